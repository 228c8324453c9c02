//! Files of labels and detections that make no sense: an error with the record each, never a
//! number.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};

use starbreak_eval::{Detections, EvalError, GroundTruth, KittiLabels, LabelSet, Protocol};

const LABELS: &str = r#"{"images": [{"id": 3, "file_name": "c.jpg"}, {"id": 0, "file_name": "a.jpg"}],
 "categories": [{"id": 7, "name": "x"}], "annotations": [
 {"id": 0, "image_id": 3, "category_id": 7, "bbox": [-5, 1.5, 0, 4], "area": 0, "iscrowd": 0, "segmentation": [[1,2]]},
 {"id": 9, "image_id": 0, "category_id": 7, "bbox": [1, 1, 3, 4], "area": 11.5, "iscrowd": 1}]}"#;

fn put(dir: &Path, name: &str, text: &str) -> PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn said(text: &str) -> Result<Detections, EvalError> {
    let dir = tempfile::tempdir().unwrap();
    let labels = LabelSet::read_coco(&put(dir.path(), "gt.json", LABELS)).unwrap();
    let path = put(dir.path(), "dt.json", text);
    Detections::read_coco(&path, &labels).map(|read| read.detections)
}

#[test]
fn labels_that_pycocotools_takes_are_taken() {
    let dir = tempfile::tempdir().unwrap();
    let labels = LabelSet::read_coco(&put(dir.path(), "gt.json", LABELS)).unwrap();
    let ids: Vec<i64> = labels.images.iter().map(|image| image.id).collect();
    assert_eq!(ids, [0, 3], "images in the order of their numbers");
    assert_eq!(labels.objects[0].image, 1, "the object of image 3");
    assert!(labels.objects[0].box_px.x < 0.0, "begins before the frame");
    assert!(
        (labels.objects[1].area_px2 - 11.5).abs() < 1e-15,
        "area of the outline"
    );
}

#[test]
fn labels_that_make_no_sense_are_refused_with_their_record() {
    for (from, to, expected) in [
        (
            r#""id": 9"#,
            r#""id": 0"#,
            "annotation 0: the id occurs twice",
        ),
        (
            r#""id": 3, "file"#,
            r#""id": 0, "file"#,
            "image 0: the id occurs twice",
        ),
        (r#""id": 9"#, r#""id": "9""#, "annotations[1]"),
        (
            r#""bbox": [1, 1, 3, 4]"#,
            r#""bbox": [1, 1, -3, 4]"#,
            "annotation 9: the bbox [1.0, 1.0, -3.0, 4.0] px has a negative side",
        ),
        (
            r#""bbox": [1, 1, 3, 4]"#,
            r#""bbox": [1, NaN, 3, 4]"#,
            "NaN and Infinity are no numbers of JSON",
        ),
        (
            r#""bbox": [1, 1, 3, 4]"#,
            r#""bbox": [1, 1e999, 3, 4]"#,
            "out of range",
        ),
        (
            r#""bbox": [1, 1, 3, 4]"#,
            r#""bbox": [1, 3, 4]"#,
            "annotations[1]",
        ),
        (
            r#""bbox": [1, 1, 3, 4]"#,
            r#""bbox": null"#,
            "annotations[1]",
        ),
        (r#", "area": 11.5"#, "", "it has no area"),
        (
            r#""image_id": 0"#,
            r#""image_id": 1"#,
            "its image 1 is not in the file",
        ),
        (
            r#""image_id": 0, "category_id": 7"#,
            r#""image_id": 0, "category_id": 8"#,
            "its category 8 is not in the file",
        ),
        (r#""iscrowd": 1"#, r#""iscrowd": 2"#, "2 is neither 0 nor 1"),
        (
            r#""categories""#,
            r#""kinds""#,
            "it has no list \"categories\"",
        ),
    ] {
        assert!(LABELS.contains(from), "{from}");
        let dir = tempfile::tempdir().unwrap();
        let path = put(dir.path(), "gt.json", &LABELS.replacen(from, to, 1));
        let error = LabelSet::read_coco(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
        assert!(!error.contains('\n'), "one line: {error}");
    }
}

#[test]
fn detections_that_make_no_sense_are_refused_with_place_and_byte() {
    let good = r#"{"image_id": 3, "category_id": 7, "bbox": [1, 2, 3, 4], "score": 0.5}"#;
    assert_eq!(
        said(&format!("[{good}]")).unwrap().items.len(),
        1,
        "this is taken"
    );
    for (from, to, expected) in [
        (
            "[1, 2, 3, 4]",
            "[1, 2, NaN, 4]",
            "[1], byte 121: NaN and Infinity",
        ),
        ("[1, 2, 3, 4]", "[1, 2, -Infinity, 4]", "[1], byte"),
        ("[1, 2, 3, 4]", "[1, 2, 1e400, 4]", "out of range"),
        (
            "[1, 2, 3, 4]",
            "[1, 2, 3, -4]",
            "[1]: the bbox [1.0, 2.0, 3.0, -4.0] px has a negative side",
        ),
        // Its area would be infinite, and overlaps no number.
        (
            "[1, 2, 3, 4]",
            "[1, 2, 1e300, 4]",
            "[1]: the bbox [1.0, 2.0, 1e300, 4.0] px has a negative side, or reaches beyond 1e9 px",
        ),
        ("[1, 2, 3, 4]", "[1, 2, 3]", "[1], byte"),
        ("[1, 2, 3, 4]", "[1, 2, 3, 4, 5]", "[1], byte"),
        (
            r#""image_id": 3"#,
            r#""image_id": "3""#,
            "expected a whole number as id",
        ),
        (
            r#""image_id": 3"#,
            r#""image_id": 3.5"#,
            "the id 3.5 is not a whole number",
        ),
        (r#""image_id": 3, "#, "", "missing field `image_id`"),
        (r#", "score": 0.5"#, "", "missing field `score`"),
        ("0.5", "Infinity", "NaN and Infinity"),
        ("0.5", "\"0.5\"", "invalid type: string"),
        ("0.5", "null", "invalid type: null"),
    ] {
        assert!(good.contains(from), "{from}");
        let text = format!("[{good},\n{}]", good.replacen(from, to, 1));
        let error = said(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
        assert!(!error.contains('\n'), "one line: {error}");
    }
}

#[test]
fn detections_of_other_images_are_counted_and_refused() {
    let row = |image: i64| {
        format!(r#"{{"image_id": {image}, "category_id": 7, "bbox": [1, 2, 3, 4], "score": 0.5}}"#)
    };
    let text = format!("[{},{},{}]", row(3), row(77), row(78));
    let error = said(&text).unwrap_err().to_string();
    assert!(
        error.contains("2 of 3 detections") && error.contains("image 77"),
        "{error}"
    );
}

#[test]
fn files_that_are_something_else_say_so() {
    for (text, expected) in [
        ("", "no content"),
        ("{}", "it is an object"),
        ("\"x\"", "expected a list or an object"),
        (
            "[{\"image_id\": 3, \"cat",
            "byte 21 on: the file ends inside a record",
        ),
        ("not json", "byte 0 on"),
    ] {
        let error = said(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text:?}: {error}");
    }
    // Deep nesting costs neither stack nor memory.
    let deep = "[".repeat(20_000_000);
    let error = said(&deep).unwrap_err().to_string();
    assert!(error.contains("more than 127 levels"), "{error}");
    let dir = tempfile::tempdir().unwrap();
    let path = put(dir.path(), "gt.json", "[]");
    let error = LabelSet::read_coco(&path).unwrap_err().to_string();
    assert!(
        error.contains("as results are"),
        "labels and results swapped: {error}"
    );
}

#[test]
fn kitti_files_that_make_no_sense_are_refused_with_their_line() {
    let good = "Car 0 0 0 1 2 30 40 1 1 1 1 1 1 0";
    for (line, expected) in [
        ("Car 0 0 0 1 2 30", "line 2: 7 fields; expected 15"),
        (
            "Car 0 0 0 1 nan 30 40 1 1 1 1 1 1 0",
            "field 6 = \"nan\" is not a finite number",
        ),
        (
            "Car 0 0 0 1 2 30 1e300 1 1 1 1 1 1 0",
            "field 8 = \"1e300\" is not a finite number within 1e9 of 0",
        ),
        (
            "Car 0 0 0 100 2 30 40 1 1 1 1 1 1 0",
            "ends before it begins",
        ),
    ] {
        let dir = tempfile::tempdir().unwrap();
        put(dir.path(), "000000.txt", &format!("{good}\n{line}\n"));
        let error = KittiLabels::read(dir.path(), "").unwrap_err().to_string();
        assert!(error.contains(expected), "{line}: {error}");
    }
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "000000.txt", good);
    let truth = GroundTruth::of_path(dir.path(), Protocol::Kitti).unwrap();
    let results = tempfile::tempdir().unwrap();
    put(results.path(), "000001.txt", &format!("{good} 0.5"));
    let error = truth
        .read_detections(results.path())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("1 of 1 detections") && error.contains("000001"),
        "{error}"
    );
}

/// What is written is read again, to the last bit.
#[test]
fn detections_come_back_from_each_form() {
    let dir = tempfile::tempdir().unwrap();
    let labels = LabelSet::read_coco(&put(dir.path(), "gt.json", LABELS)).unwrap();
    let text = r#"[{"image_id": 0, "category_id": 7, "bbox": [0.1, 1e-7, 3.3333333333333335, 4], "score": 0.30000000000000004},
        {"image_id": 3, "category_id": 7, "bbox": [1, 2, 3, 4], "score": 1}]"#;
    let first = said(text).unwrap();
    let path = put(dir.path(), "again.json", &first.to_coco(&labels));
    assert_eq!(
        Detections::read_coco(&path, &labels).unwrap().detections,
        first,
        "results of MS-COCO"
    );
    let path = put(dir.path(), "frames.json", &first.to_scalabel(&labels));
    let frames = Detections::read_scalabel(&path, &labels)
        .unwrap()
        .detections;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    for (a, b) in frames.items.iter().zip(&first.items) {
        assert!(
            near(a.box_px.width, b.box_px.width) && near(a.score, b.score),
            "{a:?} {b:?}"
        );
    }
    assert_eq!(frames.items.len(), 2, "frames of Scalabel");
    let files = first.to_kitti(&labels);
    assert_eq!(files.len(), 2, "a file per image");
    assert!(files[0].1.starts_with("x -1 -1 -10 0.1 "), "{files:?}");
}
