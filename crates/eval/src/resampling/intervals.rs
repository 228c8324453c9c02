//! Intervals from replicates.

use super::Plan;
use crate::statistic::{Interval, Method, normal_cdf, student_quantile};

/// Percentiles (1 ∓ level)/2 of replicates, interpolated between the two nearest as by default in
/// NumPy; `None` for fewer than 20 replicates or a level outside of 0 to 1.
///
/// Two-sided, each tail on its own \[Efron1993\].
#[must_use]
pub fn percentile_interval(replicates: &[f64], level: f64) -> Option<Interval> {
    let sorted = usable(replicates, level)?;
    let tail = (1.0 - level) / 2.0;
    Some(Interval {
        low: quantile(&sorted, tail)?,
        high: quantile(&sorted, 1.0 - tail)?,
        level,
        method: Method::BootstrapPercentile,
    })
}

/// What a number rests on, which says how far its draws fall short of other images.
///
/// Drawing n units anew spreads a mean by √((n − 1)/n) of what n other units would, and knows
/// nothing of how few they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Basis {
    /// So many units.
    Units(u32),
    /// The mean over groups of so many units, each of which rests on `each` of them by the harmonic
    /// mean; as with AP over classes, of which each has objects in few images.
    Groups {
        /// All units.
        n_units: u32,
        /// Those of a group.
        each: f64,
    },
}

impl Basis {
    /// Of the mean over classes, of which these are the units with objects of each.
    pub(crate) fn of_classes(units: &[u32], plan: &Plan) -> Self {
        let (mut sum, mut n) = (0.0, 0.0);
        for n_units in units.iter().filter(|n_units| **n_units > 0) {
            sum += 1.0 / f64::from(*n_units);
            n += 1.0;
        }
        Self::Groups {
            n_units: plan.n_units(),
            each: if n > 0.0 { n / sum } else { 0.0 },
        }
    }

    /// How many standard errors an interval reaches, so that after the draws it holds the truth as
    /// often as `level` says: t of n − 1 degrees of freedom times √(n/(n − 1)), for groups of m units
    /// times √(m/(m − 1)) in its place. `None` for fewer than two units.
    fn reach(self, level: f64) -> Option<f64> {
        let (n_units, each) = match self {
            Self::Units(n) => (n, f64::from(n)),
            Self::Groups { n_units, each } => (n_units, each),
        };
        if n_units < 2 || each <= 1.0 {
            return None;
        }
        let t = student_quantile(0.5 + level / 2.0, f64::from(n_units - 1));
        Some(t * (each / (each - 1.0)).sqrt())
    }
}

/// The percentile interval made wider by what its draws fall short, the expanded percentile interval
/// \[Hesterberg2015\]: percentiles Φ(∓r) of the replicates, r being the reach of its [`Basis`].
///
/// Chosen by measurement among percentile, basic, bias-corrected and normal intervals: see
/// `docs/evaluation.md`. As [`percentile_interval`] otherwise.
#[must_use]
pub fn expanded_interval(replicates: &[f64], level: f64, basis: Basis) -> Option<Interval> {
    let sorted = usable(replicates, level)?;
    let reach = basis.reach(level)?;
    Some(Interval {
        low: quantile(&sorted, normal_cdf(-reach))?,
        high: quantile(&sorted, normal_cdf(reach))?,
        level,
        method: Method::BootstrapExpanded,
    })
}

/// Replicates in order, if they can carry an interval.
fn usable(replicates: &[f64], level: f64) -> Option<Vec<f64>> {
    let is_finite = replicates.iter().all(|it| it.is_finite());
    if replicates.len() < 20 || !is_finite || !(level > 0.0 && level < 1.0) {
        return None;
    }
    let mut sorted = replicates.to_vec();
    sorted.sort_by(f64::total_cmp);
    Some(sorted)
}

/// The value below which `share` of the sorted values lie, linear between neighbors.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    if !share.is_finite() {
        return None;
    }
    let place = share.clamp(0.0, 1.0) * last as f64;
    #[expect(
        clippy::cast_possible_truncation,
        reason = "between 0 and the last place"
    )]
    let before = (place.floor() as usize).min(last);
    let (low, high) = (sorted[before], sorted[(before + 1).min(last)]);
    Some(low + (high - low) * (place - before as f64))
}
