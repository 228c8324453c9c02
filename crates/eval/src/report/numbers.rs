//! The numbers of a study that are compared and plotted, in one list: what CSV holds.

use super::clip_numbers::{of_clip, of_pooled_clips};
use super::conditions::labels;
use super::words;
use crate::SubsetRow;
use crate::evaluation::{
    DoseResponse, Estimate, Evaluation, FailureResults, FailureRow, Group, GroupKind, OverSeeds,
    PairedMetric, PairedRow, RobustnessRow, Scope, ScopeKind, Study, TideErrors,
};

/// One number with what it is about.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Number {
    /// The detector; empty for numbers about images alone.
    pub detector: String,
    /// The condition; the second of the same name has a `(2)` behind it, and so on.
    pub condition: String,
    /// `in_region`, `out_of_region` or `whole_image`; empty where there is no place.
    pub scope: &'static str,
    /// The share that decides about the region.
    pub tau: Option<f64>,
    /// `all`, `supercategory` or `class`; empty where there is no group.
    pub group_kind: &'static str,
    /// Name of the group.
    pub class: String,
    /// Which number.
    pub metric: String,
    /// The number of the clean images, where a difference is of two.
    pub clean: Option<f64>,
    /// That of the cracked images.
    pub cracked: Option<f64>,
    /// The number, or why there is none; of an AP, of scores and overlaps the difference.
    pub estimate: Estimate,
    /// Its p, where there is a test.
    pub p: Option<f64>,
    /// The same, corrected by Holm's method.
    pub p_holm: Option<f64>,
    /// How its interval, or it itself, came about.
    pub method: &'static str,
}

/// How a number that only counts came about.
pub(super) const COUNT: &str = "count";
const DIFFERENCE: &str = words::DIFFERENCE_INTERVAL;
const AP: &str = words::AP_INTERVAL;
const RATE: &str = words::RATE_INTERVAL;
const SHIFT: &str = words::SHIFT_INTERVAL;

/// The numbers of a study that are compared and plotted, in the order of the page; all others are in its JSON.
///
/// Of each condition the differences of AP and the failure rates in the region, out of it and on whole images, those
/// of supercategories and classes in the region and on whole images where they have a number; what else changes over
/// all classes. Of conditions that differ in their seed alone, the mean over seeds, too.
#[must_use]
pub fn numbers(study: &Study) -> Vec<Number> {
    let mut list = Vec::new();
    let own_tau = study.provenance.settings.tau;
    for one in &study.clean {
        if let Some(errors) = &one.tide {
            let of_all = one.results.groups.iter();
            let mut of_all = of_all.filter(|row| row.group.kind == GroupKind::All);
            let n_objects = of_all.next().map_or(0, |row| row.n_objects);
            let mut adder = Adder::new(&one.detector, "clean", &mut list);
            of_tide(&mut adder, errors, n_objects);
        }
    }
    for one in &study.over_seeds {
        let OverSeeds {
            paired,
            rates,
            condition,
            ..
        } = one;
        let mut adder = Adder::new(&one.detector, &condition.name, &mut list);
        of_pairs(&mut adder, paired, own_tau);
        of_rates(&mut adder, rates, own_tau);
    }
    for (evaluation, condition) in study.evaluations.iter().zip(labels(study)) {
        of_evaluation(evaluation, &condition, own_tau, &mut list);
    }
    for row in &study.robustness {
        of_robustness(row, &mut Adder::new(&row.detector, "all", &mut list));
    }
    if study.draws_clusters() {
        for number in &mut list {
            number.method = words::over_clusters(number.method);
        }
    }
    of_sets(study, &mut list);
    list
}

/// Adds numbers that share what they are about.
pub(super) struct Adder<'a> {
    pub(super) list: &'a mut Vec<Number>,
    pub(super) about: Number,
}

impl<'a> Adder<'a> {
    pub(super) fn new(detector: &str, condition: &str, list: &'a mut Vec<Number>) -> Self {
        let about = Number {
            detector: detector.to_owned(),
            condition: condition.to_owned(),
            ..Number::default()
        };
        Self { list, about }
    }

    fn scope(&mut self, scope: &Scope) {
        self.about.scope = match scope.kind {
            ScopeKind::InRegion => "in_region",
            ScopeKind::OutOfRegion => "out_of_region",
            ScopeKind::WholeImage => "whole_image",
        };
        self.about.tau = scope.tau;
    }

    fn group(&mut self, group: &Group) {
        self.about.group_kind = words::group_kind(group.kind);
        self.about.class.clone_from(&group.name);
    }

    pub(super) fn add(
        &mut self,
        metric: impl Into<String>,
        estimate: &Estimate,
        method: &'static str,
    ) {
        let number = self.about.clone();
        self.push(number, metric, estimate, method);
    }

    /// The same with what its test says.
    fn add_tested(
        &mut self,
        metric: impl Into<String>,
        estimate: &Estimate,
        method: &'static str,
        [p, p_holm]: [Option<f64>; 2],
    ) {
        let number = Number {
            p,
            p_holm,
            ..self.about.clone()
        };
        self.push(number, metric, estimate, method);
    }

    fn push(
        &mut self,
        mut number: Number,
        metric: impl Into<String>,
        estimate: &Estimate,
        method: &'static str,
    ) {
        number.metric = metric.into();
        number.estimate = estimate.clone();
        // What names an interval is only there with one.
        let has_interval = estimate.interval().is_some() || !method.ends_with("95 %");
        number.method = match (has_interval, estimate.value) {
            (true, _) => method,
            (false, Some(_)) => "no interval",
            (false, None) => "",
        };
        self.list.push(number);
    }

    pub(super) fn add_value(
        &mut self,
        metric: impl Into<String>,
        value: f64,
        n: u64,
        method: &'static str,
    ) {
        self.add(metric, &Estimate::of(value, n), method);
    }

    pub(super) fn add_count(&mut self, metric: impl Into<String>, count: u64) {
        self.add_value(metric, words::as_number(count), count, COUNT);
    }
}

fn of_evaluation(
    evaluation: &Evaluation,
    condition: &str,
    own_tau: Option<f64>,
    list: &mut Vec<Number>,
) {
    let counts = &evaluation.counts;
    let mut adder = Adder::new(&evaluation.detector, condition, list);
    adder.add_count("images", counts.n_images);
    if let Some(count) = counts.n_images_with_region {
        adder.add_count("images_with_region", count);
    }
    if let Some(share) = counts.mean_region_share {
        let n = counts.n_images;
        adder.add_value("mean_region_share", share, n, "mean over images");
    }
    of_pairs(&mut adder, &evaluation.paired, own_tau);
    for row in &evaluation.subsets {
        of_subset(&mut adder, row);
    }
    if let Some(failures) = &evaluation.failures {
        of_failures(&mut adder, failures, own_tau);
    }
    if let Some(errors) = &evaluation.tide_cracked {
        of_tide(&mut adder, errors, counts.n_objects);
    }
    adder = Adder::new(&evaluation.detector, condition, list);
    let about = adder.about.clone();
    for clip in &evaluation.timelines {
        of_clip(&about, clip, list);
    }
    if let Some(pooled) = &evaluation.pooled_clips {
        of_pooled_clips(&about, pooled, list);
    }
}

/// Whether a row is among the numbers: groups only where they have one, in the region at the study's own τ and on
/// whole images; at the other τ only the first metric of all classes.
fn is_listed(scope: &Scope, group: &Group, has_number: bool, own_tau: Option<f64>) -> bool {
    match group.kind {
        GroupKind::All => true,
        _ => has_number && scope.is_at(own_tau) && scope.kind != ScopeKind::OutOfRegion,
    }
}

fn of_pairs(adder: &mut Adder<'_>, rows: &[PairedRow], own_tau: Option<f64>) {
    for row in rows {
        let has_number = row.delta.value.is_some();
        let is_first = matches!(
            row.metric,
            PairedMetric::Ap50 | PairedMetric::KittiAp40 | PairedMetric::KittiAp11
        );
        let is_all = row.group.kind == GroupKind::All;
        if !is_listed(&row.scope, &row.group, has_number, own_tau)
            || !(is_first || is_all && row.scope.is_at(own_tau))
        {
            continue;
        }
        adder.scope(&row.scope);
        adder.group(&row.group);
        let number = Number {
            clean: row.clean.value,
            cracked: row.cracked.value,
            p: row.p,
            p_holm: row.p_holm,
            ..adder.about.clone()
        };
        let metric = words::metric_key(row.metric);
        adder.push(number, metric, &row.delta, DIFFERENCE);
    }
}

fn of_subset(adder: &mut Adder<'_>, row: &SubsetRow) {
    if row.group.kind != GroupKind::All {
        return;
    }
    let cracked = row.cracked_ap50.as_ref();
    let delta = match (row.clean_ap50.value, cracked.and_then(|it| it.value)) {
        (Some(clean), Some(cracked)) => Estimate::of(cracked - clean, row.n_objects),
        _ => cracked.unwrap_or(&row.clean_ap50).clone(),
    };
    adder.about.scope = "";
    adder.about.tau = None;
    adder.group(&row.group);
    let number = Number {
        clean: row.clean_ap50.value,
        cracked: cracked.and_then(|it| it.value),
        ..adder.about.clone()
    };
    let metric = format!("ap50[{}]", row.subset);
    adder.push(number, metric, &delta, "COCO protocol");
}

fn of_rates(adder: &mut Adder<'_>, rates: &[FailureRow], own_tau: Option<f64>) {
    for row in rates {
        let has_number = row.failure_rate.value.is_some();
        if !is_listed(&row.scope, &row.group, has_number, own_tau) {
            continue;
        }
        adder.scope(&row.scope);
        adder.group(&row.group);
        let p = [row.p, row.p_holm];
        adder.add_tested("failure_rate", &row.failure_rate, RATE, p);
        if row.group.kind == GroupKind::All {
            adder.add("recovery_rate", &row.recovery_rate, RATE);
        }
    }
}

fn of_failures(adder: &mut Adder<'_>, failures: &FailureResults, own_tau: Option<f64>) {
    of_rates(adder, &failures.rates, own_tau);
    adder.group(&Group::all());
    for row in &failures.new_false_positives {
        adder.scope(&row.scope);
        let per_mpx = "new_false_positives_per_mpx";
        adder.add(per_mpx, &row.new_per_mpx, AP);
    }
    let of_all = |row: &&crate::evaluation::ShiftRow| row.group.kind == GroupKind::All;
    for row in failures.shifts.iter().filter(of_all) {
        adder.scope(&row.scope);
        let p = [row.p_score, row.p_score_holm];
        adder.add_tested("score_shift", &row.score, SHIFT, p);
        let p = [row.p_iou, row.p_iou_holm];
        adder.add_tested("iou_shift", &row.iou, SHIFT, p);
    }
    for row in &failures.flips {
        adder.scope(&row.scope);
        adder.add("flip_rate", &row.rate, RATE);
    }
    adder.about.scope = "";
    adder.about.tau = None;
    for dose in &failures.dose_responses {
        of_dose(adder, dose);
    }
}

fn of_dose(adder: &mut Adder<'_>, dose: &DoseResponse) {
    adder.group(&dose.group);
    if let Some(fit) = &dose.fit {
        let metric = format!("logistic_slope_{}", dose.fact.replace(' ', "_"));
        let p = [fit.p, fit.p_holm];
        adder.add_tested(metric, &fit.slope, words::SLOPE_INTERVAL, p);
    }
}

fn of_tide(adder: &mut Adder<'_>, errors: &TideErrors, n_objects: u64) {
    adder.scope(&Scope::whole_image());
    adder.group(&Group::all());
    for (name, value) in [
        ("ap50", errors.ap50),
        ("classification", errors.classification),
        ("localization", errors.localization),
        ("both", errors.both),
        ("duplicate", errors.duplicate),
        ("background", errors.background),
        ("missed", errors.missed),
        ("false_positive", errors.false_positive),
        ("false_negative", errors.false_negative),
    ] {
        adder.add_value(format!("tide_{name}"), value, n_objects, "TIDE");
    }
}

fn of_robustness(row: &RobustnessRow, adder: &mut Adder<'_>) {
    adder.scope(&row.scope);
    adder.group(&Group::all());
    let metric = words::metric_key(row.metric);
    let number = Number {
        clean: row.clean.value,
        cracked: row.mpc.value,
        ..adder.about.clone()
    };
    adder.push(
        number,
        format!("rpc_{metric}"),
        &row.rpc,
        words::RATIO_INTERVAL,
    );
    adder.add(format!("mpc_{metric}"), &row.mpc, AP);
}

/// How far the first set, which is the clean one, lies from each other one.
fn of_sets(study: &Study, list: &mut Vec<Number>) {
    let Some(divergence) = &study.divergence else {
        return;
    };
    let Some((from, others)) = divergence.sets.split_first() else {
        return;
    };
    for table in &divergence.tables {
        let Some(row) = table.values.first() else {
            continue;
        };
        for (estimate, to) in row.iter().skip(1).zip(others) {
            if (estimate.n, estimate.value) == (0, None) {
                continue;
            }
            let mut adder = Adder::new("", &format!("{from} | {to}"), list);
            let metric = format!("{} of {}", table.measure, table.feature);
            adder.add(metric, estimate, "distance between image sets");
        }
    }
}
