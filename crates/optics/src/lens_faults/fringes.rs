//! Colors whose pictures are not of one size, or not sharp at one place.

use super::resample::{Channel, resample};
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

    /// Red and blue of a color image; gray has no fringes.
    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic) {
        if n_colors != 3 {
            return;
        }
        let pixels = light.as_chunks_mut::<3>().0;
        let mut red: Vec<f32> = pixels.iter().map(|[red, _, _]| *red).collect();
        let mut blue: Vec<f32> = pixels.iter().map(|[_, _, blue]| *blue).collect();
        self.over_plane(&mut red, 1.0, optic);
        self.over_plane(&mut blue, -1.0, optic);
        for (pixel, (red, blue)) in pixels.iter_mut().zip(red.iter().zip(&blue)) {
            [pixel[0], pixel[2]] = [*red, *blue];
        }
    }

    /// A color by itself: of red with a sign of 1, of blue with -1.
    fn over_plane(&self, plane: &mut Vec<f32>, sign: f64, optic: &Optic) {
        if self.lateral_px.abs() > 0.0 {
            // r_c = r (1 + k (r/r₀)²), and half of the corner's fringe for each of the two.
            let corner_px = optic.half_diagonal_px();
            let k = 0.5 * sign * self.corner_px(optic) / corner_px;
            let [middle_x, middle_y] = optic.middle();
            let per_px2 = 1.0 / (corner_px * corner_px);
            let from = |u: f64, v: f64| {
                let [x, y] = [u - middle_x, v - middle_y];
                let shrunk = shrunk(per_px2 * (x * x + y * y), k);
                Some([middle_x + shrunk * x, middle_y + shrunk * y])
            };
            let size = optic.size;
            *plane = resample(plane, Channel { n: 1, size }, from);
        }
        if self.axial_m.abs() > 0.0 {
            let shift = Defocus {
                sensor_shift_m: -sign * self.axial_m,
            };
            shift.over(plane, 1, optic);
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
