//! The light around the camera, estimated from one image and from where the sun stands.
//!
//! Directions are in camera coordinates: x to the right, y down, z along the optical axis. All
//! light is linear, in units of the image: 1 is what white shows.

mod dashboard;
mod direction;
mod estimate;
mod hemisphere;
mod samples;
mod sun;

pub use dashboard::Dashboard;
pub use direction::Horizon;
pub(crate) use estimate::smooth_step;
pub use hemisphere::HemisphereWeights;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::OpticsError;

/// What is next to a picture looks like its border: walls and trees go on for some 25°. FIT.
const FADES_OVER: f64 = 0.5;

/// Light of one color, linear, in units of the image's white.
pub type Rgb = [f32; 3];

/// What is said of the environment; what is not said is estimated from the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentParams {
    /// Azimuth of the sun, rad, from the optical axis towards the right.
    pub sun_azimuth_rad: f64,
    /// How fast that grows, rad/s: a camera that turns to the left has the sun turn to the right.
    pub sun_turns_rad_s: f64,
    /// Elevation of the sun above the horizon, rad.
    pub sun_elevation_rad: f64,
    /// Irradiance of the sun on a plane that faces it, in units of the image: π is what makes a
    /// white sheet show 1.
    pub sun_irradiance: Option<f64>,
    /// Radiance of the sky at the horizon.
    pub horizon_rgb: Option<Rgb>,
    /// Radiance of the sky at the zenith.
    pub zenith_rgb: Option<Rgb>,
    /// Radiance of the ground.
    pub ground_rgb: Option<Rgb>,
    /// Radiance of what is on the camera's side of the glass, as seen straight down and straight
    /// up.
    pub cabin_rgb: Option<[Rgb; 2]>,
    /// Row of the horizon over the height of the frame, from the top.
    pub horizon_row: f64,
    /// What the frame shows of the camera's own side before the glass.
    pub dashboard: Dashboard,
}

impl Default for EnvironmentParams {
    /// Sun 35° to the right and 45° high; all else from the image, by a level camera.
    fn default() -> Self {
        Self {
            sun_azimuth_rad: 35_f64.to_radians(),
            sun_turns_rad_s: 0.0,
            sun_elevation_rad: 45_f64.to_radians(),
            sun_irradiance: None,
            horizon_rgb: None,
            zenith_rgb: None,
            ground_rgb: None,
            cabin_rgb: None,
            horizon_row: 0.5,
            dashboard: Dashboard::default(),
        }
    }
}

impl EnvironmentParams {
    /// The same so many seconds later, when the sun has turned.
    #[must_use]
    pub fn later(mut self, by_s: f64) -> Self {
        let turned_rad = self.sun_turns_rad_s * by_s;
        if turned_rad != 0.0 {
            self.sun_azimuth_rad = (self.sun_azimuth_rad + turned_rad + PI).rem_euclid(TAU) - PI;
        }
        self
    }

    /// The horizon before a camera of a focal length, px, in a frame of a height, px.
    #[must_use]
    pub fn horizon(&self, height: u32, f_px: f64) -> Horizon {
        Horizon::at_row(self.horizon_row, height, f_px)
    }

    /// Way beyond the border of the frame, of the focal length, on which what the border shows fades into the environment:
    /// none where sky and ground are given, for they are what is there.
    pub(crate) fn fades_over(&self) -> f64 {
        match (self.horizon_rgb, self.zenith_rgb, self.ground_rgb) {
            (Some(_), Some(_), Some(_)) => 0.0,
            _ => FADES_OVER,
        }
    }

    /// Direction, of length 1, towards the sun over a horizon.
    #[must_use]
    pub fn sun(&self, horizon: &Horizon) -> [f64; 3] {
        horizon.sun(self.sun_azimuth_rad, self.sun_elevation_rad)
    }

    /// Every parameter is in its range: angles, and linear light from 0 to a million.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub(crate) fn check(&self) -> Result<(), OpticsError> {
        let irradiance = self.sun_irradiance.unwrap_or(0.0);
        OpticsError::check_ranges(&[
            (
                "sun_azimuth_rad",
                self.sun_azimuth_rad,
                -10.0 * TAU,
                10.0 * TAU,
            ),
            ("sun_turns_rad_s", self.sun_turns_rad_s, -TAU, TAU),
            (
                "sun_elevation_rad",
                self.sun_elevation_rad,
                -FRAC_PI_2,
                FRAC_PI_2,
            ),
            ("sun_irradiance", irradiance, 0.0, 1e6),
            ("horizon_row", self.horizon_row, -100.0, 100.0),
        ])?;
        let cabin = self.cabin_rgb.map_or([None; 2], |ends| ends.map(Some));
        for (name, rgb) in [
            ("horizon_rgb", self.horizon_rgb),
            ("zenith_rgb", self.zenith_rgb),
            ("ground_rgb", self.ground_rgb),
            ("cabin_rgb", cabin[0]),
            ("cabin_rgb", cabin[1]),
        ] {
            let rgb = rgb.unwrap_or_default();
            OpticsError::check_ranges(&rgb.map(|channel| (name, f64::from(channel), 0.0, 1e6)))?;
        }
        Ok(())
    }
}

/// The light around the camera.
///
/// The sky's radiance runs from the horizon's to the zenith's with the sine of the elevation, that
/// of the camera's side from straight down to straight up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Environment {
    /// Radiance of the sky at the horizon.
    pub horizon_rgb: Rgb,
    /// Radiance of the sky at the zenith.
    pub zenith_rgb: Rgb,
    /// Radiance of the ground.
    pub ground_rgb: Rgb,
    /// Radiance of what is on the camera's side of the glass, straight down.
    pub cabin_low_rgb: Rgb,
    /// The same, straight up.
    pub cabin_high_rgb: Rgb,
    /// Irradiance of the sun on a plane that faces it.
    pub sun_rgb: Rgb,
}

impl Environment {
    /// The light of a day, for tests.
    #[cfg(test)]
    pub(crate) const DAY: Self = Self {
        horizon_rgb: [0.5; 3],
        zenith_rgb: [0.4; 3],
        ground_rgb: [0.1; 3],
        cabin_low_rgb: [0.01; 3],
        cabin_high_rgb: [0.02; 3],
        sun_rgb: [1.0; 3],
    };

    /// Radiance from a direction by the sine of its elevation: above the horizon
    /// H + (Z − H) sin e of horizon and zenith, below it the ground's. The sun is not in it.
    #[must_use]
    pub fn radiance(&self, sin_elevation: f64) -> Rgb {
        if sin_elevation < 0.0 {
            return self.ground_rgb;
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "light is kept in single precision"
        )]
        let sin = sin_elevation.min(1.0) as f32;
        std::array::from_fn(|k| {
            self.horizon_rgb[k] + (self.zenith_rgb[k] - self.horizon_rgb[k]) * sin
        })
    }
}

/// Luminance of linear light by the primaries of sRGB \[IEC1999\].
pub(crate) fn luminance([red, green, blue]: Rgb) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Red, green and blue as the colors of an image, 1 or 3: gray is its luminance.
pub(crate) fn of_colors<const COLORS: usize>(rgb: Rgb) -> [f32; COLORS] {
    if COLORS == 1 {
        [luminance(rgb); COLORS]
    } else {
        std::array::from_fn(|k| rgb[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radiance_runs_from_the_horizons_to_the_zeniths_and_is_the_grounds_below() {
        let environment = Environment {
            horizon_rgb: [0.3, 0.6, 0.9],
            zenith_rgb: [0.1, 0.2, 1.1],
            ground_rgb: [0.05, 0.06, 0.07],
            cabin_low_rgb: [0.0; 3],
            cabin_high_rgb: [0.0; 3],
            sun_rgb: [9.0; 3],
        };
        for (sin, expected) in [
            (-1.0, [0.05, 0.06, 0.07]),
            (-1e-9, [0.05, 0.06, 0.07]),
            (0.0, [0.3, 0.6, 0.9]),
            (0.5, [0.2, 0.4, 1.0]),
            (1.0, [0.1, 0.2, 1.1]),
            (1.5, [0.1, 0.2, 1.1]),
        ] {
            for (found, expected) in environment.radiance(sin).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{found} at sine {sin}");
            }
        }
    }

    #[test]
    fn white_has_luminance_1() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6, "white");
    }
}
