//! A photograph sampled at the pixels of a frame.

use std::ops::Range;

use super::background::Background;
use super::picture::Photo;
use super::placement::Placement;
use crate::lit_runs::lit_runs;

/// Glass over one pixel: per color what it takes away, and which light it sends under light 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glass {
    pub(super) opacity: [f32; 3],
    pub(super) light: [f32; 3],
}

/// Opacity and light over a frame and a margin around it, row by row.
#[derive(Debug, Clone)]
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    background: Background,
    lanes: Lanes,
}

#[derive(Debug, Clone)]
enum Lanes {
    /// Opacity of each color; its light follows from the background.
    Three(Vec<[f32; 3]>),
    /// Opacity, and the light of each color.
    Four(Vec<[f32; 4]>),
}

impl Raster {
    /// The photograph over a frame of `width × height` px and `margin` px around it.
    ///
    /// A pixel shows the mean over its own square in the photograph where that is larger than a
    /// pixel of the photograph, else over the square of one such pixel about its middle: area
    /// averages when the photograph is shrunk, straight lines between its pixels when it is
    /// enlarged. It is read row by row and decoded on the way, so that a photograph of any size
    /// takes no more room than its codes. Beyond the photograph there is no glass.
    pub(super) fn new(
        photo: &Photo,
        placement: &Placement,
        (width, height): (usize, usize),
        margin: usize,
    ) -> Self {
        let size = photo.size();
        let columns = footprints(
            placement.left_px,
            placement.width_px,
            (width, margin),
            size.0 as usize,
        );
        let rows = footprints(
            placement.top_px,
            placement.height_px,
            (height, margin),
            size.1 as usize,
        );
        let background = photo.background();
        let lanes = match background {
            Background::Alpha => Lanes::Four(turned(
                sampled(photo, &columns, &rows),
                columns.len(),
                placement,
            )),
            Background::Black | Background::White => Lanes::Three(turned(
                sampled(photo, &columns, &rows),
                columns.len(),
                placement,
            )),
        };
        Self {
            width: columns.len(),
            height: rows.len(),
            background,
            lanes,
        }
    }

    pub(super) fn glass(&self, x: usize, y: usize) -> Glass {
        let at = y * self.width + x;
        match &self.lanes {
            Lanes::Four(lanes) => {
                let [opacity, red, green, blue] = lanes[at];
                Glass {
                    opacity: [opacity; 3],
                    light: [red, green, blue],
                }
            }
            Lanes::Three(lanes) => Glass {
                opacity: lanes[at],
                light: if self.background == Background::Black {
                    lanes[at]
                } else {
                    [0.0; 3]
                },
            },
        }
    }

    /// The background of its photograph.
    pub(super) fn background(&self) -> Background {
        self.background
    }

    /// Replaces all lanes, interleaved, by what a function makes of them.
    pub(super) fn mapped(
        self,
        three: impl FnOnce(&mut Vec<[f32; 3]>),
        four: impl FnOnce(&mut Vec<[f32; 4]>),
    ) -> Self {
        let mut lanes = self.lanes;
        match &mut lanes {
            Lanes::Three(lanes) => three(lanes),
            Lanes::Four(lanes) => four(lanes),
        }
        Self { lanes, ..self }
    }
}

/// Pixels of the photograph that a pixel of the frame is the mean of, with their weights.
#[derive(Debug, Clone)]
struct Footprint {
    first: usize,
    weights: Vec<f32>,
}

/// The footprints along one axis, of `n` pixels and `margin` more on either side.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "px of a photograph, clamped to it; weights as f32"
)]
fn footprints(
    start: f64,
    length: f64,
    (n, margin): (usize, usize),
    n_photo: usize,
) -> Vec<Footprint> {
    let px_per_px = length / n as f64;
    let half = 0.5 * px_per_px.max(1.0);
    (0..n + 2 * margin)
        .map(|k| {
            let middle = start + (k as f64 - margin as f64 + 0.5) * px_per_px;
            let (from, to) = (middle - half, middle + half);
            let end = n_photo as f64;
            let first = from.clamp(0.0, end).floor() as usize;
            let last = to.clamp(0.0, end).ceil() as usize;
            let weights = (first..last)
                .map(|at| {
                    let overlap = (to.min(at as f64 + 1.0) - from.max(at as f64)).max(0.0);
                    (overlap / (to - from)) as f32
                })
                .collect();
            Footprint { first, weights }
        })
        .collect()
}

/// The means over all footprints, row by row.
fn sampled<const L: usize>(
    photo: &Photo,
    columns: &[Footprint],
    rows: &[Footprint],
) -> Vec<[f32; L]> {
    let ends = |footprint: &Footprint| footprint.first + footprint.weights.len();
    let used = columns
        .iter()
        .filter(|footprint| !footprint.weights.is_empty());
    let first = used.clone().map(|footprint| footprint.first).min();
    let (first, last) = (first.unwrap_or(0), used.map(ends).max().unwrap_or(0));
    let mut read = vec![[0.0_f32; L]; last - first];
    // Rows of the photograph at the columns of the frame, as far as rows of the frame still need
    // them: footprints move down only.
    let mut waiting: Vec<MeanRow<L>> = Vec::new();
    let mut lanes = vec![[0.0_f32; L]; columns.len() * rows.len()];
    for (row, line) in rows
        .iter()
        .zip(lanes.chunks_exact_mut(columns.len().max(1)))
    {
        waiting.retain(|known| known.y >= row.first);
        for (y, weight) in (row.first..).zip(&row.weights) {
            if *weight <= 0.0 {
                continue;
            }
            if !waiting.iter().any(|known| known.y == y) {
                photo.read(y, first, &mut read);
                waiting.push(MeanRow::new(y, &read, first, columns));
            }
            if let Some(row) = waiting.iter().find(|known| known.y == y) {
                for run in &row.runs {
                    let sums = line[run.clone()].as_flattened_mut();
                    let means = row.means[run.clone()].as_flattened();
                    for (sum, mean) in sums.iter_mut().zip(means) {
                        *sum += weight * mean;
                    }
                }
            }
        }
    }
    lanes
}

/// The means of one row of the photograph over the columns' footprints.
struct MeanRow<const L: usize> {
    y: usize,
    means: Vec<[f32; L]>,
    /// Columns outside of which all is 0.
    runs: Vec<Range<usize>>,
}

impl<const L: usize> MeanRow<L> {
    /// From the pixels `first..` of a row.
    fn new(y: usize, read: &[[f32; L]], first: usize, columns: &[Footprint]) -> Self {
        let mut row = Self {
            y,
            means: vec![[0.0; L]; columns.len()],
            runs: Vec::new(),
        };
        let lit = lit_runs(read);
        let mut next = 0;
        for (at, column) in columns.iter().enumerate() {
            let start = column.first.saturating_sub(first);
            let end = start + column.weights.len();
            // Footprints move to the right only.
            while lit.get(next).is_some_and(|run| run.end <= start) {
                next += 1;
            }
            let Some(run) = lit.get(next) else { break };
            if run.start >= end {
                continue;
            }
            for (weight, pixel) in column.weights.iter().zip(&read[start..end]) {
                for (sum, lane) in row.means[at].iter_mut().zip(pixel) {
                    *sum += weight * lane;
                }
            }
            match row.runs.last_mut() {
                Some(run) if run.end == at => run.end = at + 1,
                _ => row.runs.push(at..at + 1),
            }
        }
        row
    }
}

/// Turned over as the placement says: exactly the mirror image.
fn turned<const L: usize>(
    mut lanes: Vec<[f32; L]>,
    width: usize,
    placement: &Placement,
) -> Vec<[f32; L]> {
    if placement.flip_horizontal {
        for row in lanes.chunks_exact_mut(width.max(1)) {
            row.reverse();
        }
    }
    if placement.flip_vertical {
        // All pixels turned round, and each row turned back.
        lanes.reverse();
        for row in lanes.chunks_exact_mut(width.max(1)) {
            row.reverse();
        }
    }
    lanes
}
