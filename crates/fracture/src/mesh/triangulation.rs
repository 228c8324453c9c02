//! Constrained Delaunay triangulation of the particles inside the outline of the pane.

use std::sync::OnceLock;

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use starbreak_glass::Pane;
use starbreak_seed::Seed;

use super::Particles;
use super::particles::to_u32;
use crate::FractureError;

/// A vertex of a triangulation that remembers which point it was made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Indexed {
    position: Point2<f64>,
    pub(crate) idx: u32,
}

impl Indexed {
    pub(crate) fn new(idx: u32, [x, y]: [f64; 2]) -> Self {
        Self {
            position: Point2::new(x, y),
            idx,
        }
    }
}

impl HasPosition for Indexed {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The nodes of a pane, and their triangulation once it has been asked for. Node ids are those of
/// its [`Particles`].
pub struct PaneMesh {
    particles: Particles,
    /// The nodes on the rim, in order around the pane.
    rim: Vec<u32>,
    edges: OnceLock<MeshEdges>,
}

/// The edges of a mesh: constrained Delaunay triangulation of its nodes.
pub struct MeshEdges {
    triangulation: ConstrainedDelaunayTriangulation<Indexed>,
    /// The triangulation's number of each node; it numbers them as they are inserted.
    vertex_of: Vec<u32>,
}

/// The mesh of a pane: `count` uniform particles, the corners, the given `fixed` points, and the
/// outline as constraints. Fixed points may lie on the rim, which they then divide.
///
/// The first ids of [`Particles::fixed_node`] are those of `fixed`, the four after them the
/// corners. The nodes are made at once; their edges, which take most of the time, by the first call
/// of [`PaneMesh::edges`]: only `mesh-edges` and `snap_to_mesh` need them.
#[must_use]
pub fn mesh_pane(pane: &Pane, count: u32, fixed: &[[f64; 2]], seed: Seed) -> PaneMesh {
    let (width, height) = (pane.width, pane.height);
    let mut points = fixed.to_vec();
    points.extend([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]);
    let particles = Particles::scatter(pane, count, &points, seed);
    PaneMesh {
        rim: rim(&particles, &points, pane),
        particles,
        edges: OnceLock::new(),
    }
}

/// The nodes on the rim, which are fixed points, in order around the pane.
fn rim(particles: &Particles, points: &[[f64; 2]], pane: &Pane) -> Vec<u32> {
    let (width, height) = (pane.width, pane.height);
    // Distance along the rim from the origin, clockwise on the screen; `None` inside the pane.
    #[expect(clippy::float_cmp, reason = "on the rim means exactly on it")]
    let along = |&[x, y]: &[f64; 2]| {
        if y == 0.0 {
            Some(x)
        } else if x == width {
            Some(width + y)
        } else if y == height {
            Some(width + height + (width - x))
        } else if x == 0.0 {
            Some(2.0 * width + height + (height - y))
        } else {
            None
        }
    };
    let mut rim: Vec<(f64, u32)> = points
        .iter()
        .enumerate()
        .filter_map(|(idx, point)| along(point).map(|at| (at, particles.fixed_node(idx))))
        .collect();
    rim.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    rim.dedup_by_key(|(_, node)| *node);
    rim.into_iter().map(|(_, node)| node).collect()
}

impl PaneMesh {
    /// The nodes.
    #[must_use]
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Number of triangles, by Euler's formula: 2V − 2 − B for V nodes, of which B are on the rim. Of a pane with room for
    /// two steps of its lattice in width and height, as any frame has; in a narrower one nodes lie beyond the rim.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        2 * self.particles.len() - 2 - self.rim.len()
    }

    /// The edges, triangulated by the first call.
    ///
    /// # Errors
    /// [`FractureError::Triangulation`] if the triangulation library refuses the points.
    pub fn edges(&self) -> Result<&MeshEdges, FractureError> {
        if let Some(edges) = self.edges.get() {
            return Ok(edges);
        }
        let edges = MeshEdges::of(&self.particles, &self.rim)?;
        Ok(self.edges.get_or_init(|| edges))
    }
}

impl MeshEdges {
    fn of(particles: &Particles, rim: &[u32]) -> Result<Self, FractureError> {
        let n = particles.len();
        let mut triangulation =
            ConstrainedDelaunayTriangulation::<Indexed>::with_capacity(n, 3 * n, 2 * n);
        let mut vertex_of = vec![0; n];
        let mut is_inserted = vec![false; n];
        let mut last = None;
        // The rim first: what follows then lies inside the hull, which never has to grow.
        for node in rim.iter().copied().chain(particles.insertion_order()) {
            if std::mem::replace(&mut is_inserted[node as usize], true) {
                continue;
            }
            let vertex = Indexed::new(node, particles.position(node));
            let inserted = match last {
                Some(near) => triangulation.insert_with_hint(vertex, near),
                None => triangulation.insert(vertex),
            };
            let handle = inserted.map_err(|cause| FractureError::Triangulation {
                n_nodes: n,
                cause: cause.to_string(),
            })?;
            vertex_of[node as usize] = to_u32(handle.index());
            last = Some(handle);
        }
        let mut edges = Self {
            triangulation,
            vertex_of,
        };
        for (&from, &to) in rim.iter().zip(rim.iter().cycle().skip(1)) {
            // The rim of a rectangle is its convex hull, so these edges exist and only get their mark.
            let (from, to) = (edges.vertex(from), edges.vertex(to));
            edges.triangulation.add_constraint(from, to);
        }
        Ok(edges)
    }

    fn vertex(&self, node: u32) -> FixedVertexHandle {
        FixedVertexHandle::from_index(self.vertex_of[node as usize] as usize)
    }

    /// The nodes that share a mesh edge with `node`, and their positions, in the order around it.
    pub(crate) fn neighbors(&self, node: u32) -> impl Iterator<Item = (u32, [f64; 2])> + '_ {
        let vertex = self.triangulation.vertex(self.vertex(node));
        vertex.out_edges().map(|edge| {
            let &Indexed { position, idx } = edge.to().data();
            (idx, [position.x, position.y])
        })
    }

    /// The node that is reached from `from` on the way to `to` along one mesh edge: the one
    /// nearest to `to`. On a Delaunay mesh this greedy walk always arrives \[BoseMorin2004\].
    pub(crate) fn next_towards(&self, from: u32, to: u32) -> u32 {
        let Point2 { x, y } = self.triangulation.vertex(self.vertex(to)).position();
        self.neighbors(from)
            .map(|(node, [other_x, other_y])| {
                let (dx, dy) = (other_x - x, other_y - y);
                (node, dx * dx + dy * dy)
            })
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
            .map_or(to, |(node, _)| node)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_of_a_rectangle_obeys_euler() {
        // V − E + F = 2 with the outer face; a triangulated polygon of V nodes, of which B on
        // the rim, has 2V − 2 − B triangles.
        for (width, height, count) in [(1242, 375, 2000), (1, 1, 10), (3, 700, 1)] {
            let pane = Pane::from_frame_px(width, height);
            let on_rim = [pane.width * 0.5, 0.0];
            let inside = [pane.width * 0.5, pane.height * 0.5];
            // Twice the same, and a corner, are no nodes of their own.
            let fixed = [on_rim, inside, on_rim, [0.0, pane.height]];
            let mesh = mesh_pane(&pane, count, &fixed, Seed(4));
            let n = mesh.particles().len();
            assert_eq!(mesh.n_triangles(), 2 * n - 2 - 5, "{width}×{height}");
            let triangulation = &mesh.edges().unwrap().triangulation;
            assert_eq!(
                triangulation.num_inner_faces(),
                mesh.n_triangles(),
                "{width}×{height}, counted"
            );
        }
    }

    #[test]
    fn a_greedy_walk_arrives() {
        let pane = Pane::from_frame_px(300, 100);
        let mesh = mesh_pane(&pane, 500, &[], Seed(2));
        let edges = mesh.edges().unwrap();
        let last = to_u32(mesh.particles().len()) - 1;
        let mut at = 0;
        for _ in 0..500 {
            if at == last {
                return;
            }
            at = edges.next_towards(at, last);
        }
        panic!("the walk did not arrive");
    }
}
