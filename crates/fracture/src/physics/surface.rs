//! What a crack's surface looks like to the light: depth, opening, tilt, zone and roughness.

use std::f64::consts::PI;

use starbreak_glass::{Face, SegmentKind, Zone};

use super::front;
use crate::params::GlassPane;
use crate::tips::{CORROSION_LIMIT, Piece, TipLaw, Web};

/// Ratio of K to that of the mirror's rim above which mist turns to hackle \[Quinn2020\].
const HACKLE_RATIO: f64 = 1.2;

/// RMS roughness of a surface made at `K_IC`, µm. FIT: mirrors measure some 10 nm, mist some 0.3 µm,
/// hackle some µm \[Hull1999\].
const MIRROR_ROUGHNESS_UM: f64 = 0.01;

/// Exponent of the growth of roughness with K. FIT: 0.4 µm where mist begins.
const ROUGHNESS_EXPONENT: f64 = 2.6;

/// Largest roughness, µm.
const MAX_ROUGHNESS_UM: f64 = 20.0;

/// What is left of the opening under load once the load is gone, at most. UNKNOWN: debris and faces that no longer fit
/// keep cracks open.
const STAYS_OPEN: f64 = 0.3;

/// Zone and RMS roughness, µm, of a surface that was made at K.
pub(super) fn relief(law: &TipLaw, intensity_pa_sqrt_m: f64) -> (Zone, f64) {
    let ratio = law.mirror_ratio(intensity_pa_sqrt_m);
    let smooth = MIRROR_ROUGHNESS_UM
        * libm::pow(
            (intensity_pa_sqrt_m / law.toughness_pa_sqrt_m).max(1.0),
            ROUGHNESS_EXPONENT,
        );
    let (zone, roughness) = if ratio < 1.0 {
        (Zone::Mirror, smooth)
    } else if ratio < HACKLE_RATIO {
        (Zone::Mist, smooth)
    } else {
        (Zone::Hackle, 4.0 * smooth)
    };
    (zone, roughness.min(MAX_ROUGHNESS_UM))
}

/// The surface of a piece of crack.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    /// Depth over thickness at its ends.
    pub(super) depths: [f64; 2],
    /// Opening at the face it begins at, at its ends, µm.
    pub(super) openings_um: [f64; 2],
    pub(super) face: Face,
}

/// The surfaces of all pieces of a web, as its cracks are now.
pub(super) fn surfaces(pane: &GlassPane, web: &Web) -> Vec<Surface> {
    let cracks = Cracks::of(pane, web);
    web.pieces
        .iter()
        .map(|piece| cracks.surface_of(pane, piece))
        .collect()
}

/// What is known of whole cracks, by their numbers.
struct Cracks {
    /// How far the farthest tip that grew out of each is from where the first of them began, m.
    tip_m: Vec<f64>,
    /// Where each began, by the same measure, m.
    start_m: Vec<f64>,
    /// The crack that each grew out of.
    parent: Vec<Option<u32>>,
    /// Opening under load where the first of them began, m.
    opening_m: Vec<f64>,
    thickness_m: f64,
    /// Opening of a crack at rest over the root of its length, √m.
    at_rest_sqrt_m: f64,
}

/// Opening under load, 4 σ L/E \[TadaParisIrwin2000\], m.
fn opened_m(pane: &GlassPane, piece: &Piece) -> f64 {
    4.0 * piece.stress_pa.max(0.0) * piece.effective_m / pane.material.young_modulus_pa.value
}

impl Cracks {
    fn of(pane: &GlassPane, web: &Web) -> Self {
        let n = web.n_cracks() as usize;
        let parent: Vec<Option<u32>> = (0..web.n_cracks()).map(|k| web.parent(k)).collect();
        let mut cracks = Self {
            tip_m: vec![0.0; n],
            start_m: vec![f64::INFINITY; n],
            parent,
            opening_m: vec![0.0; n],
            thickness_m: pane.thickness_m,
            // 4 σ c/E with K = σ √(π c) \[TadaParisIrwin2000\]: one at rest has no more K than makes it creep.
            at_rest_sqrt_m: 4.0
                * CORROSION_LIMIT
                * pane.material.fracture_toughness_pa_sqrt_m.value
                / (PI.sqrt() * pane.material.young_modulus_pa.value),
        };
        for piece in &web.pieces {
            let k = piece.crack as usize;
            cracks.tip_m[k] = cracks.tip_m[k].max(piece.along_m[1]);
            cracks.start_m[k] = cracks.start_m[k].min(piece.along_m[0]);
            cracks.opening_m[k] = cracks.opening_m[k].max(opened_m(pane, piece));
        }
        // Cracks have higher numbers than those they grew out of.
        for k in (0..n).rev() {
            if let Some(parent) = cracks.parent[k] {
                let parent = parent as usize;
                cracks.tip_m[parent] = cracks.tip_m[parent].max(cracks.tip_m[k]);
                cracks.opening_m[parent] = cracks.opening_m[parent].max(cracks.opening_m[k]);
            }
        }
        for k in 0..n {
            if let Some(parent) = cracks.parent[k] {
                cracks.opening_m[k] = cracks.opening_m[parent as usize];
            }
        }
        cracks
    }

    /// Depth over thickness of a radial crack, or of what grew out of one.
    fn depth(&self, crack: u32, along_m: f64) -> f64 {
        let k = crack as usize;
        let own = front::depth(along_m / self.thickness_m, self.tip_m[k] / self.thickness_m);
        match self.parent[k] {
            None => own,
            Some(parent) => {
                let way_m = along_m - self.start_m[k];
                let before = self.depth(parent, self.start_m[k]);
                front::of_branch(own, before, way_m / self.thickness_m)
            }
        }
    }

    /// w √(1 − (r/c)²), w the smaller one of η w₀ and that at rest.
    fn opening_um(&self, crack: u32, along_m: f64) -> f64 {
        let k = crack as usize;
        let tip_m = self.tip_m[k].max(f64::MIN_POSITIVE);
        let part = (along_m / tip_m).clamp(0.0, 1.0);
        let at_rest_m = self.at_rest_sqrt_m * tip_m.sqrt();
        let widest_m = (STAYS_OPEN * self.opening_m[k]).min(at_rest_m);
        1e6 * widest_m * (1.0 - part * part).sqrt()
    }

    fn surface_of(&self, pane: &GlassPane, piece: &Piece) -> Surface {
        let openings_um = piece
            .along_m
            .map(|along_m| self.opening_um(piece.crack, along_m));
        let (depths, face) = match piece.kind {
            SegmentKind::Radial | SegmentKind::Fork | SegmentKind::Edge => (
                piece
                    .along_m
                    .map(|along_m| self.depth(piece.crack, along_m)),
                Face::Inner,
            ),
            // A ring ends at cracks, not in the glass: it is as deep as one of its length.
            SegmentKind::Ring => {
                let half = self.tip_m[piece.crack as usize] / self.thickness_m;
                ([front::deepest(half); 2], Face::Outer)
            }
            SegmentKind::Cone => {
                let depth = (piece.along_m[1] / pane.thickness_m).clamp(0.02, 1.0);
                ([depth; 2], Face::Outer)
            }
            SegmentKind::Dice | SegmentKind::Propagated | SegmentKind::Mst => {
                ([1.0; 2], Face::Outer)
            }
        };
        Surface {
            depths,
            openings_um: match piece.kind {
                // Debris at its tip keeps a cone open.
                SegmentKind::Cone => [1e6 * opened_m(pane, piece); 2],
                // Dice have moved apart.
                SegmentKind::Dice => [1e6 * self.opening_m[piece.crack as usize]; 2],
                _ => openings_um,
            },
            face,
        }
    }
}
