//! The verb `study` on the real binary, with a real detector on real images.
#![expect(clippy::unwrap_used, reason = "a test")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use common::{command, folder, json, skipped, snapshot, starbreak};
use serde_json::Value;

/// The shared data, where it is at hand.
fn data() -> Option<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let is_there = shared.join("onnx/FastestDet.onnx").is_file();
    if !is_there {
        skipped(&format!("{} is not at hand", shared.display()));
    }
    is_there.then(|| shared.canonicalize().unwrap())
}

/// A study of eight images, two severities of coarse paper cracks, to the folder `out`.
fn arguments(data: &Path, out: &str) -> Vec<String> {
    let source = format!("coco:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    [
        "study",
        &source,
        "--model",
        &model,
        "--presets",
        "paper",
        "--severities",
        "1,5",
        "--set",
        "fracture.particles=800",
        "--limit",
        "8",
        "--replicates",
        "20",
        "--worst",
        "1",
        "-o",
        out,
    ]
    .map(str::to_owned)
    .to_vec()
}

#[test]
fn a_study_gives_one_report_and_a_killed_one_comes_to_the_same() {
    let Some(data) = data() else { return };
    let dir = folder();
    let whole = starbreak(dir.path(), &arguments(&data, "whole"));
    assert_eq!(whole.code, Some(0), "{}", whole.stderr);
    for name in ["report.html", "evaluation.json", "numbers.csv", "table.tex"] {
        assert!(dir.path().join("whole").join(name).is_file(), "{name}");
    }
    let study = json(&dir.path().join("whole/evaluation.json"));
    let evaluations = study["evaluations"].as_array().unwrap();
    let of = |key: &str| -> Vec<&Value> {
        evaluations
            .iter()
            .map(|one| &one["condition"][key])
            .collect()
    };
    assert_eq!(of("severity"), [&Value::from(1), &Value::from(5)], "both");
    assert_eq!(of("family"), ["paper", "paper"], "of one family");
    for one in evaluations {
        assert_eq!(one["counts"]["n_images"], 8, "images of the limit only");
        assert_eq!(
            one["clean"], evaluations[0]["clean"],
            "one clean arm for all"
        );
    }

    // Killed at several moments, then left alone.
    for wait_ms in [300, 900, 1500, 2500] {
        let mut child = command(dir.path(), &arguments(&data, "killed"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait_ms));
        let _ = child.kill();
        child.wait().unwrap();
    }
    let resumed = starbreak(dir.path(), &arguments(&data, "killed"));
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    let files = |name: &str| {
        let mut files = snapshot(&dir.path().join(name));
        // What names the folder itself, in the command line and in paths, differs.
        for named in ["report.html", "evaluation.json"] {
            files.remove(Path::new(named));
        }
        files
    };
    assert_eq!(
        files("killed").keys().collect::<Vec<_>>(),
        files("whole").keys().collect::<Vec<_>>(),
        "the same files"
    );
    for (name, bytes) in files("whole") {
        // Records hold how long each image took.
        let is_record = name.starts_with("sets") && name.extension().is_some_and(|e| e == "json");
        if !is_record {
            assert_eq!(files("killed").get(&name), Some(&bytes), "{name:?}");
        }
    }
    let numbers =
        |name: &str| json(&dir.path().join(name).join("evaluation.json"))["evaluations"].clone();
    assert_eq!(numbers("killed"), numbers("whole"), "the same numbers");
}

#[test]
fn what_cannot_be_studied_is_refused_before_anything_is_written() {
    let Some(data) = data() else { return };
    let dir = folder();
    let text = dir.path().join("text.onnx");
    fs::write(&text, "this is text").unwrap();
    let coco = format!("coco:{}", data.join("coco96").display());
    let pictures = format!("folder:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    let text = text.display().to_string();
    let cases: [(Vec<&str>, &str); 5] = [
        (vec![&coco, "--model", &text], "text.onnx"),
        (vec![&pictures, "--model", &model], "no labels"),
        (
            vec![&coco, "--model", &model, "--presets", "papper"],
            "did you mean",
        ),
        (
            vec![
                &coco,
                "--model",
                &model,
                "--contract",
                "auto",
                "--contract",
                "auto",
            ],
            "2 contracts for 1 models",
        ),
        (
            vec![&coco, "--model", &model, "--set", "output.format=\"png\""],
            "output.format",
        ),
    ];
    for (arguments, named) in cases {
        let mut all = vec!["study"];
        all.extend(arguments);
        all.extend(["--limit", "2", "-o", "out"]);
        let outcome = starbreak(dir.path(), &all);
        assert_eq!(outcome.code, Some(2), "{named}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains(named),
            "{named}: {}",
            outcome.stderr
        );
        assert!(!dir.path().join("out").exists(), "{named}: nothing written");
    }
}
