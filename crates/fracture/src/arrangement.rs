//! Strokes to a planar graph: wherever two meet, they get a node that both have.

use std::collections::HashMap;

use starbreak_glass::{
    ContactKind, Nodes, Pane, SegmentKind, find_contacts_of, find_contacts_up_to,
};

use crate::lattice::Lattice;
use crate::mesh::to_u32;

/// Most contacts that are sorted out, in some seconds; five times what the paper's particles give on
/// a frame that is smaller than their radius, and far above any picture's needs.
pub(crate) const MAX_CONTACTS: usize = 1_000_000;

/// A search that would find so many, or so many pairs that may meet, is given up on the way; long
/// strokes come near each other more often than they meet.
const MAX_FOUND: usize = 8 * MAX_CONTACTS;

/// Up to this many strokes are looked at one by one.
const FEW: usize = 64;

/// Rounds of splitting before the later of two strokes that still meet is given up.
const MAX_ROUNDS: usize = 16;

/// A straight piece of crack between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    /// Start node.
    pub(crate) a: u32,
    /// End node.
    pub(crate) b: u32,
    /// What it is.
    pub(crate) kind: SegmentKind,
    /// Times at which the tip leaves `a` and reaches `b`.
    pub(crate) arrival: [f64; 2],
    /// Stress at `a` and at `b`.
    pub(crate) stress: [f64; 2],
    /// Whether it may meet another where neither has a node: true until it has been looked at
    /// and found to meet nothing.
    pub(crate) is_suspect: bool,
    /// What it was cut from, in the numbering of whoever made it.
    pub(crate) source: u32,
}

/// Nodes and strokes that meet only at nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Arranged {
    pub(crate) nodes: Nodes,
    pub(crate) strokes: Vec<Stroke>,
}

/// Splits strokes where they meet. New nodes are rounded to the pane's lattice, which bends a
/// stroke by less than a lattice step; the splitting is repeated until nothing meets any more.
/// Of two strokes between the same nodes the one of the lower kind, then the earlier, stays.
///
/// There are `n_nodes` places for nodes, at `position`; few of them may be used.
///
/// # Errors
/// [`MAX_CONTACTS`] if the strokes meet more often than that.
pub(crate) fn arrange(
    pane: &Pane,
    n_nodes: usize,
    position: impl Fn(u32) -> [f64; 2],
    strokes: Vec<Stroke>,
) -> Result<Arranged, usize> {
    let (mut nodes, mut strokes) = keep_used(n_nodes, position, strokes);
    remove_duplicates(&mut strokes);
    let mut places = Places::new(pane, &nodes);
    for round in 0.. {
        let from: Vec<u32> = strokes.iter().map(|stroke| stroke.a).collect();
        let to: Vec<u32> = strokes.iter().map(|stroke| stroke.b).collect();
        let suspects: Vec<u32> = (0..to_u32(strokes.len()))
            .filter(|&idx| strokes[idx as usize].is_suspect)
            .collect();
        let contacts = if suspects.len() > FEW {
            find_contacts_up_to(&nodes, &from, &to, MAX_FOUND).ok_or(MAX_CONTACTS)?
        } else {
            find_contacts_of(&nodes, &from, &to, &suspects)
        };
        if contacts.is_empty() {
            break;
        }
        if contacts.len() > MAX_CONTACTS {
            return Err(MAX_CONTACTS);
        }
        if round >= MAX_ROUNDS {
            // Rounding keeps moving these: the later crack ends at the earlier one.
            let mut given_up: Vec<u32> = contacts.iter().map(|contact| contact.second).collect();
            given_up.sort_unstable();
            given_up.dedup();
            for idx in given_up.into_iter().rev() {
                strokes.remove(idx as usize);
            }
            continue;
        }
        let mut cuts: Vec<(u32, u32)> = Vec::new();
        for contact in &contacts {
            let (i, j) = (
                strokes[contact.first as usize],
                strokes[contact.second as usize],
            );
            match contact.kind {
                ContactKind::Cross => {
                    let place = crossing(&nodes, &i, &j);
                    let node = places.node_at(&mut nodes, place);
                    cuts.extend([(contact.first, node), (contact.second, node)]);
                }
                ContactKind::NodeOnSegment(node) => {
                    // The end of one lies inside the other; cutting at an end is harmless.
                    cuts.extend([(contact.first, node), (contact.second, node)]);
                }
                ContactKind::Overlap => {
                    cuts.extend([i.a, i.b].map(|node| (contact.second, node)));
                    cuts.extend([j.a, j.b].map(|node| (contact.first, node)));
                }
                // Places are unique per node, so this cannot come about.
                ContactKind::TwinNodes(..) => {}
            }
        }
        strokes = cut(&nodes, &strokes, cuts);
        remove_duplicates(&mut strokes);
    }
    Ok(Arranged { nodes, strokes })
}

/// Only the nodes that some stroke uses, renumbered in their old order.
fn keep_used(
    n_nodes: usize,
    position: impl Fn(u32) -> [f64; 2],
    mut strokes: Vec<Stroke>,
) -> (Nodes, Vec<Stroke>) {
    let mut new_id = vec![0; n_nodes];
    for stroke in &strokes {
        new_id[stroke.a as usize] = 1;
        new_id[stroke.b as usize] = 1;
    }
    let mut nodes = Nodes::default();
    for (node, id) in (0_u32..).zip(&mut new_id) {
        if *id == 1 {
            let [x, y] = position(node);
            *id = to_u32(nodes.x.len());
            nodes.x.push(x);
            nodes.y.push(y);
        }
    }
    for stroke in &mut strokes {
        stroke.a = new_id[stroke.a as usize];
        stroke.b = new_id[stroke.b as usize];
    }
    (nodes, strokes)
}

/// Looks nodes up by their place. Never iterated, so its order does not matter.
struct Places {
    lattice: Lattice,
    pane: Pane,
    by_place: HashMap<[u64; 2], u32>,
}

impl Places {
    fn new(pane: &Pane, nodes: &Nodes) -> Self {
        let by_place = (0_u32..)
            .zip(nodes.x.iter().zip(&nodes.y))
            .map(|(node, (x, y))| ([x.to_bits(), y.to_bits()], node))
            .collect();
        Self {
            lattice: Lattice::of_pane(pane),
            pane: *pane,
            by_place,
        }
    }

    /// The node at the lattice place nearest to a point, a new one if there is none.
    fn node_at(&mut self, nodes: &mut Nodes, [x, y]: [f64; 2]) -> u32 {
        // `+ 0.0` makes a negative zero positive.
        let x = self.lattice.round(x).clamp(0.0, self.pane.width) + 0.0;
        let y = self.lattice.round(y).clamp(0.0, self.pane.height) + 0.0;
        *self
            .by_place
            .entry([x.to_bits(), y.to_bits()])
            .or_insert_with(|| {
                nodes.x.push(x);
                nodes.y.push(y);
                to_u32(nodes.x.len() - 1)
            })
    }
}

/// Where two strokes that are known to cross do so.
fn crossing(nodes: &Nodes, i: &Stroke, j: &Stroke) -> [f64; 2] {
    let at = |node: u32| [nodes.x[node as usize], nodes.y[node as usize]];
    let ([ax, ay], [bx, by], [cx, cy], [dx, dy]) = (at(i.a), at(i.b), at(j.a), at(j.b));
    let side = |px: f64, py: f64| (dx - cx) * (py - cy) - (dy - cy) * (px - cx);
    let (from, to) = (side(ax, ay), side(bx, by));
    let t = (from / (from - to)).clamp(0.0, 1.0);
    [ax + (bx - ax) * t, ay + (by - ay) * t]
}

/// Cuts strokes at nodes: `(stroke, node)` pairs, in any order and any number.
pub(crate) fn cut(nodes: &Nodes, strokes: &[Stroke], mut cuts: Vec<(u32, u32)>) -> Vec<Stroke> {
    cuts.sort_unstable();
    cuts.dedup();
    let mut pieces = Vec::with_capacity(strokes.len() + cuts.len());
    let mut rest = cuts.as_slice();
    let mut stops: Vec<(f64, u32)> = Vec::new();
    for (idx, stroke) in (0_u32..).zip(strokes) {
        let n = rest
            .iter()
            .take_while(|(cut_idx, _)| *cut_idx == idx)
            .count();
        let (own, others) = rest.split_at(n);
        rest = others;
        if own.is_empty() {
            pieces.push(Stroke {
                is_suspect: false,
                ..*stroke
            });
            continue;
        }
        let (a, b) = (stroke.a as usize, stroke.b as usize);
        let (dx, dy) = (nodes.x[b] - nodes.x[a], nodes.y[b] - nodes.y[a]);
        let length2 = dx * dx + dy * dy;
        stops.clear();
        for &(_, node) in own {
            let (x, y) = (nodes.x[node as usize], nodes.y[node as usize]);
            let t = ((x - nodes.x[a]) * dx + (y - nodes.y[a]) * dy) / length2;
            // A node beyond an end belongs to an overlap, not to this stroke.
            if t > 0.0 && t < 1.0 && node != stroke.a && node != stroke.b {
                stops.push((t, node));
            }
        }
        stops.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let mut last = (0.0, stroke.a);
        for &(t, node) in stops.iter().chain(std::iter::once(&(1.0, stroke.b))) {
            pieces.push(Stroke {
                a: last.1,
                b: node,
                kind: stroke.kind,
                arrival: [between(stroke.arrival, last.0), between(stroke.arrival, t)],
                stress: [between(stroke.stress, last.0), between(stroke.stress, t)],
                is_suspect: true,
                source: stroke.source,
            });
            last = (t, node);
        }
    }
    pieces
}

fn between([from, to]: [f64; 2], t: f64) -> f64 {
    if t >= 1.0 { to } else { from + (to - from) * t }
}

/// Keeps one stroke per pair of nodes, and none from a node to itself.
pub(crate) fn remove_duplicates(strokes: &mut Vec<Stroke>) {
    let pair = |a: u32, b: u32| (u64::from(a.min(b)) << 32) | u64::from(a.max(b));
    let mut order: Vec<(u64, SegmentKind, u64, u32)> = (0_u32..)
        .zip(strokes.iter())
        .filter(|(_, stroke)| stroke.a != stroke.b)
        .map(|(idx, stroke)| {
            let arrival = stroke.arrival[1].to_bits();
            (pair(stroke.a, stroke.b), stroke.kind, arrival, idx)
        })
        .collect();
    order.sort_unstable();
    order.dedup_by_key(|(pair, ..)| *pair);
    let mut keep = vec![false; strokes.len()];
    for (.., idx) in order {
        keep[idx as usize] = true;
    }
    let mut flags = keep.into_iter();
    strokes.retain(|_| flags.next().unwrap_or(false));
}
