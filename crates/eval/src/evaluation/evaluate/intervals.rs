//! Intervals and tests of the paired numbers.

use super::{EvaluateSettings, Plain};
use crate::evaluation::{Estimate, Group, GroupKind, PairedMetric, PairedRow, Scope, ScopeKind};
use crate::protocol::{Boxes, runs_of_categories};
use crate::resampling::{
    DrawnPrecisions, KittiRecalls, PairedPrecision, PairedPrecisions, Plan, paired_kitti_precision,
};
use crate::statistic::Measured;
use crate::{
    Category, CoverageOf, Coverages, EvalError, GroundTruth, KittiDetections, KittiDifficulty,
    MatchRule, Pooling, SaidDetections, Subset, rank_kitti,
};

/// Of what draws are taken: where, which number, and whether of classes or of supercategories.
pub(super) type Drawn<'a> = (&'a Scope, PairedMetric, GroupKind);

/// Puts intervals and tests to AP50 and AP75 of all groups: of every scope AP50, of the
/// first τ and of whole images AP75, too. Hands over what those of the latter are measured from.
pub(super) fn put(
    rows: &mut [PairedRow],
    all: &Plain<'_>,
    take: &mut dyn FnMut(Drawn<'_>, DrawnPrecisions) -> Result<(), EvalError>,
) -> Result<(), EvalError> {
    let scopes = scopes_of(rows);
    let pooling = all.labels.by_supercategory();
    for scope in &scopes {
        let is_own = scope
            .tau
            .is_none_or(|tau| (tau - all.settings.tau()).abs() < 1e-12);
        let metrics = [(PairedMetric::Ap50, 0.5), (PairedMetric::Ap75, 0.75)];
        for (metric, iou) in metrics {
            if metric == PairedMetric::Ap75 && !is_own {
                continue;
            }
            let mut measured = |kind, pooling| {
                let drawn = drawn(all, pooling, scope, iou)?;
                let found = drawn.measured(all.plan)?;
                if is_own {
                    take((scope, metric, kind), drawn)?;
                }
                Ok::<_, EvalError>(found)
            };
            let of_classes = measured(GroupKind::Class, None)?;
            let of_groups = (pooling.as_ref())
                .map(|pooling| measured(GroupKind::Supercategory, Some(pooling)))
                .transpose()?;
            let of_row = |group: &Group| match group.kind {
                GroupKind::All => Some(&of_classes.mean),
                GroupKind::MeanOfSupercategories => of_groups.as_ref().map(|found| &found.mean),
                GroupKind::Class => find(&all.labels.categories, &of_classes, &group.name),
                GroupKind::Supercategory => find(
                    &pooling.as_ref()?.categories,
                    of_groups.as_ref()?,
                    &group.name,
                ),
            };
            let here = |row: &&mut PairedRow| row.scope == *scope && row.metric == metric;
            for row in rows.iter_mut().filter(here) {
                if let Some(found) = of_row(&row.group) {
                    put_row(row, found);
                }
            }
        }
    }
    Ok(())
}

/// The same for AP11 and AP40 of KITTI, over the evaluated frames or their drives.
pub(super) fn put_kitti(
    rows: &mut [PairedRow],
    truth: &GroundTruth,
    sides: [&SaidDetections; 2],
    coverages: &Coverages,
    settings: &EvaluateSettings,
) -> Result<(), EvalError> {
    let [Some(clean), Some(cracked)] = sides.map(|said| said.kitti.as_ref()) else {
        return Ok(());
    };
    let Some(labels) = &truth.kitti else {
        return Ok(());
    };
    let cluster = |image: &u32| truth.labels.images.get(*image as usize)?.cluster.as_deref();
    let clusters: Vec<Option<&str>> = clean.images.iter().map(cluster).collect();
    let plan =
        Plan::of_clusters(&clusters).with(settings.n_replicates, settings.seed, settings.level);
    let scopes = scopes_of(rows);
    for scope in &scopes {
        let ranked = |detections: &KittiDetections, set: usize| {
            let coverage = coverage_of(coverages, set);
            let values = subset_of(scope).values(&labels.set, &detections.set, coverage)?;
            let mut rankings = rank_kitti(labels, detections, Some(&values.restriction()))?;
            rankings.retain(|ranking| ranking.difficulty() == KittiDifficulty::Moderate);
            Ok::<_, EvalError>(rankings)
        };
        let (clean, cracked) = (ranked(clean, 0)?, ranked(cracked, 1)?);
        for (metric, recalls) in [
            (PairedMetric::KittiAp11, KittiRecalls::R11),
            (PairedMetric::KittiAp40, KittiRecalls::R40),
        ] {
            let found = paired_kitti_precision(&clean, &cracked, recalls, &plan)?;
            let here = |row: &&mut PairedRow| row.scope == *scope && row.metric == metric;
            for row in rows.iter_mut().filter(here) {
                let mut of_class = clean.iter().zip(&found.categories);
                let found = of_class.find(|(ranking, _)| ranking.class().name() == row.group.name);
                if let Some((_, found)) = found {
                    put_row(row, found);
                }
            }
        }
    }
    Ok(())
}

/// Each once, in their order.
fn scopes_of(rows: &[PairedRow]) -> Vec<Scope> {
    let mut scopes: Vec<Scope> = Vec::new();
    for row in rows {
        if !scopes.contains(&row.scope) {
            scopes.push(row.scope.clone());
        }
    }
    scopes
}

fn subset_of(scope: &Scope) -> Subset {
    match (scope.kind, scope.tau) {
        (ScopeKind::InRegion, Some(tau)) => Subset::InRegion { tau },
        (ScopeKind::OutOfRegion, Some(tau)) => Subset::OutOfRegion { tau },
        _ => Subset::WholeImage,
    }
}

fn find<'a>(
    categories: &[Category],
    found: &'a PairedPrecisions,
    name: &str,
) -> Option<&'a PairedPrecision> {
    let place = categories.iter().position(|it| it.name == name)?;
    let is_it = |row: &&PairedPrecision| row.category.is_some_and(|it| it as usize == place);
    found.categories.iter().find(is_it)
}

/// Of classes, or of groups of them.
fn drawn(
    all: &Plain<'_>,
    pooling: Option<&Pooling>,
    scope: &Scope,
    iou_threshold: f64,
) -> Result<DrawnPrecisions, EvalError> {
    let sides = [all.clean, all.cracked].map(|detections| Boxes {
        pooling,
        ..Boxes::of(all.labels, detections)
    });
    let values = [0, 1].map(|set| {
        let (boxes, coverage) = (sides[set], coverage_of(all.coverages, set));
        subset_of(scope).values(boxes.labels, boxes.detections, coverage)
    });
    let [of_clean, of_cracked] = values;
    let values = [of_clean?, of_cracked?];
    let rules = values.each_ref().map(|values| MatchRule {
        iou_threshold,
        max_detections: max_detections(all.settings),
        region: Some(values.restriction()),
    });
    let runs = runs_of_categories(&sides);
    DrawnPrecisions::of_runs(runs, all.plan, |categories| {
        let clean = sides[0].matches(&rules[0], categories)?;
        Ok([clean, sides[1].matches(&rules[1], categories)?])
    })
}

/// Most detections of a category in an image.
fn max_detections(settings: &EvaluateSettings) -> u32 {
    let most = settings.compare.coco.max_detections.last();
    most.copied().unwrap_or(100)
}

/// The coverages of one of the sets of detections.
fn coverage_of(coverages: &Coverages, set: usize) -> CoverageOf<'_> {
    CoverageOf {
        objects: &coverages.objects,
        detections: coverages.detections.get(set).map_or(&[], Vec::as_slice),
    }
}

/// A number that is there gets its interval; one that is refused stays refused.
fn put_row(row: &mut PairedRow, found: &PairedPrecision) {
    put_interval(&mut row.clean, &found.clean);
    put_interval(&mut row.cracked, &found.cracked);
    put_interval(&mut row.delta, &found.difference);
    if row.delta.value.is_some() {
        row.p = found.test.p;
    }
}

fn put_interval(estimate: &mut Estimate, found: &Measured) {
    if estimate.value.is_none() {
        return;
    }
    if let Some(interval) = found.interval {
        estimate.low = Some(interval.low);
        estimate.high = Some(interval.high);
    }
}
