//! A frame whose pixels come from other places.

mod alone;
mod lines;

use crate::pyramid::vectorized;

use alone::{Alone, Shrunk, TOGETHER_PX, middle};
use lines::Line;

/// The map is asked at the corners of squares of this side, px, and is straight between: of the strongest distortion
/// that presets have, and in its corner, it is wrong by a hundredth of a px.
const SQUARE: usize = 8;

/// Squares whose places are farther from straight lines between their corners are asked pixel by pixel, px.
const BENT_PX: f64 = 0.04;

/// So many rows of the frame a line may cross from one column to the next: of steeper ones its columns tell too little.
const STEEPEST: f64 = 0.2;

/// Corners that show columns nearer to each other than such a part of a square are not told apart.
const LEAST_STEP: f64 = 0.1;

/// Farther than any frame is wide, px.
const FARTHEST: f64 = 4e6;

/// How many squares beyond the corners of a line it is known what goes on as there.
const FARTHEST_BEYOND: f64 = 2.0;

/// What is seen of places beyond the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// Its border goes on.
    Border,
    /// Nothing: it is black.
    Nothing,
}

/// Where the pixels of frames of one size come from.
///
/// Light goes up or down within its column first, and then along its row, each between pixels by the cubic of Keys
/// \[Keys1981\], which keeps what is a straight line or a parabola: a frame that is moved by half a pixel is not blurred as
/// by a mean of neighbors. How far it goes down is thus known for the column that it is of. Where that is not known, where
/// lines are bent or turned, and where some show nothing or more than a pixel and a quarter of the frame, pixels are shown one
/// by one.
#[derive(Debug, Clone)]
pub(super) struct Resampling {
    /// Width and height, px.
    size: (usize, usize),
    /// How far to the right of the corners of squares the light was that is shown there, px.
    across_px: Vec<f32>,
    /// For the columns of corners, how far below them the light was that is shown in their rows, px; not a number where none of
    /// it is shown.
    down_px: Vec<f32>,
    /// Whether a square is shown by what its corners say.
    is_straight: Vec<bool>,
    /// Squares that show more of the frame than lies around the places of their pixels.
    shrunk: Vec<Shrunk>,
    /// Pixels of all others that show anything.
    alone: Vec<Alone>,
}

impl Resampling {
    /// Of frames of a width and height, px, where what is seen at a place was at another, px: none where nothing is seen.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "px of a frame"
    )]
    pub(super) fn new(
        size: (usize, usize),
        beyond: Beyond,
        from: impl Fn(f64, f64) -> Option<[f64; 2]>,
    ) -> Self {
        let from = |u, v| {
            let place = from(u, v).filter(|[u, v]| !(u + v).is_nan())?;
            Some(place.map(|px| px.clamp(-FARTHEST, FARTHEST)))
        };
        let bounds = [size.0 as f64, size.1 as f64];
        let is_seen = |place: [f64; 2]| {
            let is_inside = |k: usize| (0.0..=bounds[k]).contains(&place[k]);
            beyond == Beyond::Border || (is_inside(0) && is_inside(1))
        };
        // Beyond the frame a line goes on as its ends, in their rows.
        let is_beside = |[u, _]: [f64; 2], steep: f64| {
            let beyond_px = (-u).max(u - bounds[0]).max(0.0);
            beyond_px <= lines::MOST_BEYOND_PX && beyond_px * steep <= BENT_PX
        };
        let [n_across, n_down] = [size.0, size.1].map(|n| n.div_ceil(SQUARE));
        // Of all corners, in rows; not a number where nothing is seen.
        let mut places = Vec::with_capacity((n_across + 1) * (n_down + 1));
        let [mut across_px, mut down_px] = [0, 1].map(|_| Vec::with_capacity(places.capacity()));
        for v in (0..=n_down).map(corner_px) {
            let line = (0..=n_across).map(|k| from(corner_px(k), v).unwrap_or([f64::NAN; 2]));
            places.extend(line);
            let line = &places[places.len() - n_across - 1..];
            let columns = line.iter().zip(0..);
            across_px.extend(columns.map(|([u, _], k)| (u - corner_px(k)) as f32));
            let mut nearest = 0;
            down_px.extend((0..=n_across).map(corner_px).map(|column| {
                // What shows nothing is passed by.
                let is_beyond = |[u, _]: [f64; 2]| u > column;
                while nearest + 2 < line.len() && !is_beyond(line[nearest + 1]) {
                    nearest += 1;
                }
                let row = row_shown(line, nearest, column).clamp(-FARTHEST, FARTHEST);
                (row - v) as f32
            }));
        }
        let mut this = Self {
            size,
            across_px,
            down_px,
            is_straight: Vec::with_capacity(n_across * n_down),
            shrunk: Vec::new(),
            alone: Vec::new(),
        };
        for (j, i) in (0..n_down).flat_map(|j| (0..n_across).map(move |i| (j, i))) {
            if !is_even(&places, [n_across + 1, n_down + 1], [i, j]) {
                this.is_straight.push(false);
                this.leave_alone([i, j], from, is_seen);
                continue;
            }
            let first = j * (n_across + 1) + i;
            let corners = [first, first + 1, first + n_across + 1, first + n_across + 2];
            let corners = Corners(corners.map(|k| places[k]));
            let is_seen_whole = corners.0.iter().all(|at| is_seen(*at));
            let seen_px = corners.seen_px();
            let is_shrunk = seen_px.iter().any(|px| *px > TOGETHER_PX);
            let is_straight = is_seen_whole
                && !is_shrunk
                && (corners.steep()).is_some_and(|steep| {
                    steep <= STEEPEST && corners.0.iter().all(|at| is_beside(*at, steep))
                })
                && this.knows_columns(&corners, j);
            this.is_straight.push(is_straight);
            if is_seen_whole && is_shrunk {
                this.shrunk.push(Shrunk::new([i, j], corners, seen_px));
            } else if !is_straight {
                let from = |u, v| Some(corners.at([u, v], [i, j]));
                this.leave_alone([i, j], from, is_seen);
            }
        }
        this
    }

    /// Whether it is known how far all goes down that a square of a row shows of columns of the frame.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "columns of a frame"
    )]
    fn knows_columns(&self, Corners([a, b, c, d]): &Corners, row: usize) -> bool {
        let n_across = self.size.0.div_ceil(SQUARE);
        let corner_before = |column: f64| (column.max(0.0) / SQUARE as f64) as usize;
        // Each place is shown by two columns on either side.
        let first = corner_before(a[0].min(c[0]) - 3.0).min(n_across - 1);
        let last = (corner_before(b[0].max(d[0]) + 3.0) + 1).clamp(first, n_across);
        [row, row + 1].into_iter().all(|row| {
            let down_px = &self.down_px[row * (n_across + 1)..][first..=last];
            down_px.iter().all(|px| px.is_finite())
        })
    }

    /// The pixels of a square by themselves.
    fn leave_alone(
        &mut self,
        [i, j]: [usize; 2],
        from: impl Fn(f64, f64) -> Option<[f64; 2]>,
        is_seen: impl Fn([f64; 2]) -> bool,
    ) {
        let (width, height) = self.size;
        let of_square = |k: usize, n: usize| k * SQUARE..((k + 1) * SQUARE).min(n);
        for y in of_square(j, height) {
            for x in of_square(i, width) {
                let [u, v] = middle([x, y]);
                if let Some(place) = from(u, v).filter(|place| is_seen(*place)) {
                    // A place beside it that shows nothing does not tell.
                    let beside = |u, v| from(u, v).unwrap_or(place);
                    let beside = [beside(u + 1.0, v), beside(u, v + 1.0)];
                    self.alone.push(Alone::new([x, y], place, beside));
                }
            }
        }
    }

    /// The light of each pixel of a frame with one value per pixel, or three side by side, as it was at its place; black
    /// where nothing is seen. None of it is below 0.
    pub(super) fn over(&self, light: &[f32], n_colors: usize) -> Vec<f32> {
        match n_colors {
            1 => self.over_colors::<1>(light),
            _ => self.over_colors::<3>(light),
        }
    }

    fn over_colors<const COLORS: usize>(&self, light: &[f32]) -> Vec<f32> {
        let (width, height) = self.size;
        let mut out = vec![0.0; light.len()];
        let mut line = Line::<COLORS>::new(width);
        let n_across = width.div_ceil(SQUARE);
        let rows = out.chunks_exact_mut((width * COLORS).max(1));
        for ((y, out), j) in rows.enumerate().zip((0..).flat_map(|j| [j; SQUARE])) {
            let is_straight = &self.is_straight[j * n_across..][..n_across];
            if is_straight.contains(&true) {
                let t = part_of_square(y % SQUARE);
                vectorized(
                    #[inline(always)]
                    || {
                        line.fill(light, (y, height), self.between(&self.down_px, j, t));
                        line.shown(out, is_straight, self.between(&self.across_px, j, t));
                    },
                );
            }
        }
        let pixels = out.as_chunks_mut::<COLORS>().0;
        vectorized(
            #[inline(always)]
            || {
                for square in &self.shrunk {
                    square.show(light, self.size, pixels);
                }
                for pixel in &self.alone {
                    pixel.show(light, self.size, pixels);
                }
            },
        );
        out
    }

    /// Values of corners between their row and the next one.
    #[inline(always)]
    fn between<'a>(
        &self,
        values: &'a [f32],
        row: usize,
        t: f32,
    ) -> impl Fn(usize) -> f32 + use<'a> {
        let n = self.size.0.div_ceil(SQUARE) + 1;
        let [above, below] = [&values[row * n..][..n], &values[(row + 1) * n..][..n]];
        #[inline(always)]
        move |k| above[k] + t * (below[k] - above[k])
    }
}

/// Whether the places of a square are those on straight lines between its corners, within [`BENT_PX`], as far as the corners
/// beside it tell: those on a line are half way between its ends but for an eighth of how its steps differ. Not where one of
/// them is not a number.
fn is_even(places: &[[f64; 2]], n: [usize; 2], square: [usize; 2]) -> bool {
    if n[0].min(n[1]) < 3 {
        return false;
    }
    let at = |[i, j]: [usize; 2]| places[j * n[0] + i];
    (0..4).all(|k| {
        let corner = [square[0] + k % 2, square[1] + k / 2];
        (0..2).all(|axis| {
            let three = [0, 1, 2].map(|step| {
                let mut along = corner;
                along[axis] = corner[axis].clamp(1, n[axis] - 2) + step - 1;
                at(along)
            });
            let differs = |k: usize| three[2][k] - 2.0 * three[1][k] + three[0][k];
            let [x, y] = [differs(0), differs(1)];
            x * x + y * y <= 64.0 * BENT_PX * BENT_PX
        })
    })
}

/// Which row of the frame is shown of a column, px, along a line whose corners show these places: by the cubic through those of
/// the four corners about one; not a number where columns are not in their order, or far beyond them.
fn row_shown(places: &[[f64; 2]], corner: usize, column: f64) -> f64 {
    let n = places.len().min(4);
    let first = corner.saturating_sub(1).min(places.len() - n);
    let about = &places[first..][..n];
    let side = SQUARE as f64;
    let is_in_order = about
        .windows(2)
        .all(|two| two[1][0] - two[0][0] > LEAST_STEP * side);
    let beyond = (about[0][0] - column).max(column - about[n - 1][0]);
    if !is_in_order || beyond > FARTHEST_BEYOND * side {
        return f64::NAN;
    }
    let share = |k: usize| {
        let others = about.iter().enumerate().filter(|(j, _)| *j != k);
        others.fold(1.0, |share, (_, other)| {
            share * (column - other[0]) / (about[k][0] - other[0])
        })
    };
    (0..n).map(|k| share(k) * about[k][1]).sum()
}

/// Where the sides of squares are, px.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn corner_px(k: usize) -> f64 {
    (k * SQUARE) as f64
}

/// What is shown at the corners of a square, px: upper left and right, lower left and right.
#[derive(Debug, Clone, Copy)]
struct Corners([[f64; 2]; 4]);

impl Corners {
    /// What is shown at a place of the square, on straight lines between them.
    fn at(&self, place: [f64; 2], square: [usize; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.0;
        let [s, t] = [0, 1].map(|k| (place[k] - corner_px(square[k])) / SQUARE as f64);
        [0, 1].map(|k| {
            let (left, right) = (a[k] + t * (c[k] - a[k]), b[k] + t * (d[k] - b[k]));
            left + s * (right - left)
        })
    }

    /// How many rows of the frame its lines cross from one column to the next; none if columns do not follow each other.
    fn steep(&self) -> Option<f64> {
        let [a, b, c, d] = self.0;
        let of_line = |from: [f64; 2], to: [f64; 2]| {
            let columns = to[0] - from[0];
            (columns > LEAST_STEP * SQUARE as f64).then(|| ((to[1] - from[1]) / columns).abs())
        };
        Some(of_line(a, b)?.max(of_line(c, d)?))
    }

    /// How many px of the frame are seen in a pixel, along each axis.
    fn seen_px(&self) -> [f64; 2] {
        let [a, b, c, d] = self.0;
        [0, 1].map(|k| {
            let right = (b[k] - a[k]).abs().max((d[k] - c[k]).abs());
            let down = (c[k] - a[k]).abs().max((d[k] - b[k]).abs());
            (right * right + down * down).sqrt() / SQUARE as f64
        })
    }
}

/// Where the middle of a pixel of a square is between its sides.
#[expect(clippy::cast_precision_loss, reason = "px of a square")]
#[inline(always)]
fn part_of_square(k: usize) -> f32 {
    (k as f32 + 0.5) / SQUARE as f32
}

#[cfg(test)]
mod tests;
