//! Lamps on the mains, seen by a sensor that reads its rows one after the other: bands across the picture.

use std::f64::consts::PI;

/// How the light of lamps goes up and down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pulse {
    /// A sine of twice the frequency of the mains.
    Mains {
        /// Of the mains, Hz: 50 or 60.
        mains_hz: f64,
    },
    /// Full or dark, as LEDs are dimmed.
    Led {
        /// Pulses per second.
        pulses_hz: f64,
        /// Share of the time in which there is light, above 0 to 1.
        duty: f64,
    },
}

/// Light that pulses, seen row by row: row y begins y·row_s after the first.
///
/// A row that is exposed for τ from t on sees, of lamps on the mains \[own integral of 1 + m cos(4πft + φ)\],
///
/// 1 + m sinc(2fτ) cos(4πf(t + τ/2) + φ), sinc x = sin πx/πx
///
/// and of LEDs 1 − m + m·o/(τ·duty), with o the time of the exposure in which there is light: none where the exposure
/// falls between two pulses. So an LED is seen at all with the chance min(1, duty + τf).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamps {
    /// How the light pulses.
    pub pulse: Pulse,
    /// Of the mains: how far the light goes up and down, a share of its mean. Of LEDs: their share of all light.
    pub depth: f64,
    /// From the beginning of a row to that of the next, s.
    pub row_s: f64,
    /// How long a row is exposed, s.
    pub exposure_s: f64,
}

impl Lamps {
    /// Pulses per second.
    #[must_use]
    pub fn pulses_hz(&self) -> f64 {
        match self.pulse {
            Pulse::Mains { mains_hz } => 2.0 * mains_hz,
            Pulse::Led { pulses_hz, .. } => pulses_hz,
        }
    }

    /// Depth of the bands, a share: what the exposure leaves of that of the light. Of LEDs it is how far the darkest row
    /// lies below the mean.
    #[must_use]
    pub fn band_depth(&self) -> f64 {
        match self.pulse {
            Pulse::Mains { .. } => {
                let x = PI * self.pulses_hz() * self.exposure_s;
                let sinc = if x == 0.0 { 1.0 } else { libm::sin(x) / x };
                self.depth * sinc
            }
            // Of whole pulses all light, and of the rest what does not fit into the dark time.
            Pulse::Led { duty, .. } => {
                let turns = self.exposure_s * self.pulses_hz();
                let least = turns.floor() * duty + (turns - turns.floor() - (1.0 - duty)).max(0.0);
                self.depth * (1.0 - least / (turns * duty))
            }
        }
    }

    /// Whether nothing is seen of the pulses: there are none, or rows are exposed for whole ones.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.band_depth().abs() < 1e-9
    }

    /// Light of a row over that without pulses, in a frame that begins at a time; `phase` in turns.
    #[must_use]
    pub fn gain(&self, row: f64, time_s: f64, phase: f64) -> f64 {
        let begin_s = time_s + row * self.row_s;
        match self.pulse {
            Pulse::Mains { .. } => {
                let middle_s = begin_s + 0.5 * self.exposure_s;
                let turns = self.pulses_hz() * middle_s + phase;
                1.0 + self.band_depth() * libm::cos(2.0 * PI * (turns - turns.floor()))
            }
            Pulse::Led { duty, pulses_hz } => {
                let seen = self.lit(pulses_hz * begin_s + phase);
                1.0 + self.depth * (seen / (self.exposure_s * pulses_hz * duty) - 1.0)
            }
        }
    }

    /// The chance that a row, or a lamp of a few rows, sees any light of an LED.
    #[must_use]
    pub fn seen(&self) -> f64 {
        match self.pulse {
            Pulse::Mains { .. } => 1.0,
            Pulse::Led { pulses_hz, duty } => (duty + self.exposure_s * pulses_hz).min(1.0),
        }
    }

    /// Turns with light in an exposure that begins at some turns.
    fn lit(&self, begin: f64) -> f64 {
        let Pulse::Led { pulses_hz, duty } = self.pulse else {
            return 0.0;
        };
        // With light from each whole turn on, for duty: all of it up to a time.
        let until = |turns: f64| {
            let whole = turns.floor();
            whole * duty + (turns - whole).min(duty)
        };
        until(begin + self.exposure_s * pulses_hz) - until(begin)
    }
}
