//! What fails, on scenes small enough to count by hand.
#![expect(
    clippy::unwrap_used,
    reason = "a test whose scene is refused has failed"
)]

use starbreak_eval::failure::{
    FalsePositiveAreas, Group, ObjectPair, Where, class_flips, dose_response, failure_rates,
    failure_table, fit_logistic, new_false_positives, pair_objects, quantile_edges, shifts,
};
use starbreak_eval::resampling::Plan;
use starbreak_eval::{
    BoxPx, Category, Detection, Detections, ImageMatches, LabelSet, LabeledImage, MatchedDetection,
    MatchedObject, Object, ObjectKind, Outcome,
};

fn at(x: f64) -> BoxPx {
    BoxPx::from_corners([x, 0.0, x + 10.0, 10.0])
}

fn labels(n_images: u32, objects: &[(u32, u32, f64)]) -> LabelSet {
    LabelSet {
        images: (0..n_images)
            .map(|k| LabeledImage {
                id: i64::from(k),
                name: k.to_string(),
                width_px: Some(1000),
                height_px: Some(1000),
                cluster: None,
            })
            .collect(),
        categories: ["car", "truck", "person"]
            .iter()
            .zip(1..)
            .map(|(name, id)| Category {
                id,
                name: (*name).to_owned(),
                supercategory: None,
            })
            .collect(),
        objects: objects
            .iter()
            .zip(1..)
            .map(|((image, category, x), id)| Object {
                id,
                image: *image,
                category: *category,
                box_px: at(*x),
                area_px2: 100.0,
                kind: ObjectKind::Regular,
            })
            .collect(),
    }
}

/// Detections and what became of them: image, category, x, score, object found.
type Line = (u32, u32, f64, f64, Option<u32>);

/// Matches of all lines, with all objects of the labels.
fn matched(labels: &LabelSet, lines: &[Line]) -> (Vec<ImageMatches>, Detections) {
    let detections = Detections {
        items: lines
            .iter()
            .map(|(image, category, x, score, _)| Detection {
                image: *image,
                category: *category,
                box_px: at(*x),
                score: *score,
            })
            .collect(),
    };
    let mut matches = Vec::new();
    for image in 0..u32::try_from(labels.images.len()).unwrap() {
        for category in 0..3 {
            let of_cell = (0_u32..).zip(lines);
            let of_cell = of_cell.filter(|(_, it)| (it.0, it.1) == (image, category));
            let mut found: Vec<MatchedDetection> = of_cell
                .map(|(detection, (_, _, _, score, object))| MatchedDetection {
                    detection,
                    score: *score,
                    outcome: match object {
                        Some(object) => Outcome::TruePositive {
                            object: *object,
                            iou: 0.5 + score / 10.0,
                        },
                        None => Outcome::FalsePositive,
                    },
                })
                .collect();
            found.sort_by(|a, b| b.score.total_cmp(&a.score));
            let objects = (0_u32..).zip(&labels.objects);
            let objects = objects.filter(|(_, it)| (it.image, it.category) == (image, category));
            matches.push(ImageMatches {
                image,
                category,
                detections: found,
                objects: objects
                    .map(|(object, _)| MatchedObject {
                        object,
                        is_ignored: false,
                        detection: None,
                    })
                    .collect(),
            });
        }
    }
    (matches, detections)
}

/// Cars 0-3 and person 4 in two images: 0 kept, 1 lost, 2 recovered, 3 found in neither (its score
/// is too low), 4 lost.
fn scene() -> (LabelSet, Vec<ObjectPair>) {
    let labels = labels(
        2,
        &[
            (0, 0, 0.0),
            (0, 0, 20.0),
            (1, 0, 0.0),
            (1, 0, 20.0),
            (1, 2, 40.0),
        ],
    );
    let (clean, _) = matched(
        &labels,
        &[
            (0, 0, 0.0, 0.9, Some(0)),
            (0, 0, 20.0, 0.8, Some(1)),
            (1, 0, 20.0, 0.29, Some(3)),
            (1, 2, 40.0, 0.3, Some(4)),
        ],
    );
    let (cracked, _) = matched(
        &labels,
        &[
            (0, 0, 0.0, 0.7, Some(0)),
            (0, 0, 20.0, 0.2, Some(1)),
            (1, 0, 0.0, 0.6, Some(2)),
        ],
    );
    let coverage = [0.5, 0.04, 0.05, 0.0, 1.0];
    let pairs = pair_objects(&clean, &cracked, &labels, &coverage, 0.3).unwrap();
    (labels, pairs)
}

fn everywhere() -> Group {
    Group {
        category: None,
        place: Where::Image,
    }
}

#[test]
fn outcomes_are_counted_per_object_from_the_threshold_on() {
    let (_, pairs) = scene();
    let rates = failure_rates(everywhere(), &pairs, &Plan::of_images(2)).unwrap();
    let counts = [
        rates.n_kept,
        rates.n_lost,
        rates.n_recovered,
        rates.n_missed,
    ];
    assert_eq!(counts, [1, 2, 1, 1], "kept, lost, recovered, missed");
    assert_eq!((rates.n_objects, rates.n_images), (5, 2), "in all");
    assert_eq!(
        rates.failure_rate.value,
        Some(2.0 / 3.0),
        "2 of 3 found clean"
    );
    assert_eq!(rates.failure_rate.n, 3, "n are those found clean");
    assert_eq!(rates.recovery_rate.value, Some(0.5), "1 of 2 missed clean");
    // One lost in image 0; one lost and one recovered in image 1, which is no difference.
    assert_eq!((rates.test.p, rates.test.n), (Some(1.0), 1), "1 against 0");
    let none = failure_rates(everywhere(), &[], &Plan::of_images(2)).unwrap();
    assert_eq!(none.failure_rate.value, None, "nothing of nothing");
    assert!(none.failure_rate.reason.is_some(), "and why");
}

#[test]
fn the_table_has_each_place_and_class_and_a_control() {
    let (_, pairs) = scene();
    let places = [
        Where::Image,
        Where::Region { tau: 0.05 },
        Where::Outside { tau: 0.05 },
        Where::Region { tau: 0.0 },
        Where::Coverage {
            low: 0.5,
            high: 1.0,
        },
    ];
    let plan = Plan::of_images(2).with(200, 1, 0.9);
    let table = failure_table(&pairs, &places, &plan).unwrap();
    let n = |category: Option<u32>, place: Where| {
        let group = Group { category, place };
        let row = table.iter().find(|row| row.group == group);
        row.map(|row| (row.n_objects, row.n_lost))
    };
    assert_eq!(n(None, places[0]), Some((5, 2)), "whole image");
    assert_eq!(n(None, places[1]), Some((3, 1)), "in the region");
    assert_eq!(n(None, places[2]), Some((2, 1)), "outside");
    assert_eq!(
        n(None, places[3]),
        Some((4, 2)),
        "touched: coverage 0 is not"
    );
    assert_eq!(n(None, places[4]), Some((2, 1)), "up to 1, end included");
    assert_eq!(n(Some(2), places[1]), Some((1, 1)), "person in the region");
    assert_eq!(n(Some(2), places[2]), None, "no person outside, no row");
    assert_eq!(n(Some(1), places[0]), None, "no trucks, no rows");
    let short = Plan::of_images(1);
    assert!(
        failure_table(&pairs, &places, &short).is_err(),
        "an image beyond the plan"
    );
}

#[test]
fn sets_that_do_not_belong_together_are_refused() {
    let two = labels(1, &[(0, 0, 0.0), (0, 0, 20.0)]);
    let one = labels(1, &[(0, 0, 0.0)]);
    let (clean, _) = matched(&two, &[]);
    let (cracked, _) = matched(&one, &[]);
    let message = pair_objects(&clean, &cracked, &two, &[0.0; 2], 0.3).unwrap_err();
    assert!(message.to_string().contains("(2 and 1)"), "{message}");
    assert!(
        pair_objects(&clean, &clean, &one, &[0.0], 0.3).is_err(),
        "an object that the labels do not have"
    );
    assert!(
        pair_objects(&clean, &clean, &two, &[0.0], 0.3).is_err(),
        "a coverage lacks"
    );
    assert!(
        pair_objects(&clean, &clean, &two, &[0.0; 2], f64::NAN).is_err(),
        "no threshold"
    );
}

#[test]
fn shifts_are_of_objects_found_in_both() {
    let (_, pairs) = scene();
    let shifts = shifts(everywhere(), &pairs, &Plan::of_images(2)).unwrap();
    assert_eq!(shifts.n_pairs, 1, "one is kept");
    let score = shifts.score.mean.value.unwrap();
    assert!((score + 0.2).abs() < 1e-12, "0.9 to 0.7: {score}");
    let iou = shifts.iou.mean.value.unwrap();
    assert!((iou + 0.02).abs() < 1e-12, "0.59 to 0.57: {iou}");
    assert_eq!(shifts.score.mean.interval, None, "one has no spread");
    assert_eq!(shifts.score.test.p, None, "one says nothing");
}

#[test]
fn a_phantom_is_new_where_nothing_was_seen() {
    let labels = labels(2, &[(0, 0, 0.0)]);
    let (clean, clean_detections) = matched(
        &labels,
        &[
            (0, 0, 0.0, 0.9, Some(0)),
            (0, 1, 500.0, 0.8, None),
            (1, 0, 300.0, 0.2, None),
        ],
    );
    let (cracked, cracked_detections) = matched(
        &labels,
        &[
            // Taken for a truck: seen before.
            (0, 1, 0.0, 0.9, None),
            // The false one of the clean image, a little moved.
            (0, 1, 501.0, 0.8, None),
            // Where the clean image has one below the threshold: new.
            (1, 0, 300.0, 0.6, None),
            // New, outside of the region.
            (1, 0, 700.0, 0.4, None),
            // Below the threshold.
            (1, 0, 800.0, 0.1, None),
        ],
    );
    let areas = FalsePositiveAreas {
        clean_coverage: &[0.0, 0.0, 0.0],
        cracked_coverage: &[0.5, 0.0, 0.3, 0.0, 0.9],
        region_px: &[2e5, 2e5],
        image_px: &[1e6, 1e6],
        tau: 0.05,
    };
    let plan = Plan::of_images(2).with(100, 0, 0.95);
    let found = new_false_positives(
        (&clean, &clean_detections),
        (&cracked, &cracked_detections),
        areas,
        0.3,
        &plan,
    )
    .unwrap();
    let counts: Vec<_> = found
        .iter()
        .map(|it| (it.n_clean, it.n_cracked, it.n_new))
        .collect();
    assert_eq!(
        counts,
        [(1, 4, 2), (0, 2, 1), (1, 2, 1)],
        "image, region, outside"
    );
    let per_mpx = found[1].new_per_mpx.value.unwrap();
    assert!((per_mpx - 2.5).abs() < 1e-12, "1 in 0.4 Mpx: {per_mpx}");
    assert_eq!(found[0].new_per_image.value, Some(1.0), "2 in 2 images");
    assert_eq!(found[0].more_per_image.value, Some(1.5), "4 less 1 in 2");
    let short = FalsePositiveAreas {
        region_px: &[1.0],
        ..areas
    };
    let refused = new_false_positives(
        (&clean, &clean_detections),
        (&cracked, &cracked_detections),
        short,
        0.3,
        &plan,
    );
    assert!(refused.is_err(), "an area lacks");
}

#[test]
fn a_flip_is_a_lost_object_under_a_wrong_class() {
    let labels = labels(1, &[(0, 0, 0.0), (0, 0, 20.0), (0, 0, 40.0), (0, 1, 41.0)]);
    let (clean, _) = matched(
        &labels,
        &[
            (0, 0, 0.0, 0.9, Some(0)),
            (0, 0, 20.0, 0.9, Some(1)),
            (0, 0, 40.0, 0.9, Some(2)),
            (0, 1, 41.0, 0.9, Some(3)),
        ],
    );
    let (cracked, detections) = matched(
        &labels,
        &[
            (0, 1, 0.0, 0.9, None),
            (0, 2, 0.5, 0.8, None),
            // Kept, and a truck on top: no flip.
            (0, 0, 20.0, 0.9, Some(1)),
            (0, 1, 20.0, 0.8, None),
            // Object 2 is lost; the truck there rightly finds its neighbor.
            (0, 1, 41.0, 0.8, Some(3)),
        ],
    );
    let pairs = pair_objects(&clean, &cracked, &labels, &[0.0; 4], 0.3).unwrap();
    let flips = class_flips(
        &pairs,
        &cracked,
        &detections,
        &labels,
        0.3,
        0.5,
        &Plan::of_images(1),
    )
    .unwrap();
    assert_eq!(
        (flips.n_found_clean, flips.n_flipped),
        (4, 1),
        "one of four"
    );
    let row = &flips.table[0];
    assert_eq!(
        (row.category, row.taken_for, row.n),
        (0, 1, 1),
        "car for truck"
    );
    assert_eq!(flips.flip_rate.value, Some(0.25), "one of four");
}

#[test]
fn a_dose_is_binned_and_fitted_over_what_was_found_clean() {
    let (_, pairs) = scene();
    let doses = [1.0, 2.0, 9.0, 9.0, f64::NAN];
    let plan = Plan::of_images(2);
    let with_dose = pairs.iter().zip(doses);
    let response = dose_response("displacement_px", with_dose, &[0.0, 1.5, 2.0], &plan).unwrap();
    assert_eq!(response.n_without_dose, 1, "object 4");
    let bins: Vec<_> = response.bins.iter().map(|it| (it.n, it.n_lost)).collect();
    assert_eq!(bins, [(1, 0), (1, 1)], "the last bin holds its end");
    assert_eq!(response.fit.n, 2, "objects 0 and 1");
    let reason = response.fit.reason.unwrap();
    assert!(reason.contains("separates"), "{reason}");
    assert_eq!(response.fit.auc.value, Some(1.0), "but the ranks are clear");
    let unsorted = dose_response("x", pairs.iter().zip(doses), &[1.0, 1.0], &plan);
    assert!(unsorted.is_err(), "edges that do not rise");
}

#[test]
fn a_curve_that_does_not_exist_is_not_given() {
    let why = |dose: &[f64], failed: &[bool]| {
        let clusters: Vec<u32> = (0..u32::try_from(dose.len()).unwrap()).collect();
        let fit = fit_logistic(dose, failed, &clusters, 0.95);
        assert_eq!(fit.slope.estimate.value, None, "no slope of {dose:?}");
        assert_eq!(fit.probability(0.5), None, "and no curve");
        fit.reason.unwrap()
    };
    let (no, yes) = (false, true);
    assert!(why(&[], &[]).contains("no objects"), "nothing");
    assert!(
        why(&[1.0, 2.0], &[no, no]).contains("no object failed"),
        "none"
    );
    assert!(
        why(&[1.0, 2.0], &[yes, yes]).contains("all objects failed"),
        "all"
    );
    assert!(
        why(&[1.0, 1.0], &[no, yes]).contains("all doses"),
        "one dose"
    );
    let apart = [1.0, 2.0, 3.0, 4.0];
    assert!(
        why(&apart, &[no, no, yes, yes]).contains("separates"),
        "rising"
    );
    assert!(
        why(&apart, &[yes, no, no, no]).contains("separates"),
        "falling"
    );
    let touching = [1.0, 2.0, 2.0, 3.0];
    assert!(
        why(&touching, &[no, no, yes, yes]).contains("separates"),
        "one shared dose is not enough"
    );
    let crossing = fit_logistic(&apart, &[no, yes, no, yes], &[0, 1, 2, 3], 0.95);
    assert!(crossing.slope.estimate.value.is_some(), "{crossing:?}");
}

#[test]
fn edges_by_quantiles_rise() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    assert_eq!(
        quantile_edges(&values, 4),
        [0.0, 24.75, 49.5, 74.25, 99.0],
        "quarters"
    );
    assert_eq!(
        quantile_edges(&[0.0, 0.0, 0.0, 1.0], 3),
        [0.0, 1.0],
        "ties join"
    );
    assert!(quantile_edges(&[2.0, 2.0], 3).is_empty(), "nothing to cut");
    assert!(quantile_edges(&[], 3).is_empty(), "nothing");
}
