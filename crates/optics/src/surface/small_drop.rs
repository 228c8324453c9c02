//! Drops of which no part is seen: an ellipse on the cells, that shows what drops of its contact angle show in the mean, and
//! how that changes across them.

use std::f64::consts::PI;
use std::ops::Range;

use super::drawn_drop::SOFT_PX;
use super::glimpse::Glimpse;
use super::lobe::LANES;
use super::seen_at::{SeenAt, least_radius, straight};
use crate::maps::{Drawn, Reaches};

/// Radius along the longer side, in cells, below which a drop is small: of blurred ones, of sharp ones, and of sharp ones
/// that are flatter along the shorter side, in cells, so that lines across them would be seen.
const SMALL_CELLS: f64 = 3.0;
const SMALL_SHARP_CELLS: f64 = 2.2;
const SMALL_FLAT_CELLS: f64 = 1.1;
const FLAT_CELLS: f64 = 0.75;

/// Places across a row of cells, and weights, by which an ellipse's part of it is found \[AbramowitzStegun1964\], table 25.4.
const ACROSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_669_241_483_4, 5.0 / 18.0),
];

/// A drop that is drawn as what a glimpse of it shows.
#[derive(Debug)]
pub(super) struct SmallDrop {
    glimpse: Glimpse,
    blur_px: f64,
    /// Its middle, in cells.
    middle: [f64; 2],
    /// Change of the place on the pane, of its radius, per cell along x and along y.
    per_cell: [[f64; 2]; 2],
    /// How far the middle of a row of it lies to the right, per cell down; half of its widest row, and of its height.
    lean: f64,
    half: f64,
    high: f64,
    /// Weight of an area of it, so that all of it is as large as the drop.
    share: f64,
}

/// A part of an ellipse between two rows, as a box: its height, its middle and half of its width.
struct Part {
    height: f64,
    middle: [f64; 2],
    half: f64,
}

impl SmallDrop {
    /// None of a drop of which parts are seen, or of which nothing is known where it is.
    pub(super) fn of(
        seen: &SeenAt,
        glimpse: impl FnOnce([f64; 2], bool) -> Option<Glimpse>,
    ) -> Option<Self> {
        let cells_per_px = seen.cells_per_px;
        let per_cell = (seen.places_per_px).map(|of| of.map(|part| part / cells_per_px));
        let [[a, b], [c, d]] = per_cell;
        let (determinant, shorter) = ((a * d - b * c).abs(), least_radius(per_cell));
        let area = PI / determinant;
        // That of an ellipse is π times its two radii.
        let longer = 1.0 / (determinant * shorter);
        let is_soft = seen.blur_px.abs() >= SOFT_PX;
        let most = match (is_soft, shorter >= FLAT_CELLS) {
            (true, _) => SMALL_CELLS,
            (false, true) => SMALL_SHARP_CELLS,
            (false, false) => SMALL_FLAT_CELLS,
        };
        if longer.is_nan() || longer >= most {
            return None;
        }
        let along = a * a + b * b;
        let mut drop = Self {
            glimpse: glimpse(seen.at_px, is_soft)?,
            blur_px: seen.blur_px,
            middle: seen.at_px.map(|px| px * cells_per_px),
            per_cell,
            lean: -(a * c + b * d) / along,
            half: 1.0 / along.sqrt(),
            high: along.sqrt() / determinant,
            share: 1.0,
        };
        let parts = drop.rows().filter_map(|row| drop.part(row));
        drop.share = area / parts.map(|part| 2.0 * part.half * part.height).sum::<f64>();
        Some(drop)
    }

    pub(super) fn reaches(&self) -> Reaches {
        Reaches {
            radius_px: self.blur_px,
            rows: self.rows(),
        }
    }

    fn rows(&self) -> Range<i32> {
        cells([-self.high, self.high].map(|y| self.middle[1] + y))
    }

    fn part(&self, row: i32) -> Option<Part> {
        let top = f64::from(row) - self.middle[1];
        let [top, bottom] = [top, top + 1.0].map(|y| y.clamp(-self.high, self.high));
        let height = bottom - top;
        let (mut half, mut down) = (0.0, 0.0);
        for (at, weight) in ACROSS {
            let y = 0.5 * (top + bottom + at * height);
            let share = y / self.high;
            let here = weight * self.half * (1.0 - share * share).max(0.0).sqrt();
            half += here;
            down += here * y;
        }
        let y = down / half;
        (height > 0.0 && half > 0.0).then_some(Part {
            height,
            middle: [self.lean * y, y],
            half,
        })
    }
}

/// The cells from a place to another.
fn cells([from, to]: [f64; 2]) -> Range<i32> {
    #[expect(clippy::cast_possible_truncation, reason = "`as` clamps")]
    let cells = (from.floor() as i32)..(to.ceil() as i32);
    cells
}

impl Drawn<LANES> for SmallDrop {
    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        let Some(part) = self.part(row) else {
            return;
        };
        let [left, right] = [-part.half, part.half].map(|x| part.middle[0] + x);
        for column in cells([left, right].map(|x| self.middle[0] + x)) {
            let cell = f64::from(column) - self.middle[0];
            let (from, to) = (cell.max(left), (cell + 1.0).min(right));
            let place = straight(&self.per_cell, [0.5 * (from + to), part.middle[1]]);
            let weight = self.share * part.height * (to - from);
            add(column, self.glimpse.lanes(place, weight));
        }
    }
}
