//! Stress in the plane of a free pane that is warm in places.

use super::PlaneStress;
use super::dkt::{AXES, N_LOCAL, isotropic};
use super::plate::{elements, solved};
use super::recovery::NodalStress;
use super::sparse::System;
use crate::FractureError;
use crate::mesh::PlateMesh;

/// Thermal expansion of soda-lime glass, 1/K \[EN2012\].
pub const EXPANSION_PER_K: f64 = 9e-6;

/// What thermal strain does to a plate in its plane.
#[derive(Debug, Clone)]
pub struct MembraneField {
    /// Elastic energy per thickness, J/m.
    pub energy_j_m: f64,
    stress: NodalStress,
}

impl MembraneField {
    /// Stress at a node.
    #[must_use]
    pub fn stress(&self, node: u32) -> PlaneStress {
        self.stress.at_side(node)
    }

    /// Stress at a point; `None` off the mesh.
    pub fn stress_at(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        hint: &mut u32,
    ) -> Option<PlaneStress> {
        self.stress.at(mesh, point, hint)
    }
}

/// Plane stress of a pane with a free rim whose temperature is `temperature_k` over that at which
/// it is free of stress.
///
/// The stress follows from Airy's function φ, σ_xx = φ_yy, σ_yy = φ_xx, σ_xy = −φ_xy, which on a
/// free rim is zero with its normal derivative: the least of the complementary energy
/// ∫ (σ·S·σ/2 + αT (σ_xx + σ_yy)) dA is a clamped plate of stiffness 1/E and Poisson's ratio −ν
/// under the load −α ∫ T ∇²φ \[Boley1960\]. So the element of the plate serves here, too; the pane
/// must have no hole, and rigid motions do not come up.
///
/// # Errors
/// [`FractureError::Parameter`] for a material that is none or a mesh with cracks or of only a
/// part of the pane,
/// [`FractureError::Residual`] or [`FractureError::Solver`] if the equations are not solved.
pub fn membrane_stress(
    mesh: &PlateMesh,
    young_modulus_pa: f64,
    poisson_ratio: f64,
    expansion_per_k: f64,
    temperature_k: impl Fn([f64; 2]) -> f64,
) -> Result<MembraneField, FractureError> {
    let n = mesh.nodes().len();
    let is_cut = (0..)
        .take(mesh.n_border_nodes())
        .any(|node| mesh.is_on_cut(node));
    for (name, value, is_right) in [
        (
            "young_modulus_pa",
            young_modulus_pa,
            young_modulus_pa > 0.0 && young_modulus_pa < 1e300,
        ),
        (
            "poisson_ratio",
            poisson_ratio,
            poisson_ratio > -1.0 && poisson_ratio <= 0.5,
        ),
        (
            "expansion_per_k",
            expansion_per_k,
            expansion_per_k.is_finite(),
        ),
        ("mesh radius", 0.0, !is_cut),
        ("cracks", 0.0, mesh.nodes_of_sides().len() == n),
    ] {
        if !is_right {
            return Err(FractureError::Parameter {
                name,
                value,
                expected: "an elastic material, on a mesh of the whole pane without cracks".into(),
            });
        }
    }
    let frames = vec![AXES; n];
    let elements = elements(mesh, &frames);
    // In units of 1/E, so that φ stands for φ/E.
    let compliance = isotropic(1.0, -poisson_ratio);
    let packed: Vec<_> = elements.iter().map(|e| e.stiffness(&compliance)).collect();
    let mut is_fixed = vec![[false; 3]; n];
    is_fixed[..mesh.n_border_nodes()].fill([true; 3]);
    let system = System::factored(mesh, packed.iter(), &[], &is_fixed)?;

    let mut load = vec![[0.0; 3]; n];
    for ((t, nodes), element) in (0_u32..).zip(mesh.triangles()).zip(&elements) {
        let corners = mesh.corners_m(t);
        for (k, rows) in element.mid_edge.iter().enumerate() {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let temperature = temperature_k([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            if !temperature.is_finite() {
                return Err(FractureError::Parameter {
                    name: "temperature_k",
                    value: temperature,
                    expected: "finite everywhere".into(),
                });
            }
            let weight = -expansion_per_k * temperature * element.area_m2 / 3.0;
            for dof in 0..N_LOCAL {
                load[nodes[dof / 3] as usize][dof % 3] += weight * (rows[0][dof] + rows[1][dof]);
            }
        }
    }
    for (load, fixed) in load.iter_mut().zip(&is_fixed) {
        if fixed[0] {
            *load = [0.0; 3];
        }
    }
    let potential = solved(&system, &load)?;
    let work: f64 = load
        .iter()
        .zip(&potential)
        .map(|(f, u)| f[0] * u[0] + f[1] * u[1] + f[2] * u[2])
        .sum();
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]];
    let stress = NodalStress::recover(mesh, &elements, &potential, &unit, |[xx, yy, xy]| {
        PlaneStress {
            xx_pa: young_modulus_pa * yy,
            yy_pa: young_modulus_pa * xx,
            xy_pa: -young_modulus_pa * xy,
        }
    });
    Ok(MembraneField {
        energy_j_m: 0.5 * young_modulus_pa * work,
        stress,
    })
}
