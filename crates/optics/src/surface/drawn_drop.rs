//! Drops cell by cell.

use std::f64::consts::PI;
use std::ops::Range;

use starbreak_deposit::RoundPlace;

use super::drops::{Drop, RIM};
use super::lobe::LANES;
use super::rays::{MOST, Rays, Seen};
use super::seen_at::{Extent, SeenAt, least_radius, straight};
use super::water::Sight;
use crate::maps::{Drawn, Reaches, add_arrays};
use crate::number::Number;

/// Least radius of a drop along its shorter side, in rays: where cells are wider, several rays share one, so many along a
/// side at most. A drop that is seen at a grazing angle has more of them one below the other than side by side.
const LEAST_RAYS: f64 = 0.75;
const MOST_OF_CELL: u32 = 64;

/// Radius along its shorter side, in rays, up to which they are so few that where they lie makes a drop larger or smaller,
/// and most rays that are looked at for that.
const UNEVEN_RAYS: f64 = 3.0;
const MOST_EVENED: usize = 4096;

/// The same from which on rays at the rim look at the middle of what they stand for.
const MANY_RAYS: f64 = 6.0;

/// Blur, px, from which on a share below 0 at one side of a small drop is made up for by the other, and no lines are seen
/// in it.
pub(super) const SOFT_PX: f64 = 1.0;

/// Greatest radius along the longer side, of the focal length, of a drop across which places and directions change evenly.
const NARROW: f64 = 0.006;

/// How much farther than its outline a drop reaches: beyond the sides between the directions by which that is known.
const BEYOND: f64 = 1.1;

/// No drop reaches farther from its middle, of its radius.
const FARTHEST: f64 = 2.0;

/// A drop that is drawn cell by cell, by one ray or several in each.
pub(crate) struct DrawnDrop<'a> {
    pub(super) drop: Drop<'a>,
    blur_px: f64,
    /// Rays of a cell side by side and one below the other, and per px.
    of_cell: [u32; 2],
    rays_per_px: [f64; 2],
    /// Rays that may meet it.
    columns: Range<i32>,
    rows: Range<i32>,
    /// Its middle, in rays.
    middle: [f64; 2],
    /// Change of the place on the pane, of its radius, per ray along x and along y, and how far from the middle, by that
    /// alone, a ray may meet it.
    per_ray: [[f64; 2]; 2],
    reach: f64,
    /// Level up to which a ray looks at its own place, and all of what it stands for is the drop.
    whole_within: f64,
    /// Weight of a ray that stands for all of its place: of a cell, and so that few rays are as large as the drop.
    share: f64,
    /// Of one that is seen under a small angle.
    narrow: Option<Narrow>,
}

/// A drop that is seen under so small an angle that places and directions change evenly across it.
struct Narrow {
    /// To its middle.
    sight: Sight,
    /// Change of its direction per ray along x and along y.
    per_ray: [[f64; 2]; 2],
}

impl<'a> DrawnDrop<'a> {
    /// As far as it lies in the frame, or its blur by a pupil that reaches so many of its radii from its middle reaches into
    /// it; none elsewhere.
    pub(super) fn of(drop: Drop<'a>, seen: &SeenAt, pupil_reach: f64) -> Option<Self> {
        let sheet = drop.water.from.sheet;
        let blur_px = seen.blur_px;
        let beyond_px = blur_px.abs() * pupil_reach + 2.0 / seen.cells_per_px;
        let uneven = drop.cap.outline.reach();
        let extent = Extent::of(&drop, seen, BEYOND * uneven);
        let of_cell = rays_of_cell(seen);
        let rays_per_px = of_cell.map(|n| f64::from(n) * seen.cells_per_px);
        // Half a ray beyond its outline is still among what a ray stands for.
        let rays = |axis: usize, [low, high]: [f64; 2]| {
            let [low, high] = [low, high].map(|px| px * rays_per_px[axis]);
            let [low, high] = [low - 0.5, high + 0.5];
            #[expect(clippy::cast_possible_truncation, reason = "`as` clamps")]
            let rays = (low.floor() as i32)..(high.ceil() as i32);
            rays
        };
        let [across_px, down_px] = extent.spans_px;
        let (columns, rows) = (rays(0, across_px), rays(1, down_px));
        let (width, height) = sheet.view().size();
        let within_frame = |all: &Range<i32>, axis: usize, side_px: f64| {
            let most = rays(axis, [-beyond_px, side_px + beyond_px]);
            all.start.max(most.start)..all.end.min(most.end)
        };
        // Nothing is seen below a dashboard.
        let [_, last] = sheet.view().dashboard().ends();
        let within = [
            within_frame(&columns, 0, f64::from(width)),
            within_frame(&rows, 1, last * f64::from(height)),
        ];
        if within.iter().any(Range::is_empty) {
            return None;
        }
        let per_ray = |per_px: [[f64; 2]; 2]| {
            [0, 1].map(|axis| per_px[axis].map(|part| part / rays_per_px[axis]))
        };
        let radius = least_radius(per_ray(seen.places_per_px));
        let narrow = (extent.widest_px < BEYOND * NARROW * sheet.f_px()).then(|| Narrow {
            sight: drop.water.sight(seen.sight),
            per_ray: per_ray(seen.turns_per_px),
        });
        let mut drawn = Self {
            middle: [0, 1].map(|axis| rays_per_px[axis] * seen.at_px[axis]),
            per_ray: per_ray(seen.places_per_px),
            // With half a ray.
            reach: extent.reach + 0.5 / radius,
            whole_within: whole_within(1.0 / radius),
            share: 1.0 / f64::from(of_cell[0] * of_cell[1]),
            narrow,
            drop,
            blur_px,
            of_cell,
            rays_per_px,
            columns,
            rows,
        };
        drawn.even_out();
        [drawn.columns, drawn.rows] = within;
        Some(drawn)
    }

    pub(super) fn reaches(&self) -> Reaches {
        Reaches {
            radius_px: self.blur_px,
            rows: self.cells(1, &self.rows),
        }
    }

    /// Makes few rays together as large as the drop, wherever they lie.
    fn even_out(&mut self) {
        let rays = [&self.rows, &self.columns].map(ExactSizeIterator::len);
        if least_radius(self.per_ray) >= UNEVEN_RAYS
            || rays[0].saturating_mul(rays[1]) > MOST_EVENED
        {
            return;
        }
        let mut parts = 0.0;
        for y in self.rows.clone() {
            for x in self.across(y) {
                let offset = self.offset([x, y].map(f64::from));
                let place = straight(&self.per_ray, offset);
                parts += self.within_reach(place, self.part(offset, place).0);
            }
        }
        let [[a, b], [c, d]] = self.per_ray;
        // Of a drop that no ray meets nothing is shown.
        let parts = parts.max(1e-3);
        self.share *= PI / (a * d - b * c).abs() / parts;
    }

    /// Columns of a row of rays, or some more, that meet the drop as far as places change evenly.
    fn across(&self, row: i32) -> Range<i32> {
        let [[a, b], along_y] = self.per_ray;
        let [_, down] = self.offset([0.0, f64::from(row)]);
        let [x, y] = along_y.map(|part| down * part);
        // Where t (a, b) + (x, y) is so far from the middle.
        let (square, half) = (a * a + b * b, a * x + b * y);
        let root = half * half - square * (x * x + y * y - self.reach * self.reach);
        let root = root.max(0.0).sqrt();
        #[expect(clippy::cast_possible_truncation, reason = "`as` clamps")]
        let [first, end] = [-root, root].map(|root| {
            let column = (root - half) / square + self.middle[0] - 0.5;
            if root < 0.0 {
                column.floor() as i32
            } else {
                column.ceil() as i32
            }
        });
        let first = first.max(self.columns.start);
        first..end.saturating_add(1).min(self.columns.end).max(first)
    }

    /// A share of rays, if the place that they look at may be in the drop as far as places change evenly; else nothing.
    #[inline(always)]
    fn within_reach<N: Number>(&self, [x, y]: [N; 2], share: N) -> N {
        let square = x * x + y * y;
        square.below(x.all(self.reach * self.reach), [share, x.all(0.0)])
    }

    /// From the middle of the drop to a ray, in rays.
    #[inline(always)]
    fn offset<N: Number>(&self, at: [N; 2]) -> [N; 2] {
        [0, 1].map(|k| at[k] + at[k].all(0.5) - at[k].all(self.middle[k]))
    }

    /// How much of its cell a ray stands for that looks at a place, and where that is on a round drop.
    #[inline(always)]
    fn part<N: Number>(&self, offset: [N; 2], place: [N; 2]) -> (N, RoundPlace<N>) {
        let all = |value: f64| offset[0].all(value);
        let RoundPlace { level, slope } = self.drop.cap.outline.round_places(place, all);
        let level = level.at_least(0.0);
        let whole = (all(1.0), RoundPlace { level, slope });
        if level.are_below(self.whole_within) {
            return whole;
        }
        let rim = self.at_rim(offset, &whole.1);
        let either = |two: [N; 2]| level.below(all(self.whole_within), two);
        let place = RoundPlace {
            level: either([level, rim.1.level]),
            slope: [0, 1].map(|k| either([slope[k], rim.1.slope[k]])),
        };
        (either([whole.0, rim.0]), place)
    }

    /// The same of a ray that may stand for a part of the drop alone.
    #[inline(always)]
    fn at_rim<N: Number>(
        &self,
        [right, down]: [N; 2],
        RoundPlace { level, slope }: &RoundPlace<N>,
    ) -> (N, RoundPlace<N>) {
        let within = |number: N| number.at_least(0.0).at_most(1.0);
        let away = level.sqrt().at_least(1e-9);
        let [x, y] = slope.map(|part| part / away);
        // The rim is as many rays away as it takes to come there by the fastest way. Over all places that the rays may have,
        // this covers π (ρ² + 1/12) of a circle of ρ rays, hence the smaller one.
        let [x, y] = self.per_ray.map(|[a, b]| x.times(a) + y.times(b));
        let square = x * x + y * y;
        let of_ray = square.sqrt();
        let rim = (square / square.all(12.0)).less_from(1.0);
        let rim = rim.at_least(0.0).sqrt();
        let part = within((rim - away) / of_ray + away.all(0.5));
        let middle = (part * of_ray).times(0.5).less_from(1.0);
        let middle = middle.below(away, [middle, away]);
        // Of few rays anywhere in what they stand for, evenly by area, so that the dark edge has its share.
        let turn = (right.times(DITHER[0]) + down.times(DITHER[1])).fraction();
        let half = of_ray.times(0.5);
        let [inner, outer] = [away - half, away + half].map(|end| within(end) * within(end));
        let anywhere = (inner + turn * (outer - inner)).sqrt();
        let inside = of_ray
            .times(MANY_RAYS)
            .below(of_ray.all(1.0), [middle, anywhere]);
        let inside = inside.at_least(0.0).at_most(RIM);
        // The way there is a ray or so: that bulges of more than two waves fade faster inwards is left out.
        let place = RoundPlace {
            level: inside * inside,
            slope: slope.map(|part| inside / away * part),
        };
        (part, place)
    }

    /// The cells of some rays, side by side or one below the other.
    fn cells(&self, axis: usize, rays: &Range<i32>) -> Range<i32> {
        let of_cell = self.of_cell[axis].cast_signed();
        rays.start.div_euclid(of_cell)..(rays.end - 1).div_euclid(of_cell) + 1
    }

    /// Those of a cell among some.
    fn rays_of(&self, axis: usize, cell: i32, rays: &Range<i32>) -> Range<i32> {
        let of_cell = self.of_cell[axis].cast_signed();
        let first = cell * of_cell;
        first.max(rays.start)..(first + of_cell).min(rays.end)
    }
}

/// Rays of a cell side by side and one below the other, so many that a drop is as wide as some.
fn rays_of_cell(seen: &SeenAt) -> [u32; 2] {
    let per_cell = (seen.places_per_px).map(|of| of.map(|part| part / seen.cells_per_px));
    let radius = |of_cell: [u32; 2]| {
        least_radius([0, 1].map(|axis| per_cell[axis].map(|part| part / f64::from(of_cell[axis]))))
    };
    let mut of_cell = [1, 1];
    while radius(of_cell) < LEAST_RAYS {
        let [across, down] = of_cell;
        let finer = [[2 * across, down], [across, 2 * down]];
        // Where it is narrower, it gains more by that.
        let next = if radius(finer[0]) > radius(finer[1]) {
            finer[0]
        } else {
            finer[1]
        };
        if next.iter().any(|n| *n > MOST_OF_CELL) {
            break;
        }
        of_cell = next;
    }
    of_cell
}

/// Steps of a sequence of which any few numbers side by side lie evenly between 0 and 1 \[Roberts2018\].
const DITHER: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

impl Drawn<LANES> for DrawnDrop<'_> {
    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        let mut cells = Cells {
            drop: self,
            rays: Rays::default(),
            columns: [0; MOST],
            n: 0,
            last: None,
            add,
        };
        let rows = self.rays_of(1, row, &self.rows);
        if let [_, 1] = self.of_cell {
            for y in rows {
                for x in self.across(y) {
                    cells.send(x.div_euclid(self.of_cell[0].cast_signed()), [x, y]);
                }
            }
        } else {
            let across: Vec<_> = rows.map(|y| (y, self.across(y))).collect();
            let first = across.iter().map(|(_, across)| across.start).min();
            let end = across.iter().map(|(_, across)| across.end).max();
            if let (Some(first), Some(end)) = (first, end) {
                for column in self.cells(0, &(first..end)) {
                    for (y, across) in &across {
                        for x in self.rays_of(0, column, across) {
                            cells.send(column, [x, *y]);
                        }
                    }
                }
            }
        }
        cells.finish();
    }
}

impl Seen for DrawnDrop<'_> {
    #[inline(always)]
    fn along<N: Number>(&self, at: [N; 2]) -> (N, [N; LANES]) {
        let (Drop { cap, water, .. }, none) = (&self.drop, at[0].all(0.0));
        let offset = self.offset(at);
        let place = straight(&self.per_ray, offset);
        let share = self.within_reach(place, none.all(self.share));
        let (share, place, sight) = match &self.narrow {
            Some(Narrow { sight, per_ray }) => {
                let by = straight(per_ray, offset);
                let along = [0, 1].map(|k| by[k] + none.all(sight.along[k]));
                (share, place, sight.of_all(along))
            }
            None => {
                let px = [0, 1].map(|axis| {
                    let ray = at[axis];
                    (ray + ray.all(0.5)) / ray.all(self.rays_per_px[axis])
                });
                let outer_mm = water.from.sheet.outer_mm();
                let (at_mm, sight, is_seen) = water.from.sheet.behind_each(px, outer_mm);
                let place =
                    [0, 1].map(|k| (at_mm[k] - none.all(cap.at_mm[k])) / none.all(cap.radius_mm));
                let share = none.below(is_seen, [share, none]);
                // Far away the form of an outline closes once more, and drops beside a camera are looked for everywhere.
                let square = place[0] * place[0] + place[1] * place[1];
                let share = square.below(none.all(FARTHEST * FARTHEST), [share, none]);
                (share, place, water.sight(sight))
            }
        };
        let (part, RoundPlace { level, slope }) = self.part(offset, place);
        let share = share * part;
        if !share.is_above(0.0) {
            return (none, [none; LANES]);
        }
        let at = match cap.outline.is_round() {
            true => water.in_round(slope),
            false => water.in_uneven(level, slope),
        };
        (share, water.seen(at, &sight))
    }
}

/// The cells of a row, as what their rays show becomes known.
struct Cells<'a> {
    drop: &'a DrawnDrop<'a>,
    rays: Rays,
    /// Of each ray that waits its cell.
    columns: [i32; MOST],
    n: usize,
    /// The last cell, as far as its rays were followed.
    last: Option<(i32, [f32; LANES])>,
    add: &'a mut dyn FnMut(i32, [f32; LANES]),
}

impl Cells<'_> {
    fn send(&mut self, column: i32, at: [i32; 2]) {
        self.columns[self.n] = column;
        for (places, at) in self.rays.places.iter_mut().zip(at) {
            places[self.n] = f64::from(at);
        }
        self.n += 1;
        if self.n == MOST {
            self.follow();
        }
    }

    fn follow(&mut self) {
        let n = std::mem::take(&mut self.n);
        self.rays.follow(n, self.drop);
        for k in 0..n {
            let (column, share) = (self.columns[k], self.rays.shares[k]);
            if share <= 0.0 {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
            let lanes = self.rays.lanes[k].map(|lane| (share * lane) as f32);
            self.last = Some(match self.last.take() {
                Some((last, sum)) if last == column => (column, add_arrays(sum, lanes)),
                last => {
                    self.hand_on(last);
                    (column, lanes)
                }
            });
        }
    }

    fn hand_on(&mut self, cell: Option<(i32, [f32; LANES])>) {
        if let Some((column, lanes)) = cell {
            (self.add)(column, lanes);
        }
    }

    fn finish(mut self) {
        self.follow();
        let last = self.last.take();
        self.hand_on(last);
    }
}

/// The level up to which a ray that is so wide, of the drop's radius, lies within the drop and within its rim.
fn whole_within(of_ray: f64) -> f64 {
    let rim = (1.0 - of_ray * of_ray / 12.0).max(0.0).sqrt();
    // Below 0 of a drop that is no wider than a ray.
    let within = (rim - of_ray).min(RIM - 0.5 * of_ray).max(0.0);
    within * within
}

#[cfg(test)]
mod tests {
    use super::{RIM, whole_within};

    #[test]
    fn rays_that_are_wider_than_a_drop_are_never_within_it() {
        for of_ray in [0.0, 0.01, 0.5, 0.99] {
            let within = whole_within(of_ray).sqrt();
            assert!(within + of_ray <= 1.0, "{of_ray}: {within}");
            assert!(within + 0.5 * of_ray <= RIM, "{of_ray}: {within}");
        }
        for of_ray in [1.0, 1.98, 2.0, 3.5, 100.0] {
            assert!(whole_within(of_ray) <= 0.0, "{of_ray}");
        }
    }
}
