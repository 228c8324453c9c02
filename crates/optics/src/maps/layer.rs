//! Facets of a frame, covered and blurred: the scattering half of the maps.
//!
//! Cracks are thin and their blur is wide, so each *covered* cell is scattered over the image of
//! the pupil that its own depth has; a running sum along each row turns the few steps per row of
//! a disc into the disc. Cells are of the size that suits the disc: four to twelve of them per
//! radius, between four per pixel and one per eight pixels across. Coverage is found on cells of
//! half that size, which are then shared among the four nearest cells, so that a facet keeps its
//! place to a fraction of a cell.

use std::collections::BTreeMap;

use super::chunks::{CHUNK, Chunks};
use super::kernel::{Kernel, Pupil};
use super::raster::Polygon;

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

/// Fewest cells per radius of a disc where cells are no larger than pixels, and where they are.
const CELLS_PER_RADIUS: [f64; 2] = [4.0, 6.0];

/// Exponents of two of the finest and the coarsest number of cells per pixel.
const LEVELS: std::ops::RangeInclusive<i32> = -3..=2;

/// Discs of fewer cells are scattered from the cells that were covered, not from shared ones:
/// sharing would blur more than the disc.
const FEW_CELLS: f64 = 0.5;

/// A disc of a smaller radius, px, is a point.
const IN_FOCUS_PX: f64 = 0.02;

/// Radii within this ratio share a kernel.
const RADIUS_RATIO: f64 = 1.005;

/// Shares below this are none; it is far below a step of an 8-bit image.
const LEAST_SHARE: f32 = 2e-5;

/// The sum of all facets over the frame, each spread by its disc.
///
/// The first `n_shares` lanes are shares of coverage: where facets overlap they are scaled, with
/// all other lanes, to sum to at most 1.
pub(crate) fn spread<const L: usize>(
    facets: &[Facet<L>],
    n_shares: usize,
    pupil: Pupil,
    (width, height): (usize, usize),
) -> Chunks<L> {
    let mut frame = Chunks::new(width, height);
    let mut levels: BTreeMap<Level, Vec<&Facet<L>>> = BTreeMap::new();
    for facet in facets {
        let level = Level::of(facet.radius_px);
        levels.entry(level).or_default().push(facet);
    }
    for (level, facets) in levels {
        Layer::new(level, &facets, n_shares, pupil, (width, height)).run(&facets, &mut frame);
    }
    frame
}

/// A size of cells, and whether coverage is found on halves of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Level {
    /// Cells per px as a power of two.
    exponent: i32,
    is_halved: bool,
}

impl Level {
    fn of(radius_px: f64) -> Self {
        if radius_px.abs() < IN_FOCUS_PX {
            // Exact coverage of the pixels themselves.
            return Self {
                exponent: 0,
                is_halved: false,
            };
        }
        let exponent_for = |cells: f64| -> i32 {
            // Also right for a radius of 0, whose logarithm is −∞.
            let exact = libm::log2(cells / radius_px.abs()).clamp(-9.0, 9.0);
            #[expect(clippy::cast_possible_truncation, reason = "clamped")]
            let exponent = exact.ceil() as i32;
            exponent.clamp(*LEVELS.start(), *LEVELS.end())
        };
        let [fine, coarse] = CELLS_PER_RADIUS.map(exponent_for);
        let exponent = fine.max(coarse.min(0));
        Self {
            exponent,
            is_halved: radius_px.abs() * f64::exp2(f64::from(exponent)) >= FEW_CELLS,
        }
    }

    /// Weights by which a half of a cell, a quarter of a cell off its middle, is shared along one
    /// axis: with the cell on its far side, its own, the one on its near side.
    ///
    /// They keep sum and mean, and their second moment, cells², makes up for all that blurs
    /// besides the disc and the pixel itself: the half's own width, and for coarse cells the
    /// kernel's cells and the straight lines between cells.
    fn weights(self) -> [f32; 3] {
        let straight = if self.exponent >= 0 {
            0.0
        } else {
            1.0 / 12.0 + 1.0 / 6.0
        };
        let second = 1.0 / 16.0 - 1.0 / 48.0 - straight;
        [0.5 * (second - 0.25), 1.0 - second, 0.5 * (second + 0.25)]
    }
}

/// What a grid cell holds of the facets of one row.
#[derive(Debug, Clone, Copy)]
struct Cell<const L: usize> {
    lanes: [f32; L],
    /// Kernel of what covers most of it, and how much that is.
    kernel: u32,
    most: f32,
    is_touched: bool,
}

/// A row of cells in the making.
struct Row<const L: usize> {
    cells: Vec<Cell<L>>,
    touched: Vec<usize>,
}

impl<const L: usize> Row<L> {
    fn new(n: usize) -> Self {
        let cell = Cell {
            lanes: [0.0; L],
            kernel: 0,
            most: 0.0,
            is_touched: false,
        };
        Self {
            cells: vec![cell; n],
            touched: Vec::new(),
        }
    }

    /// A cell that will be added to.
    fn cell(&mut self, column: usize, kernel: u32, covers: f32) -> &mut Cell<L> {
        let cell = &mut self.cells[column];
        if !cell.is_touched {
            cell.is_touched = true;
            self.touched.push(column);
            cell.kernel = kernel;
            cell.most = covers;
        } else if covers > cell.most {
            cell.kernel = kernel;
            cell.most = covers;
        }
        cell
    }

    /// Adds a part of some lanes to a cell, if it is one of the row's.
    fn add(&mut self, column: usize, part: f32, lanes: &[f32; L], from: &Cell<L>) {
        if column < self.cells.len() {
            let to = self.cell(column, from.kernel, part * from.most);
            let sum = to.lanes;
            to.lanes = std::array::from_fn(|l| sum[l] + part * lanes[l]);
        }
    }

    /// Empties the touched cells, each given to `each` before.
    fn drain(&mut self, mut each: impl FnMut(usize, &Cell<L>)) {
        for column in self.touched.drain(..) {
            let cell = &mut self.cells[column];
            each(column, cell);
            cell.lanes = [0.0; L];
            cell.is_touched = false;
        }
    }
}

/// One size of cells.
struct Layer<const L: usize> {
    level: Level,
    n_shares: usize,
    /// Cells per px.
    scale: f64,
    /// Cells around the frame on each side.
    margin: usize,
    /// Cells across and down, margins included.
    columns: usize,
    rows: usize,
    kernels: Vec<Kernel>,
    /// Kernel of each facet.
    kernel_of: Vec<u32>,
    /// Steps of the rows that discs now reach, a power of two of them, each with room on both
    /// sides for discs that reach out of the margin.
    ring: Vec<[f32; L]>,
    ring_mask: usize,
    /// Touched cells of each row of the ring: first and last.
    spans: Vec<[usize; 2]>,
    reach: usize,
}

impl<const L: usize> Layer<L> {
    fn new(
        level: Level,
        facets: &[&Facet<L>],
        n_shares: usize,
        pupil: Pupil,
        (width, height): (usize, usize),
    ) -> Self {
        let exponent = level.exponent;
        let scale = f64::exp2(f64::from(exponent));
        let (kernels, kernel_of) = kernels_of(scale, facets, pupil);
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
        Self {
            level,
            n_shares,
            scale,
            margin,
            columns,
            rows,
            kernels,
            kernel_of,
            ring: vec![[0.0; L]; ring_rows * (columns + 2 * reach)],
            ring_mask: ring_rows - 1,
            spans: vec![[usize::MAX, 0]; ring_rows],
            reach,
        }
    }

    fn run(mut self, facets: &[&Facet<L>], frame: &mut Chunks<L>) {
        let per_cell = if self.level.is_halved { 2 } else { 1 };
        let fine = self.scale * f64::from(per_cell);
        let per_cell = per_cell as usize;
        let (columns, rows) = (self.columns * per_cell, self.rows * per_cell);
        let margin = self.margin * per_cell;
        let mut waiting = placed(facets, fine, margin, (columns, rows))
            .into_iter()
            .peekable();
        let mut active: Vec<Placed> = Vec::new();
        let mut covered = Row::new(columns + 2);
        let mut across = Row::new(self.columns);
        let mut shared = [0; 3].map(|_| Row::new(self.columns));
        let mut scratch = vec![0.0_f32; columns + 3];
        let mut emitter = Emitter::new(
            self.level.exponent,
            self.margin,
            self.columns,
            self.n_shares,
        );
        for fine_row in 0..rows {
            while let Some(placed) = waiting.next_if(|placed| placed.first <= fine_row) {
                active.push(placed);
            }
            active.retain(|placed| placed.last > fine_row);
            for placed in &active {
                let facet = facets[placed.facet];
                let kernel = self.kernel_of[placed.facet];
                cover(
                    placed,
                    facet,
                    (fine_row, margin, fine, kernel),
                    self.n_shares,
                    &mut scratch,
                    &mut covered,
                );
            }
            self.share(fine_row, &mut covered, &mut across, &mut shared);
            // The second half of the next row was the last to share with this one.
            let complete = if per_cell == 1 {
                Some(fine_row)
            } else {
                (fine_row % 2 == 1)
                    .then(|| (fine_row / 2).checked_sub(1))
                    .flatten()
            };
            if let Some(row) = complete {
                self.finish(row, &mut shared, &mut emitter, frame);
            }
        }
        for row in self.rows - per_cell + 1..self.rows + self.reach {
            self.finish(row, &mut shared, &mut emitter, frame);
        }
    }

    /// Scatters a row that is complete, and hands on the row that no later disc reaches.
    fn finish(
        &mut self,
        row: usize,
        shared: &mut [Row<L>; 3],
        emitter: &mut Emitter<L>,
        frame: &mut Chunks<L>,
    ) {
        if row < self.rows {
            self.scatter(row, &mut shared[row % 3]);
        }
        if let Some(row) = row.checked_sub(self.reach) {
            self.finish_row(row, emitter, frame);
        }
    }

    /// Shares the covered cells of a row of halves among the cells of three rows, first along the
    /// row and then across; without halves hands them on as they are. `across` is empty before
    /// and after.
    fn share(
        &self,
        fine_row: usize,
        covered: &mut Row<L>,
        across: &mut Row<L>,
        shared: &mut [Row<L>; 3],
    ) {
        let n_shares = self.n_shares;
        let weights = self.level.weights();
        covered.drain(|column, cell| {
            let mut lanes = cell.lanes;
            let share: f32 = lanes[..n_shares].iter().sum();
            if share > 1.0 {
                for lane in &mut lanes {
                    *lane /= share;
                }
            }
            if self.level.is_halved {
                // A cell's value is the mean over its halves.
                for (column, part) in shares_of(column, weights) {
                    across.add(column, 0.5 * part, &lanes, cell);
                }
            } else {
                shared[fine_row % 3].add(column, 1.0, &lanes, cell);
            }
        });
        if !self.level.is_halved {
            return;
        }
        across.drain(|column, cell| {
            for (row, part) in shares_of(fine_row, weights) {
                if row < self.rows {
                    shared[row % 3].add(column, 0.5 * part, &cell.lanes, cell);
                }
            }
        });
    }

    /// Scatters the cells of a row over their discs, and empties them.
    fn scatter(&mut self, row: usize, cells: &mut Row<L>) {
        let stride = self.columns + 2 * self.reach;
        cells.drain(|column, cell| {
            let lanes = cell.lanes;
            let middle = (column + self.reach).cast_signed();
            for (dy, dx, steps) in self.kernels[cell.kernel as usize].runs() {
                let Some(y) = row.checked_add_signed(dy as isize) else {
                    continue;
                };
                let slot = y & self.ring_mask;
                let first = (middle + dx as isize).cast_unsigned();
                let end = first + steps.len();
                let line = &mut self.ring[slot * stride + first..slot * stride + end];
                for (to, step) in line.iter_mut().zip(steps) {
                    // As one array, of which the compiler makes vectors.
                    let sum = *to;
                    *to = std::array::from_fn(|l| sum[l] + step * lanes[l]);
                }
                let span = &mut self.spans[slot];
                *span = [span[0].min(first), span[1].max(end - 1)];
            }
        });
    }

    /// Sums up a row that no later disc reaches, hands it on, and clears it.
    fn finish_row(&mut self, row: usize, emitter: &mut Emitter<L>, frame: &mut Chunks<L>) {
        let slot = row & self.ring_mask;
        let stride = self.columns + 2 * self.reach;
        let [first, last] = self.spans[slot];
        emitter.begin_row();
        if first <= last {
            let line = &mut self.ring[slot * stride..][first..=last];
            let mut sum = [0.0_f32; L];
            for (column, step) in (first..).zip(line) {
                sum = std::array::from_fn(|l| sum[l] + step[l]);
                *step = [0.0; L];
                if column >= self.reach && column < self.reach + self.columns {
                    emitter.row[column - self.reach] = sum;
                }
            }
            emitter.span = [
                first.saturating_sub(self.reach),
                (last + 1).saturating_sub(self.reach).min(self.columns),
            ];
            self.spans[slot] = [usize::MAX, 0];
        }
        emitter.end_row(row, frame);
    }
}

/// The cells that a half is shared among along one axis, and their parts; the first may lie before
/// the first cell.
fn shares_of(half: usize, [far, own, near]: [f32; 3]) -> [(usize, f32); 3] {
    let cell = half / 2;
    let (before, after) = if half.is_multiple_of(2) {
        (near, far)
    } else {
        (far, near)
    };
    [
        (cell.wrapping_sub(1), before),
        (cell, own),
        (cell + 1, after),
    ]
}

/// A facet in cells: the rows from `first` to before `last`.
struct Placed {
    polygon: Polygon,
    first: usize,
    last: usize,
    facet: usize,
}

/// The facets that reach the grid, by the rows in which they begin.
#[expect(clippy::cast_precision_loss, reason = "cells of a grid")]
fn placed<const L: usize>(
    facets: &[&Facet<L>],
    scale: f64,
    margin: usize,
    (columns, rows): (usize, usize),
) -> Vec<Placed> {
    let mut all: Vec<Placed> = Vec::with_capacity(facets.len());
    for (k, facet) in facets.iter().enumerate() {
        let corners = facet
            .corners
            .map(|corner| corner.map(|coordinate| coordinate * scale + margin as f64));
        let polygon = Polygon::new(&corners).within(columns as f64);
        let [top, bottom] = polygon.span(1);
        if !(top < rows as f64 && bottom > 0.0) {
            continue;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rows of the grid"
        )]
        let (first, last) = (
            top.max(0.0) as usize,
            bottom.min(rows as f64).ceil() as usize,
        );
        all.push(Placed {
            polygon,
            first,
            last,
            facet: k,
        });
    }
    // Stable: facets of one row keep their order.
    all.sort_by_key(|placed| placed.first);
    all
}

/// Adds what a facet covers of a row of cells.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "cells of a grid; px as f32"
)]
fn cover<const L: usize>(
    placed: &Placed,
    facet: &Facet<L>,
    (row, margin, scale, kernel): (usize, usize, f64, u32),
    n_shares: usize,
    scratch: &mut [f32],
    covered: &mut Row<L>,
) {
    let middle: [f64; 2] = std::array::from_fn(|axis| {
        facet.corners.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25
    });
    let weight: f32 = facet.lanes.iter().take(n_shares).sum();
    let place = |cell: usize| (cell as f64 + 0.5 - margin as f64) / scale;
    let y = (place(row) - middle[1]) as f32;
    let (x_first, x_step) = ((place(0) - middle[0]) as f32, (1.0 / scale) as f32);
    placed
        .polygon
        .cover_row(row as i64, scratch, |column, area| {
            let cell = covered.cell(column, kernel, area * weight);
            let sum = cell.lanes;
            cell.lanes = std::array::from_fn(|l| sum[l] + area * facet.lanes[l]);
            let x = x_first + x_step * column as f32;
            for (k, lean) in facet.lean.iter().enumerate() {
                cell.lanes[L - 2 + k] += area * (lean[0] * x + lean[1] * y);
            }
        });
}

/// The kernels that facets need, and which each needs.
fn kernels_of<const L: usize>(
    scale: f64,
    facets: &[&Facet<L>],
    pupil: Pupil,
) -> (Vec<Kernel>, Vec<u32>) {
    let mut kernels = Vec::new();
    let mut known: BTreeMap<i32, u32> = BTreeMap::new();
    let kernel_of = facets
        .iter()
        .map(|facet| {
            let radius = facet.radius_px * scale;
            #[expect(clippy::cast_possible_truncation, reason = "logarithms")]
            let key = (libm::log(radius.abs().max(1e-3)) / RADIUS_RATIO.ln()).round() as i32;
            *known
                .entry(2 * key + i32::from(radius < 0.0))
                .or_insert_with(|| {
                    let rounded = libm::exp(f64::from(key) * RADIUS_RATIO.ln());
                    kernels.push(Kernel::new(pupil, rounded.copysign(radius)));
                    #[expect(clippy::cast_possible_truncation, reason = "some hundreds")]
                    let place = (kernels.len() - 1) as u32;
                    place
                })
        })
        .collect();
    (kernels, kernel_of)
}

/// Turns rows of cells into rows of pixels.
struct Emitter<const L: usize> {
    level: i32,
    margin: usize,
    n_shares: usize,
    /// The present row of cells, and the part of it that is set.
    row: Vec<[f32; L]>,
    span: [usize; 2],
    /// Coarse cells: the row before. Fine cells: the sum of the rows of a pixel so far.
    other: Vec<[f32; L]>,
    other_span: [usize; 2],
    pixels: Vec<[f32; L]>,
}

impl<const L: usize> Emitter<L> {
    fn new(level: i32, margin: usize, columns: usize, n_shares: usize) -> Self {
        Self {
            level,
            margin,
            n_shares,
            row: vec![[0.0; L]; columns],
            span: [0, 0],
            other: vec![[0.0; L]; columns],
            other_span: [0, 0],
            pixels: Vec::new(),
        }
    }

    fn begin_row(&mut self) {
        let [first, last] = self.span;
        self.row[first..last].fill([0.0; L]);
        self.span = [0, 0];
    }

    fn end_row(&mut self, row: usize, frame: &mut Chunks<L>) {
        match self.level {
            0 => self.equal(row, frame),
            1.. => self.fine(row, frame),
            _ => self.coarse(row, frame),
        }
    }

    fn equal(&mut self, row: usize, frame: &mut Chunks<L>) {
        let (width, height) = frame.size();
        let Some(y) = row.checked_sub(self.margin).filter(|y| *y < height) else {
            return;
        };
        let [first, last] = self.span;
        let (start, end) = (
            first.saturating_sub(self.margin),
            last.saturating_sub(self.margin).min(width),
        );
        if start < end {
            let values = &self.row[start + self.margin..end + self.margin];
            hand_on(frame, y, start, values, self.n_shares);
        }
    }

    fn fine(&mut self, row: usize, frame: &mut Chunks<L>) {
        let per_px = 1_usize << self.level;
        let [first, last] = self.span;
        if first < last {
            for (sum, value) in self.other[first..last]
                .iter_mut()
                .zip(&self.row[first..last])
            {
                for (sum, value) in sum.iter_mut().zip(value) {
                    *sum += value;
                }
            }
            let [low, high] = self.other_span;
            self.other_span = if low < high {
                [low.min(first), high.max(last)]
            } else {
                [first, last]
            };
        }
        if !(row + 1).is_multiple_of(per_px) {
            return;
        }
        let [first, last] = std::mem::take(&mut self.other_span);
        if first >= last {
            return;
        }
        let (width, height) = frame.size();
        let start = (first / per_px).saturating_sub(self.margin / per_px);
        let end = last
            .div_ceil(per_px)
            .saturating_sub(self.margin / per_px)
            .min(width);
        if let Some(y) = (row / per_px).checked_sub(self.margin / per_px)
            && y < height
            && start < end
        {
            #[expect(clippy::cast_precision_loss, reason = "4 or 16")]
            let share = 1.0 / (per_px * per_px) as f32;
            self.pixels.clear();
            for x in start..end {
                let mut sum = [0.0; L];
                for cell in &self.other[self.margin + x * per_px..][..per_px] {
                    for (sum, value) in sum.iter_mut().zip(cell) {
                        *sum += share * value;
                    }
                }
                self.pixels.push(sum);
            }
            hand_on(frame, y, start, &self.pixels, self.n_shares);
        }
        self.other[first..last].fill([0.0; L]);
    }

    fn coarse(&mut self, row: usize, frame: &mut Chunks<L>) {
        let (width, height) = frame.size();
        let per_cell = 1_usize << -self.level;
        let [first, last] = [
            least(self.span, self.other_span),
            self.span[1].max(self.other_span[1]),
        ];
        if first < last {
            // Pixels whose centres lie between the centres of the rows `row − 1` and `row`.
            let half = per_cell / 2;
            let begin = (row * per_cell + half).checked_sub(self.margin * per_cell + per_cell);
            let (y_first, skip) = match begin {
                Some(y) => (y, 0),
                None => (
                    0,
                    (self.margin * per_cell + per_cell) - (row * per_cell + half),
                ),
            };
            for k in skip..per_cell {
                let y = y_first + k - skip;
                if y >= height {
                    break;
                }
                #[expect(clippy::cast_precision_loss, reason = "1 to 8")]
                let t = (k as f32 + 0.5) / per_cell as f32;
                self.coarse_line([first, last], t, y, width, frame);
            }
        }
        std::mem::swap(&mut self.row, &mut self.other);
        std::mem::swap(&mut self.span, &mut self.other_span);
    }

    /// One row of pixels between two rows of cells, `t` of the way from the one before.
    fn coarse_line(
        &mut self,
        [first, last]: [usize; 2],
        t: f32,
        y: usize,
        width: usize,
        frame: &mut Chunks<L>,
    ) {
        let per_cell = 1_usize << -self.level;
        let half = per_cell / 2;
        let zero = [0.0; L];
        let blend = |column: usize| -> [f32; L] {
            let before = self.other.get(column).unwrap_or(&zero);
            let now = self.row.get(column).unwrap_or(&zero);
            std::array::from_fn(|l| before[l] + t * (now[l] - before[l]))
        };
        // Pixels between the centres of the cells `first − 1` and `last`.
        let place =
            |column: usize| (column * per_cell + half).saturating_sub(self.margin * per_cell);
        let start = place(first.saturating_sub(1));
        let end = place(last).min(width);
        if start >= end {
            return;
        }
        self.pixels.clear();
        let mut x = start;
        let shifted = |x: usize| x + self.margin * per_cell - half;
        let mut left = shifted(x) / per_cell;
        let (mut a, mut b) = (blend(left), blend(left + 1));
        while x < end {
            let at = shifted(x);
            if at / per_cell != left {
                left = at / per_cell;
                a = b;
                b = blend(left + 1);
            }
            #[expect(clippy::cast_precision_loss, reason = "below 8")]
            let s = ((at % per_cell) as f32 + 0.5) / per_cell as f32;
            self.pixels
                .push(std::array::from_fn(|l| a[l] + s * (b[l] - a[l])));
            x += 1;
        }
        hand_on(frame, y, start, &self.pixels, self.n_shares);
    }
}

/// The lower start of two spans, of which those with nothing in them do not count.
fn least(a: [usize; 2], b: [usize; 2]) -> usize {
    match (a[0] < a[1], b[0] < b[1]) {
        (true, true) => a[0].min(b[0]),
        (true, false) => a[0],
        _ => b[0],
    }
}

/// Adds a row of pixels to the frame, without the runs in which there is nothing.
fn hand_on<const L: usize>(
    frame: &mut Chunks<L>,
    y: usize,
    start: usize,
    values: &[[f32; L]],
    n_shares: usize,
) {
    let mut at = 0;
    while at < values.len() {
        let x = start + at;
        let n = (CHUNK - x % CHUNK).min(values.len() - at);
        let part = &values[at..at + n];
        let is_something = part.iter().any(|pixel| {
            pixel[..n_shares]
                .iter()
                .map(|share| share.abs())
                .sum::<f32>()
                > LEAST_SHARE
        });
        if is_something {
            frame.add_row(y, x, part);
        }
        at += n;
    }
}

#[cfg(test)]
#[path = "layer_tests.rs"]
mod tests;
