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

/// Light that is the mean over much of the frame, for a pixel: that between four cells of the coarse scene.
#[derive(Debug, Clone)]
pub(super) struct Averaged {
    /// Place of its run among those that take light from elsewhere, and its place in that.
    run: u32,
    pixel: u32,
    /// The upper left cell, and how many on those to the right and below are.
    cell: u32,
    right: u32,
    below: u32,
    /// How far the place is from the former towards the latter.
    parts: [f32; 2],
    share: f32,
}

/// A mirror's picture moves by at most this much, px, from one pixel to the next.
pub(super) const ONE_MIRROR: f32 = 2.0;

/// Averages over less, px, are the pixel itself, and over more come from the coarse scene alone.
pub(crate) const FINE_WIDTHS: [f32; 2] = [1.5, 8.0];

/// Side of a cell of the finest coarse scene, px.
const CELL_PX: usize = 16;

impl OverlayLayer {
    /// The light of all runs from elsewhere, weighted by its share, over what was gathered before; `colors` are those of
    /// the pixel in a column and a row.
    pub(super) fn gather<const COLORS: usize>(
        &self,
        size: (usize, usize),
        colors: impl Fn(usize, usize) -> [f32; COLORS],
        gathered: &mut Vec<[[f32; CHUNK]; COLORS]>,
    ) {
        let light = |x: usize, y: usize| side_by_side(&colors(x, y));
        gathered.clear();
        gathered.resize(self.elsewhere.len(), [[0.0; CHUNK]; COLORS]);
        let mut add = |run: usize, k: usize, light: f32x4| {
            for (pixels, color) in gathered[run].iter_mut().zip(light.to_array()) {
                pixels[k] += color;
            }
        };
        for (run, other) in self.elsewhere.iter().enumerate() {
            for k in set_bits(other.is_fine.into()) {
                let share = other.share[k] * (1.0 - part_averaged(other.width[k]));
                let light = between(size, [other.u[k], other.v[k]], light);
                add(run, k, light * share);
            }
        }
        if self.averaged.is_empty() {
            return;
        }
        let cells = coarse(size, &colors, self.has_drops);
        for it in &self.averaged {
            let [first, right, below] = [it.cell, it.right, it.below].map(|at| at as usize);
            let [s, t] = it.parts;
            let row = |at: usize| cells[at] + (cells[at + right] - cells[at]) * s;
            let (top, bottom) = (row(first), row(first + below));
            let light = top + (bottom - top) * t;
            add(it.run as usize, it.pixel as usize, light * it.share);
        }
    }

    /// Finds what is averaged in a frame of a size, px, which does not depend on what it shows.
    pub(super) fn find_averaged(&mut self, size: (usize, usize)) {
        let n_wide = self.elsewhere.iter().map(|it| it.is_wide.count_ones());
        self.averaged.clear();
        self.averaged.reserve(n_wide.sum::<u32>() as usize);
        let levels = levels(size);
        for (run, other) in (0..).zip(&self.elsewhere) {
            for k in set_bits(other.is_wide.into()) {
                let (place, width) = ([other.u[k], other.v[k]], other.width[k]);
                let share = other.share[k] * part_averaged(width);
                for (doublings, part) in levels_of(width) {
                    if part > 0.0 {
                        let level = &levels[doublings.min(levels.len() - 1)];
                        let it = Averaged::of((run, k), (level, place), share * part);
                        self.averaged.push(it);
                    }
                }
            }
        }
    }
}

impl Averaged {
    /// Of a pixel of a run, about a place, px, between cells of a level.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "cells of a frame")]
    fn of((run, pixel): (u32, usize), (level, place): (&Level, [f32; 2]), share: f32) -> Self {
        let four = Four::around(level.size, place.map(|place| place * level.per_px));
        let ([x, y], [right, below]) = (four.first, four.steps);
        let columns = level.size.0;
        Self {
            run,
            pixel: pixel as u32,
            cell: (level.first + y * columns + x) as u32,
            right: right as u32,
            below: (below * columns) as u32,
            parts: four.parts,
            share,
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
/// Of a frame of at least a pixel and fewer than 2²⁴ per side; `light` is that of a pixel by column and row, its colors
/// side by side.
#[inline(always)]
pub(super) fn between(
    size: (usize, usize),
    place: [f32; 2],
    light: impl Fn(usize, usize) -> f32x4,
) -> f32x4 {
    let four = Four::around(size, place);
    let [x, y] = four.first;
    let [right, below] = four.steps;
    let [s, t] = four.parts;
    let (top_left, top_right) = (light(x, y), light(x + right, y));
    let (bottom_left, bottom_right) = (light(x, y + below), light(x + right, y + below));
    let top = top_left + (top_right - top_left) * s;
    let bottom = bottom_left + (bottom_right - bottom_left) * s;
    top + (bottom - top) * t
}

/// The four pixels around a place.
struct Four {
    /// Column and row of the upper left one.
    first: [usize; 2],
    /// From there to the others: 1, or 0 at the border.
    steps: [usize; 2],
    /// How far the place is from the former towards the latter.
    parts: [f32; 2],
}

impl Four {
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "px of a frame"
    )]
    fn around((width, height): (usize, usize), [u, v]: [f32; 2]) -> Self {
        let last = [width as i32 - 1, height as i32 - 1];
        let border = f32x4::new([last[0] as f32, last[1] as f32, 0.0, 0.0]);
        let place = f32x4::new([u, v, 0.0, 0.0]) - 0.5;
        // At least 0, and 0 where it is no number.
        let place = (place & place.simd_gt(f32x4::ZERO)).fast_min(border);
        let whole = place.fast_trunc_int();
        let [x, y, ..] = whole.to_array();
        let [s, t, ..] = (place - f32x4::from_i32x4(whole)).to_array();
        Self {
            first: [x as usize, y as usize],
            steps: [usize::from(x < last[0]), usize::from(y < last[1])],
            parts: [s, t],
        }
    }
}

/// A level of the coarse scene: means of ever more pixels.
struct Level {
    /// Place of its first cell among those of all levels.
    first: usize,
    size: (usize, usize),
    /// Cells in a pixel.
    per_px: f32,
}

/// The levels of a frame of a size, px, each with half as many cells along a side as the one before, down to one.
fn levels((width, height): (usize, usize)) -> Vec<Level> {
    let mut levels = Vec::new();
    let (mut first, mut side) = (0, CELL_PX);
    loop {
        let size = (width.div_ceil(side), height.div_ceil(side));
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let per_px = 1.0 / side as f32;
        levels.push(Level {
            first,
            size,
            per_px,
        });
        if size.0.max(size.1) <= 1 {
            return levels;
        }
        first += size.0 * size.1;
        side *= 2;
    }
}

/// Between which levels the mean over about a width, px, to each side is, and with which weights: the first one whose cells
/// are at least twice as wide, and the one before it, whose cells are half as wide, if it is not that one alone.
#[inline(always)]
fn levels_of(width: f32) -> [(usize, f32); 2] {
    #[expect(clippy::cast_precision_loss, reason = "16 px")]
    let cells = (2.0 * width / CELL_PX as f32).max(1.0);
    let exponent = exponent_up(cells);
    let doublings = exponent as usize - 127;
    let halves = cells / power_of(exponent - 1);
    let wide = match doublings > 0 && halves < 2.0 {
        true => halves - 1.0,
        false => 1.0,
    };
    [(doublings.saturating_sub(1), 1.0 - wide), (doublings, wide)]
}

/// The cells of all levels, of which the finest are means of all their pixels or of some.
fn coarse<const COLORS: usize>(
    (width, height): (usize, usize),
    colors: impl Fn(usize, usize) -> [f32; COLORS],
    has_all: bool,
) -> Vec<f32x4> {
    let levels = levels((width, height));
    let n_cells = levels.last().map_or(0, |last| last.first + 1);
    let mut cells = vec![f32x4::ZERO; n_cells];
    let (columns, rows) = levels[0].size;
    let finest = cells.chunks_exact_mut(columns).take(rows);
    for (row, y) in finest.zip((0..).step_by(CELL_PX)) {
        for (cell, x) in row.iter_mut().zip((0..).step_by(CELL_PX)) {
            *cell = match has_all {
                true => mean_light([x, y], [width, height], |x, y| side_by_side(&colors(x, y))),
                false => mean_of_four([x, y], [width, height], &colors),
            };
        }
    }
    for two in levels.windows(2) {
        if let [finer, level] = two {
            let (known, cells) = cells.split_at_mut(level.first);
            finer.halve(&known[finer.first..], cells);
        }
    }
    cells
}

/// Mean light of four pixels of a cell, in two rows: a row is as much to fetch as many pixels of it.
#[inline(always)]
fn mean_of_four<const COLORS: usize>(
    [x, y]: [usize; 2],
    [width, height]: [usize; 2],
    colors: impl Fn(usize, usize) -> [f32; COLORS],
) -> f32x4 {
    // Color by color, which is faster.
    let mut sum = [0.0; COLORS];
    for (dx, dy) in [(3, 4), (11, 4), (5, 12), (13, 12)] {
        let pixel = colors((x + dx).min(width - 1), (y + dy).min(height - 1));
        for (sum, color) in sum.iter_mut().zip(pixel) {
            *sum += color;
        }
    }
    side_by_side(&sum) * 0.25
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
    /// Means of two by two of its cells.
    fn halve(&self, from: &[f32x4], to: &mut [f32x4]) {
        let (width, height) = self.size;
        let mut to = to.iter_mut();
        for y in (0..height).step_by(2) {
            for x in (0..width).step_by(2) {
                let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
                let mut sum = f32x4::ZERO;
                for (x, y) in [(x, y), (right, y), (x, below), (right, below)] {
                    sum += from[y * width + x];
                }
                if let Some(to) = to.next() {
                    *to = sum * 0.25;
                }
            }
        }
    }
}
