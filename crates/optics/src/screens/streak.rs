//! Light that grooves turn: a streak across them through each lamp.

use starbreak_deposit::Scratches;

use super::Samples;
use crate::pyramid::Cells;

/// Width of the cells in which streaks are, px: grooves of a pupil have more than one direction.
const CELL_PX: u32 = 4;

/// Where grooves lie before a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Streaks {
    /// Direction across them, in cells of the map.
    across: Vec<[f32; 2]>,
    columns: usize,
    per_cell: u32,
    /// Places on a streak, in cells from its middle on to one side, each with its share of light; with the other side they
    /// sum to 1.
    shares: Vec<(f32, f32)>,
}

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
        let mut shares = Vec::new();
        let (mut k, mut last) = (0, 0.0);
        while k <= n {
            // Far out light changes slowly: every second cell, then every fourth stands for its neighbors.
            let wide = match k {
                0..16 => 1,
                16..64 => 2,
                _ => 4,
            };
            let next = within(f64::from(k) + f64::from(wide) - 0.5);
            let sides = if k == 0 { 1.0 } else { 0.5 };
            #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
            let share = (sides * (next - last)) as f32;
            #[expect(clippy::cast_possible_truncation, reason = "cells of a frame")]
            let middle = (f64::from(k) + 0.5 * f64::from(wide - 1)) as f32;
            shares.push((middle, share));
            last = next;
            k += wide;
        }
        // The rest.
        if let Some((_, share)) = shares.last_mut() {
            #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
            let rest = (0.5 * (1.0 - last)) as f32;
            *share += rest;
        }
        Some(Self {
            across,
            columns: samples.size.0,
            per_cell: samples.per_cell,
            shares,
        })
    }

    /// The light of a frame turned by grooves.
    pub(super) fn over<const COLORS: usize>(&self, pixels: &Cells<COLORS>) -> Cells<COLORS> {
        let mut small = pixels.clone();
        while small.per_cell < CELL_PX && small.size.0.max(small.size.1) > 1 {
            small = small.halved();
        }
        let (columns, rows) = small.size;
        let mut out = Vec::with_capacity(columns * rows * COLORS);
        for y in 0..rows {
            for x in 0..columns {
                let [dx, dy] = self.direction([x, y], small.per_cell);
                let mut sum = [0.0_f32; COLORS];
                let mut add = |k: f32, share: f32| {
                    let at = [
                        mirrored(to_f32(x) + k * dx, columns),
                        mirrored(to_f32(y) + k * dy, rows),
                    ];
                    for (sum, value) in sum.iter_mut().zip(small.cell(at[1] * columns + at[0])) {
                        *sum += share * value;
                    }
                };
                for (k, share) in &self.shares {
                    add(*k, *share);
                    if *k > 0.0 {
                        add(-k, *share);
                    }
                }
                out.extend(sum);
            }
        }
        Cells::of_cells(&out, small.size, small.per_cell)
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

#[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
fn to_f32(k: usize) -> f32 {
    k as f32
}

/// The cell of a place; beyond the frame it goes on mirrored.
fn mirrored(place: f32, n: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, reason = "cells of a frame")]
    let whole = (place + 0.5).floor() as isize;
    crate::pyramid::mirrored(whole, n)
}
