//! Light that is moved within its column, and then along its row.

use wide::f32x4;

use super::{SQUARE, part_of_square};

/// How far beyond the frame places may lie that a line knows, px.
pub(super) const MOST_BEYOND_PX: f64 = 8.0;

/// Pixels beside a line that repeat its ends: those, and what lies around a place.
const BESIDE: usize = 16;

/// A row of a frame whose light has been moved within its columns.
pub(super) struct Line<const COLORS: usize> {
    width: usize,
    /// With [`BESIDE`] pixels more at each end.
    light: Vec<f32>,
    taps: Taps,
}

impl<const COLORS: usize> Line<COLORS> {
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            light: vec![0.0; (width + 2 * BESIDE) * COLORS],
            taps: Taps::new(width),
        }
    }

    /// Of row `y` of a frame of a height, px, with how far below the light of each corner's column was.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        light: &[f32],
        (y, height): (usize, usize),
        down_px: impl Fn(usize) -> f32,
    ) {
        self.taps.find::<COLORS>(down_px);
        let n_row = self.width * COLORS;
        let to = &mut self.light[BESIDE * COLORS..][..n_row];
        let mut x = 0;
        while x < self.width {
            let (n, from) = self.taps.run(x, self.width);
            if let Some(from) = from {
                let row = |j: isize| {
                    &light[clamped(y, from + j, height) * n_row + x * COLORS..][..n * COLORS]
                };
                let to = &mut to[x * COLORS..][..n * COLORS];
                self.taps
                    .add_up::<COLORS, false>(x, [row(0), row(1), row(2), row(3)], to);
            }
            x += n;
        }
        let last = BESIDE + self.width - 1;
        for c in 0..COLORS {
            let first = self.light[BESIDE * COLORS + c];
            let last = self.light[last * COLORS + c];
            for x in 0..BESIDE {
                self.light[x * COLORS + c] = first;
                self.light[(BESIDE + self.width + x) * COLORS + c] = last;
            }
        }
    }

    /// What a row of the frame shows of it in some of its squares, with how far to the right the light of each corner was.
    #[inline(always)]
    pub(super) fn shown(
        &mut self,
        out: &mut [f32],
        is_shown: &[bool],
        across_px: impl Fn(usize) -> f32,
    ) {
        self.taps.find::<COLORS>(across_px);
        let mut k = 0;
        for same in is_shown.chunk_by(|a, b| a == b) {
            let mut x = k * SQUARE;
            k += same.len();
            let end = (k * SQUARE).min(self.width);
            while same[0] && x < end {
                let (n, from) = self.taps.run(x, end);
                if let Some(from) = from
                    && let Some(first) = (x + BESIDE).checked_add_signed(from)
                {
                    let light = |j: usize| &self.light[(first + j) * COLORS..][..n * COLORS];
                    let to = &mut out[x * COLORS..][..n * COLORS];
                    self.taps.add_up::<COLORS, true>(
                        x,
                        [light(0), light(1), light(2), light(3)],
                        to,
                    );
                }
                x += n;
            }
        }
    }
}

/// Of which pixels the light of those of a row is, along one axis.
struct Taps {
    /// How far each is moved, px.
    moved: Vec<f32>,
    /// Whole px of that.
    whole: Vec<f32>,
    /// Shares of four pixels: of the one before that, of that, and of two behind it.
    shares: [Vec<f32>; 4],
    /// For each of three colors.
    of_colors: [Vec<f32>; 4],
}

impl Taps {
    fn new(width: usize) -> Self {
        let none = vec![0.0; width.next_multiple_of(SQUARE)];
        Self {
            moved: none.clone(),
            whole: none.clone(),
            shares: std::array::from_fn(|_| none.clone()),
            of_colors: std::array::from_fn(|_| none.repeat(3)),
        }
    }

    #[inline(always)]
    fn find<const COLORS: usize>(&mut self, moved_px: impl Fn(usize) -> f32) {
        let mut left = moved_px(0);
        let parts = [0, 4].map(|k| f32x4::new(std::array::from_fn(|x| part_of_square(k + x))));
        let squares = self.moved.as_chunks_mut::<4>().0.as_chunks_mut::<2>().0;
        for (k, moved) in squares.iter_mut().enumerate() {
            let right = moved_px(k + 1);
            let [first, more] = [f32x4::splat(left), f32x4::splat(right - left)];
            moved[0] = (first + parts[0] * more).to_array();
            moved[1] = (first + parts[1] * more).to_array();
            left = right;
        }
        let n = self.moved.len();
        let [a, b, c, d] = &mut self.shares;
        let [a, b, c, d] = [&mut a[..n], &mut b[..n], &mut c[..n], &mut d[..n]];
        let (moved, whole) = (&self.moved[..n], &mut self.whole[..n]);
        for x in 0..n {
            let floor = moved[x].floor();
            let t = moved[x] - floor;
            whole[x] = floor;
            [a[x], b[x], c[x], d[x]] = shares(t);
        }
        if COLORS == 3 {
            for (shares, of_colors) in self.shares.iter().zip(&mut self.of_colors) {
                let of_colors = of_colors.as_chunks_mut::<24>().0;
                for (shares, to) in shares.as_chunks::<8>().0.iter().zip(of_colors) {
                    let shares = *shares;
                    for x in 0..24 {
                        to[x] = shares[x / 3];
                    }
                }
            }
        }
    }

    /// How many pixels from one on are moved by as many whole px, and the first of the four that each is of, from where it is;
    /// none if that is no number.
    #[expect(clippy::float_cmp, reason = "whole numbers")]
    #[inline(always)]
    fn run(&self, x: usize, end: usize) -> (usize, Option<isize>) {
        let whole = &self.whole[x..end];
        let first = whole[0];
        let mut n = 0;
        for eight in whole.as_chunks::<8>().0 {
            let mut is_same = true;
            for it in eight {
                is_same &= *it == first;
            }
            if !is_same {
                break;
            }
            n += 8;
        }
        while n < whole.len() && whole[n] == first {
            n += 1;
        }
        #[expect(clippy::cast_possible_truncation, reason = "px of a frame")]
        let from = first.is_finite().then(|| first as isize - 1);
        // What is no number is not even itself.
        (n.max(1), from)
    }

    /// Sums for pixels side by side from one on, `from` the first of four and those behind it: of light, none is below 0; half
    /// way some may be.
    #[inline(always)]
    fn add_up<const COLORS: usize, const IS_LIGHT: bool>(
        &self,
        first: usize,
        from: [&[f32]; 4],
        to: &mut [f32],
    ) {
        let n = to.len();
        let [a, b, c, d] = match COLORS {
            1 => &self.shares,
            _ => &self.of_colors,
        };
        let first = first * COLORS;
        let [a, b, c, d] = [&a[first..], &b[first..], &c[first..], &d[first..]];
        let [i, j, k, l] = [&from[0][..n], &from[1][..n], &from[2][..n], &from[3][..n]];
        let [a, b, c, d] = [&a[..n], &b[..n], &c[..n], &d[..n]];
        for x in 0..n {
            let sum = (a[x] * i[x] + b[x] * j[x]) + (c[x] * k[x] + d[x] * l[x]);
            to[x] = if !IS_LIGHT || sum > 0.0 { sum } else { 0.0 };
        }
    }
}

/// The shares of four places side by side in what lies such a part of the way from the second to the third.
#[inline(always)]
fn shares(t: f32) -> [f32; 4] {
    let rest = 1.0 - t;
    let both = -0.5 * t * rest;
    let [before, behind] = [both * rest, both * t];
    [
        before,
        (rest - (before + before)) + behind,
        (t - (behind + behind)) + before,
        behind,
    ]
}

/// The pixel so far behind one, or the last of a frame.
#[inline(always)]
pub(super) fn clamped(at: usize, behind: isize, n: usize) -> usize {
    at.saturating_add_signed(behind).min(n - 1)
}
