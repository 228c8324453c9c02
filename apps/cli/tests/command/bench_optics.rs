//! `bench --model optics`.

use std::fs;

use crate::program::{all_refused, folder, names, succeed};
use serde_json::Value;

#[test]
fn the_optics_section_times_two_frames_and_two_discs() {
    let dir = folder();
    let args = [
        "bench", "--model", "optics", "--runs", "1", "--json", "-o", "b",
    ];
    let outcome = succeed(dir.path(), &args);
    let out = dir.path().join("b");
    assert_eq!(names(&out), ["bench-optics.csv", "bench.txt"], "files");
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let cases = result["optics"]["cases"].as_array().unwrap();
    let named: Vec<(u64, f64)> = cases
        .iter()
        .map(|case| {
            (
                case["width_px"].as_u64().unwrap(),
                case["radius_px"].as_f64().unwrap(),
            )
        })
        .collect();
    assert_eq!(
        named,
        [(1242, 7.2), (1242, 35.0), (1920, 7.2), (1920, 35.0)],
        "cases"
    );
    for case in cases {
        let median = |stage: &str| case["stages_ms"][stage]["median"].as_f64().unwrap();
        for stage in ["bake", "light", "first_frame", "next_frame"] {
            assert!(median(stage) > 0.0, "{stage}: {case}");
        }
        // With one run the stages of a still add up to it.
        let sum = median("bake") + median("light") + median("first_frame");
        let still = case["still_ms"]["median"].as_f64().unwrap();
        assert!((sum / still - 1.0).abs() < 1e-9, "{sum} of {still}: {case}");
        assert!(case["segments"].as_f64().unwrap() > 8.0, "a star: {case}");
    }
    // A larger disc spreads the same cracks over more pixels.
    for pair in cases.chunks_exact(2) {
        let touched = |case: &Value| case["touched_px"].as_f64().unwrap();
        assert!(touched(&pair[1]) > touched(&pair[0]), "{pair:?}");
    }
    let csv = fs::read_to_string(out.join("bench-optics.csv")).unwrap();
    let columns: Vec<usize> = csv.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(columns, [12; 5], "{csv}");
}

#[test]
fn a_recipe_that_no_model_hears_is_refused() {
    let cases = [
        ("optics", "--preset", "windshield-star"),
        ("physics", "--set", "fracture.mesh=fast"),
        ("optics", "--camera", "kitti"),
        ("optics", "--particles", "50"),
    ];
    let mut cases: Vec<_> = cases
        .map(|(model, flag, value)| (vec!["bench", "--model", model, flag, value], flag))
        .into();
    let fixed = vec!["bench", "--model", "physics", "--fixed-radius"];
    cases.push((fixed, "--fixed-radius"));
    all_refused(folder().path(), &cases);
}
