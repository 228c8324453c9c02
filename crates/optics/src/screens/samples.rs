//! What a coat does to light in each cell of a frame, before it is spread by the pupil.

use starbreak_deposit::{Coating, Passage};

use super::Map;
use crate::View;
use crate::maps::Pupil;
use crate::physical::{Beyond, defocus_rows};
use crate::pyramid::Cells;

/// A way over the pane on which a coat does not change, mm, and most places of a cell.
const LONGEST_MM: f64 = 0.7;
const MOST_PLACES: u32 = 32;

/// How a coat changes where light goes, cell by cell.
pub(super) struct Samples {
    pub(super) size: (usize, usize),
    pub(super) per_cell: u32,
    /// Mean share of the glass that is covered.
    pub(super) covered: f64,
    /// Of red, green and blue what goes straight on, goes on in any direction, and is sent back.
    pub(super) direct: Threes,
    pub(super) diffuse: Threes,
    pub(super) back: Threes,
    /// What is turned by the smaller and by the larger angle, and by grooves.
    pub(super) turned: Threes,
    /// How far what goes straight on is moved, right and down, px, and the square of that.
    pub(super) moved: Threes,
    /// Direction across grooves, where there are any.
    pub(super) across: Vec<[f32; 2]>,
    pub(super) has_grooves: bool,
}

/// Three numbers in each cell.
pub(super) struct Threes {
    values: Vec<[f32; 3]>,
    /// Whether any is above 0.
    pub(super) has_any: bool,
}

impl Threes {
    fn with_room(n: usize) -> Self {
        Self {
            values: Vec::with_capacity(n),
            has_any: false,
        }
    }

    #[inline(always)]
    fn push(&mut self, three: [f64; 3]) {
        self.has_any |= three.iter().any(|value| *value > 0.0);
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        self.values.push(three.map(|value| value as f32));
    }
}

impl Samples {
    /// What a coat does in each cell of a frame that a view sees with a focal length, px.
    pub(super) fn of(coating: &dyn Coating, (view, f_px): (&View, f64), per_cell: u32) -> Self {
        let (width, height) = view.size();
        let size = (width.div_ceil(per_cell), height.div_ceil(per_cell));
        let mut samples = Self::none((size.0 as usize, size.1 as usize), per_cell);
        let middle = |k: u32| (f64::from(k) + 0.5) * f64::from(per_cell);
        let middle_px = 0.5 * f64::from(width);
        let (mut seen, mut places_mm, mut there) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..size.1 {
            let around_mm = footprint(view, [middle_px, middle(y)], per_cell);
            seen.clear();
            seen.extend((0..size.0).map(|x| view.unproject([middle(x), middle(y)])));
            places_mm.clear();
            for [x, y] in seen.iter().flatten() {
                places_mm.extend(around_mm.iter().map(|[dx, dy]| [x + dx, y + dy]));
            }
            there.clear();
            coating.passages(&places_mm, &mut there);
            let mut there = there.chunks_exact(around_mm.len());
            for seen in &seen {
                let passage = match (seen, seen.and_then(|_| there.next())) {
                    (Some(at_mm), Some(all)) => cell_of(all, *at_mm, view),
                    _ => Passage::CLEAN,
                };
                samples.push(&passage, f_px);
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
        let n = samples.across.len().max(1) as f64;
        samples.covered /= n;
        samples
    }

    fn none(size: (usize, usize), per_cell: u32) -> Self {
        let n = size.0 * size.1;
        Self {
            size,
            per_cell,
            covered: 0.0,
            direct: Threes::with_room(n),
            diffuse: Threes::with_room(n),
            back: Threes::with_room(n),
            turned: Threes::with_room(n),
            moved: Threes::with_room(n),
            across: Vec::with_capacity(n),
            has_grooves: false,
        }
    }

    /// Adds the next cell; covered is a sum as yet.
    #[inline(always)]
    fn push(&mut self, passage: &Passage, f_px: f64) {
        self.covered += passage.covered;
        self.direct.push(passage.direct);
        self.diffuse.push(passage.diffuse);
        self.back.push(passage.back);
        self.turned
            .push([passage.narrow, passage.wide, passage.streak]);
        let [x, y] = passage.turned_rad.map(|rad| rad * f_px);
        self.moved.push([x, y, x * x + y * y]);
        #[expect(clippy::cast_possible_truncation, reason = "a direction")]
        self.across.push(passage.across.map(|along| along as f32));
        self.has_grooves |= passage.streak > 0.0;
    }

    /// Three numbers of each where any is above 0, as [`Samples::map`].
    pub(super) fn map_of_any(&self, pupil: (Pupil, &[f64]), threes: &Threes) -> Option<Map> {
        threes.has_any.then(|| self.map(pupil, threes))
    }

    /// Three numbers of each, spread by the pupil with a radius for each row of cells.
    pub(super) fn map(&self, (pupil, radii): (Pupil, &[f64]), threes: &Threes) -> Map {
        let values = threes.values.as_flattened();
        let first = &values[..3.min(values.len())];
        if values.chunks_exact(3).all(|three| three == first) {
            return Cells::of_cells(values, self.size, self.per_cell);
        }
        let spread = defocus_rows::<3>(values, self.size, pupil, radii, Beyond::Mirrored);
        Cells::of_cells(&spread, self.size, self.per_cell)
    }
}

/// What a cell shows in the mean of some places.
#[inline(always)]
fn cell_of(places: &[Passage], at_mm: [f64; 2], view: &View) -> Passage {
    let mut passage = match places {
        [one] => *one,
        all => Passage::mean(all.iter().copied()),
    };
    if passage.streak > 0.0 {
        passage.across = across_in_frame(passage.across, at_mm, view);
    }
    passage
}

/// Places on the pane around that in the middle of a cell of a frame, mm, of which the cell shows the mean: along the longer
/// way over the pane that it is, where that is long, as of glass seen at a grazing angle.
fn footprint(view: &View, middle_px: [f64; 2], per_cell: u32) -> Vec<[f64; 2]> {
    let half = 0.5 * f64::from(per_cell);
    let ways = [[half, 0.0], [0.0, half]].into_iter().filter_map(|[x, y]| {
        let from = view.unproject(middle_px)?;
        let to = view.unproject([middle_px[0] + x, middle_px[1] + y])?;
        Some([2.0 * (to[0] - from[0]), 2.0 * (to[1] - from[1])])
    });
    let length = |[x, y]: &[f64; 2]| libm::hypot(*x, *y);
    let Some(way) = ways.max_by(|one, other| length(one).total_cmp(&length(other))) else {
        return vec![[0.0; 2]];
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some places"
    )]
    let n = ((length(&way) / LONGEST_MM).ceil() as u32).clamp(1, MOST_PLACES);
    (0..n)
        .map(|k| (f64::from(k) + 0.5) / f64::from(n) - 0.5)
        .map(|part| way.map(|mm| part * mm))
        .collect()
}

/// Direction across a groove in the frame, by that on the pane.
fn across_in_frame([x, y]: [f64; 2], at_mm: [f64; 2], view: &View) -> [f64; 2] {
    let Some([[a, b], [c, d]]) = view.jacobian(at_mm) else {
        return [x, y];
    };
    // The groove itself is moved to the frame, and light turned across it there.
    let (along_x, along_y) = (-a * y + b * x, -c * y + d * x);
    let length = libm::hypot(along_x, along_y).max(f64::MIN_POSITIVE);
    [along_y / length, -along_x / length]
}
