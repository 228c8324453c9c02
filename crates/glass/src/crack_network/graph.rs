//! The graph of cracks and rim, its edges sorted around each vertex.

use std::cmp::Ordering;

use robust::{Coord, orient2d};

use super::NetworkData;
use super::rim::{Bulge, Rim, RimPoint};
use super::strips::Strips;

/// Cracks that bound something, then the pieces of the rim.
pub(super) struct Graph {
    rim: Rim,
    at: Vec<Coord<f64>>,
    edges: Vec<[usize; 2]>,
    n_cracks: usize,
    /// Vertices on the rim, in its order; edge `n_cracks + k` leads from the k-th to the next.
    along_rim: Vec<(usize, RimPoint)>,
    rim_points: Vec<Option<RimPoint>>,
    /// Halves that leave each vertex, turning from +x towards +y, those on the rim from outside.
    spokes: Vec<usize>,
    starts: Vec<usize>,
}

/// Cracks that hang together and do not reach the rim.
pub(super) struct Island {
    /// Its topmost vertex, of several the one with the greatest x.
    pub(super) top: usize,
    /// The half at that vertex with the outside of the island on its left.
    pub(super) outer: usize,
}

impl Graph {
    pub(super) fn of(data: &NetworkData) -> Self {
        let rim = Rim::of(&data.pane);
        let mut at: Vec<Coord<f64>> = (data.nodes.x.iter().zip(&data.nodes.y))
            .map(|(&x, &y)| Coord { x, y })
            .collect();
        let mut rim_points: Vec<Option<RimPoint>> =
            at.iter().map(|node| rim.find([node.x, node.y])).collect();
        let edges = cracks_that_bound(data, &rim_points);
        let n_cracks = edges.len();
        let mut is_used = vec![false; at.len()];
        for &vertex in edges.iter().flatten() {
            is_used[vertex] = true;
        }
        let mut along_rim: Vec<(usize, RimPoint)> = (rim_points.iter().enumerate())
            .filter(|(vertex, _)| is_used[*vertex])
            .filter_map(|(vertex, point)| Some((vertex, (*point)?)))
            .collect();
        if rim.has_corners() || along_rim.is_empty() {
            for [x, y] in rim.own_points() {
                let Some(point) = rim.find([x, y]) else {
                    continue;
                };
                #[expect(clippy::float_cmp, reason = "a node in the corner is snapped to it")]
                let is_there = along_rim.iter().any(|(_, other)| other.at == point.at);
                if !is_there {
                    along_rim.push((at.len(), point));
                    at.push(Coord { x, y });
                    rim_points.push(Some(point));
                }
            }
        }
        along_rim.sort_by(|a, b| a.1.place.total_cmp(&b.1.place));
        let mut graph = Self {
            rim,
            at,
            edges,
            n_cracks,
            along_rim,
            rim_points,
            spokes: Vec::new(),
            starts: Vec::new(),
        };
        let n_rim = graph.along_rim.len();
        for k in 0..n_rim {
            let (from, to) = (graph.along_rim[k].0, graph.along_rim[(k + 1) % n_rim].0);
            graph.edges.push([from, to]);
        }
        graph.sort_spokes();
        graph
    }

    /// The vertices that a half leads from and to.
    pub(super) fn ends(&self, half: usize) -> [usize; 2] {
        let [a, b] = self.edges[half / 2];
        if half.is_multiple_of(2) {
            [a, b]
        } else {
            [b, a]
        }
    }

    /// Position of a vertex, on the rim to the last bit if it lies there.
    pub(super) fn on_rim(&self, vertex: usize) -> [f64; 2] {
        let Coord { x, y } = self.at[vertex];
        self.rim_points[vertex].map_or([x, y], |point| point.at)
    }

    /// The two points of the rim between which a half with the pane on its left runs.
    pub(super) fn rim_piece(&self, half: usize) -> Option<[&RimPoint; 2]> {
        let k = (half / 2).checked_sub(self.n_cracks)?;
        let next = (k + 1) % self.along_rim.len();
        Some([&self.along_rim[k].1, &self.along_rim[next].1])
    }

    /// What such a half encloses with its chord.
    pub(super) fn bulge(&self, from: &RimPoint, to: &RimPoint) -> Bulge {
        self.rim.bulge(from, to)
    }

    /// A half with the outside of the pane on its left.
    pub(super) fn outside(&self) -> usize {
        2 * self.n_cracks + 1
    }

    /// Sorts the halves around each vertex.
    fn sort_spokes(&mut self) {
        let mut starts = vec![0; self.at.len() + 1];
        for &vertex in self.edges.iter().flatten() {
            starts[vertex + 1] += 1;
        }
        for vertex in 0..self.at.len() {
            starts[vertex + 1] += starts[vertex];
        }
        let mut spokes = vec![0; 2 * self.edges.len()];
        let mut free = starts.clone();
        for half in 0..2 * self.edges.len() {
            let slot = &mut free[self.ends(half)[0]];
            spokes[*slot] = half;
            *slot += 1;
        }
        for vertex in 0..self.at.len() {
            self.sort_around(vertex, &mut spokes[starts[vertex]..starts[vertex + 1]]);
        }
        (self.spokes, self.starts) = (spokes, starts);
    }

    fn sort_around(&self, vertex: usize, spokes: &mut [usize]) {
        let center = self.at[vertex];
        let point = |half: usize| self.at[self.ends(half)[1]];
        let sort = |cracks: &mut [usize]| {
            cracks.sort_unstable_by(|&a, &b| turning(center, point(a), point(b)).then(a.cmp(&b)));
        };
        let Some(rim_point) = &self.rim_points[vertex] else {
            sort(spokes);
            return;
        };
        // Halves of the rim have the highest numbers: 2e leaves along it, 2e + 1 against it.
        spokes.sort_unstable();
        let n_cracks = spokes.partition_point(|&half| half < 2 * self.n_cracks);
        let along = spokes[n_cracks..]
            .iter()
            .position(|half| half.is_multiple_of(2));
        if let Some(along) = along {
            spokes.swap(n_cracks, n_cracks + along);
        }
        let (cracks, along) = spokes.split_at_mut(n_cracks);
        sort(cracks);
        // Cracks are counted from the outside on, which is where no crack is.
        let outside = Coord {
            x: center.x + rim_point.outward[0],
            y: center.y + rim_point.outward[1],
        };
        let first = cracks.partition_point(|&half| turning(center, point(half), outside).is_lt());
        cracks.rotate_left(first);
        // First the rim ahead, then the cracks, last the rim behind.
        if along.len() == 2 {
            spokes[..=n_cracks].rotate_right(1);
        }
    }

    /// The half that follows each half around the face on its left.
    pub(super) fn next(&self) -> Vec<usize> {
        let mut next = vec![0; 2 * self.edges.len()];
        for vertex in 0..self.at.len() {
            let around = self.around(vertex);
            for (k, &half) in around.iter().enumerate() {
                // Arriving by the twin of a spoke, a face goes on with the spoke before it.
                next[half ^ 1] = around[(k + around.len() - 1) % around.len()];
            }
        }
        next
    }

    fn around(&self, vertex: usize) -> &[usize] {
        &self.spokes[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// Groups of cracks that do not reach the rim, from the top down.
    pub(super) fn islands(&self) -> Vec<Island> {
        let mut is_seen = vec![false; self.at.len()];
        self.reach(self.along_rim[0].0, &mut is_seen);
        let higher = |a: &usize, b: &usize| {
            let (a, b) = (self.at[*a], self.at[*b]);
            a.y.total_cmp(&b.y).then(b.x.total_cmp(&a.x))
        };
        let mut tops: Vec<usize> = Vec::new();
        for vertex in 0..self.at.len() {
            if !is_seen[vertex] && !self.around(vertex).is_empty() {
                let island = self.reach(vertex, &mut is_seen);
                tops.extend(island.into_iter().min_by(higher));
            }
        }
        tops.sort_unstable_by(higher);
        // Spokes of a top have directions from 0 (not included) to 180 degrees, in order: the
        // outside comes after the last.
        let outer = |&top: &usize| self.around(top).last().copied();
        tops.iter()
            .filter_map(|top| outer(top).map(|outer| Island { top: *top, outer }))
            .collect()
    }

    /// The vertices that hang together with one, marked as seen.
    fn reach(&self, start: usize, is_seen: &mut [bool]) -> Vec<usize> {
        is_seen[start] = true;
        let mut reached = vec![start];
        let mut k = 0;
        while k < reached.len() {
            for &half in self.around(reached[k]) {
                let other = self.ends(half)[1];
                if !std::mem::replace(&mut is_seen[other], true) {
                    reached.push(other);
                }
            }
            k += 1;
        }
        reached
    }

    /// Ends of the cracks.
    pub(super) fn spans(&self) -> Vec<(Coord<f64>, Coord<f64>)> {
        let cracks = &self.edges[..self.n_cracks];
        cracks
            .iter()
            .map(|&[a, b]| (self.at[a], self.at[b]))
            .collect()
    }

    /// The half that a ray from a vertex towards +x meets first, seen from the vertex. The ray
    /// runs a shade below the vertex, so that it meets no other.
    pub(super) fn right_of(&self, strips: &Strips, vertex: usize) -> usize {
        let start = self.at[vertex];
        let mut nearest: Option<(usize, Coord<f64>, Coord<f64>)> = None;
        for &crack in strips.members_at(start.y) {
            let edge = crack as usize;
            let [a, b] = self.edges[edge].map(|vertex| self.at[vertex]);
            let (half, upper, lower) = if a.y <= b.y {
                (2 * edge, a, b)
            } else {
                (2 * edge + 1, b, a)
            };
            let is_met =
                (upper.y..lower.y).contains(&start.y) && orient2d(upper, lower, start) > 0.0;
            let is_nearer = |&(_, other_upper, other_lower): &(usize, Coord<f64>, Coord<f64>)| {
                // Of two cracks that do not cross, the one that starts later is compared.
                if upper.y >= other_upper.y {
                    let side = orient2d(other_upper, other_lower, upper);
                    side > 0.0 || (side == 0.0 && orient2d(other_upper, other_lower, lower) > 0.0)
                } else {
                    let side = orient2d(upper, lower, other_upper);
                    side < 0.0 || (side == 0.0 && orient2d(upper, lower, other_lower) < 0.0)
                }
            };
            if is_met && nearest.as_ref().is_none_or(is_nearer) {
                nearest = Some((half, upper, lower));
            }
        }
        if let Some((half, ..)) = nearest {
            return half;
        }
        let before = self.along_rim.partition_point(|(vertex, point)| {
            self.rim.is_before_exit(point, self.at[*vertex].y, start.y)
        });
        let n_rim = self.along_rim.len();
        2 * (self.n_cracks + (before + n_rim - 1) % n_rim)
    }
}

/// Cracks of the ply that was hit, without those along the rim and those that end in the glass,
/// as pairs of nodes.
fn cracks_that_bound(data: &NetworkData, rim_points: &[Option<RimPoint>]) -> Vec<[usize; 2]> {
    let segments = &data.segments;
    let is_on_rim = |a: usize, b: usize| match (&rim_points[a], &rim_points[b]) {
        (Some(a), Some(b)) => a.shares_side(b),
        _ => false,
    };
    let edges: Vec<[usize; 2]> = (segments.from.iter().zip(&segments.to))
        .enumerate()
        .filter(|(idx, _)| segments.ply.as_ref().is_none_or(|plies| plies[*idx] == 0))
        .map(|(_, (&from, &to))| [from as usize, to as usize])
        .filter(|&[a, b]| !is_on_rim(a, b))
        .collect();
    let mut starts = vec![0_usize; rim_points.len() + 1];
    for &vertex in edges.iter().flatten() {
        starts[vertex + 1] += 1;
    }
    for vertex in 0..rim_points.len() {
        starts[vertex + 1] += starts[vertex];
    }
    let mut at_vertex = vec![0; 2 * edges.len()];
    let mut free = starts.clone();
    for (idx, ends) in edges.iter().enumerate() {
        for &vertex in ends {
            at_vertex[free[vertex]] = idx;
            free[vertex] += 1;
        }
    }
    // Cuts off what hangs free, from its end on.
    let mut degree: Vec<usize> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut is_cut = vec![false; edges.len()];
    for tip in 0..rim_points.len() {
        let mut tip = tip;
        while degree[tip] == 1 && rim_points[tip].is_none() {
            let Some(&idx) = at_vertex[starts[tip]..starts[tip + 1]]
                .iter()
                .find(|idx| !is_cut[**idx])
            else {
                break;
            };
            is_cut[idx] = true;
            degree[tip] = 0;
            let [a, b] = edges[idx];
            tip = if a == tip { b } else { a };
            degree[tip] -= 1;
        }
    }
    (edges.into_iter().zip(is_cut))
        .filter(|(_, is_cut)| !is_cut)
        .map(|(ends, _)| ends)
        .collect()
}

/// Order of two points around a center by direction, from just beyond +x towards +y and on to
/// +x itself; exact, so a total order.
fn turning(center: Coord<f64>, p: Coord<f64>, q: Coord<f64>) -> Ordering {
    #[expect(
        clippy::float_cmp,
        reason = "half planes are exact, their border included"
    )]
    let is_late = |p: Coord<f64>| p.y < center.y || (p.y == center.y && p.x > center.x);
    let turn = 0.0
        .partial_cmp(&orient2d(center, p, q))
        .unwrap_or(Ordering::Equal);
    is_late(p).cmp(&is_late(q)).then(turn)
}
