//! Crack networks as numbers: lengths, degrees, angles.

use super::{Counts, Feature, count};
use crate::EvalError;

/// Decades from the shortest length to the longest.
pub(super) const DECADES: f64 = 4.0;

/// The histograms of a network, given as places of nodes and the two nodes of each segment, in the order of
/// [`Feature::OF_NETWORKS`].
///
/// # Errors
/// As for [`Geometry::of`].
pub(in crate::divergence) fn network_counts(
    nodes: &[[f64; 2]],
    segments: &[[usize; 2]],
    diagonal: f64,
) -> Result<Vec<Counts>, EvalError> {
    let geometry = Geometry::of(nodes, segments, diagonal)?;
    let mut lengths = vec![0.0; Feature::SegmentLength.n_bins()];
    for length in geometry.branch_lengths {
        count(&mut lengths, 1.0 + libm::log10(length) / DECADES, 1.0);
    }
    let mut degrees = vec![0.0; Feature::NodeDegree.n_bins()];
    for degree in geometry.node_degrees {
        let bin = (degree - 1).min(degrees.len() - 1);
        degrees[bin] += 1.0;
    }
    let mut angles = vec![0.0; Feature::BranchAngle.n_bins()];
    for angle in geometry.branch_angles_rad {
        count(&mut angles, angle / std::f64::consts::TAU, 1.0);
    }
    let all = [lengths, degrees, angles];
    Ok(all.iter().map(|counts| Counts::of(counts)).collect())
}

/// What is measured of one crack network.
///
/// Nodes at which a crack only bends (two segments) are no junctions, so that it does not matter in how
/// many pieces a crack was traced.
#[derive(Debug, Default)]
struct Geometry {
    /// Length of each branch along its bends, from an end or a junction to the next, in diagonals of
    /// the pane.
    branch_lengths: Vec<f64>,
    /// Number of branches at each end and junction.
    node_degrees: Vec<usize>,
    /// Angle between neighboring branches at each node where three or more meet, rad.
    branch_angles_rad: Vec<f64>,
}

/// A segment, as one leaves a node along it.
#[derive(Clone, Copy)]
struct Way {
    segment: usize,
    to: usize,
    length: f64,
}

impl Geometry {
    /// The geometry of a network, all of it in one unit, that of the diagonal.
    ///
    /// # Errors
    /// [`EvalError::NotComparable`] for a segment to a node that is not there, a place that is not
    /// finite, or a diagonal that is not above 0.
    fn of(nodes: &[[f64; 2]], segments: &[[usize; 2]], diagonal: f64) -> Result<Self, EvalError> {
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
        let mut ways: Vec<Vec<Way>> = vec![Vec::new(); nodes.len()];
        for (segment, &[from, to]) in segments.iter().enumerate() {
            let ([x0, y0], [x1, y1]) = (place(from)?, place(to)?);
            let length = libm::hypot(x1 - x0, y1 - y0);
            for (node, to) in [(from, to), (to, from)] {
                ways[node].push(Way {
                    segment,
                    to,
                    length,
                });
            }
        }
        let lengths = branch_lengths(&ways, segments.len()).into_iter();
        let mut geometry = Self {
            branch_lengths: lengths.map(|length| length / diagonal).collect(),
            ..Self::default()
        };
        for ([x, y], ways) in nodes.iter().zip(&ways).filter(|(_, ways)| is_stop(ways)) {
            geometry.node_degrees.push(ways.len());
            if ways.len() < 3 {
                continue;
            }
            let direction = |way: &Way| libm::atan2(nodes[way.to][1] - y, nodes[way.to][0] - x);
            let mut directions: Vec<f64> = ways.iter().map(direction).collect();
            directions.sort_by(f64::total_cmp);
            directions.push(directions[0] + std::f64::consts::TAU);
            let angles = directions.array_windows().map(|[a, b]| b - a);
            geometry.branch_angles_rad.extend(angles);
        }
        Ok(geometry)
    }
}

/// Whether branches end at a node of these ways.
fn is_stop(ways: &[Way]) -> bool {
    !ways.is_empty() && ways.len() != 2
}

/// Lengths of the stretches between ends and junctions, and of rings without any.
fn branch_lengths(ways: &[Vec<Way>], n_segments: usize) -> Vec<f64> {
    let mut is_walked = vec![false; n_segments];
    let mut lengths = Vec::new();
    // Rings have no end; they begin wherever they are met first.
    let stops = ways.iter().filter(|ways| is_stop(ways));
    let starts = stops.chain(ways.iter().filter(|ways| !is_stop(ways)));
    for first in starts.flatten() {
        let (mut length, mut next) = (0.0, Some(first));
        while let Some(way) = next.filter(|way| !is_walked[way.segment]) {
            is_walked[way.segment] = true;
            length += way.length;
            let onward = ways[way.to].iter().find(|on| on.segment != way.segment);
            next = onward.filter(|_| !is_stop(&ways[way.to]));
        }
        if length > 0.0 {
            lengths.push(length);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_star_of_three_arms_has_one_node_of_three_and_angles_that_close() {
        let nodes = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0], [-5.0, 0.0]];
        let star = Geometry::of(&nodes, &[[0, 1], [0, 2], [3, 0]], 10.0).unwrap();
        assert_eq!(star.branch_lengths, [0.3, 0.4, 0.5], "of a diagonal of 10");
        assert_eq!(star.node_degrees, [3, 1, 1, 1], "a middle and three ends");
        let angles = &star.branch_angles_rad;
        let sum: f64 = angles.iter().sum();
        assert!(
            (sum - std::f64::consts::TAU).abs() < 1e-12,
            "once around: {sum}"
        );
        assert_eq!(angles.len(), 3, "a right, a right and a straight angle");
    }

    #[test]
    fn a_bend_is_no_junction_and_a_ring_is_one_branch() {
        let nodes = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
        let bent = Geometry::of(&nodes, &[[0, 1], [1, 2]], 10.0).unwrap();
        assert_eq!(bent.branch_lengths, [0.7], "3 and 4");
        assert_eq!(bent.node_degrees, [1, 1], "its ends");
        let ring = Geometry::of(&nodes, &[[0, 1], [1, 2], [2, 0]], 10.0).unwrap();
        assert_eq!(ring.branch_lengths, [1.2], "3, 4 and 5");
        assert_eq!(ring.node_degrees, [0_usize; 0], "without an end");
    }

    #[test]
    fn a_segment_to_nowhere_is_refused() {
        let error = Geometry::of(&[[0.0, 0.0]], &[[0, 7]], 1.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "node 7 of 1 has no place; check the network file",
            "which"
        );
    }
}
