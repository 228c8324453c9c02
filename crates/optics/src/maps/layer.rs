//! Facets of a frame, covered and blurred: the scattering half of the maps.
//!
//! Cracks are thin and their blur is wide, so each *covered* cell is scattered over the image of
//! the pupil that its own depth has; a running sum along each row turns the few steps per row of
//! a disc into the disc. Cells are of the size that suits the disc: four to twelve of them per
//! radius, between four per pixel and one per eight pixels across. Coverage is found on cells of
//! half that size, which are then shared among the four nearest cells, so that a facet keeps its
//! place to a fraction of a cell.

use std::collections::BTreeMap;

use super::cells::Row;
use super::chunks::Chunks;
use super::emit::Emitter;
use super::kernel::{Kernel, Pupil};
use super::raster::Polygon;

/// A flat piece of something, as it lies in the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Facet<const L: usize> {
    /// Corners of a convex quadrilateral, px.
    pub(crate) corners: [[f64; 2]; 4],
    /// What it sends along each lane, per unit of coverage.
    pub(crate) lanes: [f32; L],
    /// Change of the last two lanes per px along x and y, from the mean of the corners.
    pub(crate) lean: [[f32; 2]; 2],
    /// Signed radius of its blur, px; negative turns the pupil over.
    pub(crate) radius_px: f64,
}

/// Fewest cells per radius of a disc where cells are no larger than pixels, and where they are.
const CELLS_PER_RADIUS: [f64; 2] = [4.0, 6.0];

/// Exponents of two of the finest and the coarsest number of cells per pixel.
const LEVELS: std::ops::RangeInclusive<i32> = -3..=2;

/// Discs of fewer cells are scattered from the cells that were covered, not from shared ones:
/// sharing would blur more than the disc.
const FEW_CELLS: f64 = 0.5;

/// A disc of a smaller radius, px, is a point.
const IN_FOCUS_PX: f64 = 0.02;

/// Radii within this ratio share a kernel.
const RADIUS_RATIO: f64 = 1.005;

/// The sum of all facets over the frame, each spread by its disc.
///
/// The first `n_shares` lanes are shares of coverage: where facets overlap they are scaled, with
/// all other lanes, to sum to at most 1.
pub(crate) fn spread<const L: usize>(
    facets: &[Facet<L>],
    n_shares: usize,
    pupil: Pupil,
    (width, height): (usize, usize),
) -> Chunks<L> {
    let mut frame = Chunks::new(width, height);
    let mut levels: BTreeMap<Level, Vec<&Facet<L>>> = BTreeMap::new();
    for facet in facets {
        let level = Level::of(facet.radius_px);
        levels.entry(level).or_default().push(facet);
    }
    for (level, facets) in levels {
        Layer::new(level, &facets, n_shares, pupil, (width, height)).run(&facets, &mut frame);
    }
    frame
}

/// A size of cells, and whether coverage is found on halves of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Level {
    /// Cells per px as a power of two.
    exponent: i32,
    is_halved: bool,
}

impl Level {
    fn of(radius_px: f64) -> Self {
        if radius_px.abs() < IN_FOCUS_PX {
            // Exact coverage of the pixels themselves.
            return Self {
                exponent: 0,
                is_halved: false,
            };
        }
        let exponent_for = |cells: f64| -> i32 {
            // Also right for a radius of 0, whose logarithm is −∞.
            let exact = libm::log2(cells / radius_px.abs()).clamp(-9.0, 9.0);
            #[expect(clippy::cast_possible_truncation, reason = "clamped")]
            let exponent = exact.ceil() as i32;
            exponent.clamp(*LEVELS.start(), *LEVELS.end())
        };
        let [fine, coarse] = CELLS_PER_RADIUS.map(exponent_for);
        let exponent = fine.max(coarse.min(0));
        Self {
            exponent,
            is_halved: radius_px.abs() * f64::exp2(f64::from(exponent)) >= FEW_CELLS,
        }
    }

    /// Weights by which a half of a cell, a quarter of a cell off its middle, is shared along one
    /// axis: with the cell on its far side, its own, the one on its near side.
    ///
    /// They keep sum and mean, and their second moment, cells², makes up for all that blurs
    /// besides the disc and the pixel itself: the half's own width, and for coarse cells the
    /// kernel's cells.
    fn weights(self) -> [f32; 3] {
        let kernel = if self.exponent >= 0 { 0.0 } else { 1.0 / 12.0 };
        let second = 1.0 / 16.0 - 1.0 / 48.0 - kernel;
        [0.5 * (second - 0.25), 1.0 - second, 0.5 * (second + 0.25)]
    }
}

/// One size of cells.
struct Layer<const L: usize> {
    level: Level,
    n_shares: usize,
    /// Cells per px.
    scale: f64,
    /// Cells around the frame on each side.
    margin: usize,
    /// Cells across and down, margins included.
    columns: usize,
    rows: usize,
    kernels: Vec<Kernel>,
    /// Kernel of each facet.
    kernel_of: Vec<u32>,
    /// Steps of the rows that discs now reach, a power of two of them, each with room on both
    /// sides for discs that reach out of the margin.
    ring: Vec<[f32; L]>,
    ring_mask: usize,
    /// Touched cells of each row of the ring: first and last.
    spans: Vec<[usize; 2]>,
    reach: usize,
}

impl<const L: usize> Layer<L> {
    fn new(
        level: Level,
        facets: &[&Facet<L>],
        n_shares: usize,
        pupil: Pupil,
        (width, height): (usize, usize),
    ) -> Self {
        let exponent = level.exponent;
        let scale = f64::exp2(f64::from(exponent));
        let (kernels, kernel_of) = kernels_of(scale, facets, pupil);
        let reach = kernels.iter().map(Kernel::reach).max().unwrap_or(0);
        // A whole number of px, and of cells.
        let step = 1_usize << exponent.max(0);
        let margin = (reach + 2).div_ceil(step) * step;
        let cells = |px: usize| {
            if exponent >= 0 {
                px << exponent
            } else {
                px.div_ceil(1 << -exponent) + 1
            }
        };
        let (columns, rows) = (cells(width) + 2 * margin, cells(height) + 2 * margin);
        let ring_rows = (2 * reach + 1).next_power_of_two();
        Self {
            level,
            n_shares,
            scale,
            margin,
            columns,
            rows,
            kernels,
            kernel_of,
            ring: vec![[0.0; L]; ring_rows * (columns + 2 * reach)],
            ring_mask: ring_rows - 1,
            spans: vec![[usize::MAX, 0]; ring_rows],
            reach,
        }
    }

    fn run(mut self, facets: &[&Facet<L>], frame: &mut Chunks<L>) {
        let per_cell = if self.level.is_halved { 2 } else { 1 };
        let fine = self.scale * f64::from(per_cell);
        let per_cell = per_cell as usize;
        let (columns, rows) = (self.columns * per_cell, self.rows * per_cell);
        let margin = self.margin * per_cell;
        let mut waiting = placed(facets, fine, margin, (columns, rows))
            .into_iter()
            .peekable();
        let mut active: Vec<Placed> = Vec::new();
        let mut covered = Row::new(columns + 2);
        let mut across = Row::new(self.columns);
        let mut shared = [0; 3].map(|_| Row::new(self.columns));
        let mut scratch = vec![0.0_f32; columns + 3];
        let mut emitter = Emitter::new(
            self.level.exponent,
            self.margin,
            self.columns,
            self.n_shares,
        );
        for fine_row in 0..rows {
            while let Some(placed) = waiting.next_if(|placed| placed.first <= fine_row) {
                active.push(placed);
            }
            active.retain(|placed| placed.last > fine_row);
            for placed in &active {
                let facet = facets[placed.facet];
                let kernel = self.kernel_of[placed.facet];
                cover(
                    placed,
                    facet,
                    (fine_row, margin, fine, kernel),
                    self.n_shares,
                    &mut scratch,
                    &mut covered,
                );
            }
            self.share(fine_row, &mut covered, &mut across, &mut shared);
            // The second half of the next row was the last to share with this one.
            let complete = if per_cell == 1 {
                Some(fine_row)
            } else {
                (fine_row % 2 == 1)
                    .then(|| (fine_row / 2).checked_sub(1))
                    .flatten()
            };
            if let Some(row) = complete {
                self.finish(row, &mut shared, &mut emitter, frame);
            }
        }
        for row in self.rows - per_cell + 1..self.rows + self.reach {
            self.finish(row, &mut shared, &mut emitter, frame);
        }
    }

    /// Scatters a row that is complete, and hands on the row that no later disc reaches.
    fn finish(
        &mut self,
        row: usize,
        shared: &mut [Row<L>; 3],
        emitter: &mut Emitter<L>,
        frame: &mut Chunks<L>,
    ) {
        if row < self.rows {
            self.scatter(row, &mut shared[row % 3]);
        }
        if let Some(row) = row.checked_sub(self.reach) {
            self.finish_row(row, emitter, frame);
        }
    }

    /// Shares the covered cells of a row of halves among the cells of three rows, first along the
    /// row and then across; without halves hands them on as they are. `across` is empty before
    /// and after.
    fn share(
        &self,
        fine_row: usize,
        covered: &mut Row<L>,
        across: &mut Row<L>,
        shared: &mut [Row<L>; 3],
    ) {
        let n_shares = self.n_shares;
        let weights = self.level.weights();
        covered.drain(|column, cell| {
            let mut lanes = cell.lanes;
            let share: f32 = lanes[..n_shares].iter().sum();
            if share > 1.0 {
                for lane in &mut lanes {
                    *lane /= share;
                }
            }
            if self.level.is_halved {
                // A cell's value is the mean over its halves.
                for (column, part) in shares_of(column, weights) {
                    across.add(column, 0.5 * part, &lanes, cell);
                }
            } else {
                shared[fine_row % 3].add(column, 1.0, &lanes, cell);
            }
        });
        if !self.level.is_halved {
            return;
        }
        across.drain(|column, cell| {
            for (row, part) in shares_of(fine_row, weights) {
                if row < self.rows {
                    shared[row % 3].add(column, 0.5 * part, &cell.lanes, cell);
                }
            }
        });
    }

    /// Scatters the cells of a row over their discs, and empties them.
    fn scatter(&mut self, row: usize, cells: &mut Row<L>) {
        let stride = self.columns + 2 * self.reach;
        cells.drain(|column, cell| {
            let lanes = cell.lanes;
            let middle = (column + self.reach).cast_signed();
            for (dy, dx, steps) in self.kernels[cell.kernel as usize].runs() {
                let Some(y) = row.checked_add_signed(dy as isize) else {
                    continue;
                };
                let slot = y & self.ring_mask;
                let first = (middle + dx as isize).cast_unsigned();
                let end = first + steps.len();
                let line = &mut self.ring[slot * stride + first..slot * stride + end];
                for (to, step) in line.iter_mut().zip(steps) {
                    // As one array, of which the compiler makes vectors.
                    let sum = *to;
                    *to = std::array::from_fn(|l| sum[l] + step * lanes[l]);
                }
                let span = &mut self.spans[slot];
                *span = [span[0].min(first), span[1].max(end - 1)];
            }
        });
    }

    /// Sums up a row that no later disc reaches, hands it on, and clears it.
    fn finish_row(&mut self, row: usize, emitter: &mut Emitter<L>, frame: &mut Chunks<L>) {
        let slot = row & self.ring_mask;
        let stride = self.columns + 2 * self.reach;
        let [first, last] = self.spans[slot];
        emitter.begin_row();
        if first <= last {
            let line = &mut self.ring[slot * stride..][first..=last];
            let mut sum = [0.0_f32; L];
            for (column, step) in (first..).zip(line) {
                sum = std::array::from_fn(|l| sum[l] + step[l]);
                *step = [0.0; L];
                if column >= self.reach && column < self.reach + self.columns {
                    emitter.row[column - self.reach] = sum;
                }
            }
            emitter.span = [
                first.saturating_sub(self.reach),
                (last + 1).saturating_sub(self.reach).min(self.columns),
            ];
            self.spans[slot] = [usize::MAX, 0];
        }
        emitter.end_row(row, frame);
    }
}

/// The cells that a half is shared among along one axis, and their parts; the first may lie before
/// the first cell.
fn shares_of(half: usize, [far, own, near]: [f32; 3]) -> [(usize, f32); 3] {
    let cell = half / 2;
    let (before, after) = if half.is_multiple_of(2) {
        (near, far)
    } else {
        (far, near)
    };
    [
        (cell.wrapping_sub(1), before),
        (cell, own),
        (cell + 1, after),
    ]
}

/// A facet in cells: the rows from `first` to before `last`.
struct Placed {
    polygon: Polygon,
    first: usize,
    last: usize,
    facet: usize,
}

/// The facets that reach the grid, by the rows in which they begin.
#[expect(clippy::cast_precision_loss, reason = "cells of a grid")]
fn placed<const L: usize>(
    facets: &[&Facet<L>],
    scale: f64,
    margin: usize,
    (columns, rows): (usize, usize),
) -> Vec<Placed> {
    let mut all: Vec<Placed> = Vec::with_capacity(facets.len());
    for (k, facet) in facets.iter().enumerate() {
        let corners = facet
            .corners
            .map(|corner| corner.map(|coordinate| coordinate * scale + margin as f64));
        let polygon = Polygon::new(&corners).within(columns as f64);
        let [top, bottom] = polygon.span(1);
        if !(top < rows as f64 && bottom > 0.0) {
            continue;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rows of the grid"
        )]
        let (first, last) = (
            top.max(0.0) as usize,
            bottom.min(rows as f64).ceil() as usize,
        );
        all.push(Placed {
            polygon,
            first,
            last,
            facet: k,
        });
    }
    // Stable: facets of one row keep their order.
    all.sort_by_key(|placed| placed.first);
    all
}

/// Adds what a facet covers of a row of cells.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "cells of a grid; px as f32"
)]
fn cover<const L: usize>(
    placed: &Placed,
    facet: &Facet<L>,
    (row, margin, scale, kernel): (usize, usize, f64, u32),
    n_shares: usize,
    scratch: &mut [f32],
    covered: &mut Row<L>,
) {
    let middle: [f64; 2] = std::array::from_fn(|axis| {
        facet.corners.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25
    });
    let weight: f32 = facet.lanes.iter().take(n_shares).sum();
    let place = |cell: usize| (cell as f64 + 0.5 - margin as f64) / scale;
    let y = (place(row) - middle[1]) as f32;
    let (x_first, x_step) = ((place(0) - middle[0]) as f32, (1.0 / scale) as f32);
    placed
        .polygon
        .cover_row(row as i64, scratch, |column, area| {
            let cell = covered.cell(column, kernel, area * weight);
            let sum = cell.lanes;
            cell.lanes = std::array::from_fn(|l| sum[l] + area * facet.lanes[l]);
            let x = x_first + x_step * column as f32;
            for (k, lean) in facet.lean.iter().enumerate() {
                cell.lanes[L - 2 + k] += area * (lean[0] * x + lean[1] * y);
            }
        });
}

/// The kernels that facets need, and which each needs.
fn kernels_of<const L: usize>(
    scale: f64,
    facets: &[&Facet<L>],
    pupil: Pupil,
) -> (Vec<Kernel>, Vec<u32>) {
    let mut kernels = Vec::new();
    let mut known: BTreeMap<i32, u32> = BTreeMap::new();
    let kernel_of = facets
        .iter()
        .map(|facet| {
            let radius = facet.radius_px * scale;
            #[expect(clippy::cast_possible_truncation, reason = "logarithms")]
            let key = (libm::log(radius.abs().max(1e-3)) / RADIUS_RATIO.ln()).round() as i32;
            *known
                .entry(2 * key + i32::from(radius < 0.0))
                .or_insert_with(|| {
                    let rounded = libm::exp(f64::from(key) * RADIUS_RATIO.ln());
                    kernels.push(Kernel::new(pupil, rounded.copysign(radius)));
                    #[expect(clippy::cast_possible_truncation, reason = "some hundreds")]
                    let place = (kernels.len() - 1) as u32;
                    place
                })
        })
        .collect();
    (kernels, kernel_of)
}

#[cfg(test)]
#[path = "layer_tests.rs"]
mod tests;
