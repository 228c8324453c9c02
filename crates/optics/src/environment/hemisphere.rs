//! What a plane sees of sky and ground.

use super::{Environment, Rgb};

/// Shares of the light of horizon, zenith and ground in what falls on a plane.
///
/// For the sky of [`Environment`], whose radiance is H + (Z − H) sin e, over a ground of radiance
/// G, the irradiance of a plane is π (h H + z Z + g G). With θ the angle between its outward
/// normal and up:
///
/// - g = (1 − cos θ)/2, the half space below the horizon;
/// - z = (2/3π)(sin θ + (π − θ) cos θ), the integral of the product of two clamped cosines
///   \[ChoSaul2009\];
/// - h = (1 + cos θ)/2 − z, the rest of the sky.
///
/// They sum to 1. A plane that faces up has h = 1/3 and z = 2/3, and hence 7π/9 Z from the
/// overcast sky \[MoonSpencer1942\]. Nothing shades the plane, and the sun is not in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HemisphereWeights {
    /// Share of the horizon's radiance.
    pub horizon: f64,
    /// Share of the zenith's radiance.
    pub zenith: f64,
    /// Share of the ground's radiance.
    pub ground: f64,
}

impl HemisphereWeights {
    /// Shares of a plane by the cosine between its outward normal and up, the `sin_elevation` of
    /// the normal.
    #[must_use]
    pub fn facing(cos_to_up: f64) -> Self {
        let cos = cos_to_up.clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let beyond = std::f64::consts::PI - libm::acos(cos);
        let zenith = (sin + beyond * cos).max(0.0) / (1.5 * std::f64::consts::PI);
        Self {
            horizon: (0.5 * (1.0 + cos) - zenith).max(0.0),
            zenith,
            ground: 0.5 * (1.0 - cos),
        }
    }

    /// Irradiance over π: the radiance of a white diffuse plane without the sun.
    #[must_use]
    pub fn mean_radiance(&self, environment: &Environment) -> Rgb {
        std::array::from_fn(|k| {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "light is kept in single precision"
            )]
            let mean = (self.horizon * f64::from(environment.horizon_rgb[k])
                + self.zenith * f64::from(environment.zenith_rgb[k])
                + self.ground * f64::from(environment.ground_rgb[k])) as f32;
            mean
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares by a sum over directions, midpoint rule over sine of elevation and azimuth.
    fn by_quadrature(cos_to_up: f64) -> [f64; 3] {
        const N: u32 = 600;
        let sin_to_up = (1.0 - cos_to_up * cos_to_up).sqrt();
        let mut shares = [0.0; 3];
        for i in 0..N {
            let s = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(N);
            let level = (1.0 - s * s).sqrt();
            for j in 0..N {
                let azimuth = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(N);
                let cos = (cos_to_up * s + sin_to_up * level * azimuth.cos()).max(0.0);
                // dω/π of one cell.
                let light = cos * 4.0 / f64::from(N * N);
                if s > 0.0 {
                    shares[0] += (1.0 - s) * light;
                    shares[1] += s * light;
                } else {
                    shares[2] += light;
                }
            }
        }
        shares
    }

    #[test]
    fn the_shares_are_those_of_a_sum_over_directions() {
        for degrees in (0..=180).step_by(15) {
            let cos = f64::from(degrees).to_radians().cos();
            let found = HemisphereWeights::facing(cos);
            let expected = by_quadrature(cos);
            for (found, expected) in [found.horizon, found.zenith, found.ground]
                .into_iter()
                .zip(expected)
            {
                assert!(
                    (found - expected).abs() < 2e-5,
                    "at {degrees}°: {found}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn the_shares_sum_to_1() {
        for step in -1000..=1000 {
            let weights = HemisphereWeights::facing(f64::from(step) / 1000.0);
            let sum = weights.horizon + weights.zenith + weights.ground;
            assert!((sum - 1.0).abs() < 1e-12, "{weights:?} sums to {sum}");
            assert!(
                weights.horizon >= 0.0 && weights.zenith >= 0.0 && weights.ground >= 0.0,
                "{weights:?}"
            );
        }
    }

    #[test]
    fn a_level_plane_has_the_closed_form_of_moon_and_spencer() {
        let up = HemisphereWeights::facing(1.0);
        let overcast = up.horizon / 3.0 + up.zenith;
        assert!((overcast - 7.0 / 9.0).abs() < 1e-12, "{overcast}");
        let down = HemisphereWeights::facing(-1.0);
        assert!((down.ground - 1.0).abs() < 1e-12, "{down:?}");
    }

    #[test]
    fn light_that_is_the_same_everywhere_is_seen_by_every_plane() {
        let color = [0.2, 0.3, 0.4];
        let environment = Environment {
            horizon_rgb: color,
            zenith_rgb: color,
            ground_rgb: color,
            cabin_low_rgb: color,
            cabin_high_rgb: color,
            sun_rgb: [0.0; 3],
        };
        for cos in [-1.0, -0.4, 0.0, 0.7, 1.0] {
            let mean = HemisphereWeights::facing(cos).mean_radiance(&environment);
            for (mean, color) in mean.into_iter().zip(color) {
                assert!((mean - color).abs() < 1e-6, "{mean} at {cos}");
            }
        }
    }
}
