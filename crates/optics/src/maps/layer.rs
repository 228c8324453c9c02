//! Facets and drawn cells of a frame, blurred: the scattering half of the maps.
//!
//! Cracks are thin and their blur is wide, so each *covered* cell is scattered over the image of
//! the pupil that its own depth has; a running sum along each row turns the few steps per row of
//! a disc into the disc. Cells are of the size that suits the disc: three to twelve of them per
//! radius, four of them per pixel at most; of large discs 24 to 48, so that neither time
//! nor room grows with the disc. Coverage of facets is found on cells of half that size, which are then shared
//! among the four nearest cells, so that a facet keeps its place to a fraction of a cell.

use std::collections::BTreeMap;

use super::active::{Active, Coverage};
use super::cells::Row;
use super::drawn::{Drawing, Reaching};
use super::emit::Emitter;
use super::kernel::{Kernel, Pupil};
use super::lane_runs::{CHUNK, LaneRuns};
use super::level::{Level, MOST_RADIUS_PX};
use super::placed::{columns_of, placed};

/// A flat piece of something, as it lies in the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Facet<const L: usize> {
    /// Corners of a convex quadrilateral, px.
    pub(crate) corners: [[f64; 2]; 4],
    /// What it sends along each lane, per unit of coverage.
    pub(crate) lanes: [f32; L],
    /// Change of the last two lanes per px along x and y, from the mean of the corners.
    pub(crate) lean: [[f32; 2]; 2],
    /// Signed radius of its blur, px; negative turns the pupil over.
    pub(crate) radius_px: f64,
}

/// Radii within this ratio share a kernel.
const RADIUS_RATIO: f64 = 1.005;

/// So much is drawn all over a frame.
const MUCH: usize = 1000;

/// Cells of a row that are summed up, or left out, together.
const BLOCK: usize = 16;

/// The sum of all facets over the frame and of what is drawn, each spread by its disc.
///
/// The first `n_shares` lanes are shares of coverage: where facets overlap they are scaled, with
/// all other lanes, to sum to at most 1.
pub(crate) fn spread<const L: usize>(
    facets: &[Facet<L>],
    drawn: &[Reaching<'_, L>],
    n_shares: usize,
    pupil: Pupil,
    size: (usize, usize),
) -> LaneRuns<L> {
    spread_on(
        [Level::of, Level::of_drawn],
        (facets, drawn),
        n_shares,
        pupil,
        size,
    )
}

/// The same on the cells that are chosen for a radius, px: those of facets, and of what is drawn.
fn spread_on<const L: usize>(
    [of_facet, of_drawn]: [impl Fn(f64) -> Level; 2],
    (facets, drawn): (&[Facet<L>], &[Reaching<'_, L>]),
    n_shares: usize,
    pupil: Pupil,
    (width, height): (usize, usize),
) -> LaneRuns<L> {
    // Room that is not used is not touched either; where much is drawn it is everywhere.
    let part = if drawn.len() < MUCH { 8 } else { 1 };
    let n_runs = width.div_ceil(CHUNK) * height / part;
    let mut frame = LaneRuns::with_room(width, height, n_runs);
    let mut levels: BTreeMap<Level, Things<'_, L>> = BTreeMap::new();
    for facet in facets {
        let level = of_facet(facet.radius_px);
        levels.entry(level).or_default().0.push(facet);
    }
    for drawn in drawn {
        let level = of_drawn(drawn.0.radius_px);
        levels.entry(level).or_default().1.push(drawn);
    }
    for (level, things) in levels {
        let layer = Layer::new(level, &things, n_shares, pupil, (width, height));
        pulp::Arch::new().dispatch(RunLayer {
            layer,
            things: &things,
            frame: &mut frame,
        });
    }
    frame.sort();
    frame
}

/// Facets, and what is drawn.
type Things<'a, const L: usize> = (Vec<&'a Facet<L>>, Vec<&'a Reaching<'a, L>>);

/// All rows of a layer, compiled once more for processors with AVX2, as far as it is inlined. No
/// result depends on it: nothing is fused.
struct RunLayer<'a, const L: usize> {
    layer: Layer<L>,
    things: &'a Things<'a, L>,
    frame: &'a mut LaneRuns<L>,
}

impl<const L: usize> pulp::WithSimd for RunLayer<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: pulp::Simd>(self, _: V) {
        self.layer.run(self.things, self.frame);
    }
}

/// a + s b, of whole arrays, of which the compiler makes vectors.
#[inline(always)]
pub(super) fn add_scaled<const L: usize>(a: [f32; L], s: f32, b: [f32; L]) -> [f32; L] {
    let mut sum = a;
    let mut l = 0;
    while l < L {
        sum[l] = a[l] + s * b[l];
        l += 1;
    }
    sum
}

/// a + b, of whole arrays.
#[inline(always)]
pub(crate) fn add_arrays<const L: usize>(a: [f32; L], b: [f32; L]) -> [f32; L] {
    let mut sum = a;
    let mut l = 0;
    while l < L {
        sum[l] = a[l] + b[l];
        l += 1;
    }
    sum
}

/// One size of cells.
pub(super) struct Layer<const L: usize> {
    pub(super) level: Level,
    pub(super) n_shares: usize,
    /// Cells per px.
    pub(super) scale: f64,
    /// Cells around the frame on each side.
    pub(super) margin: usize,
    /// Cells across and down, margins included.
    pub(super) columns: usize,
    rows: usize,
    kernels: Vec<Kernel>,
    /// Kernel of each facet, then of each thing that is drawn.
    kernel_of: Vec<u32>,
    /// Steps of the rows that discs now reach, a power of two of them, each with room on both
    /// sides for discs that reach out of the margin; of `stride` columns from that of `offset` on,
    /// as far as there is something.
    ring: Vec<[f32; L]>,
    ring_mask: usize,
    stride: usize,
    offset: usize,
    /// Which blocks of each row of the ring are touched, and how many words hold those of a row.
    touched: Vec<u64>,
    n_words: usize,
    /// Blocks that the present row of cells touches, and cells side by side; empty between rows.
    scattered: Vec<u64>,
    run_lanes: Vec<[f32; L]>,
    reach: usize,
}

impl<const L: usize> Layer<L> {
    fn new(
        level: Level,
        (facets, drawn): &Things<'_, L>,
        n_shares: usize,
        pupil: Pupil,
        (width, height): (usize, usize),
    ) -> Self {
        let exponent = level.exponent;
        let scale = libm::scalbn(1.0, exponent);
        let radii = facets.iter().map(|facet| facet.radius_px);
        let radii = radii.chain(drawn.iter().map(|(reaches, _)| reaches.radius_px));
        let (kernels, kernel_of) = kernels_of(scale, radii, pupil);
        let reach = kernels.iter().map(Kernel::reach).max().unwrap_or(0);
        // A whole number of px, and of cells.
        let step = 1_usize << exponent.max(0);
        let margin = (reach + 2).div_ceil(step) * step;
        let cells = |px: usize| {
            if exponent >= 0 {
                px << exponent
            } else {
                px.div_ceil(1 << -exponent) + 1
            }
        };
        let (columns, rows) = (cells(width) + 2 * margin, cells(height) + 2 * margin);
        let ring_rows = (2 * reach + 1).next_power_of_two();
        // Whole blocks, so that it does not show where they begin.
        let [first, end] = if drawn.is_empty() {
            columns_of(facets, scale, (margin, columns))
        } else {
            [0, columns]
        };
        let offset = first / BLOCK * BLOCK;
        let stride = (end + 2 * reach)
            .next_multiple_of(BLOCK)
            .min(columns + 2 * reach)
            - offset;
        let n_words = stride.div_ceil(64 * BLOCK);
        Self {
            level,
            n_shares,
            scale,
            margin,
            columns,
            rows,
            kernels,
            kernel_of,
            ring: vec![[0.0; L]; ring_rows * stride],
            ring_mask: ring_rows - 1,
            stride,
            offset,
            touched: vec![0; ring_rows * n_words],
            n_words,
            scattered: vec![0; n_words],
            run_lanes: Vec::new(),
            reach,
        }
    }

    #[inline(always)]
    fn run(mut self, (facets, drawn): &Things<'_, L>, frame: &mut LaneRuns<L>) {
        let per_cell = if self.level.is_halved { 2 } else { 1 };
        let fine_rows = self.rows * per_cell;
        let waiting = placed(
            facets.iter().map(|facet| facet.corners),
            self.scale * if self.level.is_halved { 2.0 } else { 1.0 },
            self.margin * per_cell,
            (self.columns * per_cell, fine_rows),
        );
        let mut waiting = waiting.iter().peekable();
        let mut drawing = Drawing::new(drawn, &self.kernel_of[facets.len()..]);
        let mut active: Vec<Active<L>> = Vec::new();
        let mut spare: Vec<Vec<f32>> = Vec::new();
        let mut coverage = Coverage::new(self.columns * per_cell, self.level);
        let mut cells = Row::new(self.columns);
        let mut emitter = Emitter::new(
            self.level.exponent,
            self.margin,
            self.columns,
            self.n_shares,
        );
        for fine_row in 0..fine_rows {
            while let Some(placed) = waiting.next_if(|placed| placed.first <= fine_row) {
                let facet = facets[placed.facet];
                let kernel = self.kernel_of[placed.facet];
                let slots = spare.pop().unwrap_or_default();
                active.push(Active::new(placed, facet, kernel, &self, slots));
            }
            coverage.cover(fine_row, &active);
            coverage.share(fine_row, &mut active);
            // The second half of the next row was the last to share with this one.
            let complete = if per_cell == 1 {
                Some(fine_row)
            } else {
                (fine_row % 2 == 1)
                    .then(|| (fine_row / 2).checked_sub(1))
                    .flatten()
            };
            if let Some(row) = complete {
                for facet in &mut active {
                    facet.hand_on(row, &self, &mut cells);
                }
                active.retain_mut(|facet| {
                    let stays = facet.last_row > row;
                    if !stays {
                        spare.push(std::mem::take(&mut facet.slots));
                    }
                    stays
                });
                drawing.hand_on(row, &self, &mut cells);
                self.finish(row, &mut cells, &mut emitter, frame);
            }
        }
        for row in self.rows - per_cell + 1..self.rows + self.reach {
            for facet in &mut active {
                facet.hand_on(row, &self, &mut cells);
            }
            drawing.hand_on(row, &self, &mut cells);
            self.finish(row, &mut cells, &mut emitter, frame);
        }
    }

    /// Scatters a row that is complete, and hands on the row that no later disc reaches.
    #[inline(always)]
    fn finish(
        &mut self,
        row: usize,
        cells: &mut Row<L>,
        emitter: &mut Emitter<L>,
        frame: &mut LaneRuns<L>,
    ) {
        if row < self.rows {
            self.scatter(row, cells);
        }
        self.finish_row(row, emitter, frame);
    }

    /// Scatters the cells of a row over their discs, and empties them. Rows of the ring begin
    /// `reach` before those of the cells.
    #[inline(always)]
    fn scatter(&mut self, row: usize, cells: &mut Row<L>) {
        let mut touched = std::mem::take(&mut self.scattered);
        let (mut next, mut lanes) = (0, std::mem::take(&mut self.run_lanes));
        while let Some((column, kernel)) = cells.take_run(next, &mut lanes) {
            next += lanes.len();
            let (left, row) = (column + self.reach - self.offset, row + self.reach);
            let kernel = &self.kernels[kernel as usize];
            for stretch in kernel.stretches() {
                let slot = row.wrapping_add_signed(stretch.dy as isize) & self.ring_mask;
                let line = slot * self.stride + left;
                for end in &stretch.ends {
                    let at = line.wrapping_add_signed(end.dx as isize);
                    if let Some(steps) = self.ring.get_mut(at..=at + lanes.len()) {
                        add_run(steps, end.steps, &lanes);
                    }
                }
            }
            let reach = kernel.reach();
            let right = left + lanes.len() - 1;
            for block in (left - reach) / BLOCK..=(right + reach) / BLOCK {
                if let Some(word) = touched.get_mut(block / 64) {
                    *word |= 1 << (block % 64);
                }
            }
        }
        self.run_lanes = lanes;
        cells.clear();
        if touched.iter().any(|word| *word > 0) {
            for y in row..=row + 2 * self.reach {
                let first = (y & self.ring_mask) * self.n_words;
                for (word, touched) in self.touched[first..].iter_mut().zip(&touched) {
                    *word |= touched;
                }
            }
            touched.fill(0);
        }
        self.scattered = touched;
    }

    /// Sums up the row of the ring that no later disc reaches, hands it on, and clears it.
    #[inline(always)]
    fn finish_row(&mut self, ring_row: usize, emitter: &mut Emitter<L>, frame: &mut LaneRuns<L>) {
        let slot = ring_row & self.ring_mask;
        let (stride, offset) = (self.stride, self.offset);
        emitter.begin_row();
        let line = &mut self.ring[slot * stride..][..stride];
        let words = &mut self.touched[slot * self.n_words..][..self.n_words];
        let row = ring_row.checked_sub(self.reach);
        let mut next = 0;
        while let Some([first, end]) = run_of_blocks(words, next) {
            next = end;
            let [first, end] = [first * BLOCK, (end * BLOCK).min(stride)];
            // The columns of cells among them.
            let within =
                [first, end].map(|at| (at + offset).clamp(self.reach, self.reach + self.columns));
            let cells = within.map(|at| at - self.reach);
            let within = within.map(|at| at - offset);
            let mut sum = [0.0_f32; L];
            for step in &line[first..within[0]] {
                sum = add_arrays(sum, *step);
            }
            let sums = line[within[0]..within[1]].iter().map(|step| {
                sum = add_arrays(sum, *step);
                sum
            });
            if let Some(row) = row {
                emitter.take_run(row, cells, sums, frame);
            }
            line[first..end].fill([0.0; L]);
        }
        words.fill(0);
        if let Some(row) = row {
            emitter.end_row(row, frame);
        }
    }
}

/// Adds two steps for each of some cells side by side, each cell's second one where the next cell
/// has its first.
#[inline(always)]
fn add_run<const L: usize>(to: &mut [[f32; L]], [one, two]: [f32; 2], cells: &[[f32; L]]) {
    let ([first, between @ .., last], Some(first_cell), Some(last_cell)) =
        (to, cells.first(), cells.last())
    else {
        return;
    };
    // A sum that began with 0 is never −0, so that there is nothing to add of no cell.
    *first = add_scaled(*first, one, *first_cell);
    for (step, beside) in between.iter_mut().zip(cells.windows(2)) {
        *step = add_scaled(add_scaled(*step, two, beside[0]), one, beside[1]);
    }
    *last = add_scaled(*last, two, *last_cell);
}

/// The next blocks from `start` on of which the bits are set: the first of them and the one after
/// the last.
fn run_of_blocks(words: &[u64], start: usize) -> Option<[usize; 2]> {
    let n = 64 * words.len();
    let next = |from: usize, is_set: bool| {
        let mut at = from;
        while at < n {
            let word = if is_set {
                words[at / 64]
            } else {
                !words[at / 64]
            };
            let rest = word >> (at % 64);
            if rest > 0 {
                return at + rest.trailing_zeros() as usize;
            }
            at = (at / 64 + 1) * 64;
        }
        n
    };
    let first = next(start, true);
    (first < n).then(|| [first, next(first, false)])
}

/// The kernels that discs of some radii, px, need, and which each needs.
fn kernels_of(
    scale: f64,
    radii: impl Iterator<Item = f64>,
    pupil: Pupil,
) -> (Vec<Kernel>, Vec<u32>) {
    let ratio = libm::log(RADIUS_RATIO);
    let mut kernels = Vec::new();
    let mut known: BTreeMap<i32, u32> = BTreeMap::new();
    let kernel_of = radii
        .map(|radius_px| {
            let radius = radius_px.clamp(-MOST_RADIUS_PX, MOST_RADIUS_PX) * scale;
            #[expect(clippy::cast_possible_truncation, reason = "logarithms")]
            let key = (libm::log(radius.abs().max(1e-3)) / ratio).round() as i32;
            *known
                .entry(2 * key + i32::from(radius < 0.0))
                .or_insert_with(|| {
                    let rounded = libm::exp(f64::from(key) * ratio);
                    kernels.push(Kernel::new(pupil, rounded.copysign(radius)));
                    #[expect(clippy::cast_possible_truncation, reason = "some hundreds")]
                    let place = (kernels.len() - 1) as u32;
                    place
                })
        })
        .collect();
    (kernels, kernel_of)
}

#[cfg(test)]
#[path = "layer_tests.rs"]
mod tests;
