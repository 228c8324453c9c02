//! Labels and detections that are small files and large work: an early refusal, or little time.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use starbreak_eval::timeline::ClipTrack;
use starbreak_eval::{
    AreaRange, Category, CocoParams, Detections, GroundTruth, KittiLabels, LabelSet, Protocol,
    TrackedLabels, evaluate_coco,
};

fn put(dir: &Path, name: &str, text: &str) -> PathBuf {
    let path = dir.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, text).unwrap();
    path
}

/// Labels of so many objects in one image, each of the next category.
fn coco(n_objects: usize, n_categories: usize) -> String {
    let mut text = r#"{"images": [{"id": 1, "file_name": "a.jpg"}], "annotations": ["#.to_owned();
    for k in 1..=n_objects {
        let (category, comma) = (k % n_categories, if k == 1 { "" } else { "," });
        write!(
            text,
            r#"{comma}{{"id": {k}, "image_id": 1, "category_id": {category}, "bbox": [1, 1, 3, 4], "area": 12, "iscrowd": 0}}"#
        )
        .unwrap();
    }
    text.push_str(r#"], "categories": ["#);
    for k in 0..n_categories {
        let comma = if k == 0 { "" } else { "," };
        write!(text, r#"{comma}{{"id": {k}, "name": "c{k}"}}"#).unwrap();
    }
    text + "]}"
}

#[test]
fn more_categories_or_objects_than_can_be_evaluated_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let refusal = |n_objects, n_categories| {
        let path = put(dir.path(), "gt.json", &coco(n_objects, n_categories));
        LabelSet::read_coco(&path).map_err(|error| error.to_string())
    };
    assert!(refusal(10_000, 3000).is_ok(), "as much as there may be");
    let categories = refusal(1, 3001).unwrap_err();
    assert!(
        categories.contains("more than 3000 categories"),
        "{categories}"
    );
    let objects = refusal(10_001, 1).unwrap_err();
    assert!(
        objects.contains("more than 10000 objects in the image \"a.jpg\""),
        "{objects}"
    );
    let mut rows = String::new();
    for k in 0..3001 {
        writeln!(rows, "Kind{k} 0 0 0 1 1 9 9 1 1 1 1 1 1 0").unwrap();
    }
    put(dir.path(), "label_2/000000.txt", &rows);
    let types = KittiLabels::read(&dir.path().join("label_2"), "").unwrap_err();
    let types = types.to_string();
    assert!(types.contains("more than 3000 categories"), "{types}");
}

#[test]
fn more_detections_in_an_image_than_can_be_compared_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let labels = LabelSet::read_coco(&put(dir.path(), "gt.json", &coco(1, 1))).unwrap();
    let truth = GroundTruth {
        protocol: Protocol::Coco,
        labels,
        kitti: None,
        root: None,
    };
    let one = r#"{"image_id": 1, "category_id": 0, "bbox": [1, 1, 3, 4], "score": 0.5}"#;
    for n in [10_000, 10_001] {
        let text = format!("[{}]", vec![one; n].join(","));
        let read = truth.read_detections(&put(dir.path(), "dt.json", &text));
        match read {
            Ok(said) => assert_eq!(said.detections.items.len(), 10_000, "all that may be"),
            Err(error) => {
                let error = error.to_string();
                let expected = "more than 10000 detections in the image \"a.jpg\"";
                assert!(n == 10_001 && error.contains(expected), "{n}: {error}");
            }
        }
    }
}

#[test]
fn rules_that_ask_for_gigabytes_of_curves_are_refused() {
    let labels = LabelSet {
        categories: (0..80)
            .map(|id| Category {
                id,
                name: id.to_string(),
                supercategory: None,
            })
            .collect(),
        ..LabelSet::default()
    };
    let usual = CocoParams::default();
    let shares = |n: u32| (1..=n).map(|k| f64::from(k) / f64::from(n)).collect();
    let areas = |n: u32| {
        (1..=n)
            .map(|k| AreaRange::new(&k.to_string(), [0.0, f64::from(k)]))
            .collect()
    };
    for (params, is_good) in [
        (
            CocoParams {
                max_detections: (1..=100).collect(),
                ..usual.clone()
            },
            true,
        ),
        (
            CocoParams {
                max_detections: (1..=300).collect(),
                ..usual.clone()
            },
            false,
        ),
        (
            CocoParams {
                iou_thresholds: shares(1000),
                ..usual.clone()
            },
            false,
        ),
        (
            CocoParams {
                iou_thresholds: shares(1001),
                by_category: false,
                ..usual.clone()
            },
            false,
        ),
        (
            CocoParams {
                area_ranges: areas(500),
                ..usual.clone()
            },
            false,
        ),
        (usual, true),
    ] {
        match evaluate_coco(&labels, &Detections::default(), &params, None) {
            Ok(_) => assert!(is_good, "refused"),
            Err(error) => {
                let error = error.to_string();
                assert!(
                    !is_good && error.contains("curves; expected 400000 at most"),
                    "{error}"
                );
            }
        }
    }
}

#[test]
fn a_wrong_number_of_a_frame_does_not_fill_the_memory() {
    assert!(
        ClipTrack::plain(1_000_000, 30.0, None).is_ok(),
        "nine hours"
    );
    for rate in [1e-300, 0.0, -1.0, f64::INFINITY, f64::NAN] {
        let error = ClipTrack::plain(10, rate, None).unwrap_err();
        assert!(error.to_string().contains("from 1e-6 to 1e6"), "{error}");
    }
    let error = ClipTrack::plain(u64::MAX, 30.0, None).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("18446744073709551615 frames"), "{error}");

    // Frames without a line take nothing.
    let dir = tempfile::tempdir().unwrap();
    let row = |frame: u64| format!("{frame} 1 Car 0 0 0 1 1 9 9 1 1 1 1 1 1 0\n");
    for clip in 0..3 {
        let rows = row(0) + &row(999_999);
        put(dir.path(), &format!("label_02/000{clip}.txt"), &rows);
    }
    let read = TrackedLabels::read(&dir.path().join("label_02"), 0).unwrap();
    assert_eq!(read.truth.labels.images.len(), 6, "frames with a line");
    let track = ClipTrack::plain(1_000_000, 30.0, None).unwrap();
    let laid = read.of_clip(&read.clips[0], &track).unwrap();
    let names = [0, 1, 999_999].map(|place| laid.labels.images[place].name.as_str());
    assert_eq!(
        names,
        ["0000/000000.png", "0000/000001.png", "0000/999999.png"],
        "all frames of the clip are labeled"
    );
}

#[test]
fn areas_of_many_types_do_not_fill_the_memory() {
    let dir = tempfile::tempdir().unwrap();
    let mut rows = String::new();
    for k in 0..2500 {
        writeln!(rows, "0 {k} Kind{k} 0 0 0 1 1 9 9 1 1 1 1 1 1 0").unwrap();
    }
    for frame in 0..5000 {
        writeln!(
            rows,
            "{frame} -1 DontCare -1 -1 -10 1 1 9 9 -1 -1 -1 -1 -1 -1 -10"
        )
        .unwrap();
    }
    let path = put(dir.path(), "0000.txt", &rows);
    let error = TrackedLabels::read(&path, 0).unwrap_err().to_string();
    assert!(error.contains("more than 10000000 objects"), "{error}");
}

#[test]
fn a_mark_of_utf_8_is_no_part_of_a_type() {
    let dir = tempfile::tempdir().unwrap();
    let row = "Car 0.00 0 -1.67 1 1 9 9 1.41 1.58 4.36 3.18 2.27 34.38 -1.58\n";
    put(dir.path(), "label_2/000000.txt", &format!("\u{feff}{row}"));
    let read = KittiLabels::read(&dir.path().join("label_2"), "").unwrap();
    let names: Vec<&str> = read
        .set
        .categories
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert!(
        !names.iter().any(|name| name.contains('\u{feff}')),
        "{names:?}"
    );
    let category = read.set.objects[0].category as usize;
    assert_eq!(names[category], "Car", "{names:?}");

    let path = put(
        dir.path(),
        "0000.txt",
        "\u{feff}0 1 Car 0 0 0 1 1 9 9 1 1 1 1 1 1 0\n1 1 Car 0 0 0 1 1 9 9 1 1 1 1 1 1 0\n",
    );
    let read = TrackedLabels::read(&path, 0).unwrap();
    assert_eq!(read.tracks.len(), 2, "both frames");
}
