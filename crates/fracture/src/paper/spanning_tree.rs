//! Euclidean minimum spanning tree: Delaunay edges are enough [Toussaint1980], Kruskal picks.

use petgraph::unionfind::UnionFind;
use spade::{DelaunayTriangulation, HasPosition as _, Triangulation};

use crate::FractureError;
use crate::mesh::Indexed;

/// One edge of a spanning tree, by indices into the points it was made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeEdge {
    /// The lower index.
    pub a: u32,
    /// The higher index.
    pub b: u32,
    /// Distance between the two, in the unit of the points.
    pub length: f64,
}

/// The Euclidean minimum spanning tree of points, exact, shortest edge first; ties go to the
/// lower indices. Of points at the same place one is kept. O(n log n).
///
/// # Errors
/// [`FractureError::Triangulation`] if the triangulation library refuses the points.
///
/// # Example
/// ```
/// use starbreak_fracture::paper::euclidean_spanning_tree;
/// let tree = euclidean_spanning_tree(&[[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])?;
/// assert_eq!(tree.iter().map(|edge| edge.length).sum::<f64>(), 7.0);
/// # Ok::<(), starbreak_fracture::FractureError>(())
/// ```
pub fn euclidean_spanning_tree(points: &[[f64; 2]]) -> Result<Vec<TreeEdge>, FractureError> {
    let indexed = (0_u32..)
        .zip(points)
        .map(|(idx, &point)| Indexed::new(idx, point));
    let triangulation: DelaunayTriangulation<Indexed> =
        DelaunayTriangulation::bulk_load(indexed.collect()).map_err(|cause| {
            FractureError::Triangulation {
                n_nodes: points.len(),
                cause: cause.to_string(),
            }
        })?;
    let mut edges: Vec<(u64, u32, u32)> = triangulation
        .undirected_edges()
        .map(|edge| {
            let [from, to] = edge.vertices();
            let (a, b) = (from.data(), to.data());
            let (dx, dy) = (
                a.position().x - b.position().x,
                a.position().y - b.position().y,
            );
            // Bits of a positive number sort like the number.
            (
                (dx * dx + dy * dy).to_bits(),
                a.idx.min(b.idx),
                a.idx.max(b.idx),
            )
        })
        .collect();
    edges.sort_unstable();
    let mut clusters = UnionFind::<u32>::new(points.len());
    let mut tree = Vec::with_capacity(points.len().saturating_sub(1));
    for (length2, a, b) in edges {
        if clusters.union(a, b) {
            tree.push(TreeEdge {
                a,
                b,
                length: f64::from_bits(length2).sqrt(),
            });
        }
    }
    Ok(tree)
}
