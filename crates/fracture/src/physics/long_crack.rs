//! Cracks under stress in the plane of the pane: from its rim or from an older damage.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

use starbreak_glass::SegmentKind;
use starbreak_seed::{Seed, Stream, normal};

use super::kept::Kept;
use super::outcome::LongCrackReport;
use super::shadow::Relieved;
use crate::FractureError;
use crate::mesh::MeshResolution;
use crate::mesh::{Outline, PlateMesh};
use crate::params::{GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad};
use crate::stress::{EXPANSION_PER_K, MembraneField, PlaneStress, StressField, membrane_stress};
use crate::tips::{
    COMPETITION, Ledger, MAX_STEPS, Motion, Piece, Tip, TipLaw, Tracing, Web, trace, unit,
};

/// Factor of K of a flaw at a free edge \[TadaParisIrwin2000\].
const EDGE_FACTOR: f64 = 1.12;

/// Scatter of the flaws along a rim. FIT: small, so that stress decides where it differs.
const FLAW_SCATTER: f64 = 0.05;

/// Places along the rim that are looked at for the most stressed one.
const RIM_SAMPLES: u32 = 400;

/// The stress of the last panes, by outline, Young's modulus, Poisson's ratio, load and mesh.
static LAST: Kept<PaneStress> = Kept::new(4);

/// Thermal stress with uniform tension of the frame over it.
pub(super) struct PaneStress {
    mesh: PlateMesh,
    thermal: MembraneField,
    frame: PlaneStress,
    outline: Outline,
}

impl StressField for PaneStress {
    fn stress_at(&self, point_m: [f64; 2], hint: &mut u32) -> Option<PlaneStress> {
        if self.outline.depth_m(point_m) < -1e-9 {
            return None;
        }
        let thermal = self
            .thermal
            .stress_at(&self.mesh, point_m, hint)
            .unwrap_or_default();
        Some(thermal.plus(&self.frame, 1.0))
    }
}

impl PaneStress {
    /// That of a pane, which all panes of its shape and glass share.
    pub(super) fn of(
        pane: &GlassPane,
        load: &MembraneLoad,
        resolution: MeshResolution,
    ) -> Result<Arc<Self>, FractureError> {
        let material = &pane.material;
        let elastic = [&material.young_modulus_pa, &material.poisson_ratio].map(|of| of.value);
        LAST.of(&(pane.outline, elastic, load, resolution), || {
            Self::new(&pane.outline, elastic, load, resolution)
        })
    }

    fn new(
        outline: &Outline,
        [young_modulus_pa, poisson_ratio]: [f64; 2],
        load: &MembraneLoad,
        resolution: MeshResolution,
    ) -> Result<Self, FractureError> {
        let [width, height] = outline.size_m();
        let center = [load.spot[0] * width, load.spot[1] * height];
        let sigma = load.spot_size * width.min(height);
        let middle = [0.5 * width, 0.5 * height];
        // An even mesh: the temperature has no peak that is sharper than the spot.
        let mesh = PlateMesh::graded(outline, middle, 0.02 * width.min(height), None, resolution)?;
        let thermal = membrane_stress(
            &mesh,
            young_modulus_pa,
            poisson_ratio,
            EXPANSION_PER_K,
            |[x, y]| {
                let (dx, dy) = ((x - center[0]) / sigma, (y - center[1]) / sigma);
                load.temperature_difference_k * libm::exp(-0.5 * (dx * dx + dy * dy))
            },
        )?;
        let [cos, sin] = unit(load.frame_direction_rad);
        let tension = load.frame_tension_pa;
        Ok(Self {
            mesh,
            thermal,
            frame: PlaneStress {
                xx_pa: tension * cos * cos,
                yy_pa: tension * sin * sin,
                xy_pa: tension * sin * cos,
            },
            outline: *outline,
        })
    }

    /// Elastic energy of the load, J: thermal and frame tension without their product.
    fn energy_j(&self, pane: &GlassPane) -> f64 {
        let tension = self.frame.xx_pa + self.frame.yy_pa;
        let frame = 0.5 * tension * tension / pane.material.young_modulus_pa.value;
        self.thermal.energy_j_m * pane.thickness_m
            + frame * pane.outline.area_m2() * pane.thickness_m
    }

    /// The place of the rim whose flaw opens first: where, the direction inwards, and the tension
    /// along the rim. Flaws differ by some percent, so that of equal places any may be it.
    fn weakest_rim(&self, seed: Seed) -> ([f64; 2], [f64; 2], f64) {
        let mut rng = seed.stream(Stream::LongCrack, 0);
        let mut best_counts = f64::NEG_INFINITY;
        let mut best = ([0.0; 2], [1.0, 0.0], f64::NEG_INFINITY);
        let mut hint = 0;
        for k in 0..RIM_SAMPLES {
            let (point, inward) =
                rim_place(&self.outline, (f64::from(k) + 0.5) / f64::from(RIM_SAMPLES));
            let Some(stress) = self.stress_at(point, &mut hint) else {
                continue;
            };
            let tension = stress.normal_pa([-inward[1], inward[0]]);
            let counts = tension * libm::exp(FLAW_SCATTER * normal(&mut rng));
            if counts > best_counts {
                best_counts = counts;
                best = (point, inward, tension);
            }
        }
        best
    }
}

/// The place a fraction of the way around the rim, and the direction inwards.
fn rim_place(outline: &Outline, part: f64) -> ([f64; 2], [f64; 2]) {
    match *outline {
        Outline::Rectangle { width_m, height_m } => {
            let way = part * 2.0 * (width_m + height_m);
            if way < width_m {
                ([way, 0.0], [0.0, 1.0])
            } else if way < width_m + height_m {
                ([width_m, way - width_m], [-1.0, 0.0])
            } else if way < 2.0 * width_m + height_m {
                ([2.0 * width_m + height_m - way, height_m], [0.0, -1.0])
            } else {
                ([0.0, 2.0 * (width_m + height_m) - way], [1.0, 0.0])
            }
        }
        Outline::Disc { diameter_m } => {
            let radius = 0.5 * diameter_m;
            let [cos, sin] = unit(part * 2.0 * PI);
            // Just inside, so that rounding does not put it off the pane.
            let reach = radius * (1.0 - 1e-12);
            ([radius + reach * cos, radius + reach * sin], [-cos, -sin])
        }
    }
}

/// What stress in the plane has done, as far as it is known before the end.
#[derive(Clone, Copy)]
pub(super) struct Driven {
    flaw_k_ratio: f64,
    available_j: f64,
    dissipated_j: f64,
}

impl Driven {
    /// With what it does once more.
    pub(super) fn and(self, more: Self) -> Self {
        Self {
            flaw_k_ratio: self.flaw_k_ratio.max(more.flaw_k_ratio),
            available_j: self.available_j,
            dissipated_j: self.dissipated_j + more.dissipated_j,
        }
    }

    /// The report, once it is known what came of the cracks.
    pub(super) fn report(self, class: &'static str, length_m: f64) -> LongCrackReport {
        LongCrackReport {
            class,
            length_m,
            flaw_k_ratio: self.flaw_k_ratio,
            available_j: self.available_j,
            dissipated_j: self.dissipated_j,
        }
    }
}

/// Grows the crack, or those that have numbers from `n_older` on; `after_s` is when everything else
/// has happened.
pub(super) fn grow_long_crack(
    web: &mut Web,
    pane: &GlassPane,
    (long_crack, field): (&LongCrack, &PaneStress),
    n_older: u32,
    seed: Seed,
    after_s: f64,
) -> Driven {
    let law = TipLaw::new(&pane.material, pane.thickness_m, false);
    let energy_j = field.energy_j(pane);
    let relieved = Relieved::by(web, field);
    let starts = starts(web, &relieved, (long_crack, n_older), seed);
    let flaw_k_ratio = starts
        .iter()
        .map(|start| law.intensity(start.tension_pa, start.counts_m) / law.toughness_pa_sqrt_m)
        .fold(0.0, f64::max);
    let mut ledger = Ledger {
        available_j: energy_j,
        dissipated_j: 0.0,
        steps_left: MAX_STEPS,
    };
    let mut tips: Vec<Tip> = starts
        .iter()
        .map(|start| {
            let node = start.node.unwrap_or_else(|| web.add_node(start.at_m));
            let kind = (SegmentKind::Edge, start.crack);
            let mut tip = Tip::new(
                web,
                seed,
                kind,
                node,
                start.heading,
                start.counts_m,
                after_s,
            );
            tip.along_m = start.along_m;
            if let Some(tilt_rad) = start.tilt_rad {
                tip.tilt.starts_at(tilt_rad);
            }
            tip
        })
        .collect();
    let motion = match long_crack.growth {
        LongCrackGrowth::Sudden => Motion::Dynamic,
        LongCrackGrowth::Slow { period_s } => Motion::Corrosion { period_s },
    };
    let [width, height] = pane.outline.size_m();
    let tracing = Tracing {
        law,
        motion,
        step_m: [2e-4, (0.002 * width.max(height)).clamp(2e-4, 2e-3)],
        forks: true,
        competition: COMPETITION,
        rim_shields: true,
    };
    trace(
        web,
        &mut tips,
        &relieved,
        &tracing,
        &mut ledger,
        seed,
        f64::INFINITY,
    );
    Driven {
        flaw_k_ratio,
        available_j: ledger.available_j,
        dissipated_j: ledger.dissipated_j,
    }
}

/// Where a crack begins to grow, or goes on.
struct Start {
    /// Node of the crack that goes on, and its number.
    node: Option<u32>,
    crack: Option<u32>,
    at_m: [f64; 2],
    heading: [f64; 2],
    /// Length that counts for K, and way from where the crack began, m.
    counts_m: f64,
    along_m: f64,
    tension_pa: f64,
    tilt_rad: Option<f64>,
}

fn starts(
    web: &Web,
    field: &Relieved<'_>,
    (long_crack, n_older): (&LongCrack, u32),
    seed: Seed,
) -> Vec<Start> {
    let flaw_m = long_crack.flaw_m;
    let stress_at = |at_m: [f64; 2]| field.stress_at(at_m, &mut 0).unwrap_or_default();
    match long_crack.origin {
        LongCrackOrigin::Rim => {
            let (at_m, heading, tension) = field.whole().weakest_rim(seed);
            // The flaw counts as its length with the factor of an edge.
            vec![Start {
                node: None,
                crack: None,
                at_m,
                heading,
                counts_m: EDGE_FACTOR * EDGE_FACTOR * flaw_m,
                along_m: 0.0,
                tension_pa: tension,
                tilt_rad: None,
            }]
        }
        LongCrackOrigin::Impact => {
            let farthest = free_ends(web, n_older)
                .into_iter()
                .max_by(|a, b| a.along_m.total_cmp(&b.along_m));
            let of = |end: Start| {
                let (tension_pa, _, [nx, ny]) = stress_at(end.at_m).principal();
                // It leaves the old crack across the tension, to the side that the leg points to.
                let along = [-ny, nx];
                let sign = if along[0] * end.heading[0] + along[1] * end.heading[1] < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                Start {
                    heading: along.map(|part| sign * part),
                    counts_m: flaw_m.max(end.along_m),
                    tension_pa,
                    ..end
                }
            };
            farthest.map(of).into_iter().collect()
        }
        LongCrackOrigin::Legs => {
            let of = |end: Start| {
                let side = [-end.heading[1], end.heading[0]];
                Start {
                    counts_m: flaw_m.max(end.along_m),
                    tension_pa: stress_at(end.at_m).normal_pa(side),
                    ..end
                }
            };
            free_ends(web, n_older).into_iter().map(of).collect()
        }
    }
}

/// The ends of radial cracks and their branches, of those with numbers from `n_older` on, that lie
/// in the glass, in the order of the cracks.
fn free_ends(web: &Web, n_older: u32) -> Vec<Start> {
    let mut n_at = vec![0_u32; web.nodes.len()];
    for piece in &web.pieces {
        n_at[piece.a as usize] += 1;
        n_at[piece.b as usize] += 1;
    }
    let mut last: BTreeMap<u32, &Piece> = BTreeMap::new();
    let is_leg = |piece: &&Piece| {
        piece.crack >= n_older && matches!(piece.kind, SegmentKind::Radial | SegmentKind::Fork)
    };
    for piece in web.pieces.iter().filter(is_leg) {
        let farthest = last.entry(piece.crack).or_insert(piece);
        if piece.along_m[1] > farthest.along_m[1] {
            *farthest = piece;
        }
    }
    let mut ends = Vec::new();
    for (crack, piece) in last {
        let (from, to) = (web.nodes[piece.a as usize], web.nodes[piece.b as usize]);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = libm::hypot(dx, dy);
        if n_at[piece.b as usize] > 1 || web.outline.depth_m(to) <= 1e-6 || length <= 0.0 {
            continue;
        }
        ends.push(Start {
            node: Some(piece.b),
            crack: Some(crack),
            at_m: to,
            heading: [dx / length, dy / length],
            counts_m: piece.along_m[1],
            along_m: piece.along_m[1],
            tension_pa: 0.0,
            tilt_rad: Some(piece.tilt_rad[1]),
        });
    }
    ends
}
