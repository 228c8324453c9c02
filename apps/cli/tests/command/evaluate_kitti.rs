//! `evaluate` on a broken set of KITTI: intervals of its own average precisions, damage of each object.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::program::{folder, json, starbreak, succeed};
use serde_json::Value;

/// Breaks the made-up set. In such small frames, of many particles each would be a neighbor of most others.
const GENERATE: [&str; 8] = [
    "generate",
    "kitti:kitti",
    "--preset",
    "paper",
    "--set",
    "fracture.particles=800",
    "-o",
    "broken",
];

const N: usize = 48;

/// 48 frames with a car each that is plain to see, of six drives; broken, with detections in both. Clean
/// finds all; cracked misses more of the first drives than of the last.
fn write_set(root: &Path) {
    for kind in ["image_2", "label_2"] {
        fs::create_dir_all(root.join("kitti/training").join(kind)).unwrap();
    }
    for kind in ["clean", "cracked"] {
        fs::create_dir_all(root.join(kind)).unwrap();
    }
    let mut clusters = String::new();
    for k in 0..N {
        let x = 20 + k % 7 * 10;
        let place = format!("{x}.00 10.00 {}.00 60.00", x + 80);
        let of =
            |score: &str| format!("Car 0.00 0 0.00 {place} 1.5 1.6 3.9 0.0 1.7 20.0 0.0{score}\n");
        let training = root.join("kitti/training");
        crate::program::write_photo(&training.join(format!("image_2/{k:06}.png")));
        let area = "DontCare -1 -1 -10 0.00 0.00 8.00 8.00 -1 -1 -1 -1000 -1000 -1000 -10\n";
        let label = area.to_owned() + &of("");
        fs::write(training.join(format!("label_2/{k:06}.txt")), label).unwrap();
        let found = of(&format!(" 0.{}", 50 + k % 40));
        fs::write(root.join(format!("clean/{k:06}.txt")), &found).unwrap();
        let found = if k % (2 + k / 8) == 0 { "" } else { &found };
        fs::write(root.join(format!("cracked/{k:06}.txt")), found).unwrap();
        writeln!(clusters, "{k:06}.png,drive {}", k / 8).unwrap();
    }
    fs::write(root.join("drives.csv"), clusters).unwrap();
}

const EVALUATE: [&str; 10] = [
    "evaluate",
    "kitti:kitti",
    "--clean",
    "clean",
    "--cracked",
    "cracked",
    "--cracked-set",
    "broken",
    "--replicates",
    "200",
];

fn evaluate(root: &Path, out: &str, more: &[&str]) -> Value {
    let args: Vec<&str> = EVALUATE
        .iter()
        .chain(&["-o", out])
        .chain(more)
        .copied()
        .collect();
    succeed(root, &args);
    json(&root.join(out).join("evaluation.json"))
}

#[test]
fn kitti_has_intervals_drives_and_damage() {
    let root = folder();
    let root = root.path();
    write_set(root);
    succeed(root, &GENERATE);
    let study = evaluate(root, "images", &[]);
    let row = |study: &Value, metric: &str| {
        let rows = study["evaluations"][0]["paired"].as_array().unwrap();
        let is_it = |row: &&Value| {
            row["metric"] == metric
                && row["scope"]["kind"] == "whole_image"
                && row["group"]["name"] == "car"
        };
        rows.iter().find(is_it).unwrap().clone()
    };
    for metric in ["kitti_ap40", "kitti_ap11"] {
        let row = row(&study, metric);
        assert_eq!(row["clean"]["value"], 1.0, "{metric}: clean finds all");
        let cracked = row["cracked"]["value"].as_f64().unwrap();
        let [low, high] = ["low", "high"].map(|end| row["cracked"][end].as_f64().unwrap());
        assert!(
            low < cracked && cracked < high,
            "{metric}: {low} {cracked} {high}"
        );
        assert!(
            row["delta"]["high"].as_f64().unwrap() < 0.0,
            "{metric}: a loss"
        );
        assert!(row["p"].as_f64().unwrap() < 0.01, "{metric}: no chance");
        assert!(row["p_holm"].is_number(), "{metric}: corrected");
    }
    let doses = study["evaluations"][0]["failures"]["dose_responses"]
        .as_array()
        .unwrap();
    let has = |fact: &str| doses.iter().any(|dose| dose["fact"] == fact);
    assert!(
        has("coverage") && has("contrast lost"),
        "the damage of each object: {doses:?}"
    );

    assert_eq!(
        study["provenance"]["settings"]["resampling_unit"], "image",
        "images are drawn"
    );
    let drives = evaluate(root, "drives", &["--clusters", "drives.csv"]);
    let unit = &drives["provenance"]["settings"]["resampling_unit"];
    assert_eq!(unit, "clip or drive", "drives are drawn");
    let width = |study: &Value| {
        let row = row(study, "kitti_ap40");
        row["cracked"]["high"].as_f64().unwrap() - row["cracked"]["low"].as_f64().unwrap()
    };
    assert!(
        (width(&drives) - width(&study)).abs() > 1e-6,
        "another interval"
    );

    let args: Vec<&str> = EVALUATE
        .iter()
        .chain(&["--clusters", "drives.csv"])
        .copied()
        .collect();
    let refused = starbreak(root, &args);
    assert_eq!(
        refused.code,
        Some(2),
        "clusters without intervals: {}",
        refused.stderr
    );
    fs::write(root.join("file"), "").unwrap();
    let args: Vec<&str> = EVALUATE
        .iter()
        .chain(&["-o", "file/out"])
        .copied()
        .collect();
    let refused = starbreak(root, &args);
    assert_eq!(refused.code, Some(2), "no folder: {}", refused.stderr);
}

#[test]
fn a_set_that_is_not_as_its_lists_say_gives_no_numbers() {
    let root = folder();
    let root = root.path();
    write_set(root);
    succeed(root, &GENERATE);
    let refused = |more: &[&str], what: &str, word: &str| {
        let plain = [
            "evaluate",
            "kitti:kitti",
            "--clean",
            "clean",
            "--cracked",
            "cracked",
            "--replicates",
            "20",
        ];
        let outcome = starbreak(root, &[&plain[..], more].concat());
        assert_eq!(
            outcome.code,
            Some(2),
            "{what}, {more:?}: {}",
            outcome.stderr
        );
        assert!(
            outcome.stderr.contains(word),
            "{what}, {more:?}: {}",
            outcome.stderr
        );
    };
    let set = ["--cracked-set", "broken"];
    let report = ["--cracked-set", "broken", "-o", "report"];
    let regions = ["--regions", "broken/starbreak/regions"];
    let damaged = |name: &str, asked: &[&[&str]]| {
        let path = root.join("broken").join(name);
        let whole = fs::read(&path).unwrap();
        let mut bytes = whole.clone();
        let at = bytes.iter().rposition(|byte| *byte == b'1').unwrap();
        bytes[at] = b'2';
        fs::write(&path, bytes).unwrap();
        for more in asked {
            refused(more, name, name);
        }
        fs::write(&path, whole).unwrap();
    };
    damaged(
        "starbreak/regions/training/image_2/000003.png",
        &[&set, &report, &regions],
    );
    damaged(
        "starbreak/provenance/training/image_2/000003.json",
        &[&report],
    );
    damaged("training/image_2/000003.png", &[&report]);
    damaged("starbreak/items.jsonl", &[&set, &report, &regions]);

    fs::remove_file(root.join("broken/starbreak/manifest.json")).unwrap();
    for more in [&set[..], &report, &regions] {
        refused(more, "no manifest", "manifest.json");
    }
    assert!(!root.join("report").exists(), "nothing is written");
    succeed(root, &GENERATE);
    succeed(root, &[&EVALUATE[..], &["-o", "report"]].concat());
}
