//! The protocol of KITTI against curves that the compiled development kit confirmed.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{assert_same, json, reference};
use serde_json::Value;
use starbreak_eval::{
    KittiDetections, KittiLabels, KittiMatchRule, Outcome, evaluate_kitti, match_kitti,
};

/// The numbers of a list, NaN for null.
fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

#[test]
fn every_curve_is_that_of_the_development_kit() {
    let Some(folder) = reference("kitti") else {
        return;
    };
    let expected = json(&folder.join("ref.json"));
    let mut n_curves = 0;
    for (name, case) in expected.as_object().unwrap() {
        let labels = KittiLabels::read(&folder.join(name).join("label_2"), "").unwrap();
        let detections = KittiDetections::read(&folder.join(name), &labels).unwrap();
        for curve in evaluate_kitti(&labels, &detections, None).unwrap() {
            let (class, difficulty) = (curve.class.name(), curve.difficulty.name());
            let theirs = &case[class][difficulty];
            let what = format!("{name}, {class}, {difficulty}");
            n_curves += 1;
            assert_eq!(curve.n_gt, theirs["n_gt"], "{what}: objects");
            let counts: Vec<Vec<u64>> = curve.counts.iter().map(|c| c.to_vec()).collect();
            assert_eq!(
                serde_json::json!(counts),
                theirs["counts"],
                "{what}: counts"
            );
            for (ours, key) in [
                (curve.thresholds.clone(), "thresholds"),
                (curve.recall(), "recall"),
                (curve.precision.to_vec(), "precision"),
                (vec![curve.ap11()], "ap11"),
                (vec![curve.ap40()], "ap40"),
            ] {
                let theirs = match &theirs[key] {
                    Value::Array(_) => numbers(&theirs[key]),
                    number => vec![number.as_f64().unwrap_or(f64::NAN)],
                };
                assert_same(&ours, &theirs, &format!("{what}: {key}"));
            }
        }
    }
    assert_eq!(n_curves, 24 * 9, "all cases, classes and difficulties");
}

/// The rules of what is ignored are the same in both ways of matching.
#[test]
fn what_is_to_be_found_is_the_same_in_the_matches_for_statistics() {
    let Some(folder) = reference("kitti") else {
        return;
    };
    let mut n_found = 0;
    for name in (0..24).map(|k| format!("case_{k:02}")) {
        let labels = KittiLabels::read(&folder.join(&name).join("label_2"), "").unwrap();
        let detections = KittiDetections::read(&folder.join(&name), &labels).unwrap();
        for curve in evaluate_kitti(&labels, &detections, None).unwrap() {
            let rule = KittiMatchRule {
                class: curve.class,
                difficulty: curve.difficulty,
                min_overlap: curve.class.min_overlap(),
                region: None,
            };
            let matches = match_kitti(&labels, &detections, &rule).unwrap();
            let objects = || matches.iter().flat_map(|m| &m.objects);
            let n_counted = objects().filter(|object| !object.is_ignored).count();
            assert_eq!(
                u64::try_from(n_counted).unwrap(),
                curve.n_gt,
                "{name}: {rule:?}"
            );
            for said in matches.iter().flat_map(|m| &m.detections) {
                if let Outcome::TruePositive { object, iou } = said.outcome {
                    let truth = &labels.set.objects[object as usize];
                    let found = &detections.set.items[said.detection as usize];
                    assert_eq!(truth.image, found.image, "in one frame");
                    assert_eq!(truth.category, found.category, "of one class");
                    assert!(iou > rule.min_overlap, "{iou}");
                    n_found += 1;
                }
            }
        }
    }
    assert!(n_found > 50, "objects are found: {n_found}");
}
