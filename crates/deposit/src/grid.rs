//! Where drops are, in cells of an area: who is near a place.

use crate::Area;

/// Drops up to these radii, mm, are kept apart from larger ones: among many small ones a few large ones would have to be
/// looked for from far away.
const UP_TO_MM: [f64; 3] = [0.25, 1.0, f64::INFINITY];

/// Sides of their cells, mm.
const CELLS_MM: [f64; 3] = [2.0, 4.0, 16.0];

/// Side of the cells by which drops are put in order, mm.
const ORDER_MM: f64 = 4.0;

/// What is looked at of a drop to tell whether it is near.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) at_mm: [f64; 2],
    pub(crate) radius_mm: f64,
    pub(crate) number: u32,
    /// Whether it may be farther on by now.
    pub(crate) runs: bool,
}

/// Drops by their size and by the cell of their middle.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    order: Cells,
    sizes: [OfSize; 3],
    handfuls: Vec<Handful>,
    /// Those that hold nothing.
    free: Vec<u32>,
}

/// Most drops that lie side by side in memory.
const HANDFUL: usize = 4;

/// Some drops of a cell. Only in its first handful is there room.
#[derive(Debug, Clone)]
struct Handful {
    drops: [Known; HANDFUL],
    n: usize,
    /// Place of the next of the cell, plus one; 0 after the last one.
    next: u32,
}

/// Drops of some size.
#[derive(Debug, Clone)]
struct OfSize {
    cells: Cells,
    /// Place of the first handful of each cell, plus one; 0 of empty ones. Most are looked at in vain: all are close by.
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
            handfuls: Vec::new(),
            free: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, drop: Known) {
        let size = &mut self.sizes[size_of(drop.radius_mm)];
        size.largest_mm = size.largest_mm.max(drop.radius_mm);
        let first = &mut size.first[size.cells.of(drop.at_mm)];
        if let Some(place) = first.checked_sub(1) {
            let handful = &mut self.handfuls[place as usize];
            if handful.n < HANDFUL {
                handful.drops[handful.n] = drop;
                handful.n += 1;
                return;
            }
        }
        let handful = Handful {
            drops: [drop; HANDFUL],
            n: 1,
            next: *first,
        };
        *first = match self.free.pop() {
            Some(place) => {
                self.handfuls[place as usize] = handful;
                place + 1
            }
            None => {
                self.handfuls.push(handful);
                u32::try_from(self.handfuls.len()).unwrap_or(u32::MAX)
            }
        };
    }

    pub(crate) fn remove(&mut self, drop: &Known) {
        let size = &mut self.sizes[size_of(drop.radius_mm)];
        let first = &mut size.first[size.cells.of(drop.at_mm)];
        let Some(head) = first.checked_sub(1) else {
            return;
        };
        let found = places(&self.handfuls, *first).find_map(|place| {
            let handful = &self.handfuls[place];
            let mut drops = handful.drops[..handful.n].iter();
            let k = drops.position(|known| known.number == drop.number)?;
            Some((place, k))
        });
        let Some((place, k)) = found else {
            return;
        };
        // The last of the first handful takes its place.
        let handful = &mut self.handfuls[head as usize];
        handful.n -= 1;
        let (last, n, next) = (handful.drops[handful.n], handful.n, handful.next);
        self.handfuls[place].drops[k] = last;
        if n == 0 {
            *first = next;
            self.free.push(head);
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
                    for place in places(&self.handfuls, *first) {
                        let handful = &self.handfuls[place];
                        handful.drops[..handful.n].iter().for_each(&mut call);
                    }
                }
            }
        }
    }
}

/// Places of the handfuls of a cell, by that of the first, plus one.
fn places(handfuls: &[Handful], first: u32) -> impl Iterator<Item = usize> {
    let mut next = first;
    std::iter::from_fn(move || {
        let place = next.checked_sub(1)? as usize;
        next = handfuls[place].next;
        Some(place)
    })
}

/// The place of a radius among the sizes.
fn size_of(radius_mm: f64) -> usize {
    let smaller = UP_TO_MM.iter().take_while(|up_to| radius_mm > **up_to);
    smaller.count().min(UP_TO_MM.len() - 1)
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::Rng as _;
    use starbreak_seed::{Seed, Stream, uniform};

    use super::*;

    /// The numbers of all drops that reach to within 3 mm of a place, found by looking at every one.
    fn near(all: &[Known], at_mm: [f64; 2]) -> Vec<u32> {
        let is_near = |drop: &&Known| {
            let [dx, dy] = [0, 1].map(|k| drop.at_mm[k] - at_mm[k]);
            libm::hypot(dx, dy) < drop.radius_mm + 3.0
        };
        let mut near: Vec<u32> = all.iter().filter(is_near).map(|it| it.number).collect();
        near.sort_unstable();
        near
    }

    fn drawn(rng: &mut ChaCha8Rng, number: u32) -> Known {
        let [u, v, w] = [uniform(rng), uniform(rng), uniform(rng)];
        Known {
            // Many in one corner.
            at_mm: [40.0 * u * u, 30.0 * v * v],
            radius_mm: 0.1 + 3.0 * w * w * w,
            number,
            runs: false,
        }
    }

    #[test]
    fn who_is_near_is_found_among_drops_that_come_and_go() {
        let area = Area::rectangle([0.0; 2], [40.0, 30.0]);
        let (mut grid, mut all) = (Grid::over(&area), Vec::new());
        let mut rng = Seed(5).stream(Stream::Rain, 0);
        for step in 0..3000_u32 {
            let goes = uniform(&mut rng) < if step < 1500 { 0.3 } else { 0.7 };
            if goes && !all.is_empty() {
                let place = rng.next_u32() as usize % all.len();
                grid.remove(&all.swap_remove(place));
            } else {
                let drop = drawn(&mut rng, step);
                grid.add(drop);
                all.push(drop);
            }
            let at_mm = drawn(&mut rng, 0).at_mm;
            let mut found = Vec::new();
            grid.each_near((at_mm, at_mm), 3.0, |drop| found.push(*drop));
            let found = near(&found, at_mm);
            assert_eq!(found, near(&all, at_mm), "step {step}, about {at_mm:?}");
        }
    }
}
