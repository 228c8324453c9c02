//! The cracks between dice as a graph on the pane.

/// Speed of the front that divides tempered glass, m/s. **Source** \[AcersVideo\]: 78 597 frames
/// per second.
pub const FRONT_SPEED_M_S: f64 = 1458.0;

/// Cracks between dice. Edges meet only at nodes; the rim is no edge, but edges end on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diced {
    /// Positions, m.
    pub nodes: Vec<[f64; 2]>,
    /// When the front reaches each node, s after the first touch: distance from the nearest hit
    /// over [`FRONT_SPEED_M_S`].
    pub arrival_s: Vec<f64>,
    /// Pairs of nodes, the earlier first.
    pub edges: Vec<[u32; 2]>,
    /// Number of dice; 1 where nothing divides the pane.
    pub n_cells: usize,
}

impl Diced {
    /// When a crack is at both ends of an edge, s: never faster than the front, so never zero
    /// between.
    ///
    /// # Panics
    /// If there is no such edge.
    #[must_use]
    pub fn edge_times_s(&self, edge: usize) -> [f64; 2] {
        let [from, to] = self.edges[edge].map(|node| node as usize);
        let (a, b) = (self.nodes[from], self.nodes[to]);
        let least = libm::hypot(a[0] - b[0], a[1] - b[1]) / FRONT_SPEED_M_S;
        let start = self.arrival_s[from];
        [start, self.arrival_s[to].max(start + least)]
    }

    /// A graph with times, its edges from early to late and in the order of their nodes.
    pub(super) fn timed(
        nodes: Vec<[f64; 2]>,
        mut edges: Vec<[u32; 2]>,
        n_cells: usize,
        impacts_m: &[[f64; 2]],
    ) -> Self {
        let arrival_s: Vec<f64> = nodes
            .iter()
            .map(|node| {
                let distances = impacts_m
                    .iter()
                    .map(|hit| libm::hypot(node[0] - hit[0], node[1] - hit[1]));
                let nearest = distances.fold(f64::INFINITY, f64::min);
                if nearest.is_finite() {
                    nearest / FRONT_SPEED_M_S
                } else {
                    0.0
                }
            })
            .collect();
        for edge in &mut edges {
            let [a, b] = *edge;
            if (arrival_s[b as usize], b) < (arrival_s[a as usize], a) {
                *edge = [b, a];
            }
        }
        Self {
            nodes,
            arrival_s,
            edges,
            n_cells,
        }
    }
}
