//! Nodes on cracks, as many times as there are sectors between the cracks that meet there.

use super::particles::to_u32;
use super::plate_mesh::NONE;

/// Which side of the cracks through its corners a triangle lies on.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// The side at each corner of each triangle.
    pub(super) of_triangle: Vec<[u32; 3]>,
    /// The node of each side; the first side of a node has the number of the node.
    pub(super) node_of: Vec<u32>,
}

impl Sides {
    /// Sectors around each node: triangles that follow each other without a crack in between.
    /// `is_crack` tells of the edge opposite to each corner.
    pub(super) fn new(
        n_nodes: usize,
        triangles: &[[u32; 3]],
        neighbors: &[[u32; 3]],
        is_crack: &[[bool; 3]],
    ) -> Self {
        let mut node_of: Vec<u32> = (0..to_u32(n_nodes)).collect();
        let mut of_triangle = vec![[NONE; 3]; triangles.len()];
        let mut is_met = vec![false; n_nodes];
        let corner = |t: u32, node: u32| triangles[t as usize].iter().position(|&n| n == node);
        for t in 0..to_u32(triangles.len()) {
            for k in 0..3 {
                if of_triangle[t as usize][k] != NONE {
                    continue;
                }
                let node = triangles[t as usize][k];
                let side = if std::mem::replace(&mut is_met[node as usize], true) {
                    node_of.push(node);
                    to_u32(node_of.len() - 1)
                } else {
                    node
                };
                // Both ways around the node, up to a crack or the border.
                for turn in [1, 2] {
                    let (mut at, mut own) = (t, k);
                    loop {
                        of_triangle[at as usize][own] = side;
                        let edge = (own + turn) % 3;
                        let next = neighbors[at as usize][edge];
                        if next == NONE || is_crack[at as usize][edge] {
                            break;
                        }
                        let Some(found) = corner(next, node) else {
                            break;
                        };
                        if of_triangle[next as usize][found] != NONE {
                            break;
                        }
                        (at, own) = (next, found);
                    }
                }
            }
        }
        Self {
            of_triangle,
            node_of,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six triangles around node 0, the rim counted 1 to 6; triangle k has corners 0, k+1, k+2.
    fn fan(cracks: &[u32]) -> Sides {
        let ring = |k: u32| k % 6;
        let triangles: Vec<[u32; 3]> = (0..6).map(|k| [0, ring(k) + 1, ring(k + 1) + 1]).collect();
        let neighbors: Vec<[u32; 3]> = (0..6).map(|k| [NONE, ring(k + 1), ring(k + 5)]).collect();
        let has = |node: u32| cracks.contains(&node);
        let is_crack: Vec<[bool; 3]> = triangles
            .iter()
            .map(|&[_, b, c]| [false, has(c), has(b)])
            .collect();
        Sides::new(7, &triangles, &neighbors, &is_crack)
    }

    #[test]
    fn a_node_has_a_side_for_each_sector() {
        for (cracks, n_center, n_rim) in [
            (&[][..], 1, 6),
            (&[2], 1, 7),
            (&[1, 4], 2, 8),
            (&[1, 3, 5], 3, 9),
            (&[1, 2, 3, 4, 5, 6], 6, 12),
        ] {
            let sides = fan(cracks);
            let count = |is: &dyn Fn(u32) -> bool| sides.node_of.iter().filter(|&&n| is(n)).count();
            assert_eq!(count(&|n| n == 0), n_center, "center, cracks to {cracks:?}");
            assert_eq!(count(&|n| n > 0), n_rim, "rim, cracks to {cracks:?}");
        }
        let sides = fan(&[1, 4]);
        let center = |t: usize| sides.of_triangle[t][0];
        assert_eq!([center(0), center(1), center(2)], [0; 3], "one side");
        assert_eq!([center(3), center(4), center(5)], [7; 3], "the other one");
    }
}
