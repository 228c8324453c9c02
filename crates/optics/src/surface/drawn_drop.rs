//! Drops cell by cell.

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::Range;

use starbreak_deposit::{Cap, RoundPlace};

use super::SheetView;
use super::drops::{Drop, LEAST_PX, RIM, Sight};
use super::lobe::LANES;
use crate::maps::{Drawn, add_arrays, cells_per_px};
use crate::vector::Vector;

/// Least radius of a drop along its shorter side, in rays: where cells are wider, several rays share one, so many along a
/// side at most.
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

/// Directions around a drop by which its outline is known, and how far from its middle that lies, of its radius: beyond
/// the sides between them.
const AROUND: [[f64; 2]; 16] = {
    let [a, b, c] = [
        0.923_879_532_511_286_7,
        FRAC_1_SQRT_2,
        0.382_683_432_365_089_8,
    ];
    let quarter = [[1.0, 0.0], [a, c], [b, b], [c, a]];
    let mut around = [[0.0; 2]; 16];
    let mut k = 0;
    while k < 4 {
        let [x, y] = quarter[k];
        around[k] = [x, y];
        around[k + 4] = [-y, x];
        around[k + 8] = [-x, -y];
        around[k + 12] = [y, -x];
        k += 1;
    }
    around
};
const BEYOND: f64 = 1.1;

/// A drop that is drawn cell by cell, by one ray or several in each.
pub(crate) struct DrawnDrop<'a> {
    pub(super) drop: Drop<'a>,
    blur_px: f64,
    /// Rays along one side of a cell, and per px.
    of_cell: u32,
    rays_per_px: f64,
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
    pub(super) fn of(drop: Drop<'a>, seen: &Seen, pupil_reach: f64) -> Option<Self> {
        let sheet = drop.water.from.sheet;
        let blur_px = seen.blur_px;
        let beyond_px = blur_px.abs() * pupil_reach + 2.0 / cells_per_px(blur_px);
        let uneven = drop.cap.outline.reach();
        let extent = Extent::of(&drop, seen, BEYOND * uneven);
        let (cells_per_px, radius_px) = (cells_per_px(blur_px), least_radius(seen.places_per_px));
        let mut of_cell = 1;
        while f64::from(of_cell) * cells_per_px * radius_px < LEAST_RAYS && of_cell < MOST_OF_CELL {
            of_cell *= 2;
        }
        let rays_per_px = f64::from(of_cell) * cells_per_px;
        // Half a ray beyond its outline is still among what a ray stands for.
        let rays = |[low, high]: [f64; 2]| {
            let [low, high] = [low * rays_per_px - 0.5, high * rays_per_px + 0.5];
            #[expect(clippy::cast_possible_truncation, reason = "`as` clamps")]
            let rays = (low.floor() as i32)..(high.ceil() as i32);
            rays
        };
        let [columns, rows] = extent.spans_px.map(rays);
        let (width, height) = sheet.view().size();
        let within_frame = |all: &Range<i32>, side_px: f64| {
            let most = rays([-beyond_px, side_px + beyond_px]);
            all.start.max(most.start)..all.end.min(most.end)
        };
        // Nothing is seen below a dashboard.
        let [_, last] = sheet.view().dashboard().ends();
        let within = [
            within_frame(&columns, f64::from(width)),
            within_frame(&rows, last * f64::from(height)),
        ];
        if within.iter().any(Range::is_empty) {
            return None;
        }
        let per_ray = |per_px: [[f64; 2]; 2]| per_px.map(|of| of.map(|part| part / rays_per_px));
        let narrow = (extent.widest_px < BEYOND * NARROW * sheet.f_px()).then(|| Narrow {
            sight: drop.water.sight(seen.sight),
            per_ray: per_ray(seen.turns_per_px),
        });
        let mut drawn = Self {
            middle: seen.at_px.map(|px| rays_per_px * px),
            per_ray: per_ray(seen.places_per_px),
            // With half a ray.
            reach: extent.reach + 0.5 / (radius_px * rays_per_px),
            whole_within: whole_within(1.0 / (radius_px * rays_per_px)),
            share: 1.0 / f64::from(of_cell * of_cell),
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

    /// Makes few rays together as large as the drop, wherever they lie.
    fn even_out(&mut self) {
        let rays = [&self.rows, &self.columns].map(ExactSizeIterator::len);
        if least_radius(self.per_ray) >= UNEVEN_RAYS
            || rays[0].saturating_mul(rays[1]) > MOST_EVENED
        {
            return;
        }
        let mut parts = 0.0;
        for at in (self.rows.clone()).flat_map(|y| self.columns.clone().map(move |x| [x, y])) {
            if let Some((part, _)) = self.place(at).and_then(|place| self.part(at, place)) {
                parts += part;
            }
        }
        let [[a, b], [c, d]] = self.per_ray;
        // Of a drop that no ray meets nothing is shown.
        let parts = parts.max(1e-3);
        self.share *= PI / (a * d - b * c).abs() / parts;
    }

    /// The place that a ray looks at, of the drop's radius from its middle, as far as that changes evenly; none of nearly
    /// all rays that do not meet the drop.
    fn place(&self, at: [i32; 2]) -> Option<[f64; 2]> {
        let place = straight(&self.per_ray, self.offset(at));
        let square = place[0] * place[0] + place[1] * place[1];
        (square < self.reach * self.reach).then_some(place)
    }

    /// From the middle of the drop to a ray, in rays.
    fn offset(&self, at: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|k| f64::from(at[k]) + 0.5 - self.middle[k])
    }

    /// How much of its cell a ray stands for that looks at a place, and where that is on a round drop.
    fn part(&self, at: [i32; 2], place: [f64; 2]) -> Option<(f64, RoundPlace)> {
        let whole = self.drop.cap.outline.round_place(place);
        if whole.level < self.whole_within {
            return Some((1.0, whole));
        }
        let RoundPlace { level, slope } = whole;
        let away = level.sqrt().max(1e-9);
        let [right, down] = slope.map(|part| part / away);
        // The rim is as many rays away as it takes to come there by the fastest way. Over all places that the rays may have,
        // this covers π (ρ² + 1/12) of a circle of ρ rays, hence the smaller one.
        let [x, y] = self.per_ray.map(|[a, b]| a * right + b * down);
        let square = x * x + y * y;
        let (rim, of_ray) = ((1.0 - square / 12.0).max(0.0).sqrt(), square.sqrt());
        let part = ((rim - away) / of_ray + 0.5).min(1.0);
        if part <= 0.0 {
            return None;
        }
        let inside = if of_ray * MANY_RAYS < 1.0 {
            away.min(1.0 - 0.5 * part * of_ray)
        } else {
            // Of few rays anywhere in what they stand for, evenly by area, so that the dark edge has its share.
            let [x, y] = self.offset(at);
            let turn = x * DITHER[0] + y * DITHER[1];
            let ends = [away - 0.5 * of_ray, away + 0.5 * of_ray];
            let ends = ends.map(|end| end.clamp(0.0, 1.0));
            let [inner, outer] = ends.map(|end| end * end);
            (inner + (turn - turn.floor()) * (outer - inner)).sqrt()
        };
        let inside = inside.clamp(0.0, RIM);
        // The way there is a ray or so: that bulges of more than two waves fade faster inwards is left out.
        let place = RoundPlace {
            level: inside * inside,
            slope: slope.map(|part| inside / away * part),
        };
        Some((part, place))
    }

    /// What a ray shows; none where it stands for nothing of the drop.
    fn ray(&self, at: [i32; 2]) -> Option<[f32; LANES]> {
        let place = self.place(at)?;
        let (place, sight) = match &self.narrow {
            Some(Narrow { sight, per_ray }) => {
                let [x, y] = straight(per_ray, self.offset(at));
                let along = [sight.along[0] + x, sight.along[1] + y];
                (place, Sight { along, ..*sight })
            }
            None => {
                let (cap, sheet) = (&self.drop.cap, self.drop.water.from.sheet);
                let px = at.map(|k| (f64::from(k) + 0.5) / self.rays_per_px);
                let (at_mm, sight) = sheet.behind(px, sheet.outer_mm())?;
                let place = [0, 1].map(|k| (at_mm[k] - cap.at_mm[k]) / cap.radius_mm);
                (place, self.drop.water.sight(sight))
            }
        };
        let (part, place) = self.part(at, place)?;
        let share = self.share * part;
        let sent = match self.drop.cap.outline.is_round() {
            true => self.drop.water.seen(place.slope, &sight),
            false => self.drop.water.seen_in(place, &sight),
        };
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let lanes = sent.lanes.map(|lane| (share * lane) as f32);
        Some(lanes)
    }

    /// The rays of a cell together.
    fn cell(&self, column: i32, row: i32) -> Option<[f32; LANES]> {
        if self.of_cell == 1 {
            return self.ray([column, row]);
        }
        let [columns, rows] = [(column, &self.columns), (row, &self.rows)].map(|(cell, all)| {
            let first = cell * self.of_cell.cast_signed();
            first.max(all.start)..(first + self.of_cell.cast_signed()).min(all.end)
        });
        let mut sum = None;
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            if let Some(lanes) = self.ray([x, y]) {
                sum = Some(add_arrays(sum.unwrap_or([0.0; LANES]), lanes));
            }
        }
        sum
    }

    /// The cells of some rays.
    fn cells(&self, rays: &Range<i32>) -> Range<i32> {
        let of_cell = self.of_cell.cast_signed();
        rays.start.div_euclid(of_cell)..(rays.end - 1).div_euclid(of_cell) + 1
    }
}

/// Steps of a sequence of which any few numbers side by side lie evenly between 0 and 1 \[Roberts2018\].
const DITHER: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

impl Drawn<LANES> for DrawnDrop<'_> {
    fn radius_px(&self) -> f64 {
        self.blur_px
    }

    fn rows(&self) -> Range<i32> {
        self.cells(&self.rows)
    }

    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        for column in self.cells(&self.columns) {
            if let Some(lanes) = self.cell(column, row) {
                add(column, lanes);
            }
        }
    }
}

/// Where a drop is seen, about its middle.
pub(super) struct Seen {
    /// Where the ray of sight to its middle enters the pane.
    pub(super) enters_mm: [f64; 2],
    pub(super) at_px: [f64; 2],
    /// Signed radius of its blur.
    pub(super) blur_px: f64,
    /// Direction of sight before the glass.
    sight: Vector,
    /// Change of the place on the outer face, of the drop's radius, and of the direction, per px along x and along y.
    pub(super) places_per_px: [[f64; 2]; 2],
    turns_per_px: [[f64; 2]; 2],
}

impl Seen {
    /// None of one that is farther from the frame than so many px and some of its own radii, or too small to be seen.
    pub(super) fn of(cap: &Cap, sheet: &SheetView, reach_px: f64) -> Option<Self> {
        let [[px_per_mm, _], _] = sheet.view().jacobian(cap.at_mm)?;
        let radius_px = px_per_mm * cap.radius_mm;
        if radius_px < LEAST_PX {
            return None;
        }
        let enters_mm = sheet.entry(cap.at_mm, sheet.outer_mm(), [0.0; 2])?;
        let at_px = sheet.appears(enters_mm, [0.0; 2])?;
        let (width, height) = sheet.view().size();
        let far_px = reach_px + 4.0 * radius_px;
        let is_far = |px: f64, side: u32| !(-far_px..f64::from(side) + far_px).contains(&px);
        if is_far(at_px[0], width) || is_far(at_px[1], height) {
            return None;
        }
        let behind = |right_px: f64, down_px: f64| {
            let px = [at_px[0] + right_px, at_px[1] + down_px];
            sheet.behind(px, sheet.outer_mm())
        };
        let (mut places_per_px, mut turns_per_px) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for (axis, [right, down]) in [[0.5, 0.0], [0.0, 0.5]].into_iter().enumerate() {
            let [from, to] = [behind(-right, -down)?, behind(right, down)?];
            for k in 0..2 {
                places_per_px[axis][k] = (to.0[k] - from.0[k]) / cap.radius_mm;
                turns_per_px[axis][k] = to.1[k] - from.1[k];
            }
        }
        Some(Self {
            enters_mm,
            at_px,
            blur_px: sheet.blur_radius_px(cap.at_mm, sheet.outer_mm())?,
            sight: behind(0.0, 0.0)?.1,
            places_per_px,
            turns_per_px,
        })
    }
}

/// What a drop reaches to.
struct Extent {
    /// How far from its middle, of its radius, by the change of the place about its middle alone.
    reach: f64,
    /// The same in px, and from where to where across and down.
    widest_px: f64,
    spans_px: [[f64; 2]; 2],
}

impl Extent {
    /// Of so many times its radius.
    fn of(drop: &Drop<'_>, seen: &Seen, times: f64) -> Self {
        let mut extent = Self {
            reach: 0.0,
            widest_px: 0.0,
            spans_px: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        };
        let radius_mm = times * drop.cap.radius_mm;
        for [cos, sin] in AROUND {
            let [x, y] = drop.cap.at_mm;
            let Some(at) = drop.appears([x + radius_mm * cos, y + radius_mm * sin]) else {
                // Some of it lies beside the camera: it may be everywhere.
                return Self {
                    reach: f64::INFINITY,
                    widest_px: f64::INFINITY,
                    spans_px: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
                };
            };
            let px = [0, 1].map(|k| at[k] - seen.at_px[k]);
            let place = straight(&seen.places_per_px, px);
            let [away, px] = [place, px].map(|[x, y]| libm::hypot(x, y));
            extent.reach = extent.reach.max(away);
            extent.widest_px = extent.widest_px.max(px);
            for (span, at) in extent.spans_px.iter_mut().zip(at) {
                *span = [span[0].min(at), span[1].max(at)];
            }
        }
        extent
    }
}

/// The level up to which a ray that is so wide, of the drop's radius, lies within the drop and within its rim.
fn whole_within(of_ray: f64) -> f64 {
    let rim = (1.0 - of_ray * of_ray / 12.0).max(0.0).sqrt();
    let within = (rim - of_ray).clamp(0.0, RIM - 0.5 * of_ray);
    within * within
}

/// What is some steps away, by the change per step along x and along y.
pub(super) fn straight([along_x, along_y]: &[[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| x * along_x[k] + y * along_y[k])
}

/// Steps to the rim of a drop along its shorter side, by the change of the place, of its radius, per step.
pub(super) fn least_radius([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    // The inverse of the larger singular value.
    let (sum, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
    let root = (sum * sum - 4.0 * determinant * determinant)
        .max(0.0)
        .sqrt();
    1.0 / (0.5 * (sum + root)).sqrt()
}
