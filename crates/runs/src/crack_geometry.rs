//! A crack network as plain numbers for evaluation, which knows no networks.

use starbreak_eval::EvalError;
use starbreak_eval::divergence::CrackGeometry;
use starbreak_glass::CrackNetwork;

/// Lengths, degrees and angles of a network, in diagonals of its pane.
///
/// # Errors
/// As for [`CrackGeometry::of_network`]; a network that passed its own checks has none.
pub fn crack_geometry(network: &CrackNetwork) -> Result<CrackGeometry, EvalError> {
    let data = network.data();
    let nodes: Vec<[f64; 2]> = data
        .nodes
        .x
        .iter()
        .zip(&data.nodes.y)
        .map(|(x, y)| [*x, *y])
        .collect();
    let place = |node: &u32| usize::try_from(*node).unwrap_or(usize::MAX);
    let ends = data.segments.from.iter().zip(&data.segments.to);
    let segments: Vec<[usize; 2]> = ends.map(|(from, to)| [place(from), place(to)]).collect();
    let diagonal = libm::hypot(data.pane.width, data.pane.height);
    CrackGeometry::of_network(&nodes, &segments, diagonal)
}
