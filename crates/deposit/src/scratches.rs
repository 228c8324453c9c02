//! Scratches: fine grooves of sand and wipers, seen by the light that they turn.

use crate::{Coating, Passage};

/// Grooves in a pane, too fine to be seen one by one.
///
/// How many there are is said by their haze: the share of a beam that they turn by more than 2.5° \[ASTMD1003\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scratches {
    /// Haze, 0 to 0.2.
    pub haze: f64,
    /// Share of the haze that is of grooves along the wiper's way; those of sand have all directions.
    pub wiped: f64,
    /// What the wiper turns about, mm.
    pub pivot_mm: [f64; 2],
}

/// Angle beyond which turned light is haze, rad.
const HAZE_BEYOND_RAD: f64 = 2.5 * std::f64::consts::PI / 180.0;

/// Standard deviation per axis of what grooves of all directions turn, rad. FIT.
const SAND_RAD: f64 = 0.1;

impl Scratches {
    /// Half width of the light across grooves at half its height, rad: k ∝ 1/(θ₀² + θ²). FIT.
    pub const ACROSS_RAD: f64 = 1.0 * std::f64::consts::PI / 180.0;

    /// Largest angle of that, rad.
    pub const MOST_ACROSS_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

    /// Shares of light that grooves of all directions turn, and those along the wiper's way.
    #[must_use]
    pub fn turned(&self) -> [f64; 2] {
        let ratio = HAZE_BEYOND_RAD / SAND_RAD;
        let of_sand = libm::exp(-0.5 * ratio * ratio);
        let within = |rad: f64| libm::atan(rad / Self::ACROSS_RAD);
        let of_wiper = 1.0 - within(HAZE_BEYOND_RAD) / within(Self::MOST_ACROSS_RAD);
        [
            self.haze * (1.0 - self.wiped) / of_sand,
            self.haze * self.wiped / of_wiper,
        ]
    }

    pub(crate) fn on_pane(&self) -> ScratchedPane {
        ScratchedPane {
            turned: self.turned(),
            pivot_mm: self.pivot_mm,
        }
    }
}

/// Scratches of one pane.
pub(crate) struct ScratchedPane {
    /// As [`Scratches::turned`] says.
    turned: [f64; 2],
    pivot_mm: [f64; 2],
}

impl Coating for ScratchedPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let [sand, wiper] = self.turned;
        // Light is turned across a groove: towards the pivot and away.
        let [x, y] = [0, 1].map(|k| at_mm[k] - self.pivot_mm[k]);
        let far = libm::hypot(x, y).max(1e-6);
        #[expect(clippy::cast_possible_truncation, reason = "a direction")]
        let across = [x / far, y / far].map(|along| along as f32);
        Passage {
            covered: (sand + wiper).min(1.0),
            direct: [(1.0 - sand - wiper).max(0.0); 3],
            wide: sand,
            streak: wiper,
            across,
            ..Passage::CLEAN
        }
    }

    /// Nothing but the direction changes from place to place, and that little.
    fn apart_mm(&self) -> f64 {
        f64::INFINITY
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, SAND_RAD]
    }
}
