//! What is lost, over what dose, what appears, what shifts.

use super::side_results::estimate;
use super::{EvaluateSettings, Plain};
use crate::evaluation::{
    ClassFlip, DamageFacts, DoseBin, DoseResponse, Estimate, FailureResults, FailureRow, FlipRow,
    Group, GroupKind, LogisticFit, NewFalsePositives, Scope, ScopeKind, ShiftRow,
};
use crate::failure::{
    self, FalsePositiveAreas, ObjectPair, Where, class_flips, failure_rates, failure_table,
    new_false_positives, pair_objects, quantile_edges, shifts,
};
use crate::protocol::Boxes;
use crate::statistic::Measured;
use crate::{COVERAGE_BINS, EvalError, ImageMatches, MatchRule};

/// Bins of a damage fact.
const N_FACT_BINS: u32 = 8;

/// Matches of whole images, clean and cracked, as far as a detection counts as found.
pub(super) struct Matches {
    pub(super) clean: Vec<ImageMatches>,
    pub(super) cracked: Vec<ImageMatches>,
}

/// Everything that fails, the pairs that it is counted from, and the matches those come from.
pub(super) fn failures(
    all: &Plain<'_>,
    facts: Option<&DamageFacts>,
    has_regions: bool,
    image_px: Option<Vec<f64>>,
) -> Result<(FailureResults, Vec<ObjectPair>, Matches), EvalError> {
    let settings = all.settings;
    let max_detections = settings.compare.coco.max_detections.last();
    let rule = MatchRule {
        iou_threshold: settings.iou_threshold,
        max_detections: max_detections.copied().unwrap_or(100),
        region: None,
    };
    let matches = Matches {
        clean: matches_that_count(Boxes::of(all.labels, all.clean), &rule, settings)?,
        cracked: matches_that_count(Boxes::of(all.labels, all.cracked), &rule, settings)?,
    };
    let pairs = pair_objects(
        &matches.clean,
        &matches.cracked,
        all.labels,
        &all.coverages.objects,
        settings.score_threshold,
    )?;
    let mut places: Vec<Where> = Vec::new();
    if has_regions {
        for tau in &settings.compare.taus {
            places.push(Where::Region { tau: *tau });
            places.push(Where::Outside { tau: *tau });
        }
    }
    places.push(Where::Image);
    let mut results = FailureResults {
        rates: rates(all, &pairs, &places)?,
        ..FailureResults::default()
    };
    for place in &places {
        let here: Vec<ObjectPair> = here(&pairs, *place);
        results.shifts.extend(shift_rows(all, &here, *place)?);
        results.flips.push(flip_row(all, &here, &matches, *place)?);
    }
    if has_regions {
        results.dose_responses = doses(all, &pairs, facts)?;
    }
    if let Some(image_px) = image_px {
        results.new_false_positives = appeared(all, &matches, has_regions, &image_px)?;
    }
    Ok((results, pairs, matches))
}

/// What became of all objects, and of the detections that count as found: most of a detector's do not.
fn matches_that_count(
    boxes: Boxes<'_>,
    rule: &MatchRule<'_>,
    settings: &EvaluateSettings,
) -> Result<Vec<ImageMatches>, EvalError> {
    let least = settings.score_threshold;
    boxes.all_matches(rule, |matches| {
        for of_image in &mut *matches {
            of_image.detections.retain(|it| it.score >= least);
            of_image.detections.shrink_to_fit();
        }
        matches.retain(|it| !it.detections.is_empty() || !it.objects.is_empty());
    })
}

fn here(pairs: &[ObjectPair], place: Where) -> Vec<ObjectPair> {
    let is_here = |pair: &&ObjectPair| place.holds(pair.coverage);
    pairs.iter().filter(is_here).copied().collect()
}

pub(super) fn scope_of(place: Where) -> Scope {
    let (kind, tau) = match place {
        Where::Region { tau } => (ScopeKind::InRegion, Some(tau)),
        Where::Outside { tau } => (ScopeKind::OutOfRegion, Some(tau)),
        Where::Image | Where::Coverage { .. } => (ScopeKind::WholeImage, None),
    };
    Scope { kind, tau }
}

fn class(all: &Plain<'_>, category: u32) -> String {
    let category = all.labels.categories.get(category as usize);
    category.map_or(String::new(), |category| category.name.clone())
}

/// A share of too few objects is refused.
fn unless_few(all: &Plain<'_>, measured: &Measured) -> Estimate {
    let least = all.settings.compare.min_objects;
    match measured.n < least {
        true => Estimate::few(measured.n, least),
        false => estimate(measured),
    }
}

fn rates(
    all: &Plain<'_>,
    pairs: &[ObjectPair],
    places: &[Where],
) -> Result<Vec<FailureRow>, EvalError> {
    let mut rows = Vec::new();
    let table = failure_table(pairs, places, all.plan)?;
    let pooling = all.labels.by_supercategory();
    for place in places {
        let of_place = table.iter().filter(|row| row.group.place == *place);
        let mut of_scope: Vec<FailureRow> = of_place
            .map(|found| {
                let group = match found.group.category {
                    None => Group::all(),
                    Some(category) => Group {
                        kind: GroupKind::Class,
                        name: class(all, category),
                    },
                };
                row_of(all, found, group)
            })
            .collect();
        if let Some(pooling) = &pooling {
            let groups = pooling.categories.iter().zip(0_u32..).map(|(group, idx)| {
                let is_member = |pair: &&ObjectPair| {
                    pooling.group(pair.category) == idx && place.holds(pair.coverage)
                };
                let of_group = failure::Group {
                    category: None,
                    place: *place,
                };
                let found = failure_rates(of_group, pairs.iter().filter(is_member), all.plan)?;
                let group = Group {
                    kind: GroupKind::Supercategory,
                    name: group.name.clone(),
                };
                Ok(row_of(all, &found, group))
            });
            let groups: Result<Vec<FailureRow>, EvalError> = groups.collect();
            of_scope.splice(1..1, groups?.into_iter().filter(|row| row.n_objects > 0));
        }
        rows.extend(of_scope);
    }
    Ok(rows)
}

fn row_of(all: &Plain<'_>, found: &failure::FailureRates, group: Group) -> FailureRow {
    let rates = [&found.failure_rate, &found.recovery_rate];
    failure_row(found, group, rates.map(|rate| unless_few(all, rate)))
}

/// The row of what was counted, with its rates of failure and recovery as far as they are given.
pub(super) fn failure_row(
    found: &failure::FailureRates,
    group: Group,
    [failure_rate, recovery_rate]: [Estimate; 2],
) -> FailureRow {
    FailureRow {
        scope: scope_of(found.group.place),
        group,
        n_objects: found.n_objects,
        n_found_clean: found.n_kept + found.n_lost,
        n_found_cracked: found.n_kept + found.n_recovered,
        n_lost: found.n_lost,
        n_recovered: found.n_recovered,
        p: found.test.p.filter(|_| failure_rate.value.is_some()),
        p_holm: None,
        failure_rate,
        recovery_rate,
    }
}

fn shift_rows(
    all: &Plain<'_>,
    pairs: &[ObjectPair],
    place: Where,
) -> Result<Vec<ShiftRow>, EvalError> {
    let mut categories: Vec<u32> = pairs.iter().map(|pair| pair.category).collect();
    categories.sort_unstable();
    categories.dedup();
    let groups = std::iter::once(None).chain(categories.into_iter().map(Some));
    let row = |category: Option<u32>| {
        let is_member = |pair: &&ObjectPair| category.is_none_or(|it| it == pair.category);
        let group = failure::Group { category, place };
        let found = shifts(group, pairs.iter().filter(is_member), all.plan)?;
        let score = unless_few(all, &found.score.mean);
        let p = |shift: &failure::Shift| shift.test.p.filter(|_| score.value.is_some());
        Ok(ShiftRow {
            scope: scope_of(place),
            group: match category {
                None => Group::all(),
                Some(category) => Group {
                    kind: GroupKind::Class,
                    name: class(all, category),
                },
            },
            n_pairs: found.n_pairs,
            p_score: p(&found.score),
            p_score_holm: None,
            p_iou: p(&found.iou),
            p_iou_holm: None,
            iou: unless_few(all, &found.iou.mean),
            score,
        })
    };
    groups.map(row).collect()
}

fn flip_row(
    all: &Plain<'_>,
    pairs: &[ObjectPair],
    matches: &Matches,
    place: Where,
) -> Result<FlipRow, EvalError> {
    let settings = all.settings;
    let found = class_flips(
        pairs,
        &matches.cracked,
        all.cracked,
        all.labels,
        settings.score_threshold,
        settings.iou_threshold,
        all.plan,
    )?;
    let mut commonest: Vec<ClassFlip> = found
        .table
        .iter()
        .map(|flip| ClassFlip {
            from: class(all, flip.category),
            to: class(all, flip.taken_for),
            n: flip.n,
        })
        .collect();
    commonest.sort_by(|a, b| (b.n, &a.from, &a.to).cmp(&(a.n, &b.from, &b.to)));
    Ok(FlipRow {
        scope: scope_of(place),
        n: found.n_found_clean,
        n_flipped: found.n_flipped,
        rate: unless_few(all, &found.flip_rate),
        commonest,
    })
}

/// Over coverage, and over each fact of the damage.
fn doses(
    all: &Plain<'_>,
    pairs: &[ObjectPair],
    facts: Option<&DamageFacts>,
) -> Result<Vec<DoseResponse>, EvalError> {
    let coverage = pairs.iter().map(|pair| (pair, pair.coverage));
    let mut doses = vec![dose(all, ("coverage", ""), coverage, &COVERAGE_BINS)?];
    let Some(facts) = facts else {
        return Ok(doses);
    };
    for (name, unit, values) in [
        ("displacement", "px", &facts.displacement_px),
        ("blur radius", "px", &facts.blur_radius_px),
        ("contrast lost", "", &facts.contrast_lost),
    ] {
        let value = |pair: &ObjectPair| values.get(pair.object as usize).copied();
        let with: Vec<(&ObjectPair, f64)> = pairs
            .iter()
            .map(|pair| (pair, value(pair).unwrap_or(f64::NAN)))
            .collect();
        let found = with.iter().filter(|(pair, _)| pair.clean.is_some());
        let known: Vec<f64> = found.map(|(_, value)| *value).collect();
        let edges = quantile_edges(&known, N_FACT_BINS);
        doses.push(match edges.len() > 2 {
            true => dose(all, (name, unit), with, &edges)?,
            false => DoseResponse {
                fact: name.to_owned(),
                unit: unit.to_owned(),
                group: Group::all(),
                bins: Vec::new(),
                note: Some(no_bins(&known)),
                fit: None,
            },
        });
    }
    Ok(doses)
}

/// Why there is nothing to tell objects apart by.
fn no_bins(known: &[f64]) -> String {
    let known: Vec<f64> = known.iter().copied().filter(|it| it.is_finite()).collect();
    let n_zero = known.iter().filter(|value| value.abs() <= 0.0).count();
    match (known.len(), n_zero) {
        (0, _) => "it was not recorded for any object found in the clean images".to_owned(),
        (n, n_zero) if n == n_zero => {
            format!("it is 0 for all {n} objects found in the clean images")
        }
        (n, 0) => {
            format!("it is the same for nearly all of the {n} objects found in the clean images")
        }
        (n, n_zero) => format!(
            "it is 0 for {n_zero} of {n} objects found in the clean images, too many for bins of equal counts"
        ),
    }
}

fn dose<'a>(
    all: &Plain<'_>,
    (fact, unit): (&str, &str),
    pairs: impl IntoIterator<Item = (&'a ObjectPair, f64)>,
    edges: &[f64],
) -> Result<DoseResponse, EvalError> {
    let found = failure::dose_response(fact, pairs, edges, all.plan)?;
    let bin = |bin: &failure::DoseBin| DoseBin {
        low: bin.low,
        high: bin.high,
        mean: bin.mean,
        n: bin.n,
        n_lost: bin.n_lost,
        rate: unless_few(all, &bin.failure_rate),
    };
    let slope = unless_few(all, &found.slope);
    let intercept = found.fit.intercept.estimate.value;
    Ok(DoseResponse {
        fact: fact.to_owned(),
        unit: unit.to_owned(),
        group: Group::all(),
        bins: found.bins.iter().map(bin).collect(),
        note: None,
        fit: intercept
            .filter(|_| slope.value.is_some())
            .map(|intercept| LogisticFit {
                intercept,
                slope,
                p: found.test.p,
                p_holm: None,
            }),
    })
}

fn appeared(
    all: &Plain<'_>,
    matches: &Matches,
    has_regions: bool,
    image_px: &[f64],
) -> Result<Vec<NewFalsePositives>, EvalError> {
    let coverage = |set: usize| {
        all.coverages
            .detections
            .get(set)
            .map_or(&[][..], Vec::as_slice)
    };
    let region_px: Vec<f64> = all
        .coverages
        .region_px
        .iter()
        .map(|n| crate::protocol::exact(n.unwrap_or(0)))
        .collect();
    let areas = FalsePositiveAreas {
        clean_coverage: coverage(0),
        cracked_coverage: coverage(1),
        region_px: &region_px,
        image_px,
        tau: all.settings.tau(),
    };
    let found = new_false_positives(
        (&matches.clean, all.clean),
        (&matches.cracked, all.cracked),
        areas,
        all.settings.score_threshold,
        all.plan,
    )?;
    let is_wanted = |row: &&failure::FalsePositives| has_regions || row.place == Where::Image;
    let row = |row: &failure::FalsePositives| NewFalsePositives {
        scope: scope_of(row.place),
        n_clean: row.n_clean,
        n_cracked: row.n_cracked,
        n_new: row.n_new,
        area_mpx: row.area_mpx,
        new_per_mpx: Estimate {
            n: row.n_new,
            ..estimate(&row.new_per_mpx)
        },
    };
    Ok(found.iter().filter(is_wanted).map(row).collect())
}
