use serde::{Deserialize, Serialize};

use crate::statistic::Measured;

/// A number with its interval and with what it rests on, or why there is none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Estimate {
    /// The number itself.
    pub value: Option<f64>,
    /// Lower end of its 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper end of its 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// How many things it rests on: objects, pairs or images, as the row says.
    pub n: u64,
    /// Why there is no number, in plain words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

impl Estimate {
    /// A number alone; one that is not finite is refused.
    #[must_use]
    pub fn of(value: f64, n: u64) -> Self {
        if value.is_finite() {
            return Self {
                value: Some(value),
                n,
                ..Self::default()
            };
        }
        Self::refused(n, "not a finite number")
    }

    /// A number with the ends of its interval.
    #[must_use]
    pub fn with_interval(value: f64, [low, high]: [f64; 2], n: u64) -> Self {
        let mut estimate = Self::of(value, n);
        if estimate.value.is_some() && low.is_finite() && high.is_finite() {
            (estimate.low, estimate.high) = (Some(low), Some(high));
        }
        estimate
    }

    /// No number, and why.
    #[must_use]
    pub fn refused(n: u64, why: impl Into<String>) -> Self {
        Self {
            n,
            refused: Some(why.into()),
            ..Self::default()
        }
    }

    /// No number, since it would rest on fewer objects than the least that one is given of. How many there are
    /// stands beside it in `n`, so that a table has one note for all.
    #[must_use]
    pub fn few(n: u64, least: u64) -> Self {
        Self::refused(n, format!("fewer than {least} objects"))
    }

    /// Both ends of the interval.
    #[must_use]
    pub fn interval(&self) -> Option<[f64; 2]> {
        Some([self.low?, self.high?])
    }
}

impl From<&Measured> for Estimate {
    /// The number as a reader gets it; without one the reason is there.
    fn from(measured: &Measured) -> Self {
        match (measured.value, measured.interval) {
            (Some(value), Some(ends)) => {
                Self::with_interval(value, [ends.low, ends.high], measured.n)
            }
            (Some(value), None) => Self::of(value, measured.n),
            (None, _) => {
                let why = measured.reason.as_deref().unwrap_or("not defined");
                Self::refused(measured.n, why)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Estimate;

    #[test]
    fn a_number_that_is_none_is_refused() {
        let estimate = Estimate::with_interval(f64::NAN, [0.0, 1.0], 3);
        assert_eq!(estimate.value, None, "no value");
        assert_eq!(estimate.interval(), None, "and no interval of it");
        assert!(estimate.refused.is_some(), "but a reason");
        let half = Estimate::with_interval(0.5, [f64::NAN, 1.0], 3);
        assert_eq!(half.interval(), None, "an interval has two ends");
    }
}
