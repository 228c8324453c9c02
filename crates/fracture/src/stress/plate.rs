//! A thin plate under a load across it.

use std::sync::Arc;

use super::dkt::{AXES, Element, Frame, N_LOCAL, Rigidity, deflection, isotropic, moments};
use super::near_load::NearLoad;
use super::recovery::NodalStress;
use super::sparse::System;
use super::{PlaneStress, load};
use crate::FractureError;
use crate::mesh::{Outline, PlateMesh};
use crate::params::Support;

/// Greatest residual, relative to the terms of the equations, that counts as solved.
const MAX_RESIDUAL: f64 = 1e-9;

/// Foundation of a cracked plate, in D over the fourth power of its size. Hinges may leave parts
/// that nothing holds, such as the sectors of a star that has come to a simply supported rim. This
/// stands for their inertia, which is spread over them as a foundation's pressure is; a plate that
/// is held gives way by less than 1e-5 of its deflection less.
const INERTIA: f64 = 1e-3;

/// Part of the stiffness that cracked triangles keep as if they were not cracked, so that the
/// equations have a solution where cracks leave single triangles.
const REMAINDER: f64 = 1e-9;

/// Radius over which what is sharp under a load is spread, over its distance from the border. More
/// makes it smoother, and what the border does about it larger far away; beside meshes of 90,000 nodes
/// the stress was nearest with 3 to 6.
const SPREAD: f64 = 4.0;

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
        let h = self.thickness_m;
        self.young_modulus_pa * (h * h * h)
            / (12.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }

    fn rigidity(&self) -> Rigidity {
        isotropic(self.rigidity_n_m(), self.poisson_ratio)
    }

    /// The bending stress on the back that D κ stands for.
    fn back_stress(&self, [xx, yy, xy]: [f64; 3]) -> PlaneStress {
        let factor = -6.0 / (self.thickness_m * self.thickness_m);
        PlaneStress {
            xx_pa: factor * xx,
            yy_pa: factor * yy,
            xy_pa: factor * xy,
        }
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
                    expected: expected.into(),
                });
            }
        }
        Ok(())
    }
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
    mesh: Arc<PlateMesh>,
    plate: PlateProperties,
    frames: Vec<Frame>,
    elements: Vec<Element>,
    is_held: Vec<[bool; 3]>,
    system: System,
}

impl PlateSolver {
    /// The plate on its support.
    ///
    /// A simply supported rim has w = 0, and along it no slope either (at nodes; of a disc along
    /// the true circle). Where the mesh ends within the pane, it is clamped.
    ///
    /// Cracks of the mesh are hinges: their faces touch, so that w is one on both sides and shear
    /// passes, but each side has its own slope and no moment passes. Both components of the slope
    /// are free, as the deflection at the nodes holds the faces together; a line with bends, held
    /// together all along, could not fold.
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
        let rigidity = plate.rigidity();
        let (frames, mut is_held) = supported(&mesh, support);
        for &node in &mesh.nodes_of_sides()[mesh.nodes().len()..] {
            let [_, along, across] = is_held[node as usize];
            is_held.push([true, along, across]);
        }
        let elements = elements(&mesh, &frames);
        let mut stiffness: Vec<_> = elements.iter().map(|e| e.stiffness(&rigidity)).collect();
        let corners = mesh.triangles().iter().zip(mesh.sides()).enumerate();
        for (t, _) in corners.filter(|(_, (nodes, sides))| nodes != sides) {
            stiffness.push(stiffness[t].map(|entry| REMAINDER * entry));
        }
        let mut pressure_pa_m = plate.foundation_pa_m;
        if mesh.nodes_of_sides().len() > mesh.nodes().len() {
            let area_m2 = extent_m(&mesh) * extent_m(&mesh);
            pressure_pa_m = pressure_pa_m.max(INERTIA * plate.rigidity_n_m() / (area_m2 * area_m2));
        }
        let mut foundation = vec![0.0; mesh.nodes().len()];
        for (triangle, element) in mesh.triangles().iter().zip(&elements) {
            for &node in triangle {
                foundation[node as usize] += pressure_pa_m * element.area_m2 / 3.0;
            }
        }
        let system = System::factored(&mesh, stiffness.iter(), &foundation, &is_held)?;
        Ok(Self {
            mesh: Arc::new(mesh),
            plate,
            frames,
            elements,
            is_held,
            system,
        })
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &PlateMesh {
        &self.mesh
    }

    /// The mesh, for a field that outlives the solver.
    pub(crate) fn shared_mesh(&self) -> Arc<PlateMesh> {
        Arc::clone(&self.mesh)
    }

    /// The plate's properties.
    #[must_use]
    pub fn properties(&self) -> &PlateProperties {
        &self.plate
    }

    /// Deflection and stress under a load. What of its disc lies off the mesh is taken by the
    /// rest of it, so that the force is kept.
    ///
    /// Of a whole plate without a foundation, under a load on a disc away from the rim, the mesh has
    /// to find only what is smooth; what is sharp under the load is known in closed form.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] for a load that is none or misses the mesh,
    /// [`FractureError::Residual`] if the solution does not solve the equations.
    pub fn solve(&self, load: &PatchLoad) -> Result<PlateField, FractureError> {
        let patch = load::patch(&self.mesh, &self.frames, load)?;
        let near = self.near_load(load);
        let (mut forces, held) = match &near {
            Some(near) => self.beside(near),
            None => (patch.clone(), Vec::new()),
        };
        for (force, fixed) in forces.iter_mut().zip(&self.is_held) {
            for c in 0..3 {
                if fixed[c] {
                    force[c] = 0.0;
                }
            }
        }
        let mut unknowns = solved(&self.system, &forces)?;
        for (node, unknown, value) in held {
            unknowns[node as usize][unknown] = value;
        }
        let mut work: f64 = patch
            .iter()
            .zip(&unknowns)
            .map(|(f, u)| f[0] * u[0] + f[1] * u[1] + f[2] * u[2])
            .sum();
        if let Some(near) = &near {
            work += load.force_n * near.mean_under_load_m();
        }
        // From here on each side has the deflection of its node.
        for (side, &node) in self.mesh.nodes_of_sides().iter().enumerate() {
            unknowns[side][0] = unknowns[node as usize][0];
        }
        let rigidity = self.plate.rigidity();
        let back =
            NodalStress::recover(&self.mesh, &self.elements, &unknowns, &rigidity, |moment| {
                self.plate.back_stress(moment)
            });
        Ok(PlateField {
            energy_j: 0.5 * work,
            unknowns,
            frames: self.frames.clone(),
            back,
            near: near.map(|near| (near, self.plate)),
        })
    }

    /// What is sharp under the load, where the rest is smooth.
    fn near_load(&self, load: &PatchLoad) -> Option<NearLoad> {
        let mesh = &self.mesh;
        let is_whole = mesh.nodes_of_sides().len() == mesh.nodes().len();
        if !is_whole || self.plate.foundation_pa_m > 0.0 {
            return None;
        }
        let to_border_m = mesh.to_border_m(load.center_m);
        // A force at a point is left to the mesh.
        let is_disc = load.radius_m > 1e-9 * to_border_m;
        let near = || NearLoad::new(load, SPREAD * to_border_m, self.plate.rigidity_n_m());
        (is_disc && to_border_m > load.radius_m).then(near)
    }

    /// What the mesh has to find beside what is sharp under a load: forces at its nodes, and what
    /// is held. With both together nothing moves where the plate is held, and no
    /// moment acts across a rim that may turn.
    fn beside(&self, near: &NearLoad) -> (Vec<[f64; 3]>, Vec<Held>) {
        let mesh = &self.mesh;
        let mut forces = load::spread(mesh, &self.frames, &self.elements, near);
        let mut held = Vec::new();
        let mut values = vec![[0.0; 3]; mesh.n_border_nodes()];
        for ((node, values), held_here) in (0..).zip(&mut values).zip(&self.is_held) {
            let idx = node as usize;
            let (w_m, gradient, _) = near.at(mesh.nodes()[idx]);
            let [along, across] = self.frames[idx].map(|axis| dot(axis, gradient));
            for (unknown, of_near) in [w_m, along, across].into_iter().enumerate() {
                if held_here[unknown] && of_near != 0.0 {
                    values[unknown] = -of_near;
                    held.push((node, unknown, -of_near));
                }
            }
        }
        let rigidity = self.plate.rigidity();
        for (nodes, element) in mesh.triangles().iter().zip(&self.elements) {
            let of = |node: u32| values.get(node as usize).copied().unwrap_or_default();
            let local: [f64; N_LOCAL] = std::array::from_fn(|k| of(nodes[k / 3])[k % 3]);
            if local.iter().all(|value| *value == 0.0) {
                continue;
            }
            for (k, force) in element.forces(&rigidity, &local).iter().enumerate() {
                forces[nodes[k / 3] as usize][k % 3] -= force;
            }
        }
        for (edge, normal) in mesh.border_edges() {
            let [from, to] = edge.map(|node| mesh.nodes()[node as usize]);
            let length_m = libm::hypot(to[0] - from[0], to[1] - from[1]);
            for (part, weight) in GAUSS {
                let at = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                let [xx, yy, xy] = moments(&rigidity, &near.at(at).2);
                let [nx, ny] = normal;
                let moment_n = nx * nx * xx + ny * ny * yy + 2.0 * nx * ny * xy;
                for (node, share) in edge.into_iter().zip([1.0 - part, part]) {
                    for (k, axis) in self.frames[node as usize].into_iter().enumerate() {
                        forces[node as usize][1 + k] -=
                            weight * length_m * share * moment_n * dot(axis, normal);
                    }
                }
            }
        }
        (forces, held)
    }
}

/// A node, which of its unknowns, and what that is held at.
type Held = (u32, usize, f64);

/// Places and weights of Gauss's rule with three points on the unit interval.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The longer side of a mesh, m.
fn extent_m(mesh: &PlateMesh) -> f64 {
    let side = |axis: usize| {
        let places = || mesh.nodes().iter().map(|node| node[axis]);
        places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
    };
    side(0).max(side(1))
}

/// The unknowns of a system, or why they are none.
pub(super) fn solved(system: &System, load: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, FractureError> {
    let solution = system.solve(load);
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
    /// What is to be added to the fields of the mesh.
    near: Option<(NearLoad, PlateProperties)>,
}

impl PlateField {
    fn near_m(&self, point: [f64; 2]) -> f64 {
        self.near.map_or(0.0, |(near, _)| near.at(point).0)
    }

    /// Stress on the back with what is sharp under the load.
    fn with_near(&self, stress: PlaneStress, point: [f64; 2]) -> PlaneStress {
        match &self.near {
            Some((near, plate)) => {
                let moment = moments(&plate.rigidity(), &near.at(point).2);
                stress.plus(&plate.back_stress(moment), 1.0)
            }
            None => stress,
        }
    }

    /// Deflection at a point, m, positive in the direction of the load; `None` off the mesh.
    pub fn deflection_at_m(
        &self,
        mesh: &PlateMesh,
        point: [f64; 2],
        hint: &mut u32,
    ) -> Option<f64> {
        let (triangle, l) = mesh.locate(point, hint)?;
        let nodes = mesh.triangles()[triangle as usize];
        let sides = mesh.sides()[triangle as usize];
        let frames = nodes.map(|node| self.frames[node as usize]);
        let row = deflection(&mesh.corners_m(triangle), &frames, &l);
        let of_mesh: f64 = (0..N_LOCAL)
            .map(|k| row[k] * self.unknowns[sides[k / 3] as usize][k % 3])
            .sum();
        Some(of_mesh + self.near_m(point))
    }

    /// Bending stress on a face at a side of a node of the mesh.
    #[must_use]
    pub fn surface_stress(&self, mesh: &PlateMesh, side: u32, face: Face) -> PlaneStress {
        let node = mesh.nodes_of_sides()[side as usize];
        let of_mesh = self.back.at_side(side);
        on_face(self.with_near(of_mesh, mesh.nodes()[node as usize]), face)
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
            .map(|stress| on_face(self.with_near(stress, point), face))
    }
}

fn on_face(back: PlaneStress, face: Face) -> PlaneStress {
    match face {
        Face::Back => back,
        Face::Front => PlaneStress::default().plus(&back, -1.0),
    }
}
