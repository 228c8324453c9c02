//! Intervals from replicates.

use crate::statistic::{Interval, Method, normal_cdf, normal_quantile};

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

/// The basic interval, `2·value − percentiles`: what the replicates lie above the value is what the
/// value is taken to lie above the truth \[Efron1993\]. As [`percentile_interval`] otherwise.
///
/// For statistics that lean to one side when units are drawn anew, as the AP of small classes does:
/// their percentiles may lie beside the value itself. Ends are cut to `bounds`.
#[must_use]
pub fn basic_interval(
    value: f64,
    replicates: &[f64],
    level: f64,
    bounds: [f64; 2],
) -> Option<Interval> {
    let percentiles = percentile_interval(replicates, level)?;
    let [least, most] = bounds;
    Some(Interval {
        low: (2.0 * value - percentiles.high).clamp(least, most),
        high: (2.0 * value - percentiles.low).clamp(least, most),
        level,
        method: Method::BootstrapBasic,
    })
}

/// The bias-corrected and accelerated interval \[Efron1987\].
///
/// z₀ = Φ⁻¹(share of replicates below the value, equal ones by half),
/// a = Σ(m − θᵢ)³ / (6 (Σ(m − θᵢ)²)^{3/2}) over the values θᵢ with one unit left out, of mean m; the
/// ends are the percentiles Φ(z₀ + (z₀ ± z)/(1 − a(z₀ ± z))).
///
/// `None` for fewer than 20 replicates, where all of them lie on one side of the value, or where
/// the jackknife does not vary.
#[must_use]
pub fn bca_interval(
    value: f64,
    replicates: &[f64],
    left_out: &[f64],
    level: f64,
) -> Option<Interval> {
    let sorted = usable(replicates, level)?;
    let below = sorted.partition_point(|it| *it < value);
    let up_to = sorted.partition_point(|it| *it <= value);
    let share = (below + up_to) as f64 / (2.0 * sorted.len() as f64);
    if !(share > 0.0 && share < 1.0) || left_out.len() < 2 {
        return None;
    }
    let bias = normal_quantile(share);
    let mean = left_out.iter().sum::<f64>() / left_out.len() as f64;
    let squares: f64 = left_out.iter().map(|it| (mean - it).powi(2)).sum();
    let cubes: f64 = left_out.iter().map(|it| (mean - it).powi(3)).sum();
    if squares <= 0.0 {
        return None;
    }
    let acceleration = cubes / (6.0 * squares.powf(1.5));
    let z = normal_quantile(0.5 + level / 2.0);
    let end = |z: f64| {
        let shifted = bias + z;
        let share = normal_cdf(bias + shifted / (1.0 - acceleration * shifted));
        quantile(&sorted, share)
    };
    Some(Interval {
        low: end(-z)?,
        high: end(z)?,
        level,
        method: Method::BootstrapBca,
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
