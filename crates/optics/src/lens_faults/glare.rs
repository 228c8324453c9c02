//! Light that the lens scatters over the frame.

use std::f64::consts::PI;

use super::Optic;
use super::ghosts::FARTHEST;
use super::lamps::Lamp;
use crate::environment::{of_colors, smooth_step};
use crate::pyramid::{Cells, Pyramid, vectorized};

/// Veiling glare: a share of all light is spread over the frame, around what is bright and far from it.
///
/// (1 − s) I + s Σ w G_σ ∗ I. The shape is that of a scatter that falls with the square of the angle, which has as much
/// light in each of four rings whose radii grow by a factor of three: w = ¼ of Gaussians of 0.011, 0.033, 0.1 and 0.3
/// rad. s is such that a small black patch reads what [`Glare::veil`] says.
///
/// The sun, which no image holds, is scattered as any other light: of an irradiance E it adds
/// s E/(4 · 2πσ²) exp(−θ²/2σ²) of each Gaussian, as far as no hood shades the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glare {
    /// Veiling glare index as of ISO 9358, 0 to 0.5: the light in the middle of a black patch before a white scene,
    /// over white. The patch is a tenth as wide as the shorter side of the frame.
    pub veil: f64,
}

/// Standard deviations of the Gaussians, rad. Each is of a quarter of the light.
const SIGMAS_RAD: [f64; 4] = [0.3, 0.1, 0.033_333, 0.011_111];

/// How far the sun may stand from the middle of the frame, in half diagonals, before a hood begins to shade the lens,
/// and where all of it is shaded, as for ghosts. FIT.
const HOOD: [f64; 2] = [1.0, FARTHEST];

/// Light of a sun that adds less everywhere is none.
const LEAST: f64 = 2e-5;

impl Glare {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.veil <= 0.0
    }

    /// Share of all light that is scattered: more than a patch shows, since some stays within a patch's radius of where
    /// it would be. No more than all.
    #[must_use]
    pub fn scattered(&self, optic: &Optic) -> f64 {
        (self.veil / Self::far(optic)).min(1.0)
    }

    /// What a patch shows: less than the veil asked for where all light is scattered and that is not enough, in frames
    /// whose shorter side is many degrees wide.
    #[must_use]
    pub fn shown(&self, optic: &Optic) -> f64 {
        self.scattered(optic) * Self::far(optic)
    }

    /// Share of scattered light that comes from beyond the radius of a patch.
    fn far(optic: &Optic) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let patch_px = 0.05 * optic.size.0.min(optic.size.1) as f64;
        SIGMAS_RAD
            .iter()
            .map(|sigma| {
                let ratio = patch_px / (sigma * optic.f_px);
                0.25 * libm::exp(-0.5 * ratio * ratio)
            })
            .sum()
    }

    pub(super) fn over(
        &self,
        light: &mut [f32],
        n_colors: usize,
        (optic, sun): (&Optic, Option<&Lamp>),
    ) {
        match n_colors {
            1 => self.colors_over::<1>(light, (optic, sun)),
            _ => self.colors_over::<3>(light, (optic, sun)),
        }
    }

    fn colors_over<const COLORS: usize>(
        &self,
        light: &mut [f32],
        (optic, sun): (&Optic, Option<&Lamp>),
    ) {
        // From the widest to the narrowest, each on cells as large as it allows; the sum goes from cells to finer ones.
        let mut sum: Option<Cells<COLORS>> = None;
        let mut pyramid = Pyramid::<COLORS>::of(light, optic.size);
        for sigma in SIGMAS_RAD {
            let mut blurred = pyramid.spread(sigma * optic.f_px);
            if let Some(wider) = sum {
                blurred.add(&wider);
            }
            sum = Some(blurred);
        }
        let Some(sum) = sum else { return };
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        let scattered = self.scattered(optic) as f32;
        let (kept, each) = (1.0 - scattered, 0.25 * scattered);
        let width = optic.size.0;
        let mut rows = sum.rows(width, 1);
        vectorized(
            #[inline(always)]
            || {
                for (y, row) in light.chunks_exact_mut(width * COLORS).enumerate() {
                    for (value, veil) in row.iter_mut().zip(rows.at(y)) {
                        *value = kept * *value + each * veil;
                    }
                }
            },
        );
        if let Some(sun) = sun {
            self.add_sun::<COLORS>(light, optic, sun);
        }
    }

    /// Adds what is scattered of a sun, in the frame or beside it.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "px of a frame; light is single precision"
    )]
    fn add_sun<const COLORS: usize>(&self, light: &mut [f32], optic: &Optic, sun: &Lamp) {
        let middle = optic.middle();
        let from_middle = [0, 1].map(|k| sun.at_px[k] - middle[k]);
        let away = libm::hypot(from_middle[0], from_middle[1]) / optic.half_diagonal_px();
        let passes = 1.0 - smooth_step(away, HOOD);
        if passes <= 0.0 {
            return;
        }
        let scattered = passes * self.scattered(optic) / SIGMAS_RAD.len() as f64;
        // Along the columns and along the rows, of each Gaussian.
        let along = |axis: usize, n: usize| -> Vec<[f32; 4]> {
            let of_place = |place: usize| {
                let from_sun = place as f64 + 0.5 - sun.at_px[axis];
                SIGMAS_RAD.map(|sigma| {
                    let sigma_px = sigma * optic.f_px;
                    let ratio = from_sun / sigma_px;
                    let share = libm::exp(-0.5 * ratio * ratio) / ((2.0 * PI).sqrt() * sigma_px);
                    share as f32
                })
            };
            (0..n).map(of_place).collect()
        };
        let (width, height) = optic.size;
        let (columns, rows) = (along(0, width), along(1, height));
        let color: [f32; COLORS] = of_colors(sun.light.map(|light| light * scattered as f32));
        let most =
            |of: &[[f32; 4]]| [0, 1, 2, 3].map(|k| of.iter().fold(0.0, |m, it| it[k].max(m)));
        let (column, row) = (most(&columns), most(&rows));
        let brightest: f32 = (0..4).map(|k| column[k] * row[k]).sum();
        if color
            .iter()
            .all(|light| f64::from(light * brightest) < LEAST)
        {
            return;
        }
        vectorized(
            #[inline(always)]
            || {
                for (row, down) in light.chunks_exact_mut(width * COLORS).zip(&rows) {
                    for (pixel, across) in row.as_chunks_mut::<COLORS>().0.iter_mut().zip(&columns)
                    {
                        let [a, b, c, d] = [0, 1, 2, 3].map(|k| across[k] * down[k]);
                        let veil = (a + b) + (c + d);
                        for (value, color) in pixel.iter_mut().zip(color) {
                            *value += veil * color;
                        }
                    }
                }
            },
        );
    }
}
