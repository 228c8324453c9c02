//! The full form of the verb `evaluate` on the real binary: five files, all or none, and numbers that
//! follow by hand from a made-up set.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::repeated_keys;
use serde_json::{Value, json};

fn starbreak(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_starbreak"))
        .current_dir(folder)
        .args(args)
        .output()
        .unwrap()
}

/// 40 images of one class with one object each. The region is the left half of the first 30. Clean finds
/// all; cracked loses 12 of those in the region, and one outside.
fn write_set(folder: &Path) {
    let images: Vec<Value> = (1..=40)
        .map(|id| json!({"id": id, "file_name": format!("{id:03}.png"), "width": 40, "height": 20}))
        .collect();
    let objects: Vec<Value> = (1..=40)
        .map(|id| {
            json!({"id": id, "image_id": id, "category_id": 1, "bbox": [2.0, 2.0, 10.0, 10.0], "area": 100.0, "iscrowd": 0})
        })
        .collect();
    let labels = json!({
        "images": images,
        "annotations": objects,
        "categories": [{"id": 1, "name": "<b>car</b>", "supercategory": "vehicle"}],
    });
    let detection = |id: i32| json!({"image_id": id, "category_id": 1, "bbox": [2.0, 2.0, 10.0, 10.0], "score": 0.9 - f64::from(id) * 0.001});
    let clean: Vec<Value> = (1..=40).map(detection).collect();
    let cracked: Vec<Value> = (13..=39).map(detection).collect();
    fs::write(folder.join("labels.json"), labels.to_string()).unwrap();
    fs::write(folder.join("clean.json"), Value::from(clean).to_string()).unwrap();
    fs::write(
        folder.join("cracked.json"),
        Value::from(cracked).to_string(),
    )
    .unwrap();
    fs::create_dir(folder.join("regions")).unwrap();
    for id in 1..=40_u32 {
        let is_hit = |x: u32| id <= 30 && x < 20;
        let pixel = |x, _| image::Luma([if is_hit(x) { 255_u8 } else { 0 }]);
        let mask = image::GrayImage::from_fn(40, 20, pixel);
        let file = fs::File::create(folder.join(format!("regions/{id:03}.png"))).unwrap();
        let mut encoder = png::Encoder::new(file, 40, 20);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(mask.as_raw()).unwrap();
    }
}

const EVALUATE: [&str; 11] = [
    "evaluate",
    "--ground-truth",
    "labels.json",
    "--clean",
    "clean.json",
    "--cracked",
    "cracked.json",
    "--regions",
    "regions",
    "--replicates",
    "200",
];

fn run(folder: &Path, more: &[&str]) -> Output {
    starbreak(folder, &[&EVALUATE[..], more].concat())
}

#[test]
fn the_numbers_are_those_of_the_made_up_set() {
    let folder = tempfile::tempdir().unwrap();
    write_set(folder.path());
    let output = run(folder.path(), &["-o", "out", "--json"]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        printed["clean"]["coco_stats"].as_array().map(Vec::len),
        Some(12),
        "the contract"
    );
    let text = fs::read_to_string(folder.path().join("out/evaluation.json")).unwrap();
    let study: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(study["schema"], "starbreak.evaluation/2", "the schema");
    let evaluation = &study["evaluations"][0];
    let rates = evaluation["failures"]["rates"].as_array().unwrap();
    let rate = |kind: &str, tau: Option<f64>| {
        let is_it = |row: &&Value| {
            row["scope"]["kind"] == kind
                && row["scope"]["tau"].as_f64() == tau
                && row["group"]["kind"] == "all"
        };
        rates.iter().find(is_it).unwrap()
    };
    let inside = rate("in_region", Some(0.05));
    assert_eq!(
        (&inside["n_found_clean"], &inside["n_lost"]),
        (&json!(30), &json!(12)),
        "12 of 30"
    );
    assert_eq!(inside["failure_rate"]["value"], json!(0.4), "0.4");
    let everywhere = rate("whole_image", None);
    assert_eq!(everywhere["n_lost"], json!(13), "and one outside");
    let outside = rate("out_of_region", Some(0.05));
    assert!(
        outside["failure_rate"]["value"].is_null(),
        "10 objects are too few"
    );
    assert!(
        outside["failure_rate"]["refused"].is_string(),
        "and it is said"
    );
    let paired = evaluation["paired"].as_array().unwrap();
    let is_it = |row: &&Value| {
        row["scope"]["kind"] == "in_region"
            && row["scope"]["tau"] == json!(0.05)
            && row["group"]["kind"] == "all"
            && row["metric"] == "ap50"
    };
    let row = paired.iter().find(is_it).unwrap();
    // All that is found is right: precision is 1 at the 61 recalls up to 18 of 30.
    let wanted = 61.0 / 101.0;
    let cracked = row["cracked"]["value"].as_f64().unwrap();
    assert!(
        (cracked - wanted).abs() < 1e-12,
        "AP50 {cracked}, by hand {wanted}"
    );
    assert_eq!(row["clean"]["value"], json!(1.0), "clean finds all");
    let delta = &row["delta"];
    let (low, high) = (
        delta["low"].as_f64().unwrap(),
        delta["high"].as_f64().unwrap(),
    );
    assert!(
        low < wanted - 1.0 && wanted - 1.0 < high && high < 0.0,
        "{low} to {high}"
    );
    assert!(row["p"].as_f64().unwrap() < 0.02, "not by chance");
    let lines = fs::read_to_string(folder.path().join("out/failures.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 13, "one line per lost object");
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(
        page.contains("&lt;b&gt;car") && !page.contains("<b>car"),
        "a name is a name"
    );
    let csv = fs::read_to_string(folder.path().join("out/numbers.csv")).unwrap();
    let none: [String; 0] = [];
    assert_eq!(repeated_keys(&csv), none, "each number once");
    assert!(
        csv.contains(",whole_image,,all,all,ap50,"),
        "of whole images, too"
    );
    assert!(folder.path().join("out/table.tex").is_file(), "the table");
}

/// Two categories that are both called car, each with objects in the region.
#[test]
fn categories_of_one_name_stay_two() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_set(at);
    let mut labels: Value =
        serde_json::from_slice(&fs::read(at.join("labels.json")).unwrap()).unwrap();
    labels["categories"] = json!([{"id": 1, "name": "car"}, {"id": 7, "name": "car"}]);
    for object in labels["annotations"].as_array_mut().unwrap() {
        if object["id"].as_u64().unwrap() % 2 == 0 {
            object["category_id"] = json!(7);
        }
    }
    fs::write(at.join("labels.json"), labels.to_string()).unwrap();
    assert!(
        run(at, &["-o", "out"]).status.success(),
        "both are evaluated"
    );
    let csv = fs::read_to_string(at.join("out/numbers.csv")).unwrap();
    let none: [String; 0] = [];
    assert_eq!(repeated_keys(&csv), none, "each number once");
    assert!(
        csv.contains(",class,car,") && csv.contains(",class,car (id 7),"),
        "{csv}"
    );
}

#[test]
fn the_report_of_a_study_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    write_set(folder.path());
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("out/study.json"), "{}").unwrap();
    let output = run(folder.path(), &["-o", "out"]);
    assert_eq!(output.status.code(), Some(2), "refused");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("out: is the folder of a study"), "{said}");
    let left: Vec<_> = fs::read_dir(folder.path().join("out")).unwrap().collect();
    assert_eq!(left.len(), 1, "nothing was written beside it");
}

#[test]
fn equal_input_gives_equal_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    write_set(folder.path());
    let files = [
        "evaluation.json",
        "numbers.csv",
        "table.tex",
        "failures.jsonl",
    ];
    let read = |out: &str| files.map(|name| fs::read(folder.path().join(out).join(name)).unwrap());
    assert!(
        run(folder.path(), &["-o", "out", "--threads", "1"])
            .status
            .success(),
        "one thread"
    );
    let first = read("out");
    assert!(
        run(folder.path(), &["-o", "out", "--threads", "3"])
            .status
            .success(),
        "three"
    );
    let again = read("out");
    for ((a, b), name) in first.iter().zip(&again).zip(files) {
        // The command line is part of the provenance.
        let text =
            |bytes: &[u8]| String::from_utf8_lossy(bytes).replace("--threads 1", "--threads 3");
        assert_eq!(text(a), text(b), "{name}");
    }
}

#[test]
fn a_folder_that_cannot_take_a_file_gets_none() {
    let folder = tempfile::tempdir().unwrap();
    write_set(folder.path());
    // Where the page should go is a folder.
    fs::create_dir_all(folder.path().join("out/report.html")).unwrap();
    let output = run(folder.path(), &["-o", "out"]);
    assert_eq!(output.status.code(), Some(2), "refused");
    let left: Vec<_> = fs::read_dir(folder.path().join("out")).unwrap().collect();
    assert_eq!(left.len(), 1, "nothing was written beside it");
}
