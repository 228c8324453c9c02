//! `starbreak evaluate` as a user types it.

use std::fs;
use std::path::Path;

use crate::program::{folder, starbreak};
use serde_json::{Value, json};

/// A set of 30 images with an object each, half of it in the region, and detections: all objects
/// found clean, those of every third image lost cracked.
fn write(root: &Path) {
    let images: Vec<Value> = (0..30)
        .map(|k| json!({ "id": k, "file_name": format!("{k}.png"), "width": 40, "height": 30 }))
        .collect();
    let object = |k: i32| json!({ "id": k + 1, "image_id": k, "category_id": 5, "bbox": [4, 4, 16, 12], "area": 100.0, "iscrowd": 0 });
    let said =
        |k: i32| json!({ "image_id": k, "category_id": 5, "bbox": [4, 4, 16, 12.5], "score": 0.9 });
    let truth = json!({
        "images": images,
        "annotations": (0..30).map(object).collect::<Vec<_>>(),
        "categories": [{ "id": 5, "name": "cat", "supercategory": "animal" }],
    });
    fs::write(root.join("gt.json"), truth.to_string()).unwrap();
    let clean: Vec<Value> = (0..30).map(said).collect();
    let cracked: Vec<Value> = (0..30).filter(|k| k % 3 != 0).map(said).collect();
    fs::write(root.join("a.json"), json!(clean).to_string()).unwrap();
    fs::write(root.join("b.json"), json!(cracked).to_string()).unwrap();
    fs::create_dir(root.join("masks")).unwrap();
    for k in 0..30 {
        write_mask(&root.join(format!("masks/{k}.png")), (40, 30));
    }
}

/// A mask whose left 12 columns are in the region.
fn write_mask(path: &Path, (width, height): (u32, u32)) {
    let mask = image::GrayImage::from_fn(width, height, |x, _| {
        image::Luma([if x < 12 { 255 } else { 0 }])
    });
    fs::write(path, starbreak_dataset::encode_mask(&mask).unwrap()).unwrap();
}

fn result(root: &Path, args: &[&str]) -> Value {
    let args: Vec<&str> = ["evaluate", "--json"].iter().chain(args).copied().collect();
    let outcome = starbreak(root, &args);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    serde_json::from_str(&outcome.stdout).unwrap()
}

const PAIR: [&str; 8] = [
    "--ground-truth",
    "gt.json",
    "--clean",
    "a.json",
    "--damaged",
    "b.json",
    "--regions",
    "masks",
];

#[test]
fn the_result_has_the_numbers_of_both_sides_and_of_the_region() {
    let dir = folder();
    write(dir.path());
    let said = result(dir.path(), &[&PAIR[..], &["-o", "report"]].concat());
    for side in ["clean", "cracked"] {
        let stats = said[side]["coco_stats"].as_array().unwrap();
        assert_eq!(stats.len(), 12, "{side}");
        assert!(
            stats.iter().all(Value::is_f64),
            "{side}: numbers: {stats:?}"
        );
    }
    assert_eq!(said["clean"]["coco_stats"][1], 1.0, "all found");
    // 20 of 30 found without an error: precision 1 up to recall 2/3, at 67 of 101 recalls.
    assert_eq!(
        said["cracked"]["coco_stats"][1],
        67.0 / 101.0,
        "a third lost"
    );
    assert_eq!(
        said["counts"]["n_images_with_region"], 30,
        "{}",
        said["counts"]
    );
    let row = said["paired"].as_array().unwrap().iter();
    let mut rows = row.filter(|row| row["scope"]["kind"] == "in_region" && row["metric"] == "ap50");
    let first = rows.next().unwrap();
    assert_eq!(
        first["n_objects"], 30,
        "half of each object is in the region: {first}"
    );
    assert_eq!(first["delta"]["value"], 67.0 / 101.0 - 1.0, "{first}");
    let file = fs::read_to_string(dir.path().join("report/evaluation.json")).unwrap();
    let file: Value = serde_json::from_str(&file).unwrap();
    let of_file = &file["evaluations"][0];
    let of_clean = &file["clean"][0];
    for (found, key) in [
        (&of_file["paired"], "paired"),
        (&of_file["failures"], "failures"),
        (&of_file["tide_cracked"], "tide_cracked"),
        (&of_clean["tide"], "tide_clean"),
        (&of_clean["label_audit"], "label_audit"),
    ] {
        assert!(found.is_object() || found.is_array(), "{key}: {found}");
        assert_eq!(found, &said[key], "{key}: the file has what is printed");
    }
}

/// Nothing but the sign depends on which side is called clean.
#[test]
fn swapping_clean_and_cracked_negates_every_difference() {
    let dir = folder();
    write(dir.path());
    let one = result(dir.path(), &PAIR);
    let mut swapped = PAIR;
    swapped.swap(3, 5);
    let other = result(dir.path(), &swapped);
    let (one, other) = (
        one["paired"].as_array().unwrap(),
        other["paired"].as_array().unwrap(),
    );
    assert_eq!(one.len(), other.len(), "as many rows");
    let mut n_numbers = 0;
    for (a, b) in one.iter().zip(other) {
        match (a["delta"]["value"].as_f64(), b["delta"]["value"].as_f64()) {
            (Some(a), Some(b)) => {
                assert!((a + b).abs() <= 0.0, "{a} and {b}");
                n_numbers += u32::from(a.abs() > 0.0);
            }
            (a, b) => assert_eq!(a, b, "both are refused"),
        }
        assert_eq!(a["n_objects"], b["n_objects"], "the same objects");
    }
    assert!(n_numbers >= 6, "differences that are none: {n_numbers}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let dir = folder();
    write(dir.path());
    let refused = |args: &[&str], named: &str| {
        let args: Vec<&str> = ["evaluate"].iter().chain(args).copied().collect();
        let outcome = starbreak(dir.path(), &args);
        let complaint = outcome.complaint(named);
        assert!(complaint.is_none(), "{args:?}: {complaint:?}");
    };
    refused(&["--clean", "a.json"], "SOURCE");
    let plain = ["--ground-truth", "gt.json", "--clean", "a.json"];
    refused(
        &[&plain[..], &["--tau", "0.5"]].concat(),
        "tau is about the region; give regions or a damaged set",
    );
    refused(
        &[&plain[..], &["--regions", "masks", "--class-agnostic"]].concat(),
        "class-agnostic matching: only for the numbers of whole images",
    );
    refused(
        &["coco:.", "--ground-truth", "gt.json", "--clean", "a.json"],
        "cannot be used with",
    );
    refused(
        &["--ground-truth", "gt.json", "--clean", "gt.json"],
        "missing field `image_id`",
    );
    refused(
        &[
            "--ground-truth",
            "gt.json",
            "--protocol",
            "kitti",
            "--clean",
            "a.json",
        ],
        "gt.json",
    );
    write_mask(&dir.path().join("masks/7.png"), (41, 30));
    refused(&PAIR, "41 x 30 px, but the image is 40 x 30 px");
    fs::remove_file(dir.path().join("masks/7.png")).unwrap();
    refused(&PAIR, "7.png");
}
