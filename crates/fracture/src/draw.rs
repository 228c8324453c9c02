//! The random strength of glass, from a stream that the caller keeps.

use rand_chacha::rand_core::Rng;
use starbreak_seed::uniform;

/// Strength over characteristic strength by Weibull's law, kept within 0.5 to 1.5.
pub(crate) fn weibull_factor(modulus: f64, rng: &mut impl Rng) -> f64 {
    libm::pow(-libm::log(1.0 - uniform(rng)), 1.0 / modulus).clamp(0.5, 1.5)
}
