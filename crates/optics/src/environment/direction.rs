//! Which way is up: directions of the world in camera coordinates.

use crate::number::Number;
use crate::vector::dot;

/// The horizon of a camera without roll, by the direction that is up.
///
/// Camera coordinates are x to the right, y down, z along the optical axis. What the camera's
/// side of a tilted camera sees of the world follows from one row: where the horizon crosses the
/// middle column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizon {
    /// The world's up, of length 1.
    pub up: [f64; 3],
}

impl Horizon {
    /// The horizon of a camera that looks straight ahead.
    #[must_use]
    pub fn level() -> Self {
        Self {
            up: [0.0, -1.0, 0.0],
        }
    }

    /// The horizon that crosses the middle column of a frame at a row, given as a fraction of the
    /// frame's height from the top; `f_px` is the focal length, px, 1 or more.
    ///
    /// With v = (row·H − H/2)/f the horizon lies along (0, v, 1) straight ahead, and up is across
    /// it: (0, −1, v)/√(1 + v²). A row above the middle is a camera that looks down.
    #[must_use]
    pub fn at_row(horizon_row: f64, height: u32, f_px: f64) -> Self {
        let v = (horizon_row - 0.5) * f64::from(height) / f_px.max(1.0);
        let length = (1.0 + v * v).sqrt();
        Self {
            up: [0.0, -1.0 / length, v / length],
        }
    }

    /// Sine of the elevation of a direction of any length above the horizon, −1 to 1; 0 of no
    /// direction.
    #[must_use]
    pub fn sin_elevation(&self, direction: [f64; 3]) -> f64 {
        if dot(direction, direction) > 0.0 {
            self.sine_of(direction)
        } else {
            0.0
        }
    }

    /// The same of a direction of some length.
    #[inline(always)]
    pub(crate) fn sine_of<N: Number>(&self, [x, y, z]: [N; 3]) -> N {
        let [right, down, ahead] = self.up;
        let length = (x * x + y * y + z * z).sqrt();
        let up = x.times(right) + y.times(down) + z.times(ahead);
        (up / length).at_least(-1.0).at_most(1.0)
    }

    /// Direction, of length 1, towards a sun at an azimuth (0 straight ahead, positive to the
    /// right) and an elevation above the horizon, rad.
    ///
    /// cos e (sin a · right + cos a · ahead) + sin e · up, with ahead the part of the optical
    /// axis along the ground.
    #[must_use]
    pub fn sun(&self, azimuth_rad: f64, elevation_rad: f64) -> [f64; 3] {
        let (sin_azimuth, cos_azimuth) = libm::sincos(azimuth_rad);
        let (sin_elevation, cos_elevation) = libm::sincos(elevation_rad);
        let ahead = [0.0, self.up[2], -self.up[1]];
        let right = [1.0, 0.0, 0.0];
        std::array::from_fn(|k| {
            cos_elevation * (sin_azimuth * right[k] + cos_azimuth * ahead[k])
                + sin_elevation * self.up[k]
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn assert_near(found: [f64; 3], expected: [f64; 3], what: &str) {
        for (found_k, expected_k) in found.into_iter().zip(expected) {
            assert!(
                (found_k - expected_k).abs() < 1e-12,
                "{what}: {found:?}, expected {expected:?}"
            );
        }
    }

    #[test]
    fn the_sun_of_a_level_camera_stands_where_it_is_said() {
        let level = Horizon::level();
        let s = 0.5_f64.sqrt();
        for (azimuth, elevation, expected) in [
            (0.0, 0.0, [0.0, 0.0, 1.0]),
            (FRAC_PI_2, 0.0, [1.0, 0.0, 0.0]),
            (-FRAC_PI_2, 0.0, [-1.0, 0.0, 0.0]),
            (PI, 0.0, [0.0, 0.0, -1.0]),
            (1.0, FRAC_PI_2, [0.0, -1.0, 0.0]),
            (0.0, -FRAC_PI_2, [0.0, 1.0, 0.0]),
            (0.0, FRAC_PI_2 / 2.0, [0.0, -s, s]),
            (FRAC_PI_2, FRAC_PI_2 / 2.0, [s, -s, 0.0]),
        ] {
            assert_near(
                level.sun(azimuth, elevation),
                expected,
                &format!("{azimuth} rad, {elevation} rad"),
            );
        }
    }

    #[test]
    fn the_middle_row_is_the_horizon_of_a_level_camera() {
        assert_near(
            Horizon::at_row(0.5, 375, 721.5).up,
            Horizon::level().up,
            "row 0.5",
        );
    }

    #[test]
    fn pixels_on_the_horizons_row_have_no_elevation_at_any_pitch() {
        let (height, f_px) = (375, 721.5);
        for row in [-1.0, 0.0, 0.2, 0.5, 0.9, 2.0] {
            let horizon = Horizon::at_row(row, height, f_px);
            let v = (row - 0.5) * f64::from(height) / f_px;
            for u in [-1.0, 0.0, 0.3] {
                let sin = horizon.sin_elevation([u, v, 1.0]);
                assert!(sin.abs() < 1e-12, "row {row}, u {u}: {sin}");
                let above = horizon.sin_elevation([u, v - 0.01, 1.0]);
                assert!(above > 0.0, "above row {row}: {above}");
            }
        }
    }

    #[test]
    fn a_camera_that_looks_down_30_degrees_has_its_axis_30_degrees_below_the_horizon() {
        // The horizon then stands tan 30° above the middle.
        let (height, f_px) = (1000, 500.0);
        let row = 0.5 - f_px * 30_f64.to_radians().tan() / f64::from(height);
        let horizon = Horizon::at_row(row, height, f_px);
        let sin = horizon.sin_elevation([0.0, 0.0, 2.0]);
        assert!((sin + 0.5).abs() < 1e-12, "sine {sin}");
    }

    #[test]
    fn the_suns_elevation_comes_back_at_any_pitch() {
        for row in [-2.0, 0.1, 0.5, 1.4] {
            let horizon = Horizon::at_row(row, 720, 900.0);
            for elevation in [-80_f64, -10.0, 0.0, 25.0, 60.0, 90.0] {
                let sun = horizon.sun(0.7, elevation.to_radians());
                let length = dot(sun, sun);
                assert!((length - 1.0).abs() < 1e-12, "length² {length}");
                let sin = horizon.sin_elevation(sun);
                let expected = elevation.to_radians().sin();
                assert!((sin - expected).abs() < 1e-12, "{elevation}° at row {row}");
            }
        }
    }

    #[test]
    fn what_is_no_direction_has_no_elevation() {
        let sin = Horizon::level().sin_elevation([0.0; 3]);
        assert!(sin.abs() < f64::EPSILON, "sine {sin}");
    }
}
