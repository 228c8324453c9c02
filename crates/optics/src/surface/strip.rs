//! Where a flat piece of surface in the sheet appears in the frame.

use super::SheetView;
use crate::vector::Vector;

/// Where one side of a straight piece of crack appears in the frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip {
    pub(super) corners: [[f64; 2]; 4],
    /// Across the upper edge, of length 1.
    pub(super) normal_px: [f64; 2],
    /// From the upper edge along that normal, from the middle of the pupil.
    pub(super) width_px: f64,
    pub(super) radius_px: f64,
}

impl Strip {
    /// The strip between an upper edge (the first two corners) and a lower one (the other two, the
    /// other way round), in the sheet's coordinates, mm.
    pub(super) fn new(sheet: &SheetView, corners: &[Vector; 4]) -> Option<Self> {
        let chief = [0.0, 0.0];
        let project = |[x, y, z]: Vector| sheet.project([x, y], z, chief);
        let mut seen = [
            project(corners[0])?,
            project(corners[1])?,
            project(corners[2])?,
            project(corners[3])?,
        ];
        // Along the longer edge: one of them may have shrunk to a point.
        let span = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
        let square = |[u, v]: [f64; 2]| u * u + v * v;
        let (upper, lower) = (span(seen[0], seen[1]), span(seen[3], seen[2]));
        let along = if square(upper) >= 0.25 * square(lower) {
            upper
        } else {
            lower
        };
        let length_px = square(along).sqrt();
        if length_px <= 1e-9 {
            return None;
        }
        let normal_px = [-along[1] / length_px, along[0] / length_px];
        let between =
            |p: Vector, q: Vector| -> Vector { std::array::from_fn(|k| 0.5 * (p[k] + q[k])) };
        let (trace, edge) = (
            between(corners[0], corners[1]),
            between(corners[2], corners[3]),
        );
        // Both from two opposite points of the pupil across the crack.
        let across = |[x, y, z]: Vector, side: f64| {
            let pupil = normal_px.map(|part| side * part * sheet.pupil_mm());
            let [u, v] = sheet.project([x, y], z, pupil)?;
            Some(u * normal_px[0] + v * normal_px[1])
        };
        let (outer_plus, outer_minus) = (across(trace, 1.0)?, across(trace, -1.0)?);
        let (inner_plus, inner_minus) = (across(edge, 1.0)?, across(edge, -1.0)?);
        let outer_radius = 0.5 * (outer_minus - outer_plus);
        let inner_radius = 0.5 * (inner_minus - inner_plus);
        let width = 0.5 * (inner_plus + inner_minus - outer_plus - outer_minus);
        let spread = inner_radius - outer_radius;
        let mean = mean_width(width, spread);
        if width.abs() < spread.abs() {
            // Parts of the pupil see the one side of the crack, others the other.
            for k in 0..2 {
                let mid = [0, 1].map(|axis| 0.5 * (seen[k][axis] + seen[3 - k][axis]));
                for (corner, side) in [(k, -0.5), (3 - k, 0.5)] {
                    seen[corner] = [
                        mid[0] + side * mean * normal_px[0],
                        mid[1] + side * mean * normal_px[1],
                    ];
                }
            }
        }
        Some(Self {
            corners: seen,
            normal_px,
            width_px: width,
            radius_px: 0.5 * (outer_radius + inner_radius),
        })
    }
}

/// Mean over a round pupil of |w + s a|, a across the pupil from −1 to 1: the width at which a
/// crack is seen whose width is `width` from the middle of the pupil and changes by `spread`
/// towards its rim.
///
/// With u = w/s: |w| (2 F(u) − 1) + s 4/(3π) (1 − u²)^{3/2}, F the share of the disc below u.
fn mean_width(width: f64, spread: f64) -> f64 {
    let (width, spread) = (width.abs(), spread.abs());
    if width >= spread {
        return width;
    }
    let u = width / spread;
    let root = (1.0 - u * u).sqrt();
    let below = 0.5 + (u * root + libm::asin(u)) / std::f64::consts::PI;
    width * (2.0 * below - 1.0) + spread * 4.0 / (3.0 * std::f64::consts::PI) * root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_width_is_the_integral_over_the_pupil() {
        for (width, spread) in [
            (0.0, 1.0),
            (0.3, 1.0),
            (-0.7, 1.0),
            (0.99, -1.0),
            (2.0, 1.0),
        ] {
            let n = 20_000;
            let (mut sum, mut weight) = (0.0, 0.0);
            for k in 0..n {
                let a = (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
                let chord = (1.0 - a * a).sqrt();
                sum += chord * (width + spread * a).abs();
                weight += chord;
            }
            let expected = sum / weight;
            let found = mean_width(width, spread);
            assert!(
                (found - expected).abs() < 1e-4,
                "{width}, {spread}: {found}, not {expected}"
            );
        }
    }
}
