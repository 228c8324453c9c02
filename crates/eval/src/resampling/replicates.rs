//! Replicates of any statistic.

use rayon::prelude::*;

use super::intervals::{expanded_interval, percentile_interval};
use super::{Basis, Plan};
use crate::EvalError;
use crate::statistic::{Interval, MIN_UNITS, Measured, Method};

/// Values of several statistics: of the sample, and of all bootstrap replicates.
#[derive(Debug, Clone, PartialEq)]
pub struct Replicates {
    level: f64,
    n_units: u32,
    /// Of the sample itself, per statistic.
    pub whole: Vec<Option<f64>>,
    /// Per statistic, one value per replicate; `None` where a draw leaves the statistic undefined.
    pub values: Vec<Vec<Option<f64>>>,
    /// Per statistic, by how much halves of the images have more of it than all; empty where it is not
    /// known.
    leans: Vec<f64>,
}

/// Replicates of `statistic`, which gives for weights one value per statistic, always in the same
/// number and order, `None` where one is undefined.
///
/// Replicates are computed on all threads; the result does not depend on their number.
///
/// # Errors
/// If the plan has no replicates or no proper level.
pub fn bootstrap<F>(plan: &Plan, statistic: F) -> Result<Replicates, EvalError>
where
    F: Fn(&[u32]) -> Vec<Option<f64>> + Sync,
{
    plan.check()?;
    let whole = statistic(&vec![1; plan.n_images()]);
    let rows: Vec<Vec<Option<f64>>> = (0..plan.n_replicates)
        .into_par_iter()
        .map(|replicate| statistic(&plan.weights(replicate)))
        .collect();
    Ok(Replicates::of(plan, &whole, &rows))
}

impl Replicates {
    fn of(plan: &Plan, whole: &[Option<f64>], rows: &[Vec<Option<f64>>]) -> Self {
        let column = |place: usize| rows.iter().map(|row| finite(row, place)).collect();
        Self {
            level: plan.level,
            n_units: plan.n_units(),
            values: (0..whole.len()).map(column).collect(),
            whole: (0..whole.len()).map(|place| finite(whole, place)).collect(),
            leans: Vec::new(),
        }
    }

    /// From the values of each draw, by its place among all of the plan: replicates, and how much each statistic leans
    /// to above in few images. That is as much as halves of the images, in random pairs, have more of it than all have:
    /// what leans by c/n over n images leans by 2c/n over n/2, so that the step from half to all is what is left at n.
    ///
    /// Intervals of [`expanded`](Self::expanded) average precisions reach lower by it.
    pub(crate) fn of_draws(plan: &Plan, values: impl Fn(usize) -> Vec<Option<f64>>) -> Self {
        let rows: Vec<Vec<Option<f64>>> = plan.replicate_draws().map(&values).collect();
        let mut replicates = Self::of(plan, &values(0), &rows);
        let pairs: Vec<[Vec<Option<f64>>; 2]> = plan
            .half_draws()
            .map(|first| [values(first), values(first + 1)])
            .collect();
        let lean = |(place, whole): (usize, &Option<f64>)| {
            let means: Vec<f64> = pairs
                .iter()
                .filter_map(|[one, other]| {
                    Some(0.5 * (finite(one, place)? + finite(other, place)?))
                })
                .collect();
            match whole {
                Some(whole) if !means.is_empty() => {
                    means.iter().sum::<f64>() / means.len() as f64 - whole
                }
                _ => 0.0,
            }
        };
        replicates.leans = replicates.whole.iter().enumerate().map(lean).collect();
        replicates
    }

    /// A statistic with its percentile interval; n are the units drawn.
    #[must_use]
    pub fn percentile(&self, place: usize, method: Method) -> Measured {
        self.measured(place, method, |values| {
            percentile_interval(values, self.level).ok_or_else(|| "too few replicates".to_owned())
        })
    }

    /// A statistic with its expanded percentile interval, from which the low end of an average precision is
    /// lower by what it leans to above where that is known; n are the units drawn.
    #[must_use]
    pub fn expanded(&self, place: usize, method: Method, basis: Basis) -> Measured {
        let lean = match method {
            Method::AveragePrecision => self.leans.get(place).copied().unwrap_or(0.0).max(0.0),
            _ => 0.0,
        };
        self.based(place, method, basis, |values| {
            let found = expanded_interval(values, self.level, basis)?;
            // No precision is below 0.
            let low = if lean > 0.0 {
                (found.low - lean).max(0.0)
            } else {
                found.low
            };
            Some(Interval { low, ..found })
        })
    }

    /// A statistic with the wider, at each end, of its expanded percentile interval and one that is known
    /// otherwise; none where either is missing.
    pub(crate) fn expanded_to(
        &self,
        place: usize,
        method: Method,
        basis: Basis,
        interval: Option<Interval>,
    ) -> Measured {
        self.based(place, method, basis, |values| {
            let (of_draws, other) = (expanded_interval(values, self.level, basis)?, interval?);
            Some(Interval {
                low: of_draws.low.min(other.low),
                high: of_draws.high.max(other.high),
                ..of_draws
            })
        })
    }

    /// A statistic with an interval that is known otherwise, where its own draws would have one.
    pub(crate) fn with_interval(
        &self,
        place: usize,
        method: Method,
        basis: Basis,
        interval: Option<Interval>,
    ) -> Measured {
        self.based(place, method, basis, |_| interval)
    }

    fn based(
        &self,
        place: usize,
        method: Method,
        basis: Basis,
        interval: impl Fn(&[f64]) -> Option<Interval>,
    ) -> Measured {
        self.measured(place, method, |values| match basis {
            Basis::Units(n @ ..MIN_UNITS) => Err(format!(
                "its objects are in {n} resampling units, fewer than {MIN_UNITS}"
            )),
            _ => interval(values).ok_or_else(|| "too few replicates".to_owned()),
        })
    }

    fn measured(
        &self,
        place: usize,
        method: Method,
        interval: impl Fn(&[f64]) -> Result<Interval, String>,
    ) -> Measured {
        let n = u64::from(self.n_units);
        let Some(whole) = self.whole.get(place).copied().flatten() else {
            return Measured::none(n, method, "undefined for the sample itself");
        };
        let all = self.values.get(place).map_or(&[][..], Vec::as_slice);
        let values: Vec<f64> = all.iter().copied().flatten().collect();
        let measured = Measured::of(whole, n, method);
        // Draws that leave the statistic undefined say nothing; too many, and what is left is no
        // picture of it.
        let n_undefined = all.len() - values.len();
        if n_undefined * 20 > all.len() {
            let mut without = measured;
            without.reason = Some(format!(
                "no interval: it is undefined in {n_undefined} of {} replicates",
                all.len()
            ));
            return without;
        }
        let first = values.first().copied().unwrap_or(whole);
        let spread = values.iter().map(|value| (value - first).abs());
        let is_alike = spread.fold(0.0_f64, f64::max) <= 1e-12 * whole.abs();
        let found = match () {
            () if self.n_units < MIN_UNITS => Err(format!(
                "{} resampling units, fewer than {MIN_UNITS}",
                self.n_units
            )),
            () if is_alike => Err("all replicates give the same value".to_owned()),
            () => interval(&values),
        };
        match found {
            Ok(interval) => measured.within(Some(interval)),
            Err(why) => {
                let mut without = measured;
                without.reason = Some(format!("no interval: {why}"));
                without
            }
        }
    }
}

fn finite(values: &[Option<f64>], place: usize) -> Option<f64> {
    values
        .get(place)
        .copied()
        .flatten()
        .filter(|it| it.is_finite())
}
