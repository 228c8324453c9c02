//! How far a star of a laminate comes: the tip's law on the closed form of a plate on a foundation,
//! with no look at the plate, the tips and the competition that the physics solves.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use starbreak_fracture::contact::contact_load;
use starbreak_fracture::physics::{GlassPane, StoneImpact};

/// ker(x) and kei'(x), from ker + i kei = K₀(x e^{iπ/4}) = ∫₀^∞ exp(−x e^{iπ/4} cosh t) dt.
fn kelvin(x: f64) -> [f64; 2] {
    let step = 0.01;
    let (mut ker, mut kei_slope) = (0.0, 0.0);
    for k in 0..1200_u32 {
        // The trapezoidal rule: the integrand is even, so half of the first counts.
        let weight = if k == 0 { 0.5 * step } else { step };
        let cosh = libm::cosh(step * f64::from(k));
        let phase = x * FRAC_1_SQRT_2 * cosh;
        let (sin, cos) = libm::sincos(phase);
        let fades = weight * libm::exp(-phase);
        ker += fades * cos;
        kei_slope -= fades * FRAC_1_SQRT_2 * cosh * (cos - sin);
    }
    [ker, kei_slope]
}

/// Hoop tension of the far face of an unbounded plate on a foundation of length ℓ, Pa, at r from a
/// point force: w = −(Pℓ²/2πD) kei(r/ℓ), M_θ = (P/2π)((1 − ν) kei'(x)/x + ν ker(x)), x = r/ℓ, by
/// Δkei = ker \[Timoshenko1959\].
fn hoop_pa(pane: &GlassPane, length_m: f64, force_n: f64, r_m: f64) -> f64 {
    let (h, nu) = (pane.thickness_m, pane.material.poisson_ratio.value);
    let x = r_m / length_m;
    let [ker, kei_slope] = kelvin(x);
    6.0 / (h * h) * force_n / (2.0 * PI) * ((1.0 - nu) * kei_slope / x + nu * ker)
}

/// What K of `n` equal arms of length r is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StarLaw {
    /// σ(qr)√(π min(1.5 f r, 0.95 s/π)), q = min(1, 0.64 + 0.035 n), s = 2πr/n: calibrated against the
    /// energy that finite elements release.
    Calibrated,
    /// σ(r)√(π f min(r, s/2π)), which the figures of the design are from.
    Design,
}

/// The length at which n equal arms come to rest under the highest force of the stone, K = `K_IC`,
/// m; 0 where they never run, `None` where there is no foundation.
pub(crate) fn arrest_m(
    pane: &GlassPane,
    stone: &StoneImpact,
    n_arms: f64,
    star_law: StarLaw,
) -> Option<f64> {
    let length_m = pane.foundation_length_m()?;
    let force_n = contact_load(stone, &pane.material, pane.thickness_m).peak_force_n;
    let nu = pane.material.poisson_ratio.value;
    let factor = (1.0 + nu) / (3.0 * (3.0 + nu));
    let toughness = pane.material.fracture_toughness_pa_sqrt_m.value;
    let runs = |r_m: f64| {
        let (place, effective_m) = match star_law {
            StarLaw::Calibrated => (
                (0.64 + 0.035 * n_arms).min(1.0),
                r_m * (1.5 * factor).min(1.9 / n_arms),
            ),
            StarLaw::Design => (1.0, r_m * factor * (1.0 / n_arms).min(1.0)),
        };
        let tension_pa = hoop_pa(pane, length_m, force_n, place * r_m).max(0.0);
        tension_pa * (PI * effective_m).sqrt() >= toughness
    };
    // The farthest of fine steps at which it still runs.
    let step_m = 5e-3 * length_m;
    let farthest = (1..=1000_u32)
        .map(|k| step_m * f64::from(k))
        .filter(|&r_m| runs(r_m))
        .fold(0.0, f64::max);
    Some(farthest)
}
