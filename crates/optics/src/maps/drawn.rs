//! What is traced cell by cell, on the cells that suit its blur, instead of facet by facet.

use std::ops::Range;

use super::cells::Row;
use super::layer::{Layer, add_scaled};
use super::level::Level;

/// Something of one blur, as it lies in the frame.
pub(crate) trait Drawn<const L: usize> {
    /// Calls with the column of each cell of a row that it covers, and with what it sends along each lane, weighted already
    /// by the part of the cell that it covers.
    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; L]));
}

/// How far something that is drawn reaches: looked at more often than what it shows.
#[derive(Debug, Clone)]
pub(crate) struct Reaches {
    /// Signed radius of its blur, px; negative turns the pupil over.
    pub(crate) radius_px: f64,
    /// Rows of cells that it may cover; that of 0 is the first of the frame.
    pub(crate) rows: Range<i32>,
}

/// Something that is drawn, and how far it reaches.
pub(crate) type Reaching<'a, const L: usize> = (Reaches, &'a dyn Drawn<L>);

/// Cells per px of something whose blur has this radius.
pub(crate) fn cells_per_px(radius_px: f64) -> f64 {
    libm::scalbn(1.0, Level::of_drawn(radius_px).exponent)
}

/// What is drawn in a layer, row by row.
pub(super) struct Drawing<'a, const L: usize> {
    /// By the rows in which they begin, with their kernels.
    waiting: std::vec::IntoIter<(Range<i32>, &'a dyn Drawn<L>, u32)>,
    active: Vec<(Range<i32>, &'a dyn Drawn<L>, u32)>,
}

impl<'a, const L: usize> Drawing<'a, L> {
    pub(super) fn new(drawn: &[&Reaching<'a, L>], kernels: &[u32]) -> Self {
        let with_kernels = drawn.iter().zip(kernels);
        let mut waiting: Vec<_> = with_kernels
            .map(|((reaches, drawn), kernel)| (reaches.rows.clone(), *drawn, *kernel))
            .collect();
        // Stable: those of one row keep their order.
        waiting.sort_by_key(|(rows, ..)| rows.start);
        Self {
            waiting: waiting.into_iter(),
            active: Vec::new(),
        }
    }

    /// Adds what covers a row of a layer to its cells; rows are asked for in their order.
    pub(super) fn hand_on(&mut self, row: usize, layer: &Layer<L>, cells: &mut Row<L>) {
        let margin = layer.margin.cast_signed();
        let Ok(row) = i32::try_from(row.cast_signed() - margin) else {
            return;
        };
        let begins = |(rows, ..): &&(Range<i32>, &dyn Drawn<L>, u32)| rows.start <= row;
        let n = self.waiting.as_slice().iter().take_while(begins).count();
        self.active.extend(self.waiting.by_ref().take(n));
        self.active.retain(|(rows, ..)| rows.end > row);
        let shares = |lanes: &[f32; L]| lanes[..layer.n_shares].iter().sum::<f32>();
        for (_, drawn, kernel) in &self.active {
            drawn.row(row, &mut |column, lanes| {
                let column = layer.margin.checked_add_signed(column as isize);
                if let Some(column) = column.filter(|column| *column < layer.columns) {
                    let covers = shares(&lanes);
                    let cell = cells.cell(column, *kernel, covers);
                    // Of what lies over another no more than what that leaves.
                    let room = (1.0 - shares(&cell.lanes)).clamp(0.0, 1.0);
                    let part = (room / covers.max(f32::MIN_POSITIVE)).min(1.0);
                    cell.lanes = add_scaled(cell.lanes, part, lanes);
                }
            });
        }
    }
}
