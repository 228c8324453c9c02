//! Facets that reach the present rows, and how much of their cells they cover.

use std::ops::Range;

use super::cells::Row;
use super::layer::{Facet, Layer, add_scaled};
use super::level::Level;
use super::placed::Placed;
use super::raster::{Edge, cover_row};

/// Cells covered by less are not covered.
const LEAST_COVERAGE: f32 = 1e-6;

/// What the facets cover of one row of halves (or of cells, where those are not halved).
pub(super) struct Coverage {
    level: Level,
    /// Shares of the row, the sum over its facets.
    shares: Vec<f32>,
    scratch: Vec<f32>,
    runs: Vec<Run>,
    /// Those of the runs one after the other, with nothing around each where cells are halved.
    areas: Vec<f32>,
    is_over: bool,
}

/// What a facet covers of a row.
struct Run {
    /// Place among the active ones.
    facet: usize,
    /// The first that it covers, and where among the areas it begins and ends.
    first: usize,
    areas: Range<usize>,
}

/// So many halves of nothing, or one more, are around those of a facet: as far as they are shared.
const AROUND: usize = 4;

impl Coverage {
    pub(super) fn new(columns: usize, level: Level) -> Self {
        Self {
            level,
            shares: vec![0.0; columns + 3],
            scratch: vec![0.0; columns + 3],
            runs: Vec::new(),
            areas: Vec::new(),
            is_over: false,
        }
    }

    /// Finds what each facet covers of a row, and all of them.
    pub(super) fn cover<const L: usize>(&mut self, row: usize, active: &[Active<L>]) {
        self.runs.clear();
        self.areas.clear();
        self.is_over = false;
        for (k, facet) in active.iter().enumerate() {
            if facet.last <= row {
                continue;
            }
            if self.level.is_halved {
                self.areas.extend([0.0; AROUND + 1]);
            }
            let start = self.areas.len();
            let first = cover_row(&facet.edges, row, &mut self.scratch, &mut self.areas);
            let Some(first) = first else {
                continue;
            };
            let areas = start..self.areas.len();
            for (share, area) in self.shares[first..].iter_mut().zip(&self.areas[start..]) {
                *share += area * facet.weight;
                self.is_over |= *share > 1.0;
            }
            self.runs.push(Run {
                facet: k,
                first,
                areas,
            });
        }
        self.areas.extend([0.0; AROUND + 1]);
    }

    /// Shares the areas of each facet out among its cells; where facets overlap they are scaled
    /// down before.
    pub(super) fn share<const L: usize>(&mut self, row: usize, active: &mut [Active<L>]) {
        for run in &self.runs {
            let first = run.first;
            if self.is_over {
                let areas = &mut self.areas[run.areas.clone()];
                for (area, share) in areas.iter_mut().zip(&self.shares[first..]) {
                    if *share > 1.0 {
                        *area /= share;
                    }
                }
            }
            let facet = &mut active[run.facet];
            if self.level.is_halved {
                // Whole cells, from two halves before the cell before the first one's.
                let start = run.areas.start - AROUND - first % 2;
                let end = run.areas.end + AROUND + (run.areas.end - start) % 2;
                let pairs = self.areas[start..end].as_chunks().0;
                facet.add_halves(row, first / 2, pairs, self.level.weights());
            } else {
                facet.add(row, first, &self.areas[run.areas.clone()]);
            }
        }
        for run in &self.runs {
            self.shares[run.first..][..run.areas.len()].fill(0.0);
        }
    }
}

/// A facet that reaches the present rows.
pub(super) struct Active<const L: usize> {
    edges: Vec<Edge>,
    /// Row after its last one, of halves if cells are halved; and its last row of cells.
    last: usize,
    pub(super) last_row: usize,
    lanes: [f32; L],
    lean: [[f32; 2]; 2],
    /// Share of coverage.
    weight: f32,
    kernel: u32,
    /// Middle, px.
    middle: [f64; 2],
    /// First of the cells that it may cover, and how many there are.
    left: usize,
    width: usize,
    /// How much it covers of three rows of those cells, and which part of them is set.
    pub(super) slots: Vec<f32>,
    spans: [[usize; 2]; 3],
}

impl<const L: usize> Active<L> {
    pub(super) fn new(
        placed: &Placed,
        facet: &Facet<L>,
        kernel: u32,
        layer: &Layer<L>,
        mut slots: Vec<f32>,
    ) -> Self {
        let per_cell = if layer.level.is_halved { 2 } else { 1 };
        let [low, high] = placed.polygon.span(0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "columns of the grid"
        )]
        let [low, high] = [low, high].map(|x| x.max(0.0) as usize / per_cell);
        let left = low.saturating_sub(1);
        let width = (high + 3).min(layer.columns).saturating_sub(left);
        slots.clear();
        slots.resize(3 * width, 0.0);
        Self {
            edges: placed.polygon.edges().collect(),
            last: placed.last,
            last_row: placed.last.saturating_sub(1) / per_cell + per_cell - 1,
            lanes: facet.lanes,
            lean: facet.lean,
            weight: facet.lanes.iter().take(layer.n_shares).sum(),
            kernel,
            middle: std::array::from_fn(|axis| {
                facet.corners.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25
            }),
            left,
            width,
            slots,
            spans: [[usize::MAX, 0]; 3],
        }
    }

    /// Adds coverage to cells of a row from `first` on, those that are its own.
    fn add(&mut self, row: usize, first: usize, values: &[f32]) {
        let skipped = self.left.saturating_sub(first);
        let from = first + skipped - self.left;
        let n = (values.len().saturating_sub(skipped)).min(self.width.saturating_sub(from));
        if n > 0 {
            let to = &mut self.slots[row % 3 * self.width..][from..from + n];
            for (sum, value) in to.iter_mut().zip(&values[skipped..]) {
                *sum += value;
            }
            self.set(row, [from, from + n]);
        }
    }

    /// Remembers that a part of its cells of a row is set.
    fn set(&mut self, row: usize, [from, end]: [usize; 2]) {
        let span = &mut self.spans[row % 3];
        *span = [span[0].min(from), span[1].max(end)];
    }

    /// Shares the coverage of halves of a row among the nearest cells of three rows: of pairs of halves, the third of
    /// them those of the cell `first`.
    fn add_halves(
        &mut self,
        fine_row: usize,
        first: usize,
        pairs: &[[f32; 2]],
        [far, own, near]: [f32; 3],
    ) {
        let (row, is_upper) = (fine_row / 2, fine_row.is_multiple_of(2));
        let (before, after) = if is_upper { (near, far) } else { (far, near) };
        // Each pair but the first and the last gives a cell, from the one before `first` on: those that are its own.
        let skipped = (self.left + 1).saturating_sub(first);
        let from = first + skipped - 1 - self.left;
        let n = pairs.len().saturating_sub(2 + skipped);
        let n = n.min(self.width.saturating_sub(from));
        if n == 0 {
            return;
        }
        let mut parts = [0.0; 3];
        parts[row % 3] = own;
        parts[(row + 1) % 3] = after;
        self.set(row, [from, from + n]);
        self.set(row + 1, [from, from + n]);
        if let Some(row) = row.checked_sub(1) {
            parts[row % 3] = before;
            self.set(row, [from, from + n]);
        }
        let (one, others) = self.slots.split_at_mut(self.width);
        let (two, three) = others.split_at_mut(self.width);
        let sums = one[from..].iter_mut().zip(&mut two[from..]);
        let sums = sums.zip(&mut three[from..]).take(n);
        for (((one, two), three), pairs) in sums.zip(pairs[skipped..].windows(3)) {
            if let [[a, b], [c, d], [e, f]] = pairs {
                // A cell's value is the mean over its halves, here along both axes.
                let value = 0.25 * (far * (a + f) + near * (b + e) + own * (c + d));
                *one += parts[0] * value;
                *two += parts[1] * value;
                *three += parts[2] * value;
            }
        }
    }

    /// Hands what it covers of a row that is complete on to the row's cells.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "cells of a grid; px as f32"
    )]
    #[inline(always)]
    pub(super) fn hand_on(&mut self, row: usize, layer: &Layer<L>, cells: &mut Row<L>) {
        let slot = row % 3;
        let [first, end] = std::mem::replace(&mut self.spans[slot], [usize::MAX, 0]);
        if first >= end {
            return;
        }
        let place = |cell: usize| (cell as f64 + 0.5 - layer.margin as f64) / layer.scale;
        let y = (place(row) - self.middle[1]) as f32;
        let x = (place(self.left + first) - self.middle[0]) as f32;
        let step = (1.0 / layer.scale) as f32;
        let mut lanes = self.lanes;
        let mut steps = [0.0; 2];
        for (k, lean) in self.lean.iter().enumerate() {
            lanes[L - 2 + k] += lean[0] * x + lean[1] * y;
            steps[k] = lean[0] * step;
        }
        let slots = &mut self.slots[slot * self.width..][first..end];
        for (column, covered) in (self.left + first..).zip(slots) {
            let part = std::mem::take(covered);
            if part.abs() > LEAST_COVERAGE {
                let cell = cells.cell(column, self.kernel, part * self.weight);
                cell.lanes = add_scaled(cell.lanes, part, lanes);
            }
            lanes[L - 2] += steps[0];
            lanes[L - 1] += steps[1];
        }
    }
}
