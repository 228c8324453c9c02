//! Facets that reach the present rows, and how much of their cells they cover.

use super::cells::Row;
use super::layer::{Facet, Layer, add_scaled};
use super::level::Level;
use super::placed::Placed;
use super::raster::{Edge, cover_row};

/// Cells covered by less are not covered.
const LEAST_COVERAGE: f32 = 1e-6;

/// What the facets cover of one row of halves (or of cells, where those are not halved).
pub(super) struct Coverage {
    /// Shares of the row, the sum over its facets.
    shares: Vec<f32>,
    scratch: Vec<f32>,
    /// For each facet that covers something of the row its place among the active ones, the first
    /// cell, and where its areas end in `areas`.
    runs: Vec<(usize, usize, usize)>,
    areas: Vec<f32>,
    is_over: bool,
    halves: Vec<f32>,
}

impl Coverage {
    pub(super) fn new(columns: usize) -> Self {
        Self {
            shares: vec![0.0; columns + 3],
            scratch: vec![0.0; columns + 3],
            runs: Vec::new(),
            areas: Vec::new(),
            is_over: false,
            halves: Vec::new(),
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
            cover_row(&facet.edges, row, &mut self.scratch, |first, areas| {
                self.areas.extend_from_slice(areas);
                self.runs.push((k, first, self.areas.len()));
                for (share, area) in self.shares[first..].iter_mut().zip(areas) {
                    *share += area * facet.weight;
                    self.is_over |= *share > 1.0;
                }
            });
        }
    }

    /// Shares the areas of each facet out among its cells; where facets overlap they are scaled
    /// down before.
    pub(super) fn share<const L: usize>(
        &mut self,
        row: usize,
        level: Level,
        active: &mut [Active<L>],
    ) {
        let mut start = 0;
        for &(facet, first, end) in &self.runs {
            let areas = &mut self.areas[start..end];
            start = end;
            if self.is_over {
                for (area, share) in areas.iter_mut().zip(&self.shares[first..]) {
                    if *share > 1.0 {
                        *area /= share;
                    }
                }
            }
            if level.is_halved {
                active[facet].add_halves(row, first, areas, level.weights(), &mut self.halves);
            } else {
                active[facet].add(row, first, areas, 1.0);
            }
        }
        let mut start = 0;
        for &(_, first, end) in &self.runs {
            self.shares[first..first + end - start].fill(0.0);
            start = end;
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
    fn add(&mut self, row: usize, first: usize, values: &[f32], part: f32) {
        let slot = row % 3;
        let skipped = self.left.saturating_sub(first);
        let (Some(values), from) = (values.get(skipped..), (first + skipped) - self.left) else {
            return;
        };
        let Some(to) = self.slots[slot * self.width..][..self.width].get_mut(from..) else {
            return;
        };
        let n = values.len().min(to.len());
        for (sum, value) in to.iter_mut().zip(values) {
            *sum += part * value;
        }
        let span = &mut self.spans[slot];
        *span = [span[0].min(from), span[1].max(from + n)];
    }

    /// Shares the coverage of halves of a row among the nearest cells of three rows.
    fn add_halves(
        &mut self,
        fine_row: usize,
        first: usize,
        areas: &[f32],
        [far, own, near]: [f32; 3],
        halves: &mut Vec<f32>,
    ) {
        // From two halves before the cell before the first one's.
        halves.clear();
        halves.resize(4 + first % 2, 0.0);
        halves.extend_from_slice(areas);
        halves.resize(halves.len() + 4 + halves.len() % 2, 0.0);
        let n = (halves.len() - 4) / 2;
        for k in 0..n {
            if let &[a, b, c, d, e, f] = &halves[2 * k..2 * k + 6] {
                // A cell's value is the mean over its halves, here along both axes.
                halves[k] = 0.25 * (far * (a + f) + near * (b + e) + own * (c + d));
            }
        }
        let (row, is_upper) = (fine_row / 2, fine_row.is_multiple_of(2));
        let (before, after) = if is_upper { (near, far) } else { (far, near) };
        // The first of them may lie before the first cell.
        let skipped = usize::from(first < 2);
        let (values, column) = (&halves[skipped..n], first / 2 + skipped - 1);
        if let Some(row) = row.checked_sub(1) {
            self.add(row, column, values, before);
        }
        self.add(row, column, values, own);
        self.add(row + 1, column, values, after);
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
