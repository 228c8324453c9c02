//! Colors whose pictures are not of one size, or not sharp at one place.

use super::resample::{Beyond, Resampling};
use super::{Defocus, Optic};

/// Colored fringes: red and blue are larger or smaller than green, and sharp elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fringes {
    /// How much farther from the middle red is than blue in a corner, px.
    pub lateral_px: f64,
    /// How far behind the sensor red is sharp, and blue before it, m.
    pub axial_m: f64,
}

impl Fringes {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.lateral_px.abs() <= 0.0 && self.axial_m.abs() <= 0.0
    }

    /// How much farther from the middle red is than blue in a corner, px: at most a quarter of the way to the corner.
    #[must_use]
    pub fn corner_px(&self, optic: &Optic) -> f64 {
        let most = 0.25 * optic.half_diagonal_px();
        self.lateral_px.clamp(-most, most)
    }

    /// Where red and blue come from; nothing where both stay.
    pub(super) fn resamplings(&self, optic: &Optic) -> Vec<Resampling> {
        if self.lateral_px.abs() <= 0.0 {
            return Vec::new();
        }
        // r_c = r (1 + k (r/r₀)²), and half of the corner's fringe for each of the two.
        let corner_px = optic.half_diagonal_px();
        let k_red = 0.5 * self.corner_px(optic) / corner_px;
        let [middle_x, middle_y] = optic.middle();
        let per_px2 = 1.0 / (corner_px * corner_px);
        let of_color = |k: f64| {
            Resampling::new(optic.size, Beyond::Border, |u, v| {
                let (x, y) = (u - middle_x, v - middle_y);
                let shrunk = shrunk(per_px2 * (x * x + y * y), k);
                Some([middle_x + shrunk * x, middle_y + shrunk * y])
            })
        };
        vec![of_color(k_red), of_color(-k_red)]
    }

    /// Red and blue of a color image; gray has no fringes.
    pub(super) fn over(
        &self,
        light: &mut [f32],
        n_colors: usize,
        (optic, resamplings): (&Optic, &[Resampling]),
    ) {
        if n_colors != 3 {
            return;
        }
        let pixels = light.as_chunks_mut::<3>().0;
        for (color, sign) in [(0, 1.0), (2, -1.0)] {
            let mut plane: Vec<f32> = pixels.iter().map(|pixel| pixel[color]).collect();
            // That of red comes first.
            if let Some(resampling) = resamplings.get(color / 2) {
                plane = resampling.over(&plane, 1);
            }
            if self.axial_m.abs() > 0.0 {
                let shift = Defocus {
                    sensor_shift_m: -sign * self.axial_m,
                };
                shift.over(&mut plane, 1, optic);
            }
            for (pixel, value) in pixels.iter_mut().zip(plane) {
                pixel[color] = value;
            }
        }
    }
}

/// r over r_c = r (1 + k r²), of the square of r_c.
fn shrunk(square: f64, k: f64) -> f64 {
    // Newton for s in s (1 + k q s²) = 1; k is a hundredth or so.
    let kq = k * square;
    let mut s = 1.0 - kq;
    for _ in 0..3 {
        s -= (s * (1.0 + kq * s * s) - 1.0) / (1.0 + 3.0 * kq * s * s);
    }
    s
}
