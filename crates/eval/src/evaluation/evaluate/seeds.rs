//! Conditions that differ in nothing but their seed, taken together.

use std::collections::{BTreeMap, BTreeSet};

use super::intervals::{Place, coverage_of, max_detections};
use super::side_results::estimate;
use super::what_fails::{failure_row, scope_of};
use super::{EvaluateSettings, as_plain, nothing_covered, plan_of};
use crate::evaluation::{
    Condition, Estimate, FailureRow, Group, GroupKind, OverSeeds, PairedMetric, PairedRow, Scope,
};
use crate::failure::{ObjectPair, Where, failure_table, pair_objects};
use crate::resampling::{PairedPrecision, Plan, paired_average_precision};
use crate::statistic::Measured;
use crate::{
    Coverages, Detections, EvalError, GroundTruth, ImageMatches, LabelSet, MatchRule, Pooling,
    SaidDetections, match_images,
};

/// One detector under all its conditions.
#[derive(Debug, Clone, Copy)]
pub struct SeedsInput<'a> {
    /// Name of the detector.
    pub detector: &'a str,
    /// The labels.
    pub truth: &'a GroundTruth,
    /// What the detector finds in the clean images.
    pub clean: &'a SaidDetections,
    /// What it finds in the cracked ones.
    pub cracked: &'a [CrackedSet<'a>],
    /// How.
    pub settings: &'a EvaluateSettings,
}

/// What a detector finds under one condition.
#[derive(Debug, Clone, Copy)]
pub struct CrackedSet<'a> {
    /// What was done to the glass.
    pub condition: &'a Condition,
    /// The detections.
    pub said: &'a SaidDetections,
    /// What [`evaluate_with_coverages`](super::evaluate_with_coverages) gave for them.
    pub coverages: Option<&'a Coverages>,
}

/// The same by the rules of MS-COCO, pattern by pattern.
pub(super) struct Patterns<'a> {
    pub(super) labels: LabelSet,
    pub(super) clean: Detections,
    /// In the order of the patterns: detections and coverages.
    pub(super) cracked: Vec<(&'a Condition, Detections, Coverages)>,
    pub(super) has_regions: bool,
}

/// Nothing where there is no such set, or where only a part of the frames is evaluated.
pub(super) fn patterns_of<'a>(
    input: &SeedsInput<'a>,
    sets: &[&CrackedSet<'a>],
) -> Option<Patterns<'a>> {
    let mut found: Option<Patterns<'a>> = None;
    let has_regions = sets.iter().all(|set| set.coverages.is_some());
    for set in sets {
        let (plain, clean, cracked) = as_plain(input.truth, input.clean, Some(set.said))?;
        let cracked = cracked?;
        let coverages = match set.coverages {
            Some(coverages) => coverages.clone(),
            None => nothing_covered(&plain.labels, &[&clean, &cracked]),
        };
        let one = (set.condition, cracked.detections, coverages);
        match &mut found {
            Some(patterns) => patterns.cracked.push(one),
            None => {
                found = Some(Patterns {
                    labels: plain.labels,
                    clean: clean.detections,
                    cracked: vec![one],
                    has_regions,
                });
            }
        }
    }
    found
}

/// For each family and severity with two seeds or more the mean over its seeds: AP50 and AP75 in the region at
/// the first τ, out of it and everywhere, and what is lost there.
///
/// # Errors
/// As [`crate::evaluation::evaluate`].
pub fn over_seeds(input: &SeedsInput<'_>) -> Result<Vec<OverSeeds>, EvalError> {
    let mut cells: Vec<Vec<&CrackedSet<'_>>> = Vec::new();
    for set in input.cracked {
        let key = |set: &CrackedSet<'_>| (set.condition.family.clone(), set.condition.severity);
        let is_same = |cell: &&mut Vec<&CrackedSet<'_>>| {
            cell.first().is_some_and(|first| key(first) == key(set))
        };
        let is_known = set.condition.family.is_some() && set.condition.seed.is_some();
        match cells.iter_mut().find(is_same).filter(|_| is_known) {
            Some(cell) => cell.push(set),
            None => cells.push(vec![set]),
        }
    }
    let mut means = Vec::new();
    for cell in cells.iter().filter(|cell| cell.len() > 1) {
        if let Some(patterns) = patterns_of(input, cell) {
            means.push(mean_of(input, &patterns)?);
        }
    }
    Ok(means)
}

fn mean_of(input: &SeedsInput<'_>, patterns: &Patterns<'_>) -> Result<OverSeeds, EvalError> {
    let settings = input.settings;
    let plan = plan_of(&patterns.labels, settings);
    let seeds: Vec<u64> = patterns
        .cracked
        .iter()
        .filter_map(|(condition, ..)| condition.seed)
        .collect();
    let first = patterns.cracked.first().map(|(condition, ..)| *condition);
    let pooling = patterns.labels.by_supercategory();
    let mut places = vec![Where::Image];
    if patterns.has_regions {
        let tau = settings.tau();
        places = vec![Where::Region { tau }, Where::Outside { tau }, Where::Image];
    }
    let mut paired = Vec::new();
    for place in &places {
        let scope = scope_of(*place);
        for (metric, iou) in [(PairedMetric::Ap50, 0.5), (PairedMetric::Ap75, 0.75)] {
            paired.extend(rows(
                patterns,
                (&scope, metric, iou),
                pooling.as_ref(),
                &plan,
                settings,
            )?);
        }
    }
    Ok(OverSeeds {
        detector: input.detector.to_owned(),
        condition: without_seed(first, &seeds),
        seeds,
        paired,
        rates: rates(patterns, &places, pooling.as_ref(), &plan, settings)?,
    })
}

fn without_seed(first: Option<&Condition>, seeds: &[u64]) -> Condition {
    let family = first.and_then(|condition| condition.family.clone());
    let severity = first.and_then(|condition| condition.severity);
    let name = family.clone().unwrap_or_default();
    let of_severity = severity.map_or(String::new(), |severity| format!(", severity {severity}"));
    Condition {
        name: format!("{name}{of_severity}, {} seeds", seeds.len()),
        family,
        severity,
        seed: None,
    }
}

/// The objects of one group.
#[derive(Default)]
struct Tally {
    /// Those of each seed.
    by_seed: Vec<u64>,
    /// Images with one of them under some seed.
    images: BTreeSet<u32>,
}

impl Tally {
    fn add(&mut self, seed: usize, n_seeds: usize, matches: &ImageMatches) {
        self.by_seed.resize(n_seeds, 0);
        let objects = matches.objects.iter();
        let n = objects.filter(|object| !object.is_ignored).count();
        if let (1.., Some(of_seed)) = (n, self.by_seed.get_mut(seed)) {
            *of_seed += u64::try_from(n).unwrap_or(u64::MAX);
            self.images.insert(matches.image);
        }
    }

    fn n_objects(&self) -> u64 {
        self.by_seed.iter().sum()
    }
}

/// The rows of all groups of one place and metric.
fn rows(
    patterns: &Patterns<'_>,
    (scope, metric, iou_threshold): (&Scope, PairedMetric, f64),
    pooling: Option<&Pooling>,
    plan: &Plan,
    settings: &EvaluateSettings,
) -> Result<Vec<PairedRow>, EvalError> {
    let place = Place {
        scope,
        iou_threshold,
        max_detections: max_detections(settings),
    };
    let of_kind = |kind: GroupKind| -> Result<Vec<PairedRow>, EvalError> {
        let labels = match (pooling, kind) {
            (Some(pooling), GroupKind::Supercategory) => LabelSet {
                images: patterns.labels.images.clone(),
                categories: pooling.categories.clone(),
                objects: pooling.objects_of(&patterns.labels),
            },
            _ => patterns.labels.clone(),
        };
        let grouped = |found: &Detections| match (pooling, kind) {
            (Some(pooling), GroupKind::Supercategory) => pooling.detections_of(found),
            _ => found.clone(),
        };
        let clean_detections = grouped(&patterns.clean);
        let (mut clean, mut cracked) = (Vec::new(), Vec::new());
        for (_, found, coverages) in &patterns.cracked {
            clean.push(place.matches(&labels, &clean_detections, coverage_of(coverages, 0))?);
            cracked.push(place.matches(&labels, &grouped(found), coverage_of(coverages, 1))?);
        }
        let mut tallies: BTreeMap<Option<u32>, Tally> = BTreeMap::new();
        let n_seeds = clean.len();
        for (seed, matches) in clean.iter().enumerate() {
            for matches in matches {
                for group in [None, Some(matches.category)] {
                    tallies
                        .entry(group)
                        .or_default()
                        .add(seed, n_seeds, matches);
                }
            }
        }
        let clean: Vec<&[ImageMatches]> = clean.iter().map(Vec::as_slice).collect();
        let cracked: Vec<&[ImageMatches]> = cracked.iter().map(Vec::as_slice).collect();
        let n_categories = labels.categories.len();
        let found = paired_average_precision(&clean, &cracked, n_categories, plan)?;
        let nothing = Tally::default();
        let all = match kind {
            GroupKind::Supercategory => Group::mean_of_supercategories(),
            _ => Group::all(),
        };
        let named = |one: &PairedPrecision| -> Option<Group> {
            let category = labels.categories.get(one.category? as usize)?;
            Some(Group {
                kind,
                name: category.name.clone(),
            })
        };
        let groups = found
            .categories
            .iter()
            .filter_map(|one| Some((named(one)?, one)));
        let rows = std::iter::once((all, &found.mean)).chain(groups);
        Ok(rows
            .map(|(group, one)| {
                let tally = tallies.get(&one.category).unwrap_or(&nothing);
                row(scope, metric, group, one, tally, settings)
            })
            .filter(|row| row.n_objects > 0 || row.group.kind != GroupKind::Class)
            .collect())
    };
    let mut rows = of_kind(GroupKind::Class)?;
    if pooling.is_some() {
        rows.splice(1..1, of_kind(GroupKind::Supercategory)?);
    }
    Ok(rows)
}

fn row(
    scope: &Scope,
    metric: PairedMetric,
    group: Group,
    found: &PairedPrecision,
    tally: &Tally,
    settings: &EvaluateSettings,
) -> PairedRow {
    let least = settings.compare.min_objects;
    let n = tally.n_objects();
    let is_few = tally.by_seed.iter().any(|n| *n < least) || tally.by_seed.is_empty();
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
        n_images: u64::try_from(tally.images.len()).unwrap_or(u64::MAX),
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
    patterns: &Patterns<'_>,
    places: &[Where],
    pooling: Option<&Pooling>,
    plan: &Plan,
    settings: &EvaluateSettings,
) -> Result<Vec<FailureRow>, EvalError> {
    let rule = MatchRule {
        iou_threshold: settings.iou_threshold,
        max_detections: max_detections(settings),
        region: None,
    };
    let clean = match_images(&patterns.labels, &patterns.clean, &rule)?;
    let mut pairs: Vec<ObjectPair> = Vec::new();
    for (_, found, coverages) in &patterns.cracked {
        pairs.extend(pair_objects(
            &clean,
            &match_images(&patterns.labels, found, &rule)?,
            &patterns.labels,
            &coverages.objects,
            settings.score_threshold,
        )?);
    }
    let mut rows = rates_of(&pairs, places, plan, settings, |category| {
        let category = patterns.labels.categories.get(category as usize)?;
        Some((GroupKind::Class, category.name.clone()))
    })?;
    if let Some(pooling) = pooling {
        for pair in &mut pairs {
            pair.category = pooling.group(pair.category);
        }
        let groups = rates_of(&pairs, places, plan, settings, |group| {
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
    plan: &Plan,
    settings: &EvaluateSettings,
    name: impl Fn(u32) -> Option<(GroupKind, String)>,
) -> Result<Vec<FailureRow>, EvalError> {
    let table = failure_table(pairs, places, plan)?;
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
            given(rate, rate.n, different(is_found_clean), settings)
        };
        let rates = [
            given(&found.failure_rate, true),
            given(&found.recovery_rate, false),
        ];
        Some(failure_row(found, group, rates))
    };
    Ok(table.iter().filter_map(row).collect())
}
