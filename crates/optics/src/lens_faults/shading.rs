//! Corners that get less light than the middle.

use super::Optic;

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

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "px of a frame; light is single precision"
    )]
    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic) {
        let (width, _) = optic.size;
        let [middle_x, middle_y] = optic.middle();
        let corner_tan2 = 1.0 / (1.0 - self.corner_loss).sqrt() - 1.0;
        let per_px2 = corner_tan2 / (optic.half_diagonal_px() * optic.half_diagonal_px());
        // The law is even: one half of a row is the other's mirror image.
        let half = width.div_ceil(2);
        let mut gains = vec![0.0_f32; width];
        for (y, row) in light.chunks_exact_mut(width * n_colors).enumerate() {
            let dy = y as f64 + 0.5 - middle_y;
            for x in 0..half {
                let dx = x as f64 + 0.5 - middle_x;
                let cos2 = 1.0 / (1.0 + per_px2 * (dx * dx + dy * dy));
                let gain = (cos2 * cos2) as f32;
                (gains[x], gains[width - 1 - x]) = (gain, gain);
            }
            for (pixel, gain) in row.chunks_exact_mut(n_colors).zip(&gains) {
                for value in pixel {
                    *value *= gain;
                }
            }
        }
    }
}
