//! Conditions that differ in nothing but their seed, taken together.

use std::collections::BTreeSet;

use super::intervals::Drawn;
use super::side_results::estimate;
use super::what_fails::{failure_row, scope_of};
use super::{EvaluateSettings, Plain};
use crate::evaluation::{
    Condition, Estimate, FailureRow, Group, GroupKind, OverSeeds, PairedMetric, PairedRow, Scope,
};
use crate::failure::{ObjectPair, Where, failure_table};
use crate::resampling::{DrawnPrecisions, PairedPrecision};
use crate::statistic::Measured;
use crate::{EvalError, Pooling};

/// What is known of conditions that differ in nothing but their seed, added up one after the other.
#[derive(Debug, Default)]
pub(super) struct SeedSums {
    /// In the order in which they came.
    seeds: Vec<u64>,
    drawn: Vec<(Scope, PairedMetric, GroupKind, DrawnPrecisions)>,
    pairs: Vec<ObjectPair>,
    is_without_regions: bool,
}

impl SeedSums {
    pub(super) fn add_drawn(
        &mut self,
        (scope, metric, kind): Drawn<'_>,
        drawn: DrawnPrecisions,
    ) -> Result<(), EvalError> {
        let is_it = |(s, m, k, _): &&mut (Scope, PairedMetric, GroupKind, DrawnPrecisions)| {
            (s, *m, *k) == (scope, metric, kind)
        };
        match self.drawn.iter_mut().find(is_it) {
            Some((.., sums)) => sums.add(&drawn)?,
            None => self.drawn.push((scope.clone(), metric, kind, drawn)),
        }
        Ok(())
    }

    pub(super) fn add_pairs(&mut self, seed: Option<u64>, pairs: &[ObjectPair], has_regions: bool) {
        self.seeds.extend(seed);
        self.pairs.extend(pairs);
        self.is_without_regions |= !has_regions;
    }

    /// The mean over the seeds: AP50 and AP75 in the region at the first τ, out of it and everywhere, and what is
    /// lost there.
    pub(super) fn mean(
        mut self,
        detector: &str,
        first: &Condition,
        all: &Plain<'_>,
    ) -> Result<OverSeeds, EvalError> {
        let pooling = all.labels.by_supercategory();
        let tau = all.settings.tau();
        let places = match self.is_without_regions {
            true => vec![Where::Image],
            false => vec![Where::Region { tau }, Where::Outside { tau }, Where::Image],
        };
        let mut paired = Vec::new();
        for scope in places.iter().map(|place| scope_of(*place)) {
            for metric in [PairedMetric::Ap50, PairedMetric::Ap75] {
                let of = |kind| self.rows((&scope, metric, kind), pooling.as_ref(), all);
                let mut rows = of(GroupKind::Class)?;
                if pooling.is_some() {
                    let behind_mean = rows.len().min(1);
                    rows.splice(behind_mean..behind_mean, of(GroupKind::Supercategory)?);
                }
                paired.extend(rows);
            }
        }
        let pairs = std::mem::take(&mut self.pairs);
        Ok(OverSeeds {
            detector: detector.to_owned(),
            condition: without_seed(first, self.seeds.len()),
            rates: rates(pairs, &places, pooling.as_ref(), all)?,
            seeds: self.seeds,
            paired,
        })
    }

    /// The rows of the groups of one kind, in one place and of one metric.
    fn rows(
        &self,
        (scope, metric, kind): Drawn<'_>,
        pooling: Option<&Pooling>,
        all: &Plain<'_>,
    ) -> Result<Vec<PairedRow>, EvalError> {
        let is_it = |(s, m, k, _): &&(Scope, PairedMetric, GroupKind, DrawnPrecisions)| {
            (s, *m, *k) == (scope, metric, kind)
        };
        let Some((.., drawn)) = self.drawn.iter().find(is_it) else {
            return Ok(Vec::new());
        };
        let found = drawn.measured(all.plan)?;
        let (of_all, categories) = match (pooling, kind) {
            (Some(pooling), GroupKind::Supercategory) => {
                (Group::mean_of_supercategories(), &pooling.categories)
            }
            _ => (Group::all(), &all.labels.categories),
        };
        let named = |one: &PairedPrecision| -> Option<Group> {
            let category = categories.get(one.category? as usize)?;
            Some(Group {
                kind,
                name: category.name.clone(),
            })
        };
        let groups = found.categories.iter();
        let groups = groups.filter_map(|one| Some((named(one)?, one)));
        let rows = std::iter::once((of_all, &found.mean)).chain(groups);
        Ok(rows
            .map(|(group, one)| {
                let objects = drawn.objects(one.category);
                row((scope, metric), group, one, objects, all.settings)
            })
            .filter(|row| row.n_objects > 0 || row.group.kind != GroupKind::Class)
            .collect())
    }
}

fn without_seed(first: &Condition, n_seeds: usize) -> Condition {
    let family = first.family.clone();
    let severity = first.severity;
    let name = family.clone().unwrap_or_default();
    let of_severity = severity.map_or(String::new(), |severity| format!(", severity {severity}"));
    Condition {
        name: format!("{name}{of_severity}, {n_seeds} seeds"),
        family,
        severity,
        seed: None,
    }
}

fn row(
    (scope, metric): (&Scope, PairedMetric),
    group: Group,
    found: &PairedPrecision,
    (by_seed, n_images): (Vec<u64>, usize),
    settings: &EvaluateSettings,
) -> PairedRow {
    let least = settings.compare.min_objects;
    let n = by_seed.iter().sum();
    let is_few = by_seed.iter().any(|n| *n < least);
    let of = |measured: &Measured| match is_few {
        true => Estimate::refused(n, format!("fewer than {least} objects in some seed")),
        false => Estimate {
            n,
            ..estimate(measured)
        },
    };
    let delta = of(&found.difference);
    PairedRow {
        scope: scope.clone(),
        group,
        metric,
        n_objects: n,
        n_images: u64::try_from(n_images).unwrap_or(u64::MAX),
        clean: of(&found.clean),
        cracked: of(&found.cracked),
        p: found.test.p.filter(|_| delta.value.is_some()),
        p_holm: None,
        delta,
        ceiling: None,
    }
}

/// A share of too few different objects is refused: the same one under several seeds is one.
fn given(measured: &Measured, n: u64, n_distinct: u64, settings: &EvaluateSettings) -> Estimate {
    let least = settings.compare.min_objects;
    if n_distinct < least {
        return Estimate::refused(n, format!("fewer than {least} different objects"));
    }
    Estimate {
        n,
        ..estimate(measured)
    }
}

/// What is lost, of each group in each place.
fn rates(
    mut pairs: Vec<ObjectPair>,
    places: &[Where],
    pooling: Option<&Pooling>,
    all: &Plain<'_>,
) -> Result<Vec<FailureRow>, EvalError> {
    let mut rows = rates_of(&pairs, places, all, |category| {
        let category = all.labels.categories.get(category as usize)?;
        Some((GroupKind::Class, category.name.clone()))
    })?;
    if let Some(pooling) = pooling {
        for pair in &mut pairs {
            pair.category = pooling.group(pair.category);
        }
        let groups = rates_of(&pairs, places, all, |group| {
            let category = pooling.categories.get(group as usize)?;
            Some((GroupKind::Supercategory, category.name.clone()))
        })?;
        rows.extend(
            groups
                .into_iter()
                .filter(|row| row.group.kind != GroupKind::All),
        );
    }
    Ok(rows)
}

fn rates_of(
    pairs: &[ObjectPair],
    places: &[Where],
    all: &Plain<'_>,
    name: impl Fn(u32) -> Option<(GroupKind, String)>,
) -> Result<Vec<FailureRow>, EvalError> {
    let table = failure_table(pairs, places, all.plan)?;
    let row = |found: &crate::failure::FailureRates| {
        let group = match found.group.category {
            None => Group::all(),
            Some(category) => {
                let (kind, name) = name(category)?;
                Group { kind, name }
            }
        };
        let different = |is_found_clean: bool| -> u64 {
            let is_member = |pair: &&ObjectPair| {
                found.group.category.is_none_or(|it| it == pair.category)
                    && found.group.place.holds(pair.coverage)
                    && pair.clean.is_some() == is_found_clean
            };
            let objects: BTreeSet<u32> = pairs
                .iter()
                .filter(is_member)
                .map(|pair| pair.object)
                .collect();
            u64::try_from(objects.len()).unwrap_or(u64::MAX)
        };
        let given = |rate: &Measured, is_found_clean| {
            given(rate, rate.n, different(is_found_clean), all.settings)
        };
        let rates = [
            given(&found.failure_rate, true),
            given(&found.recovery_rate, false),
        ];
        Some(failure_row(found, group, rates))
    };
    Ok(table.iter().filter_map(row).collect())
}
