//! Length and direction of the gradient of luma.

use std::f64::consts::PI;

use super::frame::LumaPlane;
use super::{Counts, Feature, count};

/// `ln(1 + 127.5 √2)`: the largest that central differences of codes give.
pub(super) const LARGEST_LOG: f64 = 5.200_220_568_340_732_5;

/// `ln(1 + g)`, and the direction weighted by g, over the pixels that have four neighbors.
pub(super) fn histograms(plane: &LumaPlane) -> [Counts; 2] {
    let mut magnitudes = vec![0.0; Feature::LogGradient64.n_bins()];
    let mut orientations = vec![0.0; Feature::Orientation36.n_bins()];
    let width = usize::try_from(plane.width().max(1)).unwrap_or(1);
    let rows: Vec<&[f32]> = plane.as_raw().chunks_exact(width).collect();
    for three in rows.windows(3) {
        let &[above, row, below] = three else {
            continue;
        };
        let columns = row.windows(3).zip(above.iter().zip(below).skip(1));
        for (line, (up, down)) in columns {
            let &[left, _, right] = line else {
                continue;
            };
            let x = f64::from(right - left) / 2.0;
            let y = f64::from(down - up) / 2.0;
            let length = (x * x + y * y).sqrt();
            count(&mut magnitudes, libm::log1p(length) / LARGEST_LOG, 1.0);
            if length > 0.0 {
                let angle = libm::atan2(y, x);
                let turn = if angle < 0.0 { PI } else { 0.0 };
                // 180° is 0°.
                let share = Some((angle + turn) / PI).filter(|share| *share < 1.0);
                let share = share.unwrap_or_default();
                count(&mut orientations, share, length);
            }
        }
    }
    [Counts::of(&magnitudes), Counts::of(&orientations)]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_ramp_has_one_slope_and_one_direction() {
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        let values = (0..200).map(|at| 3.0 * (at % 20) as f32 + 4.0 * (at / 20) as f32);
        let plane = LumaPlane::from_raw(20, 10, values.collect()).unwrap();
        let [magnitude, orientation] = histograms(&plane);
        let full = |counts: &Counts| {
            let mut histogram = vec![0.0; 64];
            counts.add_to(&mut histogram, 1.0);
            histogram
        };
        // |(3, 4)| = 5: ln 6 = 1.792 of 5.200 is bin 22 of 64; atan2(4, 3) = 53.1° is bin 10.
        let magnitude = full(&magnitude);
        assert!(
            (magnitude[22] - 144.0).abs() < 1e-9,
            "18 by 8 inner pixels: {magnitude:?}"
        );
        let orientation = full(&orientation);
        assert!(
            (orientation[10] - 720.0).abs() < 1e-2,
            "144 times 5: {orientation:?}"
        );
    }

    #[test]
    fn the_steepest_edge_is_in_the_last_bin() {
        let share = libm::log1p(127.5 * std::f64::consts::SQRT_2) / LARGEST_LOG;
        assert!((share - 1.0).abs() < 1e-12, "{share}");
    }
}
