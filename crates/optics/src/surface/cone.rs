//! The wall of a cone between the face and its trace.

use super::chains::{Chain, End};
use crate::vector::Vector;

/// A cone begins on the face at this part of its lower radius at least.
const LEAST_CONE: f64 = 0.15;

/// Parts of the depth between which the wall of a cone that is through counts as straight.
const BANDS: [f64; 5] = [0.0, 0.5, 0.75, 0.9, 1.0];

impl Chain {
    /// Bands of the depth, as parts of it from the face it begins at, in which its wall is straight.
    pub(super) fn bands(&self) -> impl Iterator<Item = [f64; 2]> {
        let limits: &[f64] = if self.is_flared { &BANDS } else { &[0.0, 1.0] };
        limits.windows(2).map(|pair| [pair[0], pair[1]])
    }

    /// A place of a cone about a middle, a part of the depth from the face: its trace is its lower edge, and it comes from
    /// a smaller circle on the face.
    ///
    /// Where it is through, the tangent of its lean falls as 1 − t² with the part t of the depth. FIT: bending opens
    /// cracks upright at the far face, and photographs of bullseyes show a dark crescent along the outer edge that fades
    /// inwards.
    pub(super) fn on_cone(&self, middle: [f64; 2], end: &End, part: f64) -> Vector {
        let deep = self.thickness_mm() * end.depth;
        let from_middle = [0, 1].map(|k| end.at[k] - middle[k]);
        let radius = (from_middle[0] * from_middle[0] + from_middle[1] * from_middle[1]).sqrt();
        let least = (1.0 - deep * end.lean.abs() / radius.max(1e-9)).max(LEAST_CONE);
        let out = match self.is_flared {
            true => part * (3.0 - part * part) / 2.0,
            false => part,
        };
        let by = least + (1.0 - least) * out;
        let [x, y] = [0, 1].map(|k| middle[k] + by * from_middle[k]);
        [x, y, self.ply_mm[1] - part * deep]
    }
}

#[cfg(test)]
mod tests {
    use starbreak_glass::Face;

    use super::super::chains::Piece;
    use super::super::relief::THROUGH;
    use super::*;

    fn cone(depth: f64) -> Chain {
        let end = |x: f64| End {
            at: [x, 0.0],
            left: [0.0, -1.0],
            depth,
            lean: 2.5,
            along_mm: 0.0,
        };
        let piece = Piece {
            ends: [end(6.0), end(6.0)],
            alpha: 0.0,
            gap_um: 1.0,
        };
        Chain {
            pieces: vec![piece],
            ply_mm: [3.0, 5.0],
            face: Face::Outer,
            cone_about: Some([0.0; 2]),
            is_flared: depth >= THROUGH,
            has_front: true,
            relief: None,
        }
    }

    #[test]
    fn a_cone_through_the_ply_begins_flat_and_shut_and_ends_upright_and_open() {
        let cone = cone(1.0);
        let end = cone.pieces[0].ends[0];
        let at = |part: f64| cone.place(&end, part);
        let is_at = |part: f64, [x, z]: [f64; 2]| {
            let [there, _, depth] = at(part);
            (there - x).abs() < 1e-12 && (depth - z).abs() < 1e-12
        };
        assert!(is_at(1.0, [6.0, 3.0]), "its trace on the far face");
        assert!(is_at(0.0, [1.0, 5.0]), "its contact: 2.5 x 2 mm further in");
        let lean = |part: f64| {
            let ([out, _, high], [more, _, low]) = (at(part - 1e-6), at(part + 1e-6));
            (more - out) / (high - low)
        };
        for part in [0.001, 0.3, 0.6, 0.999] {
            let law = 2.5 * 1.5 * (1.0 - part * part);
            assert!(
                (lean(part) - law).abs() < 1e-4,
                "at {part}: {} not {law}",
                lean(part)
            );
        }
        for (part, opens) in [(0.0, 0.0), (0.5, 0.25), (1.0, 1.0)] {
            let got = cone.closes(part);
            assert!((got - opens).abs() < 1e-12, "at {part}: open by {got}");
        }
        let bands: Vec<[f64; 2]> = cone.bands().collect();
        assert!(
            bands.len() > 2 && bands.windows(2).all(|pair| pair[0][1] <= pair[1][0]),
            "{bands:?}"
        );
    }

    #[test]
    fn a_cone_that_ends_in_the_glass_is_straight() {
        let cone = cone(0.5);
        let end = cone.pieces[0].ends[0];
        let [x, _, z] = cone.place(&end, 0.5);
        assert!(
            (x - 4.75).abs() < 1e-12 && (z - 4.5).abs() < 1e-12,
            "{x}, {z}"
        );
        assert_eq!(cone.bands().count(), 1);
    }
}
