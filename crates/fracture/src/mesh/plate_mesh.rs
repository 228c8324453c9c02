//! A triangle mesh of a pane that is fine where it is hit.

use spade::handles::{FixedFaceHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, DelaunayTriangulation, Point2, Triangulation};

use super::Outline;
use super::cracks::{chains, clear_of};
use super::grading::{Domain, Grading};
use super::particles::to_u32;
use super::rim::{BorderNode, border};
use super::sides::Sides;
use crate::FractureError;

/// How fine the plate's mesh is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshResolution {
    /// About 1500 nodes, or 500 where only what is smooth is left to the mesh.
    Fast,
    /// About 6000 nodes, or 1500 where only what is smooth is left to the mesh.
    Default,
}

/// No triangle there: the other side of a border edge.
pub(super) const NONE: u32 = u32::MAX;

/// A Delaunay mesh of a pane, or of the part of it around a point, in m; cracks run along its edges.
///
/// Corners of a triangle are in the order of increasing angle (from +x towards +y). Nodes on the
/// border come first.
#[derive(Debug, Clone)]
pub struct PlateMesh {
    outline: Outline,
    nodes_m: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    /// The triangle across the edge opposite to each corner.
    pub(super) neighbors: Vec<[u32; 3]>,
    border: Vec<BorderNode>,
    sides: Sides,
    crack_edges: Vec<[u32; 2]>,
    inner_size_m: f64,
}

impl PlateMesh {
    /// The mesh of a pane: rings around `center_m` whose triangles have edges of `inner_size_m`
    /// (or less, where the pane is small) at the center and grow in proportion to their distance
    /// from it. With `domain_radius_m`, only what is within that distance of the center is
    /// meshed.
    ///
    /// # Errors
    /// [`FractureError::ImpactOffPane`] if the center is not on the pane,
    /// [`FractureError::Parameter`] if a size is not positive.
    pub fn graded(
        outline: &Outline,
        center_m: [f64; 2],
        inner_size_m: f64,
        domain_radius_m: Option<f64>,
        resolution: MeshResolution,
    ) -> Result<Self, FractureError> {
        let target = match resolution {
            MeshResolution::Fast => 1500,
            MeshResolution::Default => 6000,
        };
        Self::graded_to(outline, center_m, inner_size_m, domain_radius_m, target)
    }

    /// [`PlateMesh::graded`] with about `n_nodes` nodes (200 to 100 000).
    ///
    /// # Errors
    /// As there.
    pub fn graded_to(
        outline: &Outline,
        center_m: [f64; 2],
        inner_size_m: f64,
        domain_radius_m: Option<f64>,
        n_nodes: u32,
    ) -> Result<Self, FractureError> {
        Self::graded_around_cracks(
            outline,
            center_m,
            inner_size_m,
            domain_radius_m,
            n_nodes,
            &[],
        )
    }

    /// [`PlateMesh::graded_to`] with edges along cracks, which are chains of straight pieces, m.
    ///
    /// Cracks meet where they share a vertex. They are sampled anew by the local size of the
    /// mesh; ends and junctions nearer to each other than 0.4 of it become one, and what would
    /// cross another crack without a shared vertex is left out. What of a crack lies off the mesh
    /// does not count.
    ///
    /// # Errors
    /// As there.
    pub fn graded_around_cracks(
        outline: &Outline,
        center_m: [f64; 2],
        inner_size_m: f64,
        domain_radius_m: Option<f64>,
        n_nodes: u32,
        cracks: &[Vec<[f64; 2]>],
    ) -> Result<Self, FractureError> {
        let [width, height] = outline.size_m();
        for (name, value) in [
            ("width_m", width),
            ("height_m", height),
            ("inner_size_m", inner_size_m),
            ("domain_radius_m", domain_radius_m.unwrap_or(1.0)),
        ] {
            if !(value > 0.0 && value < 1e6) {
                return Err(FractureError::Parameter {
                    name,
                    value,
                    expected: "a positive length".into(),
                });
            }
        }
        let is_on_pane = outline.depth_m(center_m) >= -1e-9 * width.min(height);
        if !is_on_pane {
            return Err(FractureError::ImpactOffPane {
                x: center_m[0],
                y: center_m[1],
                width,
                height,
            });
        }
        let domain = Domain::new(*outline, center_m, domain_radius_m);
        let target = n_nodes.clamp(200, 100_000);
        let (mut border, mut interior, grading) = place(domain, inner_size_m, target);
        let chains = chains(cracks, &grading, &mut border);
        if !chains.edges.is_empty() {
            interior = clear_of(&interior, &chains, &border, &grading);
        }
        let nodes_m: Vec<[f64; 2]> = border
            .iter()
            .map(|node| node.position_m)
            .chain(chains.nodes_m)
            .chain(interior)
            .collect();
        let Faces {
            triangles,
            neighbors,
            is_crack,
        } = triangulate(&nodes_m, &chains.edges)?;
        let sides = Sides::new(nodes_m.len(), &triangles, &neighbors, &is_crack);
        let crack_edges = crack_edges(&triangles, &neighbors, &is_crack);
        Ok(Self {
            outline: *outline,
            nodes_m,
            triangles,
            neighbors,
            border,
            sides,
            crack_edges,
            inner_size_m: grading.size_at_m(center_m),
        })
    }

    /// Positions of the nodes, m.
    #[must_use]
    pub fn nodes(&self) -> &[[f64; 2]] {
        &self.nodes_m
    }

    /// Corners of the triangles.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The side of the cracks that each corner of each triangle lies on. A node has one side,
    /// with its own number, or, where cracks meet or reach the rim, one for each sector between
    /// them.
    #[must_use]
    pub fn sides(&self) -> &[[u32; 3]] {
        &self.sides.of_triangle
    }

    /// The node of each side.
    #[must_use]
    pub fn nodes_of_sides(&self) -> &[u32] {
        &self.sides.node_of
    }

    /// Edges that are cracks, by their nodes.
    #[must_use]
    pub fn crack_edges(&self) -> &[[u32; 2]] {
        &self.crack_edges
    }

    /// The rim of the pane that was meshed.
    #[must_use]
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Whether a node lies on the pane's rim.
    #[must_use]
    pub fn is_on_rim(&self, node: u32) -> bool {
        self.border
            .get(node as usize)
            .is_some_and(|node| node.is_on_rim)
    }

    /// Whether a node lies on the circle beyond which the pane is not meshed.
    #[must_use]
    pub fn is_on_cut(&self, node: u32) -> bool {
        self.border
            .get(node as usize)
            .is_some_and(|node| node.is_on_cut)
    }

    /// Number of nodes on the border; theirs are the first numbers.
    #[must_use]
    pub fn n_border_nodes(&self) -> usize {
        self.border.len()
    }

    /// Edges of the border, by their nodes, and their unit normals outwards.
    pub(crate) fn border_edges(&self) -> impl Iterator<Item = ([u32; 2], [f64; 2])> {
        let edges = self.triangles.iter().zip(&self.neighbors);
        let edges = edges.flat_map(|(nodes, neighbors)| {
            let outer = (0..3).filter(|&k| neighbors[k] == NONE);
            outer.map(|k| [nodes[(k + 1) % 3], nodes[(k + 2) % 3]])
        });
        edges.map(|edge| {
            let [from, to] = edge.map(|node| self.nodes_m[node as usize]);
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(dx, dy);
            (edge, [dy / length, -dx / length])
        })
    }

    /// Distance from a point to the border of the mesh, m.
    pub(crate) fn to_border_m(&self, [x, y]: [f64; 2]) -> f64 {
        let distance_m = |(edge, normal): ([u32; 2], [f64; 2])| {
            let [from, to] = edge.map(|node| self.nodes_m[node as usize]);
            let along = [-normal[1], normal[0]];
            let far = |from: [f64; 2]| (x - from[0]) * along[0] + (y - from[1]) * along[1];
            // Beyond an end by so much.
            let beyond = (-far(from)).max(far(to)).max(0.0);
            let off = (x - from[0]) * normal[0] + (y - from[1]) * normal[1];
            libm::hypot(off, beyond)
        };
        self.border_edges()
            .map(distance_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance between nodes at the center, m.
    #[must_use]
    pub fn inner_size_m(&self) -> f64 {
        self.inner_size_m
    }

    /// Positions of a triangle's corners, m.
    #[must_use]
    pub fn corners_m(&self, triangle: u32) -> [[f64; 2]; 3] {
        self.triangles[triangle as usize].map(|node| self.nodes_m[node as usize])
    }
}

/// Nodes of the border and inside it, about `target` in all: the number around is corrected by
/// the root of what is missing, for the count grows with its square.
fn place(domain: Domain, inner_m: f64, target: u32) -> (Vec<BorderNode>, Vec<[f64; 2]>, Grading) {
    let mut around = 40.0_f64;
    let mut best = None;
    let mut best_miss = f64::INFINITY;
    for _ in 0..8 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped"
        )]
        let n_around = around.round().clamp(12.0, 2000.0) as u32;
        let grading = Grading::new(domain, n_around, inner_m, target);
        let border = border(&grading);
        let interior = grading.interior();
        let ratio = (border.len() + interior.len()) as f64 / f64::from(target);
        let miss = libm::log(ratio).abs();
        if miss < best_miss {
            best_miss = miss;
            best = Some((border, interior, grading));
        }
        let next = (f64::from(n_around) / ratio.sqrt()).clamp(12.0, 2000.0);
        if miss < 0.05 || (next - f64::from(n_around)).abs() < 0.5 {
            break;
        }
        around = next;
    }
    best.unwrap_or_else(|| {
        let grading = Grading::new(domain, 40, inner_m, target);
        (border(&grading), grading.interior(), grading)
    })
}

/// Triangles, what lies opposite to their corners, and whether a crack is in between.
struct Faces {
    triangles: Vec<[u32; 3]>,
    neighbors: Vec<[u32; 3]>,
    is_crack: Vec<[bool; 3]>,
}

/// The triangles of the nodes, with edges along the cracks except where those cross. The domain is
/// convex, so its border is the hull of the nodes.
fn triangulate(nodes_m: &[[f64; 2]], cracks: &[[u32; 2]]) -> Result<Faces, FractureError> {
    let failed = |cause: String| FractureError::Triangulation {
        n_nodes: nodes_m.len(),
        cause,
    };
    let points = nodes_m.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points)
        .map_err(|cause| failed(cause.to_string()))?;
    if mesh.num_vertices() != nodes_m.len() || mesh.num_inner_faces() == 0 {
        return Err(failed(
            "two nodes at one place, or all on a line".to_owned(),
        ));
    }
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::from(mesh);
    for edge in cracks {
        let [from, to] = edge.map(|node| FixedVertexHandle::from_index(node as usize));
        if mesh.can_add_constraint(from, to) {
            mesh.add_constraint(from, to);
        }
    }
    let n = mesh.num_inner_faces();
    let mut faces = Faces {
        triangles: Vec::with_capacity(n),
        neighbors: Vec::with_capacity(n),
        is_crack: Vec::with_capacity(n),
    };
    for face in mesh.inner_faces() {
        // Edge k leaves corner k and lies opposite to corner k + 2.
        let edges = face.adjacent_edges();
        faces
            .triangles
            .push(edges.map(|edge| to_u32(edge.from().index())));
        faces.neighbors.push([1, 2, 0].map(|k| {
            let other: FixedFaceHandle<_> = edges[k].rev().face().fix();
            other.index().checked_sub(1).map_or(NONE, to_u32)
        }));
        faces
            .is_crack
            .push([1, 2, 0].map(|k| edges[k].is_constraint_edge()));
    }
    Ok(faces)
}

/// Edges between triangles that are cracks, each once.
fn crack_edges(
    triangles: &[[u32; 3]],
    neighbors: &[[u32; 3]],
    is_crack: &[[bool; 3]],
) -> Vec<[u32; 2]> {
    let mut edges = Vec::new();
    for ((t, nodes), (neighbors, is_crack)) in
        (0_u32..).zip(triangles).zip(neighbors.iter().zip(is_crack))
    {
        for k in 0..3 {
            if is_crack[k] && neighbors[k] != NONE && t < neighbors[k] {
                edges.push([nodes[(k + 1) % 3], nodes[(k + 2) % 3]]);
            }
        }
    }
    edges
}
