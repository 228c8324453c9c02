//! A planar graph to a history: which segment grew out of which, and when it arrived.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use starbreak_glass::{Nodes, Segments};

use crate::arrangement::{Arranged, Stroke};
use crate::mesh::to_u32;

/// A node that cracks have reached; the earliest is taken up first, of equals the lower node.
type Reached = Reverse<(u64, u32)>;

/// Orders strokes by the time at which a crack that starts at the impacts reaches them.
///
/// A segment arrives at its own time, or when the crack reaches its start, whichever is later;
/// so no segment arrives before its parent. Parts that no crack from an impact reaches start
/// by themselves, at the node with the earliest time. Segments come out in order of arrival.
pub(crate) fn grow(arranged: Arranged, impacts: &[[f64; 2]]) -> (Nodes, Segments) {
    let Arranged { nodes, strokes } = arranged;
    let incident = Incident::new(nodes.x.len(), &strokes);
    let mut reach = vec![f64::INFINITY; nodes.x.len()];
    let mut reached_by: Vec<Option<u32>> = vec![None; nodes.x.len()];
    let mut taken = vec![false; strokes.len()];
    // (arrival, stroke, from, parent stroke)
    let mut grown: Vec<(f64, u32, u32, Option<u32>)> = Vec::with_capacity(strokes.len());

    let mut heap: BinaryHeap<Reached> = BinaryHeap::new();
    let mut done = vec![false; nodes.x.len()];
    for (node, (&x, &y)) in (0_u32..).zip(nodes.x.iter().zip(&nodes.y)) {
        #[expect(
            clippy::float_cmp,
            reason = "an impact is a node when it is the very same point"
        )]
        if impacts
            .iter()
            .any(|&[impact_x, impact_y]| impact_x == x && impact_y == y)
        {
            reach[node as usize] = 0.0;
            heap.push(Reverse((0.0_f64.to_bits(), node)));
        }
    }
    let mut starts = incident.earliest(&strokes);
    starts.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
    loop {
        let Some(Reverse((_, node))) = heap.pop() else {
            // Everything that the impacts reach is done; go on where stress came first.
            let Some((time, node)) = starts.pop() else {
                break;
            };
            if !done[node as usize] {
                reach[node as usize] = time;
                heap.push(Reverse((time.to_bits(), node)));
            }
            continue;
        };
        if std::mem::replace(&mut done[node as usize], true) {
            continue;
        }
        let here = reach[node as usize];
        for &idx in incident.of(node) {
            if std::mem::replace(&mut taken[idx as usize], true) {
                continue;
            }
            let stroke = &strokes[idx as usize];
            let other = if stroke.a == node { stroke.b } else { stroke.a };
            let arrival = here.max(stroke.arrival[0]).max(stroke.arrival[1]);
            grown.push((arrival, idx, node, reached_by[node as usize]));
            if arrival < reach[other as usize] {
                reach[other as usize] = arrival;
                reached_by[other as usize] = Some(idx);
                heap.push(Reverse((arrival.to_bits(), other)));
            }
        }
    }
    (nodes, columns(grown, &strokes))
}

/// Columns in order of arrival; a parent always stands before its children.
fn columns(mut grown: Vec<(f64, u32, u32, Option<u32>)>, strokes: &[Stroke]) -> Segments {
    // Stable: segments that arrive together stay in the order in which they were reached.
    grown.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut place = vec![0_u32; strokes.len()];
    for (position, (_, idx, ..)) in (0_u32..).zip(&grown) {
        place[*idx as usize] = position;
    }
    let mut segments = Segments::default();
    let (mut parents, mut arrivals, mut stresses) = (Vec::new(), Vec::new(), Vec::new());
    for (arrival, idx, from, parent) in grown {
        let stroke = &strokes[idx as usize];
        let (to, stress) = if stroke.a == from {
            (stroke.b, stroke.stress[1])
        } else {
            (stroke.a, stroke.stress[0])
        };
        segments.from.push(from);
        segments.to.push(to);
        segments.kind.push(stroke.kind);
        parents.push(parent.map(|idx| place[idx as usize]));
        arrivals.push(arrival);
        stresses.push(stress);
    }
    segments.parent = Some(parents);
    segments.arrival_step = Some(arrivals);
    segments.stress_paper_units = Some(stresses);
    segments
}

/// Strokes at each node, in ascending order.
struct Incident {
    starts: Vec<u32>,
    strokes: Vec<u32>,
}

impl Incident {
    fn new(n_nodes: usize, strokes: &[Stroke]) -> Self {
        let mut starts = vec![0_u32; n_nodes + 1];
        for node in strokes.iter().flat_map(|stroke| [stroke.a, stroke.b]) {
            starts[node as usize + 1] += 1;
        }
        for node in 0..n_nodes {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut at = vec![0_u32; 2 * strokes.len()];
        for (idx, stroke) in (0..to_u32(strokes.len())).zip(strokes) {
            for node in [stroke.a, stroke.b] {
                let slot = &mut next[node as usize];
                at[*slot as usize] = idx;
                *slot += 1;
            }
        }
        Self {
            starts,
            strokes: at,
        }
    }

    fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.strokes[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// The earliest time of any stroke at each node.
    fn earliest(&self, strokes: &[Stroke]) -> Vec<(f64, u32)> {
        (0..to_u32(self.starts.len() - 1))
            .map(|node| {
                let times = self.of(node).iter().map(|&idx| {
                    let stroke = &strokes[idx as usize];
                    if stroke.a == node {
                        stroke.arrival[0]
                    } else {
                        stroke.arrival[1]
                    }
                });
                (times.fold(f64::INFINITY, f64::min), node)
            })
            .collect()
    }
}
