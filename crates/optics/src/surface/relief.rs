//! The surface of a crack between its edges, as its front left it.
//!
//! The tip wanders; what it leans by at a moment is what all of its front leans by then. The front is
//! a part of an ellipse, farther behind the deeper it is. So a place deep in the glass leans as the
//! face does a way further on, and lines of the same lean curve across the surface as Wallner lines
//! do.

/// Over how many thicknesses the front of a crack through the glass rises from its tip. FIT, as for
/// the depth of one that has come to rest.
pub(super) const FRONT: f64 = 1.5;

/// Depth over thickness from which a crack counts as through. FIT.
pub(super) const THROUGH: f64 = 0.9;

/// Places and weights by which the lean is taken from the face to a depth: Gauss-Legendre.
const PLACES: [[f64; 2]; 4] = [
    [0.069_431_844_202_974, 0.173_927_422_568_727],
    [0.330_009_478_207_572, 0.326_072_577_431_273],
    [0.669_990_521_792_428, 0.326_072_577_431_273],
    [0.930_568_155_797_026, 0.173_927_422_568_727],
];

/// Leans that differ by less are one.
const LEAST_CHANGE: f64 = 1e-3;

/// How the surface of a crack leans at the face that it begins at.
#[derive(Debug)]
pub(super) struct Relief {
    /// Way along the crack, mm, and tangent of the tilt there.
    at_face: Vec<[f64; 2]>,
    /// How far a front through the glass reaches behind its tip, mm; none of a shallow crack, whose
    /// front reaches back to where it began.
    reach_mm: Option<f64>,
}

impl Relief {
    /// Of a crack that is so deep half way along it. None where it leans by the same everywhere.
    pub(super) fn new(at_face: Vec<[f64; 2]>, depth: f64, thickness_mm: f64) -> Option<Self> {
        let first = at_face.first()?[1];
        let changes = at_face
            .iter()
            .any(|[_, lean]| (lean - first).abs() > LEAST_CHANGE);
        changes.then(|| Self {
            at_face,
            reach_mm: (depth >= THROUGH).then_some(FRONT * thickness_mm),
        })
    }

    /// The lean a part of the depth from a place of the face.
    pub(super) fn lean(&self, along_mm: f64, depth: f64, part: f64) -> f64 {
        let tip_mm = self.at_face.last().map_or(along_mm, |[tip, _]| *tip);
        let lag_mm = match self.reach_mm {
            Some(reach_mm) => reach_mm * behind(part * depth),
            // The last front passed the deepest places.
            None => (tip_mm - along_mm) * behind(part),
        };
        let passed_mm = along_mm + lag_mm;
        let next = self.at_face.partition_point(|[at, _]| *at <= passed_mm);
        match (next.checked_sub(1), self.at_face.get(next)) {
            (Some(last), Some([to, after])) => {
                let [from, before] = self.at_face[last];
                before + (after - before) * (passed_mm - from) / (to - from)
            }
            (Some(last), None) => self.at_face[last][1],
            (None, Some([_, first])) => *first,
            (None, None) => 0.0,
        }
    }

    /// Its mean from the face to a part of the depth.
    pub(super) fn mean_lean(&self, along_mm: f64, depth: f64, part: f64) -> f64 {
        PLACES
            .iter()
            .map(|[of, weight]| weight * self.lean(along_mm, depth, of * part))
            .fold(0.0, |sum, lean| sum + lean)
    }
}

/// How far an ellipse is behind its tip at a depth, of its half axis, over its other half axis.
fn behind(depth: f64) -> f64 {
    1.0 - (1.0 - depth * depth).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rising(depth: f64) -> Relief {
        let relief = Relief::new(vec![[0.0, 0.0], [10.0, 1.0]], depth, 2.0);
        relief.unwrap_or_else(|| unreachable!("it changes"))
    }

    #[test]
    fn a_front_through_the_glass_leaves_the_lean_of_its_tip_behind() {
        let relief = rising(1.0);
        // At the face where the tip is, at full depth 1.5 thicknesses behind.
        assert!(
            (relief.lean(4.0, 1.0, 0.0) - 0.4).abs() < 1e-12,
            "at the face"
        );
        assert!((relief.lean(4.0, 1.0, 1.0) - 0.7).abs() < 1e-12, "deepest");
        let half = 0.4 + 0.3 * (1.0 - 0.75_f64.sqrt());
        assert!(
            (relief.lean(4.0, 1.0, 0.5) - half).abs() < 1e-12,
            "half way"
        );
        // The mean of 1 − √(1 − t²) is 1 − π/4.
        let mean = 0.4 + 0.3 * (1.0 - std::f64::consts::FRAC_PI_4);
        assert!(
            (relief.mean_lean(4.0, 1.0, 1.0) - mean).abs() < 1e-3,
            "mean"
        );
        // Before the crack began and beyond its end nothing changes any more.
        assert!(relief.lean(-1.0, 1.0, 0.0).abs() <= 0.0, "before");
        assert!((relief.lean(9.0, 1.0, 1.0) - 1.0).abs() < 1e-12, "beyond");
        // Where the front came to rest its deepest place is the tip's: 0.9 mm behind it, 0.714 deep.
        let deep = (1.0_f64 - 0.7 * 0.7).sqrt();
        assert!((relief.lean(9.1, deep, 1.0) - 1.0).abs() < 1e-12, "at rest");
    }

    #[test]
    fn the_deepest_places_of_a_shallow_crack_are_those_of_its_last_front() {
        let relief = rising(0.5);
        for along_mm in [0.0, 3.0, 9.0] {
            let deepest = relief.lean(along_mm, 0.5, 1.0);
            assert!((deepest - 1.0).abs() < 1e-12, "{along_mm} mm: {deepest}");
            let face = relief.lean(along_mm, 0.5, 0.0);
            assert!(
                (face - 0.1 * along_mm).abs() < 1e-12,
                "{along_mm} mm: {face}"
            );
        }
    }

    #[test]
    fn what_leans_by_the_same_everywhere_is_flat() {
        assert!(Relief::new(vec![[0.0, 0.1], [5.0, 0.1]], 1.0, 2.0).is_none());
        assert!(Relief::new(Vec::new(), 1.0, 2.0).is_none());
    }
}
