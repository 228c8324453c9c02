//! Uniform particles over a pane, sorted into the cells of a grid.

use starbreak_glass::Pane;
use starbreak_seed::{Seed, Stream, uniform};

use crate::lattice::Lattice;

/// Particles per grid cell on average.
const PER_CELL: f64 = 6.0;

/// Nodes of a mesh in the order of a grid of cells, row by row: neighbors on the pane are
/// neighbors in memory.
#[derive(Debug, Clone)]
pub struct Particles {
    x: Vec<f64>,
    y: Vec<f64>,
    /// First node of each cell, row-major, and the number of nodes at the end.
    cell_starts: Vec<u32>,
    n_columns: usize,
    n_rows: usize,
    cell_size: f64,
    /// Where the fixed points went.
    fixed: Vec<u32>,
}

/// Rounds of the insertion order; the first holds one node in 2^(ROUNDS − 1).
const ROUNDS: usize = 9;

/// Distance along a Hilbert curve over a grid of 2^16 × 2^16 cells.
fn hilbert_index(mut x: u32, mut y: u32) -> u64 {
    let mut along = 0;
    let mut side = 1_u32 << 15;
    while side > 0 {
        let (right, lower) = (u32::from(x & side > 0), u32::from(y & side > 0));
        along = (along << 2) | u64::from((3 * right) ^ lower);
        if lower == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
        side >>= 1;
    }
    along
}

/// A number that looks random, the same for the same node (splitmix64 [Steele2014]).
fn scramble(node: u32) -> u64 {
    let mut bits = u64::from(node)
        .wrapping_add(1)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

impl Particles {
    /// `count` particles drawn uniformly over the inside of the pane, and the `fixed` points.
    ///
    /// Positions are rounded to a lattice of 2^-26 of the longer side. A particle that falls on
    /// a place that is taken is left out; a fixed point never is, and two equal fixed points
    /// become one node.
    #[must_use]
    pub fn scatter(pane: &Pane, count: u32, fixed: &[[f64; 2]], seed: Seed) -> Self {
        let lattice = Lattice::of_pane(pane);
        let mut rng = seed.stream(Stream::Particles, 0);
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(count as usize + fixed.len());
        points.extend_from_slice(fixed);
        for _ in 0..count {
            let x = lattice.round_inside(uniform(&mut rng) * pane.width, pane.width);
            let y = lattice.round_inside(uniform(&mut rng) * pane.height, pane.height);
            points.push([x, y]);
        }
        Self::sorted_into_cells(pane, &points, fixed.len())
    }

    fn sorted_into_cells(pane: &Pane, points: &[[f64; 2]], n_fixed: usize) -> Self {
        #[expect(
            clippy::cast_precision_loss,
            reason = "a count, only to choose a cell size"
        )]
        let n = points.len().max(1) as f64;
        // Long thin panes get square cells all the same, but never more cells than points.
        let cell_size = (pane.width * pane.height * PER_CELL / n)
            .sqrt()
            .max(pane.width.max(pane.height) / n);
        let columns_of = |side: f64| to_index(side / cell_size) + 1;
        let (n_columns, n_rows) = (columns_of(pane.width), columns_of(pane.height));
        let mut particles = Self {
            x: Vec::with_capacity(points.len()),
            y: Vec::with_capacity(points.len()),
            cell_starts: vec![0; n_columns * n_rows + 1],
            n_columns,
            n_rows,
            cell_size,
            fixed: vec![0; n_fixed],
        };
        let cells: Vec<u32> = points
            .iter()
            .map(|[x, y]| to_u32(particles.cell(*x, *y)))
            .collect();
        let mut starts = vec![0_u32; n_columns * n_rows + 1];
        for &cell in &cells {
            starts[cell as usize + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut order = vec![0_u32; points.len()];
        let mut next = starts.clone();
        for (idx, &cell) in (0_u32..).zip(&cells) {
            let slot = &mut next[cell as usize];
            order[*slot as usize] = idx;
            *slot += 1;
        }
        for cell in 0..n_columns * n_rows {
            let first = particles.x.len();
            // The fixed points were first in `points`, so they are first in their cell, too.
            for &idx in &order[starts[cell] as usize..starts[cell + 1] as usize] {
                let [x, y] = points[idx as usize];
                #[expect(clippy::float_cmp, reason = "lattice positions are equal or apart")]
                let taken = (first..particles.x.len())
                    .find(|&k| particles.x[k] == x && particles.y[k] == y);
                let node = taken.unwrap_or(particles.x.len());
                if taken.is_none() {
                    particles.x.push(x);
                    particles.y.push(y);
                }
                if let Some(slot) = particles.fixed.get_mut(idx as usize) {
                    *slot = to_u32(node);
                }
            }
            particles.cell_starts[cell + 1] = to_u32(particles.x.len());
        }
        particles
    }

    fn cell(&self, x: f64, y: f64) -> usize {
        self.row(y) * self.n_columns + self.column(x)
    }

    fn column(&self, x: f64) -> usize {
        to_index(x / self.cell_size).min(self.n_columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        to_index(y / self.cell_size).min(self.n_rows - 1)
    }

    /// Number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is no node at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Position of a node.
    ///
    /// # Panics
    /// If there is no such node.
    #[must_use]
    pub fn position(&self, node: u32) -> [f64; 2] {
        [self.x[node as usize], self.y[node as usize]]
    }

    /// The node of the `idx`-th fixed point.
    ///
    /// # Panics
    /// If there was no such point.
    #[must_use]
    pub fn fixed_node(&self, idx: usize) -> u32 {
        self.fixed[idx]
    }

    /// All nodes in an order in which a triangulation grows fast: rounds of about doubling size,
    /// each a random sample, and within a round along a Hilbert curve over the cells, so that each
    /// node lies near the one before it (biased randomized insertion order \[Amenta2003\]).
    pub(crate) fn insertion_order(&self) -> Vec<u32> {
        let mut cells: Vec<(u64, u32)> = Vec::with_capacity(self.n_columns * self.n_rows);
        for row in 0..self.n_rows {
            for column in 0..self.n_columns {
                let along = hilbert_index(to_u32(column), to_u32(row));
                cells.push((along, to_u32(row * self.n_columns + column)));
            }
        }
        cells.sort_unstable();
        let mut rounds: [Vec<u32>; ROUNDS] = Default::default();
        for (_, cell) in cells {
            let cell = cell as usize;
            for node in self.cell_starts[cell]..self.cell_starts[cell + 1] {
                // Half of the nodes go into the last round, half of the rest into the one before.
                let round = scramble(node).trailing_zeros() as usize;
                rounds[round.min(ROUNDS - 1)].push(node);
            }
        }
        rounds.into_iter().rev().flatten().collect()
    }

    /// Calls `visit(node, dx, dy, distance²)` for every node other than `center` within `radius`
    /// of it, in ascending order of nodes.
    pub(crate) fn for_each_within(
        &self,
        center: u32,
        radius: f64,
        mut visit: impl FnMut(u32, f64, f64, f64),
    ) {
        let [x, y] = self.position(center);
        let radius2 = radius * radius;
        for row in self.row(y - radius)..=self.row(y + radius) {
            #[expect(clippy::cast_precision_loss, reason = "a row number")]
            let (top, bottom) = (
                row as f64 * self.cell_size,
                (row + 1) as f64 * self.cell_size,
            );
            // The last row also holds what lies on the rim of the pane, beyond its lower edge.
            let gap = if row + 1 == self.n_rows {
                (top - y).max(0.0)
            } else {
                (top - y).max(y - bottom).max(0.0)
            };
            // One part in 10^9 more than the chord, so that rounding never loses a neighbor.
            let half_chord = (radius2 - gap * gap).max(0.0).sqrt() + radius * 1e-9;
            let first = self.cell_starts[row * self.n_columns + self.column(x - half_chord)];
            let last = self.cell_starts[row * self.n_columns + self.column(x + half_chord) + 1];
            let (first, last) = (first as usize, last as usize);
            for (node, (&other_x, &other_y)) in
                (first..last).zip(self.x[first..last].iter().zip(&self.y[first..last]))
            {
                let (dx, dy) = (other_x - x, other_y - y);
                let distance2 = dx * dx + dy * dy;
                if distance2 <= radius2 && distance2 > 0.0 {
                    visit(to_u32(node), dx, dy, distance2);
                }
            }
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates; cells are clamped"
)]
fn to_index(value: f64) -> usize {
    value as usize
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "node counts are bounded by u32 from the particle count on"
)]
pub(crate) fn to_u32(index: usize) -> u32 {
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brute(particles: &Particles, center: u32, radius: f64) -> Vec<u32> {
        let [x, y] = particles.position(center);
        (0..to_u32(particles.len()))
            .filter(|&node| {
                let [other_x, other_y] = particles.position(node);
                let distance2 = (other_x - x).powi(2) + (other_y - y).powi(2);
                node != center && distance2 <= radius * radius
            })
            .collect()
    }

    #[test]
    fn the_grid_finds_what_a_full_search_finds() {
        for (width, height, count) in [
            (1242, 375, 3000),
            (1, 1, 500),
            (1, 900, 700),
            (900, 1, 700),
            (40, 40, 1),
        ] {
            let pane = Pane::from_frame_px(width, height);
            let corner = [pane.width, pane.height];
            let particles = Particles::scatter(&pane, count, &[[0.0, 0.0], corner], Seed(3));
            for radius in [0.001, 0.3, 7.0, 65.0, 4000.0] {
                for center in (0..to_u32(particles.len())).step_by(particles.len() / 20 + 1) {
                    let mut found = Vec::new();
                    particles.for_each_within(center, radius, |node, _, _, _| found.push(node));
                    assert_eq!(
                        found,
                        brute(&particles, center, radius),
                        "{width}×{height}, radius {radius}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_insertion_order_holds_every_node_once() {
        for count in [0, 1, 2, 5000] {
            let particles = Particles::scatter(
                &Pane::from_frame_px(300, 100),
                count,
                &[[0.0, 0.0]],
                Seed(5),
            );
            let mut order = particles.insertion_order();
            order.sort_unstable();
            assert!(
                order.into_iter().eq(0..to_u32(particles.len())),
                "{count} particles"
            );
        }
    }

    #[test]
    fn neighbors_on_the_hilbert_curve_are_neighbors_on_the_grid() {
        let mut cells: Vec<_> = (0..64 * 64)
            .map(|k| (hilbert_index(k % 64, k / 64), k % 64, k / 64))
            .collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let ((_, x0, y0), (_, x1, y1)) = (pair[0], pair[1]);
            assert_eq!(
                x0.abs_diff(x1) + y0.abs_diff(y1),
                1,
                "the curve never jumps"
            );
        }
    }

    #[test]
    fn no_two_nodes_share_a_place_even_when_the_lattice_is_crowded() {
        // A pane so thin that its lattice offers few places across.
        let pane = Pane {
            width: 1.0,
            height: 1e-7,
            thickness_mm: None,
            kind: None,
        };
        let particles = Particles::scatter(&pane, 20_000, &[[0.5, 0.0], [0.5, 0.0]], Seed(1));
        let mut places: Vec<_> = (0..to_u32(particles.len()))
            .map(|node| particles.position(node).map(f64::to_bits))
            .collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), particles.len(), "a place holds one node");
        assert_eq!(
            particles.fixed_node(0),
            particles.fixed_node(1),
            "equal fixed points are one node"
        );
    }

    #[test]
    fn particles_are_uniform() {
        // χ² over 20 × 20 bins: mean 399, standard deviation 28.
        let pane = Pane::from_frame_px(200, 200);
        let particles = Particles::scatter(&pane, 40_000, &[], Seed(9));
        let mut bins = vec![0.0_f64; 400];
        for node in 0..to_u32(particles.len()) {
            let [x, y] = particles.position(node);
            bins[to_index(y / 10.0).min(19) * 20 + to_index(x / 10.0).min(19)] += 1.0;
        }
        let chi2: f64 = bins
            .iter()
            .map(|count| (count - 100.0).powi(2) / 100.0)
            .sum();
        assert!((290.0..520.0).contains(&chi2), "χ² = {chi2}");
    }
}
