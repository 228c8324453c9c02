//! Nodes of a flat sheet: a square lattice, perhaps jittered.

use crate::random::Random;

/// Nodes at the cell centers of a square lattice, row by row; each stands for an area dx².
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Nodes along x.
    pub n_x: usize,
    /// Nodes along y.
    pub n_y: usize,
    /// Spacing, m.
    pub spacing_m: f64,
    /// Positions, m; the middle of the sheet is the origin.
    pub x_m: Vec<f64>,
    /// Positions, m.
    pub y_m: Vec<f64>,
    /// Largest displacement of a node from its cell center, in spacings.
    jitter: f64,
}

impl Lattice {
    /// A lattice whose nodes are moved by up to `jitter` spacings along each axis. Jitter breaks
    /// the symmetry of the square lattice, along whose axes cracks would prefer to run.
    #[must_use]
    pub fn new(n_x: usize, n_y: usize, spacing_m: f64, jitter: f64, random: &mut Random) -> Self {
        let mut x_m = Vec::with_capacity(n_x * n_y);
        let mut y_m = Vec::with_capacity(n_x * n_y);
        let at = |i: usize, n: usize| (as_f64(i) + 0.5 - 0.5 * as_f64(n)) * spacing_m;
        for row in 0..n_y {
            for column in 0..n_x {
                x_m.push(at(column, n_x) + jitter * spacing_m * random.symmetric());
                y_m.push(at(row, n_y) + jitter * spacing_m * random.symmetric());
            }
        }
        Self {
            n_x,
            n_y,
            spacing_m,
            x_m,
            y_m,
            jitter,
        }
    }

    /// Number of nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.n_x * self.n_y
    }

    /// Whether there is no node.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Distance of two nodes, m.
    #[must_use]
    pub fn distance_m(&self, i: usize, j: usize) -> f64 {
        libm::hypot(self.x_m[j] - self.x_m[i], self.y_m[j] - self.y_m[i])
    }

    /// Nodes `j > i` not farther than `radius_m`, in rising order, for each `i` in turn.
    pub fn pairs(&self, radius_m: f64) -> impl Iterator<Item = (usize, usize)> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few spacings"
        )]
        let reach = (radius_m / self.spacing_m + 2.0 * self.jitter + 1e-9).floor() as usize;
        // A lattice distance of exactly the radius is inside, whatever the rounding.
        let limit_m = radius_m * (1.0 + 1e-9);
        (0..self.len()).flat_map(move |i| {
            let (row, column) = (i / self.n_x, i % self.n_x);
            let rows = row..(row + reach + 1).min(self.n_y);
            rows.flat_map(move |r| {
                let columns = column.saturating_sub(reach)..(column + reach + 1).min(self.n_x);
                columns.map(move |c| r * self.n_x + c)
            })
            .filter(move |&j| j > i && self.distance_m(i, j) <= limit_m)
            .map(move |j| (i, j))
        })
    }
}

/// A count as a number.
#[expect(
    clippy::cast_precision_loss,
    reason = "counts of nodes are far below 2^53"
)]
#[must_use]
pub const fn as_f64(n: usize) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_those_of_all_pairs() {
        let lattice = Lattice::new(11, 9, 0.5, 0.35, &mut Random::new(3));
        let all: Vec<_> = (0..lattice.len())
            .flat_map(|i| (i + 1..lattice.len()).map(move |j| (i, j)))
            .filter(|&(i, j)| lattice.distance_m(i, j) <= 0.85)
            .collect();
        assert_eq!(
            lattice.pairs(0.85).collect::<Vec<_>>(),
            all,
            "all within 0.85 m"
        );
    }

    #[test]
    fn a_regular_node_has_48_neighbors_in_four_spacings() {
        let lattice = Lattice::new(9, 9, 1.0, 0.0, &mut Random::new(0));
        let n = lattice
            .pairs(4.0)
            .filter(|&(i, j)| i == 40 || j == 40)
            .count();
        assert_eq!(
            n, 48,
            "points of the square lattice in a circle of radius 4, without its center"
        );
    }
}
