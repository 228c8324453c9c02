//! What drives, turns, divides and stops the tip of a crack.

use std::f64::consts::PI;

use starbreak_glass::Material;

use crate::stress::PlaneStress;

/// Shape factor of a through crack in a bent plate: K = σ √(f π L) with
/// f = (1+ν)/(3(3+ν)) \[HuiZehnder1993\]; 1 under membrane stress.
fn bending_factor(poisson_ratio: f64) -> f64 {
    (1.0 + poisson_ratio) / (3.0 * (3.0 + poisson_ratio))
}

/// Rayleigh speed over shear speed: (0.862 + 1.14 ν)/(1 + ν) \[Freund1990\].
fn rayleigh_fraction(poisson_ratio: f64) -> f64 {
    (0.862 + 1.14 * poisson_ratio) / (1.0 + poisson_ratio)
}

/// Terminal speed of cracks in soda-lime glass, m/s \[Schardin1959\].
pub(crate) const TERMINAL_SPEED_M_S: f64 = 1500.0;

/// Mirror constant over toughness, `A/K_IC`, √(1/m)·√m \[Abdel1982\].
const MIRROR_CONSTANT: f64 = 2.35;

/// The branching constant is a little above the mirror constant \[Quinn2020\].
const BRANCHING_OVER_MIRROR: f64 = 1.15;

/// Coefficient of variation of the branching constant. FIT: design value.
pub(crate) const BRANCHING_SCATTER: f64 = 0.06;

/// Effective lengths over the way that a tip remembers.
const MEMORY: f64 = 1.75;

/// Wander of a tip's direction over a way of one thickness, rad. FIT: legs look straight.
pub(crate) const WANDER_RAD: f64 = 2.0 * PI / 180.0;

/// The law of one material and thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TipLaw {
    pub(crate) toughness_pa_sqrt_m: f64,
    pub(crate) fracture_energy_j_m2: f64,
    pub(crate) rayleigh_m_s: f64,
    /// f of K = σ √(f π L).
    pub(crate) shape_factor: f64,
    pub(crate) thickness_m: f64,
    /// Whether the plate is bent, or under stress in its plane.
    is_bent: bool,
}

/// Distances to the cracks that run beside a tip, m; infinite where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gaps {
    pub(crate) left_m: f64,
    pub(crate) right_m: f64,
}

impl Gaps {
    pub(crate) const NONE: Self = Self {
        left_m: f64::INFINITY,
        right_m: f64::INFINITY,
    };

    /// Width of the strip that feeds a tip: the harmonic mean of the two gaps.
    pub(crate) fn strip_m(self) -> f64 {
        2.0 / (1.0 / self.left_m + 1.0 / self.right_m)
    }
}

impl TipLaw {
    /// The law for a crack through a plate that is bent, or under stress in its plane.
    pub(crate) fn new(material: &Material, thickness_m: f64, is_bent: bool) -> Self {
        let nu = material.poisson_ratio.value;
        let shear_modulus = material.young_modulus_pa.value / (2.0 * (1.0 + nu));
        let shear_speed = (shear_modulus / material.density_kg_m3.value).sqrt();
        Self {
            toughness_pa_sqrt_m: material.fracture_toughness_pa_sqrt_m.value,
            fracture_energy_j_m2: material.fracture_energy_j_m2(),
            rayleigh_m_s: rayleigh_fraction(nu) * shear_speed,
            shape_factor: if is_bent { bending_factor(nu) } else { 1.0 },
            thickness_m,
            is_bent,
        }
    }

    /// Length that counts: the crack's own, or that which a strip of the width between its
    /// neighbors gives.
    ///
    /// Under stress in the plane min(L, s/2π), as G = σ²s/2E of a strip. In a bent plate
    /// min(1.5 L, 0.95 s/πf): FIT to the energy release of hinge-line stars of 2 to 12 arms in
    /// the plate's own finite elements, within 15 % (13 % for glass; `examples/tip_calibration.rs`).
    pub(crate) fn effective_length_m(&self, length_m: f64, gaps: Gaps) -> f64 {
        if self.is_bent {
            let strip_m = 0.95 * gaps.strip_m() / (PI * self.shape_factor);
            strip_m.min(1.5 * length_m)
        } else {
            length_m.min(gaps.strip_m() / (2.0 * PI))
        }
    }

    /// The place along a crack, from its origin 0 to its tip 1, whose stress in the intact body
    /// counts for K: q = min(1, 0.64 + 0.035 n) of the arms n = 2πL/s of a star; 1 under stress
    /// in the plane. FIT as in [`TipLaw::effective_length_m`]: the arms of a star hand their load on
    /// to its front, the mean of a stress that falls with the logarithm lies at 0.6 L.
    pub(crate) fn stress_place(&self, length_m: f64, gaps: Gaps) -> f64 {
        if self.is_bent {
            let n_arms = 2.0 * PI * length_m / gaps.strip_m();
            (0.64 + 0.035 * n_arms).min(1.0)
        } else {
            1.0
        }
    }

    /// K = σ_n √(f π L_eff), 0 under compression.
    pub(crate) fn intensity(&self, normal_stress_pa: f64, effective_m: f64) -> f64 {
        normal_stress_pa.max(0.0) * (self.shape_factor * PI * effective_m).sqrt()
    }

    /// Mean stress after a step of `way_m` through `stress_pa`; `None` where only the stress at the tip
    /// counts.
    ///
    /// K of a crack is the integral of the intact body's stress along it with the weight
    /// (2/π)/√(1 − (x/L)²) \[TadaParisIrwin2000\], whose mean lies at 2L/π; a running mean over L/1.75
    /// has the same mean place.
    pub(crate) fn mean_stress_pa(
        &self,
        mean_pa: f64,
        stress_pa: f64,
        way_m: f64,
        effective_m: f64,
    ) -> Option<f64> {
        let forgotten = 1.0 - libm::exp(-MEMORY * way_m / effective_m.max(1e-9));
        (!self.is_bent).then_some(mean_pa + (stress_pa - mean_pa) * forgotten)
    }

    /// v = c_R (1 − (K_IC/K)²) up to the terminal speed \[Freund1990\]; 0 below K_IC.
    pub(crate) fn speed_m_s(&self, intensity: f64) -> f64 {
        if intensity <= self.toughness_pa_sqrt_m {
            return 0.0;
        }
        let ratio = self.toughness_pa_sqrt_m / intensity;
        (self.rayleigh_m_s * (1.0 - ratio * ratio)).min(TERMINAL_SPEED_M_S)
    }

    /// K at which a tip forks: σ √L = A_b in a membrane, so K = √π A_b; of `scatter` more.
    pub(crate) fn branching_intensity(&self, scatter: f64) -> f64 {
        PI.sqrt() * MIRROR_CONSTANT * BRANCHING_OVER_MIRROR * self.toughness_pa_sqrt_m * scatter
    }

    /// K over that of the mirror's rim: below 1 mirror, to 1.2 mist, above hackle.
    pub(crate) fn mirror_ratio(&self, intensity: f64) -> f64 {
        intensity / (PI.sqrt() * MIRROR_CONSTANT * self.toughness_pa_sqrt_m)
    }
}

/// Angle between the two branches of a fork, rad, from the ratio σ_II/σ_I of the stress state:
/// 15° under torsion (−1), 45° in one direction (0), 90° at 2:1 (½) and beyond
/// \[Preston1935\].
pub(crate) fn fork_angle_rad(stress: &PlaneStress) -> f64 {
    let (major, minor, _) = stress.principal();
    if major <= 0.0 {
        return 0.0;
    }
    let ratio = (minor / major).clamp(-1.0, 0.5);
    let degrees = if ratio < 0.0 {
        45.0 + 30.0 * ratio
    } else {
        45.0 + 90.0 * ratio
    };
    degrees.to_radians()
}

/// The direction that a tip turns to: across the most tensile stress, to the side it runs.
pub(crate) fn crack_direction(stress: &PlaneStress, running: [f64; 2]) -> [f64; 2] {
    let (_, _, [nx, ny]) = stress.principal();
    let along = [-ny, nx];
    if along[0] * running[0] + along[1] * running[1] < 0.0 {
        [ny, -nx]
    } else {
        along
    }
}
