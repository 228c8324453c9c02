//! Power over radial frequency.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::frame::LumaPlane;
use super::{Counts, Feature, count};

/// Power below this part of a code² per px is rounding of an even image.
const EVEN: f64 = 1e-6;

/// The power of an image in rings of frequency, all together as much as it has pixels; nothing for
/// an even image.
pub(super) fn histogram(plane: &LumaPlane) -> Counts {
    let side = |n: u32| usize::try_from(n).unwrap_or_default();
    let (width, height) = (side(plane.width()), side(plane.height()));
    if width * height == 0 {
        return Counts::default();
    }
    #[expect(clippy::cast_precision_loss, reason = "a number of pixels")]
    let n = (width * height) as f64;
    let mean = plane.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
    let mut columns = columns_of_rows(plane.as_raw(), [width, height], mean);
    FftPlanner::new()
        .plan_fft_forward(height)
        .process(&mut columns);
    let (fx, fy) = (frequencies(width), frequencies(height));
    let mut rings = vec![0.0; Feature::Spectrum64.n_bins()];
    let mut total = 0.0;
    for ((place, x), column) in fx.iter().enumerate().zip(columns.chunks_exact(height)) {
        // Of a column whose mirror image is left out both count.
        let times = if place == 0 || 2 * place == width {
            1.0
        } else {
            2.0
        };
        for (y, value) in fy.iter().zip(column) {
            let frequency = (x * x + y * y).sqrt();
            if frequency > 0.0 && frequency <= 0.5 {
                let power = value.norm_sqr() * times;
                total += power;
                count(&mut rings, frequency / 0.5, power);
            }
        }
    }
    if total <= EVEN * n * n {
        return Counts::default();
    }
    for ring in &mut rings {
        *ring *= n / total;
    }
    Counts::of(&rings)
}

/// The rows without the mean and under the window, transformed: for each frequency from 0 to the middle its column, one
/// after the other. Those beyond are mirror images, since the rows are real; for the same reason two rows are transformed
/// at once, as `a + i b`, which gives `A = (Z(k) + Z*(−k)) / 2` and `B = (Z(k) − Z*(−k)) / 2i`.
fn columns_of_rows(values: &[f32], [width, height]: [usize; 2], mean: f64) -> Vec<Complex<f64>> {
    let (across, down) = (hann(width), hann(height));
    let windowed = |(row, weight_y): (&[f32], &f64)| -> Vec<f64> {
        let row = row.iter().zip(&across);
        row.map(|(value, weight)| (f64::from(*value) - mean) * (weight * weight_y))
            .collect()
    };
    let rows = values.chunks_exact(width).zip(&down);
    let rows: Vec<Vec<f64>> = rows.map(windowed).collect();
    let transform = FftPlanner::new().plan_fft_forward(width);
    let mut scratch = vec![Complex::default(); transform.get_inplace_scratch_len()];
    let mut both = vec![Complex::default(); width];
    let mut columns = vec![Complex::default(); (width / 2 + 1) * height];
    for (pair, rows) in rows.chunks(2).enumerate() {
        for (x, into) in both.iter_mut().enumerate() {
            let value = |row: usize| rows.get(row).and_then(|row| row.get(x));
            let [a, b] = [value(0), value(1)].map(|value| value.copied().unwrap_or_default());
            *into = Complex::new(a, b);
        }
        transform.process_with_scratch(&mut both, &mut scratch);
        for (k, column) in columns.chunks_exact_mut(height).enumerate() {
            let (here, mirrored) = (both[k], both[(width - k) % width].conj());
            let [sum, gap] = [here + mirrored, here - mirrored].map(|twice| twice / 2.0);
            let halves = [sum, Complex::new(gap.im, -gap.re)];
            for (into, value) in column.iter_mut().skip(2 * pair).zip(halves) {
                *into = value;
            }
        }
    }
    columns
}

/// `sin²(π (j + ½) / n)`.
fn hann(n: usize) -> Vec<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a place among pixels")]
    let at = |j: usize| libm::sin(std::f64::consts::PI * (j as f64 + 0.5) / n as f64).powi(2);
    (0..n).map(at).collect()
}

/// Frequency of each coefficient, cycles per px, without its sign.
fn frequencies(n: usize) -> Vec<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a place among pixels")]
    let at = |j: usize| j.min(n - j) as f64 / n as f64;
    (0..n).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_has_its_power_at_its_frequency() {
        let plane = LumaPlane::from_fn(128, 96, |x, _| {
            let phase = std::f64::consts::TAU * 0.25 * f64::from(x);
            #[expect(clippy::cast_possible_truncation, reason = "a picture")]
            let value = (128.0 + 50.0 * phase.sin()) as f32;
            image::Luma([value])
        });
        let mut rings = vec![0.0; 64];
        histogram(&plane).add_to(&mut rings, 1.0);
        let total: f64 = rings.iter().sum();
        assert!(
            (total - 12_288.0).abs() < 1e-6,
            "as much as pixels: {total}"
        );
        // 0.25 is the edge of bins 31 and 32; the window spreads it by one coefficient.
        let near: f64 = rings[31..34].iter().sum();
        assert!(near > 0.999 * total, "{near} of {total}");
    }

    /// By the sum that defines the transform, for odd and even sides, of noise.
    #[test]
    fn the_power_of_noise_is_that_of_the_plain_sum() {
        let sides = [
            [5, 4],
            [4, 5],
            [9, 9],
            [8, 6],
            [7, 1],
            [1, 7],
            [2, 3],
            [3, 2],
        ];
        for [width, height] in sides {
            let mut state = 10 * width + height;
            let plane = LumaPlane::from_fn(width, height, |_, _| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                image::Luma([f32::from(state.to_le_bytes()[3])])
            });
            let n = f64::from(width * height);
            let mean = plane.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
            let window = |at: u32, n: u32| {
                let phase = std::f64::consts::PI * (f64::from(at) + 0.5) / f64::from(n);
                phase.sin().powi(2)
            };
            let side = |k: u32, n: u32| f64::from(k.min(n - k)) / f64::from(n);
            let (mut expected, mut total) = (vec![0.0; 64], 0.0);
            for (u, v) in (0..height).flat_map(|v| (0..width).map(move |u| (u, v))) {
                let mut sum = Complex::new(0.0, 0.0);
                for (x, y, pixel) in plane.enumerate_pixels() {
                    let turns =
                        f64::from(u * x) / f64::from(width) + f64::from(v * y) / f64::from(height);
                    let weight = window(x, width) * window(y, height);
                    let value = (f64::from(pixel.0[0]) - mean) * weight;
                    sum += Complex::from_polar(value, -std::f64::consts::TAU * turns);
                }
                let frequency = side(u, width).hypot(side(v, height));
                if frequency > 0.0 && frequency <= 0.5 {
                    total += sum.norm_sqr();
                    count(&mut expected, frequency / 0.5, sum.norm_sqr());
                }
            }
            let mut rings = vec![0.0; 64];
            histogram(&plane).add_to(&mut rings, 1.0);
            for (ring, (got, power)) in rings.iter().zip(&expected).enumerate() {
                let error = (got - power * n / total).abs();
                assert!(
                    error < 1e-9,
                    "{width} x {height}, ring {ring}: off by {error:e}"
                );
            }
        }
    }

    #[test]
    fn an_even_image_has_no_power() {
        let plane = LumaPlane::from_pixel(33, 7, image::Luma([200.3]));
        assert_eq!(histogram(&plane), Counts::default(), "nothing varies");
    }
}
