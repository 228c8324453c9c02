//! Light that grooves turn: a streak across them through each lamp.

use starbreak_deposit::Scratches;

use super::Samples;
use crate::pyramid::{Cells, Pyramid, mirrored, vectorized};

/// Width of the cells in which streaks are, px: grooves of a pupil have more than one direction.
const CELL_PX: u32 = 4;

/// Where grooves lie before a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Streaks {
    /// Direction across them, in cells of the map.
    across: Vec<[f32; 2]>,
    columns: usize,
    per_cell: u32,
    /// Pieces of a streak from its middle on to one side; with the other side their shares sum to 1.
    pieces: Vec<Piece>,
}

/// A piece of a streak.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    /// Its middle, px from that of the streak.
    away_px: f32,
    /// Its share of light.
    share: f32,
    /// Which cells are as wide as it is long: each a factor of 2 wider than those before.
    level: usize,
}

/// Sizes of cells.
const LEVELS: usize = 3;

impl Streaks {
    /// Of what a coat does; none where it has no grooves.
    pub(super) fn of(samples: &Samples, f_px: f64) -> Option<Self> {
        if samples.passages.iter().all(|it| it.streak <= 0.0) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a direction")]
        let across = (samples.passages.iter())
            .map(|it| it.across.map(|along| along as f32))
            .collect();
        // The share within an angle, of k ∝ 1/(θ₀² + θ²).
        let whole = libm::atan(Scratches::MOST_ACROSS_RAD / Scratches::ACROSS_RAD);
        let within = |cells: f64| {
            let rad = libm::atan(cells * f64::from(CELL_PX) / f_px);
            (libm::atan(rad / Scratches::ACROSS_RAD) / whole).min(1.0)
        };
        // Beyond two frames it is all one.
        let most = 2.0 * to_f64(samples.size.0.max(samples.size.1)) * f64::from(samples.per_cell);
        let reach_px = (libm::tan(Scratches::MOST_ACROSS_RAD) * f_px).min(most);
        let reach = reach_px / f64::from(CELL_PX);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "cells of a frame"
        )]
        let n = reach.ceil().max(1.0) as u32;
        let mut pieces: Vec<Piece> = Vec::new();
        let (mut k, mut last) = (0, 0.0);
        while k <= n {
            // Far out light changes slowly.
            let level = match k {
                0..16 => 0,
                16..64 => 1,
                _ => 2,
            };
            let wide = 1 << level;
            let next = within(f64::from(k) + f64::from(wide) - 0.5);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "px of a frame, a share of light"
            )]
            pieces.push(Piece {
                away_px: ((f64::from(k) + 0.5 * f64::from(wide - 1)) * f64::from(CELL_PX)) as f32,
                share: (0.5 * (next - last)) as f32,
                level,
            });
            last = next;
            k += wide;
        }
        // The rest.
        if let Some(piece) = pieces.last_mut() {
            #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
            let rest = (0.5 * (1.0 - last)) as f32;
            piece.share += rest;
        }
        Some(Self {
            across,
            columns: samples.size.0,
            per_cell: samples.per_cell,
            pieces,
        })
    }

    /// The light of a frame turned by grooves.
    pub(super) fn over<const COLORS: usize>(
        &self,
        pyramid: &mut Pyramid<'_, COLORS>,
    ) -> Cells<COLORS> {
        let small = pyramid.no_wider(f64::from(CELL_PX));
        let wide: [Wide<COLORS>; LEVELS] = std::array::from_fn(|level| {
            let reach_px = (self.pieces.iter())
                .filter(|piece| piece.level == level)
                .fold(0.0, |most: f32, piece| most.max(piece.away_px));
            Wide::of(&pyramid.no_wider(f64::from(CELL_PX << level)), reach_px)
        });
        let mut out = vec![[0.0_f32; COLORS]; small.size.0 * small.size.1];
        vectorized(
            #[inline(always)]
            || {
                for (y, row) in out.chunks_exact_mut(small.size.0).enumerate() {
                    for (x, sum) in row.iter_mut().enumerate() {
                        *sum = self.of_cell([x, y], small.per_cell, &wide);
                    }
                }
            },
        );
        Cells::of_cells(out.as_flattened(), small.size, small.per_cell)
    }

    /// The light that is turned to the middle of a cell.
    #[inline(always)]
    fn of_cell<const COLORS: usize>(
        &self,
        cell: [usize; 2],
        per_cell: u32,
        wide: &[Wide<COLORS>; LEVELS],
    ) -> [f32; COLORS] {
        let across = self.direction(cell, per_cell);
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let at = cell.map(|k| (k as f32 + 0.5) * per_cell as f32);
        let mut sum = [0.0_f32; COLORS];
        for piece in &self.pieces {
            let cells = &wide[piece.level];
            for away in [piece.away_px, -piece.away_px] {
                let light = cells.at([0, 1].map(|k| at[k] + away * across[k]));
                for c in 0..COLORS {
                    sum[c] += piece.share * light[c];
                }
            }
        }
        sum
    }

    /// Direction across grooves at a cell of a frame.
    fn direction(&self, [x, y]: [usize; 2], per_cell: u32) -> [f32; 2] {
        let middle = |k: usize| (2 * k + 1) * per_cell as usize / 2 / self.per_cell as usize;
        let last = self.across.len() / self.columns - 1;
        let at = middle(y).min(last) * self.columns + middle(x).min(self.columns - 1);
        self.across[at]
    }
}

#[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
fn to_f64(k: usize) -> f64 {
    k as f64
}

/// The cells of a frame and, mirrored, what is beyond it.
struct Wide<const COLORS: usize> {
    light: Vec<[f32; COLORS]>,
    columns: usize,
    /// Cells beyond each side.
    beyond: f32,
    per_px: f32,
}

impl<const COLORS: usize> Wide<COLORS> {
    /// With as much beyond the frame as a way, px.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a frame"
    )]
    fn of(cells: &Cells<COLORS>, reach_px: f32) -> Self {
        let beyond = (reach_px / cells.per_cell as f32).ceil() as usize + 1;
        let (width, height) = cells.size;
        let sides = |n: usize| {
            (0..n + 2 * beyond).map(move |k| mirrored(k.cast_signed() - beyond.cast_signed(), n))
        };
        let columns: Vec<usize> = sides(width).collect();
        let light = sides(height)
            .flat_map(|y| columns.iter().map(move |x| y * width + x))
            .map(|cell| cells.cell(cell))
            .collect();
        Self {
            light,
            columns: columns.len(),
            beyond: beyond as f32,
            per_px: 1.0 / cells.per_cell as f32,
        }
    }

    /// The light of the cell of a place, px.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a frame"
    )]
    #[inline(always)]
    fn at(&self, at_px: [f32; 2]) -> [f32; COLORS] {
        let [x, y] = at_px.map(|px| (px * self.per_px + self.beyond) as u32 as usize);
        self.light
            .get(y * self.columns + x)
            .copied()
            .unwrap_or([0.0; COLORS])
    }
}
