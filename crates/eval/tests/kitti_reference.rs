//! The protocol of KITTI against curves that the compiled development kit confirmed.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;

use std::path::Path;

use common::{assert_same, json, reference};
use serde_json::Value;
use starbreak_eval::{KittiDetections, KittiLabels, evaluate_kitti, rank_kitti};

fn read(folder: &Path) -> (KittiLabels, KittiDetections) {
    let labels = KittiLabels::read(&folder.join("label_2"), "").unwrap();
    let detections = KittiDetections::read(folder, &labels).unwrap();
    (labels, detections)
}

/// The numbers of a list, NaN for null.
fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

#[test]
fn every_curve_is_that_of_the_development_kit() {
    let folder = reference("kitti");
    let expected = json(&folder.join("ref.json"));
    let mut n_curves = 0;
    for (name, case) in expected.as_object().unwrap() {
        let (labels, detections) = read(&folder.join(name));
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

/// A frame that is drawn twice counts as two files do, and one that is not drawn as none.
#[test]
fn a_weighted_curve_is_that_of_repeated_files() {
    let folder = reference("kitti");
    let mut n_reached = 0;
    for name in (0..24).map(|k| format!("case_{k:02}")) {
        let name = name.as_str();
        let (labels, detections) = read(&folder.join(name));
        let rankings = rank_kitti(&labels, &detections, None).unwrap();
        let weights: Vec<u32> = (0..)
            .map(|k| (k * 7 + 3) % 4)
            .take(detections.images.len())
            .collect();
        let repeated = tempfile::tempdir().unwrap();
        let mut n = 0;
        for (image, weight) in detections.images.iter().zip(&weights) {
            let file = &labels.set.images[*image as usize].name;
            let stem = Path::new(file).file_stem().unwrap().to_str().unwrap();
            for _ in 0..*weight {
                for kind in ["label_2", "data"] {
                    let to = repeated.path().join(kind);
                    std::fs::create_dir_all(&to).unwrap();
                    let from = folder.join(name).join(kind).join(format!("{stem}.txt"));
                    std::fs::copy(from, to.join(format!("{n:06}.txt"))).unwrap();
                }
                n += 1;
            }
        }
        let (labels, detections) = read(repeated.path());
        let whole = evaluate_kitti(&labels, &detections, None).unwrap();
        for (ranking, whole) in rankings.iter().zip(&whole) {
            let weighted = ranking.curve(&weights);
            let what = format!("{name}, {:?}, {:?}", whole.class, whole.difficulty);
            n_reached += whole.counts.len();
            assert_eq!(weighted.counts, whole.counts, "{what}");
            assert_same(&weighted.thresholds, &whole.thresholds, &what);
            assert_same(&weighted.precision, &whole.precision, &what);
            assert_eq!(weighted.n_gt, whole.n_gt, "{what}");
            assert_eq!(weighted.n_images, whole.n_images, "{what}");
        }
    }
    assert!(n_reached > 100, "recalls are reached: {n_reached}");
}
