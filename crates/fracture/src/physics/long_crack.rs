//! Cracks under stress in the plane of the pane: from its rim or from an older damage.

use std::f64::consts::PI;

use starbreak_glass::{Seed, SegmentKind, Stream};

use super::outcome::LongCrackReport;
use super::params::{
    GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad, MeshResolution,
};
use crate::FractureError;
use crate::draw::normal;
use crate::mesh::{Outline, PlateMesh};
use crate::stress::{EXPANSION_PER_K, MembraneField, PlaneStress, StressField, membrane_stress};
use crate::tips::{COMPETITION, Ledger, MAX_STEPS, Motion, Tip, TipLaw, Tracing, Web, trace, unit};

/// Factor of K of a flaw at a free edge \[TadaParisIrwin2000\].
const EDGE_FACTOR: f64 = 1.12;

/// Scatter of the flaws along a rim. FIT: small, so that stress decides where it differs.
const FLAW_SCATTER: f64 = 0.05;

/// Places along the rim that are looked at for the most stressed one.
const RIM_SAMPLES: u32 = 400;

/// Thermal stress with uniform tension of the frame over it.
struct PaneStress {
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
    fn of(
        pane: &GlassPane,
        load: &MembraneLoad,
        resolution: MeshResolution,
    ) -> Result<Self, FractureError> {
        let [width, height] = pane.outline.size_m();
        let center = [load.spot[0] * width, load.spot[1] * height];
        let sigma = load.spot_size * width.min(height);
        let middle = [0.5 * width, 0.5 * height];
        // An even mesh: the temperature has no peak that is sharper than the spot.
        let mesh = PlateMesh::graded(
            &pane.outline,
            middle,
            0.02 * width.min(height),
            None,
            resolution,
        )?;
        let thermal = membrane_stress(
            &mesh,
            pane.material.young_modulus_pa.value,
            pane.material.poisson_ratio.value,
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
            outline: pane.outline,
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

/// Grows the crack; `after_s` is when everything else has happened.
pub(super) fn grow_long_crack(
    web: &mut Web,
    pane: &GlassPane,
    long_crack: &LongCrack,
    resolution: MeshResolution,
    seed: Seed,
    after_s: f64,
) -> Result<LongCrackReport, FractureError> {
    let field = PaneStress::of(pane, &long_crack.load, resolution)?;
    let law = TipLaw::new(&pane.material, pane.thickness_m, false);
    let energy_j = field.energy_j(pane);
    let start = match long_crack.origin {
        LongCrackOrigin::Rim => {
            let (point, inward, tension) = field.weakest_rim(seed);
            Some((
                None,
                point,
                inward,
                long_crack.flaw_m,
                EDGE_FACTOR * tension,
            ))
        }
        LongCrackOrigin::Impact => farthest_tip(web).map(|(node, direction, length_m)| {
            let point = web.nodes[node as usize];
            let stress = field.stress_at(point, &mut 0).unwrap_or_default();
            let (tension, _, [nx, ny]) = stress.principal();
            // It leaves the old crack across the tension, to the side that the leg points to.
            let along = [-ny, nx];
            let sign = if along[0] * direction[0] + along[1] * direction[1] < 0.0 {
                -1.0
            } else {
                1.0
            };
            let heading = [along[0] * sign, along[1] * sign];
            (
                Some(node),
                point,
                heading,
                long_crack.flaw_m.max(length_m),
                tension,
            )
        }),
    };
    let Some((node, point, direction, flaw_m, tension_pa)) = start else {
        return Ok(LongCrackReport {
            class: "intact",
            length_m: 0.0,
            flaw_k_ratio: 0.0,
            available_j: energy_j,
            dissipated_j: 0.0,
        });
    };
    let flaw_k_ratio = law.intensity(tension_pa, flaw_m) / law.toughness_pa_sqrt_m;
    let mut ledger = Ledger {
        available_j: energy_j,
        dissipated_j: 0.0,
        steps_left: MAX_STEPS,
    };
    let first_piece = web.pieces.len();
    let node = node.unwrap_or_else(|| web.add_node(point));
    // The flaw counts as its length; at the rim with the factor of an edge.
    let factor = if matches!(long_crack.origin, LongCrackOrigin::Rim) {
        EDGE_FACTOR * EDGE_FACTOR
    } else {
        1.0
    };
    let tip = Tip::new(
        web,
        seed,
        SegmentKind::Edge,
        node,
        direction,
        factor * flaw_m,
        after_s,
    );
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
    let mut tips = vec![tip];
    trace(
        web,
        &mut tips,
        &field,
        &tracing,
        &mut ledger,
        seed,
        f64::INFINITY,
    );
    let length_m = web.pieces[first_piece..]
        .iter()
        .map(|piece| piece.along_m[1] - piece.along_m[0])
        .fold(0.0, |sum, length| sum + length);
    let meets_rim = tips
        .iter()
        .any(|tip| pane.outline.depth_m(tip.at_m) <= 1e-6);
    let class = if web.pieces.len() == first_piece {
        "intact"
    } else {
        match (long_crack.origin, meets_rim) {
            (LongCrackOrigin::Rim, _) if long_crack.load.frame_tension_pa <= 0.0 => "stress-crack",
            (LongCrackOrigin::Rim, _) => "edge-crack",
            (LongCrackOrigin::Impact, false) => "floater-crack",
            (LongCrackOrigin::Impact, true) => "long-crack",
        }
    };
    Ok(LongCrackReport {
        class,
        length_m,
        flaw_k_ratio,
        available_j: ledger.available_j,
        dissipated_j: ledger.dissipated_j,
    })
}

/// End of the crack of the first hit that reaches farthest from where it began: its node, its
/// direction there and its length.
fn farthest_tip(web: &Web) -> Option<(u32, [f64; 2], f64)> {
    let is_leg = |kind| matches!(kind, SegmentKind::Radial | SegmentKind::Fork);
    let piece = web
        .pieces
        .iter()
        .filter(|piece| is_leg(piece.kind))
        .max_by(|a, b| a.along_m[1].total_cmp(&b.along_m[1]))?;
    let (from, to) = (web.nodes[piece.a as usize], web.nodes[piece.b as usize]);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = libm::hypot(dx, dy).max(1e-12);
    Some((piece.b, [dx / length, dy / length], piece.along_m[1]))
}
