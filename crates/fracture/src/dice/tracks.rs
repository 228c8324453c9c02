//! What cracks have left behind so far: pieces of track, found by place.

use super::graph::Diced;
use crate::mesh::{Outline, to_u32};

/// A tip that meets a track this near to its end, as a fraction of the track, meets the end: no
/// die is smaller than a step.
const SNAP: f64 = 0.5;

const NONE: u32 = u32::MAX;

/// Straight pieces between nodes, in the squares of a grid.
pub(super) struct Tracks {
    nodes: Vec<[f64; 2]>,
    edges: Vec<[u32; 2]>,
    times_s: Vec<[f64; 2]>,
    /// First entry of each square.
    heads: Vec<u32>,
    /// (edge, next entry of the square).
    entries: Vec<(u32, u32)>,
    n_columns: usize,
    n_rows: usize,
    side_m: f64,
}

/// Where a step meets a track.
pub(super) struct Meeting {
    /// Fraction of the step.
    pub(super) fraction: f64,
    edge: u32,
    along: f64,
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates; squares are clamped"
)]
fn to_index(value: f64) -> usize {
    value as usize
}

impl Tracks {
    pub(super) fn new([width, height]: [f64; 2], step_m: f64) -> Self {
        // Never more squares than a million.
        let side_m = step_m
            .max((width * height).sqrt() * 1e-3)
            .max(width.max(height) * 1e-5);
        let (n_columns, n_rows) = (to_index(width / side_m) + 1, to_index(height / side_m) + 1);
        Self {
            nodes: Vec::new(),
            edges: Vec::new(),
            times_s: Vec::new(),
            heads: vec![NONE; n_columns * n_rows],
            entries: Vec::new(),
            n_columns,
            n_rows,
            side_m,
        }
    }

    pub(super) fn position(&self, node: u32) -> [f64; 2] {
        self.nodes[node as usize]
    }

    pub(super) fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    pub(super) fn add_node(&mut self, at: [f64; 2]) -> u32 {
        self.nodes.push(at);
        to_u32(self.nodes.len() - 1)
    }

    pub(super) fn add_track(&mut self, edge: [u32; 2], times_s: [f64; 2]) {
        self.edges.push(edge);
        self.times_s.push(times_s);
        self.register(to_u32(self.edges.len() - 1));
    }

    fn register(&mut self, edge: u32) {
        let [a, b] = self.edges[edge as usize].map(|node| self.position(node));
        for square in self.squares(a, b) {
            self.entries.push((edge, self.heads[square]));
            self.heads[square] = to_u32(self.entries.len() - 1);
        }
    }

    /// Squares that the box around a piece touches.
    fn squares(&self, a: [f64; 2], b: [f64; 2]) -> Vec<usize> {
        let range = |k: usize, n: usize| {
            let cell = |at: f64| to_index(at / self.side_m).min(n - 1);
            cell(a[k].min(b[k]))..cell(a[k].max(b[k])) + 1
        };
        let mut squares = Vec::with_capacity(4);
        for row in range(1, self.n_rows) {
            squares.extend(range(0, self.n_columns).map(|column| row * self.n_columns + column));
        }
        squares
    }

    /// Whether no track lies across the way from one node to the other.
    fn is_free(&self, node: u32, to: u32) -> bool {
        let end = self.position(to);
        let others = |ends: &[u32; 2]| !ends.contains(&to);
        self.meeting_where(node, end, others).is_none()
    }

    /// The first track that the way from a node to `end` meets; those that begin at the node do
    /// not count.
    pub(super) fn first_meeting(&self, node: u32, end: [f64; 2]) -> Option<Meeting> {
        self.meeting_where(node, end, |_| true)
    }

    fn meeting_where(
        &self,
        node: u32,
        end: [f64; 2],
        counts: impl Fn(&[u32; 2]) -> bool,
    ) -> Option<Meeting> {
        let from = self.position(node);
        let step = [end[0] - from[0], end[1] - from[1]];
        let mut first: Option<Meeting> = None;
        for square in self.squares(from, end) {
            let mut entry = self.heads[square];
            while entry != NONE {
                let (edge, next) = self.entries[entry as usize];
                entry = next;
                let ends = self.edges[edge as usize];
                if ends.contains(&node) || !counts(&ends) {
                    continue;
                }
                let [a, b] = ends.map(|node| self.position(node));
                let track = [b[0] - a[0], b[1] - a[1]];
                let gap = [a[0] - from[0], a[1] - from[1]];
                let cross = step[0] * track[1] - step[1] * track[0];
                let fraction = (gap[0] * track[1] - gap[1] * track[0]) / cross;
                let along = (gap[0] * step[1] - gap[1] * step[0]) / cross;
                // A little beyond the step and past the ends, so that nothing slips through or
                // ends a hair short.
                let is_met =
                    (0.0..=1.1).contains(&fraction) && (-1e-9..=1.0 + 1e-9).contains(&along);
                let is_first = first
                    .as_ref()
                    .is_none_or(|m| (fraction, edge) < (m.fraction, m.edge));
                if is_met && is_first {
                    first = Some(Meeting {
                        fraction,
                        edge,
                        along,
                    });
                }
            }
        }
        first
    }

    /// The node at a meeting of the way from `node`: the nearer end of the track if it is near and
    /// nothing lies before it, or a new one that divides the track.
    pub(super) fn node_at(&mut self, node: u32, meeting: &Meeting) -> u32 {
        let edge = meeting.edge as usize;
        let [a, b] = self.edges[edge];
        let nearer = if meeting.along < 0.5 { a } else { b };
        let off = meeting.along.min(1.0 - meeting.along);
        if off <= 1e-9 || (off < SNAP && self.is_free(node, nearer)) {
            return nearer;
        }
        let (p, q) = (self.position(a), self.position(b));
        let t = meeting.along;
        let middle = self.add_node([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        let [start, end] = self.times_s[edge];
        let passed = start + t * (end - start);
        // The old entries still find the first part; the second part gets its own.
        self.edges[edge] = [a, middle];
        self.times_s[edge] = [start, passed];
        self.add_track([middle, b], [passed, end]);
        middle
    }

    /// Whether a track already leads from one to the other.
    pub(super) fn are_joined(&self, a: u32, b: u32) -> bool {
        let at = self.position(a);
        self.squares(at, at).into_iter().any(|square| {
            let mut entry = self.heads[square];
            while entry != NONE {
                let (edge, next) = self.entries[entry as usize];
                let ends = self.edges[edge as usize];
                if ends == [a, b] || ends == [b, a] {
                    return true;
                }
                entry = next;
            }
            false
        })
    }

    /// All of it as a graph, with its dice counted by Euler's formula.
    pub(super) fn into_dice(self, outline: &Outline) -> Diced {
        let mut parent: Vec<u32> = (0..to_u32(self.nodes.len())).collect();
        let root = |parent: &mut Vec<u32>, mut node: u32| {
            while parent[node as usize] != node {
                parent[node as usize] = parent[parent[node as usize] as usize];
                node = parent[node as usize];
            }
            node
        };
        let mut n_parts = self.nodes.len() + 1;
        let rim = to_u32(parent.len());
        parent.push(rim);
        let mut join = |a: u32, b: u32| {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            if a != b {
                parent[a as usize] = b;
                n_parts -= 1;
            }
        };
        for &[a, b] in &self.edges {
            join(a, b);
        }
        let mut n_rim = 0;
        for (node, &at) in (0_u32..).zip(&self.nodes) {
            if outline.depth_m(at) < 1e-12 {
                join(node, rim);
                n_rim += 1;
            }
        }
        // V − E + F = C for inner faces. The rim is a polygon with as many edges as nodes; where no
        // crack reaches it, it is a part of its own with one face, all around the cracks.
        let n_cells = self.edges.len() + n_rim + n_parts - self.nodes.len();
        Diced {
            nodes: self.nodes,
            edges: self.edges,
            times_s: self.times_s,
            n_cells,
        }
    }
}
