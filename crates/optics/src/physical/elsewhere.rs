//! Light from elsewhere in the frame: what mirrors and chips show of the scene itself.

use super::overlay::OverlayLayer;
use crate::maps::CHUNK;

/// Light from elsewhere in the frame for the pixels of a run.
#[derive(Debug, Clone)]
pub(super) struct Elsewhere {
    /// Its share.
    pub(super) share: [f32; CHUNK],
    /// The place, px.
    pub(super) u: [f32; CHUNK],
    pub(super) v: [f32; CHUNK],
    /// Over how much of the frame, px, it is averaged: where the blur mixes two mirrors that show
    /// places far apart, the mean place is the middle of much, not a picture of its own.
    pub(super) width: [f32; CHUNK],
}

/// A mirror's picture moves by at most this much, px, from one pixel to the next.
pub(super) const ONE_MIRROR: f32 = 2.0;

/// Averages over less, px, are the pixel itself, and over more come from the coarse scene alone.
const FINE_WIDTHS: [f32; 2] = [1.5, 8.0];

/// Side of a cell of the finest coarse scene, px.
const CELL_PX: usize = 16;

impl OverlayLayer {
    /// The light of all runs from elsewhere, weighted by its share.
    pub(super) fn gather<const COLORS: usize>(
        &self,
        size: (usize, usize),
        light: impl Fn(usize, usize) -> f32,
    ) -> Vec<[[f32; COLORS]; CHUNK]> {
        let is_wide = |other: &Elsewhere| other.width.iter().any(|width| *width > FINE_WIDTHS[0]);
        let coarse = if self.elsewhere.iter().any(is_wide) {
            Coarse::of::<COLORS>(size, &light)
        } else {
            Coarse { levels: Vec::new() }
        };
        self.elsewhere
            .iter()
            .map(|other| {
                let mut gathered = [[0.0; COLORS]; CHUNK];
                for (k, gathered) in gathered.iter_mut().enumerate() {
                    let share = other.share[k];
                    if share <= 0.0 {
                        continue;
                    }
                    let place = [other.u[k], other.v[k]];
                    let width = other.width[k];
                    let wide = ((width - FINE_WIDTHS[0]) / (FINE_WIDTHS[1] - FINE_WIDTHS[0]))
                        .clamp(0.0, 1.0);
                    if wide < 1.0 {
                        let fine = between::<COLORS>(size, place, &light);
                        for (sum, light) in gathered.iter_mut().zip(fine) {
                            *sum += share * (1.0 - wide) * light;
                        }
                    }
                    if wide > 0.0 {
                        let mean = coarse.mean::<COLORS>(place, width);
                        for (sum, light) in gathered.iter_mut().zip(mean) {
                            *sum += share * wide * light;
                        }
                    }
                }
                gathered
            })
            .collect()
    }
}

/// Light at a place, px, between the middles of pixels; beyond the frame that of its border.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "px of a frame"
)]
pub(super) fn between<const COLORS: usize>(
    (width, height): (usize, usize),
    [u, v]: [f32; 2],
    light: impl Fn(usize, usize) -> f32,
) -> [f32; COLORS] {
    let u = (u - 0.5).clamp(0.0, (width - 1) as f32);
    let v = (v - 0.5).clamp(0.0, (height - 1) as f32);
    let (x, y) = (u as usize, v as usize);
    let (s, t) = (u - x as f32, v - y as f32);
    let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
    let [top_left, top_right] = [y * width + x, y * width + right];
    let [bottom_left, bottom_right] = [below * width + x, below * width + right];
    let mut mean = [0.0; COLORS];
    for (c, mean) in mean.iter_mut().enumerate() {
        let [a, b] = [light(top_left, c), light(bottom_left, c)];
        let top = a + s * (light(top_right, c) - a);
        let bottom = b + s * (light(bottom_right, c) - b);
        *mean = top + t * (bottom - top);
    }
    mean
}

/// The scene in large cells: means of a few pixels of each, then of ever more cells.
struct Coarse {
    levels: Vec<Level>,
}

struct Level {
    size: (usize, usize),
    cell_px: f32,
    /// Colors of the cells, row by row.
    light: Vec<f32>,
}

impl Coarse {
    fn of<const COLORS: usize>(
        (width, height): (usize, usize),
        light: impl Fn(usize, usize) -> f32,
    ) -> Self {
        let size = (width.div_ceil(CELL_PX), height.div_ceil(CELL_PX));
        let mut cells = Vec::with_capacity(size.0 * size.1 * COLORS);
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            for c in 0..COLORS {
                let mut sum = 0.0;
                for (dx, dy) in [(3, 5), (11, 3), (5, 13), (13, 11)] {
                    let (x, y) = (
                        (x * CELL_PX + dx).min(width - 1),
                        (y * CELL_PX + dy).min(height - 1),
                    );
                    sum += light(y * width + x, c);
                }
                cells.push(0.25 * sum);
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "16 px")]
        let mut levels = vec![Level {
            size,
            cell_px: CELL_PX as f32,
            light: cells,
        }];
        while let Some(last) = levels
            .last()
            .filter(|last| last.size.0.max(last.size.1) > 1)
        {
            let next = last.halved::<COLORS>();
            levels.push(next);
        }
        Self { levels }
    }

    /// Mean light about a place, px, over about `width` px to each side.
    fn mean<const COLORS: usize>(&self, [u, v]: [f32; 2], width: f32) -> [f32; COLORS] {
        let level = self
            .levels
            .iter()
            .find(|level| level.cell_px >= 2.0 * width)
            .or(self.levels.last());
        level.map_or([0.0; COLORS], |level| {
            let place = [u, v].map(|place| place / level.cell_px);
            between(level.size, place, |at, c| level.light[at * COLORS + c])
        })
    }
}

impl Level {
    fn halved<const COLORS: usize>(&self) -> Self {
        let (width, height) = self.size;
        let size = (width.div_ceil(2), height.div_ceil(2));
        let mut light = Vec::with_capacity(size.0 * size.1 * COLORS);
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            for c in 0..COLORS {
                let (right, below) = ((2 * x + 1).min(width - 1), (2 * y + 1).min(height - 1));
                let sum: f32 = [
                    (2 * x, 2 * y),
                    (right, 2 * y),
                    (2 * x, below),
                    (right, below),
                ]
                .into_iter()
                .map(|(x, y)| self.light[(y * width + x) * COLORS + c])
                .sum();
                light.push(0.25 * sum);
            }
        }
        Self {
            size,
            cell_px: 2.0 * self.cell_px,
            light,
        }
    }
}
