//! Light of a frame in square cells, for blurs so wide that single pixels do not matter.

/// Cells per standard deviation of a Gaussian, at least.
pub(crate) const CELLS_PER_SIGMA: f64 = 2.0;

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
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "px of a frame"
    )]
    pub(crate) fn at(&self, [u, v]: [f32; 2]) -> [f32; COLORS] {
        let (columns, rows) = self.size;
        let along = |px: f32, n: usize| {
            let place = (px / self.per_cell as f32 - 0.5).clamp(0.0, (n - 1) as f32);
            let whole = place as usize;
            (whole, (whole + 1).min(n - 1), place - whole as f32)
        };
        let (left, right, s) = along(u, columns);
        let (top, bottom, t) = along(v, rows);
        let of = |x: usize, y: usize| &self.light[y * columns + x];
        let corners = [
            of(left, top),
            of(right, top),
            of(left, bottom),
            of(right, bottom),
        ];
        std::array::from_fn(|c| {
            let [a, b, low_a, low_b] = corners.map(|it| it[c]);
            let (high, low) = (a + s * (b - a), low_a + s * (low_b - low_a));
            high + t * (low - high)
        })
    }

    /// Spread by a Gaussian of a standard deviation, px, on cells as large as that allows.
    pub(crate) fn spread(&self, sigma_px: f64) -> Self {
        let mut cells = self.clone();
        while f64::from(cells.per_cell) * 2.0 <= sigma_px / CELLS_PER_SIGMA
            && cells.size.0.max(cells.size.1) > 2
        {
            cells = cells.halved();
        }
        cells.blurred(sigma_px)
    }

    /// Cells twice as wide; those at the end of the frame are cut off by it.
    pub(crate) fn halved(&self) -> Self {
        let (width, height) = self.size;
        let size = (width.div_ceil(2), height.div_ceil(2));
        let mut light = Vec::with_capacity(size.0 * size.1);
        for y in (0..height).step_by(2) {
            let above = &self.light[y * width..][..width];
            let below = &self.light[(y + 1).min(height - 1) * width..][..width];
            for (above, below) in above.chunks(2).zip(below.chunks(2)) {
                let last = above.len() - 1;
                light.push(std::array::from_fn(|c| {
                    0.25 * ((above[0][c] + above[last][c]) + (below[0][c] + below[last][c]))
                }));
            }
        }
        Self {
            size,
            per_cell: 2 * self.per_cell,
            light,
        }
    }

    /// Spread by a Gaussian of a standard deviation, px; beyond the frame it goes on mirrored. What cells and the
    /// straight lines back between them spread already is taken off.
    pub(crate) fn blurred(&self, sigma_px: f64) -> Self {
        let sigma = sigma_px / f64::from(self.per_cell);
        // Variances per axis, cells²: means 1/12, lines 1/6.
        let known = if self.per_cell > 1 { 0.25 } else { 0.0 };
        let kernel = gaussian((sigma * sigma - known).max(0.0).sqrt());
        let (width, height) = self.size;
        let mut along = vec![[0.0_f32; COLORS]; self.light.len()];
        let reach = kernel.len() - 1;
        let mut wide = vec![[0.0_f32; COLORS]; width + 2 * reach];
        for (row, to) in self
            .light
            .chunks_exact(width)
            .zip(along.chunks_exact_mut(width))
        {
            for (k, to) in (-reach.cast_signed()..).zip(&mut wide) {
                *to = row[mirrored(k, width)];
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
        Self { light, ..*self }
    }

    /// Adds the light of wider cells.
    pub(crate) fn add(&mut self, wider: &Self) {
        let ratio = self.per_cell;
        let (width, _) = self.size;
        for (y, row) in self.light.chunks_exact_mut(width).enumerate() {
            wider.each_between_cells((y, width), ratio, |x, more| {
                row[x] = std::array::from_fn(|c| row[x][c] + more[c]);
            });
        }
    }

    /// Adds the light of cells to that of the pixels of a frame of a width, px.
    pub(crate) fn add_to(&self, light: &mut [f32], width: usize) {
        for (y, row) in light.chunks_exact_mut(width * COLORS).enumerate() {
            let row = row.as_chunks_mut::<COLORS>().0;
            self.each_between(y, width, |x, more| {
                for (value, more) in row[x].iter_mut().zip(more) {
                    *value += more;
                }
            });
        }
    }

    /// Calls with the light at each pixel of a row, on straight lines between the middles of cells.
    pub(crate) fn each_between(
        &self,
        y: usize,
        width: usize,
        call: impl FnMut(usize, [f32; COLORS]),
    ) {
        self.each_between_cells((y, width), 1, call);
    }

    /// The same at the middles of cells of a width, px.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "px of a frame"
    )]
    fn each_between_cells(
        &self,
        (y, width): (usize, usize),
        step: u32,
        mut call: impl FnMut(usize, [f32; COLORS]),
    ) {
        let scale = step as f32 / self.per_cell as f32;
        let at = |k: usize, n: usize| {
            let place = ((k as f32 + 0.5) * scale - 0.5).clamp(0.0, (n - 1) as f32);
            let whole = place as usize;
            (whole, (whole + 1).min(n - 1), place - whole as f32)
        };
        let (columns, rows) = self.size;
        let (above, below, t) = at(y, rows);
        let above = &self.light[above * columns..][..columns];
        let below = &self.light[below * columns..][..columns];
        let between = |a: [f32; COLORS], b: [f32; COLORS], t: f32| -> [f32; COLORS] {
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
        };
        let line: Vec<_> = above
            .iter()
            .zip(below)
            .map(|(a, b)| between(*a, *b, t))
            .collect();
        for x in 0..width {
            let (left, right, s) = at(x, columns);
            call(x, between(line[left], line[right], s));
        }
    }
}

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
