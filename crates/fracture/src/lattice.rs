//! Positions on a lattice of powers of two, so fine that no picture can show it and so coarse
//! that two different nodes are never closer than one step.

use starbreak_glass::Pane;

/// Bits per coordinate: products of two differences keep every bit of an `f64`.
const BITS: i32 = 26;

/// At this size neighboring numbers are one apart.
const INTEGER: f64 = 6_755_399_441_055_744.0;

/// The lattice of a pane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice {
    step: f64,
}

impl Lattice {
    /// Step 2^⌈log2(longer side)⌉ / 2^26: for 1242 px it is 2^-15 px.
    pub(crate) fn of_pane(pane: &Pane) -> Self {
        let longer = pane.width.max(pane.height);
        Self {
            step: libm::exp2(libm::ceil(libm::log2(longer)) - f64::from(BITS)),
        }
    }

    /// Distance of two neighboring positions.
    pub(crate) fn step(self) -> f64 {
        self.step
    }

    /// The nearest lattice position.
    pub(crate) fn round(self, value: f64) -> f64 {
        // Adding and subtracting 1.5·2^52 rounds to an integer without a call to the math library.
        ((value / self.step + INTEGER) - INTEGER) * self.step
    }

    /// The nearest lattice position strictly between 0 and `side`, where there is one.
    pub(crate) fn round_inside(self, value: f64, side: f64) -> f64 {
        self.round(value).min(side - self.step).max(self.step)
    }
}
