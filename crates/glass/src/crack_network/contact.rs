//! Where segments meet without a common node. Exact: decided by adaptive orientation
//! predicates [Shewchuk1997], so that neither a crossing nor a touch is ever missed.

use std::cmp::Ordering;

use robust::{Coord, orient2d};

use super::Nodes;
use super::strips::{InStrip, Strips};

/// In which way two segments meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ContactKind {
    /// Their interiors cross in one point.
    Cross,
    /// This node, an end of one, lies in the interior of the other.
    NodeOnSegment(u32),
    /// They lie on one line and share more than a point.
    Overlap,
    /// Two different nodes, one of each, at the same place.
    TwinNodes(u32, u32),
}

impl ContactKind {
    pub(super) fn description(self) -> &'static str {
        match self {
            Self::Cross => "cross without a node",
            Self::NodeOnSegment(_) => "touch where only one of them has a node",
            Self::Overlap => "lie on top of each other",
            Self::TwinNodes(..) => "end at one place in two different nodes",
        }
    }
}

/// Two segments that meet otherwise than at a common node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contact {
    /// The segment with the lower index.
    pub first: u32,
    /// The other one.
    pub second: u32,
    /// How they meet.
    pub kind: ContactKind,
}

/// All pairs of segments that meet otherwise than at a node that both have, in ascending
/// order, each once. Segments of zero length are passed over.
///
/// Strips of about the height of a segment, swept in x: O(n log n + pairs of boxes that
/// overlap).
///
/// # Panics
/// If an index of `from` or `to` is not a node.
#[must_use]
pub fn find_contacts(nodes: &Nodes, from: &[u32], to: &[u32]) -> Vec<Contact> {
    search(nodes, from, to, usize::MAX).unwrap_or_default()
}

/// Pairs whose boxes overlap, over contacts: so many are looked at before a search gives up.
const PAIRS_PER_CONTACT: usize = 64;

/// As [`find_contacts`], for lines from outside: none where there are more contacts than
/// `max_contacts`, or more than 64 times as many pairs to look at, so that neither time nor
/// memory runs away.
///
/// # Panics
/// If an index of `from` or `to` is not a node.
#[must_use]
pub fn find_contacts_up_to(
    nodes: &Nodes,
    from: &[u32],
    to: &[u32],
    max_contacts: usize,
) -> Option<Vec<Contact>> {
    search(nodes, from, to, max_contacts)
}

fn search(nodes: &Nodes, from: &[u32], to: &[u32], max_contacts: usize) -> Option<Vec<Contact>> {
    let mut pairs_left = max_contacts.saturating_mul(PAIRS_PER_CONTACT);
    let n = from.len().min(to.len());
    let point = |node: u32| Coord {
        x: nodes.x[node as usize],
        y: nodes.y[node as usize],
    };
    let ends: Vec<(Coord<f64>, Coord<f64>)> =
        (0..n).map(|i| (point(from[i]), point(to[i]))).collect();
    let strips = Strips::new(&ends);
    let mut contacts = overlaps_at_nodes(nodes, &from[..n], &to[..n], max_contacts)?;
    let mut swept: Vec<InStrip> = Vec::new();
    for strip in 0..strips.count() {
        swept.clear();
        swept.extend(strips.members(strip).iter().map(|&i| {
            strips.clip(
                strip,
                i,
                &ends[i as usize],
                [from[i as usize], to[i as usize]],
            )
        }));
        swept.sort_unstable_by(|a, b| a.x_min.total_cmp(&b.x_min).then(a.segment.cmp(&b.segment)));
        for (k, one) in swept.iter().enumerate() {
            for other in &swept[k + 1..] {
                if other.x_min > one.x_max {
                    break;
                }
                pairs_left = pairs_left.checked_sub(1)?;
                if one.y_min > other.y_max || other.y_min > one.y_max || one.shares_node(other) {
                    continue;
                }
                let (i, j) = (
                    one.segment.min(other.segment),
                    one.segment.max(other.segment),
                );
                let (a, b) = (
                    (from[i as usize], to[i as usize]),
                    (from[j as usize], to[j as usize]),
                );
                contact(&ends[i as usize], &ends[j as usize], a, b, |kind| {
                    contacts.push(Contact {
                        first: i,
                        second: j,
                        kind,
                    });
                });
                if contacts.len() > max_contacts {
                    return None;
                }
            }
        }
    }
    contacts.sort_unstable();
    contacts.dedup();
    Some(contacts)
}

/// As [`find_contacts`], for the pairs of which at least one is among the `suspects`: each of
/// them against all, so for few suspects much faster than a full search.
///
/// # Panics
/// If a suspect is not a segment, or an index of `from` or `to` is not a node.
#[must_use]
pub fn find_contacts_of(nodes: &Nodes, from: &[u32], to: &[u32], suspects: &[u32]) -> Vec<Contact> {
    let point = |node: u32| Coord {
        x: nodes.x[node as usize],
        y: nodes.y[node as usize],
    };
    let ends = |segment: u32| {
        let (a, b) = (from[segment as usize], to[segment as usize]);
        ((a, b), (point(a), point(b)))
    };
    let apart = |a: f64, b: f64, c: f64, d: f64| a.max(b) < c.min(d) || c.max(d) < a.min(b);
    let mut contacts = Vec::new();
    for &suspect in suspects {
        let ((node_a, node_b), (a, b)) = ends(suspect);
        for (other, _) in (0_u32..).zip(from) {
            let ((node_c, node_d), (c, d)) = ends(other);
            if other == suspect || apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y) {
                continue;
            }
            let (first, second) = (suspect.min(other), suspect.max(other));
            let mut report = |kind| {
                contacts.push(Contact {
                    first,
                    second,
                    kind,
                })
            };
            let common = [
                (node_a, node_c, a, b, d),
                (node_a, node_d, a, b, c),
                (node_b, node_c, b, a, d),
                (node_b, node_d, b, a, c),
            ];
            match common
                .into_iter()
                .find(|(node, other_node, ..)| node == other_node)
            {
                Some((_, _, center, p, q)) => {
                    if orient2d(center, p, q) == 0.0 && overlap(&a, &b, &c, &d) {
                        report(ContactKind::Overlap);
                    }
                }
                None => contact(&(a, b), &(c, d), (node_a, node_b), (node_c, node_d), report),
            }
        }
    }
    contacts.sort_unstable();
    contacts.dedup();
    contacts
}

/// Segments with a common node that leave it in the same direction: the only way in which such
/// two meet again. Found by sorting the segments around each node, so that a star of many arms
/// costs no more than its sorting.
fn overlaps_at_nodes(
    nodes: &Nodes,
    from: &[u32],
    to: &[u32],
    max_contacts: usize,
) -> Option<Vec<Contact>> {
    let mut starts = vec![0_u32; nodes.x.len() + 1];
    for &node in from.iter().chain(to) {
        starts[node as usize + 1] += 1;
    }
    for node in 0..nodes.x.len() {
        starts[node + 1] += starts[node];
    }
    // (other end, segment) around each node.
    let mut around = vec![(0_u32, 0_u32); 2 * from.len()];
    let mut next = starts.clone();
    for (segment, (&a, &b)) in (0_u32..).zip(from.iter().zip(to)) {
        for (node, other) in [(a, b), (b, a)] {
            let slot = &mut next[node as usize];
            around[*slot as usize] = (other, segment);
            *slot += 1;
        }
    }
    let point = |node: u32| Coord {
        x: nodes.x[node as usize],
        y: nodes.y[node as usize],
    };
    let mut contacts = Vec::new();
    for node in 0..nodes.x.len() {
        let spokes = &mut around[starts[node] as usize..starts[node + 1] as usize];
        if spokes.len() > 1 {
            overlapping_spokes(
                Coord {
                    x: nodes.x[node],
                    y: nodes.y[node],
                },
                spokes,
                point,
                &mut contacts,
                max_contacts,
            )?;
        }
    }
    Some(contacts)
}

/// Pairs of segments around one node that leave it in the same direction; none if they are more
/// than `max_contacts` in all.
fn overlapping_spokes(
    center: Coord<f64>,
    spokes: &mut [(u32, u32)],
    point: impl Fn(u32) -> Coord<f64>,
    contacts: &mut Vec<Contact>,
    max_contacts: usize,
) -> Option<()> {
    #[expect(
        clippy::float_cmp,
        reason = "half planes are exact, their border included"
    )]
    let lower = |p: Coord<f64>| p.y < center.y || (p.y == center.y && p.x < center.x);
    // Exact predicates within half a turn make this a total order.
    let direction = |p: Coord<f64>, q: Coord<f64>| {
        let turn = 0.0
            .partial_cmp(&orient2d(center, p, q))
            .unwrap_or(Ordering::Equal);
        lower(p).cmp(&lower(q)).then(turn)
    };
    spokes.sort_unstable_by(|a, b| direction(point(a.0), point(b.0)).then(a.1.cmp(&b.1)));
    let mut rest = &*spokes;
    while let Some((&(other, _), _)) = rest.split_first() {
        let same = rest
            .iter()
            .take_while(|spoke| direction(point(other), point(spoke.0)).is_eq())
            .count();
        let (group, after) = rest.split_at(same.max(1));
        for (k, &(end, one)) in group.iter().enumerate() {
            for &(other_end, two) in &group[k + 1..] {
                // Segments of zero length have no direction and meet nothing.
                if point(end) != center && point(other_end) != center {
                    contacts.push(Contact {
                        first: one.min(two),
                        second: one.max(two),
                        kind: ContactKind::Overlap,
                    });
                }
                if contacts.len() > max_contacts {
                    return None;
                }
            }
        }
        rest = after;
    }
    Some(())
}

/// Reports how two segments without a common node meet.
fn contact(
    (a, b): &(Coord<f64>, Coord<f64>),
    (c, d): &(Coord<f64>, Coord<f64>),
    (node_a, node_b): (u32, u32),
    (node_c, node_d): (u32, u32),
    mut report: impl FnMut(ContactKind),
) {
    if a == b || c == d {
        return;
    }
    let (c_side, d_side) = (orient2d(*a, *b, *c), orient2d(*a, *b, *d));
    if c_side != 0.0 && d_side != 0.0 && (c_side > 0.0) == (d_side > 0.0) {
        return;
    }
    let (a_side, b_side) = (orient2d(*c, *d, *a), orient2d(*c, *d, *b));
    if c_side == 0.0 && d_side == 0.0 {
        if overlap(a, b, c, d) {
            report(ContactKind::Overlap);
        } else {
            for (node, p) in [(node_a, a), (node_b, b)] {
                for (other, q) in [(node_c, c), (node_d, d)] {
                    if node != other && p == q {
                        report(ContactKind::TwinNodes(node.min(other), node.max(other)));
                    }
                }
            }
        }
        return;
    }
    let opposite = |p: f64, q: f64| (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0);
    if opposite(c_side, d_side) && opposite(a_side, b_side) {
        report(ContactKind::Cross);
        return;
    }
    for (side, node, p) in [(c_side, node_c, c), (d_side, node_d, d)] {
        if side == 0.0 {
            touch(p, node, (a, node_a), (b, node_b), &mut report);
        }
    }
    for (side, node, p) in [(a_side, node_a, a), (b_side, node_b, b)] {
        if side == 0.0 {
            touch(p, node, (c, node_c), (d, node_d), &mut report);
        }
    }
}

/// Reports node `p`, known to lie on the line through `a` and `b`, if it lies on the segment
/// and is not one of its nodes.
fn touch(
    p: &Coord<f64>,
    node: u32,
    (a, node_a): (&Coord<f64>, u32),
    (b, node_b): (&Coord<f64>, u32),
    report: &mut impl FnMut(ContactKind),
) {
    if p == a || p == b {
        let end = if p == a { node_a } else { node_b };
        if node != end {
            report(ContactKind::TwinNodes(node.min(end), node.max(end)));
        }
    } else if between(p, a, b) {
        report(ContactKind::NodeOnSegment(node));
    }
}

/// Whether `p`, on the line through `a` and `b`, lies strictly between them.
fn between(p: &Coord<f64>, a: &Coord<f64>, b: &Coord<f64>) -> bool {
    if (a.x - b.x).abs() >= (a.y - b.y).abs() {
        p.x > a.x.min(b.x) && p.x < a.x.max(b.x)
    } else {
        p.y > a.y.min(b.y) && p.y < a.y.max(b.y)
    }
}

/// Whether two segments on one line share more than a point.
fn overlap(a: &Coord<f64>, b: &Coord<f64>, c: &Coord<f64>, d: &Coord<f64>) -> bool {
    let pick = |p: &Coord<f64>| {
        if (a.x - b.x).abs() >= (a.y - b.y).abs() {
            p.x
        } else {
            p.y
        }
    };
    let (low, high) = (pick(a).min(pick(b)), pick(a).max(pick(b)));
    let (other_low, other_high) = (pick(c).min(pick(d)), pick(c).max(pick(d)));
    low.max(other_low) < high.min(other_high)
}
