//! Pixels that are shown one by one.

use super::lines::clamped;
use super::{Corners, SQUARE};

/// Up to so many px of the frame that are seen in one of what is shown, no more is asked about than around a place.
pub(super) const TOGETHER_PX: f64 = 1.25;

/// So many times as wide as between pixels the cubic is at most.
const WIDEST: u8 = 8;

/// Most pixels in a row of which one is.
const MOST: usize = 4 * WIDEST as usize + 1;

/// How many times as wide as between pixels the cubic is for a pixel that shows so many px of the frame: as many from 2 on,
/// without a step from what is beside.
#[expect(clippy::cast_possible_truncation, reason = "a share")]
fn wide_of(seen_px: f64) -> f32 {
    let wide = seen_px.min(1.0 + (seen_px - TOGETHER_PX) / (2.0 - TOGETHER_PX));
    let wide = if wide > 1.0 { wide } else { 1.0 };
    wide.min(f64::from(WIDEST)) as f32
}

/// A square that shows more of the frame than lies around the places of its pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shrunk {
    square: [usize; 2],
    corners: Corners,
    /// How many times as wide as between pixels the cubic is.
    wide: [f32; 2],
}

impl Shrunk {
    /// Of a square, what its corners show, and how many px of the frame its pixels show along each axis.
    pub(super) fn new(square: [usize; 2], corners: Corners, seen_px: [f64; 2]) -> Self {
        Self {
            square,
            corners,
            wide: seen_px.map(wide_of),
        }
    }

    /// Puts its pixels into a frame.
    #[inline(always)]
    pub(super) fn show<const COLORS: usize>(
        &self,
        light: &[f32],
        size: (usize, usize),
        out: &mut [[f32; COLORS]],
    ) {
        let [left, top] = self.square.map(|k| k * SQUARE);
        for y in top..(top + SQUARE).min(size.1) {
            for x in left..(left + SQUARE).min(size.0) {
                let place = self.corners.at(middle([x, y]), self.square);
                let moved = moved([x, y], place);
                out[y * size.0 + x] = seen(light, size, [x, y], moved, self.wide);
            }
        }
    }
}

/// A pixel by itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alone {
    at: [usize; 2],
    /// How far away its light was, px.
    moved: [f32; 2],
    /// How many times as wide as between pixels the cubic is.
    wide: [f32; 2],
}

impl Alone {
    /// Of a pixel whose middle shows such a place of the frame, and its neighbors to the right and below these, px.
    pub(super) fn new(at: [usize; 2], place: [f64; 2], [right, below]: [[f64; 2]; 2]) -> Self {
        Self {
            at,
            moved: moved(at, place),
            wide: [0, 1].map(|k| wide_of(libm::hypot(right[k] - place[k], below[k] - place[k]))),
        }
    }

    /// Puts it into a frame.
    #[inline(always)]
    pub(super) fn show<const COLORS: usize>(
        &self,
        light: &[f32],
        size: (usize, usize),
        out: &mut [[f32; COLORS]],
    ) {
        let [x, y] = self.at;
        out[y * size.0 + x] = seen(light, size, self.at, self.moved, self.wide);
    }
}

/// The middle of a pixel, px.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
pub(super) fn middle([x, y]: [usize; 2]) -> [f64; 2] {
    [x as f64 + 0.5, y as f64 + 0.5]
}

/// How far away the light of a pixel is that shows a place, px.
#[expect(clippy::cast_possible_truncation, reason = "px of a frame")]
fn moved(at: [usize; 2], place: [f64; 2]) -> [f32; 2] {
    let middle = middle(at);
    [0, 1].map(|k| (place[k] - middle[k]) as f32)
}

/// The light around a place that is so far from a pixel, px, by the cubic of Keys, which is as much wider as more of the frame
/// is seen in a pixel, or lines thinner than that would break up into dots.
#[inline(always)]
fn seen<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    [x, y]: [usize; 2],
    moved: [f32; 2],
    wide: [f32; 2],
) -> [f32; COLORS] {
    let across = Weights::of(moved[0], wide[0]);
    let down = Weights::of(moved[1], wide[1]);
    let mut columns = [0.0_f32; 3 * MOST];
    let columns = &mut columns[..across.n * COLORS];
    let left = x.checked_add_signed(across.first);
    let inside = left.filter(|left| left + across.n <= width);
    for (j, down) in (down.first..).zip(&down.shares[..down.n]) {
        let row = &light[clamped(y, j, height) * width * COLORS..][..width * COLORS];
        if let Some(left) = inside {
            let row = &row[left * COLORS..][..columns.len()];
            for (column, light) in columns.iter_mut().zip(row) {
                *column += down * light;
            }
        } else {
            for (i, column) in (across.first..).zip(columns.chunks_exact_mut(COLORS)) {
                let from = clamped(x, i, width) * COLORS;
                for (column, light) in column.iter_mut().zip(&row[from..]) {
                    *column += down * light;
                }
            }
        }
    }
    let mut all = [0.0_f32; COLORS];
    for (across, column) in across.shares.iter().zip(columns.chunks_exact(COLORS)) {
        for (all, light) in all.iter_mut().zip(column) {
            *all += across * light;
        }
    }
    for all in &mut all {
        *all = all.max(0.0);
    }
    all
}

/// Shares of pixels side by side in what is seen at a place.
struct Weights {
    /// The first, from the pixel whose place it is.
    first: isize,
    n: usize,
    shares: [f32; MOST],
}

impl Weights {
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some pixels"
    )]
    #[inline(always)]
    fn of(moved: f32, wide: f32) -> Self {
        let first = (moved - 2.0 * wide).floor() + 1.0;
        let last = (moved + 2.0 * wide).ceil() - 1.0;
        let n = ((last - first) as usize + 1).min(MOST);
        let mut shares = [0.0; MOST];
        let mut sum = 0.0;
        for (k, share) in shares[..n].iter_mut().enumerate() {
            let x = ((first - moved) + k as f32).abs() / wide;
            let near = (1.5 * x - 2.5) * x * x + 1.0;
            let far = ((2.5 - 0.5 * x) * x - 4.0) * x + 2.0;
            *share = if x < 1.0 { near } else { far };
            sum += *share;
        }
        for share in &mut shares[..n] {
            *share /= sum;
        }
        Self {
            first: first as isize,
            n,
            shares,
        }
    }
}
