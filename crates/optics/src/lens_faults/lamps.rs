//! Lamps of a frame: what is brighter than white, and the sun beside it.

use super::Optic;
use super::bright::runs_with;
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
pub(super) fn lamps_of(light: &[f32], n_colors: usize, size: (usize, usize)) -> Vec<Lamp> {
    match n_colors {
        1 => lamps_of_colors::<1>(light.as_chunks().0, size),
        _ => lamps_of_colors::<3>(light.as_chunks().0, size),
    }
}

fn lamps_of_colors<const COLORS: usize>(
    light: &[[f32; COLORS]],
    (width, height): (usize, usize),
) -> Vec<Lamp> {
    let lit = runs_with(light, width, |value| value > 1.0);
    if lit.is_empty() {
        return Vec::new();
    }
    let (mut columns, rows) = (width.div_ceil(CELL_PX), height.div_ceil(CELL_PX));
    let mut cells = vec![Cell::default(); columns * rows];
    for run in lit {
        let (left, y) = (run.start % width, run.start / width);
        for (x, pixel) in (left..).zip(&light[run]) {
            cells[y / CELL_PX * columns + x / CELL_PX].add_pixel([x, y], pixel);
        }
    }
    let is_lit = |cell: &&Cell| cell.weight > 0.0;
    while cells.iter().filter(is_lit).count() > MOST {
        let half = columns.div_ceil(2);
        let mut larger = vec![Cell::default(); half * cells.len().div_ceil(columns).div_ceil(2)];
        for (k, cell) in cells.iter().enumerate() {
            larger[k / columns / 2 * half + k % columns / 2].add(cell);
        }
        (cells, columns) = (larger, half);
    }
    cells.iter().filter(is_lit).map(Cell::lamp).collect()
}

/// What of the frame's lamps is in a square of it.
#[derive(Clone, Copy, Default)]
struct Cell {
    colors: [f64; 3],
    /// All colors together, and places, px, times that.
    weight: f64,
    at: [f64; 2],
    n_pixels: u32,
}

impl Cell {
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    fn add_pixel<const COLORS: usize>(&mut self, at: [usize; 2], pixel: &[f32; COLORS]) {
        let all = f64::from(pixel.iter().sum::<f32>());
        self.add(&Self {
            colors: [0, 1, 2].map(|k| f64::from(pixel[k.min(COLORS - 1)])),
            weight: all,
            at: at.map(|place| all * (place as f64 + 0.5)),
            n_pixels: 1,
        });
    }

    fn add(&mut self, other: &Self) {
        for (sum, color) in self.colors.iter_mut().zip(other.colors) {
            *sum += color;
        }
        for (sum, at) in self.at.iter_mut().zip(other.at) {
            *sum += at;
        }
        self.weight += other.weight;
        self.n_pixels += other.n_pixels;
    }

    /// All of it as one lamp.
    fn lamp(&self) -> Lamp {
        #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
        let light = self.colors.map(|color| color as f32);
        Lamp {
            at_px: self.at.map(|place| place / self.weight),
            light,
            radius_px: (f64::from(self.n_pixels) / std::f64::consts::PI).sqrt(),
        }
    }
}
