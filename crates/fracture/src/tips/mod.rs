//! Crack tips: the law of their motion, and the tracing of many at once.

mod gaps;
mod law;
#[cfg(test)]
mod tests;
mod tilt;
mod tracer;
mod web;

pub(crate) use gaps::COMPETITION;
pub(crate) use law::{Gaps, TERMINAL_SPEED_M_S, TipLaw, crack_direction};
pub(crate) use tilt::Tilt;
pub(crate) use tracer::{
    CORROSION_LIMIT, Ledger, MAX_STEPS, Motion, Tip, TipState, Tracing, trace, unit,
};
pub(crate) use web::{Piece, Web};
