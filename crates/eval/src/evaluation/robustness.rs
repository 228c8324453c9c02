//! mPC and rPC of a study's detectors.

use super::{
    Estimate, Evaluation, GroupKind, PairedMetric, PairedRow, RobustnessRow, Scope, ScopeKind,
};
use crate::{CrackedPrecision, mean_performance};

/// mPC and rPC of one detector without intervals, of AP, AP50 and AP75 on whole images and in the region at
/// `tau`, over the families, severities and seeds of its evaluations' conditions, those without family or severity left
/// aside; nothing unless two conditions or more have both. `n_objects` says how many different objects some
/// condition asks for in a place.
///
/// In the region every condition has a clean AP of its own, since its region is its own; rPC is by their
/// mean.
pub(super) fn mean_rows(
    evaluations: &[Evaluation],
    tau: f64,
    n_objects: &dyn Fn(&Scope) -> u64,
) -> Vec<RobustnessRow> {
    let of_grid: Vec<&Evaluation> = evaluations
        .iter()
        .filter(|one| one.condition.is_of_grid())
        .collect();
    if of_grid.len() < 2 {
        return Vec::new();
    }
    let in_region = Scope {
        kind: ScopeKind::InRegion,
        tau: Some(tau),
    };
    let mut rows = Vec::new();
    for scope in [Scope::whole_image(), in_region] {
        let n = n_objects(&scope);
        for metric in [PairedMetric::Ap, PairedMetric::Ap50, PairedMetric::Ap75] {
            rows.extend(row(&of_grid, &scope, metric, n));
        }
    }
    rows
}

fn row(
    evaluations: &[&Evaluation],
    scope: &Scope,
    metric: PairedMetric,
    n: u64,
) -> Option<RobustnessRow> {
    let find = |one: &Evaluation| -> Option<PairedRow> {
        let is_it = |row: &&PairedRow| {
            row.scope == *scope && row.metric == metric && row.group.kind == GroupKind::All
        };
        one.paired.iter().find(is_it).cloned()
    };
    let found: Vec<(&Evaluation, PairedRow)> = evaluations
        .iter()
        .filter_map(|one| Some((*one, find(one)?)))
        .collect();
    let clean: Option<Vec<f64>> = found.iter().map(|(_, row)| row.clean.value).collect();
    let clean = clean.filter(|values| !values.is_empty()).map(|values| {
        let n_sets = f64::from(u32::try_from(values.len()).unwrap_or(u32::MAX));
        values.iter().sum::<f64>() / n_sets
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
    let (first, _) = found.first()?;
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
        detector: first.detector.clone(),
        scope: scope.clone(),
        metric,
        clean: estimate(mean.clean),
        mpc: estimate(mean.mpc),
        rpc: estimate(mean.rpc),
        n_seeds: None,
    })
}
