//! Replicates of any statistic.

use rayon::prelude::*;

use super::intervals::{basic_interval, bca_interval, percentile_interval};
use super::{Plan, Weights};
use crate::EvalError;
use crate::statistic::{Interval, Measured, Method};

/// Fewer units than these, and their draws are no picture of other units.
const MIN_UNITS: u32 = 5;

/// Groups of units that the jackknife of [`Replicates::bca`] leaves out one after the other.
const MAX_GROUPS: u32 = 200;

/// Values of several statistics: of the sample, of all bootstrap replicates, and with each group of
/// units left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Replicates {
    level: f64,
    n_units: u32,
    /// Of the sample itself, per statistic.
    pub whole: Vec<Option<f64>>,
    /// Per statistic, one value per replicate; `None` where a draw leaves the statistic undefined.
    pub values: Vec<Vec<Option<f64>>>,
    /// Per statistic, with one group of units left out after the other; empty with more than one
    /// pattern.
    left_out: Vec<Vec<Option<f64>>>,
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
    F: Fn(&Weights) -> Vec<Option<f64>> + Sync,
{
    plan.check()?;
    let clean = |values: Vec<Option<f64>>| -> Vec<Option<f64>> {
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        values.into_iter().map(finite).collect()
    };
    let whole = clean(statistic(&plan.ones()));
    let rows: Vec<Vec<Option<f64>>> = (0..plan.n_replicates)
        .into_par_iter()
        .map(|replicate| clean(statistic(&plan.weights(replicate))))
        .collect();
    let n_groups = if plan.n_patterns() > 1 {
        0
    } else {
        plan.n_units().min(MAX_GROUPS)
    };
    let without: Vec<Vec<Option<f64>>> = (0..n_groups)
        .into_par_iter()
        .map(|group| clean(statistic(&plan.without_group(group, n_groups))))
        .collect();
    let column = |rows: &[Vec<Option<f64>>], place: usize| -> Vec<Option<f64>> {
        rows.iter()
            .map(|row| row.get(place).copied().flatten())
            .collect()
    };
    let n_statistics = whole.len();
    Ok(Replicates {
        level: plan.level,
        n_units: plan.n_units(),
        values: (0..n_statistics)
            .map(|place| column(&rows, place))
            .collect(),
        left_out: (0..n_statistics)
            .map(|place| column(&without, place))
            .collect(),
        whole,
    })
}

impl Replicates {
    /// A statistic with its percentile interval; n are the units drawn.
    #[must_use]
    pub fn percentile(&self, place: usize, method: Method) -> Measured {
        self.measured(place, method, |_, values| {
            percentile_interval(values, self.level)
                .ok_or_else(|| "there are too few replicates".to_owned())
        })
    }

    /// A statistic with its basic interval, cut to `bounds`; n are the units drawn.
    #[must_use]
    pub fn basic(&self, place: usize, method: Method, bounds: [f64; 2]) -> Measured {
        self.measured(place, method, |whole, values| {
            basic_interval(whole, values, self.level, bounds)
                .ok_or_else(|| "there are too few replicates".to_owned())
        })
    }

    /// A statistic with its bias-corrected and accelerated interval; n are the units drawn.
    ///
    /// The acceleration is by a jackknife over single units, or over 200 groups of them where there
    /// are more.
    #[must_use]
    pub fn bca(&self, place: usize, method: Method) -> Measured {
        self.measured(place, method, |whole, values| {
            let left_out: Option<Vec<f64>> = self
                .left_out
                .get(place)
                .and_then(|values| values.iter().copied().collect());
            let Some(left_out) = left_out.filter(|values| values.len() > 1) else {
                return Err("the jackknife is undefined here; use the percentiles".to_owned());
            };
            bca_interval(whole, values, &left_out, self.level).ok_or_else(|| {
                "replicates or jackknife do not vary on both sides of the value; use the percentiles"
                    .to_owned()
            })
        })
    }

    fn measured(
        &self,
        place: usize,
        method: Method,
        interval: impl Fn(f64, &[f64]) -> Result<Interval, String>,
    ) -> Measured {
        let n = u64::from(self.n_units);
        let Some(whole) = self.whole.get(place).copied().flatten() else {
            return Measured::none(n, method, "undefined in the sample itself");
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
                "no interval: {n_undefined} of {} draws leave it undefined",
                all.len()
            ));
            return without;
        }
        let first = values.first().copied().unwrap_or(whole);
        let spread = values.iter().map(|value| (value - first).abs());
        let is_alike = spread.fold(0.0_f64, f64::max) <= 1e-12 * whole.abs();
        let found = match () {
            () if self.n_units < MIN_UNITS => Err(format!(
                "{} units are too few to draw from, fewer than {MIN_UNITS}",
                self.n_units
            )),
            () if is_alike => Err("all draws give the same".to_owned()),
            () => interval(whole, &values),
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
