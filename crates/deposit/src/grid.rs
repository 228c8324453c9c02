//! Where drops are, in cells of an area: who is near a place.

use crate::Area;

/// Drops up to these radii, mm, are kept apart from larger ones: among many small ones a few large ones would have to be
/// looked for from far away.
const UP_TO_MM: [f64; 3] = [0.25, 1.0, f64::INFINITY];

/// Sides of their cells, mm.
const CELLS_MM: [f64; 3] = [2.0, 4.0, 16.0];

/// Side of the cells by which drops are put in order, mm.
const ORDER_MM: f64 = 4.0;

/// What is looked at of a drop to tell whether it is near. Its number is that of its place among all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) at_mm: [f64; 2],
    pub(crate) radius_mm: f64,
    pub(crate) number: u32,
}

/// Drops by their size and by the cell of their middle.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    order: Cells,
    sizes: [OfSize; 3],
    /// By their numbers: each with the number of the next in its cell, plus one; 0 after the last one.
    drops: Vec<(Known, u32)>,
}

/// Drops of some size.
#[derive(Debug, Clone)]
struct OfSize {
    cells: Cells,
    /// Number of the first drop in each cell, plus one; 0 in empty ones. Most are looked at in vain: all are close by.
    first: Vec<u32>,
    /// No radius was larger as yet, mm.
    largest_mm: f64,
}

/// An area in cells.
#[derive(Debug, Clone)]
struct Cells {
    from_mm: [f64; 2],
    /// Powers of two, as the sides.
    per_mm: f64,
    n: [usize; 2],
}

impl Cells {
    fn over(area: &Area, side_mm: f64) -> Self {
        Self {
            from_mm: area.from_mm,
            per_mm: 1.0 / side_mm,
            n: area.cells(side_mm),
        }
    }

    /// The cell of a coordinate; beyond the area that of its border.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a pane"
    )]
    fn along(&self, axis: usize, mm: f64) -> usize {
        let cell = ((mm - self.from_mm[axis]) * self.per_mm).max(0.0) as usize;
        cell.min(self.n[axis] - 1)
    }

    /// Columns one after the other, for drops run up and down.
    fn of(&self, at_mm: [f64; 2]) -> usize {
        self.along(0, at_mm[0]) * self.n[1] + self.along(1, at_mm[1])
    }
}

impl Grid {
    pub(crate) fn over(area: &Area) -> Self {
        Self {
            order: Cells::over(area, ORDER_MM),
            sizes: CELLS_MM.map(|side_mm| {
                let cells = Cells::over(area, side_mm);
                OfSize {
                    first: vec![0; cells.n[0] * cells.n[1]],
                    cells,
                    largest_mm: 0.0,
                }
            }),
            drops: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, drop: Known) {
        let size = &mut self.sizes[size_of(drop.radius_mm)];
        size.largest_mm = size.largest_mm.max(drop.radius_mm);
        let first = &mut size.first[size.cells.of(drop.at_mm)];
        let place = drop.number as usize;
        if place >= self.drops.len() {
            self.drops.resize(place + 1, (drop, 0));
        }
        self.drops[place] = (drop, *first);
        *first = drop.number + 1;
    }

    pub(crate) fn remove(&mut self, drop: &Known) {
        let size = &mut self.sizes[size_of(drop.radius_mm)];
        let first = &mut size.first[size.cells.of(drop.at_mm)];
        let (_, after) = self.drops[drop.number as usize];
        if *first == drop.number + 1 {
            *first = after;
            return;
        }
        let mut next = *first;
        while let Some(place) = next.checked_sub(1) {
            let (_, following) = &mut self.drops[place as usize];
            if *following == drop.number + 1 {
                *following = after;
                return;
            }
            next = *following;
        }
    }

    /// The cell by which a drop is put in order, those of a row one after the other.
    pub(crate) fn order(&self, at_mm: [f64; 2]) -> usize {
        let Cells { n, .. } = self.order;
        self.order.along(1, at_mm[1]) * n[0] + self.order.along(0, at_mm[0])
    }

    /// Calls with all drops that reach to within a distance of a rectangle, and with some others.
    pub(crate) fn each_near(
        &self,
        (from_mm, to_mm): ([f64; 2], [f64; 2]),
        within_mm: f64,
        mut call: impl FnMut(&Known),
    ) {
        for OfSize {
            cells,
            first,
            largest_mm,
        } in &self.sizes
        {
            if *largest_mm <= 0.0 {
                continue;
            }
            let reach = within_mm + largest_mm;
            let [left, right] = [from_mm[0] - reach, to_mm[0] + reach].map(|x| cells.along(0, x));
            let [top, bottom] = [from_mm[1] - reach, to_mm[1] + reach].map(|y| cells.along(1, y));
            for x in left..=right {
                let column = x * cells.n[1];
                for first in &first[column + top..=column + bottom] {
                    let mut next = *first;
                    while let Some(place) = next.checked_sub(1) {
                        let (known, after) = &self.drops[place as usize];
                        call(known);
                        next = *after;
                    }
                }
            }
        }
    }
}

/// The place of a radius among the sizes.
fn size_of(radius_mm: f64) -> usize {
    let smaller = UP_TO_MM.iter().take_while(|up_to| radius_mm > **up_to);
    smaller.count().min(UP_TO_MM.len() - 1)
}
