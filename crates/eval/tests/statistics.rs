//! Statistics against programs that we did not write: statsmodels, SciPy and tidecv, by way of
//! `statistics/known_answers.py`.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot read its answers has failed"
)]

use serde_json::Value;
use starbreak_eval::failure::fit_logistic;
use starbreak_eval::resampling::{Basis, expanded_interval, percentile_interval};
use starbreak_eval::resampling::{Plan, bootstrap};
use starbreak_eval::statistic::{holm, mcnemar, wilson_interval};
use starbreak_eval::tide::{TideSettings, tide};
use starbreak_eval::timeline::{Survival, kaplan_meier, kaplan_meier_of_clusters};
use starbreak_eval::{
    BoxPx, Category, Detection, Detections, LabelSet, LabeledImage, Object, ObjectKind,
};

fn answers(part: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("statistics/known_answers.json")).unwrap();
    let cases = all[part].as_array().unwrap().clone();
    assert!(!cases.is_empty(), "there are answers for {part}");
    cases
}

fn f64s(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|it| it.as_f64().unwrap()).collect()
}

#[track_caller]
fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(
        off <= relative * expected.abs().max(1e-300),
        "{what}: {found} instead of {expected}, off by {off:e}"
    );
}

#[test]
fn wilson_intervals_are_those_of_statsmodels() {
    for case in answers("wilson") {
        let (k, n) = (case["k"].as_u64().unwrap(), case["n"].as_u64().unwrap());
        let interval = wilson_interval(k, n, case["level"].as_f64().unwrap()).unwrap();
        for (found, end) in [(interval.low, "low"), (interval.high, "high")] {
            let expected = case[end].as_f64().unwrap();
            assert!(
                (found - expected).abs() < 1e-13,
                "{end} of {k} of {n}: {found} instead of {expected}"
            );
        }
    }
    assert_eq!(wilson_interval(0, 0, 0.95), None, "no share of nothing");
    assert_eq!(wilson_interval(1, 2, 1.0), None, "nothing is certain");
}

#[test]
fn mcnemar_is_that_of_statsmodels() {
    for case in answers("mcnemar") {
        let (b, c) = (case["b"].as_u64().unwrap(), case["c"].as_u64().unwrap());
        let test = mcnemar(b, c);
        let what = format!("{b} against {c}");
        let (exact, mid_p) = (test.exact.p.unwrap(), test.mid_p.p.unwrap());
        assert_close(exact, case["exact"].as_f64().unwrap(), 1e-10, &what);
        assert_close(mid_p, case["mid_p"].as_f64().unwrap(), 1e-10, &what);
        assert_eq!(test.exact.n, b + c, "n of {what}");
    }
    let none = mcnemar(0, 0);
    assert_eq!(none.exact.p, None, "no change, no p");
    assert!(none.exact.reason.is_some(), "and a reason");
}

#[test]
fn holm_is_that_of_statsmodels() {
    for case in answers("holm") {
        let p: Vec<Option<f64>> = f64s(&case["p"]).into_iter().map(Some).collect();
        for (found, expected) in holm(&p).into_iter().zip(f64s(&case["corrected"])) {
            assert_close(found.unwrap(), expected, 1e-14, "corrected p");
        }
    }
}

#[test]
fn logistic_curves_are_those_of_statsmodels() {
    for case in answers("logistic") {
        let failed: Vec<bool> = f64s(&case["failed"]).iter().map(|it| *it > 0.5).collect();
        let clusters: Vec<u32> = case["clusters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| u32::try_from(it.as_u64().unwrap()).unwrap())
            .collect();
        let fit = fit_logistic(&f64s(&case["dose"]), &failed, &clusters, 0.95);
        for (place, coefficient) in [&fit.intercept, &fit.slope].into_iter().enumerate() {
            let beta = f64s(&case["beta"])[place];
            assert_close(coefficient.estimate.value.unwrap(), beta, 1e-8, "beta");
            let se = f64s(&case["se"])[place];
            assert_close(coefficient.standard_error.unwrap(), se, 1e-8, "error");
            let se = f64s(&case["se_clustered"])[place];
            let found = coefficient.standard_error_clustered.unwrap();
            assert_close(found, se, 1e-8, "error over clusters");
            let p = f64s(&case["p"])[place];
            assert_close(coefficient.test.p.unwrap(), p, 1e-6, "p");
        }
        let interval = fit.slope.estimate.interval.unwrap();
        let ends = f64s(&case["slope_interval"]);
        assert_close(interval.low, ends[0], 1e-6, "lower end of the slope");
        assert_close(interval.high, ends[1], 1e-6, "upper end of the slope");
        let auc = case["auc"].as_f64().unwrap();
        assert_close(fit.auc.value.unwrap(), auc, 1e-12, "AUC");
    }
}

#[test]
fn percentiles_are_those_of_scipy_from_the_same_replicates() {
    for case in answers("bootstrap") {
        let replicates = f64s(&case["replicates"]);
        let found = percentile_interval(&replicates, 0.95).unwrap();
        let expected = f64s(&case["percentile"]);
        assert_close(found.low, expected[0], 1e-10, "lower end");
        assert_close(found.high, expected[1], 1e-10, "upper end");
        // Of many units the expanded interval is the percentile one; of few it is wider.
        let width = |n: u32| {
            let interval = expanded_interval(&replicates, 0.95, Basis::Units(n)).unwrap();
            interval.high - interval.low
        };
        let plain = found.high - found.low;
        assert!((width(1_000_000) / plain - 1.0).abs() < 1e-3, "many");
        assert!(width(8) > 1.1 * plain, "{} against {plain}", width(8));
    }
}

fn place(value: &Value) -> u32 {
    u32::try_from(value.as_u64().unwrap()).unwrap()
}

fn box_px(value: &Value) -> BoxPx {
    let sides = f64s(value);
    BoxPx {
        x: sides[0],
        y: sides[1],
        width: sides[2],
        height: sides[3],
    }
}

fn tide_input(case: &Value) -> (LabelSet, Detections) {
    let images = (0..case["n_images"].as_i64().unwrap()).map(|id| LabeledImage {
        id,
        name: id.to_string(),
        width_px: None,
        height_px: None,
        cluster: None,
    });
    let categories = (0..case["n_classes"].as_i64().unwrap()).map(|id| Category {
        id,
        name: id.to_string(),
        supercategory: None,
    });
    let objects = case["objects"].as_array().unwrap().iter().zip(1..);
    let labels = LabelSet {
        images: images.collect(),
        categories: categories.collect(),
        objects: objects
            .map(|(it, id)| Object {
                id,
                image: place(&it[0]),
                category: place(&it[1]),
                box_px: box_px(&it[2]),
                area_px2: box_px(&it[2]).area_px2(),
                kind: if it[3].as_bool().unwrap() {
                    ObjectKind::Crowd
                } else {
                    ObjectKind::Regular
                },
            })
            .collect(),
    };
    let items = case["detections"].as_array().unwrap().iter();
    let detections = Detections {
        items: items
            .map(|it| Detection {
                image: place(&it[0]),
                category: place(&it[1]),
                box_px: box_px(&it[2]),
                score: it[3].as_f64().unwrap(),
            })
            .collect(),
    };
    (labels, detections)
}

#[test]
fn tide_is_that_of_tidecv() {
    for (k, case) in answers("tide").iter().enumerate() {
        let (labels, detections) = tide_input(case);
        let tide = tide(&labels, &detections, TideSettings::default()).unwrap();
        let what = format!("case {k}");
        let same = |found: Option<f64>, expected: &Value, name: &str| {
            let (found, expected) = (found.unwrap(), expected.as_f64().unwrap());
            assert!(
                (found - expected).abs() < 1e-9,
                "{name} of {what}: {found} instead of {expected}"
            );
        };
        same(tide.ap, &case["ap"], "AP");
        for error in &tide.errors {
            let name = serde_json::to_value(error.kind).unwrap();
            let name = name.as_str().unwrap();
            assert_eq!(Some(error.n), case["n"][name].as_u64(), "{name} of {what}");
            same(error.d_ap, &case["d_ap"][name], name);
        }
        let special = &case["special"];
        same(tide.false_positive_d_ap, &special["FalsePos"], "FalsePos");
        same(tide.false_negative_d_ap, &special["FalseNeg"], "FalseNeg");
    }
}

#[test]
fn survival_is_that_of_lifelines() {
    for case in answers("survival") {
        let is_lost: Vec<bool> = case["failed"]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| it.as_bool().unwrap())
            .collect();
        let curve = kaplan_meier(&f64s(&case["times"]), &is_lost, 0.95).unwrap();
        let rows = case["rows"].as_array().unwrap();
        assert_eq!(curve.steps.len(), rows.len(), "times of a loss");
        for (step, row) in curve.steps.iter().zip(rows) {
            let expected = |name: &str| row[name].as_f64().unwrap();
            assert_close(step.time_s, expected("time"), 1e-12, "time");
            assert_eq!(Some(step.n_at_risk), row["at_risk"].as_u64(), "at risk");
            let share = step.share.value.unwrap();
            assert!((share - expected("survival")).abs() < 1e-12, "share");
            match step.share.interval {
                Some(interval) => {
                    assert_close(interval.low, expected("low"), 1e-9, "lower end");
                    assert_close(interval.high, expected("high"), 1e-9, "upper end");
                }
                None => assert!(share < 1e-12, "only the end has no interval: {share}"),
            }
        }
        assert_eq!(curve.median_s.value, case["median"].as_f64(), "median");
        let ends = ["median_low", "median_high"].map(|end| case[end].as_f64());
        assert_eq!(curve.median_ends_s, ends, "ends of its interval");
    }
    let why = |times: &[f64], is_lost: &[bool]| {
        let curve = kaplan_meier(times, is_lost, 0.95).unwrap();
        curve
            .median_s
            .reason
            .as_deref()
            .unwrap_or_default()
            .to_owned()
    };
    assert_eq!(why(&[], &[]), "no object is at risk", "of nothing");
    let followed = why(&[1.0, 0.5, 0.5], &[true, false, false]);
    assert_eq!(followed, "", "censored early: the median is reached");
    let kept = why(&[0.5, 1.0, 1.0], &[true, false, false]);
    assert!(kept.contains("as long as objects are followed"), "{kept}");
    assert!(kaplan_meier(&[1.0], &[], 0.95).is_err(), "a time too many");
    assert!(kaplan_meier(&[f64::NAN], &[true], 0.95).is_err(), "no time");
}

/// ±z √V of each step's interval, back from its ends on the log-log scale.
fn spreads(curve: &Survival) -> Vec<f64> {
    let spread = |step: &starbreak_eval::timeline::SurvivalStep| {
        let interval = step.share.interval?;
        let scaled = |end: f64| (-end.ln()).ln();
        let half = (scaled(interval.low) - scaled(interval.high)) / 2.0;
        Some(half * -step.share.value?.ln())
    };
    curve.steps.iter().filter_map(spread).collect()
}

/// Times of objects in clips, of which each has a pace of its own; a third is followed for a while only.
fn clips(n_clips: u32, n_objects: u32) -> (Vec<f64>, Vec<bool>, Vec<u32>) {
    let mut state = 9_u64;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let (mut times, mut is_lost, mut clusters) = (Vec::new(), Vec::new(), Vec::new());
    for clip in 0..n_clips {
        let pace = 0.3 + 2.0 * uniform();
        for _ in 0..n_objects {
            let after = -pace * (1.0 - uniform()).ln();
            let until = 3.0 * uniform();
            // To tenths: objects are lost together.
            times.push((after.min(until) * 10.0).ceil() / 10.0);
            is_lost.push(after <= until);
            clusters.push(clip);
        }
    }
    (times, is_lost, clusters)
}

#[test]
fn with_each_object_a_cluster_the_variance_is_greenwoods() {
    let (times, is_lost, _) = clips(8, 5);
    let n = u32::try_from(times.len()).unwrap();
    let each: Vec<u32> = (0..n).collect();
    let own = kaplan_meier_of_clusters(&times, &is_lost, &each, 0.95).unwrap();
    let greenwood = kaplan_meier(&times, &is_lost, 0.95).unwrap();
    let factor = (f64::from(n) / f64::from(n - 1)).sqrt();
    let (own_spreads, expected) = (spreads(&own), spreads(&greenwood));
    assert!(expected.len() > 10, "many steps");
    assert_eq!(
        own_spreads.len(),
        expected.len(),
        "intervals at the same steps"
    );
    for (found, expected) in own_spreads.iter().zip(expected) {
        assert_close(*found, expected * factor, 1e-9, "but for n/(n - 1)");
    }
    for (a, b) in own.steps.iter().zip(&greenwood.steps) {
        assert_eq!(a.share.value, b.share.value, "the same curve");
        assert_eq!(
            [a.n_at_risk, a.n_lost],
            [b.n_at_risk, b.n_lost],
            "of the same objects"
        );
    }
}

#[test]
fn the_variance_between_clusters_is_that_of_drawing_them_anew() {
    let (n_clips, n_objects) = (60, 12);
    let (times, is_lost, clusters) = clips(n_clips, n_objects);
    let curve = kaplan_meier_of_clusters(&times, &is_lost, &clusters, 0.95).unwrap();
    let at = |curve: &Survival, time_s: f64| {
        let before = curve
            .steps
            .iter()
            .take_while(|step| step.time_s <= time_s + 1e-9);
        before.last().map_or(1.0, |step| step.share.value.unwrap())
    };
    let probes = [0.2, 0.5, 1.0, 1.5];
    let plan = Plan::of_images(n_clips).with(2000, 4, 0.95);
    let replicates = bootstrap(&plan, |weights| {
        let (mut drawn, mut lost) = (Vec::new(), Vec::new());
        for ((time, is_lost), clip) in times.iter().zip(&is_lost).zip(&clusters) {
            for _ in 0..weights[*clip as usize] {
                drawn.push(*time);
                lost.push(*is_lost);
            }
        }
        let curve = kaplan_meier(&drawn, &lost, 0.95).unwrap();
        probes
            .iter()
            .map(|time_s| Some(at(&curve, *time_s).ln()))
            .collect()
    })
    .unwrap();
    let greenwood = kaplan_meier(&times, &is_lost, 0.95).unwrap();
    let mut wider = 0;
    for (probe, values) in probes.iter().zip(&replicates.values) {
        let values: Vec<f64> = values.iter().copied().flatten().collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let expected = 1.959_964 * (squares / (values.len() - 1) as f64).sqrt();
        let place = curve
            .steps
            .iter()
            .rposition(|step| step.time_s <= probe + 1e-9)
            .unwrap();
        let found = spreads(&curve)[place];
        assert!(
            (found / expected - 1.0).abs() < 0.1,
            "{probe} s: {found}, drawn {expected}"
        );
        wider += u32::from(found > 1.1 * spreads(&greenwood)[place]);
    }
    assert!(
        wider >= 3,
        "clips of a pace of their own tell less than so many objects: {wider}"
    );
}

#[test]
fn clusters_that_make_no_sense_are_refused_and_clusters_alike_have_no_interval() {
    let refused = |clusters: &[u32]| {
        kaplan_meier_of_clusters(&[1.0, 2.0], &[true, true], clusters, 0.95)
            .unwrap_err()
            .to_string()
    };
    assert!(
        refused(&[0]).contains("clusters"),
        "one too few: {}",
        refused(&[0])
    );
    assert!(
        refused(&[3, 3]).contains("2 or more"),
        "one alone: {}",
        refused(&[3, 3])
    );
    let times = [0.5, 1.0, 0.5, 1.0];
    let alike = kaplan_meier_of_clusters(&times, &[true, false, true, false], &[0, 0, 1, 1], 0.95);
    let first = alike.unwrap().steps[0].share.clone();
    assert_eq!(
        (first.value, first.interval),
        (Some(0.5), None),
        "no width is not known"
    );
}
