//! Numbers in square cells of an area.

use std::ops::Range;

use crate::Area;

/// Most cells of an area: larger ones are taken where there would be more.
const MOST_CELLS: f64 = 4e6;

/// Values in square cells of an area, in rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Raster<T = f32> {
    from_mm: [f64; 2],
    pub(crate) cell_mm: f64,
    pub(crate) size: [usize; 2],
    pub(crate) values: Vec<T>,
    /// Cells of each row whose middle is in the area.
    pub(crate) across: Vec<Range<usize>>,
}

impl<T: Copy> Raster<T> {
    /// Of one value in cells of a width, mm, or wider ones where those would be too many.
    pub(crate) fn over(area: &Area, cell_mm: f64, value: T) -> Self {
        let least_mm = (area.rectangle_m2() * 1e6 / MOST_CELLS).sqrt();
        let cell_mm = cell_mm.max(least_mm).max(1e-3);
        let size = area.cells(cell_mm);
        let mut raster = Self {
            from_mm: area.from_mm,
            cell_mm,
            size,
            values: vec![value; size[0] * size[1]],
            across: Vec::new(),
        };
        raster.across = (0..size[1])
            .map(|y| raster.columns(area.across_mm(raster.middle_mm(0, y)[1])))
            .collect();
        raster
    }

    /// The cells of a row whose middles lie between places, mm.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a pane; below 0 is 0"
    )]
    fn columns(&self, ends_mm: [f64; 2]) -> Range<usize> {
        let ends = ends_mm.map(|mm| {
            let [cells, _] = self.in_cells([mm, self.from_mm[1]]);
            ((cells - 0.5).ceil().max(0.0) as usize).min(self.size[0])
        });
        ends[0]..ends[1].max(ends[0])
    }

    /// How many cells have their middle in the area.
    pub(crate) fn n_across(&self) -> usize {
        self.across.iter().map(Range::len).sum()
    }

    /// Of some columns those of a row that are in the area.
    pub(crate) fn within(&self, columns: &Range<usize>, row: usize) -> Range<usize> {
        let across = &self.across[row];
        let first = columns.start.max(across.start);
        first..columns.end.min(across.end).max(first)
    }

    /// A place in cells, the middle of the first at 0.5.
    pub(crate) fn in_cells(&self, at_mm: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (at_mm[k] - self.from_mm[k]) / self.cell_mm)
    }

    /// The middle of a cell, mm.
    #[expect(clippy::cast_precision_loss, reason = "cells of a pane")]
    pub(crate) fn middle_mm(&self, x: usize, y: usize) -> [f64; 2] {
        [
            self.from_mm[0] + (x as f64 + 0.5) * self.cell_mm,
            self.from_mm[1] + (y as f64 + 0.5) * self.cell_mm,
        ]
    }

    /// The cell of a place, where there is one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a pane"
    )]
    pub(crate) fn cell(&self, at_mm: [f64; 2]) -> Option<usize> {
        let [x, y] = self.in_cells(at_mm);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.size[0] as f64 && y < self.size[1] as f64;
        is_inside.then(|| y as usize * self.size[0] + x as usize)
    }

    /// Columns and rows of cells that a disc may reach.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a pane; below 0 is 0"
    )]
    pub(crate) fn around(&self, at_mm: [f64; 2], radius_mm: f64) -> [Range<usize>; 2] {
        let at = self.in_cells(at_mm);
        let radius = radius_mm / self.cell_mm;
        [0, 1].map(|k| {
            // What is not negative is rounded down as it becomes whole.
            let from = (at[k] - radius).max(0.0) as usize;
            let to = (at[k] + radius).max(0.0);
            let to = (to as usize).saturating_add(usize::from(to > to as usize as f64));
            from.min(self.size[k])..to.min(self.size[k])
        })
    }

    /// A raster of a number for each cell.
    pub(crate) fn map(&self, of: impl FnMut(&T) -> f32) -> Raster {
        Raster {
            from_mm: self.from_mm,
            cell_mm: self.cell_mm,
            size: self.size,
            values: self.values.iter().map(of).collect(),
            across: self.across.clone(),
        }
    }
}

impl Raster {
    /// The value at a place, on straight lines between the middles of cells; beyond the area that of its border.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a pane"
    )]
    pub(crate) fn at(&self, at_mm: [f64; 2]) -> f64 {
        let at = self.in_cells(at_mm);
        let [(left, right, s), (top, bottom, t)] = [0, 1].map(|k| {
            let place = (at[k] - 0.5).clamp(0.0, (self.size[k] - 1) as f64);
            let whole = place as usize;
            (
                whole,
                (whole + 1).min(self.size[k] - 1),
                place - whole as f64,
            )
        });
        let value = |x: usize, y: usize| f64::from(self.values[y * self.size[0] + x]);
        let high = value(left, top) + s * (value(right, top) - value(left, top));
        let low = value(left, bottom) + s * (value(right, bottom) - value(left, bottom));
        high + t * (low - high)
    }
}
