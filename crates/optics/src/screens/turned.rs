//! Glass that is not even: what is seen through it is moved, and blurred where the pupil sees several slopes.

use super::samples::{Samples, Spread};
use crate::pyramid::{Cells, Pyramid, vectorized};

/// Less than this moves nothing, px.
const LEAST_PX: f32 = 0.02;

/// From a pixel to the place that is seen there, and how much that is blurred.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turned {
    /// Right, down, and the standard deviation per axis, px.
    moved: Cells<3>,
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
        Some(Self {
            moved: Cells::of_cells(&values, mean.size, mean.per_cell),
        })
    }

    /// How far a cell is moved and blurred, px: the root of the mean square.
    pub(super) fn moves_by(&self, cell: usize) -> f32 {
        self.moved.values().nth(cell).map_or(0.0, |[x, y, sigma]| {
            (x * x + y * y + 2.0 * sigma * sigma).sqrt()
        })
    }

    /// Moves and blurs the light of a frame, in place.
    pub(super) fn over<const COLORS: usize>(&self, light: &mut [f32], size: (usize, usize)) {
        // Ever more blurred copies: of standard deviations 0, 1, 2, 4, … px.
        let most = self.moved.values().map(|it| it[2]).fold(0.0_f32, f32::max);
        let mut blurred = vec![Cells::<COLORS>::of(light, size)];
        let mut pyramid = Pyramid::<COLORS>::of(light, size);
        let mut sigma_px = 1.0_f32;
        while sigma_px < 2.0 * most && sigma_px < 256.0 {
            blurred.push(pyramid.spread(f64::from(sigma_px)));
            sigma_px *= 2.0;
        }
        let mut rows = self.moved.rows(size.0);
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
                                mirrored(from[0] + 0.5 + right, size.0),
                                mirrored(from[1] + 0.5 + down, size.1),
                            ];
                            *pixel = between_copies(&blurred, at, sigma);
                        }
                    }
                }
            },
        );
    }
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
fn mirrored(px: f32, n: usize) -> f32 {
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
