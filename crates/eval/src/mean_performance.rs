//! How a detector holds up over kinds and severities of cracks: mPC and rPC.

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::resampling::{DrawnMean, Plan, Replicates, permuted_draws};
use crate::statistic::{Interval, Measured, Method};

/// AP of one set of cracked images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CrackedPrecision {
    /// Kind of crack: a preset's name.
    pub family: String,
    /// How severe, 1 to 5 as a rule.
    pub severity: u32,
    /// Seed of the patterns.
    pub seed: u64,
    /// The AP, if it is defined.
    pub ap: Option<f64>,
}

/// Mean performance under cracks and its share of the clean one.
///
/// mPC = 1/(N_c N_s) Σ_c Σ_s AP_{c,s} over kinds c and severities s, AP_{c,s} being the mean over
/// seeds; rPC = mPC / AP_clean \[Michaelis2019\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeanPerformance {
    /// AP of the clean images.
    pub clean: Option<f64>,
    /// Mean over kinds and severities, in the unit of the APs.
    pub mpc: Option<f64>,
    /// Its share of the clean AP; not bounded by 1.
    pub rpc: Option<f64>,
    /// Kinds.
    pub n_families: u64,
    /// Severities.
    pub n_severities: u64,
    /// Sets of cracked images.
    pub n_sets: u64,
    /// Per kind and severity, in order of both.
    pub cells: Vec<PerformanceCell>,
    /// Why there is no mPC or rPC.
    pub reason: Option<String>,
}

/// One kind at one severity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PerformanceCell {
    /// Kind of crack.
    pub family: String,
    /// How severe.
    pub severity: u32,
    /// Mean AP over seeds.
    pub ap: Option<f64>,
    /// Seeds.
    pub n_seeds: u64,
    /// Standard deviation over two seeds or more.
    pub deviation: Option<f64>,
}

/// mPC and rPC of a set of APs; with a reason instead where a kind lacks a severity that another
/// one has, or an AP is not given, since a mean over other cells is another number.
#[must_use]
pub(crate) fn mean_performance(clean: Option<f64>, sets: &[CrackedPrecision]) -> MeanPerformance {
    let mut families: Vec<&str> = sets.iter().map(|it| it.family.as_str()).collect();
    families.sort_unstable();
    families.dedup();
    let mut severities: Vec<u32> = sets.iter().map(|it| it.severity).collect();
    severities.sort_unstable();
    severities.dedup();
    let mut cells = Vec::new();
    let mut reason = sets
        .is_empty()
        .then(|| "there are no damaged images".to_owned());
    for family in &families {
        for severity in &severities {
            let cell = cell(family, *severity, sets);
            if reason.is_none() && cell.ap.is_none() {
                reason = Some(match cell.n_seeds {
                    0 => format!("{family} lacks severity {severity}, which other families have"),
                    _ => format!(
                        "there is no AP of {family} at severity {severity}: too few objects or none"
                    ),
                });
            }
            cells.push(cell);
        }
    }
    let sum: Option<f64> = cells.iter().map(|cell| cell.ap).sum();
    let mpc = sum
        .filter(|_| !cells.is_empty())
        .map(|sum| sum / cells.len() as f64);
    let rpc = mpc
        .zip(clean.filter(|clean| *clean > 0.0))
        .map(|(mpc, clean)| mpc / clean);
    if reason.is_none() && rpc.is_none() {
        reason = Some("the clean AP is 0 or not given (too few objects or none)".to_owned());
    }
    MeanPerformance {
        clean,
        mpc,
        rpc,
        n_families: families.len() as u64,
        n_severities: severities.len() as u64,
        n_sets: sets.len() as u64,
        cells,
        reason,
    }
}

/// Clean AP, mPC and rPC with their intervals, over the classes of each set of images: `cells` are the places of the
/// sets among the kinds and severities, each with the same number of seeds. The clean images are one set for all where
/// `is_clean_one`, else one per set, of whose values the mean is taken as well. Nothing is given where an AP is not defined.
///
/// Each replicate draws images (or clusters) once for all sets, and averages as mPC is averaged. The intervals of clean
/// AP and mPC are expanded percentiles by the images of the classes, and lower by what AP of few images leans to
/// above. That of rPC is the wider, at each end, of the expanded percentiles, which are too narrow where classes are in
/// few images, and of what exchanges of clean and cracked reach from 1 by factors
/// ([`Permuted`](crate::resampling::Permuted)), which is too narrow where the damage is strong.
///
/// # Errors
/// If the plan cannot be carried out.
pub fn measured_performance(
    sets: &[DrawnMean],
    is_clean_one: bool,
    cells: &[usize],
    plan: &Plan,
) -> Result<[Measured; 3], EvalError> {
    plan.check()?;
    let mean = |side: usize, draw: usize| -> Option<f64> {
        let value = |set: &DrawnMean| Some(set.pair(draw)?[side]);
        match sets {
            [alone] => value(alone),
            all => mean_of_cells(cells, &all.iter().map(value).collect::<Vec<_>>()),
        }
    };
    let ratio = |cracked: Option<f64>, clean: Option<f64>| {
        cracked
            .zip(clean.filter(|clean| *clean > 0.0))
            .map(|(cracked, clean)| cracked / clean)
    };
    let replicates = Replicates::of_draws(plan, |draw| {
        let clean = match sets.first().filter(|_| is_clean_one) {
            Some(first) => first.pair(draw).map(|[clean, _]| clean),
            None => mean(0, draw),
        };
        let cracked = mean(1, draw);
        vec![clean, cracked, ratio(cracked, clean)]
    });
    let exchanged = permuted_draws(plan, |draw| {
        vec![ratio(mean(1, draw), mean(0, draw)).map(f64::ln)]
    });
    let of_ratio = exchanged.first().and_then(|one| one.interval);
    let of_ratio = of_ratio.map(|of_log| Interval {
        low: of_log.low.exp(),
        high: of_log.high.exp(),
        ..of_log
    });
    let side = DrawnMean::basis(sets, plan);
    let ap = Method::AveragePrecision;
    Ok([
        replicates.expanded(0, ap, side),
        replicates.expanded(1, ap, side),
        replicates.expanded_to(2, Method::Ratio, side, of_ratio),
    ])
}

/// Mean over cells of the mean over seeds; nothing where a value is missing.
fn mean_of_cells(place: &[usize], values: &[Option<f64>]) -> Option<f64> {
    let n_cells = place.iter().max()? + 1;
    let mut cells = vec![(0.0_f64, 0.0_f64); n_cells];
    for (cell, value) in place.iter().zip(values) {
        let cell = cells.get_mut(*cell)?;
        *cell = (cell.0 + (*value)?, cell.1 + 1.0);
    }
    Some(cells.iter().map(|(sum, n)| sum / n).sum::<f64>() / n_cells as f64)
}

fn cell(family: &str, severity: u32, sets: &[CrackedPrecision]) -> PerformanceCell {
    let of_cell: Vec<Option<f64>> = sets
        .iter()
        .filter(|it| it.family == family && it.severity == severity)
        .map(|it| it.ap.filter(|ap| ap.is_finite()))
        .collect();
    let n = of_cell.len() as f64;
    let all: Option<Vec<f64>> = of_cell.iter().copied().collect();
    let all = all.filter(|all| !all.is_empty());
    let mean = all.as_ref().map(|all| all.iter().sum::<f64>() / n);
    let deviation = all.zip(mean).filter(|(all, _)| all.len() > 1);
    PerformanceCell {
        family: family.to_owned(),
        severity,
        ap: mean,
        n_seeds: of_cell.len() as u64,
        deviation: deviation.map(|(all, mean)| {
            (all.iter().map(|ap| (ap - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::{CrackedPrecision, mean_performance};

    fn set(family: &str, severity: u32, seed: u64, ap: Option<f64>) -> CrackedPrecision {
        CrackedPrecision {
            family: family.to_owned(),
            severity,
            seed,
            ap,
        }
    }

    #[test]
    fn kinds_and_severities_weigh_the_same_whatever_the_number_of_seeds() {
        let sets = [
            set("star", 1, 0, Some(0.5)),
            set("star", 1, 1, Some(0.3)),
            set("star", 2, 0, Some(0.2)),
            set("long", 1, 0, Some(0.6)),
            set("long", 2, 0, Some(0.4)),
        ];
        let mean = mean_performance(Some(0.8), &sets);
        let mpc = (0.4 + 0.2 + 0.6 + 0.4) / 4.0;
        assert!(
            (mean.mpc.unwrap_or(-1.0) - mpc).abs() < 1e-15,
            "mPC {mean:?}"
        );
        assert!((mean.rpc.unwrap_or(-1.0) - mpc / 0.8).abs() < 1e-15, "rPC");
        let deviation = mean.cells.iter().find_map(|cell| cell.deviation);
        let expected = 0.02_f64.sqrt();
        assert!(
            (deviation.unwrap_or(-1.0) - expected).abs() < 1e-15,
            "of two seeds"
        );
    }

    #[test]
    fn a_gap_is_said_and_not_averaged_over() {
        let sets = [
            set("star", 1, 0, Some(0.5)),
            set("star", 2, 0, Some(0.2)),
            set("long", 1, 0, Some(0.6)),
        ];
        let mean = mean_performance(Some(0.8), &sets);
        assert_eq!(mean.mpc, None, "no mean over other cells");
        let reason = mean.reason.unwrap_or_default();
        assert!(reason.contains("long lacks severity 2"), "{reason}");
        let undefined = mean_performance(Some(0.8), &[set("star", 1, 0, None)]);
        assert_eq!(undefined.mpc, None, "undefined stays so");
        let no_clean = mean_performance(Some(0.0), &[set("star", 1, 0, Some(0.0))]);
        assert_eq!(
            (no_clean.mpc, no_clean.rpc),
            (Some(0.0), None),
            "no share of 0"
        );
        assert_eq!(mean_performance(None, &[]).mpc, None, "nothing");
    }
}
