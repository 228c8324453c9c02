//! Light that grooves turn: a streak across them through each lamp.

use starbreak_deposit::Scratches;
use wide::f32x4;

use super::samples::Samples;
use crate::pyramid::{Cells, Pyramid, between, mirrored, vectorized};

/// Width of the cells in which streaks of lamps are, px: grooves of a pupil have more than one direction.
const CELL_PX: u32 = 4;

/// Width of those in which streaks of all other light are, px, and how many pieces of a streak are as long as these, as
/// those twice as wide, and so on: far out that light changes slowly.
const BROAD_PX: u32 = 8;
const PIECES: u32 = 8;
const LEVELS: usize = 5;

/// Light above which a cell is a lamp, of which its own streak is drawn: brighter than what is only clipped.
const LAMP: f32 = 2.0;

/// Where grooves lie before a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Streaks {
    /// Direction across them, in cells of the map.
    across: Vec<[f32; 2]>,
    columns: usize,
    per_cell: u32,
    /// Pieces of a streak from its middle on to one side; with the other side their shares sum to 1.
    pieces: Vec<Piece>,
    /// Shares of light in cells of the streak of a lamp, from its middle on to one side.
    shares: Vec<f32>,
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

impl Streaks {
    /// Of what a coat does; none where it has no grooves.
    pub(super) fn of(samples: &Samples, f_px: f64) -> Option<Self> {
        if !samples.has_grooves {
            return None;
        }
        // The share within an angle, of k ∝ 1/(θ₀² + θ²).
        let whole = libm::atan(Scratches::MOST_ACROSS_RAD / Scratches::ACROSS_RAD);
        let within = |px: f64| {
            let rad = libm::atan(px / f_px);
            (libm::atan(rad / Scratches::ACROSS_RAD) / whole).min(1.0)
        };
        // Beyond two frames it is all one.
        let most = 2.0 * to_f64(samples.size.0.max(samples.size.1)) * f64::from(samples.per_cell);
        let reach_px = (libm::tan(Scratches::MOST_ACROSS_RAD) * f_px).min(most);
        Some(Self {
            across: samples.across.clone(),
            columns: samples.size.0,
            per_cell: samples.per_cell,
            pieces: pieces(reach_px, within),
            shares: shares(reach_px, within),
        })
    }

    /// The light of a frame turned by grooves.
    pub(super) fn over<const COLORS: usize>(
        &self,
        pyramid: &mut Pyramid<'_, COLORS>,
        (width, height): (usize, usize),
    ) -> Cells<COLORS> {
        let mut rest = pyramid.no_wider(f64::from(CELL_PX));
        let (columns, per_cell) = (rest.size.0, rest.per_cell as usize);
        // Of a cell that the frame cuts off: what it has of its light is what it has of its area.
        let part_of = |cell: usize| {
            let [x, y] = [cell % columns, cell / columns].map(|k| k * per_cell);
            let px = per_cell.min(width - x) * per_cell.min(height - y);
            to_f32(px) / to_f32(per_cell * per_cell)
        };
        let mut streaks = rest.clone();
        let mut lamps = Vec::new();
        for (cell, light) in rest.values_mut().iter_mut().enumerate() {
            let more = light.map(|value| (value - LAMP).max(0.0));
            if more.iter().any(|value| *value > 0.0) {
                lamps.push((cell, more.map(|value| part_of(cell) * value)));
                *light = light.map(|value| value.min(LAMP));
            }
        }
        streaks.values_mut().fill([0.0; COLORS]);
        for (cell, more) in lamps {
            self.draw(&mut streaks, cell, more);
        }
        streaks.add(&self.broad(&rest));
        streaks
    }

    /// Adds the streak of a lamp in a cell. It lies across the grooves before the lamp: before each of its places they have
    /// that direction, as arcs about one point have.
    fn draw<const COLORS: usize>(
        &self,
        streaks: &mut Cells<COLORS>,
        cell: usize,
        light: [f32; COLORS],
    ) {
        let (columns, rows) = streaks.size;
        let from = [cell % columns, cell / columns];
        let across = self.direction(from, streaks.per_cell);
        let from = from.map(to_f32);
        for side in [1.0, -1.0] {
            for (k, share) in self.shares.iter().enumerate() {
                let away = side * to_f32(k);
                let [x, y] = [from[0] + away * across[0], from[1] + away * across[1]];
                if x <= -1.0 || y <= -1.0 || x >= to_f32(columns) || y >= to_f32(rows) {
                    break;
                }
                streaks.add_at([x, y], light.map(|value| share * value));
            }
        }
    }

    /// The light of cells that are no lamps, turned.
    fn broad<const COLORS: usize>(&self, cells: &Cells<COLORS>) -> Cells<COLORS> {
        let small = match cells.per_cell < BROAD_PX {
            true => cells.halved(),
            false => cells.clone(),
        };
        let mut sizes = vec![small.clone()];
        for level in 1..LEVELS {
            let wider = sizes[level - 1].halved();
            sizes.push(wider);
        }
        let wide: Vec<Wide> = (sizes.iter().enumerate())
            .map(|(level, cells)| {
                let reach_px = (self.pieces.iter())
                    .filter(|piece| piece.level == level)
                    .fold(0.0, |most: f32, piece| most.max(piece.away_px));
                Wide::of(cells, reach_px)
            })
            .collect();
        // What comes from far changes as slowly as the cells that it comes from.
        let n_near = self.pieces.partition_point(|piece| piece.level == 0);
        let (near, far) = self.pieces.split_at(n_near);
        let mut broad = self.of_pieces(near, &small, &wide);
        broad.add(&self.of_pieces(far, &sizes[1], &wide));
        broad
    }

    /// What is turned to cells as wide as some from pieces of streaks.
    fn of_pieces<const COLORS: usize>(
        &self,
        pieces: &[Piece],
        Cells { size, per_cell, .. }: &Cells<COLORS>,
        wide: &[Wide],
    ) -> Cells<COLORS> {
        let mut out = vec![[0.0_f32; COLORS]; size.0 * size.1];
        vectorized(
            #[inline(always)]
            || {
                for (y, row) in out.chunks_exact_mut(size.0).enumerate() {
                    for (x, sum) in row.iter_mut().enumerate() {
                        *sum = self.of_cell(pieces, ([x, y], *per_cell), wide);
                    }
                }
            },
        );
        Cells::of_cells(out.as_flattened(), *size, *per_cell)
    }

    /// The light that is turned to the middle of a cell, so many px wide.
    #[inline(always)]
    fn of_cell<const COLORS: usize>(
        &self,
        pieces: &[Piece],
        (cell, per_cell): ([usize; 2], u32),
        wide: &[Wide],
    ) -> [f32; COLORS] {
        let across = self.direction(cell, per_cell);
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let at = cell.map(|k| (k as f32 + 0.5) * per_cell as f32);
        let mut sum = f32x4::ZERO;
        for piece in pieces {
            let cells = &wide[piece.level];
            for away in [piece.away_px, -piece.away_px] {
                let light = cells.at([at[0] + away * across[0], at[1] + away * across[1]]);
                sum += f32x4::splat(piece.share) * light;
            }
        }
        let sum = sum.to_array();
        std::array::from_fn(|c| sum[c])
    }

    /// Direction across grooves at a cell of a frame.
    fn direction(&self, [x, y]: [usize; 2], per_cell: u32) -> [f32; 2] {
        let middle = |k: usize| (2 * k + 1) * per_cell as usize / 2 / self.per_cell as usize;
        let last = self.across.len() / self.columns - 1;
        let at = middle(y).min(last) * self.columns + middle(x).min(self.columns - 1);
        self.across[at]
    }
}

/// Pieces of a streak of all that is no lamp, by the share of light within a way, px.
fn pieces(reach_px: f64, within: impl Fn(f64) -> f64) -> Vec<Piece> {
    let n = n_cells(reach_px, BROAD_PX);
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut k, mut last) = (0, 0.0);
    while k <= n {
        let level = ((k / PIECES + 1).ilog2() as usize).min(LEVELS - 1);
        let wide = 1 << level;
        let next = within((f64::from(k) + f64::from(wide) - 0.5) * f64::from(BROAD_PX));
        #[expect(
            clippy::cast_possible_truncation,
            reason = "px of a frame, a share of light"
        )]
        pieces.push(Piece {
            away_px: ((f64::from(k) + 0.5 * f64::from(wide - 1)) * f64::from(BROAD_PX)) as f32,
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
    pieces
}

/// Shares of light of the streak of a lamp in its cells, from its middle on to one side; the rest is beyond all frames.
fn shares(reach_px: f64, within: impl Fn(f64) -> f64) -> Vec<f32> {
    let mut last = 0.0;
    (0..=n_cells(reach_px, CELL_PX))
        .map(|k| {
            let next = within((f64::from(k) + 0.5) * f64::from(CELL_PX));
            #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
            let share = (0.5 * (next - last)) as f32;
            last = next;
            share
        })
        .collect()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "cells of a frame"
)]
fn n_cells(reach_px: f64, per_cell: u32) -> u32 {
    (reach_px / f64::from(per_cell)).ceil().max(1.0) as u32
}

#[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
fn to_f64(k: usize) -> f64 {
    k as f64
}

#[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
fn to_f32(k: usize) -> f32 {
    k as f32
}

/// The cells of a frame and, mirrored, what is beyond it.
struct Wide {
    /// Of each cell, with zeros after its colors.
    light: Vec<f32x4>,
    columns: usize,
    /// Cells beyond each side.
    beyond: f32,
    per_px: f32,
}

impl Wide {
    /// With as much beyond the frame as a way, px.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a frame"
    )]
    fn of<const COLORS: usize>(cells: &Cells<COLORS>, reach_px: f32) -> Self {
        let beyond = (reach_px / cells.per_cell as f32).ceil() as usize + 2;
        let (width, height) = cells.size;
        let sides = |n: usize| {
            (0..n + 2 * beyond).map(move |k| mirrored(k.cast_signed() - beyond.cast_signed(), n))
        };
        let columns: Vec<usize> = sides(width).collect();
        let light = sides(height)
            .flat_map(|y| columns.iter().map(move |x| y * width + x))
            .map(|cell| {
                let light = cells.cell(cell);
                f32x4::new(std::array::from_fn(|k| {
                    light.get(k).copied().unwrap_or(0.0)
                }))
            })
            .collect();
        Self {
            light,
            columns: columns.len(),
            beyond: beyond as f32,
            per_px: 1.0 / cells.per_cell as f32,
        }
    }

    /// The light at a place, px, on straight lines between the middles of cells; none beyond what is there.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a frame"
    )]
    #[inline(always)]
    fn at(&self, [x_px, y_px]: [f32; 2]) -> f32x4 {
        let (u, v) = (
            x_px * self.per_px + self.beyond - 0.5,
            y_px * self.per_px + self.beyond - 0.5,
        );
        let (x, y) = (u as i32, v as i32);
        let first = y as usize * self.columns + x as usize;
        let Some(cells) = self.light.get(first..first + self.columns + 2) else {
            return f32x4::ZERO;
        };
        let (s, t) = (u - x as f32, v - y as f32);
        let [above, below] = [0, self.columns].map(|k| between(cells[k], cells[k + 1], s));
        between(above, below, t)
    }
}
