//! `bench --model`: the physics section, and that each model can be left out.

use std::fs;

use crate::program::{folder, names, succeed};
use serde_json::Value;

#[test]
fn the_physics_section_times_every_pane_on_both_meshes() {
    let dir = folder();
    let args = [
        "bench", "--model", "physics", "--runs", "1", "--json", "-o", "b",
    ];
    let outcome = succeed(dir.path(), &args);
    let out = dir.path().join("b");
    assert_eq!(
        names(&out),
        ["bench-physics.csv", "bench.txt"],
        "nothing of the paper's model"
    );
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(result["series"].is_null(), "{result}");
    let cases = result["physics"]["cases"].as_array().unwrap();
    let named: Vec<(&str, &str)> = cases
        .iter()
        .map(|case| {
            (
                case["mesh"].as_str().unwrap(),
                case["case"].as_str().unwrap(),
            )
        })
        .collect();
    for mesh in ["default", "fast"] {
        let panes = named.iter().filter(|(of, _)| *of == mesh).count();
        assert_eq!(panes, 4, "mesh {mesh}: {named:?}");
    }
    for case in cases {
        let stages = case["stages_ms"].as_object().unwrap();
        assert!(
            stages.contains_key("contact") && stages.contains_key("network"),
            "{case}"
        );
        // With one run the stages add up to the total.
        let sum: f64 = stages
            .values()
            .map(|stage| stage["median"].as_f64().unwrap())
            .sum();
        let total = case["total_ms"]["median"].as_f64().unwrap();
        assert!((sum / total - 1.0).abs() < 1e-6, "{sum} of {total}: {case}");
        let has_dice = case["case"].as_str().unwrap().contains("tempered");
        assert_eq!(stages.contains_key("dice"), has_dice, "{case}");
        assert_eq!(stages.contains_key("stress"), !has_dice, "{case}");
    }
    let another = result["physics"]["another_impact"].as_array().unwrap();
    assert_eq!(another.len(), 2, "{result}");
    for one in another {
        assert!(one["ms"]["median"].as_f64().unwrap() > 0.0, "{one}");
    }
    let csv = fs::read_to_string(out.join("bench-physics.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 9, "a header and eight runs: {csv}");
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
}

#[test]
fn both_models_are_measured_unless_one_is_named() {
    let dir = folder();
    let args = ["bench", "--runs", "1", "--particles", "50", "-o", "b"];
    let outcome = succeed(dir.path(), &args);
    let out = dir.path().join("b");
    assert_eq!(
        names(&out),
        [
            "bench-optics.csv",
            "bench-physics.csv",
            "bench.csv",
            "bench.png",
            "bench.svg",
            "bench.txt"
        ],
        "files"
    );
    let table = fs::read_to_string(out.join("bench.txt")).unwrap();
    assert!(outcome.stdout.contains(&table), "the table is shown");
    for words in [
        "50 particles",
        "laminated star, mesh default, 1 runs",
        "kept factor",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
}
