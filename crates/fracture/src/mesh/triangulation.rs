//! Constrained Delaunay triangulation of the particles inside the outline of the pane.

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

/// A triangulated pane. Node ids are those of its [`Particles`].
pub struct PaneMesh {
    particles: Particles,
    triangulation: ConstrainedDelaunayTriangulation<Indexed>,
    /// The triangulation's number of each node; it numbers them as they are inserted.
    vertex_of: Vec<u32>,
}

/// The mesh of a pane: `count` uniform particles, the corners, the given `fixed` points, and the
/// outline as constraints. Fixed points may lie on the rim, which they then divide.
///
/// The first ids of [`Particles::fixed_node`] are those of `fixed`, the four after them the
/// corners.
///
/// # Errors
/// [`FractureError::Triangulation`] if the triangulation library refuses the points.
pub fn mesh_pane(
    pane: &Pane,
    count: u32,
    fixed: &[[f64; 2]],
    seed: Seed,
) -> Result<PaneMesh, FractureError> {
    let (width, height) = (pane.width, pane.height);
    let mut points = fixed.to_vec();
    points.extend([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]);
    let particles = Particles::scatter(pane, count, &points, seed);
    let outline = outline(&particles, &points, pane);
    let n = particles.len();
    let mut triangulation =
        ConstrainedDelaunayTriangulation::<Indexed>::with_capacity(n, 3 * n, 2 * n);
    let mut vertex_of = vec![0; particles.len()];
    let mut is_inserted = vec![false; particles.len()];
    let mut last = None;
    // The rim first: what follows then lies inside the hull, which never has to grow.
    let rim = outline.iter().map(|[from, _]| to_u32(*from));
    for node in rim.chain(particles.insertion_order()) {
        if std::mem::replace(&mut is_inserted[node as usize], true) {
            continue;
        }
        let vertex = Indexed::new(node, particles.position(node));
        let inserted = match last {
            Some(near) => triangulation.insert_with_hint(vertex, near),
            None => triangulation.insert(vertex),
        };
        let handle = inserted.map_err(|cause| FractureError::Triangulation {
            n_nodes: particles.len(),
            cause: cause.to_string(),
        })?;
        vertex_of[node as usize] = to_u32(handle.index());
        last = Some(handle);
    }
    let handle = |node: usize| FixedVertexHandle::from_index(vertex_of[node] as usize);
    for [from, to] in outline {
        // The rim of a rectangle is its convex hull, so these edges exist and only get their mark.
        triangulation.add_constraint(handle(from), handle(to));
    }
    Ok(PaneMesh {
        particles,
        triangulation,
        vertex_of,
    })
}

/// The rim as constraint edges from node to node: fixed points on it in order around the pane.
fn outline(particles: &Particles, points: &[[f64; 2]], pane: &Pane) -> Vec<[usize; 2]> {
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
    let mut rim: Vec<(f64, usize)> = points
        .iter()
        .enumerate()
        .filter_map(|(idx, point)| along(point).map(|at| (at, particles.fixed_node(idx) as usize)))
        .collect();
    rim.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    rim.dedup_by_key(|(_, node)| *node);
    (0..rim.len())
        .map(|k| [rim[k].1, rim[(k + 1) % rim.len()].1])
        .collect()
}

impl PaneMesh {
    /// The nodes.
    #[must_use]
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Number of triangles.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        self.triangulation.num_inner_faces()
    }

    /// The nodes that share a mesh edge with `node`, in the order around it.
    pub fn mesh_neighbors(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        let handle = FixedVertexHandle::from_index(self.vertex_of[node as usize] as usize);
        self.triangulation
            .vertex(handle)
            .out_edges()
            .map(|edge| edge.to().data().idx)
    }

    /// The node that is reached from `from` on the way to `to` along one mesh edge: the one
    /// nearest to `to`. On a Delaunay mesh this greedy walk always arrives \[BoseMorin2004\].
    pub(crate) fn next_towards(&self, from: u32, to: u32) -> u32 {
        let [x, y] = self.particles.position(to);
        self.mesh_neighbors(from)
            .map(|node| {
                let [other_x, other_y] = self.particles.position(node);
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
            let mesh = mesh_pane(&pane, count, &[on_rim], Seed(4)).unwrap();
            let n = mesh.particles().len();
            assert_eq!(mesh.n_triangles(), 2 * n - 2 - 5, "{width}×{height}");
        }
    }

    #[test]
    fn a_greedy_walk_arrives() {
        let pane = Pane::from_frame_px(300, 100);
        let mesh = mesh_pane(&pane, 500, &[], Seed(2)).unwrap();
        let last = to_u32(mesh.particles().len()) - 1;
        let mut at = 0;
        for _ in 0..500 {
            if at == last {
                return;
            }
            at = mesh.next_towards(at, last);
        }
        panic!("the walk did not arrive");
    }
}
