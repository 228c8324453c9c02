//! Light from elsewhere in the frame: what mirrors and chips show of the scene itself.

use wide::f32x4;

use super::overlay::OverlayLayer;
use crate::bit_rows::set_bits;
use crate::maps::CHUNK;

/// Light from elsewhere in the frame for the pixels of a run.
#[derive(Debug, Clone)]
pub(super) struct Elsewhere {
    /// Its share.
    pub(super) share: [f32; CHUNK],
    /// The place, px.
    pub(super) u: [f32; CHUNK],
    pub(super) v: [f32; CHUNK],
    /// Over how much of the frame, px, it is averaged.
    pub(super) width: [f32; CHUNK],
    /// Bit k is set where pixel k has some that is not averaged, and where it has some that is.
    pub(super) is_fine: u32,
    pub(super) is_wide: u32,
}

/// A mirror's picture moves by at most this much, px, from one pixel to the next.
pub(super) const ONE_MIRROR: f32 = 2.0;

/// Averages over less, px, are the pixel itself, and over more come from the coarse scene alone.
pub(crate) const FINE_WIDTHS: [f32; 2] = [1.5, 8.0];

/// Side of a cell of the finest coarse scene, px.
const CELL_PX: usize = 16;

impl OverlayLayer {
    /// The light of all runs from elsewhere, weighted by its share, over what was gathered before; `light` is that of a
    /// pixel in a column and a row.
    pub(super) fn gather<const COLORS: usize>(
        &self,
        size: (usize, usize),
        colors: impl Fn(usize, usize) -> [f32; COLORS],
        gathered: &mut Vec<[[f32; CHUNK]; COLORS]>,
    ) {
        let light = |x: usize, y: usize| side_by_side(&colors(x, y));
        let coarse = if self.elsewhere.iter().any(|other| other.is_wide > 0) {
            Coarse::of(size, &colors, self.has_drops)
        } else {
            Coarse { levels: Vec::new() }
        };
        gathered.clear();
        gathered.resize(self.elsewhere.len(), [[0.0; CHUNK]; COLORS]);
        for (other, pixels) in self.elsewhere.iter().zip(gathered) {
            let mut add = |k: usize, light: f32x4| {
                for (pixels, color) in pixels.iter_mut().zip(light.to_array()) {
                    pixels[k] += color;
                }
            };
            // One after the other, so that no branch has to be foretold.
            for k in set_bits(other.is_fine.into()) {
                let share = other.share[k] * (1.0 - part_averaged(other.width[k]));
                let light = between_pixels(size, [other.u[k], other.v[k]], light);
                add(k, light * share);
            }
            for k in set_bits(other.is_wide.into()) {
                let share = other.share[k] * part_averaged(other.width[k]);
                let light = coarse.mean([other.u[k], other.v[k]], other.width[k]);
                add(k, light * share);
            }
        }
    }
}

/// How much of the light is averaged over a width, px.
#[inline(always)]
pub(super) fn part_averaged(width: f32) -> f32 {
    let [least, most] = FINE_WIDTHS;
    ((width - least) / (most - least)).clamp(0.0, 1.0)
}

/// The exponent, as an `f32` has it, of the least power of two that is no less than a number above 0.
pub(crate) fn exponent_up(value: f32) -> u32 {
    ((value.to_bits() - 1) >> (f32::MANTISSA_DIGITS - 1)) + 1
}

/// The power of two of an exponent, as an `f32` has it.
pub(super) fn power_of(exponent: u32) -> f32 {
    f32::from_bits(exponent << (f32::MANTISSA_DIGITS - 1))
}

/// Colors as one vector, of which what they leave is 0.
#[inline(always)]
pub(super) fn side_by_side<const COLORS: usize>(colors: &[f32; COLORS]) -> f32x4 {
    const { assert!(COLORS <= 4, "a vector holds four") };
    let mut all = [0.0; 4];
    for (to, color) in all.iter_mut().zip(colors) {
        *to = *color;
    }
    f32x4::new(all)
}

/// Light at a place, px, between the middles of pixels; beyond the frame that of its border.
///
/// Of a frame of at least a pixel and fewer than 2²⁴ per side; `light` is that of a pixel, counted
/// row by row, its colors side by side.
#[inline(always)]
pub(super) fn between(
    size: (usize, usize),
    place: [f32; 2],
    light: impl Fn(usize) -> f32x4,
) -> f32x4 {
    between_pixels(size, place, |x, y| light(y * size.0 + x))
}

/// The same of pixels by column and row.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "px of a frame"
)]
fn between_pixels(
    (width, height): (usize, usize),
    [u, v]: [f32; 2],
    light: impl Fn(usize, usize) -> f32x4,
) -> f32x4 {
    let last = [width as i32 - 1, height as i32 - 1];
    let border = f32x4::new([last[0] as f32, last[1] as f32, 0.0, 0.0]);
    let place = f32x4::new([u, v, 0.0, 0.0]) - 0.5;
    // At least 0, and 0 where it is no number.
    let place = (place & place.simd_gt(f32x4::ZERO)).fast_min(border);
    let whole = place.fast_trunc_int();
    let [x, y, ..] = whole.to_array();
    let [s, t, ..] = (place - f32x4::from_i32x4(whole)).to_array();
    let (right, below) = ((x + 1).min(last[0]), (y + 1).min(last[1]));
    let at = |x: i32, y: i32| light(x as usize, y as usize);
    let (top_left, top_right) = (at(x, y), at(right, y));
    let (bottom_left, bottom_right) = (at(x, below), at(right, below));
    let top = top_left + (top_right - top_left) * s;
    let bottom = bottom_left + (bottom_right - bottom_left) * s;
    top + (bottom - top) * t
}

/// The scene in large cells: means of pixels of each, then of ever more cells.
struct Coarse {
    levels: Vec<Level>,
}

struct Level {
    size: (usize, usize),
    /// Cells in a pixel.
    per_px: f32,
    /// Of the cells, row by row.
    light: Vec<f32x4>,
}

impl Coarse {
    /// Of all pixels, or of four of each cell, in two rows: a row is as much to fetch as many pixels of it.
    fn of<const COLORS: usize>(
        (width, height): (usize, usize),
        colors: impl Fn(usize, usize) -> [f32; COLORS],
        has_all: bool,
    ) -> Self {
        let size = (width.div_ceil(CELL_PX), height.div_ceil(CELL_PX));
        let some = [(3, 4), (11, 4), (5, 12), (13, 12)];
        let mut cells = vec![f32x4::ZERO; size.0 * size.1];
        for (row, y) in cells.chunks_exact_mut(size.0).zip((0..).step_by(CELL_PX)) {
            for (cell, x) in row.iter_mut().zip((0..).step_by(CELL_PX)) {
                *cell = if has_all {
                    mean_light([x, y], [width, height], |x, y| side_by_side(&colors(x, y)))
                } else {
                    // Color by color, which is faster.
                    let mut sum = [0.0; COLORS];
                    for (dx, dy) in some {
                        let pixel = colors((x + dx).min(width - 1), (y + dy).min(height - 1));
                        for (sum, color) in sum.iter_mut().zip(pixel) {
                            *sum += color;
                        }
                    }
                    side_by_side(&sum) * 0.25
                };
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "16 px")]
        let mut levels = vec![Level {
            size,
            per_px: 1.0 / CELL_PX as f32,
            light: cells,
        }];
        while let Some(last) = levels
            .last()
            .filter(|last| last.size.0.max(last.size.1) > 1)
        {
            let next = last.halved();
            levels.push(next);
        }
        Self { levels }
    }

    /// Mean light about a place, px, over about `width` px to each side.
    #[inline(always)]
    fn mean(&self, [u, v]: [f32; 2], width: f32) -> f32x4 {
        // Of the first level whose cells are at least twice as wide, and of the one before it, whose cells are half as wide.
        #[expect(clippy::cast_precision_loss, reason = "16 px")]
        let cells = (2.0 * width / CELL_PX as f32).max(1.0);
        let exponent = exponent_up(cells);
        let doublings = exponent as usize - 127;
        let of_level = |doublings: usize| {
            let level = self.levels.get(doublings).or(self.levels.last());
            level.map_or(f32x4::ZERO, |level| {
                let place = [u, v].map(|place| place * level.per_px);
                between(level.size, place, |at| level.light[at])
            })
        };
        let wide = of_level(doublings);
        let halves = cells / power_of(exponent - 1);
        if doublings == 0 || halves >= 2.0 {
            return wide;
        }
        let narrow = of_level(doublings - 1);
        narrow + (wide - narrow) * (halves - 1.0)
    }
}

/// Mean light of the pixels of a cell from its first on, as far as it lies in the frame.
fn mean_light(
    [x, y]: [usize; 2],
    [width, height]: [usize; 2],
    light: impl Fn(usize, usize) -> f32x4,
) -> f32x4 {
    let (columns, rows) = (x..(x + CELL_PX).min(width), y..(y + CELL_PX).min(height));
    #[expect(clippy::cast_precision_loss, reason = "some hundred px")]
    let n = (columns.len() * rows.len()) as f32;
    let mut sum = f32x4::ZERO;
    for y in rows {
        for x in columns.clone() {
            sum += light(x, y);
        }
    }
    sum * (1.0 / n)
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = self.size;
        let size = (width.div_ceil(2), height.div_ceil(2));
        let mut light = Vec::with_capacity(size.0 * size.1);
        for y in (0..height).step_by(2) {
            for x in (0..width).step_by(2) {
                let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
                let cells = [(x, y), (right, y), (x, below), (right, below)];
                let cells = cells.map(|(x, y)| self.light[y * width + x]);
                let mut sum = f32x4::ZERO;
                for cell in cells {
                    sum += cell;
                }
                light.push(sum * 0.25);
            }
        }
        Self {
            size,
            per_px: 0.5 * self.per_px,
            light,
        }
    }
}
