//! Glass that is not even: what is seen through it is moved, and blurred where the pupil sees several slopes.

use wide::f32x4;

use super::samples::{Samples, Spread};
use crate::pyramid::{Cells, Pyramid, TOGETHER, between, mirrored, together, vectorized};

/// Less than this moves nothing, px.
const LEAST_PX: f32 = 0.02;

/// What is moved and blurred by no more than this, px, is put together from pixels; else from between blurred copies.
const NEAR_PX: f32 = 16.0;
const NEARLY_SHARP_PX: f32 = 0.8;

/// From a pixel to the place that is seen there, and how much that is blurred.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turned {
    /// Right, down, and the standard deviation per axis, px.
    moved: Cells<3>,
    /// The most of each.
    most_px: [f32; 3],
}

impl Turned {
    /// Of what a coat does; none where nothing is turned.
    pub(super) fn of(samples: &Samples, spread: &Spread<'_>) -> Option<Self> {
        let mean = samples.map_of_any(spread, &samples.moved)?;
        // Of what the pupil sees the mean is moved, and the rest of the squares is blur.
        let values: Vec<f32> = mean
            .values()
            .flat_map(|[x, y, square]| {
                let rest = (square - x * x - y * y).max(0.0);
                [*x, *y, (0.5 * rest).sqrt()]
            })
            .collect();
        let moved = Cells::of_cells(&values, mean.size, mean.per_cell);
        let most_px = [0, 1, 2]
            .map(|k| (moved.values()).fold(0.0_f32, |most, moves| most.max(moves[k].abs())));
        Some(Self { moved, most_px })
    }

    /// How far a cell is moved and blurred, px: the root of the mean square.
    pub(super) fn moves_by(&self, cell: usize) -> f32 {
        self.moved.values().nth(cell).map_or(0.0, |[x, y, sigma]| {
            (x * x + y * y + 2.0 * sigma * sigma).sqrt()
        })
    }

    /// Moves and blurs the light of a frame, in place.
    pub(super) fn over<const COLORS: usize>(&self, light: &mut [f32], size: (usize, usize)) {
        let [right, down, sigma] = self.most_px;
        if right.max(down) <= NEAR_PX && sigma <= NEARLY_SHARP_PX {
            vectorized(
                #[inline(always)]
                || self.by_pixels::<COLORS>(light, size),
            );
        } else {
            self.by_copies::<COLORS>(light, size);
        }
    }

    /// Each pixel from four by four, by shares with the mean and the variance of what is seen there.
    #[inline(always)]
    fn by_pixels<const COLORS: usize>(&self, light: &mut [f32], (width, height): (usize, usize)) {
        let n = width * COLORS;
        let [beside, away] = [0, 1].map(|k| whole(self.most_px[k]).0.unsigned_abs() + 2);
        let mut before = RowsBefore::<COLORS>::of(light, (width, height), [beside, away]);
        let mut out = vec![0.0; n + TOGETHER];
        let mut moves = self.moved.rows(width, 1);
        for y in 0..height {
            before.advance(light, y);
            for (x, moves) in moves.at(y).as_chunks::<3>().0.iter().enumerate() {
                let [right, down, sigma] = *moves;
                let is_moved = right.abs().max(down.abs()).max(sigma) >= LEAST_PX;
                let [(right, s), (down, t)] = match is_moved {
                    true => [right, down].map(whole),
                    false => [(0, 0.0); 2],
                };
                let [across, along] = [s, t].map(|part| rest(part, sigma));
                let at = [
                    (x + beside).wrapping_add_signed(right) * COLORS,
                    away.wrapping_add_signed(down),
                ];
                let light = if is_moved && across.max(along) > 0.0 {
                    before.blurred(at, [shares(s, across), shares(t, along)])
                } else {
                    before.between(at, [s, t])
                };
                out[x * COLORS..x * COLORS + TOGETHER].copy_from_slice(light.as_array());
            }
            light[y * n..][..n].copy_from_slice(&out[..n]);
        }
    }

    /// Each pixel from between pixels and between copies of the frame that are blurred ever more.
    fn by_copies<const COLORS: usize>(&self, light: &mut [f32], size: (usize, usize)) {
        // Ever more blurred copies: of standard deviations 0, 1, 2, 4, … px.
        let most = self.most_px[2];
        let mut blurred = vec![Cells::<COLORS>::of(light, size)];
        let mut pyramid = Pyramid::<COLORS>::of(light, size);
        let mut sigma_px = 1.0_f32;
        while sigma_px < 2.0 * most && sigma_px < 256.0 {
            blurred.push(pyramid.spread(f64::from(sigma_px)));
            sigma_px *= 2.0;
        }
        let mut rows = self.moved.rows(size.0, 1);
        vectorized(
            #[inline(always)]
            || {
                let out = light.as_chunks_mut::<COLORS>().0;
                for (y, row) in out.chunks_exact_mut(size.0).enumerate() {
                    let moves = rows.at(y).as_chunks::<3>().0;
                    for (x, (pixel, moves)) in row.iter_mut().zip(moves).enumerate() {
                        let [right, down, sigma] = *moves;
                        if right.abs().max(down.abs()).max(sigma) >= LEAST_PX {
                            let from = [x, y].map(to_f32);
                            let at = [
                                mirrored_px(from[0] + 0.5 + right, size.0),
                                mirrored_px(from[1] + 0.5 + down, size.1),
                            ];
                            *pixel = between_copies(&blurred, at, sigma);
                        }
                    }
                }
            },
        );
    }
}

/// The rows of a frame about one as they were before any was changed, mirrored beyond its border.
struct RowsBefore<const COLORS: usize> {
    rows: Vec<Vec<f32>>,
    size: (usize, usize),
    beside: usize,
}

impl<const COLORS: usize> RowsBefore<COLORS> {
    /// About the row before the first: so many rows to both sides of it, with so many pixels beside them.
    fn of(light: &[f32], size: (usize, usize), [beside, away]: [usize; 2]) -> Self {
        let row = vec![0.0; (size.0 + 2 * beside) * COLORS + TOGETHER];
        let rows = vec![row; 2 * away + 1];
        let mut before = Self { rows, size, beside };
        for k in 0..2 * away {
            let y = mirrored(k.cast_signed() - away.cast_signed(), size.1);
            before.fill(k + 1, &light[y * size.0 * COLORS..]);
        }
        before
    }

    /// Goes on to a row, the next, from which on all are as they were.
    #[inline(always)]
    fn advance(&mut self, light: &[f32], y: usize) {
        self.rows.rotate_left(1);
        let (away, last) = (self.rows.len() / 2, self.rows.len() - 1);
        let row = mirrored((y + away).cast_signed(), self.size.1);
        if row == y + away {
            self.fill(last, &light[row * self.size.0 * COLORS..]);
        } else {
            let same = self.rows[row + away - y].clone();
            self.rows[last] = same;
        }
    }

    /// The light part of the ways across and down from a pixel to the next.
    #[inline(always)]
    fn between(&self, [first, row]: [usize; 2], [s, t]: [f32; 2]) -> f32x4 {
        let of_row = |row: &[f32]| {
            let row = &row[first..first + COLORS + TOGETHER];
            between(together(row), together(&row[COLORS..]), s)
        };
        between(of_row(&self.rows[row]), of_row(&self.rows[row + 1]), t)
    }

    /// The light of four by four pixels by their shares across and down, of which the second is that pixel.
    #[inline(always)]
    fn blurred(&self, [first, row]: [usize; 2], [across, down]: [[f32; 4]; 2]) -> f32x4 {
        let mut sum = f32x4::ZERO;
        for (row, share) in self.rows[row - 1..row + 3].iter().zip(down) {
            let row = &row[first - COLORS..first + 2 * COLORS + TOGETHER];
            let mut lights = f32x4::ZERO;
            for (k, share) in across.into_iter().enumerate() {
                lights += f32x4::splat(share) * together(&row[k * COLORS..]);
            }
            sum += f32x4::splat(share) * lights;
        }
        sum
    }

    /// Fills one of the rows with the first pixels of a frame's rest.
    #[inline(always)]
    fn fill(&mut self, k: usize, light: &[f32]) {
        let (n, beside) = (self.size.0, self.beside);
        let row = &mut self.rows[k];
        row[beside * COLORS..][..n * COLORS].copy_from_slice(&light[..n * COLORS]);
        for x in (0..beside).chain(beside + n..2 * beside + n) {
            let from = mirrored(x.cast_signed() - beside.cast_signed(), n) * COLORS;
            row[x * COLORS..][..COLORS].copy_from_slice(&light[from..from + COLORS]);
        }
    }
}

/// The pixel before a place, and how near that is to the next.
#[inline(always)]
fn whole(px: f32) -> (isize, f32) {
    let before = px.floor();
    #[expect(clippy::cast_possible_truncation, reason = "px of a frame")]
    let whole = before as i32 as isize;
    (whole, px - before)
}

/// The variance that a straight line between two pixels, part of the way, lacks to that of a standard deviation, px.
#[inline(always)]
fn rest(part: f32, sigma_px: f32) -> f32 {
    (sigma_px * sigma_px - part * (1.0 - part)).max(0.0)
}

/// Shares of the pixel before a place that is part of the way to the next, of that, and of one more on both sides: of a
/// straight line between the two, with more variance, px².
#[inline(always)]
fn shares(part: f32, more: f32) -> [f32; 4] {
    let (one, other) = (1.0 - part, part);
    let (half, rest) = (0.5 * more, 1.0 - more);
    [
        one * half,
        one * rest + other * half,
        other * rest + one * half,
        other * half,
    ]
}

/// The light at a place blurred by a standard deviation, px: between two copies by the variance.
#[inline(always)]
fn between_copies<const COLORS: usize>(
    blurred: &[Cells<COLORS>],
    at: [f32; 2],
    sigma: f32,
) -> [f32; COLORS] {
    let level = blurred_level(sigma).min(blurred.len() - 1);
    let low = blurred[level].at(at);
    let Some(next) = blurred.get(level + 1) else {
        return low;
    };
    let variance = |level: usize| match level {
        0 => 0.0,
        _ => f32::from(1_u16 << (2 * (level - 1)).min(15)),
    };
    let (from, to) = (variance(level), variance(level + 1));
    let part = ((sigma * sigma - from) / (to - from)).clamp(0.0, 1.0);
    let high = next.at(at);
    std::array::from_fn(|c| low[c] + part * (high[c] - low[c]))
}

#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn to_f32(k: usize) -> f32 {
    k as f32
}

/// A place of a frame; beyond its border it goes on mirrored.
#[inline(always)]
fn mirrored_px(px: f32, n: usize) -> f32 {
    let n = to_f32(n);
    if (0.0..=n).contains(&px) {
        return px;
    }
    let folded = px.abs() % (2.0 * n);
    folded.min(2.0 * n - folded)
}

/// The last copy that is no more blurred than a standard deviation, px.
fn blurred_level(sigma_px: f32) -> usize {
    let mut level = 0;
    let mut next = 1.0;
    while sigma_px >= next && level < 8 {
        level += 1;
        next *= 2.0;
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Glass that moves and blurs everywhere alike.
    fn even(moves: [f32; 3], (width, height): (usize, usize)) -> Turned {
        Turned {
            moved: Cells::of_cells(&moves.repeat(width * height), (width, height), 1),
            most_px: moves.map(f32::abs),
        }
    }

    fn over(turned: &Turned, light: &[f32], size: (usize, usize)) -> Vec<f32> {
        let mut light = light.to_vec();
        turned.over::<1>(&mut light, size);
        light
    }

    #[test]
    fn what_is_seen_has_the_mean_and_the_variance_that_it_should() {
        let size = (40, 30);
        // x + 10 y and x² + y², as a row of two colors.
        let light: Vec<f32> = (0..size.0 * size.1)
            .map(|k| [k % size.0, k / size.0].map(to_f32))
            .flat_map(|[x, y]| [x + 10.0 * y, x * x + y * y, 0.0])
            .collect();
        for (right, down, sigma) in [
            (0.2, 0.6, 0.0),
            (-0.3, 0.1, 0.7),
            (2.6, -3.4, 0.5),
            (0.0, 0.0, 0.8),
        ] {
            let turned = even([right, down, sigma], size);
            let mut seen = light.clone();
            turned.over::<3>(&mut seen, size);
            let seen = seen[(15 * size.0 + 20) * 3..].first_chunk::<2>();
            let [u, v] = [20.0 + right, 15.0 + down];
            // A straight line between pixels has a variance of its own, below which it cannot be.
            let variance = |px: f32| (px - px.floor()) * (px.ceil() - px);
            let more = [right, down].map(|px| variance(px).max(sigma * sigma));
            let expected = [u + 10.0 * v, u * u + v * v + more[0] + more[1]];
            for (seen, expected) in seen.unwrap_or(&[0.0; 2]).iter().zip(expected) {
                assert!(
                    (seen - expected).abs() < 1e-2,
                    "{right}, {down}, {sigma} px: {seen} for {expected}"
                );
            }
        }
    }

    #[test]
    fn rows_are_seen_as_they_were_before_any_was_changed() {
        for (size, down) in [
            ((3, 40), 3.0),
            ((5, 40), -3.0),
            ((1, 4), 7.0),
            ((2, 1), -16.0),
            ((1, 3), -5.0),
        ] {
            let light: Vec<f32> = (0..size.0 * size.1)
                .map(|k| to_f32((k * 7919) % 251))
                .collect();
            for (right, sigma) in [(0.0, 0.6), (4.0, 0.0), (-2.0, 0.7)] {
                let seen = over(&even([right, down, sigma], size), &light, size);
                let beside = shares(0.0, sigma * sigma);
                for (k, seen) in seen.iter().enumerate() {
                    let mut expected = 0.0;
                    for (i, j) in (0..9).map(|k| (k % 3, k / 3)) {
                        let from = |at: usize, px: f32, step: usize, n: usize| {
                            #[expect(clippy::cast_possible_truncation, reason = "some px")]
                            let px = px as isize;
                            mirrored((at + step).cast_signed() + px - 1, n)
                        };
                        let x = from(k % size.0, right, i, size.0);
                        let y = from(k / size.0, down, j, size.1);
                        expected += beside[i] * beside[j] * light[y * size.0 + x];
                    }
                    assert!(
                        (seen - expected).abs() < 1e-3,
                        "pixel {k} of {size:?}, {right} and {down} px away"
                    );
                }
            }
        }
    }

    /// Both ways to put a frame together agree where each of them serves.
    #[test]
    fn blurred_copies_show_the_same_as_pixels() {
        let size = (60, 50);
        let light: Vec<f32> = (0..size.0 * size.1)
            .map(|k| [k % size.0, k / size.0].map(to_f32))
            .map(|[x, y]| 0.5 + 0.3 * (0.2 * x).sin() * (0.15 * y).cos())
            .collect();
        for moves in [[0.3, 1.2, 0.1], [-0.5, 0.4, 0.6], [2.2, -1.0, 0.8]] {
            let turned = even(moves, size);
            let near = over(&turned, &light, size);
            let mut copies = light.clone();
            turned.by_copies::<1>(&mut copies, size);
            let most =
                (near.iter().zip(&copies)).fold(0.0_f32, |most, (a, b)| most.max((a - b).abs()));
            assert!(most < 0.01, "{moves:?}: {most}");
        }
    }
}
