//! Key figures of a network.

use serde::{Deserialize, Serialize};

use super::fragments::Faces;
use super::{Model, NetworkData, SegmentKind};

/// Key figures of a network. All but the energies are computed from its columns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Cracks that leave an impact: `propagated` and `radial` segments that start at one.
    pub n_radial: usize,
    /// Segments in all.
    pub n_segments: usize,
    /// Sum of the segments' lengths, in the network's length unit.
    pub total_length: f64,
    /// Greatest length from where a crack starts (a segment without parent) to where a crack
    /// ends, along parents, forks included, in the network's length unit. Absent without
    /// parents, and for the paper's model, whose hops and tree edges are not cracks that run on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_crack: Option<f64>,
    /// Pieces that the pane is in, 1 if none came off: the number of
    /// [`CrackNetwork::fragments`](super::CrackNetwork::fragments). Absent for the paper's model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_fragments: Option<usize>,
    /// Energy that went into new surface, J, where the model knows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dissipated_j: Option<f64>,
    /// Energy that was there to break the glass, J, where the model knows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub available_j: Option<f64>,
}

/// Key figures of a network whose columns are in order.
pub(super) fn summarize(data: &NetworkData) -> Summary {
    let is_impact = |node: u32| {
        let (x, y) = (data.nodes.x[node as usize], data.nodes.y[node as usize]);
        #[expect(
            clippy::float_cmp,
            reason = "an impact is a node when it is the very same point"
        )]
        data.impacts
            .iter()
            .any(|impact| impact.x == x && impact.y == y)
    };
    let segments = &data.segments;
    let mut n_radial = 0;
    let mut total_length = 0.0;
    for (idx, (&from, kind)) in segments.from.iter().zip(&segments.kind).enumerate() {
        total_length += segment_length(data, idx);
        if matches!(kind, SegmentKind::Propagated | SegmentKind::Radial) && is_impact(from) {
            n_radial += 1;
        }
    }
    let is_paper = data.model == Model::Paper;
    let given = data.summary.unwrap_or_default();
    Summary {
        n_radial,
        n_segments: segments.from.len(),
        total_length,
        longest_crack: if is_paper { None } else { longest_crack(data) },
        n_fragments: (!is_paper).then(|| Faces::of(data).n_fragments()),
        dissipated_j: given.dissipated_j,
        available_j: given.available_j,
    }
}

/// The longest chain of parents.
fn longest_crack(data: &NetworkData) -> Option<f64> {
    let segments = &data.segments;
    let parents = segments.parent.as_ref()?;
    // Length from the start of the crack to the end of each segment, NaN where not yet known.
    let mut reach = vec![f64::NAN; parents.len()];
    let mut chain = Vec::new();
    let mut longest = 0.0_f64;
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(segment) = at.filter(|&segment| reach[segment].is_nan()) {
            chain.push(segment);
            at = parents[segment].map(|parent| parent as usize);
        }
        let mut length = at.map_or(0.0, |segment| reach[segment]);
        while let Some(segment) = chain.pop() {
            length += segment_length(data, segment);
            reach[segment] = length;
        }
        longest = longest.max(length);
    }
    Some(longest)
}

fn segment_length(data: &NetworkData, segment: usize) -> f64 {
    let (a, b) = (
        data.segments.from[segment] as usize,
        data.segments.to[segment] as usize,
    );
    let (dx, dy) = (
        data.nodes.x[b] - data.nodes.x[a],
        data.nodes.y[b] - data.nodes.y[a],
    );
    (dx * dx + dy * dy).sqrt()
}
