//! The audit of classes on detections whose classes were made wrong.
#![expect(
    clippy::unwrap_used,
    reason = "a test whose scene is refused has failed"
)]

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use starbreak_eval::label_audit::{AuditSettings, ClassMap, LabelAudit, Verdict, label_audit};
use starbreak_eval::{
    BoxPx, Category, Detection, Detections, LabelSet, LabeledImage, Object, ObjectKind,
};

/// Numbers with gaps, as those of MS-COCO: 12, 26, 29, 30, 45 are missing.
const IDS: [i64; 20] = [
    1, 2, 3, 8, 10, 11, 13, 14, 24, 25, 27, 28, 31, 32, 43, 44, 46, 47, 89, 90,
];

fn labels(n_images: u32, n_per_image: u32) -> LabelSet {
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let mut objects = Vec::new();
    for image in 0..n_images {
        for k in 0..n_per_image {
            let x = f64::from(k) * 30.0;
            objects.push(Object {
                id: i64::from(image * n_per_image + k + 1),
                image,
                category: stream.next_u32() % 20,
                box_px: BoxPx::from_corners([x, 0.0, x + 20.0, 20.0]),
                area_px2: 400.0,
                kind: ObjectKind::Regular,
            });
        }
    }
    LabelSet {
        images: (0..n_images)
            .map(|k| LabeledImage {
                id: i64::from(k),
                name: k.to_string(),
                width_px: None,
                height_px: None,
                cluster: None,
            })
            .collect(),
        categories: IDS
            .iter()
            .map(|id| Category {
                id: *id,
                name: format!("class {id}"),
                supercategory: None,
            })
            .collect(),
        objects,
    }
}

/// A detector that errs in one of five classes; what it says is made wrong by `said`, which gives
/// nothing for what a reader would refuse.
fn detected(labels: &LabelSet, said: impl Fn(u32) -> Option<u32>) -> Detections {
    let mut stream = ChaCha8Rng::seed_from_u64(2);
    let mut items = Vec::new();
    for object in &labels.objects {
        let errs = stream.next_u32().is_multiple_of(5);
        let category = if errs {
            stream.next_u32() % 20
        } else {
            object.category
        };
        if let Some(category) = said(category) {
            items.push(Detection {
                image: object.image,
                category,
                box_px: object.box_px,
                score: 0.8,
            });
        }
    }
    Detections { items }
}

fn audit(said: impl Fn(u32) -> Option<u32>) -> LabelAudit {
    let labels = labels(60, 6);
    let detections = detected(&labels, said);
    label_audit(&labels, &detections, AuditSettings::default()).unwrap()
}

fn place_of_id(id: i64) -> Option<u32> {
    let place = IDS.iter().position(|it| *it == id)?;
    u32::try_from(place).ok()
}

fn id(place: u32) -> i64 {
    IDS[place as usize]
}

fn wrong_map(audit: &LabelAudit) -> &ClassMap {
    match &audit.verdict {
        Verdict::Wrong { map, advice } => {
            assert!(!advice.is_empty(), "what to do");
            map
        }
        other => panic!("{other:?} of {:?}", audit.maps),
    }
}

#[test]
fn classes_that_fit_pass() {
    let audit = audit(Some);
    assert_eq!(audit.verdict, Verdict::Fits, "{:?}", audit.maps.first());
    assert!(
        audit.agreement.value.is_some_and(|it| it > 0.75),
        "{:?}",
        audit.agreement
    );
}

#[test]
fn numbers_one_too_large_are_found_out_in_spite_of_gaps() {
    let audit = audit(|place| place_of_id(id(place) + 1));
    assert_eq!(*wrong_map(&audit), ClassMap::IdShift { by: 1 }, "+1");
}

#[test]
fn places_one_too_small_are_found_out() {
    let audit = audit(|place| place.checked_sub(1));
    assert_eq!(*wrong_map(&audit), ClassMap::PlaceShift { by: -1 }, "-1");
}

#[test]
fn places_used_as_numbers_are_found_out() {
    let audit = audit(|place| place_of_id(i64::from(place)));
    assert_eq!(
        *wrong_map(&audit),
        ClassMap::PlaceAsId { first: 0 },
        "from 0"
    );
}

#[track_caller]
fn assert_moved(said: impl Fn(u32) -> u32, expected: &[(u32, u32)]) {
    let audit = audit(|place| Some(said(place)));
    let ClassMap::Permutation { moves } = wrong_map(&audit) else {
        panic!("{:?}", audit.verdict);
    };
    let pairs: Vec<(u32, u32)> = moves.iter().map(|it| (it.detected, it.labeled)).collect();
    assert_eq!(pairs, expected, "what stands for what");
}

#[test]
fn five_classes_in_a_ring_are_found_out() {
    let said = |place| if place < 5 { (place + 1) % 5 } else { place };
    assert_moved(said, &[(0, 4), (1, 0), (2, 1), (3, 2), (4, 3)]);
}

#[test]
fn two_classes_in_each_others_place_are_found_out_though_most_pairs_agree() {
    let said = |place| if place < 2 { 1 - place } else { place };
    assert_moved(said, &[(0, 1), (1, 0)]);
}

#[test]
fn noise_is_not_taken_for_a_permutation() {
    let labels = labels(20, 6);
    let mut stream = ChaCha8Rng::seed_from_u64(3);
    let mut detections = detected(&labels, Some);
    for item in &mut detections.items {
        item.category = stream.next_u32() % 20;
    }
    let audit = label_audit(&labels, &detections, AuditSettings::default()).unwrap();
    assert!(
        matches!(audit.verdict, Verdict::Unexplained { .. }),
        "chance explains nothing: {:?}",
        audit.verdict
    );
}

#[test]
fn too_few_pairs_are_said_to_be_too_few() {
    let labels = labels(4, 6);
    let detections = detected(&labels, |place| place_of_id(id(place) + 1));
    let audit = label_audit(&labels, &detections, AuditSettings::default()).unwrap();
    assert_eq!(audit.verdict, Verdict::TooFew { needed: 30 }, "24 at most");
    let none = label_audit(&labels, &Detections::default(), AuditSettings::default()).unwrap();
    assert_eq!(none.agreement.value, None, "no pairs, no share");
    let settings = AuditSettings {
        iou: f64::NAN,
        ..AuditSettings::default()
    };
    assert!(label_audit(&labels, &detections, settings).is_err(), "NaN");
}
