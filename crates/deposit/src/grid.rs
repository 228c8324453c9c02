//! Where drops are, in cells of an area: who is near a place.

use crate::Area;

/// Drops up to this radius, mm, are kept apart from larger ones: among many small ones a few large ones would have to be
/// looked for from far away.
const SMALL_MM: f64 = 1.0;

/// Sides of the cells of small ones, of large ones, and of those that run, mm: these are few, and may be far from where they
/// began.
const CELLS_MM: [f64; 3] = [4.0, 16.0, 16.0];
const SMALL: usize = 0;
const LARGE: usize = 1;
const RUN: usize = 2;

/// Side of the cells by which drops are put in order, mm.
const ORDER_MM: f64 = 4.0;

/// A place of a pane that is kept in single precision is off by less, mm.
const OFF_MM: f32 = 0.01;

/// A drop that is put into a grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) at_mm: [f64; 2],
    pub(crate) radius_mm: f64,
    /// How far it may have gone up or down by now, mm; 0 where it holds.
    pub(crate) goes_mm: f64,
    pub(crate) number: u32,
}

/// Drops by their kind and by the cell of their middle.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    order: Cells,
    kinds: [OfKind; 3],
    handfuls: Vec<Handful>,
    /// Those that hold nothing.
    free: Vec<u32>,
}

/// What is kept of a drop to tell whether it may be near: most are looked at in vain, and memory is what that takes.
#[derive(Debug, Clone, Copy)]
struct Kept {
    at_mm: [f32; 2],
    reaches_mm: f32,
    number: u32,
}

/// Most drops that lie side by side in memory.
const HANDFUL: usize = 3;

/// Some drops of a cell, in one line of a processor's cache. Only in a cell's first handful is there room.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Handful {
    drops: [Kept; HANDFUL],
    n: u32,
    /// Place of the next of the cell, plus one; 0 after the last one.
    next: u32,
}

/// Drops of some kind.
#[derive(Debug, Clone)]
struct OfKind {
    cells: Cells,
    /// Place of the first handful of each cell, plus one; 0 of empty ones.
    first: Vec<u32>,
    /// None reached farther as yet, mm.
    farthest_mm: f64,
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
            kinds: CELLS_MM.map(|side_mm| {
                let cells = Cells::over(area, side_mm);
                OfKind {
                    first: vec![0; cells.n[0] * cells.n[1]],
                    cells,
                    farthest_mm: 0.0,
                }
            }),
            handfuls: Vec::new(),
            free: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, drop: Known) {
        let kind = &mut self.kinds[drop.kind()];
        kind.farthest_mm = kind.farthest_mm.max(drop.radius_mm + drop.goes_mm);
        let first = &mut kind.first[kind.cells.of(drop.at_mm)];
        if let Some(place) = first.checked_sub(1) {
            let handful = &mut self.handfuls[place as usize];
            if let Some(room) = handful.drops.get_mut(handful.n as usize) {
                *room = drop.kept();
                handful.n += 1;
                return;
            }
        }
        let handful = Handful {
            drops: [drop.kept(); HANDFUL],
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
        let kind = &mut self.kinds[drop.kind()];
        let first = &mut kind.first[kind.cells.of(drop.at_mm)];
        let Some(head) = first.checked_sub(1) else {
            return;
        };
        let found = places(&self.handfuls, *first).find_map(|place| {
            let mut drops = self.handfuls[place].drops().iter();
            let k = drops.position(|kept| kept.number == drop.number)?;
            Some((place, k))
        });
        let Some((place, k)) = found else {
            return;
        };
        // The last of the first handful takes its place.
        let handful = &mut self.handfuls[head as usize];
        handful.n -= 1;
        let (last, n, next) = (handful.drops[handful.n as usize], handful.n, handful.next);
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

    /// Calls with the numbers of all drops that reach to within a distance of a rectangle, and of some others.
    pub(crate) fn each_near(
        &self,
        place: ([f64; 2], [f64; 2]),
        within_mm: f64,
        mut call: impl FnMut(u32),
    ) {
        for kind in &self.kinds {
            kind.each_near(place, within_mm, &self.handfuls, &mut call);
        }
    }

    /// The same, but only for those that run.
    pub(crate) fn each_running_near(
        &self,
        place: ([f64; 2], [f64; 2]),
        within_mm: f64,
        call: impl FnMut(u32),
    ) {
        self.kinds[RUN].each_near(place, within_mm, &self.handfuls, call);
    }
}

impl OfKind {
    fn each_near(
        &self,
        (from_mm, to_mm): ([f64; 2], [f64; 2]),
        within_mm: f64,
        handfuls: &[Handful],
        mut call: impl FnMut(u32),
    ) {
        let Self {
            cells,
            first,
            farthest_mm,
        } = self;
        if *farthest_mm <= 0.0 {
            return;
        }
        let reach = within_mm + farthest_mm;
        let [left, right] = [from_mm[0] - reach, to_mm[0] + reach].map(|x| cells.along(0, x));
        let [top, bottom] = [from_mm[1] - reach, to_mm[1] + reach].map(|y| cells.along(1, y));
        let [from, to] = [from_mm, to_mm].map(|mm| mm.map(short));
        let within = short(within_mm);
        for x in left..=right {
            let column = x * cells.n[1];
            for first in &first[column + top..=column + bottom] {
                for place in places(handfuls, *first) {
                    for kept in handfuls[place].drops() {
                        let [x, y] = kept.at_mm;
                        let dx = x - x.max(from[0]).min(to[0]);
                        let dy = y - y.max(from[1]).min(to[1]);
                        let sum = within + kept.reaches_mm + OFF_MM;
                        if dx * dx + dy * dy < sum * sum {
                            call(kept.number);
                        }
                    }
                }
            }
        }
    }
}

impl Known {
    fn kind(&self) -> usize {
        if self.goes_mm > 0.0 {
            RUN
        } else if self.radius_mm > SMALL_MM {
            LARGE
        } else {
            SMALL
        }
    }

    fn kept(&self) -> Kept {
        Kept {
            at_mm: self.at_mm.map(short),
            reaches_mm: short(self.radius_mm + self.goes_mm),
            number: self.number,
        }
    }
}

impl Handful {
    fn drops(&self) -> &[Kept] {
        self.drops.get(..self.n as usize).unwrap_or_default()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "mm of a pane")]
fn short(mm: f64) -> f32 {
    mm as f32
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
            libm::hypot(dx, dy) < drop.radius_mm + drop.goes_mm + 3.0
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
            goes_mm: if number.is_multiple_of(9) { 4.0 } else { 0.0 },
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
            grid.each_near((at_mm, at_mm), 3.0, |number| {
                found.extend(all.iter().find(|drop| drop.number == number));
            });
            let found = near(&found, at_mm);
            assert_eq!(found, near(&all, at_mm), "step {step}, about {at_mm:?}");
        }
    }
}
