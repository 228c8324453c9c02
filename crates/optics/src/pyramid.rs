//! Light of a frame in square cells, for blurs so wide that single pixels do not matter.

use wide::f32x4;

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

    /// The light of each cell, in rows.
    pub(crate) fn values(&self) -> std::slice::Iter<'_, [f32; COLORS]> {
        self.light.iter()
    }

    /// The light of one.
    pub(crate) fn cell(&self, cell: usize) -> [f32; COLORS] {
        self.light[cell]
    }

    /// The same, to be changed.
    pub(crate) fn values_mut(&mut self) -> std::slice::IterMut<'_, [f32; COLORS]> {
        self.light.iter_mut()
    }

    /// The light at a place, px, on straight lines between the middles of cells; beyond the frame that of its border.
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    #[inline(always)]
    pub(crate) fn at(&self, place_px: [f32; 2]) -> [f32; COLORS] {
        let (columns, rows) = self.size;
        let [u, v] = place_px.map(|px| px / self.per_cell as f32);
        let ((left, s), (top, t)) = (cell_before(u, columns), cell_before(v, rows));
        let (right, bottom) = ((left + 1).min(columns - 1), (top + 1).min(rows - 1));
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        let [a, b, low_a, low_b] = corners.map(|(x, y)| self.together(y * columns + x));
        let (high, low) = (between(a, b, s), between(low_a, low_b, s));
        let light = between(high, low, t).to_array();
        std::array::from_fn(|c| light[c])
    }

    /// The light of a cell, with some of the next at its end.
    #[inline(always)]
    fn together(&self, cell: usize) -> f32x4 {
        let from = &self.light.as_flattened()[cell * COLORS..];
        if let Some(all) = from.first_chunk() {
            return f32x4::new(*all);
        }
        let mut all = [0.0; TOGETHER];
        all[..COLORS].copy_from_slice(&self.light[cell]);
        f32x4::new(all)
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

    /// Spread by a Gaussian of a standard deviation, px; beyond the frame it goes on mirrored. What cells and the
    /// straight lines back between them spread already is taken off.
    pub(crate) fn blurred(&self, sigma_px: f64) -> Self {
        let sigma = sigma_px / f64::from(self.per_cell);
        // Variances per axis, cells²: means 1/12, lines 1/6.
        let known = if self.per_cell > 1 { 0.25 } else { 0.0 };
        let kernel = gaussian((sigma * sigma - known).max(0.0).sqrt());
        let light = vectorized(
            #[inline(always)]
            || self.by_kernel(&kernel),
        );
        Self { light, ..*self }
    }

    /// Spread by the middle and one side of a kernel, across and down.
    #[inline(always)]
    fn by_kernel(&self, kernel: &[f32]) -> Vec<[f32; COLORS]> {
        let (width, height) = self.size;
        let mut along = vec![[0.0_f32; COLORS]; self.light.len()];
        let reach = kernel.len() - 1;
        let mut wide = vec![[0.0_f32; COLORS]; width + 2 * reach];
        for (row, to) in self
            .light
            .chunks_exact(width)
            .zip(along.chunks_exact_mut(width))
        {
            wide[reach..reach + width].copy_from_slice(row);
            for k in 0..reach {
                wide[k] = row[mirrored(k.cast_signed() - reach.cast_signed(), width)];
                wide[reach + width + k] = row[mirrored((width + k).cast_signed(), width)];
            }
            for (k, share) in kernel.iter().enumerate() {
                let sides: &[usize] = if k == 0 {
                    &[reach]
                } else {
                    &[reach - k, reach + k]
                };
                for first in sides {
                    add_times(to, &wide[*first..*first + width], *share);
                }
            }
        }
        let mut light = vec![[0.0_f32; COLORS]; self.light.len()];
        for (y, to) in light.chunks_exact_mut(width).enumerate() {
            for (k, share) in kernel.iter().enumerate() {
                let (y, k) = (y.cast_signed(), k.cast_signed());
                let sides: &[isize] = if k == 0 { &[y] } else { &[y - k, y + k] };
                for from in sides {
                    let from = mirrored(*from, height) * width;
                    add_times(to, &along[from..from + width], *share);
                }
            }
        }
        light
    }

    /// Adds the light of wider cells.
    pub(crate) fn add(&mut self, wider: &Self) {
        let (width, step) = (self.size.0, self.per_cell);
        add_rows(self.light.as_flattened_mut(), Rows::of(wider, width, step));
    }

    /// Adds the light of cells to that of the pixels of a frame of a width, px.
    pub(crate) fn add_to(&self, light: &mut [f32], width: usize) {
        add_rows(light, Rows::of(self, width, 1));
    }

    /// The light at each pixel of a frame of a width, px, row by row.
    pub(crate) fn rows(&self, width: usize) -> Rows<'_, COLORS> {
        Rows::of(self, width, 1)
    }
}

/// Values on a straight line from some to others.
#[inline(always)]
pub(crate) fn between(from: f32x4, to: f32x4, part: f32) -> f32x4 {
    from + f32x4::splat(part) * (to - from)
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
    /// Of the present row: that of cells, with more at its end, and that of pixels.
    line: Vec<f32>,
    row: Vec<f32>,
}

/// Values that are read and written together: all of a pixel, and the first of the next.
const TOGETHER: usize = 4;

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
            row: vec![0.0; n * COLORS + TOGETHER],
            cells,
        }
    }

    /// The light of a row, with the values of a pixel side by side.
    #[inline(always)]
    pub(crate) fn at(&mut self, y: usize) -> &[f32] {
        let (columns, rows) = self.cells.size;
        let (above, t) = cell_before(middle(y, self.scale), rows);
        let row_of = |y: usize| self.cells.light[y * columns..][..columns].as_flattened();
        let (from, below) = (row_of(above), row_of((above + 1).min(rows - 1)));
        let n = self.across.len() * COLORS;
        if self.scale.to_bits() == 1.0_f32.to_bits() && n == from.len() {
            return from;
        }
        for ((to, a), b) in self.line.iter_mut().zip(from).zip(below) {
            *to = a + (b - a) * t;
        }
        // Beyond the last cell it goes on.
        let end = columns * COLORS;
        self.line.copy_within(end - COLORS..end, end);
        let places = self.across.iter().zip(0_usize..);
        for ((left, s), x) in places {
            let left = left * COLORS;
            if COLORS == 1 {
                let [a, b] = [self.line[left], self.line[left + 1]];
                self.row[x] = a + (b - a) * s;
                continue;
            }
            let a = &self.line[left..left + TOGETHER];
            let b = &self.line[left + COLORS..left + COLORS + TOGETHER];
            let to = &mut self.row[x * COLORS..x * COLORS + TOGETHER];
            for k in 0..TOGETHER {
                to[k] = a[k] + (b[k] - a[k]) * s;
            }
        }
        &self.row[..n]
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
            None => Cells::of(self.pixels, self.size).blurred(sigma_px),
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

#[inline(always)]
fn add_times<const COLORS: usize>(to: &mut [[f32; COLORS]], from: &[[f32; COLORS]], share: f32) {
    for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
        *to += share * from;
    }
}

/// The middle and one side of a Gaussian of a standard deviation, in cells; with its other side it sums to 1.
fn gaussian(sigma: f64) -> Vec<f32> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some cells"
    )]
    let reach = (3.5 * sigma).ceil() as u32;
    let at = |k: u32| {
        let ratio = f64::from(k) / sigma.max(1e-6);
        libm::exp(-0.5 * ratio * ratio)
    };
    let sum: f64 = (1..=reach).map(|k| 2.0 * at(k)).sum::<f64>() + 1.0;
    #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
    let side = (0..=reach).map(|k| (at(k) / sum) as f32).collect();
    side
}

/// Index of a sample beyond the border, mirrored at the border's own edge.
pub(crate) fn mirrored(index: isize, n: usize) -> usize {
    let period = 2 * n.cast_signed();
    let folded = index.rem_euclid(period);
    folded.min(period - 1 - folded).cast_unsigned()
}
