//! All numbers of a study in one long list, one row each: what CSV holds.

use super::clip_numbers::{of_clip, of_pooled_clips};
use super::conditions::labels;
use super::words;
use crate::SubsetRow;
use crate::evaluation::{
    DoseResponse, Estimate, Evaluation, FailureResults, FailureRow, Group, GroupAp, GroupKind,
    PairedRow, ProtocolResults, Scope, ScopeKind, Study, TideErrors,
};

/// One number with what it is about.
#[derive(Debug, Clone, PartialEq)]
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
    /// The number, or why there is none.
    pub estimate: Estimate,
    /// How its interval, or it itself, came about.
    pub method: &'static str,
}

const TWO_WAY: &str = "two-way bootstrap over images and seeds, 95 %";
const BOOTSTRAP: &str = "paired bootstrap over images, 95 %";
const OVER_IMAGES: &str = "bootstrap over images, 95 %";
const MEAN_TWO_WAY: &str =
    "mean over families, severities and seeds; two-way bootstrap over images and seeds, 95 %";
const MEAN_OVER_IMAGES: &str = "mean over families and severities; bootstrap over images, 95 %";
/// How a number that only counts came about.
pub(super) const COUNT: &str = "count";
const WILSON: &str = "Wilson, 95 %";

/// All numbers of a study, in the order of the page.
#[must_use]
pub fn numbers(study: &Study) -> Vec<Number> {
    let mut list = Vec::new();
    for one in &study.clean {
        let about = blank(&one.detector, "clean");
        of_protocol(&about, "clean", &one.results, &mut list);
        if let Some(errors) = &one.tide {
            let of_all = |row: &&GroupAp| row.group.kind == GroupKind::All;
            let n = one.results.groups.iter().find(of_all);
            of_tide(
                &about,
                "clean",
                errors,
                n.map_or(0, |row| row.n_objects),
                &mut list,
            );
        }
    }
    for pooled in &study.pooled {
        let about = blank(&pooled.detector, &pooled.condition.name);
        for row in &pooled.paired {
            of_pair(&about, row, TWO_WAY, &mut list);
        }
        of_rates(&about, &pooled.rates, TWO_WAY, &mut list);
    }
    for (evaluation, condition) in study.evaluations.iter().zip(labels(study)) {
        of_evaluation(evaluation, &condition, &mut list);
    }
    for row in &study.robustness {
        let metric = words::metric_key(row.metric);
        let method = match (row.mpc.interval().is_some(), row.n_seeds) {
            (false, _) => "mean over families, severities and seeds",
            (true, Some(2..)) => MEAN_TWO_WAY,
            (true, _) => MEAN_OVER_IMAGES,
        };
        for (name, estimate) in [("clean", &row.clean), ("mpc", &row.mpc), ("rpc", &row.rpc)] {
            let mut number = blank(&row.detector, "all");
            put_scope(&mut number, &row.scope);
            put_group(&mut number, &Group::all());
            number.metric = format!("{name}_{metric}");
            number.estimate = estimate.clone();
            number.method = method;
            list.push(number);
        }
    }
    if study.draws_clusters() {
        for number in &mut list {
            number.method = over_clusters(number.method);
        }
    }
    of_sets(study, &mut list);
    list
}

/// The same method where clusters of images are drawn.
fn over_clusters(method: &'static str) -> &'static str {
    match method {
        TWO_WAY => "two-way bootstrap over clusters of images and seeds, 95 %",
        BOOTSTRAP => "paired bootstrap over clusters of images, 95 %",
        OVER_IMAGES => "bootstrap over clusters of images, 95 %",
        MEAN_TWO_WAY => {
            "mean over families, severities and seeds; two-way bootstrap over clusters of images and seeds, 95 %"
        }
        MEAN_OVER_IMAGES => {
            "mean over families and severities; bootstrap over clusters of images, 95 %"
        }
        other => other,
    }
}

fn blank(detector: &str, condition: &str) -> Number {
    Number {
        detector: detector.to_owned(),
        condition: condition.to_owned(),
        scope: "",
        tau: None,
        group_kind: "",
        class: String::new(),
        metric: String::new(),
        estimate: Estimate::default(),
        method: "",
    }
}

fn put_scope(number: &mut Number, scope: &Scope) {
    number.scope = match scope.kind {
        ScopeKind::InRegion => "in_region",
        ScopeKind::OutOfRegion => "out_of_region",
        ScopeKind::WholeImage => "whole_image",
    };
    number.tau = scope.tau;
}

fn put_group(number: &mut Number, group: &Group) {
    number.group_kind = words::group_kind(group.kind);
    number.class.clone_from(&group.name);
}

/// Adds numbers that share what they are about.
pub(super) struct Adder<'a> {
    pub(super) list: &'a mut Vec<Number>,
    pub(super) about: Number,
}

impl Adder<'_> {
    pub(super) fn add(
        &mut self,
        metric: impl Into<String>,
        estimate: &Estimate,
        method: &'static str,
    ) {
        let mut number = self.about.clone();
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

fn of_evaluation(evaluation: &Evaluation, condition: &str, list: &mut Vec<Number>) {
    let about = blank(&evaluation.detector, condition);
    of_protocol(&about, "cracked", &evaluation.cracked, list);
    let counts = &evaluation.counts;
    let mut adder = Adder {
        list,
        about: about.clone(),
    };
    for (name, count) in [
        ("images", Some(counts.n_images)),
        ("images_with_region", counts.n_images_with_region),
        ("images_intact", counts.n_images_intact),
    ] {
        if let Some(count) = count {
            adder.add_count(name, count);
        }
    }
    if let Some(share) = counts.mean_region_share {
        adder.add_value(
            "mean_region_share",
            share,
            counts.n_images,
            "mean over images",
        );
    }
    for row in &evaluation.paired {
        of_pair(&about, row, BOOTSTRAP, list);
    }
    for row in &evaluation.subsets {
        of_subset(&about, row, list);
    }
    if let Some(failures) = &evaluation.failures {
        of_failures(&about, failures, list);
    }
    if let Some(errors) = &evaluation.tide_cracked {
        of_tide(&about, "cracked", errors, evaluation.counts.n_objects, list);
    }
    for clip in &evaluation.timelines {
        of_clip(&about, clip, list);
    }
    if let Some(pooled) = &evaluation.pooled_clips {
        of_pooled_clips(&about, pooled, list);
    }
}

fn of_protocol(about: &Number, side: &str, results: &ProtocolResults, list: &mut Vec<Number>) {
    const STATS: [&str; 12] = [
        "ap",
        "ap50",
        "ap75",
        "ap_small",
        "ap_medium",
        "ap_large",
        "ar_1",
        "ar_10",
        "ar_100",
        "ar_small",
        "ar_medium",
        "ar_large",
    ];
    let mut about = about.clone();
    put_scope(&mut about, &Scope::whole_image());
    let mut adder = Adder { list, about };
    put_group(&mut adder.about, &Group::all());
    let of_all = |row: &&GroupAp| row.group.kind == GroupKind::All;
    let n_all = results
        .groups
        .iter()
        .find(of_all)
        .map_or(0, |row| row.n_objects);
    for (name, value) in STATS.iter().zip(results.coco_stats.into_iter().flatten()) {
        // How many objects have a size is not among the results.
        let is_of_all = !["_small", "_medium", "_large"]
            .iter()
            .any(|size| name.ends_with(size));
        let n = if is_of_all { n_all } else { 0 };
        let estimate = match value {
            Some(value) => Estimate::of(value, n),
            None => Estimate::refused(0, "no such object"),
        };
        adder.add(format!("coco_{name}_{side}"), &estimate, "COCO protocol");
    }
    // The AP, AP50 and AP75 of all stand among the twelve already, where they are there.
    let is_new = |row: &&GroupAp| results.coco_stats.is_none() || row.group.kind != GroupKind::All;
    for row in results.groups.iter().filter(is_new) {
        put_group(&mut adder.about, &row.group);
        for (name, estimate) in [("ap", &row.ap), ("ap50", &row.ap50), ("ap75", &row.ap75)] {
            adder.add(format!("coco_{name}_{side}"), estimate, "COCO protocol");
        }
    }
    for row in &results.kitti {
        let group = Group {
            kind: GroupKind::Class,
            name: row.class.clone(),
        };
        put_group(&mut adder.about, &group);
        let difficulty = &row.difficulty;
        let name = |what: &str| format!("kitti_{what}_{difficulty}_{side}");
        adder.add(name("ap11"), &row.ap11, "KITTI protocol");
        adder.add(name("ap40"), &row.ap40, "KITTI protocol");
        let n = row.n_objects;
        adder.add_value(name("ceiling_ap11"), row.ceiling_ap11, n, "closed form");
        adder.add_value(name("ceiling_ap40"), row.ceiling_ap40, n, "closed form");
    }
}

fn of_pair(about: &Number, row: &PairedRow, method: &'static str, list: &mut Vec<Number>) {
    let mut about = about.clone();
    put_scope(&mut about, &row.scope);
    put_group(&mut about, &row.group);
    let mut adder = Adder { list, about };
    let metric = words::metric_key(row.metric);
    let all = [
        ("clean", &row.clean),
        ("cracked", &row.cracked),
        ("difference", &row.delta),
    ];
    // One reason for all three is said once.
    let is_refused = all
        .iter()
        .all(|(_, estimate)| estimate.value.is_none() && estimate.refused == row.delta.refused);
    if is_refused {
        adder.add(metric, &row.delta, method);
        return;
    }
    for (name, estimate) in all {
        adder.add(format!("{metric}_{name}"), estimate, method);
    }
    let n = row.n_objects;
    let p = [
        ("p", row.p, "permutation"),
        ("p_holm", row.p_holm, "permutation, Holm"),
    ];
    for (name, p, method) in p {
        if let Some(p) = p {
            adder.add_value(format!("{metric}_{name}"), p, n, method);
        }
    }
    if let Some(ceiling) = row.ceiling {
        adder.add_value(format!("{metric}_ceiling"), ceiling, n, "closed form");
    }
}

fn of_subset(about: &Number, row: &SubsetRow, list: &mut Vec<Number>) {
    let mut about = about.clone();
    put_group(&mut about, &row.group);
    let mut adder = Adder { list, about };
    let subset = &row.subset;
    let sides = [
        ("clean", Some(&row.clean_ap50)),
        ("cracked", row.cracked_ap50.as_ref()),
    ];
    for (side, estimate) in sides {
        if let Some(estimate) = estimate {
            adder.add(format!("ap50_{side}[{subset}]"), estimate, "COCO protocol");
        }
    }
}

/// What is lost, with where the interval of the rate of failure comes from.
fn of_rates(about: &Number, rates: &[FailureRow], method: &'static str, list: &mut Vec<Number>) {
    let mut adder = Adder {
        list,
        about: about.clone(),
    };
    for row in rates {
        put_scope(&mut adder.about, &row.scope);
        put_group(&mut adder.about, &row.group);
        adder.add("failure_rate", &row.failure_rate, method);
        if let Some(rate) = &row.failure_rate_over_images {
            adder.add("failure_rate_over_images", rate, OVER_IMAGES);
        }
        adder.add("recovery_rate", &row.recovery_rate, WILSON);
        for (name, count) in [
            ("objects", row.n_objects),
            ("found_clean", row.n_found_clean),
            ("found_cracked", row.n_found_cracked),
            ("lost", row.n_lost),
            ("recovered", row.n_recovered),
        ] {
            adder.add_count(name, count);
        }
        let p = [
            ("failure_p", row.p, "McNemar, exact"),
            ("failure_p_holm", row.p_holm, "McNemar, exact, Holm"),
        ];
        for (name, p, method) in p {
            if let Some(p) = p {
                adder.add_value(name, p, row.n_lost + row.n_recovered, method);
            }
        }
    }
}

fn of_failures(about: &Number, failures: &FailureResults, list: &mut Vec<Number>) {
    of_rates(about, &failures.rates, WILSON, list);
    let mut adder = Adder {
        list,
        about: about.clone(),
    };
    for row in &failures.new_false_positives {
        put_scope(&mut adder.about, &row.scope);
        adder.add(
            "new_false_positives_per_mpx",
            &row.new_per_mpx,
            "Poisson, exact, 95 %",
        );
        adder.add_count("false_positives_clean", row.n_clean);
        adder.add_count("false_positives_cracked", row.n_cracked);
        adder.add_count("new_false_positives", row.n_new);
    }
    for row in &failures.shifts {
        put_scope(&mut adder.about, &row.scope);
        put_group(&mut adder.about, &row.group);
        adder.add("score_shift", &row.score, "bootstrap, 95 %");
        adder.add("iou_shift", &row.iou, "bootstrap, 95 %");
        let p = [("score_shift_p", row.p_score), ("iou_shift_p", row.p_iou)];
        for (name, p) in p {
            if let Some(p) = p {
                adder.add_value(name, p, row.n_pairs, "Wilcoxon signed-rank");
            }
        }
    }
    for row in &failures.flips {
        put_scope(&mut adder.about, &row.scope);
        put_group(&mut adder.about, &Group::all());
        adder.add("flip_rate", &row.rate, WILSON);
    }
    adder.about = about.clone();
    for dose in &failures.dose_responses {
        of_dose(&mut adder, dose);
    }
}

fn of_dose(adder: &mut Adder<'_>, dose: &DoseResponse) {
    put_group(&mut adder.about, &dose.group);
    let fact = dose.fact.replace(' ', "_");
    for bin in &dose.bins {
        // All digits: bins of a dose whose values lie close together are told apart by the last ones.
        let name = format!("failure_rate_at_{fact}_{}_to_{}", bin.low, bin.high);
        adder.add(name, &bin.rate, WILSON);
    }
    if let Some(fit) = &dose.fit {
        let n = fit.slope.n;
        adder.add(
            format!("logistic_slope_{fact}"),
            &fit.slope,
            "maximum likelihood, Wald, 95 %",
        );
        adder.add_value(
            format!("logistic_intercept_{fact}"),
            fit.intercept,
            n,
            "maximum likelihood",
        );
        if let Some(p) = fit.p {
            adder.add_value(format!("logistic_p_{fact}"), p, n, "Wald");
        }
    }
}

fn of_tide(
    about: &Number,
    side: &str,
    errors: &TideErrors,
    n_objects: u64,
    list: &mut Vec<Number>,
) {
    let mut about = about.clone();
    put_scope(&mut about, &Scope::whole_image());
    put_group(&mut about, &Group::all());
    let mut adder = Adder { list, about };
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
        adder.add_value(format!("tide_{name}_{side}"), value, n_objects, "TIDE");
    }
}

fn of_sets(study: &Study, list: &mut Vec<Number>) {
    let Some(divergence) = &study.divergence else {
        return;
    };
    for table in &divergence.tables {
        for (row, from) in table.values.iter().zip(&divergence.sets) {
            for (estimate, to) in row
                .iter()
                .zip(&divergence.sets)
                .filter(|(estimate, to)| *to != from && (estimate.n, estimate.value) != (0, None))
            {
                let mut number = blank("", &format!("{from} | {to}"));
                number.metric = format!("{} of {}", table.measure, table.feature);
                number.estimate = estimate.clone();
                number.method = "distance between sets of images";
                list.push(number);
            }
        }
    }
}
