//! Frame rates and time bases, exact.

use std::fmt;
use std::str::FromStr;

use super::VideoError;

/// A positive fraction: frames per second, or seconds per tick of a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fraction {
    numerator: u32,
    denominator: u32,
}

impl Fraction {
    /// The fraction in lowest terms; `None` if either part is 0.
    #[must_use]
    pub fn new(numerator: u32, denominator: u32) -> Option<Self> {
        let (mut a, mut b) = (numerator, denominator);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        (numerator > 0 && denominator > 0).then(|| Self {
            numerator: numerator / a,
            denominator: denominator / a,
        })
    }

    /// What is above the line.
    #[must_use]
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// What is below the line.
    #[must_use]
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// One over it.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            numerator: self.denominator,
            denominator: self.numerator,
        }
    }

    /// The number nearest to it.
    #[must_use]
    pub fn value(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    /// Seconds after `ticks` of a clock with this many seconds per tick.
    #[must_use]
    pub fn seconds(self, ticks: i64) -> f64 {
        #[expect(
            clippy::cast_precision_loss,
            reason = "exact below 2^53 ticks, which is centuries"
        )]
        let ticks = ticks as f64;
        ticks * f64::from(self.numerator) / f64::from(self.denominator)
    }
}

impl fmt::Display for Fraction {
    /// `30000/1001`, or `25` where the denominator is 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.numerator)?;
        match self.denominator {
            1 => Ok(()),
            denominator => write!(f, "/{denominator}"),
        }
    }
}

impl FromStr for Fraction {
    type Err = VideoError;

    /// A frame rate: a fraction of whole numbers or a decimal of up to three places.
    fn from_str(text: &str) -> Result<Self, VideoError> {
        let parsed = match text.trim().split_once('/') {
            Some((above, below)) => match (above.trim().parse(), below.trim().parse()) {
                (Ok(above), Ok(below)) => Self::new(above, below),
                _ => None,
            },
            None => decimal(text.trim()),
        };
        parsed
            .filter(|rate| (0.001..=1000.0).contains(&rate.value()))
            .ok_or_else(|| VideoError::Rate {
                given: text.to_owned(),
            })
    }
}

/// A decimal number of up to three places as thousandths.
fn decimal(text: &str) -> Option<Fraction> {
    let (whole, places) = text.split_once('.').unwrap_or((text, ""));
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || places.len() > 3 || !is_digits(whole) || !is_digits(places) {
        return None;
    }
    let thousandths: u32 = format!("{whole}{places:0<3}").parse().ok()?;
    Fraction::new(thousandths, 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_exactly() {
        for (text, numerator, denominator) in [
            ("25", 25, 1),
            ("30000/1001", 30_000, 1001),
            ("29.97", 2997, 100),
            (" 23.976 ", 2997, 125),
            ("60/2", 30, 1),
            ("0.5", 1, 2),
        ] {
            let rate = Fraction::from_str(text).ok();
            assert_eq!(rate, Fraction::new(numerator, denominator), "{text}");
            assert!(rate.is_some(), "{text}");
        }
        for text in [
            "", "0", "-3", "nan", "1/0", "0/1", "1e3", "1.2345", "2000", ".5", "1/2/3",
        ] {
            assert!(Fraction::from_str(text).is_err(), "{text:?} was accepted");
        }
    }

    #[test]
    fn a_clock_counts_without_drift() {
        let tick = Fraction::new(1001, 30_000).map(|tick| tick.seconds(30_000));
        assert_eq!(tick, Some(1001.0), "30000 ticks");
    }
}
