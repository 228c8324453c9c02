//! The cracks between dice as a graph on the pane.

/// Speed of the front that divides tempered glass, m/s. **Source** a video of the American
/// Ceramic Society at 78 597 frames per second.
pub const FRONT_SPEED_M_S: f64 = 1458.0;

/// Cracks between dice. Edges meet only at nodes; the rim is no edge, but edges end on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diced {
    /// Positions, m.
    pub nodes: Vec<[f64; 2]>,
    /// Pairs of nodes: where a crack comes from and where it goes to.
    pub edges: Vec<[u32; 2]>,
    /// When the crack is at both ends of each edge, s after the first touch: the second is later
    /// than the first.
    pub times_s: Vec<[f64; 2]>,
    /// Number of dice; 1 where nothing divides the pane.
    pub n_cells: usize,
}

impl Diced {
    /// A graph in which a front runs out from the nearest hit: at [`FRONT_SPEED_M_S`] along the
    /// radius, and no faster along any edge.
    pub(super) fn with_front(
        nodes: Vec<[f64; 2]>,
        mut edges: Vec<[u32; 2]>,
        n_cells: usize,
        impacts_m: &[[f64; 2]],
    ) -> Self {
        let distance = |a: &[f64; 2], b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
        let arrival_s: Vec<f64> = nodes
            .iter()
            .map(|node| {
                let distances = impacts_m.iter().map(|hit| distance(node, hit));
                let nearest = distances.fold(f64::INFINITY, f64::min);
                if nearest.is_finite() {
                    nearest / FRONT_SPEED_M_S
                } else {
                    0.0
                }
            })
            .collect();
        let times_s = edges
            .iter_mut()
            .map(|edge| {
                let time = |node: u32| arrival_s[node as usize];
                let [a, b] = *edge;
                if (time(b), b) < (time(a), a) {
                    *edge = [b, a];
                }
                let [from, to] = *edge;
                let length = distance(&nodes[from as usize], &nodes[to as usize]);
                let start = time(from);
                [start, time(to).max(start + length / FRONT_SPEED_M_S)]
            })
            .collect();
        Self {
            nodes,
            edges,
            times_s,
            n_cells,
        }
    }
}
