//! `starbreak timeline`: detections that are incomplete or of something else, and several clips.

use std::fs;
use std::path::Path;

use crate::program::{Outcome, folder, snapshot, starbreak, succeed};
use serde_json::{Value, json};

/// Frames of each clip; the damage begins at frame 10 of `a` and 12 of `b`.
const N: u64 = 30;
const ONSETS: [(&str, u64); 2] = [("a", 10), ("b", 12)];

/// Where object `k` is in a frame.
fn corners(object: u64, frame: u64) -> [f64; 4] {
    let (x, y) = (2.0 * frame as f64, 40.0 * object as f64);
    [x, y, x + 30.0, y + 20.0]
}

fn write(at: &Path, name: &str, value: &Value) {
    fs::write(at.join(name), value.to_string()).unwrap();
}

fn track_file(name: &str, onset: u64, file: Option<fn(u64) -> String>) -> Value {
    let frames: Vec<Value> = (0..N)
        .map(|k| {
            let state = if k < onset { "intact" } else { "still" };
            let mut line = json!({"frame_idx": k, "time_s": k as f64 / 10.0, "state": state});
            if let Some(file) = file {
                line["file"] = json!(file(k));
            }
            line
        })
        .collect();
    json!({
        "schema": "starbreak.track/1", "n_frames": N, "fps": 10.0, "width_px": 200, "height_px": 240,
        "input": {"name": name, "kind": "clip", "sha256": "00"}, "output": {"name": "out.mp4"},
        "damage_onset": {"frame_idx": onset, "time_s": onset as f64 / 10.0}, "frames": frames,
    })
}

/// Results of a clip; image numbers from `first_id`.
fn results(first_id: u64, category: u64, is_found: impl Fn(u64, u64) -> bool) -> Value {
    let mut list = Vec::new();
    for frame in 0..N {
        for object in (1..=4).filter(|k| is_found(*k, frame)) {
            let [x, y, x1, y1] = corners(object, frame);
            list.push(
                json!({"image_id": first_id + frame, "category_id": category,
                "bbox": [x, y, x1 - x, y1 - y], "score": 0.8}),
            );
        }
    }
    Value::Array(list)
}

/// Results of KITTI, file names by `name`.
fn kitti(at: &Path, folder: &str, class: &str, name: impl Fn(u64) -> String) {
    fs::create_dir_all(at.join(folder)).unwrap();
    for frame in 0..N {
        let row = |object| {
            let [x0, y0, x1, y1] = corners(object, frame);
            format!("{class} -1 -1 -10 {x0} {y0} {x1} {y1} -1 -1 -1 -1000 -1000 -1000 -10 0.8\n")
        };
        let rows: String = (1..=4).map(row).collect();
        fs::write(at.join(folder).join(name(frame)), rows).unwrap();
    }
}

/// Two clips in one file of labels of MS-COCO, with the detections of each by frame.
fn scene() -> tempfile::TempDir {
    let dir = folder();
    let at = dir.path();
    let (mut videos, mut images, mut annotations) = (Vec::new(), Vec::new(), Vec::new());
    for folder in ["clean", "cracked", "tracks", "label_02"] {
        fs::create_dir(at.join(folder)).unwrap();
    }
    for (place, (clip, onset)) in (0..).zip(ONSETS) {
        videos.push(json!({"id": place + 1, "name": clip}));
        let mut rows = String::new();
        for k in 0..N {
            let id = 1 + place * N + k;
            images.push(
                json!({"id": id, "file_name": format!("{clip}/{k}.png"), "width": 200,
                "height": 240, "video_id": place + 1, "frame_id": k}),
            );
            for object in 1..=4 {
                let [x, y, x1, y1] = corners(object, k);
                annotations.push(json!({"id": annotations.len() + 1, "image_id": id, "category_id": 3,
                    "instance_id": 10 * place + object, "bbox": [x, y, x1 - x, y1 - y], "area": 600.0,
                    "iscrowd": 0}));
                rows.push_str(&format!(
                    "{k} {object} Car 0 0 -1 {x} {y} {x1} {y1} 1 1 1 0 0 0 0\n"
                ));
            }
        }
        fs::write(at.join(format!("label_02/{clip}.txt")), rows).unwrap();
        let track = track_file(&format!("{clip}.mp4"), onset, None);
        write(at, &format!("tracks/{clip}.track.json"), &track);
        write(
            at,
            &format!("clean/{clip}.json"),
            &results(1, 3, |_, _| true),
        );
        // Objects 1 and 2 are lost 2 frames and 4 frames after the onset.
        let cracked = results(1, 3, |k, frame| k > 2 || frame < onset + 2 * k);
        write(at, &format!("cracked/{clip}.json"), &cracked);
    }
    let categories = json!([{"id": 3, "name": "car"}]);
    write(
        at,
        "labels.json",
        &json!({"videos": videos, "images": images, "categories": categories, "annotations": annotations}),
    );
    dir
}

/// The clip `a` by frame with these sides.
fn of_a<'a>(clean: &'a str, cracked: &'a str) -> Vec<&'a str> {
    vec![
        "timeline",
        "labels.json",
        "--clip",
        "a",
        "--by-frame",
        "--clean",
        clean,
        "--cracked",
        cracked,
        "--track",
        "tracks/a.track.json",
        "--replicates",
        "50",
    ]
}

fn refused(at: &Path, args: &[&str], words: &[&str]) {
    let outcome = starbreak(at, args);
    assert_eq!(outcome.code, Some(2), "{args:?}: {outcome:?}");
    assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    for word in words {
        assert!(outcome.stderr.contains(word), "{word:?}: {outcome:?}");
    }
}

/// A warning stands in the output, in the JSON and in the report.
fn warned(at: &Path, args: &[&str], words: &str) -> Outcome {
    let outcome = succeed(at, &[args, &["-o", "out", "--json"]].concat());
    assert!(outcome.stderr.contains(words), "{words:?}: {outcome:?}");
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(result["warnings"].to_string().contains(words), "{result}");
    let page = fs::read_to_string(at.join("out/report.html")).unwrap();
    assert!(page.contains(words), "the page says {words:?}");
    outcome
}

#[test]
fn detections_that_stop_early_begin_late_or_are_not_there_are_warned_about() {
    let dir = scene();
    let at = dir.path();
    let whole = succeed(at, &of_a("clean/a.json", "cracked/a.json"));
    assert!(!whole.stderr.contains("detections"), "{whole:?}");
    write(at, "half.json", &results(1, 3, |_, frame| frame < 20));
    write(at, "late.json", &results(1, 3, |_, frame| frame >= 6));
    write(at, "empty.json", &json!([]));
    let said = "detections on the damaged side end at frame 19, on the clean side at 29 of 29";
    warned(at, &of_a("clean/a.json", "half.json"), said);
    let said = "detections on the clean side end at frame 19";
    warned(at, &of_a("half.json", "cracked/a.json"), said);
    let said = "detections on the damaged side begin at frame 6, on the clean side at 0";
    warned(at, &of_a("clean/a.json", "late.json"), said);
    let said = "no detections on the damaged side in any of its 30 frames";
    let one = warned(at, &of_a("clean/a.json", "empty.json"), said);
    assert!(
        !one.stderr.contains("no detections on the clean side"),
        "{one:?}"
    );
    let said = "no detections on the clean side in any of its 30 frames";
    let both = warned(at, &of_a("empty.json", "empty.json"), said);
    assert!(
        both.stderr.contains("no detections on the damaged side"),
        "{both:?}"
    );
    // Without labels likewise.
    let args = [
        "timeline",
        "--clean",
        "clean/a.json",
        "--cracked",
        "half.json",
        "--track",
        "tracks/a.track.json",
        "--replicates",
        "50",
    ];
    warned(at, &args, "detections on the damaged side end at frame 19");
}

#[test]
fn detections_of_other_images_or_other_categories_are_refused() {
    let dir = scene();
    let at = dir.path();
    let args = [
        "timeline",
        "labels.json",
        "--clean",
        "clean/b.json",
        "--cracked",
        "cracked/b.json",
        "--track",
        "tracks/b.track.json",
    ];
    refused(at, &args, &["clean/b.json", "clip \"b\"", "--by-frame"]);
    write(at, "other.json", &results(1, 60, |_, _| true));
    let args = of_a("clean/a.json", "other.json");
    refused(
        at,
        &args,
        &[
            "all 120 detections on the damaged side",
            "categories",
            "\"60\"",
        ],
    );
    let mut some = results(1, 3, |_, _| true);
    let foreign = results(1, 60, |k, _| k == 1);
    some.as_array_mut()
        .unwrap()
        .extend(foreign.as_array().unwrap().clone());
    write(at, "some.json", &some);
    let said = "30 of 150 detections on the damaged side have categories that the labels lack";
    warned(at, &of_a("clean/a.json", "some.json"), said);
    let name = |k| format!("frame_{k:06}.txt");
    kitti(at, "k", "Car", name);
    kitti(at, "donuts", "donut", name);
    let args = [
        "timeline",
        "label_02/a.txt",
        "--clean",
        "k",
        "--cracked",
        "donuts",
        "--track",
        "tracks/a.track.json",
    ];
    refused(
        at,
        &args,
        &["all 120 detections on the damaged side", "donut"],
    );
}

#[test]
fn scalabel_labels_keep_categories_that_bdd100k_lacks() {
    let dir = scene();
    let at = dir.path();
    let frames = |is_result: bool| -> Value {
        let frame = |k: u64| {
            let labels: Vec<Value> = (1..=4)
                .map(|object| {
                    let [x1, y1, x2, y2] = corners(object, k);
                    let class = if object == 1 { "car" } else { "donut" };
                    let mut label = json!({"id": object.to_string(), "category": class,
                        "box2d": {"x1": x1, "y1": y1, "x2": x2, "y2": y2}});
                    if is_result {
                        label["score"] = json!(0.8);
                    }
                    label
                })
                .collect();
            json!({"name": format!("{k}.png"), "videoName": "a", "frameIndex": k, "labels": labels})
        };
        Value::Array((0..N).map(frame).collect())
    };
    write(at, "s.json", &frames(false));
    write(at, "found.json", &frames(true));
    let args = [
        "timeline",
        "s.json",
        "--clean",
        "found.json",
        "--cracked",
        "found.json",
        "--track",
        "tracks/a.track.json",
        "--json",
        "--replicates",
        "50",
    ];
    let outcome = succeed(at, &args);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let objects = result["timelines"][0]["objects"].as_array().unwrap();
    let classes: Vec<&str> = objects
        .iter()
        .map(|it| it["class"].as_str().unwrap())
        .collect();
    assert_eq!(classes, ["car", "donut", "donut", "donut"], "all are kept");
    assert_eq!(
        result["timelines"][0]["cracked"]["survival"]["n"],
        json!(4),
        "and followed"
    );
    // The benchmark's own classes are a closed list: nothing is dropped in silence.
    let args = [
        "evaluate",
        "--ground-truth",
        "s.json",
        "--protocol",
        "bdd",
        "--clean",
        "found.json",
        "-o",
        "e",
    ];
    refused(at, &args, &["90 of 120 boxes", "\"donut\""]);
}

#[test]
fn several_clips_by_frame_are_evaluated_and_their_files_are_named() {
    let dir = scene();
    let at = dir.path();
    let args = [
        "timeline",
        "labels.json",
        "--by-frame",
        "--clean",
        "clean",
        "--cracked",
        "cracked",
        "--track",
        "tracks",
        "--replicates",
        "50",
        "-o",
        "out",
    ];
    succeed(at, &args);
    let written = crate::program::json(&at.join("out/evaluation.json"));
    assert_eq!(
        written["evaluations"][0]["timelines"]
            .as_array()
            .unwrap()
            .len(),
        2,
        "both"
    );
    let inputs = written["provenance"]["inputs"].to_string();
    for file in [
        "clean/a.json",
        "clean/b.json",
        "cracked/a.json",
        "cracked/b.json",
    ] {
        assert!(inputs.contains(file), "{file}: {inputs}");
    }
    for (clip, _) in ONSETS {
        for side in ["kc", "kk"] {
            kitti(at, &format!("{side}/{clip}"), "Car", |k| {
                format!("frame_{k:06}.txt")
            });
        }
    }
    let args = [
        "timeline",
        "label_02",
        "--clean",
        "kc",
        "--cracked",
        "kk",
        "--track",
        "tracks",
        "--replicates",
        "50",
        "-o",
        "kout",
    ];
    succeed(at, &args);
    // No file that was read is replaced, in a folder of several either.
    for side in ["clean", "cracked"] {
        let of_side = at.join(side);
        fs::copy(of_side.join("a.json"), of_side.join("evaluation.json")).unwrap();
    }
    let labels = fs::read_to_string(at.join("labels.json")).unwrap();
    let renamed = labels.replace("\"name\":\"a\"", "\"name\":\"evaluation\"");
    assert_ne!(renamed, labels, "the clip has another name");
    fs::write(at.join("renamed.json"), renamed).unwrap();
    let args = [
        "timeline",
        "renamed.json",
        "--by-frame",
        "--clean",
        "clean",
        "--cracked",
        "cracked",
        "--track",
        "evaluation=tracks/a.track.json",
        "-o",
        "clean",
        "--replace",
    ];
    refused(
        at,
        &args,
        &["would replace the input", "clean/evaluation.json"],
    );
}

#[test]
fn names_of_kitti_results_are_numbers_of_frames_and_that_is_said() {
    let dir = scene();
    let at = dir.path();
    kitti(at, "from0", "Car", |k| format!("{k:06}.txt"));
    kitti(at, "from1", "Car", |k| format!("{:06}.txt", k + 1));
    kitti(at, "far", "Car", |k| format!("{:06}.txt", k + 7));
    let by_name: fn(u64) -> String = |k| format!("{:06}.png", k + 1);
    write(
        at,
        "named.track.json",
        &track_file("a.mp4", 10, Some(by_name)),
    );
    let args = |clean: &'static str, track: &'static str| -> Vec<&'static str> {
        vec![
            "timeline",
            "label_02/a.txt",
            "--clean",
            clean,
            "--cracked",
            clean,
            "--track",
            track,
            "--replicates",
            "50",
        ]
    };
    for (clean, track, first) in [
        ("from0", "tracks/a.track.json", Some(0)),
        ("from1", "tracks/a.track.json", Some(1)),
        ("from0", "named.track.json", Some(0)),
        ("from1", "named.track.json", None),
    ] {
        let args = args(clean, track);
        let outcome = succeed(at, &args);
        assert!(
            outcome.stdout.contains("100.0 % clean"),
            "each frame is its own: {outcome:?}"
        );
        match first {
            Some(first) => {
                let said = format!(
                    "{clean}: its file names are read as frame numbers, counted from {first}"
                );
                warned(at, &args, &said);
            }
            None => assert!(
                !outcome.stderr.contains("read as frame numbers"),
                "{outcome:?}"
            ),
        }
    }
    let args = args("far", "tracks/a.track.json");
    refused(
        at,
        &args,
        &[
            "frames that the clip lacks",
            "000030",
            "\"frame_000000.png\"",
        ],
    );
}

#[test]
fn a_clip_given_twice_and_the_folder_of_a_study_are_refused() {
    let dir = scene();
    let at = dir.path();
    let of_a = of_a("clean/a.json", "cracked/a.json");
    let twice = [&of_a[..], &["--clip", "a", "-o", "out"]].concat();
    refused(at, &twice, &["--clip \"a\" is given twice"]);
    assert!(!at.join("out").exists(), "nothing written");
    fs::create_dir(at.join("study")).unwrap();
    fs::write(at.join("study/study.json"), "{}").unwrap();
    fs::write(at.join("study/report.html"), "the study's").unwrap();
    let before = snapshot(at);
    let args = [&of_a[..], &["-o", "study"]].concat();
    refused(
        at,
        &args,
        &["study: is the folder of a study", "give another"],
    );
    assert!(snapshot(at) == before, "nothing written");
}

#[test]
fn a_report_of_clips_leaves_nothing_of_one_of_images_and_is_put_into_no_set() {
    let dir = scene();
    let at = dir.path();
    let of_a = of_a("clean/a.json", "cracked/a.json");
    let to_out = [&of_a[..], &["-o", "out"]].concat();
    // Files of these names that are of no report stay.
    fs::create_dir(at.join("out")).unwrap();
    fs::write(at.join("out/table.tex"), "somebody's").unwrap();
    succeed(at, &to_out);
    write(at, "all.json", &results(1, 3, |_, _| true));
    let args = [
        "evaluate",
        "--ground-truth",
        "labels.json",
        "--clean",
        "all.json",
        "--cracked",
        "all.json",
        "-o",
        "out",
    ];
    refused(at, &args, &["out/table.tex", "--replace"]);
    let theirs = fs::read_to_string(at.join("out/table.tex")).unwrap();
    assert_eq!(theirs, "somebody's", "as it was");
    fs::remove_file(at.join("out/table.tex")).unwrap();
    succeed(at, &args);
    assert!(at.join("out/failures.jsonl").is_file(), "of images");
    succeed(at, &to_out);
    let files = [
        "evaluation.json",
        "numbers.csv",
        "report.html",
        "written.json",
    ];
    assert_eq!(
        crate::program::names(&at.join("out")),
        files,
        "of clips alone"
    );

    fs::create_dir_all(at.join("set/starbreak")).unwrap();
    fs::write(at.join("set/starbreak/run.json"), "{}").unwrap();
    let to_set = [&of_a[..], &["-o", "set"]].concat();
    refused(at, &to_set, &["set: is the folder of a generated set"]);
    let mut args = args.to_vec();
    args.pop();
    args.push("set");
    refused(at, &args, &["set: is the folder of a generated set"]);
    let files = ["starbreak", "starbreak/run.json"];
    assert_eq!(crate::program::names(&at.join("set")), files, "as it was");
}

#[test]
fn labels_that_end_before_the_clip_are_warned_about() {
    let dir = scene();
    let at = dir.path();
    let whole = succeed(at, &of_a("clean/a.json", "cracked/a.json"));
    assert!(!whole.stderr.contains("the labels end"), "{whole:?}");
    let mut track = track_file("a.mp4", 10, None);
    let more = json!({"frame_idx": N, "time_s": 3.0, "state": "still"});
    track["frames"].as_array_mut().unwrap().push(more);
    track["n_frames"] = json!(N + 1);
    write(at, "tracks/a.track.json", &track);
    let args = of_a("clean/a.json", "cracked/a.json");
    warned(
        at,
        &args,
        "the labels end at frame 29, the clip has 31 frames",
    );
}
