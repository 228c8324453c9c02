//! Color of the sun by its elevation.

use super::{Rgb, luminance};

/// Wavelengths that stand for red, green and blue, µm. FIT.
const WAVELENGTHS_UM: [f64; 3] = [0.61, 0.55, 0.465];

/// Color of sunlight at an elevation above the horizon, of luminance 1; that of 0 below it.
///
/// White of the image is daylight as a whole. Of it the air scatters away exp(−0.008735 λ^−4.08 m)
/// [Preetham1999], blue before red, with the air mass
/// m = 1/(sin e + 0.50572 (e + 6.07995°)^−1.6364) [KastenYoung1989]. Clean, dry air: haze and
/// ozone are left out.
pub(super) fn sun_color(elevation_rad: f64) -> Rgb {
    let elevation_rad = elevation_rad.clamp(0.0, std::f64::consts::FRAC_PI_2);
    let degrees = elevation_rad.to_degrees();
    let air_mass =
        1.0 / (libm::sin(elevation_rad) + 0.505_72 * libm::pow(degrees + 6.079_95, -1.6364));
    #[expect(
        clippy::cast_possible_truncation,
        reason = "light is kept in single precision"
    )]
    let color =
        WAVELENGTHS_UM.map(|um| libm::exp(-0.008_735 * libm::pow(um, -4.08) * air_mass) as f32);
    let whole = luminance(color);
    color.map(|channel| channel / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_high_sun_is_nearly_white_and_a_low_one_red() {
        let [red, green, blue] = sun_color(90_f64.to_radians());
        assert!((0.97..1.06).contains(&red), "red {red}");
        assert!((0.97..1.03).contains(&green), "green {green}");
        assert!((0.85..1.0).contains(&blue), "blue {blue}");
        let [red, green, blue] = sun_color(0.0);
        assert!(
            red > 2.0 && green < 1.0 && blue < 0.1,
            "{red} {green} {blue}"
        );
    }

    #[test]
    fn the_color_warms_as_the_sun_sinks_and_keeps_its_luminance() {
        let mut last = f32::INFINITY;
        for degrees in (-5..=90).rev() {
            let color = sun_color(f64::from(degrees).to_radians());
            assert!((luminance(color) - 1.0).abs() < 1e-6, "at {degrees}°");
            let blue_over_red = color[2] / color[0];
            assert!(blue_over_red <= last, "at {degrees}°");
            last = blue_over_red;
        }
    }

    #[test]
    fn the_air_mass_is_that_of_the_published_table() {
        // Kasten and Young give 37.92 at the horizon and 2.0 near 30°; green falls by
        // exp(−0.1001 m) with τ(550 nm) = 0.1001.
        let ratio = |degrees: f64| {
            let [red, _, blue] = sun_color(degrees.to_radians()).map(f64::from);
            (red / blue).ln()
        };
        // ln(red/blue) is the air mass times the difference of the optical depths.
        let per_mass = ratio(90.0);
        assert!((per_mass - 0.133).abs() < 0.002, "{per_mass}");
        let horizon = ratio(0.0) / per_mass;
        assert!((horizon - 37.92).abs() < 0.1, "air mass {horizon}");
        let low = ratio(30.0) / per_mass;
        assert!((low - 1.994).abs() < 0.01, "air mass {low}");
    }
}
