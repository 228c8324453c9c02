//! The sparse system of a mesh with three unknowns per side of a node: assembly, Cholesky factor,
//! solution.
//!
//! The sides of a node share its deflection, which is the first unknown of its first side. That of
//! the others is held and stands for nothing.

use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, amd};

use super::cholesky::{Cholesky, Lower};
use super::dkt::{N_LOCAL, N_PACKED};
use crate::FractureError;
use crate::mesh::{PlateMesh, to_u32};

/// A symmetric positive definite matrix (its lower triangle, column by column) and its factor.
///
/// Nodes are numbered in the order of elimination from the start, and where each entry of each
/// element goes is known, so that a new factor costs assembly and numbers only.
pub(super) struct System {
    /// Place of each node in the order of elimination.
    place: Vec<u32>,
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// Where the packed entries of each element are added.
    scatter: Vec<[u32; N_PACKED]>,
    values: Vec<f64>,
    factor: Cholesky,
}

/// The nodes of a triangle, then their sides.
type Stencil = [u32; 6];

fn failed(cause: impl std::fmt::Debug) -> FractureError {
    FractureError::Solver {
        cause: format!("{cause:?}"),
    }
}

impl System {
    /// The pattern of a mesh with its ordering and symbolic factor.
    pub(super) fn new(mesh: &PlateMesh) -> Result<Self, FractureError> {
        let n_nodes = mesh.nodes_of_sides().len();
        let corners = || mesh.triangles().iter().zip(mesh.sides());
        let stencil = |[a, b, c]: [u32; 3], [d, e, f]: [u32; 3]| [a, b, c, d, e, f];
        let stencils: Vec<Stencil> = corners()
            .map(|(nodes, sides)| stencil(*nodes, *sides))
            .chain(
                corners()
                    .filter(|(nodes, sides)| nodes != sides)
                    .map(|(nodes, _)| stencil(*nodes, *nodes)),
            )
            .collect();
        let place = elimination_order(n_nodes, &stencils)?;
        let placed: Vec<Stencil> = stencils
            .iter()
            .map(|stencil| stencil.map(|node| place[node as usize]))
            .collect();
        let later = later_neighbors(n_nodes, &placed);
        let mut columns = vec![0];
        let mut rows = Vec::new();
        for (node, later) in (0..).zip(&later) {
            for c in 0..3 {
                rows.extend((c..3).map(|r| 3 * node + r));
                rows.extend(
                    later
                        .iter()
                        .flat_map(|other| [0, 1, 2].map(|r| 3 * other + r)),
                );
                columns.push(to_u32(rows.len()));
            }
        }
        let n = 3 * n_nodes;
        let (upper_columns, upper_rows) = upper(&later);
        // In the given order faer reads the upper triangle, whatever it is told.
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(n, n, &upper_columns, None, &upper_rows),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..CholeskySymbolicParams::default()
            },
        )
        .map_err(failed)?;
        let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
            return Err(failed("no supernodes"));
        };
        let scatter = placed
            .iter()
            .map(|triangle| scatter(triangle, &columns, &later))
            .collect();
        Ok(Self {
            values: vec![0.0; rows.len()],
            factor: Cholesky::new(symbolic),
            place,
            columns,
            rows,
            scatter,
        })
    }

    /// Assembles the elements' packed matrices and a diagonal for the first unknown of each node,
    /// holds the unknowns in `is_fixed`, and factors.
    ///
    /// Elements are those of the triangles, then once more those of the triangles with a side that
    /// is not the first of its node, for unknowns of the first sides.
    pub(super) fn factor<'a>(
        &mut self,
        elements: impl Iterator<Item = &'a [f64; N_PACKED]>,
        diagonal: &[f64],
        is_fixed: &[[bool; 3]],
    ) -> Result<(), FractureError> {
        self.values.fill(0.0);
        for (packed, scatter) in elements.zip(&self.scatter) {
            for (value, &at) in packed.iter().zip(scatter) {
                self.values[at as usize] += value;
            }
        }
        for (value, &place) in diagonal.iter().zip(&self.place) {
            self.values[self.columns[3 * place as usize] as usize] += value;
        }
        self.hold(is_fixed);
        self.factor.factor(&Lower {
            columns: &self.columns,
            rows: &self.rows,
            values: &self.values,
        })
    }

    /// Replaces rows and columns of held unknowns by those of the unit matrix.
    fn hold(&mut self, is_fixed: &[[bool; 3]]) {
        let mut held = vec![false; self.columns.len() - 1];
        for (fixed, &place) in is_fixed.iter().zip(&self.place) {
            for c in 0..3 {
                held[3 * place as usize + c] = fixed[c];
            }
        }
        for (column, range) in self.columns.windows(2).enumerate() {
            for at in range[0] as usize..range[1] as usize {
                let row = self.rows[at] as usize;
                if held[row] || held[column] {
                    self.values[at] = if row == column { 1.0 } else { 0.0 };
                }
            }
        }
    }

    /// The solution for a load with three entries per node, zero where unknowns are held, and the
    /// residual of its equations.
    pub(super) fn solve(&self, load: &[[f64; 3]]) -> Solution {
        let n = self.columns.len() - 1;
        let mut right = vec![0.0; n];
        for (load, &place) in load.iter().zip(&self.place) {
            let at = 3 * place as usize;
            right[at..at + 3].copy_from_slice(load);
        }
        let mut unknowns = right.clone();
        self.factor.solve(&mut unknowns);
        let relative_residual = self.relative_residual(&unknowns, &right);
        let by_node = self
            .place
            .iter()
            .map(|&place| [0, 1, 2].map(|c| unknowns[3 * place as usize + c]))
            .collect();
        Solution {
            by_node,
            relative_residual,
        }
    }

    /// ‖K u − f‖ / ‖ |K| |u| + |f| ‖, each unknown measured in units of the root of its stiffness,
    /// so that forces and moments can be compared. Against ‖f‖ alone even a rigid motion rounded
    /// to 53 bits is 1e-9 on a mesh from 1 mm to 1 m.
    fn relative_residual(&self, unknowns: &[f64], right: &[f64]) -> f64 {
        let mut rest: Vec<f64> = right.iter().map(|f| -f).collect();
        let mut whole: Vec<f64> = right.iter().map(|f| f.abs()).collect();
        for (column, range) in self.columns.windows(2).enumerate() {
            for at in range[0] as usize..range[1] as usize {
                let (row, value) = (self.rows[at] as usize, self.values[at]);
                let below = value * unknowns[column];
                rest[row] += below;
                whole[row] += below.abs();
                if row != column {
                    let above = value * unknowns[row];
                    rest[column] += above;
                    whole[column] += above.abs();
                }
            }
        }
        let norm = |vector: &[f64]| {
            let squares = vector.iter().zip(&self.columns);
            let sum: f64 = squares
                .map(|(x, &start)| x * x / self.values[start as usize])
                .sum();
            sum.sqrt()
        };
        let (rest, whole) = (norm(&rest), norm(&whole));
        if whole > 0.0 { rest / whole } else { rest }
    }
}

/// What solving gives.
pub(super) struct Solution {
    pub(super) by_node: Vec<[f64; 3]>,
    pub(super) relative_residual: f64,
}

/// Place of each node in an order that keeps the factor sparse (approximate minimum degree of
/// the graph of nodes, a third of the work of that of unknowns) \[Amestoy1996\].
fn elimination_order(n_nodes: usize, stencils: &[Stencil]) -> Result<Vec<u32>, FractureError> {
    let later = later_neighbors(n_nodes, stencils);
    let mut columns = vec![0];
    let mut rows = Vec::new();
    for (node, later) in (0..).zip(&later) {
        rows.push(node);
        rows.extend(later);
        columns.push(to_u32(rows.len()));
    }
    let graph = SymbolicSparseColMatRef::new_checked(n_nodes, n_nodes, &columns, None, &rows);
    let mut order = vec![0_u32; n_nodes];
    let mut place = vec![0_u32; n_nodes];
    let mut scratch = MemBuffer::try_new(amd::order_maybe_unsorted_scratch::<u32>(
        n_nodes,
        rows.len(),
    ))
    .map_err(failed)?;
    amd::order_maybe_unsorted(
        &mut order,
        &mut place,
        graph,
        amd::Control::default(),
        MemStack::new(&mut scratch),
    )
    .map_err(failed)?;
    Ok(place)
}

/// For each node its neighbors of higher number, in order.
fn later_neighbors(n_nodes: usize, stencils: &[Stencil]) -> Vec<Vec<u32>> {
    let mut later: Vec<Vec<u32>> = vec![Vec::with_capacity(8); n_nodes];
    for stencil in stencils {
        for (k, &a) in stencil.iter().enumerate() {
            for &b in stencil[..k].iter().filter(|&&b| b != a) {
                later[a.min(b) as usize].push(a.max(b));
            }
        }
    }
    for neighbors in &mut later {
        neighbors.sort_unstable();
        neighbors.dedup();
    }
    later
}

/// Columns and rows of the upper triangle.
fn upper(later: &[Vec<u32>]) -> (Vec<u32>, Vec<u32>) {
    let mut earlier: Vec<Vec<u32>> = vec![Vec::with_capacity(8); later.len()];
    for (node, later) in (0..).zip(later) {
        for &other in later {
            earlier[other as usize].push(node);
        }
    }
    let mut columns = vec![0];
    let mut rows = Vec::new();
    for (node, earlier) in (0..).zip(&earlier) {
        for c in 0..3 {
            rows.extend(
                earlier
                    .iter()
                    .flat_map(|other| [0, 1, 2].map(|r| 3 * other + r)),
            );
            rows.extend((0..=c).map(|r| 3 * node + r));
            columns.push(to_u32(rows.len()));
        }
    }
    (columns, rows)
}

/// Where the packed entries of an element go.
fn scatter(stencil: &Stencil, columns: &[u32], later: &[Vec<u32>]) -> [u32; N_PACKED] {
    let place = |high: u32, row: u32, low: u32, column: u32| {
        let start = columns[(3 * low + column) as usize];
        if high == low {
            start + row - column
        } else {
            let nth = later[low as usize].partition_point(|&other| other < high);
            start + 3 - column + 3 * to_u32(nth) + row
        }
    };
    let mut out = [0; N_PACKED];
    let mut at = 0;
    let unknown = |local: usize| {
        let corner = local / 3;
        let of_side = if local.is_multiple_of(3) { 0 } else { 3 };
        (stencil[corner + of_side], to_u32(local % 3))
    };
    for i in 0..N_LOCAL {
        for j in 0..=i {
            let (a, b) = (unknown(i), unknown(j));
            let (high, low) = if a > b { (a, b) } else { (b, a) };
            out[at] = place(high.0, high.1, low.0, low.1);
            at += 1;
        }
    }
    out
}
