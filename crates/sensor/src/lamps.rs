//! Lamps on the mains, seen by a sensor that reads its rows one after the other: bands across the picture.

use std::f64::consts::PI;

/// Light that pulses with twice the frequency of the mains. A row that is exposed for τ from t on sees \[own
/// integral of 1 + m cos(4πft + φ)\]
///
/// 1 + m sinc(2fτ) cos(4πf(t + τ/2) + φ), sinc x = sin πx/πx
///
/// and row y begins y·row_s after the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamps {
    /// Frequency of the mains, Hz: 50 or 60.
    pub mains_hz: f64,
    /// How far the light goes up and down, a share of its mean.
    pub depth: f64,
    /// From the beginning of a row to that of the next, s.
    pub row_s: f64,
    /// How long a row is exposed, s.
    pub exposure_s: f64,
}

impl Lamps {
    /// Depth of the bands, a share: what the exposure leaves of that of the light.
    #[must_use]
    pub fn band_depth(&self) -> f64 {
        let x = PI * 2.0 * self.mains_hz * self.exposure_s;
        let sinc = if x == 0.0 { 1.0 } else { libm::sin(x) / x };
        self.depth * sinc
    }

    /// Whether nothing is seen of the pulses: there are none, or rows are exposed for whole ones.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.band_depth().abs() < 1e-9
    }

    /// Light of a row over that without pulses, in a frame that begins at a time; `phase` in turns.
    #[must_use]
    pub fn gain(&self, row: f64, time_s: f64, phase: f64) -> f64 {
        let middle_s = time_s + row * self.row_s + 0.5 * self.exposure_s;
        let turns = 2.0 * self.mains_hz * middle_s + phase;
        1.0 + self.band_depth() * libm::cos(2.0 * PI * (turns - turns.floor()))
    }
}
