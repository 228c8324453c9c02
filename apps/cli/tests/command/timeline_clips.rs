//! `starbreak timeline` over several clips: their objects in one curve.

use std::fs;
use std::path::Path;

use crate::program::{folder, repeated_keys, succeed};
use serde_json::{Value, json};

/// Frames of each clip, at 10 per second.
const N: u64 = 30;
/// Objects of each clip.
const N_OBJECTS: u64 = 4;

/// Frame of the damage of a clip.
fn onset(clip: u64) -> u64 {
    6 + clip
}

fn write(at: &Path, name: &str, value: &Value) {
    fs::write(at.join(name), value.to_string()).unwrap();
}

/// Clips in one file of labels, with the detections of all: object k of 1 and 2 is lost k frames after
/// the damage of its clip, in a clip of even number a frame later.
fn scene(n_clips: u64) -> tempfile::TempDir {
    let dir = folder();
    let at = dir.path();
    fs::create_dir(at.join("tracks")).unwrap();
    let (mut videos, mut images, mut annotations) = (Vec::new(), Vec::new(), Vec::new());
    let (mut clean, mut cracked) = (Vec::new(), Vec::new());
    for clip in 0..n_clips {
        let name = format!("clip{clip}");
        videos.push(json!({"id": clip + 1, "name": name}));
        for k in 0..N {
            let id = 1 + clip * N + k;
            images.push(
                json!({"id": id, "file_name": format!("{name}/{k}.png"), "width": 200, "height": 240,
                "video_id": clip + 1, "frame_id": k}),
            );
            for object in 1..=N_OBJECTS {
                let bbox = [2.0 * k as f64, 40.0 * object as f64, 30.0, 20.0];
                annotations.push(
                    json!({"id": annotations.len() + 1, "image_id": id, "category_id": 3,
                    "instance_id": object, "bbox": bbox, "area": 600.0, "iscrowd": 0}),
                );
                let found = json!({"image_id": id, "category_id": 3, "bbox": bbox, "score": 0.8});
                let lost_from = onset(clip) + object + u64::from(clip % 2 == 0);
                if object > 2 || k < lost_from {
                    cracked.push(found.clone());
                }
                clean.push(found);
            }
        }
        let frames: Vec<Value> = (0..N)
            .map(|k| {
                let state = if k < onset(clip) { "intact" } else { "still" };
                json!({"frame_idx": k, "time_s": k as f64 / 10.0, "state": state})
            })
            .collect();
        let begins = json!({"frame_idx": onset(clip), "time_s": onset(clip) as f64 / 10.0});
        let track = json!({
            "schema": "starbreak.track/1", "n_frames": N, "fps": 10.0, "width_px": 200, "height_px": 240,
            "input": {"name": format!("{name}.mp4"), "kind": "clip", "sha256": "00"},
            "output": {"name": "out.mp4"}, "damage_onset": begins, "frames": frames,
        });
        write(at, &format!("tracks/{name}.track.json"), &track);
    }
    let categories = json!([{"id": 3, "name": "car"}]);
    write(
        at,
        "labels.json",
        &json!({"videos": videos, "images": images, "categories": categories, "annotations": annotations}),
    );
    write(at, "clean.json", &Value::from(clean));
    write(at, "cracked.json", &Value::from(cracked));
    dir
}

const ARGS: [&str; 12] = [
    "timeline",
    "labels.json",
    "--clean",
    "clean.json",
    "--cracked",
    "cracked.json",
    "--track",
    "tracks",
    "--replicates",
    "50",
    "-o",
    "out",
];

#[test]
fn the_objects_of_all_clips_are_in_one_curve_that_counts_from_each_damage() {
    let dir = scene(6);
    let at = dir.path();
    let outcome = succeed(at, &[&ARGS[..], &["--json"]].concat());
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let pooled = &result["pooled_clips"];
    assert_eq!(
        [
            &pooled["n_clips"],
            &pooled["cracked"]["n"],
            &pooled["cracked"]["n_lost"]
        ],
        [&json!(6), &json!(24), &json!(12)],
        "{pooled}"
    );
    assert_eq!(pooled["unit"], json!("clip"), "clips are drawn");
    assert_eq!(pooled["clean"]["n_lost"], json!(0), "the control");
    // By hand: of 24 objects 3 are lost 0.1 s after the damage, 6 after 0.2 s, 3 after 0.3 s; all are
    // followed beyond, whatever the frame of the damage.
    let steps = pooled["cracked"]["steps"].as_array().unwrap();
    let row = |step: &Value| {
        let number = |key: &str| step[key].as_f64().unwrap();
        (
            number("time_s"),
            number("n_at_risk"),
            number("n_lost"),
            step["share"]["value"].as_f64().unwrap(),
        )
    };
    let expected = [
        (0.1, 24.0, 3.0, 21.0 / 24.0),
        (0.2, 21.0, 6.0, 15.0 / 24.0),
        (0.3, 15.0, 3.0, 0.5),
    ];
    assert_eq!(steps.len(), 3, "{steps:?}");
    for (step, expected) in steps.iter().zip(expected) {
        let found = row(step);
        assert_eq!(
            (found.0, found.1, found.2),
            (expected.0, expected.1, expected.2),
            "{step}"
        );
        assert!((found.3 - expected.3).abs() < 1e-12, "{step}");
    }
    let interval = &steps[0]["share"]["interval"];
    let scaled = |end: &str| (-interval[end].as_f64().unwrap().ln()).ln();
    let half = (scaled("low") - scaled("high")) / 2.0 * -(21.0_f64 / 24.0).ln();
    // After 0.1 s one of 4 is lost in three of six clips, none in the others: a clip's sum is
    // (d_c − 4 · 3/24)/21, so ±0.5/21.
    let by_hand = 1.959_963_984_540_054 * (6.0_f64 / 5.0 * 6.0 * (0.5 / 21.0_f64).powi(2)).sqrt();
    assert!((half - by_hand).abs() < 1e-9, "{half}, by hand {by_hand}");
    assert_eq!(interval["method"], json!("williams_log_log"), "{interval}");

    // 4 objects of a clip are few, 24 of all are not; 6 clips are.
    let warnings = result["warnings"].to_string();
    assert!(!warnings.contains("use longer clips"), "{warnings}");
    assert!(
        warnings.contains("between clips; with fewer than 20"),
        "{warnings}"
    );
    let csv = fs::read_to_string(at.join("out/numbers.csv")).unwrap();
    let none: [String; 0] = [];
    assert_eq!(repeated_keys(&csv), none, "each number once");
    for row in [
        ",at_risk_cracked,,,24,",
        ",lost_cracked,,,12,",
        ",not_lost_cracked_after_0.200000_s,,,0.625,",
        "between clips (Williams)",
    ] {
        assert!(csv.contains(row), "{row}: {csv}");
    }
    let written: Value =
        serde_json::from_slice(&fs::read(at.join("out/evaluation.json")).unwrap()).unwrap();
    assert_eq!(
        &written["evaluations"][0]["pooled_clips"], pooled,
        "in the file, too"
    );
    let page = fs::read_to_string(at.join("out/report.html")).unwrap();
    for said in [
        "all 6 clips together",
        "<th scope=\"row\">all clips together</th>",
        "fig-e0-clips-survival",
        "(Williams)",
    ] {
        assert!(page.contains(said), "the page says {said:?}");
    }
    let shown = succeed(at, &ARGS);
    let said =
        "6 clips together: of 24 objects at risk 12 lost, 0 clean, half of them within 0.30 s";
    assert!(
        shown.stderr.contains(said) || shown.stdout.contains(said),
        "{shown:?}"
    );
}

#[test]
fn few_clips_take_objects_as_independent_and_say_so() {
    let dir = scene(3);
    let outcome = succeed(dir.path(), &[&ARGS[..], &["--json"]].concat());
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let pooled = &result["pooled_clips"];
    assert_eq!(pooled["unit"], json!("object"), "{pooled}");
    let interval = &pooled["cracked"]["steps"][0]["share"]["interval"];
    assert_eq!(interval["method"], json!("greenwood_log_log"), "{interval}");
    let warnings = result["warnings"].to_string();
    for said in [
        "clip clip0: only 4 objects are at risk",
        "the 3 clips together: only 12 objects are at risk",
        "intervals treat objects as independent",
    ] {
        assert!(warnings.contains(said), "{said}: {warnings}");
    }
    let alone = scene(1);
    let outcome = succeed(alone.path(), &[&ARGS[..], &["--json"]].concat());
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["pooled_clips"], Value::Null, "one clip is no pool");
}
