//! Power over radial frequency.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::counts::Counts;
use super::frame::LumaPlane;
use super::gradient::count;

pub(super) const N_BINS: usize = 64;

/// Cycles per px.
pub(super) const BIN_WIDTH: f64 = 0.5 / 64.0;

/// Power below this part of a code² per px is rounding of an even image.
const EVEN: f64 = 1e-6;

/// The power of an image in rings of frequency, all together as much as it has pixels; nothing for
/// an even image.
pub(super) fn histogram(plane: &LumaPlane) -> Counts {
    let (width, height) = (plane.width, plane.height);
    let n_pixels = width * height;
    if n_pixels == 0 || plane.values.len() != n_pixels {
        return Counts::default();
    }
    #[expect(clippy::cast_precision_loss, reason = "a number of pixels")]
    let n = n_pixels as f64;
    let mean = plane.values.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
    let (across, down) = (hann(width), hann(height));
    let mut grid: Vec<Complex<f64>> = plane
        .values
        .chunks_exact(width)
        .zip(&down)
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
    let mut rings = vec![0.0; N_BINS];
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
        let (width, height) = (128, 96);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            reason = "a picture"
        )]
        let values = (0..width * height)
            .map(|at| {
                let x = (at % width) as f64;
                (128.0 + 50.0 * (std::f64::consts::TAU * 0.25 * x).sin()) as f32
            })
            .collect();
        let plane = LumaPlane {
            width,
            height,
            values,
        };
        let mut rings = vec![0.0; N_BINS];
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
        let plane = LumaPlane {
            width: 33,
            height: 7,
            values: vec![200.3; 33 * 7],
        };
        assert!(histogram(&plane).is_empty(), "nothing varies");
    }
}
