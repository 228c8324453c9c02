//! The pane under a hit as a plate: which part of it bends, and how strongly.
//!
//! Away from rims and cracks the plate's stress depends on one length alone (the reach of the
//! bending wave, or that of the foundation), so one factorization of a disc of unit radius serves
//! every hit, every moment of it, and every pane of one kind. Where a rim or a crack is in reach, a
//! mesh of its own is made.

use std::f64::consts::PI;
use std::sync::Arc;

use super::kept::Kept;
use crate::FractureError;
use crate::mesh::MeshResolution;
use crate::mesh::{Outline, PlateMesh};
use crate::params::{GlassBuild, GlassPane, Support};
use crate::stress::{
    Face, PatchLoad, PlaneStress, PlateField, PlateProperties, PlateSolver, StressField,
};

/// Poisson's ratio of the interlayer under confinement. FIT: it gives a constrained modulus of
/// 2.55 E, the middle of what design and measurement of laminates use.
const INTERLAYER_POISSON: f64 = 0.42;

/// Reach of a bending wave r = β (D/ρh)^¼ √t: with β² = 2π a clamped disc of this radius has, under
/// a constant force, the deflection under the force that the plate's impedance 8√(Dρh) asks for.
const WAVE_REACH: f64 = 2.506_628_274_631_000_5;

/// Radius of the kept disc on a foundation, in lengths ℓ of the foundation; at 12 ℓ a Winkler plate
/// has come to rest to 10⁻³.
const FOUNDATION_REACH: f64 = 16.0;

/// Size of the kept disc's innermost elements over its radius.
const KEPT_INNER_SIZE: f64 = 0.004;

/// Size of elements under the load over the radius of the patch.
const INNER_SIZE: f64 = 0.35;

/// Size of the innermost elements over the distance from the rim, where what is sharp under the load
/// is known in closed form.
const SMOOTH_INNER_SIZE: f64 = 0.15;

/// A mesh for a plate without a foundation under a load that the rim is not in: of a quarter of the nodes, as it
/// has to find only what is smooth ([`PlateSolver::solve`]).
fn smooth_mesh(
    outline: &Outline,
    center_m: [f64; 2],
    domain_m: Option<f64>,
    resolution: MeshResolution,
) -> Result<PlateMesh, FractureError> {
    let n_nodes = match resolution {
        MeshResolution::Fast => 500,
        MeshResolution::Default => 1500,
    };
    let depth_m = outline
        .depth_m(center_m)
        .min(domain_m.unwrap_or(f64::INFINITY));
    PlateMesh::graded_to(
        outline,
        center_m,
        SMOOTH_INNER_SIZE * depth_m,
        domain_m,
        n_nodes,
    )
}

/// How a plate carries a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Carrying {
    /// On an elastic foundation of the length ℓ = (D/k)^¼, m.
    Foundation { length_m: f64 },
    /// By inertia: the bending wave has reached so far, m.
    Wave { reach_m: f64 },
    /// By its rim.
    Rim,
}

/// The stiffness of a pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stiffness {
    pub(super) properties: PlateProperties,
    /// D = E h³/12(1 − ν²), N m.
    pub(super) bending_n_m: f64,
    /// ρ h, kg/m².
    pub(super) mass_kg_m2: f64,
}

impl Stiffness {
    pub(super) fn of(pane: &GlassPane) -> Self {
        let (e, nu) = (
            pane.material.young_modulus_pa.value,
            pane.material.poisson_ratio.value,
        );
        let h = pane.thickness_m;
        let foundation_pa_m = match pane.build {
            GlassBuild::Laminated {
                interlayer_thickness_m,
                interlayer_modulus_pa,
                ..
            } => {
                let p = INTERLAYER_POISSON;
                let constrained = (1.0 - p) / ((1.0 + p) * (1.0 - 2.0 * p));
                interlayer_modulus_pa * constrained / interlayer_thickness_m
            }
            GlassBuild::Annealed | GlassBuild::Tempered { .. } => 0.0,
        };
        Self {
            properties: PlateProperties {
                thickness_m: h,
                young_modulus_pa: e,
                poisson_ratio: nu,
                foundation_pa_m,
            },
            bending_n_m: e * h * h * h / (12.0 * (1.0 - nu * nu)),
            mass_kg_m2: pane.material.density_kg_m3.value * h,
        }
    }

    /// Length of the foundation, m; `None` where there is none.
    pub(super) fn foundation_length_m(&self) -> Option<f64> {
        let k = self.properties.foundation_pa_m;
        (k > 0.0).then(|| (self.bending_n_m / k).sqrt().sqrt())
    }

    /// How far bending has come at a time after the hit, m.
    pub(super) fn wave_reach_m(&self, time_s: f64) -> f64 {
        WAVE_REACH * (self.bending_n_m / self.mass_kg_m2).sqrt().sqrt() * time_s.sqrt()
    }

    /// Force per speed of a point of an unbounded plate, 8√(Dρh) \[Zener1941\], kg/s.
    pub(super) fn impedance_kg_s(&self) -> f64 {
        8.0 * (self.bending_n_m * self.mass_kg_m2).sqrt()
    }

    /// Deflection that an impulse leaves under itself in an unbounded plate, m.
    pub(super) fn deflection_m(&self, impulse_n_s: f64) -> f64 {
        impulse_n_s / self.impedance_kg_s()
    }

    /// Central force that holds a clamped disc at a deflection: P = 16 π D w/r², N.
    pub(super) fn disc_force_n(&self, deflection_m: f64, radius_m: f64) -> f64 {
        16.0 * PI * self.bending_n_m * deflection_m / (radius_m * radius_m)
    }

    /// What ln(reach) adds to the stress in the middle of a clamped disc per force,
    /// 6/h² · (1 + ν)/4π \[Timoshenko1959\], Pa/N.
    pub(super) fn stress_per_log_reach_pa_n(&self) -> f64 {
        let h = self.properties.thickness_m;
        6.0 / (h * h) * (1.0 + self.properties.poisson_ratio) / (4.0 * PI)
    }

    /// Radius of the patch that gives a thick plate's stress under a load on a disc of `radius_m`:
    /// √(1.6 r² + h²) − 0.675 h for r < h/2 \[Westergaard1926\].
    pub(super) fn patch_radius_m(&self, radius_m: f64) -> f64 {
        let h = self.properties.thickness_m;
        if radius_m < 0.5 * h {
            (1.6 * radius_m * radius_m + h * h).sqrt() - 0.675 * h
        } else {
            radius_m
        }
    }
}

impl GlassPane {
    /// Length ℓ = (D/k)^¼ of the elastic foundation that the interlayer of a laminate is to the ply
    /// that is hit, m; `None` where there is none. Bending dies out over some lengths.
    #[must_use]
    pub fn foundation_length_m(&self) -> Option<f64> {
        Stiffness::of(self).foundation_length_m()
    }
}

/// The discs of the last panes, of some 10 MB each.
static DISCS: Kept<PlateSolver> = Kept::new(4);

/// How they were bent last, by the patch and force of the load in their middle: all stones of a recipe may be
/// alike.
static BENT: Kept<PlateField> = Kept::new(8);

/// A disc that serves every hit of a pane.
#[derive(Debug, Clone, Copy)]
struct Disc {
    radius: f64,
    properties: PlateProperties,
    resolution: MeshResolution,
}

impl Disc {
    fn solver(&self) -> Result<Arc<PlateSolver>, FractureError> {
        DISCS.of(self, || {
            let radius = self.radius;
            let outline = Outline::Disc {
                diameter_m: 2.0 * radius,
            };
            let mesh = if self.properties.foundation_pa_m > 0.0 {
                // Fine enough for the smallest patch over the longest foundation.
                let inner = KEPT_INNER_SIZE * radius;
                PlateMesh::graded(&outline, [radius; 2], inner, None, self.resolution)?
            } else {
                smooth_mesh(&outline, [radius; 2], None, self.resolution)?
            };
            PlateSolver::new(mesh, self.properties, Support::Clamped)
        })
    }
}

/// The solvers of one pane.
pub(super) struct Plates {
    pub(super) stiffness: Stiffness,
    outline: Outline,
    support: Support,
    resolution: MeshResolution,
    /// The disc of this pane, once a hit needs it.
    disc: Option<Arc<PlateSolver>>,
    pub(super) n_solutions: usize,
    pub(super) n_mesh_nodes: usize,
}

/// A force on the pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Load {
    pub(super) center_m: [f64; 2],
    pub(super) patch_radius_m: f64,
    pub(super) force_n: f64,
    pub(super) carrying: Carrying,
}

/// The bending of a pane, at its own place and size.
pub(super) struct Bending {
    mesh: Arc<PlateMesh>,
    field: Arc<PlateField>,
    /// Metres per unit of the mesh.
    scale: f64,
    /// Stress over that of the solution, which is linear in the force.
    gain: f64,
    load: Load,
    /// Where the mesh's origin lies on the pane, m.
    origin_m: [f64; 2],
    outline: Outline,
}

/// One face of a bent pane.
pub(super) struct BentFace<'a> {
    bending: &'a Bending,
    face: Face,
}

impl Bending {
    /// The same plate under another force and, where a wave carries it, another reach: its stress
    /// is linear in the force, and depends on place over reach alone (but for the patch, whose
    /// size is felt only under it).
    pub(super) fn set_load(&mut self, force_n: f64, reach_m: Option<f64>) {
        self.gain = force_n / self.load.force_n;
        if let (Carrying::Wave { reach_m: old_m }, Some(reach_m)) = (self.load.carrying, reach_m) {
            let center = self.load.center_m;
            let unit_m = self.scale / old_m * reach_m;
            for (origin, center) in self.origin_m.iter_mut().zip(center) {
                *origin = center + (*origin - center) / self.scale * unit_m;
            }
            self.scale = unit_m;
            self.load.carrying = Carrying::Wave { reach_m };
        }
    }

    /// Strain energy, J.
    pub(super) fn energy_j(&self) -> f64 {
        self.field.energy_j * self.scale * self.scale * self.gain * self.gain
    }

    pub(super) fn face(&self, face: Face) -> BentFace<'_> {
        BentFace {
            bending: self,
            face,
        }
    }
}

impl StressField for BentFace<'_> {
    fn stress_at(&self, point_m: [f64; 2], hint: &mut u32) -> Option<PlaneStress> {
        let bending = self.bending;
        if bending.outline.depth_m(point_m) < -1e-9 {
            return None;
        }
        let local = [
            (point_m[0] - bending.origin_m[0]) / bending.scale,
            (point_m[1] - bending.origin_m[1]) / bending.scale,
        ];
        // Beyond the mesh the plate is at rest.
        let stress = bending
            .field
            .surface_stress_at(&bending.mesh, local, self.face, hint)
            .unwrap_or_default();
        Some(PlaneStress::default().plus(&stress, bending.gain))
    }
}

impl Plates {
    pub(super) fn new(pane: &GlassPane, resolution: MeshResolution) -> Self {
        Self {
            stiffness: Stiffness::of(pane),
            outline: pane.outline,
            support: pane.support,
            resolution,
            disc: None,
            n_solutions: 0,
            n_mesh_nodes: 0,
        }
    }

    /// How the pane carries a hit at `time_s` after it.
    pub(super) fn carrying(&self, center_m: [f64; 2], time_s: f64) -> Carrying {
        if let Some(length_m) = self.stiffness.foundation_length_m() {
            return Carrying::Foundation { length_m };
        }
        let reach_m = self.stiffness.wave_reach_m(time_s);
        let [width, height] = self.outline.size_m();
        let farthest = libm::hypot(
            center_m[0].max(width - center_m[0]),
            center_m[1].max(height - center_m[1]),
        );
        if reach_m < farthest {
            Carrying::Wave { reach_m }
        } else {
            Carrying::Rim
        }
    }

    /// Whether the pane carries a hit as if it had no rim.
    pub(super) fn is_free(&self, center_m: [f64; 2], carrying: Carrying) -> bool {
        let free = self.outline.depth_m(center_m);
        match carrying {
            Carrying::Foundation { length_m } => free > 0.6 * FOUNDATION_REACH * length_m,
            Carrying::Wave { reach_m } => free >= reach_m,
            Carrying::Rim => false,
        }
    }

    /// The bending of the intact pane.
    pub(super) fn bend(&mut self, load: &Load) -> Result<Bending, FractureError> {
        let is_free = self.is_free(load.center_m, load.carrying);
        match load.carrying {
            Carrying::Foundation { length_m } if is_free => {
                self.bend_kept(load, length_m, FOUNDATION_REACH)
            }
            Carrying::Wave { reach_m } if is_free => self.bend_kept(load, reach_m, 1.0),
            _ => self.bend_around(load, &[]),
        }
    }

    /// Counts a bending, and notes the largest mesh.
    fn note(&mut self, solver: &PlateSolver) {
        self.n_solutions += 1;
        self.n_mesh_nodes = self.n_mesh_nodes.max(solver.mesh().nodes().len());
    }

    fn bend_kept(
        &mut self,
        load: &Load,
        unit_m: f64,
        radius: f64,
    ) -> Result<Bending, FractureError> {
        let mut properties = self.stiffness.properties;
        if properties.foundation_pa_m > 0.0 {
            // In lengths of the foundation: ℓ = 1.
            properties.foundation_pa_m = self.stiffness.bending_n_m;
        }
        let disc = Disc {
            radius,
            properties,
            resolution: self.resolution,
        };
        let solver = match &self.disc {
            Some(solver) => Arc::clone(solver),
            None => Arc::clone(self.disc.insert(disc.solver()?)),
        };
        self.note(&solver);
        let patch = PatchLoad {
            center_m: [radius; 2],
            radius_m: load.patch_radius_m / unit_m,
            force_n: load.force_n,
        };
        let field = BENT.of(&(disc, patch), || solver.solve(&patch))?;
        Ok(Bending {
            mesh: solver.shared_mesh(),
            field,
            scale: unit_m,
            gain: 1.0,
            load: *load,
            origin_m: load.center_m.map(|center| center - radius * unit_m),
            outline: self.outline,
        })
    }

    /// Nodes of a mesh around cracks, or around a load on the rim of one sheet, about.
    fn nodes_around_cracks(&self) -> u32 {
        match self.resolution {
            MeshResolution::Fast => 900,
            MeshResolution::Default => 2000,
        }
    }

    /// The bending on a mesh of its own around a hit, with cracks as hinges.
    pub(super) fn bend_around(
        &mut self,
        load: &Load,
        cracks: &[Vec<[f64; 2]>],
    ) -> Result<Bending, FractureError> {
        let domain_m = match load.carrying {
            Carrying::Foundation { length_m } => Some(FOUNDATION_REACH * length_m),
            Carrying::Wave { reach_m } => Some(reach_m),
            Carrying::Rim => None,
        };
        let inner_m = INNER_SIZE * load.patch_radius_m;
        let (outline, center_m, resolution) = (&self.outline, load.center_m, self.resolution);
        let is_sheet = self.stiffness.properties.foundation_pa_m == 0.0;
        let is_on_rim = outline.depth_m(center_m) <= load.patch_radius_m;
        let mesh = if !cracks.is_empty() || (is_sheet && is_on_rim) {
            let n_nodes = self.nodes_around_cracks();
            PlateMesh::graded_around_cracks(outline, center_m, inner_m, domain_m, n_nodes, cracks)?
        } else if is_sheet {
            smooth_mesh(outline, center_m, domain_m, resolution)?
        } else {
            PlateMesh::graded(outline, center_m, inner_m, domain_m, resolution)?
        };
        let solver = PlateSolver::new(mesh, self.stiffness.properties, self.support)?;
        self.note(&solver);
        let field = solver.solve(&PatchLoad {
            center_m,
            radius_m: load.patch_radius_m,
            force_n: load.force_n,
        })?;
        Ok(Bending {
            mesh: solver.shared_mesh(),
            field: Arc::new(field),
            scale: 1.0,
            gain: 1.0,
            load: *load,
            origin_m: [0.0, 0.0],
            outline: self.outline,
        })
    }
}
