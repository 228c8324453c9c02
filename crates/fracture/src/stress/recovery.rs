//! Stress at nodes from that within triangles.

use super::PlaneStress;
use super::dkt::{Element, N_LOCAL, Rigidity};
use crate::mesh::PlateMesh;

/// Stress at the sides of the nodes of a mesh, linear in between.
#[derive(Debug, Clone)]
pub(super) struct NodalStress {
    by_side: Vec<PlaneStress>,
}

impl NodalStress {
    /// Means over the triangles around each node that lie on one side of the cracks through it,
    /// weighted by area. `stress` makes a stress of D κ.
    pub(super) fn recover(
        mesh: &PlateMesh,
        elements: &[Element],
        unknowns: &[[f64; 3]],
        rigidity: &Rigidity,
        stress: impl Fn([f64; 3]) -> PlaneStress,
    ) -> Self {
        let mut sums = vec![[0.0; 4]; mesh.nodes_of_sides().len()];
        for (sides, element) in mesh.sides().iter().zip(elements) {
            let mut local = [0.0; N_LOCAL];
            for (k, &side) in sides.iter().enumerate() {
                local[3 * k..3 * k + 3].copy_from_slice(&unknowns[side as usize]);
            }
            let mid = element.curvatures(&local);
            for (k, &side) in sides.iter().enumerate() {
                // κ is linear in the triangle.
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let curvature = [0, 1, 2].map(|c| mid[i][c] + mid[j][c] - mid[k][c]);
                let sum = &mut sums[side as usize];
                for (row, total) in rigidity.iter().zip(sum.iter_mut()) {
                    let moment =
                        row[0] * curvature[0] + row[1] * curvature[1] + row[2] * curvature[2];
                    *total += element.area_m2 * moment;
                }
                sum[3] += element.area_m2;
            }
        }
        let by_side = sums
            .iter()
            .map(|[xx, yy, xy, area]| stress([xx / area, yy / area, xy / area]))
            .collect();
        Self { by_side }
    }

    pub(super) fn at_side(&self, side: u32) -> PlaneStress {
        self.by_side[side as usize]
    }

    pub(super) fn at(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        hint: &mut u32,
    ) -> Option<PlaneStress> {
        let (triangle, l) = mesh.locate(point, hint)?;
        let sides = mesh.sides()[triangle as usize];
        let sum = sides
            .iter()
            .zip(l)
            .fold(PlaneStress::default(), |sum, (&side, l)| {
                sum.plus(&self.by_side[side as usize], l)
            });
        Some(sum)
    }
}
