//! Crack tips: the law of their motion, and the tracing of many at once.

mod gaps;
mod law;
#[cfg(test)]
mod tests;
mod tracer;
mod web;

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;

use crate::mesh::uniform;

pub(crate) use gaps::COMPETITION;
pub(crate) use law::{Gaps, TERMINAL_SPEED_M_S, TipLaw, crack_direction};
pub(crate) use tracer::{Ledger, MAX_STEPS, Motion, Tip, TipState, Tracing, trace, unit};
pub(crate) use web::{Piece, Web};

/// A standard normal number \[BoxMuller1958\].
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - uniform(rng))).sqrt();
    radius * libm::cos(2.0 * PI * uniform(rng))
}
