//! A thin plate under a load across it.

use super::dkt::{
    AXES, Element, Frame, N_LOCAL, N_PACKED, Rigidity, cracked, deflection, isotropic,
};
use super::recovery::NodalStress;
use super::sparse::System;
use super::{PlaneStress, load};
use crate::FractureError;
use crate::mesh::{Outline, PlateMesh};
use crate::physics::Support;

/// Greatest residual, relative to the terms of the equations, that counts as solved.
const MAX_RESIDUAL: f64 = 1e-9;

/// What a plate is made of and what it lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateProperties {
    /// Thickness h, m.
    pub thickness_m: f64,
    /// Young's modulus E, Pa.
    pub young_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Pressure per deflection k of the elastic foundation (Winkler), Pa/m; 0 for none.
    pub foundation_pa_m: f64,
}

impl PlateProperties {
    /// Bending stiffness D = E h³ / 12(1 − ν²), N m.
    #[must_use]
    pub fn rigidity_n_m(&self) -> f64 {
        self.young_modulus_pa * self.thickness_m.powi(3)
            / (12.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }

    fn check(&self) -> Result<(), FractureError> {
        let positive = |value: f64| value > 0.0 && value < 1e300;
        let checks = [
            (
                "thickness_m",
                self.thickness_m,
                positive(self.thickness_m),
                "> 0",
            ),
            (
                "young_modulus_pa",
                self.young_modulus_pa,
                positive(self.young_modulus_pa),
                "> 0",
            ),
            (
                "poisson_ratio",
                self.poisson_ratio,
                self.poisson_ratio > -1.0 && self.poisson_ratio <= 0.5,
                "-1 to 0.5",
            ),
            (
                "foundation_pa_m",
                self.foundation_pa_m,
                (0.0..1e300).contains(&self.foundation_pa_m),
                "0 or more",
            ),
        ];
        for (name, value, is_right, expected) in checks {
            if !is_right {
                return Err(FractureError::Parameter {
                    name,
                    value,
                    expected,
                });
            }
        }
        Ok(())
    }
}

/// A crack through a triangle, which loses its stiffness with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hinge {
    /// The triangle.
    pub triangle: u32,
    /// Normal of the crack, not zero. The stiffness is lost in all directions, so that it does not
    /// change the result yet.
    pub normal: [f64; 2],
    /// What remains of the stiffness, 1e-9 to 1.
    pub residual: f64,
}

/// The part of the plate that moves, while a wave has not come farther.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveDisc {
    /// Its center, m.
    pub center_m: [f64; 2],
    /// Its radius, m.
    pub radius_m: f64,
}

/// A force spread evenly over a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchLoad {
    /// Center of the disc, m.
    pub center_m: [f64; 2],
    /// Its radius, m; 0 for a force at a point.
    pub radius_m: f64,
    /// The force, N, in the direction of the hit.
    pub force_n: f64,
}

/// A face of the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// The one away from the hit.
    Back,
    /// The one that is hit.
    Front,
}

/// A plate with its mesh: factored once, then solved for as many loads as there are.
pub struct PlateSolver {
    mesh: PlateMesh,
    plate: PlateProperties,
    frames: Vec<Frame>,
    elements: Vec<Element>,
    intact: Vec<[f64; N_PACKED]>,
    foundation: Vec<f64>,
    is_held: Vec<[bool; 3]>,
    /// As of the last factor.
    is_fixed: Vec<[bool; 3]>,
    /// Triangles with hinges and their rigidity, in the order of triangles, as of the last factor.
    cracked: Vec<(u32, Rigidity)>,
    system: System,
}

impl PlateSolver {
    /// The plate on its support, intact and active as a whole.
    ///
    /// A simply supported rim has w = 0, and along it no slope either (at nodes; of a disc along
    /// the true circle). Where the mesh ends within the pane, it is clamped.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] for properties that no plate has, [`FractureError::Solver`]
    /// if the equations cannot be factored.
    pub fn new(
        mesh: PlateMesh,
        plate: PlateProperties,
        support: Support,
    ) -> Result<Self, FractureError> {
        plate.check()?;
        let rigidity = isotropic(plate.rigidity_n_m(), plate.poisson_ratio);
        let (frames, is_held) = supported(&mesh, support);
        let elements = elements(&mesh, &frames);
        let intact: Vec<_> = elements.iter().map(|e| e.stiffness(&rigidity)).collect();
        let mut foundation = vec![0.0; mesh.nodes().len()];
        for (triangle, element) in mesh.triangles().iter().zip(&elements) {
            for &node in triangle {
                foundation[node as usize] += plate.foundation_pa_m * element.area_m2 / 3.0;
            }
        }
        let system = System::new(mesh.nodes().len(), mesh.triangles())?;
        let mut solver = Self {
            mesh,
            plate,
            frames,
            elements,
            intact,
            foundation,
            is_fixed: is_held.clone(),
            is_held,
            cracked: Vec::new(),
            system,
        };
        solver.factor(&[], None)?;
        Ok(solver)
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &PlateMesh {
        &self.mesh
    }

    /// The plate's properties.
    #[must_use]
    pub fn properties(&self) -> &PlateProperties {
        &self.plate
    }

    /// Factors the plate anew, with these cracks and clamped outside of the active disc.
    ///
    /// # Errors
    /// [`FractureError::Solver`] if the equations cannot be factored,
    /// [`FractureError::Parameter`] for a hinge or disc that is none.
    pub fn factor(
        &mut self,
        hinges: &[Hinge],
        active: Option<ActiveDisc>,
    ) -> Result<(), FractureError> {
        self.cracked = self.cracked_rigidities(hinges)?;
        self.is_fixed.clone_from(&self.is_held);
        if let Some(disc) = active {
            if !(disc.radius_m >= 0.0 && disc.center_m.iter().all(|x| x.is_finite())) {
                return Err(FractureError::Parameter {
                    name: "active radius_m",
                    value: disc.radius_m,
                    expected: "0 or more, around a finite center",
                });
            }
            for (fixed, [x, y]) in self.is_fixed.iter_mut().zip(self.mesh.nodes()) {
                if libm::hypot(x - disc.center_m[0], y - disc.center_m[1]) > disc.radius_m {
                    *fixed = [true; 3];
                }
            }
        }
        let weakened: Vec<(u32, [f64; N_PACKED])> = self
            .cracked
            .iter()
            .map(|(t, rigidity)| (*t, self.elements[*t as usize].stiffness(rigidity)))
            .collect();
        let mut next = weakened.iter().peekable();
        let packed = (0_u32..).zip(&self.intact).map(|(t, intact)| {
            match next.next_if(|(cracked, _)| *cracked == t) {
                Some((_, packed)) => packed,
                None => intact,
            }
        });
        self.system.factor(packed, &self.foundation, &self.is_fixed)
    }

    fn cracked_rigidities(&self, hinges: &[Hinge]) -> Result<Vec<(u32, Rigidity)>, FractureError> {
        let intact = isotropic(self.plate.rigidity_n_m(), self.plate.poisson_ratio);
        let mut sorted: Vec<&Hinge> = hinges.iter().collect();
        sorted.sort_by_key(|hinge| hinge.triangle);
        let mut weak: Vec<(u32, Rigidity)> = Vec::new();
        for hinge in sorted {
            let length = libm::hypot(hinge.normal[0], hinge.normal[1]);
            let is_right = (hinge.triangle as usize) < self.elements.len()
                && length > 0.0
                && length.is_finite()
                && (1e-9..=1.0).contains(&hinge.residual);
            if !is_right {
                return Err(FractureError::Parameter {
                    name: "hinge residual",
                    value: hinge.residual,
                    expected: "1e-9 to 1, in a triangle of the mesh, with a normal",
                });
            }
            match weak.last_mut() {
                // A second crack takes nothing more.
                Some((t, _)) if *t == hinge.triangle => (),
                _ => weak.push((hinge.triangle, cracked(&intact, hinge.residual))),
            }
        }
        Ok(weak)
    }

    /// Deflection and stress under a load. What of its disc lies off the mesh is taken by the
    /// rest of it, so that the force is kept.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] for a load that is none or misses the mesh,
    /// [`FractureError::Residual`] if the solution does not solve the equations.
    pub fn solve(&self, load: &PatchLoad) -> Result<PlateField, FractureError> {
        let mut forces = load::patch(&self.mesh, &self.frames, load)?;
        for (force, fixed) in forces.iter_mut().zip(&self.is_fixed) {
            for c in 0..3 {
                if fixed[c] {
                    force[c] = 0.0;
                }
            }
        }
        let unknowns = solved(&self.system, &forces)?;
        let work: f64 = forces
            .iter()
            .zip(&unknowns)
            .map(|(f, u)| f[0] * u[0] + f[1] * u[1] + f[2] * u[2])
            .sum();
        let rigidity = isotropic(self.plate.rigidity_n_m(), self.plate.poisson_ratio);
        let factor = -6.0 / (self.plate.thickness_m * self.plate.thickness_m);
        let back = NodalStress::recover(
            &self.mesh,
            &self.elements,
            &unknowns,
            &rigidity,
            &self.cracked,
            |[xx, yy, xy]| PlaneStress {
                xx_pa: factor * xx,
                yy_pa: factor * yy,
                xy_pa: factor * xy,
            },
        );
        Ok(PlateField {
            energy_j: 0.5 * work,
            unknowns,
            frames: self.frames.clone(),
            back,
        })
    }
}

/// The unknowns of a system, or why they are none.
pub(super) fn solved(system: &System, load: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, FractureError> {
    let solution = system.solve(load)?;
    if solution.relative_residual <= MAX_RESIDUAL {
        Ok(solution.by_node)
    } else {
        Err(FractureError::Residual {
            residual: solution.relative_residual,
            limit: MAX_RESIDUAL,
        })
    }
}

/// Elements of a mesh whose nodes have these frames.
pub(super) fn elements(mesh: &PlateMesh, frames: &[Frame]) -> Vec<Element> {
    (0..)
        .zip(mesh.triangles())
        .map(|(t, nodes)| Element::new(&mesh.corners_m(t), &nodes.map(|n| frames[n as usize])))
        .collect()
}

/// Frames of the nodes (on the rim: along it and across) and which unknowns are held.
fn supported(mesh: &PlateMesh, support: Support) -> (Vec<Frame>, Vec<[bool; 3]>) {
    let n = mesh.nodes().len();
    let mut frames = vec![AXES; n];
    let mut is_held = vec![[false; 3]; n];
    for (node, &[x, y]) in (0_u32..).zip(&mesh.nodes()[..mesh.n_border_nodes()]) {
        let idx = node as usize;
        if mesh.is_on_cut(node) || support == Support::Clamped {
            is_held[idx] = [true; 3];
            continue;
        }
        is_held[idx] = [true, true, false];
        #[expect(clippy::float_cmp, reason = "on a side means exactly on it")]
        match *mesh.outline() {
            Outline::Rectangle { width_m, height_m } => {
                let is_across = x == 0.0 || x == width_m;
                if is_across {
                    frames[idx] = [[0.0, 1.0], [1.0, 0.0]];
                }
                is_held[idx][2] = is_across && (y == 0.0 || y == height_m);
            }
            Outline::Disc { diameter_m } => {
                let (dx, dy) = (x - 0.5 * diameter_m, y - 0.5 * diameter_m);
                let r = libm::hypot(dx, dy);
                frames[idx] = [[-dy / r, dx / r], [dx / r, dy / r]];
            }
        }
    }
    (frames, is_held)
}

/// How a plate bends under a load.
#[derive(Debug, Clone)]
pub struct PlateField {
    /// Strain energy of plate and foundation, which is half of the work of the load, J.
    pub energy_j: f64,
    unknowns: Vec<[f64; 3]>,
    frames: Vec<Frame>,
    back: NodalStress,
}

impl PlateField {
    /// Deflection at a node, m, positive in the direction of the load.
    #[must_use]
    pub fn deflection_m(&self, node: u32) -> f64 {
        self.unknowns[node as usize][0]
    }

    /// Deflection at a point, m; `None` off the mesh.
    pub fn deflection_at_m(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        hint: &mut u32,
    ) -> Option<f64> {
        let (triangle, l) = mesh.locate(point, hint)?;
        let nodes = mesh.triangles()[triangle as usize];
        let frames = nodes.map(|node| self.frames[node as usize]);
        let row = deflection(&mesh.corners_m(triangle), &frames, &l);
        Some(
            (0..N_LOCAL)
                .map(|k| row[k] * self.unknowns[nodes[k / 3] as usize][k % 3])
                .sum(),
        )
    }

    /// Bending stress on a face at a node.
    #[must_use]
    pub fn surface_stress(&self, node: u32, face: Face) -> PlaneStress {
        on_face(self.back.at_node(node), face)
    }

    /// Bending stress σ = 6M/h² on a face at a point; `None` off the mesh.
    pub fn surface_stress_at(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        face: Face,
        hint: &mut u32,
    ) -> Option<PlaneStress> {
        self.back
            .at(mesh, point, hint)
            .map(|stress| on_face(stress, face))
    }
}

fn on_face(back: PlaneStress, face: Face) -> PlaneStress {
    match face {
        Face::Back => back,
        Face::Front => PlaneStress::default().plus(&back, -1.0),
    }
}
