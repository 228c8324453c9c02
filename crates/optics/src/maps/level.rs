//! How large the cells are on which a disc is spread.

/// Fewest cells per radius of a disc where cells are pixels, and where they are larger.
const CELLS_PER_RADIUS: [f64; 2] = [4.0, 6.0];

/// The same where cells are smaller than pixels, each of which is the mean over several.
const SMALL_CELLS_PER_RADIUS: f64 = 2.6;

/// Exponents of two of the finest and the coarsest number of cells per pixel, but for large discs.
const LEVELS: std::ops::RangeInclusive<i32> = -3..=2;

/// Fewest cells per radius of a large disc, whose cells are coarser than that: a disc is as smooth
/// as it is large, so that more would show nothing more. It begins at 384 px.
const CELLS_PER_LARGE_RADIUS: f64 = 24.0;

/// Exponent of the coarsest cells of all, of which some dozens are still counted in 32 bits of px.
const COARSEST: i32 = -24;

/// A larger disc, px, counts as one of this size; it is far beyond any lens.
pub(super) const MOST_RADIUS_PX: f64 = 4e8;

/// Discs of fewer cells are scattered from the cells that were covered, not from shared ones:
/// sharing would blur more than the disc.
const FEW_CELLS: f64 = 0.5;

/// Radius of a disc, px, from which what is drawn is not drawn on cells that are smaller than pixels.
const BLURRED_PX: f64 = 2.2;

/// A disc of a smaller radius, px, is a point.
const IN_FOCUS_PX: f64 = 0.02;

/// A size of cells, and whether coverage is found on halves of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Level {
    /// Cells per px as a power of two.
    pub(super) exponent: i32,
    pub(super) is_halved: bool,
}

/// The exponent of the least power of two that is not below a number above 0.
fn next_power_of_two(value: f64) -> i32 {
    const DIGITS: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = value.to_bits();
    let exponent = i32::try_from(bits >> DIGITS).unwrap_or(i32::MAX) - (f64::MAX_EXP - 1);
    exponent + i32::from(!bits.is_multiple_of(1 << DIGITS))
}

impl Level {
    pub(super) fn of(radius_px: f64) -> Self {
        if radius_px.abs() < IN_FOCUS_PX {
            // Exact coverage of the pixels themselves.
            return Self {
                exponent: 0,
                is_halved: false,
            };
        }
        let exponent_for = |cells: f64| -> i32 {
            // Also right for a radius of 0.
            next_power_of_two(cells / radius_px.abs()).clamp(COARSEST, 9)
        };
        let [equal, coarse] = CELLS_PER_RADIUS.map(exponent_for);
        // Where pixels are too coarse, halves of them at least.
        let small = exponent_for(SMALL_CELLS_PER_RADIUS).max(equal.min(1));
        let exponent = small
            .max(coarse.min(0))
            .clamp(*LEVELS.start(), *LEVELS.end())
            .min(exponent_for(CELLS_PER_LARGE_RADIUS));
        Self {
            exponent,
            is_halved: libm::scalbn(radius_px.abs(), exponent) >= FEW_CELLS,
        }
    }

    /// The same of what is drawn cell by cell, each of which takes a ray: 4 of a px at most, and one of a px that is
    /// blurred with its neighbors.
    pub(super) fn of_drawn(radius_px: f64) -> Self {
        let level = Self::of(radius_px);
        let most = i32::from(radius_px.abs() < BLURRED_PX);
        Self {
            exponent: level.exponent.min(most),
            // Nothing is shared.
            is_halved: false,
        }
    }

    /// Weights by which a half of a cell, a quarter of a cell off its middle, is shared along one
    /// axis: with the cell on its far side, its own, the one on its near side.
    ///
    /// They keep sum and mean, and their second moment, cells², makes up for all that blurs
    /// besides the disc and the pixel itself: the half's own width, and for coarse cells the
    /// kernel's cells.
    pub(super) fn weights(self) -> [f32; 3] {
        let kernel = if self.exponent >= 0 { 0.0 } else { 1.0 / 12.0 };
        let second = 1.0 / 16.0 - 1.0 / 48.0 - kernel;
        [0.5 * (second - 0.25), 1.0 - second, 0.5 * (second + 0.25)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_of_two_is_its_own_next() {
        for exponent in -30..=30 {
            let power = libm::scalbn(1.0, exponent);
            assert_eq!(next_power_of_two(power), exponent, "{power}");
            assert_eq!(next_power_of_two(1.001 * power), exponent + 1, "{power}");
            assert_eq!(next_power_of_two(0.999 * power), exponent, "{power}");
        }
        assert!(next_power_of_two(f64::INFINITY) > 1000, "of no radius");
    }
}
