//! How many radial cracks leave a hit, and in which directions.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::Material;
use starbreak_seed::{normal, uniform};

use crate::tips::{Gaps, TipLaw};

/// Scatter of the number of radials, standard deviation of its logarithm.
/// FIT: \[Vandenberghe2013\] sees 4 and 8 where the law says 4.4 and 7.
const COUNT_SCATTER: f64 = 0.12;

/// Least distance of two radials over the mean one.
const HARD_CORE: f64 = 0.5;

/// Most radials that are thought of; they stand closer than a crushed zone can show.
const MAX_RADIALS: f64 = 200.0;

/// Mean number of radials n = C (V/c)^½ (E h/Γ)^¼ of a plate that nothing holds back
/// \[Vandenberghe2013\].
///
/// # Limits
/// The exponent ½ is measured; ¼ and h for the length are not: C is a calibration.
#[must_use]
pub fn mean_radial_count(
    material: &Material,
    thickness_m: f64,
    normal_speed_m_s: f64,
    factor: f64,
) -> f64 {
    let toughness_length =
        material.young_modulus_pa.value * thickness_m / material.fracture_energy_j_m2();
    factor
        * (normal_speed_m_s / material.bar_wave_speed_m_s()).sqrt()
        * toughness_length.sqrt().sqrt()
}

/// A number of radials around the mean.
pub(super) fn draw_count(mean: f64, rng: &mut ChaCha8Rng) -> u32 {
    whole_count(mean * libm::exp(COUNT_SCATTER * normal(rng)))
}

/// The nearest whole number of radials, of those that are thought of.
pub(super) fn whole_count(count: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 200"
    )]
    let count = libm::round(count.min(MAX_RADIALS)) as u32;
    count
}

/// `count` directions, none nearer to the next than half of the mean distance, more of them where
/// the stress is higher: density ∝ σ_θ^m, a weakest link of Weibull modulus m.
pub(super) fn draw_angles(
    count: u32,
    weibull_modulus: f64,
    hoop_stress_pa: impl Fn(f64) -> f64,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let samples = 64;
    let sample = |k: u32| f64::from(k) / f64::from(samples) * 2.0 * PI;
    let peak = (0..samples)
        .map(|k| hoop_stress_pa(sample(k)))
        .fold(0.0, f64::max);
    if peak <= 0.0 || count == 0 {
        return Vec::new();
    }
    let least = HARD_CORE * 2.0 * PI / f64::from(count);
    let mut angles: Vec<f64> = Vec::new();
    let mut tries = 0;
    while angles.len() < count as usize && tries < 400 * count {
        tries += 1;
        let angle = 2.0 * PI * uniform(rng);
        let weight = libm::pow(
            (hoop_stress_pa(angle) / peak).clamp(0.0, 1.0),
            weibull_modulus,
        );
        let is_free = angles.iter().all(|&other| {
            let distance = (angle - other).abs();
            distance.min(2.0 * PI - distance) >= least
        });
        if is_free && uniform(rng) < weight {
            angles.push(angle);
        }
    }
    angles.sort_unstable_by(f64::total_cmp);
    angles
}

/// Takes the weakest away until every radial can start: K at `start_m` is at least `K_IC` for all.
pub(super) fn cull(
    angles: &mut Vec<f64>,
    law: &TipLaw,
    start_m: f64,
    hoop_stress_pa: impl Fn(f64) -> f64,
) {
    while !angles.is_empty() {
        let n = angles.len();
        let gap_m = |from: usize, to: usize| {
            let angle = (angles[to] - angles[from]).rem_euclid(2.0 * PI);
            if n == 1 {
                f64::INFINITY
            } else {
                start_m * angle
            }
        };
        let intensity = |k: usize| {
            let gaps = Gaps {
                left_m: gap_m(k, (k + 1) % n),
                right_m: gap_m((k + n - 1) % n, k),
            };
            let effective_m = law.effective_length_m(start_m, gaps);
            law.intensity(hoop_stress_pa(angles[k]), effective_m)
        };
        let weakest = (0..n)
            .map(|k| (intensity(k), k))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match weakest {
            Some((least, k)) if least < law.toughness_pa_sqrt_m => {
                angles.remove(k);
            }
            _ => return,
        }
    }
}
