//! Crack patterns as numbers: lengths, degrees, angles, area.

use super::counts::Counts;
use super::gradient::count;
use crate::EvalError;

pub(super) const N_LENGTH_BINS: usize = 48;
pub(super) const N_DEGREE_BINS: usize = 12;
pub(super) const N_ANGLE_BINS: usize = 36;
pub(super) const N_AREA_BINS: usize = 40;

/// Decades from the shortest to the longest, and from the least to the whole area.
const DECADES: f64 = 4.0;

pub(super) const LENGTH_BIN_WIDTH: f64 = DECADES / 48.0;
pub(super) const AREA_BIN_WIDTH: f64 = DECADES / 40.0;

/// What is measured of one crack pattern; what is not known of it stays empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrackGeometry {
    /// Length of each branch along its bends, from an end or a junction to the next, in diagonals of
    /// the pane or frame.
    pub branch_length_diagonals: Vec<f64>,
    /// Number of branches at each end and junction.
    pub node_degree: Vec<u32>,
    /// Angle between neighboring branches at each node where three or more meet, rad.
    pub branch_angle_rad: Vec<f64>,
    /// Share of the frame that its mask covers, 0 to 1.
    pub mask_area: Option<f64>,
}

impl CrackGeometry {
    /// The geometry of a network: places of nodes and, for each segment, its two nodes; all in one
    /// unit, that of the diagonal.
    ///
    /// Nodes at which a crack only bends (two segments) are no junctions, so that it does not matter
    /// in how many pieces a crack was traced.
    ///
    /// # Errors
    /// [`EvalError::NotComparable`] for a segment to a node that is not there, a place that is not
    /// finite, or a diagonal that is not above 0.
    pub fn of_network(
        nodes: &[[f64; 2]],
        segments: &[[usize; 2]],
        diagonal: f64,
    ) -> Result<Self, EvalError> {
        let refuse = |fact: String| EvalError::NotComparable {
            fact,
            way_out: "check the network file",
        };
        if !(diagonal.is_finite() && diagonal > 0.0) {
            return Err(refuse(format!("the pane has a diagonal of {diagonal}")));
        }
        let place = |node: usize| {
            let place = nodes.get(node).filter(|p| p.iter().all(|v| v.is_finite()));
            place.ok_or_else(|| refuse(format!("node {node} of {} has no place", nodes.len())))
        };
        let mut neighbors: Vec<Vec<(usize, f64)>> = vec![Vec::new(); nodes.len()];
        for &[from, to] in segments {
            let ([x0, y0], [x1, y1]) = (place(from)?, place(to)?);
            let length = libm::hypot(x1 - x0, y1 - y0);
            for (node, other) in [(from, to), (to, from)] {
                if let Some(list) = neighbors.get_mut(node) {
                    list.push((other, length));
                }
            }
        }
        let mut geometry = Self::default();
        for length in branch_lengths(&neighbors) {
            geometry.branch_length_diagonals.push(length / diagonal);
        }
        for (node, list) in neighbors.iter().enumerate() {
            if list.is_empty() || list.len() == 2 {
                continue;
            }
            geometry
                .node_degree
                .push(u32::try_from(list.len()).unwrap_or(u32::MAX));
            if list.len() < 3 {
                continue;
            }
            let [x, y] = place(node)?;
            let mut directions = Vec::new();
            for (other, _) in list {
                let [to_x, to_y] = place(*other)?;
                directions.push(libm::atan2(to_y - y, to_x - x));
            }
            directions.sort_by(f64::total_cmp);
            let around = directions
                .first()
                .map(|first| first + std::f64::consts::TAU);
            let next = directions.iter().skip(1).copied().chain(around);
            let angles: Vec<f64> = directions.iter().zip(next).map(|(a, b)| b - a).collect();
            geometry.branch_angle_rad.extend(angles);
        }
        Ok(geometry)
    }

    /// Its histograms, in the order of [`Feature::OF_CRACKS`](super::Feature::OF_CRACKS).
    pub(in crate::divergence) fn counts(&self) -> Vec<Counts> {
        let mut lengths = vec![0.0; N_LENGTH_BINS];
        for length in &self.branch_length_diagonals {
            count(&mut lengths, share_of_decades(*length), 1.0);
        }
        let mut degrees = vec![0.0; N_DEGREE_BINS];
        for degree in &self.node_degree {
            let bin = usize::try_from(degree.saturating_sub(1)).unwrap_or(usize::MAX);
            if let Some(slot) = degrees.get_mut(bin.min(N_DEGREE_BINS - 1)) {
                *slot += 1.0;
            }
        }
        let mut angles = vec![0.0; N_ANGLE_BINS];
        for angle in &self.branch_angle_rad {
            count(&mut angles, angle / std::f64::consts::TAU, 1.0);
        }
        let mut areas = vec![0.0; N_AREA_BINS];
        if let Some(area) = self.mask_area {
            count(&mut areas, share_of_decades(area), 1.0);
        }
        [lengths, degrees, angles, areas]
            .map(|h| Counts::of(&h))
            .to_vec()
    }
}

/// Lengths of the stretches between nodes that have not two neighbors, and of rings without any.
fn branch_lengths(neighbors: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let n_of = |node: usize| neighbors.get(node).map_or(0, Vec::len);
    let mut is_walked: Vec<Vec<bool>> = neighbors
        .iter()
        .map(|list| vec![false; list.len()])
        .collect();
    let mut lengths = Vec::new();
    let ends = (0..neighbors.len()).filter(|node| n_of(*node) != 2);
    // Rings have no end; they begin wherever they are met first.
    let starts = ends.chain((0..neighbors.len()).filter(|node| n_of(*node) == 2));
    for start in starts {
        for first in 0..n_of(start) {
            let (mut node, mut exit, mut length) = (start, first, 0.0);
            while let Some(flag) = is_walked
                .get_mut(node)
                .and_then(|flags| flags.get_mut(exit))
            {
                if *flag {
                    break;
                }
                *flag = true;
                let Some(&(next, step)) = neighbors.get(node).and_then(|list| list.get(exit))
                else {
                    break;
                };
                length += step;
                // The way back from there is walked, too.
                let back = neighbors
                    .get(next)
                    .and_then(|list| list.iter().position(|(to, _)| *to == node));
                let Some(back) = back else { break };
                if let Some(flag) = is_walked
                    .get_mut(next)
                    .and_then(|flags| flags.get_mut(back))
                {
                    *flag = true;
                }
                if n_of(next) != 2 {
                    break;
                }
                (node, exit) = (next, 1 - back.min(1));
            }
            if length > 0.0 {
                lengths.push(length);
            }
        }
    }
    lengths
}

/// Where a value lies between 10⁻⁴ and 1, by its logarithm, 0 to 1.
fn share_of_decades(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    1.0 + libm::log10(value) / DECADES
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_star_of_three_arms_has_one_node_of_three_and_angles_that_close() {
        let nodes = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0], [-5.0, 0.0]];
        let star = CrackGeometry::of_network(&nodes, &[[0, 1], [0, 2], [3, 0]], 10.0).unwrap();
        assert_eq!(
            star.branch_length_diagonals,
            [0.3, 0.4, 0.5],
            "of a diagonal of 10"
        );
        assert_eq!(star.node_degree, [3, 1, 1, 1], "a middle and three ends");
        let sum: f64 = star.branch_angle_rad.iter().sum();
        assert!(
            (sum - std::f64::consts::TAU).abs() < 1e-12,
            "once around: {sum}"
        );
        assert_eq!(
            star.branch_angle_rad.len(),
            3,
            "a right, a right and a straight angle"
        );
    }

    #[test]
    fn a_bend_is_no_junction_and_a_ring_is_one_branch() {
        let nodes = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
        let bent = CrackGeometry::of_network(&nodes, &[[0, 1], [1, 2]], 10.0).unwrap();
        assert_eq!(bent.branch_length_diagonals, [0.7], "3 and 4");
        assert_eq!(bent.node_degree, [1, 1], "its ends");
        let ring = CrackGeometry::of_network(&nodes, &[[0, 1], [1, 2], [2, 0]], 10.0).unwrap();
        assert_eq!(ring.branch_length_diagonals, [1.2], "3, 4 and 5");
        assert_eq!(ring.node_degree, [0_u32; 0], "without an end");
    }

    #[test]
    fn a_segment_to_nowhere_is_refused() {
        let error = CrackGeometry::of_network(&[[0.0, 0.0]], &[[0, 7]], 1.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "node 7 of 1 has no place; check the network file",
            "which"
        );
    }
}
