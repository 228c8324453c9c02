//! Corners that get less light than the middle.

use super::Optic;
use crate::pyramid::vectorized;

/// Loss of light towards the corners, by the law of a lens whose light falls onto the sensor at a slant:
/// cos⁴ θ, where tan θ = r/d. The distance d of its exit pupil is such that a corner loses what is said. A camera's own
/// correction is left out, or does not fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// Share of light that a corner loses, 0 to 0.95.
    pub corner_loss: f64,
}

impl Shading {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.corner_loss <= 0.0
    }

    /// Share of light that is left at a distance from the middle, over that of the corners.
    #[must_use]
    pub fn left(&self, r: f64) -> f64 {
        // cos² θ = 1/(1 + tan² θ), and its square is what is left in a corner, where r = 1.
        let corner_tan2 = 1.0 / (1.0 - self.corner_loss).sqrt() - 1.0;
        let cos2 = 1.0 / (1.0 + corner_tan2 * r * r);
        cos2 * cos2
    }

    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic) {
        vectorized(
            #[inline(always)]
            || match n_colors {
                1 => self.over_rows::<1>(light, optic),
                _ => self.over_rows::<3>(light, optic),
            },
        );
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "px of a frame; light is single precision"
    )]
    #[inline(always)]
    fn over_rows<const COLORS: usize>(&self, light: &mut [f32], optic: &Optic) {
        let (width, height) = optic.size;
        let [middle_x, middle_y] = optic.middle();
        let corner_tan2 = 1.0 / (1.0 - self.corner_loss).sqrt() - 1.0;
        let per_px2 = corner_tan2 / (optic.half_diagonal_px() * optic.half_diagonal_px());
        let mut gains = vec![0.0_f32; width];
        // The law is even: rows below the middle are as those above it, and so are halves of rows.
        let mut rows = light.chunks_exact_mut(width * COLORS);
        for y in 0..height.div_ceil(2) {
            let dy = y as f64 + 0.5 - middle_y;
            let (half, mirrored) = gains.split_at_mut(width.div_ceil(2));
            for (x, gain) in half.iter_mut().enumerate() {
                let dx = x as f64 + 0.5 - middle_x;
                let cos2 = 1.0 / (1.0 + per_px2 * (dx * dx + dy * dy));
                *gain = (cos2 * cos2) as f32;
            }
            for (to, gain) in mirrored.iter_mut().rev().zip(half) {
                *to = *gain;
            }
            for row in [rows.next(), rows.next_back()].into_iter().flatten() {
                for (pixel, gain) in row.as_chunks_mut::<COLORS>().0.iter_mut().zip(&gains) {
                    for value in pixel {
                        *value *= gain;
                    }
                }
            }
        }
    }
}
