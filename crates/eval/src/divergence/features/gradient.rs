//! Length and direction of the gradient of luma.

use super::counts::Counts;
use super::frame::LumaPlane;

pub(super) const N_MAGNITUDE_BINS: usize = 64;
pub(super) const N_ORIENTATION_BINS: usize = 36;

/// `ln(1 + 127.5 √2)`: the largest that central differences of codes give.
const LARGEST_LOG: f64 = 5.200_220_568_340_732_5;

/// Width of a bin of `ln(1 + g)`.
pub(super) fn magnitude_bin_width() -> f64 {
    LARGEST_LOG / 64.0
}

/// `ln(1 + g)`, and the direction weighted by g, over the pixels that have four neighbors.
pub(super) fn histograms(plane: &LumaPlane) -> [Counts; 2] {
    let mut magnitudes = vec![0.0; N_MAGNITUDE_BINS];
    let mut orientations = vec![0.0; N_ORIENTATION_BINS];
    let rows: Vec<&[f32]> = plane.values.chunks_exact(plane.width.max(1)).collect();
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
            let share = libm::log1p(length) / LARGEST_LOG;
            count(&mut magnitudes, share, 1.0);
            if length > 0.0 {
                let angle = libm::atan2(y, x);
                let angle = if angle < 0.0 {
                    angle + std::f64::consts::PI
                } else {
                    angle
                };
                // 180° is 0°.
                let share = angle / std::f64::consts::PI;
                count(
                    &mut orientations,
                    if share >= 1.0 { 0.0 } else { share },
                    length,
                );
            }
        }
    }
    [Counts::of(&magnitudes), Counts::of(&orientations)]
}

/// Counts in the bin of a share of the axis, 0 to 1; the end belongs to the last bin.
pub(super) fn count(histogram: &mut [f64], share: f64, weight: f64) {
    let n = histogram.len();
    #[expect(clippy::cast_precision_loss, reason = "a number of bins")]
    let at = (share.clamp(0.0, 1.0) * n as f64).floor();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the number of bins"
    )]
    let bin = (at as usize).min(n.saturating_sub(1));
    if let Some(slot) = histogram.get_mut(bin) {
        *slot += weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(counts: &Counts, n: usize) -> Vec<f64> {
        let mut histogram = vec![0.0; n];
        counts.add_to(&mut histogram, 1.0);
        histogram
    }

    #[test]
    fn a_ramp_has_one_slope_and_one_direction() {
        let (width, height) = (20, 10);
        let values = (0..width * height)
            .map(|at| {
                #[expect(clippy::cast_precision_loss, reason = "small numbers")]
                let (x, y) = ((at % width) as f32, (at / width) as f32);
                3.0 * x + 4.0 * y
            })
            .collect();
        let plane = LumaPlane {
            width,
            height,
            values,
        };
        let [magnitude, orientation] = histograms(&plane);
        // |(3, 4)| = 5: ln 6 = 1.792 of 5.200 is bin 22 of 64; atan2(4, 3) = 53.1° is bin 10.
        let magnitude = full(&magnitude, 64);
        assert!(
            (magnitude[22] - 144.0).abs() < 1e-9,
            "18 by 8 inner pixels: {magnitude:?}"
        );
        let orientation = full(&orientation, 36);
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
