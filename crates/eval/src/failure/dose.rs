//! Failure over how strongly an object is hit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{LogisticFit, ObjectPair, fit_logistic};
use crate::EvalError;
use crate::resampling::{Plan, quantile};
use crate::statistic::{Measured, TestOutcome, clustered_share};

/// The failure rate of objects over a dose: coverage, displacement, blur, contrast lost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DoseResponse {
    /// What the dose is, with its unit, such as `coverage` or `displacement_px`.
    pub dose: String,
    /// By rising dose.
    pub bins: Vec<DoseBin>,
    /// A curve through the single objects.
    pub fit: LogisticFit,
    /// Its slope, with an interval by the variance between units.
    pub slope: Measured,
    /// Whether that is other than 0, by the same variance.
    pub test: TestOutcome,
    /// Objects found clean whose dose is not known.
    pub n_without_dose: u64,
}

/// Objects with a dose from `low` to below `high`; the last bin holds its end, too.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DoseBin {
    /// From here.
    pub low: f64,
    /// To here.
    pub high: f64,
    /// Mean dose of its objects.
    pub mean: Option<f64>,
    /// Objects found clean.
    pub n: u64,
    /// Those of them missed cracked.
    pub n_lost: u64,
    /// Their share, with Wilson's interval over images or clusters.
    pub failure_rate: Measured,
}

/// Failure over a dose: in the bins between rising `edges`, and as a logistic curve with the
/// units of the plan, images or clusters of them, as clusters. Only objects found clean count.
///
/// Each pair comes with its dose; one that is not finite is taken as not known. Doses outside of the
/// edges count for the curve alone.
///
/// # Errors
/// If the edges do not rise, or an image is not in the plan.
pub fn dose_response<'a>(
    name: &str,
    pairs: impl IntoIterator<Item = (&'a ObjectPair, f64)>,
    edges: &[f64],
    plan: &Plan,
) -> Result<DoseResponse, EvalError> {
    if let Some(pair) = edges.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Err(EvalError::StatisticSetting {
            what: "edge of a bin",
            value: pair[1],
            range: "above the one before",
        });
    }
    let (mut doses, mut failed, mut units) = (Vec::new(), Vec::new(), Vec::new());
    let mut n_without_dose = 0;
    for (pair, dose) in pairs.into_iter().filter(|(pair, _)| pair.clean.is_some()) {
        if dose.is_finite() {
            doses.push(dose);
            failed.push(pair.is_lost());
            units.push(plan.unit(pair.image)?);
        } else {
            n_without_dose += 1;
        }
    }
    let n_bins = edges.len().saturating_sub(1);
    let bin = |(place, ends): (usize, &[f64])| {
        let (low, high) = (ends[0], ends[1]);
        let holds = |it: f64| it >= low && (it < high || place + 1 == n_bins && it <= high);
        let (mut sum, mut n, mut n_lost) = (0.0, 0_u64, 0_u64);
        let mut clusters = BTreeMap::<u32, [u64; 2]>::new();
        let rows = doses.iter().zip(&failed).zip(&units);
        for ((dose, failed), unit) in rows.filter(|((dose, _), _)| holds(**dose)) {
            sum += dose;
            n += 1;
            n_lost += u64::from(*failed);
            let counts = clusters.entry(*unit).or_default();
            *counts = [counts[0] + u64::from(*failed), counts[1] + 1];
        }
        let clusters: Vec<[u64; 2]> = clusters.into_values().collect();
        DoseBin {
            low,
            high,
            mean: (n > 0).then(|| sum / n as f64),
            n,
            n_lost,
            failure_rate: clustered_share(&clusters, plan.level),
        }
    };
    let bins = edges.windows(2).enumerate().map(bin).collect();
    let fit = fit_logistic(&doses, &failed, &units, plan.level);
    units.sort_unstable();
    units.dedup();
    let (slope, test) = fit.slope.between_units(units.len(), plan.level);
    Ok(DoseResponse {
        dose: name.to_owned(),
        bins,
        fit,
        slope,
        test,
        n_without_dose,
    })
}

/// Edges of up to `n_bins` bins with about as many values in each; fewer where values are equal,
/// none where all are.
#[must_use]
pub fn quantile_edges(values: &[f64], n_bins: u32) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|it| it.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let mut edges: Vec<f64> = (0..=n_bins)
        .filter_map(|k| quantile(&sorted, f64::from(k) / f64::from(n_bins.max(1))))
        .collect();
    edges.dedup_by(|b, a| *b <= *a);
    if edges.len() < 2 { Vec::new() } else { edges }
}
