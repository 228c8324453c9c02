//! Where drops are, in cells of an area: who is near a place.

use crate::Area;

/// Side of a cell, mm.
const CELL_MM: f64 = 4.0;

/// Numbers of drops by the cell of their middle.
#[derive(Debug)]
pub(crate) struct Grid {
    from_mm: [f64; 2],
    size: [usize; 2],
    cells: Vec<Vec<u32>>,
}

impl Grid {
    pub(crate) fn over(area: &Area) -> Self {
        let size = area.cells(CELL_MM);
        Self {
            from_mm: area.from_mm,
            size,
            cells: vec![Vec::new(); size[0] * size[1]],
        }
    }

    /// The cell of a coordinate; beyond the area that of its border.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a pane"
    )]
    fn along(&self, axis: usize, mm: f64) -> usize {
        let cell = ((mm - self.from_mm[axis]) / CELL_MM).max(0.0) as usize;
        cell.min(self.size[axis] - 1)
    }

    fn cell_of(&self, at_mm: [f64; 2]) -> usize {
        self.along(1, at_mm[1]) * self.size[0] + self.along(0, at_mm[0])
    }

    pub(crate) fn add(&mut self, at_mm: [f64; 2], drop: u32) {
        let cell = self.cell_of(at_mm);
        self.cells[cell].push(drop);
    }

    pub(crate) fn remove(&mut self, at_mm: [f64; 2], drop: u32) {
        let cell = self.cell_of(at_mm);
        self.cells[cell].retain(|known| *known != drop);
    }

    /// Calls with all drops whose middles lie in the cells of a rectangle.
    pub(crate) fn each_in(&self, from_mm: [f64; 2], to_mm: [f64; 2], mut call: impl FnMut(u32)) {
        for y in self.along(1, from_mm[1])..=self.along(1, to_mm[1]) {
            for x in self.along(0, from_mm[0])..=self.along(0, to_mm[0]) {
                self.cells[y * self.size[0] + x]
                    .iter()
                    .for_each(|drop| call(*drop));
            }
        }
    }
}
