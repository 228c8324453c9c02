//! The pieces that the cracks cut the pane into: the faces of the graph of cracks and rim.

use std::collections::BTreeSet;

use super::graph::Graph;
use super::strips::Strips;
use super::{CrackNetwork, NetworkData};

/// A piece of the pane that cracks, or cracks and the rim, bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    /// Corners of the outer bound, in the network's length unit, without those of holes. On the
    /// rim of a disc only its ends are corners of a piece of rim, the arc is not.
    pub outline: Vec<[f64; 2]>,
    /// Area without holes, in the network's length unit squared; of a disc, arcs included.
    pub area: f64,
    /// Centre of that area.
    pub centroid: [f64; 2],
    /// Length of all that bounds it against other fragments and against the outside, holes
    /// included.
    pub perimeter: f64,
    /// Whether a piece of the rim bounds it.
    pub touches_rim: bool,
}

impl Fragment {
    /// Whether a point lies within the outer bound.
    #[must_use]
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let mut is_inside = false;
        for (k, &[x0, y0]) in self.outline.iter().enumerate() {
            let [x1, y1] = self.outline[(k + 1) % self.outline.len()];
            if (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0) {
                is_inside = !is_inside;
            }
        }
        is_inside
    }

    /// A point within the outer bound: the centroid, or the middle of the widest part of a level
    /// line through it or above it. None of a bound without area.
    #[must_use]
    pub fn inner_point(&self) -> Option<[f64; 2]> {
        if self.contains(self.centroid) {
            return Some(self.centroid);
        }
        let mut levels: Vec<f64> = self.outline.iter().map(|corner| corner[1]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let middles = levels.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let mut best: Option<(f64, [f64; 2])> = None;
        for y in middles {
            let mut crossings: Vec<f64> = (0..self.outline.len())
                .filter_map(|k| {
                    let [x0, y0] = self.outline[k];
                    let [x1, y1] = self.outline[(k + 1) % self.outline.len()];
                    ((y0 > y) != (y1 > y)).then(|| x0 + (y - y0) / (y1 - y0) * (x1 - x0))
                })
                .collect();
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let width = pair[1] - pair[0];
                if best.is_none_or(|(widest, _)| width > widest) {
                    best = Some((width, [0.5 * (pair[0] + pair[1]), y]));
                }
            }
        }
        best.map(|(_, point)| point)
    }
}

impl CrackNetwork {
    /// The fragments that fell out of the pane: of those around each point of
    /// [`NetworkData::fallen`] the smallest, for one may lie in the hole of another.
    #[must_use]
    pub fn fallen_fragments(&self) -> Vec<Fragment> {
        if self.data.fallen.is_empty() {
            return Vec::new();
        }
        let mut fragments = self.fragments();
        let around = |point: &[f64; 2]| {
            let all = fragments.iter().enumerate();
            all.filter(|(_, fragment)| fragment.contains(*point))
                .min_by(|(_, a), (_, b)| a.area.total_cmp(&b.area))
                .map(|(idx, _)| idx)
        };
        let fallen: BTreeSet<usize> = self.data.fallen.iter().filter_map(around).collect();
        let mut idx = 0..;
        fragments.retain(|_| idx.next().is_some_and(|idx| fallen.contains(&idx)));
        fragments
    }

    /// The fragments that the cracks and the rim of the pane bound: at least one, and their
    /// areas sum to that of the pane.
    ///
    /// A crack that ends in the glass bounds nothing. Where a ring of cracks meets no other
    /// crack, what is inside is one fragment and a hole in the other. All cracks of the ply
    /// that was hit count, however deep they are; those of other plies do not.
    ///
    /// Half-edge walk around each face; exact predicates decide what lies where. O(n log n),
    /// and about √n for each group of cracks that reaches no rim.
    ///
    /// # Limits
    /// Nodes within [`Pane::rim_tolerance`](crate::Pane::rim_tolerance) of the rim are on it.
    #[must_use]
    pub fn fragments(&self) -> Vec<Fragment> {
        Faces::of(&self.data).fragments()
    }
}

/// What an index of a face is when it is the outside of the pane.
const OUTSIDE: u32 = u32::MAX;

/// The faces of the graph of cracks and rim. The two halves of edge e are 2e, from its first
/// end to its second, and 2e + 1, back; each has a face on its left (y up).
pub(super) struct Faces {
    graph: Graph,
    /// The half that follows each half around its face.
    next: Vec<usize>,
    /// The face at each half.
    face: Vec<u32>,
    /// One half of the outer bound of each face.
    first: Vec<usize>,
}

impl Faces {
    pub(super) fn of(data: &NetworkData) -> Self {
        let graph = Graph::of(data);
        let next = graph.next();
        let mut cycle = vec![u32::MAX; next.len()];
        let mut starts: Vec<usize> = Vec::new();
        for start in 0..next.len() {
            if cycle[start] != u32::MAX {
                continue;
            }
            let number = u32::try_from(starts.len()).unwrap_or(OUTSIDE);
            starts.push(start);
            let mut half = start;
            while cycle[half] == u32::MAX {
                cycle[half] = number;
                half = next[half];
            }
        }
        // Each island has one cycle that runs around it: a hole in the face where it lies.
        let mut face_of: Vec<Option<u32>> = vec![None; starts.len()];
        face_of[cycle[graph.outside()] as usize] = Some(OUTSIDE);
        let islands = graph.islands();
        let mut is_hole = vec![false; starts.len()];
        for island in &islands {
            is_hole[cycle[island.outer] as usize] = true;
        }
        let mut first = Vec::new();
        for (number, &start) in starts.iter().enumerate() {
            if !is_hole[number] && face_of[number].is_none() {
                face_of[number] = u32::try_from(first.len()).ok();
                first.push(start);
            }
        }
        if !islands.is_empty() {
            // From the top down: what a ray meets belongs to the rim or to an island before.
            let strips = Strips::new(&graph.spans());
            for island in &islands {
                let around = cycle[graph.right_of(&strips, island.top)] as usize;
                face_of[cycle[island.outer] as usize] = face_of[around];
            }
        }
        let face = cycle
            .iter()
            .map(|&number| face_of[number as usize].unwrap_or(OUTSIDE))
            .collect();
        Self {
            graph,
            next,
            face,
            first,
        }
    }

    pub(super) fn n_fragments(&self) -> usize {
        self.first.len()
    }

    fn fragments(&self) -> Vec<Fragment> {
        let mut fragments: Vec<Fragment> = self
            .first
            .iter()
            .map(|&first| Fragment {
                outline: self.outline(first),
                area: 0.0,
                centroid: [0.0; 2],
                perimeter: 0.0,
                touches_rim: false,
            })
            .collect();
        for half in 0..self.next.len() {
            let Some(fragment) = fragments.get_mut(self.face[half] as usize) else {
                continue;
            };
            // Relative to a corner of its own, a small fragment loses no digits.
            let origin = fragment.outline[0];
            let [a, b] = self.graph.ends(half).map(|vertex| {
                let [x, y] = self.graph.on_rim(vertex);
                [x - origin[0], y - origin[1]]
            });
            let twice = a[0] * b[1] - b[0] * a[1];
            fragment.area += 0.5 * twice;
            fragment.centroid[0] += twice * (a[0] + b[0]) / 6.0;
            fragment.centroid[1] += twice * (a[1] + b[1]) / 6.0;
            if let Some([from, to]) = self.graph.rim_piece(half) {
                let bulge = self.graph.bulge(from, to);
                fragment.area += bulge.area;
                fragment.centroid[0] += bulge.moment[0] - bulge.area * origin[0];
                fragment.centroid[1] += bulge.moment[1] - bulge.area * origin[1];
                fragment.perimeter += bulge.length;
                fragment.touches_rim = true;
            } else if self.face[half ^ 1] != self.face[half] {
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                fragment.perimeter += (dx * dx + dy * dy).sqrt();
            }
        }
        for fragment in &mut fragments {
            let per_area = if fragment.area > 0.0 {
                1.0 / fragment.area
            } else {
                0.0
            };
            for k in 0..2 {
                fragment.centroid[k] = fragment.outline[0][k] + fragment.centroid[k] * per_area;
            }
        }
        fragments
    }

    fn outline(&self, first: usize) -> Vec<[f64; 2]> {
        let mut outline = Vec::new();
        let mut half = first;
        loop {
            outline.push(self.graph.on_rim(self.graph.ends(half)[0]));
            half = self.next[half];
            if half == first {
                return outline;
            }
        }
    }
}
