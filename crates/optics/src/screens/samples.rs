//! What a coat does to light in each cell of a frame, before it is spread by the pupil.

use starbreak_deposit::{Coating, Passage};

use super::Map;
use crate::View;
use crate::maps::Pupil;
use crate::physical::{Beyond, defocus_rows};
use crate::pyramid::Cells;

/// A way over the pane on which a coat does not change, mm, and most places of a cell of which the mean is taken.
const LONGEST_MM: f64 = 0.7;
const MOST_PLACES: u32 = 32;

/// How a coat changes where light goes, cell by cell.
pub(super) struct Samples {
    pub(super) size: (usize, usize),
    pub(super) per_cell: u32,
    /// Share of each that is glass, where a dashboard stands before the pane; else none.
    glass: Vec<f32>,
    /// Mean share of the frame that is covered.
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
        if !view.dashboard().is_none() {
            let (columns, rows) = samples.size;
            samples.glass = (0..columns * rows)
                .map(|k| [k % columns, k / columns])
                .map(|cell| (view.dashboard()).glass_in(cell, view.size(), per_cell))
                .collect();
        }
        let middle = |k: f64| (k + 0.5) * f64::from(per_cell);
        let row = |y: f64| (0..size.0).map(move |x| view.unproject([f64::from(x), y].map(middle)));
        let longest_mm = coating.apart_mm().max(LONGEST_MM);
        let (mut ways_mm, mut there) = (Vec::new(), Vec::new());
        // The last one, this one and the next.
        let mut rows = [-1.0, -1.0, 0.0].map(|y| row(y).collect::<Vec<_>>());
        for y in 0..size.1 {
            rows.rotate_left(1);
            rows[2] = row(f64::from(y) + 1.0).collect();
            let seen = &rows[1];
            let beside = [rows[0].as_slice(), &rows[2]];
            ways_mm.clear();
            let longest = add_ways(seen, beside, &mut ways_mm);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some places"
            )]
            let n_places = ((longest / longest_mm).ceil() as u32).clamp(1, MOST_PLACES);
            there.clear();
            coating.along(&ways_mm, n_places, &mut there);
            let mut there = there.iter();
            for seen in seen {
                match (seen, seen.and_then(|_| there.next())) {
                    (Some(at_mm), Some(passage)) => samples.push(passage, (*at_mm, view), f_px),
                    _ => samples.push(&Passage::CLEAN, ([0.0; 2], view), f_px),
                }
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
            glass: Vec::new(),
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
    fn push(&mut self, passage: &Passage, (at_mm, view): ([f64; 2], &View), f_px: f64) {
        let glass = self.glass.get(self.across.len());
        self.covered += passage.covered * f64::from(glass.copied().unwrap_or(1.0));
        self.direct.push(passage.direct);
        self.diffuse.push(passage.diffuse);
        self.back.push(passage.back);
        self.turned
            .push([passage.narrow, passage.wide, passage.streak]);
        let [x, y] = passage.turned_rad.map(|rad| rad * f_px);
        self.moved.push([x, y, x * x + y * y]);
        let has_grooves = passage.streak > 0.0;
        self.across.push(match has_grooves {
            true => across_in_frame(passage.across, at_mm, view),
            false => passage.across,
        });
        self.has_grooves |= has_grooves;
    }

    /// Three numbers of each where any is above 0, as [`Samples::map`], which are 0 where no glass is.
    pub(super) fn map_of_any(&self, spread: &Spread<'_>, threes: &Threes) -> Option<Map> {
        threes.has_any.then(|| self.map(spread, threes, 0.0))
    }

    /// Three numbers of each, spread by the pupil, and what they are where no glass is.
    pub(super) fn map(&self, spread: &Spread<'_>, threes: &Threes, without: f32) -> Map {
        let values = threes.values.as_flattened();
        let first = &values[..3.min(values.len())];
        let is_even = values.chunks_exact(3).all(|three| three == first);
        let mut spread = match is_even {
            true => values.to_vec(),
            false => spread.over(values, self.size),
        };
        for (three, glass) in spread.chunks_exact_mut(3).zip(&self.glass) {
            for value in three {
                *value = without + glass * (*value - without);
            }
        }
        Cells::of_cells(&spread, self.size, self.per_cell)
    }
}

/// How the pupil spreads what each row of cells does.
pub(super) struct Spread<'a> {
    pupil: Pupil,
    /// Radius of its image for each row, in cells.
    radii: &'a [f64],
    /// What rows that are all 1 become.
    of_ones: Vec<f32>,
}

impl<'a> Spread<'a> {
    pub(super) fn of(pupil: Pupil, radii: &'a [f64]) -> Self {
        let ones = vec![1.0; radii.len()];
        let size = (1, radii.len());
        Self {
            pupil,
            radii,
            of_ones: defocus_rows::<1>(&ones, size, pupil, radii, Beyond::Mirrored),
        }
    }

    /// Three numbers of each cell, spread: where discs grow or shrink from row to row a little more or less comes together
    /// than there was, which is made good for.
    fn over(&self, values: &[f32], size: (usize, usize)) -> Vec<f32> {
        let mut spread = defocus_rows::<3>(values, size, self.pupil, self.radii, Beyond::Mirrored);
        for (row, all) in spread.chunks_exact_mut(3 * size.0).zip(&self.of_ones) {
            for value in row {
                *value /= all;
            }
        }
        spread
    }
}

/// Adds the way on the pane, mm, of which each cell of a row shows the mean, by its middle and how far it goes, of those that
/// show the pane: that to the cell above or below, whichever is nearer. The longest is returned. All rows are of places in the
/// middles of cells.
fn add_ways(
    row: &[Option<[f64; 2]>],
    [above, below]: [&[Option<[f64; 2]>]; 2],
    ways_mm: &mut Vec<[[f64; 2]; 2]>,
) -> f64 {
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let mut most_mm2 = 0.0_f64;
    for ((at_mm, above_mm), below_mm) in row.iter().zip(above).zip(below) {
        let Some(at_mm) = at_mm else {
            continue;
        };
        let way = |to: &Option<[f64; 2]>| to.map(|to| [to[0] - at_mm[0], to[1] - at_mm[1]]);
        let way_mm = match (way(above_mm), way(below_mm)) {
            (Some(one), Some(other)) if square(other) < square(one) => other,
            (Some(one), _) | (None, Some(one)) => one,
            (None, None) => [0.0; 2],
        };
        most_mm2 = most_mm2.max(square(way_mm));
        ways_mm.push([*at_mm, way_mm]);
    }
    most_mm2.sqrt()
}

/// Direction across a groove in the frame, by that on the pane.
fn across_in_frame(across: [f32; 2], at_mm: [f64; 2], view: &View) -> [f32; 2] {
    let Some([[a, b], [c, d]]) = view.jacobian(at_mm) else {
        return across;
    };
    let [x, y] = across.map(f64::from);
    // The groove itself is moved to the frame, and light turned across it there.
    let (along_x, along_y) = (-a * y + b * x, -c * y + d * x);
    let length = libm::hypot(along_x, along_y).max(f64::MIN_POSITIVE);
    #[expect(clippy::cast_possible_truncation, reason = "a direction")]
    let in_frame = [along_y / length, -along_x / length].map(|along| along as f32);
    in_frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Camera;

    /// A line down the pane through which nothing goes.
    struct Line {
        middle_mm: f64,
        width_mm: f64,
    }

    impl Coating for Line {
        fn passage(&self, at_mm: [f64; 2]) -> Passage {
            let mut passage = Passage::CLEAN;
            if (at_mm[0] - self.middle_mm).abs() < 0.5 * self.width_mm {
                passage.direct = [0.0; 3];
            }
            passage
        }

        fn turns_by_rad(&self) -> [f64; 2] {
            [0.0; 2]
        }
    }

    #[test]
    fn a_thin_line_in_a_far_corner_is_no_row_of_dashes() {
        let camera = Camera {
            f_px: 900.0,
            distance_m: 0.15,
            rake_rad: 50_f64.to_radians(),
            axis_at_mm: [0.0, 0.0],
        };
        let size = (1160, 860);
        let view = View::through(&camera, size).unwrap_or_else(|error| panic!("{error}"));
        let line = Line {
            middle_mm: 180.0,
            width_mm: 0.3,
        };
        let samples = Samples::of(&line, (&view, camera.f_px), 1);
        let (mut n_rows, mut squares) = (0, 0.0);
        let rows = samples.direct.values.chunks_exact(size.0 as usize);
        for (row, y) in rows.zip(0_u32..) {
            let middle = |x: u32| view.unproject([f64::from(x) + 0.5, f64::from(y) + 0.5]);
            let Some((one, next)) = middle(900).zip(middle(901)) else {
                continue;
            };
            let px_mm = next[0] - one[0];
            let hidden: f32 = row.iter().map(|share| 1.0 - share[0]).sum();
            // Where pixels are as wide as the line, and it is within the frame.
            let last_mm = one[0] + px_mm * f64::from(size.0 - 10 - 900);
            if px_mm > 0.3 && last_mm > line.middle_mm {
                n_rows += 1;
                squares += (f64::from(hidden) * px_mm / line.width_mm - 1.0).powi(2);
            }
        }
        let rms = (squares / f64::from(n_rows)).sqrt();
        // 0.45 of places that lie below each other: all of a line, or nothing.
        assert!(rms < 0.3, "of its width in a row: {rms}");
        assert!(n_rows > 50, "{n_rows} rows");
    }

    /// Where discs shrink down the frame, glass without a coat stays as clear as it is, also at its border.
    #[test]
    fn clean_glass_stays_clean_where_discs_change() {
        let camera = Camera {
            f_px: 300.0,
            distance_m: 0.15,
            rake_rad: 0.0,
            axis_at_mm: [0.0, 0.0],
        };
        let size = (240, 160);
        let view = View::through(&camera, size).unwrap_or_else(|error| panic!("{error}"));
        let line = Line {
            middle_mm: -55.0,
            width_mm: 2.0,
        };
        let samples = Samples::of(&line, (&view, camera.f_px), 1);
        let radii: Vec<f64> = (0..160).map(|y| 14.0 - 0.075 * f64::from(y)).collect();
        let spread = Spread::of(Pupil::Round, &radii);
        let direct = samples.map(&spread, &samples.direct, 1.0);
        let (mut clean, mut hidden) = (0.0_f32, 0.0_f32);
        for (k, value) in direct.values().enumerate() {
            match k % 240 {
                60.. => clean = clean.max((value[0] - 1.0).abs()),
                _ => hidden = hidden.max(1.0 - value[0]),
            }
        }
        assert!(hidden > 0.1, "the line hides {hidden}");
        assert!(clean < 1e-4, "far from it {clean} is lost or made");
    }
}
