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
    let (across, down) = (hann(width), hann(height));
    let rows = plane.as_raw().chunks_exact(width).zip(&down);
    let mut grid: Vec<Complex<f64>> = rows
        .flat_map(|(row, weight_y)| row.iter().zip(&across).map(move |(v, w)| (v, w * weight_y)))
        .map(|(value, weight)| Complex::new((f64::from(*value) - mean) * weight, 0.0))
        .collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(width).process(&mut grid);
    // Transposed, so that the columns lie in a row.
    let mut turned: Vec<Complex<f64>> = (0..width)
        .flat_map(|x| grid.iter().skip(x).step_by(width).copied())
        .collect();
    planner.plan_fft_forward(height).process(&mut turned);
    let (fx, fy) = (frequencies(width), frequencies(height));
    let mut rings = vec![0.0; Feature::Spectrum64.n_bins()];
    let mut total = 0.0;
    let places = fx.iter().flat_map(|x| fy.iter().map(move |y| (x, y)));
    for ((x, y), value) in places.zip(&turned) {
        let frequency = (x * x + y * y).sqrt();
        if frequency > 0.0 && frequency <= 0.5 {
            let power = value.norm_sqr();
            total += power;
            count(&mut rings, frequency / 0.5, power);
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

    #[test]
    fn an_even_image_has_no_power() {
        let plane = LumaPlane::from_pixel(33, 7, image::Luma([200.3]));
        assert_eq!(histogram(&plane), Counts::default(), "nothing varies");
    }
}
