//! Lamps of a frame: what is brighter than white, and the sun beside it.

use super::Optic;
use crate::environment::Rgb;

/// Width of the cells in which lamps are gathered, px.
const CELL_PX: usize = 8;

/// Most lamps: of more, cells are gathered to larger ones.
const MOST: usize = 64;

/// What a lamp sends to the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Where its image is, px; it may lie beyond the frame.
    pub at_px: [f64; 2],
    /// Red, green and blue of all pixels of its image together.
    pub light: Rgb,
    /// Radius of a disc of its image's area, px.
    pub radius_px: f64,
}

impl Lamp {
    /// A sun in a direction of length 1, before the camera, of an irradiance: its image holds E f² of light, px² of white.
    #[must_use]
    pub fn of_sun(direction: [f64; 3], irradiance: Rgb, optic: &Optic) -> Option<Self> {
        let [x, y, z] = direction;
        if z <= 0.05 {
            return None;
        }
        let middle = optic.middle();
        #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
        let per_irradiance = (optic.f_px * optic.f_px) as f32;
        Some(Self {
            at_px: [
                middle[0] + optic.f_px * x / z,
                middle[1] + optic.f_px * y / z,
            ],
            light: irradiance.map(|color| color * per_irradiance),
            radius_px: 0.00465 * optic.f_px,
        })
    }
}

/// The lamps in a frame: where it is brighter than white, by what it is.
pub(super) fn lamps_of(
    light: &[f32],
    n_colors: usize,
    (width, height): (usize, usize),
) -> Vec<Lamp> {
    if light.iter().all(|value| *value <= 1.0) {
        return Vec::new();
    }
    let mut cell_px = CELL_PX;
    loop {
        let lamps = gathered(light, n_colors, (width, height), cell_px);
        if lamps.len() <= MOST || cell_px > width.max(height) {
            return lamps;
        }
        cell_px *= 2;
    }
}

#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "px of a frame; light is single precision"
)]
fn gathered(
    light: &[f32],
    n_colors: usize,
    (width, height): (usize, usize),
    cell_px: usize,
) -> Vec<Lamp> {
    let mut lamps = Vec::new();
    for top in (0..height).step_by(cell_px) {
        for left in (0..width).step_by(cell_px) {
            let (mut sum, mut weight, mut at, mut n) = ([0.0_f64; 3], 0.0, [0.0; 2], 0.0);
            for y in top..(top + cell_px).min(height) {
                for x in left..(left + cell_px).min(width) {
                    let pixel = &light[(y * width + x) * n_colors..][..n_colors];
                    if pixel.iter().all(|value| *value <= 1.0) {
                        continue;
                    }
                    let all = f64::from(pixel.iter().sum::<f32>());
                    weight += all;
                    n += 1.0;
                    at[0] += all * (x as f64 + 0.5);
                    at[1] += all * (y as f64 + 0.5);
                    for (k, sum) in sum.iter_mut().enumerate() {
                        *sum += f64::from(pixel[k.min(n_colors - 1)]);
                    }
                }
            }
            if weight > 0.0 {
                lamps.push(Lamp {
                    at_px: at.map(|place| place / weight),
                    light: sum.map(|color| color as f32),
                    radius_px: (n / std::f64::consts::PI).sqrt(),
                });
            }
        }
    }
    lamps
}
