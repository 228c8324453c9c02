//! Cracks as chains of nodes and edges of a plate's mesh.

use super::grading::{Domain, Grading};
use super::particles::to_u32;
use super::rim::{BorderNode, move_nearest};

/// Distance over the local size below which ends and junctions are one node.
const SAME: f64 = 0.4;

/// Least distance over the local size from one node of a crack to another.
const APART: f64 = 0.7;

/// Depth over the local size below which an end lies on the border.
const ON_BORDER: f64 = 0.05;

/// Least depth over the local size of a node within the domain.
const WITHIN: f64 = 0.4;

/// Distance over the local size between a crack and other nodes.
const CLEAR: f64 = 0.5;

/// Distance over the local size at which a crack is drawn to a node of another one.
const DRAWN: f64 = 0.3;

/// Points that are looked at together.
const GROUP: usize = 8;

/// How often a piece that is drawn to others may be divided.
const MAX_DETOURS: u32 = 16;

/// Cracks as nodes and edges.
pub(super) struct Chains {
    /// Nodes within the domain; their numbers follow those of the border.
    pub(super) nodes_m: Vec<[f64; 2]>,
    pub(super) edges: Vec<[u32; 2]>,
}

/// A place that a crack is to run through.
struct Stop {
    point: [f64; 2],
    /// Whether the crack ends or meets another one there.
    is_key: bool,
}

/// Brings cracks to the size of the mesh. Their ends and the vertices that they share stay, the
/// rest is sampled anew. Where cracks run nearer to each other than the size allows, samples are
/// left out: the crack goes straight from the one before to the one after, or along the other
/// crack. An end on the border takes the nearest node of the border with it.
pub(super) fn chains(
    cracks: &[Vec<[f64; 2]>],
    grading: &Grading,
    border: &mut [BorderNode],
) -> Chains {
    let shared = shared_vertices(cracks);
    let paths: Vec<Vec<Stop>> = cracks
        .iter()
        .flat_map(|crack| inside(crack, &grading.domain))
        .map(|path| sampled(&path, &shared, grading))
        .collect();
    let mut placed = Placed {
        grading,
        n_border: border.len(),
        is_taken: vec![false; border.len()],
        border,
        nodes_m: Vec::new(),
    };
    let mut nodes: Vec<Vec<Option<u32>>> = paths
        .iter()
        .map(|path| path.iter().map(|_| None).collect())
        .collect();
    // Ends and junctions first, on the border before all.
    for round in 0..3 {
        for (path, nodes) in paths.iter().zip(&mut nodes) {
            for (stop, node) in path.iter().zip(nodes.iter_mut()) {
                *node = node.or_else(|| match (round, stop.is_key) {
                    (0, true) => placed.on_border(stop.point),
                    (1, true) => placed.key(stop.point),
                    (2, false) => placed.between(stop.point),
                    _ => None,
                });
            }
        }
    }
    let mut edges = Vec::new();
    for nodes in &nodes {
        let mut chain: Vec<u32> = nodes.iter().copied().flatten().collect();
        chain.dedup();
        for pair in chain.windows(2) {
            placed.connect([pair[0], pair[1]], MAX_DETOURS, &mut edges);
        }
    }
    Chains {
        nodes_m: placed.nodes_m,
        edges,
    }
}

/// Keeps the points that are not too near to a crack.
pub(super) fn clear_of(
    points: &[[f64; 2]],
    chains: &Chains,
    border: &[BorderNode],
    grading: &Grading,
) -> Vec<[f64; 2]> {
    let position = |node: u32| match border.get(node as usize) {
        Some(node) => node.position_m,
        None => chains.nodes_m[node as usize - border.len()],
    };
    let pieces: Vec<[[f64; 2]; 2]> = chains.edges.iter().map(|edge| edge.map(position)).collect();
    let nodes = border.iter().map(|node| (node.position_m, 0.3));
    let nodes = nodes.chain(chains.nodes_m.iter().map(|&node| (node, 1.0)));
    let mut kept = Vec::with_capacity(points.len());
    // Points that follow each other lie on an arc of a ring: what is far from all of them is seen at once.
    for group in points.chunks(GROUP) {
        let least = |point: &[f64; 2]| CLEAR * grading.size_at_m(*point);
        let most = group.iter().map(least).fold(0.0, f64::max);
        let ends = |axis: usize| {
            let places = group.iter().map(move |point| point[axis]);
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            })
        };
        let bounds = [ends(0), ends(1)];
        let may_be_near = |[a, b]: [[f64; 2]; 2]| {
            (0..2).all(|axis| {
                let [low, high] = bounds[axis];
                a[axis].min(b[axis]) - most <= high && a[axis].max(b[axis]) + most >= low
            })
        };
        let pieces: Vec<_> = pieces.iter().filter(|piece| may_be_near(**piece)).collect();
        let nodes: Vec<_> = nodes
            .clone()
            .filter(|&(node, _)| may_be_near([node; 2]))
            .collect();
        kept.extend(group.iter().filter(|&point| {
            let least = least(point);
            !pieces
                .iter()
                .any(|[a, b]| is_near_piece(*point, *a, *b, least))
                && !nodes
                    .iter()
                    .any(|&(node, part)| is_near(node, *point, part * least))
        }));
    }
    kept
}

/// The nodes of cracks so far.
struct Placed<'a> {
    grading: &'a Grading,
    border: &'a mut [BorderNode],
    n_border: usize,
    is_taken: Vec<bool>,
    nodes_m: Vec<[f64; 2]>,
}

impl Placed<'_> {
    fn on_border(&mut self, point: [f64; 2]) -> Option<u32> {
        let size = self.grading.size_at_m(point);
        if self.grading.domain.depth_m(point) > ON_BORDER * size {
            return None;
        }
        let domain = &self.grading.domain;
        move_nearest(self.border, &mut self.is_taken, domain, point).map(to_u32)
    }

    fn key(&mut self, point: [f64; 2]) -> Option<u32> {
        let size = self.grading.size_at_m(point);
        let nearest = self
            .nodes_m
            .iter()
            .map(|node| distance(*node, point))
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match nearest {
            Some((idx, away)) if away < SAME * size => Some(to_u32(self.n_border + idx)),
            _ if self.grading.domain.depth_m(point) < WITHIN * size => None,
            _ => Some(self.add(point)),
        }
    }

    fn between(&mut self, point: [f64; 2]) -> Option<u32> {
        let size = self.grading.size_at_m(point);
        let is_free = self.grading.domain.depth_m(point) >= WITHIN * size
            && self
                .nodes_m
                .iter()
                .all(|node| !is_near(*node, point, APART * size));
        is_free.then(|| self.add(point))
    }

    /// An edge, or, where it passes too near to other nodes, edges through those.
    fn connect(&self, [a, b]: [u32; 2], detours: u32, edges: &mut Vec<[u32; 2]>) {
        let (from, to) = (self.position(a), self.position(b));
        let span = distance(from, to);
        let middle = at(from, to, 0.5);
        let drawing = (0..)
            .zip(&self.nodes_m)
            .map(|(idx, node)| (to_u32(self.n_border) + idx, *node))
            // Nearer to both ends than these are to each other, so that detours come to an end.
            .filter(|&(idx, node)| {
                idx != a && idx != b && is_near(node, from, span) && is_near(node, to, span)
            })
            .filter(|&(_, node)| {
                is_near_piece(node, from, to, DRAWN * self.grading.size_at_m(node))
            })
            // The middle one, so that they come to an end soon.
            .map(|(idx, node)| (distance(node, middle), idx))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match drawing {
            None => edges.push([a, b]),
            Some((_, node)) if detours > 0 => {
                self.connect([a, node], detours - 1, edges);
                self.connect([node, b], detours - 1, edges);
            }
            Some(_) => (),
        }
    }

    fn position(&self, node: u32) -> [f64; 2] {
        match self.border.get(node as usize) {
            Some(node) => node.position_m,
            None => self.nodes_m[node as usize - self.n_border],
        }
    }

    fn add(&mut self, point: [f64; 2]) -> u32 {
        self.nodes_m.push(point);
        to_u32(self.n_border + self.nodes_m.len() - 1)
    }
}

/// Vertices that cracks have in common, in the order of their bits.
fn shared_vertices(cracks: &[Vec<[f64; 2]>]) -> Vec<[u64; 2]> {
    let mut all: Vec<[u64; 2]> = cracks
        .iter()
        .flatten()
        .map(|p| p.map(f64::to_bits))
        .collect();
    all.sort_unstable();
    let mut shared: Vec<[u64; 2]> = all
        .windows(2)
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0])
        .collect();
    shared.dedup();
    shared
}

/// The parts of a crack within the domain.
fn inside(crack: &[[f64; 2]], domain: &Domain) -> Vec<Vec<[f64; 2]>> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut is_open = false;
    for pair in crack.windows(2) {
        let Some([from, to]) = within(pair[0], pair[1], domain) else {
            is_open = false;
            continue;
        };
        match parts.last_mut() {
            Some(part) if is_open && from <= 0.0 => part.push(at(pair[0], pair[1], to)),
            _ => parts.push(vec![at(pair[0], pair[1], from), at(pair[0], pair[1], to)]),
        }
        is_open = to >= 1.0;
    }
    parts
}

/// The fractions of the way from a to b between which it lies in the domain, which is convex, so
/// that the depth along the way has one maximum.
fn within(a: [f64; 2], b: [f64; 2], domain: &Domain) -> Option<[f64; 2]> {
    if !(a.iter().chain(&b).all(|x| x.is_finite()) && distance(a, b) > 0.0) {
        return None;
    }
    // On the border counts as inside.
    let depth = |t: f64| domain.depth_m(at(a, b, t)) + 1e-9 * domain.reach_m();
    if depth(0.0) >= 0.0 && depth(1.0) >= 0.0 {
        return Some([0.0, 1.0]);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if depth(left) < depth(right) {
            low = left;
        } else {
            high = right;
        }
    }
    let deepest = 0.5 * (low + high);
    if depth(deepest) <= 0.0 {
        return None;
    }
    let border = |end: f64| {
        if depth(end) >= 0.0 {
            return end;
        }
        let (mut out, mut within) = (end, deepest);
        for _ in 0..60 {
            let middle = 0.5 * (out + within);
            if depth(middle) >= 0.0 {
                within = middle;
            } else {
                out = middle;
            }
        }
        within
    };
    Some([border(0.0), border(1.0)])
}

/// A path with its keys kept and what is between them divided by the local size.
fn sampled(path: &[[f64; 2]], shared: &[[u64; 2]], grading: &Grading) -> Vec<Stop> {
    let is_key = |idx: usize| {
        idx == 0
            || idx + 1 == path.len()
            || shared.binary_search(&path[idx].map(f64::to_bits)).is_ok()
    };
    let mut stops = vec![Stop {
        point: path[0],
        is_key: true,
    }];
    let mut first = 0;
    for last in (1..path.len()).filter(|&idx| is_key(idx)) {
        divide(&path[first..=last], grading, &mut stops);
        stops.push(Stop {
            point: path[last],
            is_key: true,
        });
        first = last;
    }
    stops
}

/// Appends places between the ends of a path, as many as the local size asks for.
fn divide(path: &[[f64; 2]], grading: &Grading, stops: &mut Vec<Stop>) {
    // Steps along the path, each with the number of gaps up to its end.
    let mut steps: Vec<([f64; 2], f64)> = vec![(path[0], 0.0)];
    let mut gaps = 0.0;
    for pair in path.windows(2) {
        let length = distance(pair[0], pair[1]);
        let mut done = 0.0;
        while done < length {
            let here = at(pair[0], pair[1], done / length);
            let next = (done + 0.2 * grading.size_at_m(here)).min(length);
            let middle = at(pair[0], pair[1], 0.5 * (done + next) / length);
            gaps += (next - done) / grading.size_at_m(middle);
            done = next;
            steps.push((at(pair[0], pair[1], done / length), gaps));
        }
    }
    let n = gaps.round();
    let mut k = 1.0;
    for pair in steps.windows(2) {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        while k < n && k * gaps / n <= high {
            let t = (k * gaps / n - low) / (high - low);
            stops.push(Stop {
                point: at(from, to, t),
                is_key: false,
            });
            k += 1.0;
        }
    }
}

fn at(a: [f64; 2], b: [f64; 2], t: f64) -> [f64; 2] {
    // The ends are exactly what they are, so that they are known again.
    if t <= 0.0 {
        a
    } else if t >= 1.0 {
        b
    } else {
        [0, 1].map(|k| a[k] + t * (b[k] - a[k]))
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Whether two points are less than a distance apart, without its root.
fn is_near(a: [f64; 2], b: [f64; 2], least: f64) -> bool {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    dx * dx + dy * dy < least * least
}

/// Whether a point is less than a distance from the straight piece from a to b.
fn is_near_piece(point: [f64; 2], a: [f64; 2], b: [f64; 2], least: f64) -> bool {
    let is_beside =
        |k: usize| point[k] > a[k].min(b[k]) - least && point[k] < a[k].max(b[k]) + least;
    if !(is_beside(0) && is_beside(1)) {
        return false;
    }
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let along = (point[0] - a[0]) * dx + (point[1] - a[1]) * dy;
    let t = (along / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    is_near(point, [a[0] + t * dx, a[1] + t * dy], least)
}
