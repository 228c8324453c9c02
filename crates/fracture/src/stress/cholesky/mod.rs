//! The Cholesky factor of a sparse matrix, to the same bit on every processor.
//!
//! Columns that share a pattern are one dense block, a supernode \[Ng1993\]. Each entry is what is
//! left of the matrix's after products of two rows are taken away, block by block and in each in the
//! order of its columns. A processor with wide instructions does several rows at a time; that, how
//! rows are tiled, and that no product is fused with its sum leave every bit as it is. The libraries
//! choose their kernels, and with them the rounding, by the processor.

use super::elimination::{PER_NODE, Supernode};
use crate::FractureError;
use crate::mesh::to_u32;

#[cfg(test)]
mod tests;

/// Rows and columns that are worked on at a time: what the registers of AVX2 hold.
const TILE_ROWS: usize = 8;
const TILE_COLUMNS: usize = 4;

/// Sums that a scalar product is made of.
const LANES: usize = 8;

/// A factor L with L Lᵀ = A.
pub(super) struct Cholesky {
    n: usize,
    blocks: Vec<Block>,
    /// What earlier blocks take away from each block, in their order.
    updates: Vec<Vec<Update>>,
}

/// Columns of one pattern.
struct Block {
    first_column: usize,
    n_columns: usize,
    /// Rows below those of the block's own columns.
    rows_below: Vec<u32>,
    /// Column by column: the triangle of its own rows (what is above the diagonal is not read), then
    /// those below. Empty until the block is factored.
    values: Vec<f64>,
}

/// An earlier block that has rows among the columns of a block.
struct Update {
    block: usize,
    /// The first of them, among its rows below, and how many there are.
    first: usize,
    n: usize,
}

/// The lower triangle of a matrix, column by column.
pub(super) struct Lower<'a> {
    pub(super) columns: &'a [u32],
    pub(super) rows: &'a [u32],
    pub(super) values: &'a [f64],
}

impl Cholesky {
    /// The pattern of a factor of `n` columns.
    pub(super) fn new(n: usize, supernodes: &[Supernode]) -> Self {
        let mut blocks: Vec<Block> = Vec::with_capacity(supernodes.len());
        let mut block_of_column = Vec::with_capacity(n);
        for (idx, supernode) in supernodes.iter().enumerate() {
            let first_column = block_of_column.len();
            let n_columns = PER_NODE * supernode.n;
            block_of_column.resize(first_column + n_columns, idx);
            let unknowns = |&node: &u32| [0, 1, 2].map(|own| 3 * node + own);
            let rows_below: Vec<u32> = supernode.below.iter().flat_map(unknowns).collect();
            blocks.push(Block {
                first_column,
                n_columns,
                values: Vec::new(),
                rows_below,
            });
        }
        let of_column = |column: u32| block_of_column[column as usize];
        let mut updates: Vec<Vec<Update>> = blocks.iter().map(|_| Vec::new()).collect();
        for (block, Block { rows_below, .. }) in blocks.iter().enumerate() {
            let mut first = 0;
            for rows in rows_below.chunk_by(|a, b| of_column(*a) == of_column(*b)) {
                let n = rows.len();
                updates[of_column(rows[0])].push(Update { block, first, n });
                first += n;
            }
        }
        Self { n, blocks, updates }
    }

    /// The factor of a matrix.
    ///
    /// # Errors
    /// [`FractureError::Solver`] if the matrix is not positive definite.
    pub(super) fn factor(&mut self, matrix: &Lower<'_>) -> Result<(), FractureError> {
        pulp::Arch::new().dispatch(Factoring {
            cholesky: self,
            matrix,
        })
    }

    /// The solution for a right side, in its place.
    pub(super) fn solve(&self, right: &mut [f64]) {
        pulp::Arch::new().dispatch(Solving {
            cholesky: self,
            right,
        });
    }
}

/// [`Cholesky::factor`], compiled once more for processors with AVX2, as far as it is inlined.
struct Factoring<'a> {
    cholesky: &'a mut Cholesky,
    matrix: &'a Lower<'a>,
}

impl pulp::WithSimd for Factoring<'_> {
    type Output = Result<(), FractureError>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let Cholesky { n, blocks, updates } = self.cholesky;
        // Of each row of the block at hand, which of the block's rows it is.
        let mut own_row = vec![0; *n];
        for (idx, updates) in updates.iter().enumerate() {
            let (earlier, rest) = blocks.split_at_mut(idx);
            let block = &mut rest[0];
            for (own, &row) in (to_u32(block.n_columns)..).zip(&block.rows_below) {
                own_row[row as usize] = own;
            }
            for (own, column) in (0..block.n_columns).zip(block.first_column..) {
                own_row[column] = to_u32(own);
            }
            block.fill(self.matrix, &own_row);
            for update in updates {
                block.take_away(&earlier[update.block], update, &own_row);
            }
            block.eliminate()?;
        }
        Ok(())
    }
}

impl Block {
    fn n_rows(&self) -> usize {
        self.n_columns + self.rows_below.len()
    }

    /// The matrix's own entries.
    fn fill(&mut self, matrix: &Lower<'_>, own_row: &[u32]) {
        let n_rows = self.n_rows();
        self.values = vec![0.0; self.n_columns * n_rows];
        let columns = &matrix.columns[self.first_column..];
        for (range, column) in columns.windows(2).zip(self.values.chunks_exact_mut(n_rows)) {
            let range = range[0] as usize..range[1] as usize;
            for (&row, value) in matrix.rows[range.clone()].iter().zip(&matrix.values[range]) {
                column[own_row[row as usize] as usize] = *value;
            }
        }
    }

    /// Takes away the products of the rows of an earlier block.
    #[inline(always)]
    fn take_away(&mut self, from: &Self, update: &Update, own_row: &[u32]) {
        let n_rows = self.n_rows();
        let rows = &from.rows_below[update.first..];
        let products = Products {
            values: &from.values,
            n_rows: from.n_rows(),
            first: from.n_columns + update.first,
            n_targets: update.n,
        };
        products.each(|column, first_row, sums| {
            let at = rows[column] as usize - self.first_column;
            let target = &mut self.values[at * n_rows..][..n_rows];
            for (&row, sum) in rows[first_row..].iter().zip(sums) {
                target[own_row[row as usize] as usize] -= sum;
            }
        });
    }

    /// Factors the triangle and solves for the rows below.
    #[inline(always)]
    fn eliminate(&mut self) -> Result<(), FractureError> {
        let n_rows = self.n_rows();
        for first in (0..self.n_columns).step_by(TILE_COLUMNS) {
            let n = TILE_COLUMNS.min(self.n_columns - first);
            let (done, rest) = self.values.split_at_mut(first * n_rows);
            let products = Products {
                values: done,
                n_rows,
                first,
                n_targets: n,
            };
            products.each(|column, first_row, sums| {
                let target = &mut rest[column * n_rows + first + first_row..];
                for (value, sum) in target.iter_mut().zip(sums) {
                    *value -= sum;
                }
            });
            for own in 0..n {
                let (done, rest) = rest.split_at_mut(own * n_rows);
                let diagonal = first + own;
                let column = &mut rest[diagonal..n_rows];
                for done in done.chunks_exact(n_rows) {
                    let factor = done[diagonal];
                    for (value, done) in column.iter_mut().zip(&done[diagonal..]) {
                        *value -= factor * done;
                    }
                }
                if !(column[0] > 0.0 && column[0] < f64::INFINITY) {
                    return Err(FractureError::Solver {
                        cause: format!(
                            "pivot {} is {}, not positive",
                            self.first_column + diagonal,
                            column[0]
                        ),
                    });
                }
                let root = column[0].sqrt();
                let inverse = 1.0 / root;
                for value in column.iter_mut() {
                    *value *= inverse;
                }
                column[0] = root;
            }
        }
        Ok(())
    }
}

/// Products of rows of a block from `first` on with the first `n_targets` of them.
struct Products<'a> {
    values: &'a [f64],
    n_rows: usize,
    first: usize,
    n_targets: usize,
}

impl Products<'_> {
    /// Calls with the target, the first row, both from `first` on, and the sums of rows from there,
    /// once for each row that is the target's or below it (and some above).
    #[inline(always)]
    fn each(&self, mut with: impl FnMut(usize, usize, &[f64])) {
        let mut target = 0;
        while target + TILE_COLUMNS <= self.n_targets {
            self.columns::<TILE_COLUMNS>(target, &mut with);
            target += TILE_COLUMNS;
        }
        while target < self.n_targets {
            self.columns::<1>(target, &mut with);
            target += 1;
        }
    }

    #[inline(always)]
    fn columns<const C: usize>(&self, target: usize, with: &mut impl FnMut(usize, usize, &[f64])) {
        let n = self.n_rows - self.first;
        let mut row = target;
        while row + TILE_ROWS <= n {
            self.tile::<TILE_ROWS, C>(row, target, with);
            row += TILE_ROWS;
        }
        while row < n {
            self.tile::<1, C>(row, target, with);
            row += 1;
        }
    }

    #[inline(always)]
    fn tile<const R: usize, const C: usize>(
        &self,
        row: usize,
        target: usize,
        with: &mut impl FnMut(usize, usize, &[f64]),
    ) {
        let mut sums = [[0.0; R]; C];
        for column in self.values.chunks_exact(self.n_rows) {
            let column = &column[self.first..];
            let (Some(rows), Some(targets)) = (
                column[row..].first_chunk::<R>(),
                column[target..].first_chunk::<C>(),
            ) else {
                break;
            };
            for c in 0..C {
                for r in 0..R {
                    sums[c][r] += rows[r] * targets[c];
                }
            }
        }
        for (c, sums) in sums.into_iter().enumerate() {
            // A copy, so that the sums themselves stay in registers wherever this call is not inlined.
            let sums: [f64; R] = std::array::from_fn(|r| sums[r]);
            with(target + c, row, &sums);
        }
    }
}

/// [`Cholesky::solve`], compiled once more for processors with AVX2, as far as it is inlined.
struct Solving<'a> {
    cholesky: &'a Cholesky,
    right: &'a mut [f64],
}

impl pulp::WithSimd for Solving<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { cholesky, right } = self;
        // Of the block at hand: unknowns of its columns, then of its rows below.
        let mut own = Vec::new();
        for block in &cholesky.blocks {
            let n_rows = block.n_rows();
            let columns = block.first_column..block.first_column + block.n_columns;
            own.clear();
            own.extend_from_slice(&right[columns.clone()]);
            // Most blocks are not above a load in the order of elimination, and pass nothing on.
            if own.iter().all(|value| *value == 0.0) {
                continue;
            }
            own.resize(n_rows, 0.0);
            for (k, column) in block.values.chunks_exact(n_rows).enumerate() {
                own[k] /= column[k];
                let factor = own[k];
                for (own, value) in own[k + 1..].iter_mut().zip(&column[k + 1..]) {
                    *own -= factor * value;
                }
            }
            right[columns].copy_from_slice(&own[..block.n_columns]);
            for (&row, own) in block.rows_below.iter().zip(&own[block.n_columns..]) {
                right[row as usize] += own;
            }
        }
        for block in cholesky.blocks.iter().rev() {
            let columns = block.first_column..block.first_column + block.n_columns;
            own.clear();
            own.extend_from_slice(&right[columns.clone()]);
            own.extend(block.rows_below.iter().map(|&row| right[row as usize]));
            let values = block.values.chunks_exact(block.n_rows());
            for (k, column) in values.enumerate().rev() {
                own[k] = (own[k] - product(&column[k + 1..], &own[k + 1..])) / column[k];
            }
            right[columns].copy_from_slice(&own[..block.n_columns]);
        }
    }
}

/// A scalar product, in a fixed number of sums.
#[inline(always)]
fn product(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
