//! Stress at nodes from that within triangles.

use super::PlaneStress;
use super::dkt::{Element, N_LOCAL, Rigidity};
use crate::mesh::PlateMesh;

/// Stress at the nodes of a mesh, linear in between.
#[derive(Debug, Clone)]
pub(super) struct NodalStress {
    by_node: Vec<PlaneStress>,
}

impl NodalStress {
    /// Means over the triangles around each node, weighted by area. Triangles with cracks count
    /// only where a node has no other. `stress` makes a stress of D κ.
    pub(super) fn recover(
        mesh: &PlateMesh,
        elements: &[Element],
        unknowns: &[[f64; 3]],
        rigidity: &Rigidity,
        cracked: &[(u32, Rigidity)],
        stress: impl Fn([f64; 3]) -> PlaneStress,
    ) -> Self {
        let n = mesh.nodes().len();
        // Of intact triangles, and of cracked ones.
        let mut sums = [vec![[0.0; 4]; n], vec![[0.0; 4]; n]];
        let mut next = cracked.iter().peekable();
        for ((t, nodes), element) in (0_u32..).zip(mesh.triangles()).zip(elements) {
            let of_crack = next.next_if(|(triangle, _)| *triangle == t);
            let rigidity = of_crack.map_or(rigidity, |(_, rigidity)| rigidity);
            let sums = &mut sums[usize::from(of_crack.is_some())];
            let mut local = [0.0; N_LOCAL];
            for (k, &node) in nodes.iter().enumerate() {
                local[3 * k..3 * k + 3].copy_from_slice(&unknowns[node as usize]);
            }
            let mid = element.curvatures(&local);
            for (k, &node) in nodes.iter().enumerate() {
                // κ is linear in the triangle.
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let curvature = [0, 1, 2].map(|c| mid[i][c] + mid[j][c] - mid[k][c]);
                let sum = &mut sums[node as usize];
                for (row, total) in rigidity.iter().zip(sum.iter_mut()) {
                    let moment =
                        row[0] * curvature[0] + row[1] * curvature[1] + row[2] * curvature[2];
                    *total += element.area_m2 * moment;
                }
                sum[3] += element.area_m2;
            }
        }
        let [intact, broken] = sums;
        let by_node = intact
            .iter()
            .zip(&broken)
            .map(|(intact, broken)| {
                let [xx, yy, xy, area] = if intact[3] > 0.0 { intact } else { broken };
                stress([xx / area, yy / area, xy / area])
            })
            .collect();
        Self { by_node }
    }

    pub(super) fn at_node(&self, node: u32) -> PlaneStress {
        self.by_node[node as usize]
    }

    pub(super) fn at(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        hint: &mut u32,
    ) -> Option<PlaneStress> {
        let (triangle, l) = mesh.locate(point, hint)?;
        let nodes = mesh.triangles()[triangle as usize];
        let sum = nodes
            .iter()
            .zip(l)
            .fold(PlaneStress::default(), |sum, (&node, l)| {
                sum.plus(&self.by_node[node as usize], l)
            });
        Some(sum)
    }
}
