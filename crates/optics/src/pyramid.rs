//! Light of a frame in square cells, for blurs so wide that single pixels do not matter.

use wide::f32x4;

use crate::blur::{Kernel, weighted_sum};

/// Cells per standard deviation of a Gaussian, at least.
const CELLS_PER_SIGMA: f64 = 2.0;

/// Means of a frame's light over square cells, in rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cells<const COLORS: usize> {
    /// Columns and rows of cells.
    pub(crate) size: (usize, usize),
    /// Width of a cell, px.
    pub(crate) per_cell: u32,
    light: Vec<[f32; COLORS]>,
}

impl<const COLORS: usize> Cells<COLORS> {
    /// The pixels of a frame of a width and height, px.
    pub(crate) fn of(light: &[f32], size: (usize, usize)) -> Self {
        Self {
            size,
            per_cell: 1,
            light: light.as_chunks::<COLORS>().0.to_vec(),
        }
    }

    /// Cells of a width, px, in rows of so many columns.
    pub(crate) fn of_cells(values: &[f32], size: (usize, usize), per_cell: u32) -> Self {
        Self {
            per_cell,
            ..Self::of(values, size)
        }
    }

    /// No light, in cells of a width, px, of a frame of a width and height, px.
    pub(crate) fn none((width, height): (usize, usize), per_cell: u32) -> Self {
        let size = [width, height].map(|n| n.div_ceil(per_cell as usize));
        Self {
            size: size.into(),
            per_cell,
            light: vec![[0.0; COLORS]; size[0] * size[1]],
        }
    }

    /// The light of each cell, in rows, to be changed.
    pub(crate) fn values_mut(&mut self) -> &mut [[f32; COLORS]] {
        &mut self.light
    }

    /// The light of each cell, in rows.
    pub(crate) fn values(&self) -> std::slice::Iter<'_, [f32; COLORS]> {
        self.light.iter()
    }

    /// The light of one.
    pub(crate) fn cell(&self, cell: usize) -> [f32; COLORS] {
        self.light[cell]
    }

    /// The light at a place, px, on straight lines between the middles of cells; beyond the frame that of its border.
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    #[inline(always)]
    pub(crate) fn at(&self, place_px: [f32; 2]) -> [f32; COLORS] {
        let (columns, rows) = self.size;
        let [u, v] = match self.per_cell {
            1 => place_px,
            per_cell => place_px.map(|px| px / per_cell as f32),
        };
        let ((left, s), (top, t)) = (cell_before(u, columns), cell_before(v, rows));
        let first = top * columns + left;
        // The two cells of a row with some of the next at their end.
        let values = self.light.as_flattened();
        let row = |first: usize| values.get(first * COLORS..(first + 1) * COLORS + TOGETHER);
        let light = match (row(first), row(first + columns)) {
            (Some(high), Some(low)) if left + 1 < columns => {
                let [high, low] =
                    [high, low].map(|row| between(together(row), together(&row[COLORS..]), s));
                between(high, low, t)
            }
            _ => self.at_border([left, top], [s, t]),
        };
        let light = light.to_array();
        std::array::from_fn(|c| light[c])
    }

    /// The same where there may be no cell to the right or below.
    #[cold]
    fn at_border(&self, [left, top]: [usize; 2], [s, t]: [f32; 2]) -> f32x4 {
        let (columns, rows) = self.size;
        let row = |y: usize| {
            let [a, b] = [left, (left + 1).min(columns - 1)].map(|x| {
                let light = self.light[y * columns + x];
                f32x4::new(std::array::from_fn(|k| {
                    light.get(k).copied().unwrap_or(0.0)
                }))
            });
            between(a, b, s)
        };
        between(row(top), row((top + 1).min(rows - 1)), t)
    }

    /// Adds light at a place, in cells from the middle of the first, to the four around it, to each the more the nearer.
    pub(crate) fn add_at(&mut self, [x, y]: [f32; 2], light: [f32; COLORS]) {
        let (columns, rows) = self.size;
        let [(left, s), (top, t)] = [x, y].map(|at| {
            let whole = at.floor();
            #[expect(clippy::cast_possible_truncation, reason = "cells of a frame")]
            let first = whole as isize;
            (first, at - whole)
        });
        for (y, down) in [(top, 1.0 - t), (top + 1, t)] {
            for (x, across) in [(left, 1.0 - s), (left + 1, s)] {
                let at = usize::try_from(x).ok().zip(usize::try_from(y).ok());
                if let Some((x, y)) = at.filter(|(x, y)| *x < columns && *y < rows) {
                    let cell = &mut self.light[y * columns + x];
                    for c in 0..COLORS {
                        cell[c] += down * across * light[c];
                    }
                }
            }
        }
    }

    /// Cells twice as wide; those at the end of the frame are cut off by it.
    pub(crate) fn halved(&self) -> Self {
        halved(self.light.as_flattened(), self.size, self.per_cell)
    }

    /// As [`blurred`].
    pub(crate) fn blurred(&self, sigma_px: f64) -> Self {
        blurred(&self.light, self.size, self.per_cell, sigma_px)
    }

    /// Adds the light of wider cells.
    pub(crate) fn add(&mut self, wider: &Self) {
        let rows = wider.rows(self.size.0, self.per_cell);
        add_rows(self.light.as_flattened_mut(), rows);
    }

    /// Adds the light of cells to that of the pixels of a frame of a width, px.
    pub(crate) fn add_to(&self, light: &mut [f32], width: usize) {
        add_rows(light, self.rows(width, 1));
    }

    /// The light of rows of so many places that are so many px wide and high: with 1 the pixels of a frame.
    pub(crate) fn rows(&self, n: usize, step_px: u32) -> Rows<'_, COLORS> {
        Rows::of(self, n, step_px)
    }
}

/// The first of some values.
#[inline(always)]
pub(crate) fn together(values: &[f32]) -> f32x4 {
    f32x4::new(std::array::from_fn(|k| values[k]))
}

/// Values on a straight line from some to others.
#[inline(always)]
pub(crate) fn between(from: f32x4, to: f32x4, part: f32) -> f32x4 {
    from + f32x4::splat(part) * (to - from)
}

/// The light of cells spread by a Gaussian of a standard deviation, px; beyond the frame it goes on mirrored. What cells and
/// the straight lines back between them spread already is taken off.
fn blurred<const COLORS: usize>(
    light: &[[f32; COLORS]],
    size: (usize, usize),
    per_cell: u32,
    sigma_px: f64,
) -> Cells<COLORS> {
    let sigma = sigma_px / f64::from(per_cell);
    // Variances per axis, cells²: means 1/12, lines 1/6.
    let known = if per_cell > 1 { 0.25 } else { 0.0 };
    let kernel = Kernel::wide((sigma * sigma - known).max(0.0).sqrt());
    let light = vectorized(
        #[inline(always)]
        || by_kernel(light, size, &kernel),
    );
    Cells {
        size,
        per_cell,
        light,
    }
}

/// Spread by a kernel, across and down.
#[inline(always)]
fn by_kernel<const COLORS: usize>(
    light: &[[f32; COLORS]],
    (width, height): (usize, usize),
    kernel: &Kernel,
) -> Vec<[f32; COLORS]> {
    let reach = kernel.radius();
    // Rows that are spread across, as many as are spread down together.
    let n_rows = (2 * reach + 1).min(height);
    let mut across = vec![[0.0_f32; COLORS]; n_rows * width];
    let mut wide = vec![[0.0_f32; COLORS]; width + 2 * reach];
    let mut rows = light.chunks_exact(width).enumerate();
    let mut n_across = 0;
    let mut out = vec![[0.0_f32; COLORS]; light.len()];
    for (y, to) in out.chunks_exact_mut(width).enumerate() {
        let wanted = (y + reach + 1).min(height);
        for (from, row) in rows.by_ref().take(wanted - n_across) {
            let slot = from % n_rows * width;
            row_by_kernel(row, &mut wide, &mut across[slot..slot + width], kernel);
        }
        n_across = wanted;
        let row = |k: isize| {
            let slot = mirrored(y.cast_signed() + k, height) % n_rows * width;
            across[slot..slot + width].as_flattened()
        };
        let taps: Vec<_> = (0..=reach.cast_signed())
            .map(|k| (row(-k), row(k)))
            .collect();
        weighted_sum(&taps, kernel, to.as_flattened_mut());
    }
    out
}

/// A row spread across, with room for it and what is beyond its ends.
#[inline(always)]
fn row_by_kernel<const COLORS: usize>(
    row: &[[f32; COLORS]],
    wide: &mut [[f32; COLORS]],
    to: &mut [[f32; COLORS]],
    kernel: &Kernel,
) {
    let (width, reach) = (row.len(), kernel.radius());
    wide[reach..reach + width].copy_from_slice(row);
    for k in 0..reach {
        wide[k] = row[mirrored(k.cast_signed() - reach.cast_signed(), width)];
        wide[reach + width + k] = row[mirrored((width + k).cast_signed(), width)];
    }
    let from = |first: usize| wide[first..first + width].as_flattened();
    let taps: Vec<_> = (0..=reach)
        .map(|k| (from(reach - k), from(reach + k)))
        .collect();
    weighted_sum(&taps, kernel, to.as_flattened_mut());
}

fn add_rows<const COLORS: usize>(light: &mut [f32], mut rows: Rows<'_, COLORS>) {
    vectorized(
        #[inline(always)]
        || {
            let width = rows.across.len();
            for (y, row) in light.chunks_exact_mut(width * COLORS).enumerate() {
                for (value, more) in row.iter_mut().zip(rows.at(y)) {
                    *value += more;
                }
            }
        },
    );
}

/// The light of cells at each pixel of a row, on straight lines between their middles.
pub(crate) struct Rows<'c, const COLORS: usize> {
    cells: &'c Cells<COLORS>,
    /// The cell left of each pixel, and how near it is to the next.
    across: Vec<(usize, f32)>,
    /// Cells from one row to the next.
    scale: f32,
    /// A row of cells with more at its end.
    line: Vec<f32>,
    /// Two rows of cells at each pixel, by the parity of their numbers, with room at their ends, and which they are.
    wide: [Vec<f32>; 2],
    wide_of: [usize; 2],
    /// The present row.
    row: Vec<f32>,
}

/// Values that are read and written together: all of a pixel, and the first of the next.
pub(crate) const TOGETHER: usize = 4;

impl<'c, const COLORS: usize> Rows<'c, COLORS> {
    /// Of so many places a width, px, apart.
    fn of(cells: &'c Cells<COLORS>, n: usize, step: u32) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let scale = step as f32 / cells.per_cell as f32;
        let columns = cells.size.0;
        Self {
            across: (0..n)
                .map(|x| cell_before(middle(x, scale), columns))
                .collect(),
            scale,
            line: vec![0.0; (columns + 1) * COLORS + TOGETHER],
            wide: [(); 2].map(|()| vec![0.0; n * COLORS + TOGETHER]),
            wide_of: [usize::MAX; 2],
            row: vec![0.0; n * COLORS],
            cells,
        }
    }

    /// The light of a row, with the values of a pixel side by side.
    #[inline(always)]
    pub(crate) fn at(&mut self, y: usize) -> &[f32] {
        let (columns, rows) = self.cells.size;
        let (above, t) = cell_before(middle(y, self.scale), rows);
        let n = self.across.len() * COLORS;
        if self.scale.to_bits() == 1.0_f32.to_bits() && n == columns * COLORS {
            return self.cells.light[above * columns..][..columns].as_flattened();
        }
        let below = (above + 1).min(rows - 1);
        for wanted in [above, below] {
            if self.wide_of[wanted % 2] != wanted {
                self.widen(wanted);
            }
        }
        let (from, to) = (&self.wide[above % 2], &self.wide[below % 2]);
        for ((light, a), b) in self.row.iter_mut().zip(from).zip(to) {
            *light = a + (b - a) * t;
        }
        &self.row
    }

    /// Puts a row of cells where those of its parity are.
    #[inline(always)]
    fn widen(&mut self, row: usize) {
        let columns = self.cells.size.0;
        let end = columns * COLORS;
        let from = &self.cells.light[row * columns..][..columns];
        self.line[..end].copy_from_slice(from.as_flattened());
        // Beyond the last cell it goes on.
        self.line.copy_within(end - COLORS..end, end);
        let wide = &mut self.wide[row % 2];
        self.wide_of[row % 2] = row;
        if self.scale.to_bits() == 0.5_f32.to_bits() && COLORS > 1 {
            double::<COLORS>(&self.line, wide, self.across.len());
            return;
        }
        for ((left, s), x) in self.across.iter().zip(0_usize..) {
            let left = left * COLORS;
            if COLORS == 1 {
                let [a, b] = [self.line[left], self.line[left + 1]];
                wide[x] = a + (b - a) * s;
                continue;
            }
            let a = &self.line[left..left + TOGETHER];
            let b = &self.line[left + COLORS..left + COLORS + TOGETHER];
            let to = &mut wide[x * COLORS..x * COLORS + TOGETHER];
            for k in 0..TOGETHER {
                to[k] = a[k] + (b[k] - a[k]) * s;
            }
        }
    }
}

/// As [`Rows::widen`], to so many places that are half as wide as cells.
#[inline(always)]
fn double<const COLORS: usize>(line: &[f32], wide: &mut [f32], n: usize) {
    wide[..COLORS].copy_from_slice(&line[..COLORS]);
    for cell in 0..n / 2 {
        let first = cell * COLORS;
        let from = &line[first..first + COLORS + TOGETHER];
        let (a, b) = (together(from), together(&from[COLORS..]));
        let to = &mut wide[2 * first + COLORS..2 * first + 2 * COLORS + TOGETHER];
        to[..TOGETHER].copy_from_slice(between(a, b, 0.25).as_array());
        to[COLORS..COLORS + TOGETHER].copy_from_slice(between(a, b, 0.75).as_array());
    }
}

/// The middle of a row or column, in cells that are so many of them wide.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
#[inline(always)]
fn middle(k: usize, scale: f32) -> f32 {
    (k as f32 + 0.5) * scale
}

/// Of so many cells that whose middle is before a place, in cells, and how near that is to the next.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "px of a frame"
)]
#[inline(always)]
fn cell_before(place: f32, n: usize) -> (usize, f32) {
    let place = (place - 0.5).clamp(0.0, (n - 1) as f32);
    let whole = place as u32;
    (whole as usize, place - whole as f32)
}

/// A frame in pixels, and in ever wider cells as they are asked for.
pub(crate) struct Pyramid<'l, const COLORS: usize> {
    pixels: &'l [f32],
    size: (usize, usize),
    /// Cells of 2, 4, 8, … px.
    wider: Vec<Cells<COLORS>>,
}

impl<'l, const COLORS: usize> Pyramid<'l, COLORS> {
    /// Of the light of a frame of a width and height, px.
    pub(crate) fn of(pixels: &'l [f32], size: (usize, usize)) -> Self {
        Self {
            pixels,
            size,
            wider: Vec::new(),
        }
    }

    /// Cells that are no wider than so many px, as wide as that allows: the pixels themselves at least.
    pub(crate) fn no_wider(&mut self, most_px: f64) -> Cells<COLORS> {
        match self.wider_up_to(most_px) {
            Some(cells) => cells.clone(),
            None => Cells::of(self.pixels, self.size),
        }
    }

    /// Spread by a Gaussian of a standard deviation, px, on cells as wide as that allows.
    pub(crate) fn spread(&mut self, sigma_px: f64) -> Cells<COLORS> {
        match self.wider_up_to(sigma_px / CELLS_PER_SIGMA) {
            Some(cells) => cells.blurred(sigma_px),
            None => blurred(self.pixels.as_chunks().0, self.size, 1, sigma_px),
        }
    }

    /// Cells of 2 px or more, where so many px allow them.
    fn wider_up_to(&mut self, most_px: f64) -> Option<&Cells<COLORS>> {
        let (mut n, mut per_cell, mut size) = (0, 2.0, self.size);
        while per_cell <= most_px && size.0.max(size.1) > 2 {
            if n == self.wider.len() {
                let next = match self.wider.last() {
                    Some(last) => last.halved(),
                    None => halved(self.pixels, self.size, 1),
                };
                self.wider.push(next);
            }
            size = self.wider[n].size;
            n += 1;
            per_cell *= 2.0;
        }
        self.wider.get(n.checked_sub(1)?)
    }
}

/// Means of two by two cells; those at the end of the frame are cut off by it.
fn halved<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    per_cell: u32,
) -> Cells<COLORS> {
    let size = (width.div_ceil(2), height.div_ceil(2));
    let mut half = vec![[0.0_f32; COLORS]; size.0 * size.1];
    let light = light.as_chunks::<COLORS>().0;
    vectorized(
        #[inline(always)]
        || {
            for (y, to) in half.chunks_exact_mut(size.0).enumerate() {
                let above = &light[2 * y * width..][..width];
                let below = &light[(2 * y + 1).min(height - 1) * width..][..width];
                for ((to, above), below) in to.iter_mut().zip(above.chunks(2)).zip(below.chunks(2))
                {
                    let last = above.len() - 1;
                    for c in 0..COLORS {
                        to[c] = 0.25
                            * ((above[0][c] + above[last][c]) + (below[0][c] + below[last][c]));
                    }
                }
            }
        },
    );
    Cells {
        size,
        per_cell: 2 * per_cell,
        light: half,
    }
}

/// Runs what is inlined in it compiled for the processor that there is. No result depends on it: nothing is fused.
#[inline(always)]
pub(crate) fn vectorized<R>(run: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(run)
}

/// Index of a sample beyond the border, mirrored at the border's own edge.
pub(crate) fn mirrored(index: isize, n: usize) -> usize {
    let period = 2 * n.cast_signed();
    let folded = index.rem_euclid(period);
    folded.min(period - 1 - folded).cast_unsigned()
}
