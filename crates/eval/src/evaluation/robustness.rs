//! mPC and rPC of a study's detectors.

use super::{
    Estimate, Evaluation, GroupKind, PairedMetric, PairedRow, RobustnessRow, Scope, ScopeKind,
};
use crate::{CrackedPrecision, mean_performance};

/// mPC and rPC of each detector, of AP, AP50 and AP75 on whole images and in the region at `tau`, over the
/// families, severities and seeds of the evaluations' conditions; nothing unless a detector has two
/// conditions or more, each with family and severity.
///
/// In the region every condition has a clean AP of its own, since its region is its own; rPC is by their
/// mean.
#[must_use]
pub fn robustness(evaluations: &[Evaluation], tau: Option<f64>) -> Vec<RobustnessRow> {
    let mut detectors: Vec<&str> = Vec::new();
    for one in evaluations {
        if !detectors.contains(&one.detector.as_str()) {
            detectors.push(&one.detector);
        }
    }
    let mut scopes = vec![Scope::whole_image()];
    if tau.is_some() {
        scopes.push(Scope {
            kind: ScopeKind::InRegion,
            tau,
        });
    }
    let mut rows = Vec::new();
    for detector in detectors {
        let of_detector: Vec<&Evaluation> = evaluations
            .iter()
            .filter(|one| one.detector == detector)
            .collect();
        let is_known =
            |one: &&Evaluation| one.condition.family.is_some() && one.condition.severity.is_some();
        if of_detector.len() < 2 || !of_detector.iter().all(is_known) {
            continue;
        }
        for scope in &scopes {
            for metric in [PairedMetric::Ap, PairedMetric::Ap50, PairedMetric::Ap75] {
                rows.extend(row(detector, &of_detector, scope, metric));
            }
        }
    }
    rows
}

fn row(
    detector: &str,
    evaluations: &[&Evaluation],
    scope: &Scope,
    metric: PairedMetric,
) -> Option<RobustnessRow> {
    let find = |one: &Evaluation| -> Option<PairedRow> {
        let is_it = |row: &&PairedRow| {
            row.scope == *scope && row.metric == metric && row.group.kind == GroupKind::All
        };
        one.paired.iter().find(is_it).cloned()
    };
    let found: Vec<(&&Evaluation, PairedRow)> = evaluations
        .iter()
        .filter_map(|one| Some((one, find(one)?)))
        .collect();
    let n = found.iter().map(|(_, row)| row.n_objects).sum();
    let clean: Option<Vec<f64>> = found.iter().map(|(_, row)| row.clean.value).collect();
    let clean = clean.filter(|values| !values.is_empty()).map(|values| {
        let n = f64::from(u32::try_from(values.len()).unwrap_or(u32::MAX));
        values.iter().sum::<f64>() / n
    });
    let sets: Vec<CrackedPrecision> = found
        .iter()
        .map(|(one, row)| CrackedPrecision {
            family: one.condition.family.clone().unwrap_or_default(),
            severity: u32::from(one.condition.severity.unwrap_or(0)),
            seed: one.condition.seed.unwrap_or(0),
            ap: row.cracked.value,
        })
        .collect();
    if sets.is_empty() {
        return None;
    }
    let mean = mean_performance(clean, &sets);
    let why = mean
        .reason
        .clone()
        .unwrap_or_else(|| "not defined".to_owned());
    let estimate = |value: Option<f64>| match value {
        Some(value) => Estimate::of(value, n),
        None => Estimate::refused(n, why.clone()),
    };
    Some(RobustnessRow {
        detector: detector.to_owned(),
        scope: scope.clone(),
        metric,
        clean: estimate(mean.clean),
        mpc: estimate(mean.mpc),
        rpc: estimate(mean.rpc),
        n_seeds: None,
    })
}
