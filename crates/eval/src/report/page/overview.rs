//! What all evaluations of a study say together.

use super::super::conditions::{Summed, summed};
use super::super::words;
use super::{Block, Cell, Section, Table, curves, pictures};
use crate::evaluation::{FailureRow, GroupKind, PairedMetric, PairedRow, ScopeKind, Study};

/// The row that sums up: all classes, of the given place and metric, at the study's own τ.
pub(super) fn headline<'a>(
    study: &Study,
    one: &Summed<'a>,
    kind: ScopeKind,
    metric: PairedMetric,
) -> Option<&'a PairedRow> {
    let is_it = |row: &&PairedRow| {
        row.scope.kind == kind
            && row.metric == metric
            && row.group.kind == GroupKind::All
            && row.scope.is_at(study.provenance.settings.tau)
    };
    one.paired.iter().find(is_it)
}

/// The same of the rates of failure.
pub(super) fn headline_failure<'a>(
    study: &Study,
    one: &Summed<'a>,
    kind: ScopeKind,
) -> Option<&'a FailureRow> {
    one.rates.iter().find(|row| {
        row.scope.kind == kind
            && row.group.kind == GroupKind::All
            && row.scope.is_at(study.provenance.settings.tau)
    })
}

pub(super) fn subtitle(study: &Study) -> String {
    let all = study.evaluations.iter();
    let detectors = words::distinct(all.clone().map(|one| &one.detector));
    let conditions = words::distinct(all.map(|one| &one.condition.name));
    let n_images = study.evaluations.first().map_or(0, |e| e.counts.n_images);
    let n_objects = study.evaluations.first().map_or(0, |e| e.counts.n_objects);
    words::name(&format!(
        "{} images with {} objects of {}, clean and damaged: {} and {}, by the rules of {}.",
        words::count(n_images),
        words::count(n_objects),
        study.dataset,
        plural(detectors.len(), "detector"),
        plural(conditions.len(), "condition"),
        protocol_name(&study.provenance.settings.protocol),
    ))
}

fn protocol_name(protocol: &str) -> &str {
    match protocol {
        "coco" => "MS-COCO",
        "kitti" => "KITTI",
        "bdd" => "BDD100K",
        other => other,
    }
}

fn plural(n: usize, what: &str) -> String {
    match n {
        1 => format!("1 {what}"),
        _ => format!("{n} {what}s"),
    }
}

/// The findings, one sentence each.
pub(super) fn facts(study: &Study) -> Vec<String> {
    let mut facts = Vec::new();
    let all = summed(study);
    if all.len() > 4 {
        return facts_of_many(study, &all);
    }
    for one in &all {
        let who = format!("{}, {}", one.detector, one.condition.name);
        if let Some(row) = headline(study, one, ScopeKind::InRegion, PairedMetric::Ap50)
            && let (Some(clean), Some(cracked), Some(delta)) =
                (row.clean.value, row.cracked.value, row.delta.value)
        {
            let interval = row.delta.interval().map_or(String::new(), |[low, high]| {
                let ends = [low, high].map(words::signed_percent);
                format!(", 95 % interval {} to {}", ends[0], ends[1])
            });
            facts.push(words::name(&format!(
                "{who}: AP50 in the region changes from {} to {} ({} points{interval}).",
                words::percent(clean),
                words::percent(cracked),
                words::signed_percent(delta),
            )));
        }
        let inside = headline_failure(study, one, ScopeKind::InRegion);
        let outside = headline_failure(study, one, ScopeKind::OutOfRegion);
        if let Some(row) = inside
            && let Some(rate) = row.failure_rate.value
        {
            let control = outside
                .filter(|row| row.failure_rate.value.is_some())
                .map_or(String::new(), |row| {
                    let rate = row.failure_rate.value.map_or(String::new(), words::percent);
                    format!(
                        "; outside the region, {} of {} ({rate} %)",
                        words::count(row.n_lost),
                        words::count(row.n_found_clean),
                    )
                });
            facts.push(words::name(&format!(
                "{who}: of {} objects in the region found in the clean images, {} are lost ({} %){control}.",
                words::count(row.n_found_clean),
                words::count(row.n_lost),
                words::percent(rate),
            )));
        }
    }
    facts
}

/// The same of many conditions: from which to which value, per detector.
fn facts_of_many(study: &Study, all: &[Summed<'_>]) -> Vec<String> {
    let detectors = words::distinct(all.iter().map(|one| one.detector));
    let fact = |detector: &&str| {
        let of_detector: Vec<&Summed<'_>> =
            all.iter().filter(|one| one.detector == *detector).collect();
        let deltas = of_detector.iter().filter_map(|one| {
            headline(study, one, ScopeKind::InRegion, PairedMetric::Ap50)?
                .delta
                .value
        });
        let deltas: Vec<f64> = deltas.collect();
        let rates = |kind| {
            let rate =
                move |one: &&Summed<'_>| headline_failure(study, one, kind)?.failure_rate.value;
            of_detector.iter().filter_map(rate).collect::<Vec<f64>>()
        };
        let n_conditions = of_detector.len();
        let mut parts = Vec::new();
        if let Some([least, most]) = span(&deltas) {
            parts.push(format!(
                "AP50 in the region changes by {} to {} points{}",
                words::signed_percent(least),
                words::signed_percent(most),
                have_a_number(deltas.len(), n_conditions),
            ));
        }
        for (kind, place) in [
            (ScopeKind::InRegion, "in the region"),
            (ScopeKind::OutOfRegion, "outside the region"),
        ] {
            let rates = rates(kind);
            if let Some([least, most]) = span(&rates) {
                parts.push(format!(
                    "{place}, {} to {} % of the objects found in the clean images are lost{}",
                    words::percent(least),
                    words::percent(most),
                    have_a_number(rates.len(), n_conditions),
                ));
            }
        }
        if parts.is_empty() {
            return words::name(&format!(
                "{detector}: none of the {n_conditions} conditions has a number in the region."
            ));
        }
        words::name(&format!(
            "{detector}, {n_conditions} conditions: {}.",
            parts.join("; ")
        ))
    };
    detectors.iter().map(fact).collect()
}

/// How many of the conditions a span is of, where it is not of all.
fn have_a_number(n: usize, n_conditions: usize) -> String {
    match n == n_conditions {
        true => String::new(),
        false => format!(" ({n} of {n_conditions} conditions have a number)"),
    }
}

/// Least and greatest of values.
fn span(values: &[f64]) -> Option<[f64; 2]> {
    values.iter().fold(None, |ends: Option<[f64; 2]>, value| {
        Some(match ends {
            None => [*value, *value],
            Some([least, most]) => [least.min(*value), most.max(*value)],
        })
    })
}

pub(super) fn section(study: &Study) -> Section {
    let all = summed(study);
    let mut blocks = vec![Block::table(overview_table(study, &all))];
    if all.iter().any(|one| one.n_seeds > 1) {
        let singles: Vec<Summed<'_>> = study.evaluations.iter().map(Summed::of).collect();
        blocks.push(Block::fold(
            "Each seed separately",
            vec![Block::table(overview_table(study, &singles))],
        ));
    }
    blocks.extend(pictures::examples(study));
    blocks.extend(curves::overview(study));
    blocks.extend(robustness_table(study).map(Block::table));
    Section {
        id: "overview".to_owned(),
        title: "Overview".to_owned(),
        blocks,
    }
}

fn overview_table(study: &Study, all: &[Summed<'_>]) -> Table {
    let mut table = Table::new(
        "All detectors and conditions: AP50 of all classes in the region, clean and damaged, and the share of \
         the objects found in the clean images that are lost, in the region and outside it. Percent; 95 % \
         intervals in brackets.",
        "Detector|Condition|#Objects in region|#AP50 clean|#AP50 damaged|#Difference|#p (Holm)|#Lost in region|#Lost outside",
    );
    for one in all {
        let paired = headline(study, one, ScopeKind::InRegion, PairedMetric::Ap50)
            .or_else(|| headline(study, one, ScopeKind::WholeImage, PairedMetric::Ap50));
        let failure = |kind| headline_failure(study, one, kind).map(|row| &row.failure_rate);
        let mut row = vec![
            Cell::head(one.detector),
            Cell::text(words::name(&one.condition.name)),
        ];
        match paired {
            Some(paired) => {
                row.push(Cell::count(paired.n_objects));
                row.push(table.estimate(&paired.clean, words::percent));
                row.push(table.estimate(&paired.cracked, words::percent));
                row.push(table.estimate(&paired.delta, words::signed_percent));
                row.push(Cell::probability(paired.p_holm));
            }
            None => row.extend([(); 5].map(|()| Cell::nothing())),
        }
        for kind in [ScopeKind::InRegion, ScopeKind::OutOfRegion] {
            row.push(table.estimate(failure(kind), words::percent));
        }
        table.push(row);
    }
    let n_seeds = all.iter().map(|one| one.n_seeds).max().unwrap_or(1);
    let units = units(study);
    table.remark(&match n_seeds {
        0 | 1 => format!(
            "Each row is one random draw of damage; its intervals are over {units}, each with damage of its own."
        ),
        _ => format!(
            "Rows with several seeds are means over them; intervals and p resample and exchange {units} with \
             all their seeds. An object counts once per seed."
        ),
    });
    table.remark(
        "p tests the difference, with Holm's correction over the conditions of the detector.",
    );
    table
}

fn robustness_table(study: &Study) -> Option<Table> {
    if study.robustness.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "Robustness over all conditions: mean performance under corruption (mPC) and relative performance \
         under corruption (rPC). Percent; 95 % intervals in brackets, for AP50 and AP75.",
        "Detector|Where|Metric|#Clean|#mPC|#rPC",
    );
    for row in &study.robustness {
        let cells = vec![
            Cell::head(&row.detector),
            Cell::text(words::scope(&row.scope)),
            Cell::text(words::metric(row.metric)),
            table.estimate(&row.clean, words::percent),
            table.estimate(&row.mpc, words::percent),
            table.estimate(&row.rpc, words::percent),
        ];
        table.push(cells);
    }
    let seeds: Vec<Option<u64>> = study.robustness.iter().map(|row| row.n_seeds).collect();
    let remark = match seeds.iter().copied().min().flatten() {
        None => "There are no intervals, because families and severities differ in their seeds."
            .to_owned(),
        Some(0 | 1) => format!("Intervals resample {}.", units(study)),
        Some(n) => format!("Intervals resample {} with all {n} seeds.", units(study)),
    };
    table.remark(&remark);
    let mut conditions = study.evaluations.iter().map(|one| &one.condition);
    if conditions.any(|condition| condition.severity.is_none()) {
        table
            .remark("Conditions without a severity, such as recipes, are left out of these means.");
    }
    Some(table)
}

/// One of what intervals draw.
pub(super) fn unit(study: &Study) -> &'static str {
    match study.draws_clusters() {
        true => "cluster",
        false => "image",
    }
}

/// What intervals draw.
pub(super) fn units(study: &Study) -> &'static str {
    match study.draws_clusters() {
        true => "clusters of images (clips, drives)",
        false => "images",
    }
}
