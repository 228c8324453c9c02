//! A sensor that is not where the lens makes its picture.

use super::Optic;
use crate::maps::Pupil;
use crate::physical::spread_evenly;

/// A sensor out of the focal plane: each point becomes an image of the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defocus {
    /// Way of the sensor from where the picture is sharp, m; positive away from the lens.
    pub sensor_shift_m: f64,
}

/// Square of the least radius of which pixels show a disc, px².
const LEAST_SQUARE: f64 = 1.44;

impl Defocus {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        // Not −0 either.
        self.sensor_shift_m.abs() <= 0.0
    }

    /// Diameter of the disc that a point becomes, px: c = Δ/(N p), with the pitch p = f/f_px of the pixels. It is
    /// positive where the sensor is behind the picture, as for what is nearer than the focus.
    #[must_use]
    pub fn disc_px(&self, optic: &Optic) -> f64 {
        self.sensor_shift_m * optic.f_px / (optic.lens.f_number * optic.lens.focal_length_m)
    }

    pub(super) fn over(&self, light: &mut Vec<f32>, n_colors: usize, optic: &Optic) {
        let radius_px = 0.5 * self.disc_px(optic);
        let square = radius_px * radius_px;
        // What a disc gives to the pixels around it is spread within them, too: the variance of a pixel per axis, 1/12,
        // is taken off that of the disc, R²/4.
        let radius_px = (square.max(LEAST_SQUARE) - 1.0 / 3.0)
            .sqrt()
            .copysign(radius_px);
        let pupil = Pupil::of(&optic.lens);
        let blurred = spread_evenly(light, n_colors, optic.size, pupil, radius_px);
        if square >= LEAST_SQUARE {
            *light = blurred;
            return;
        }
        // Of a smaller disc as much of the least one as has its variance.
        #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
        let share = (square / LEAST_SQUARE) as f32;
        for (value, blurred) in light.iter_mut().zip(blurred) {
            *value += share * (blurred - *value);
        }
    }
}
