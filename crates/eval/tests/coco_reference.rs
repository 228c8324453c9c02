//! The protocol of MS-COCO against arrays that pycocotools 2.0.11 wrote.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;

use std::path::Path;

use common::{assert_same, json, npy, reference};
use serde_json::Value;
use starbreak_eval::{
    AreaRange, CocoParams, Detections, LabelSet, MatchRule, RankedMatches, Restriction,
    average_precision, evaluate_coco, match_images,
};

struct Case {
    labels: LabelSet,
    detections: Detections,
    params: CocoParams,
    /// The areas that stand in place of those of the detections.
    areas: Option<Vec<f64>>,
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|v| v.as_f64().unwrap()).collect()
}

fn case(folder: &Path) -> Case {
    let labels = LabelSet::read_coco(&folder.join("gt.json")).unwrap();
    let read = Detections::read_coco(&folder.join("dt.json"), &labels).unwrap();
    let given = json(&folder.join("params.json"));
    let mut params = CocoParams {
        by_category: given["useCats"] != 0,
        has_gt_id_zero_quirk: true,
        ..CocoParams::default()
    };
    if let Some(thresholds) = given.get("iouThrs") {
        params.iou_thresholds = numbers(thresholds);
    }
    if let Some(caps) = given.get("maxDets") {
        let caps = caps.as_array().unwrap().iter();
        params.max_detections = caps
            .map(|n| n.as_u64().unwrap().try_into().unwrap())
            .collect();
    }
    if let Some(ranges) = given.get("areaRng") {
        let names = given["areaRngLbl"].as_array().unwrap();
        let ranges = ranges.as_array().unwrap().iter().map(numbers);
        params.area_ranges = ranges
            .zip(names)
            .map(|(r, name)| AreaRange::new(name.as_str().unwrap(), [r[0], r[1]]))
            .collect();
    }
    Case {
        labels,
        detections: read.detections,
        params,
        areas: given.get("dt_area_override").map(numbers),
    }
}

/// The cases that are there; all of them must be.
fn cases() -> Vec<(String, Case)> {
    let folder = reference("coco");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(names.len() >= 14, "all cases are there: {names:?}");
    let read = |name: String| {
        let case = case(&folder.join(&name));
        (name, case)
    };
    names.into_iter().map(read).collect()
}

#[test]
fn every_array_is_that_of_pycocotools() {
    for (name, case) in cases() {
        let folder = reference("coco").join(&name).join("ref");
        let objects: Vec<f64> = case.labels.objects.iter().map(|o| o.area_px2).collect();
        let values = case.areas.as_ref().map(|areas| Restriction {
            objects: &objects,
            detections: areas,
            range: [0.0, 0.0],
        });
        let ours = evaluate_coco(
            &case.labels,
            &case.detections,
            &case.params,
            values.as_ref(),
        );
        let ours = ours.unwrap();
        for (what, numbers) in [
            ("precision", &ours.precision),
            ("recall", &ours.recall),
            ("scores", &ours.scores),
        ] {
            let theirs = npy(&folder.join(format!("{what}.npy")));
            assert_same(numbers, &theirs, &format!("{name}: {what}"));
        }
        let stats = json(&folder.join("stats.json"));
        let stats = numbers(&stats["stats"]);
        assert_same(&ours.stats().unwrap(), &stats, &format!("{name}: stats"));
    }
}

/// The object of number 0 is found like any other unless the quirk is asked for.
#[test]
fn number_zero_is_a_number_like_any_other() {
    let of_quirk = |(name, _): &(String, Case)| name == "gt_id_zero_quirk";
    let (_, mut case) = cases().into_iter().find(of_quirk).unwrap();
    let evaluate = |case: &Case| evaluate_coco(&case.labels, &case.detections, &case.params, None);
    let quirk = evaluate(&case).unwrap().stats().unwrap();
    case.params.has_gt_id_zero_quirk = false;
    let right = evaluate(&case).unwrap().stats().unwrap();
    let zero = case.labels.objects.iter_mut().find(|object| object.id == 0);
    zero.unwrap().id = 1_000_000;
    case.params.has_gt_id_zero_quirk = true;
    let renamed = evaluate(&case).unwrap().stats().unwrap();
    assert_same(&right, &renamed, "another number changes nothing");
    assert!(right[0] > quirk[0] + 0.01, "{} and {}", right[0], quirk[0]);
}

/// What the bootstrap counts is what the protocol counts.
#[test]
fn with_weights_of_one_the_matches_give_the_precision_of_the_protocol() {
    for (name, case) in cases() {
        if !case.params.by_category || name.starts_with("region") || name.starts_with("gt_id") {
            continue;
        }
        let folder = reference("coco").join(&name).join("ref");
        let theirs = npy(&folder.join("precision.npy"));
        let ours = evaluate_coco(&case.labels, &case.detections, &case.params, None).unwrap();
        let [n_t, n_r, n_k, n_a, n_m] = ours.shape();
        let weights = vec![1; case.labels.images.len()];
        for t in 0..n_t {
            let rule = MatchRule {
                iou_threshold: case.params.iou_thresholds[t],
                max_detections: case.params.max_detections[n_m - 1],
                region: None,
            };
            let matches = match_images(&case.labels, &case.detections, &rule).unwrap();
            for k in 0..n_k {
                let of_category = || matches.iter().filter(|m| m.category as usize == k);
                let curve = RankedMatches::of(of_category()).curve(&weights);
                let at = |r: usize| ((((t * n_r + r) * n_k + k) * n_a) * n_m) + n_m - 1;
                let expected: Vec<f64> = (0..n_r).map(|r| theirs[at(r)]).collect();
                let found = curve.map_or(vec![-1.0; n_r], |curve| curve.precision.to_vec());
                assert_same(
                    &found,
                    &expected,
                    &format!("{name}: threshold {t}, category {k}"),
                );
                let ap = average_precision(of_category(), &weights);
                let protocol = ours.average_precision(&[t], &[k], 0, n_m - 1);
                assert_eq!(ap, protocol, "{name}: threshold {t}, category {k}");
            }
        }
    }
}

/// A weight of two is the image twice.
#[test]
fn a_weight_is_a_number_of_copies() {
    let Some((_, case)) = cases().into_iter().find(|(name, _)| name == "rand_00") else {
        return;
    };
    let weights: Vec<u32> = (0..u32::try_from(case.labels.images.len()).unwrap())
        .map(|i| i * 7 % 4)
        .collect();
    // The images as often as their weights say, one after the other.
    let mut labels = LabelSet {
        categories: case.labels.categories.clone(),
        ..LabelSet::default()
    };
    let mut detections = Detections::default();
    for (image, weight) in weights.iter().enumerate() {
        for _ in 0..*weight {
            let copy = u32::try_from(labels.images.len()).unwrap();
            labels.images.push(case.labels.images[image].clone());
            let objects = case
                .labels
                .objects
                .iter()
                .filter(|o| o.image as usize == image);
            labels.objects.extend(objects.cloned().map(|mut object| {
                object.image = copy;
                object
            }));
            let said = case
                .detections
                .items
                .iter()
                .filter(|d| d.image as usize == image);
            detections
                .items
                .extend(said.map(|d| starbreak_eval::Detection { image: copy, ..*d }));
        }
    }
    let rule = MatchRule::default();
    let weighted = match_images(&case.labels, &case.detections, &rule).unwrap();
    let copied = match_images(&labels, &detections, &rule).unwrap();
    let ones = vec![1; labels.images.len()];
    for k in 0..2 {
        let of = |m: &&starbreak_eval::ImageMatches| m.category == k;
        let weighted = RankedMatches::of(weighted.iter().filter(of)).curve(&weights);
        let copied = RankedMatches::of(copied.iter().filter(of)).curve(&ones);
        assert_same(
            &weighted.unwrap().precision,
            &copied.unwrap().precision,
            "both curves",
        );
    }
}
