//! Random numbers of the shapes that fracture needs, from a stream that the caller keeps.

use std::f64::consts::TAU;

use rand_chacha::rand_core::Rng;

/// A uniform number in [0, 1) with 53 random bits.
pub(crate) fn uniform(rng: &mut impl Rng) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "53 bits fit an f64 exactly")]
    let bits = (rng.next_u64() >> 11) as f64;
    bits / 9_007_199_254_740_992.0
}

/// A standard normal number \[BoxMuller1958\].
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - uniform(rng))).sqrt();
    radius * libm::cos(TAU * uniform(rng))
}

/// Strength over characteristic strength by Weibull's law, kept within 0.5 to 1.5.
pub(crate) fn weibull_factor(modulus: f64, rng: &mut impl Rng) -> f64 {
    libm::pow(-libm::log(1.0 - uniform(rng)), 1.0 / modulus).clamp(0.5, 1.5)
}
