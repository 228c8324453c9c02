//! What a crack's surface looks like to the light: opening, depth, zone and roughness.

use std::f64::consts::PI;

use starbreak_glass::{Material, Zone};

use crate::tips::{Piece, TipLaw};

/// Ratio of K to that of the mirror's rim above which mist turns to hackle \[Quinn2020\].
const HACKLE_RATIO: f64 = 1.2;

/// RMS roughness of a surface made at `K_IC`, µm. FIT: mirrors measure some 10 nm, mist some 0.3 µm,
/// hackle some µm \[Hull1999\].
const MIRROR_ROUGHNESS_UM: f64 = 0.01;

/// Exponent of the growth of roughness with K. FIT: 0.4 µm where mist begins.
const ROUGHNESS_EXPONENT: f64 = 2.6;

/// Largest roughness, µm.
const MAX_ROUGHNESS_UM: f64 = 20.0;

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

/// Opening of a crack at a point, µm: that of a crack of the length that counts, 4 σ L/E
/// \[TadaParisIrwin2000\], narrowing to the tip like the root of the distance from it.
pub(super) fn opening_um(material: &Material, piece: &Piece, length_m: f64) -> f64 {
    let full = 4.0 * piece.stress_pa.max(0.0) * piece.effective_m / material.young_modulus_pa.value;
    let middle = 0.5 * (piece.along_m[0] + piece.along_m[1]);
    let from_tip = ((length_m - middle) / length_m.max(1e-9)).clamp(0.0, 1.0);
    (full * from_tip.sqrt() * 1e6).max(MIN_OPENING_UM)
}

/// Opening that stays even at the tip of an arrested crack, µm. FIT: about a tenth of a wavelength
/// of light, so that the tip fades.
const MIN_OPENING_UM: f64 = 0.05;

/// Depth over thickness of a radial crack of length L in a bent plate: where the stress intensity
/// of the remaining ligament falls to `K_IC`.
///
/// The ligament of a part-through crack of depth d carries σ/(1 + 3 (h/L) α(d)), α the
/// dimensionless compliance of the cracked section (line spring \[RiceLevy1972\]), and the front
/// has K = σ_lig √(πdh) F(d) of an edge crack under bending \[TadaParisIrwin2000\].
pub(super) fn bending_depth(law: &TipLaw, stress_pa: f64, length_m: f64) -> f64 {
    let h = law.thickness_m;
    let mut compliance = 0.0;
    let mut depth = 0.0;
    let steps = 95_u32;
    for k in 1..=steps {
        let d = f64::from(k) * 0.01;
        let factor = edge_crack_bending(d);
        compliance += d * factor * factor * 0.01 * PI * 2.0;
        let ligament = stress_pa / (1.0 + 3.0 * h / length_m.max(1e-6) * compliance);
        if ligament * (PI * d * h).sqrt() * factor >= law.toughness_pa_sqrt_m {
            depth = d;
        }
    }
    depth.max(MIN_DEPTH)
}

/// A crack that is seen has at least this depth over thickness.
const MIN_DEPTH: f64 = 0.05;

/// F(d) of an edge crack of relative depth d under pure bending \[TadaParisIrwin2000\].
fn edge_crack_bending(d: f64) -> f64 {
    let angle = 0.5 * PI * d;
    (libm::tan(angle) / angle).sqrt() * (0.923 + 0.199 * libm::pow(1.0 - libm::sin(angle), 4.0))
        / libm::cos(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_crack_factor_is_the_tabulated_one() {
        // Pure bending by the other fit, 1.122 − 1.40 d + 7.33 d² − 13.08 d³ + 14 d⁴ (d ≤ 0.6); the two
        // agree to 2.5 %.
        for d in [1e-6_f64, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6] {
            let fit = 1.122 - 1.40 * d + 7.33 * d.powi(2) - 13.08 * d.powi(3) + 14.0 * d.powi(4);
            let ratio = edge_crack_bending(d) / fit;
            assert!((ratio - 1.0).abs() < 0.025, "d = {d}: {ratio}");
        }
    }
}
