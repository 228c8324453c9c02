//! `starbreak timeline`: objects over the frames of a clip, by hand-made labels and detections.

use std::fs;
use std::path::Path;

use crate::program::{all_refused, folder, json, repeated_keys, snapshot, starbreak, succeed};
use serde_json::{Value, json};

/// Frames of the clip.
const N: u64 = 20;
/// The first with damage, at 0.8 s.
const ONSET: u64 = 8;

/// Where object `k` is in a frame: each drives along its own lane.
fn corners(object: u64, frame: u64) -> [f64; 4] {
    let (x, y) = (2.0 * frame as f64, 40.0 * object as f64);
    [x, y, x + 30.0, y + 20.0]
}

/// Whether the cracked clip shows object `k`: 1 is lost at frame 10, 2 at the onset, 3 flickers,
/// 4 stays.
fn is_found_cracked(object: u64, frame: u64) -> bool {
    match object {
        1 => frame < 10,
        2 => frame < ONSET,
        3 => frame < ONSET || !frame.is_multiple_of(3),
        _ => true,
    }
}

fn track_file(n_frames: u64, name: &str) -> Value {
    let state = |k: u64| match k {
        0..ONSET => "intact",
        ONSET..12 => "growing",
        _ => "still",
    };
    let frames: Vec<Value> = (0..n_frames)
        .map(|k| json!({"frame_idx": k, "time_s": k as f64 / 10.0, "state": state(k)}))
        .collect();
    let onset = json!({"frame_idx": ONSET, "time_s": ONSET as f64 / 10.0});
    json!({
        "schema": "starbreak.track/1", "n_frames": n_frames, "fps": 10.0, "width_px": 200, "height_px": 240,
        "input": {"name": name, "kind": "clip", "sha256": "00"}, "output": {"name": "out.mp4"},
        "damage_onset": if n_frames > ONSET { onset } else { Value::Null }, "frames": frames,
    })
}

/// Labels of MS-COCO with the keys of CocoVID, images numbered from 101.
fn coco(clip: &str) -> Value {
    let mut annotations = Vec::new();
    for frame in 0..N {
        for object in 1..=4 {
            let [x, y, x1, y1] = corners(object, frame);
            annotations.push(json!({
                "id": annotations.len() + 1, "image_id": 101 + frame, "category_id": 3, "instance_id": 70 + object,
                "bbox": [x, y, x1 - x, y1 - y], "area": 600.0, "iscrowd": 0,
            }));
        }
    }
    let image = |k: u64| {
        json!({"id": 101 + k, "file_name": format!("{k}.png"), "width": 200, "height": 240, "video_id": 9,
            "frame_id": k})
    };
    json!({
        "videos": [{"id": 9, "name": clip}], "images": (0..N).map(image).collect::<Vec<_>>(),
        "categories": [{"id": 3, "name": "car"}], "annotations": annotations,
    })
}

fn coco_results(first_id: u64, is_found: impl Fn(u64, u64) -> bool) -> Value {
    let mut list = Vec::new();
    for frame in 0..N {
        for object in (1..=4).filter(|k| is_found(*k, frame)) {
            let [x, y, x1, y1] = corners(object, frame);
            list.push(json!({
                "image_id": first_id + frame, "category_id": 3, "bbox": [x, y, x1 - x, y1 - y], "score": 0.8,
            }));
        }
    }
    Value::Array(list)
}

fn scalabel(clip: &str, is_result: bool, is_found: impl Fn(u64, u64) -> bool) -> Value {
    let frame = |k: u64| {
        let labels: Vec<Value> = (1..=4)
            .filter(|object| is_found(*object, k))
            .map(|object| {
                let [x1, y1, x2, y2] = corners(object, k);
                let mut label = json!({"id": format!("0000{object}"), "category": "car",
                    "box2d": {"x1": x1, "y1": y1, "x2": x2, "y2": y2}});
                if is_result {
                    label["score"] = json!(0.8);
                }
                label
            })
            .collect();
        json!({"name": format!("{clip}-{k:07}.jpg"), "videoName": clip, "frameIndex": k, "labels": labels})
    };
    Value::Array((0..N).map(frame).collect())
}

fn write(dir: &Path, name: &str, value: &Value) {
    fs::write(dir.join(name), value.to_string()).unwrap();
}

/// A folder with the clip in every form.
fn scene() -> tempfile::TempDir {
    let dir = folder();
    let at = dir.path();
    write(at, "drive.track.json", &track_file(N, "drive.mp4"));
    write(at, "labels.json", &coco("drive"));
    write(at, "clean.json", &coco_results(101, |_, _| true));
    write(at, "cracked.json", &coco_results(101, is_found_cracked));
    dir
}

const ARGS: [&str; 8] = [
    "timeline",
    "labels.json",
    "--clean",
    "clean.json",
    "--cracked",
    "cracked.json",
    "--track",
    "drive.track.json",
];

/// The one clip in the result of a command line.
fn clip_of(at: &Path, args: &[&str]) -> Value {
    let outcome = succeed(at, &[args, &["--json", "--replicates", "50"]].concat());
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["timelines"].as_array().unwrap().len(), 1, "{result}");
    result["timelines"][0].clone()
}

fn fates(timeline: &Value) -> Vec<String> {
    let fate = |row: &Value| match row["fate"]["kind"].as_str().unwrap() {
        "lost" => format!(
            "lost {} {:.1}",
            row["fate"]["frame_idx"],
            row["fate"]["after_s"].as_f64().unwrap()
        ),
        kind => kind.to_owned(),
    };
    timeline["tracks"]
        .as_array()
        .unwrap()
        .iter()
        .map(fate)
        .collect()
}

#[test]
fn what_is_lost_when_is_what_was_made_so() {
    let dir = scene();
    let clip = clip_of(dir.path(), &[&ARGS[..], &["-o", "out"]].concat());
    assert_eq!(
        fates(&clip["cracked"]),
        ["lost 10 0.2", "lost 8 0.0", "kept", "kept"]
    );
    assert_eq!(fates(&clip["clean"]), ["kept"; 4], "the control");
    let names: Vec<&str> = clip["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["71", "72", "73", "74"], "names of the labels");
    assert_eq!(clip["cracked"]["damage_onset"]["time_s"], json!(0.8));
    // By hand: objects 1 to 4 are found in 2, 0, 8 and 12 of 12 frames from the onset on.
    let found = clip["cracked"]["after"]["found"]["value"].as_f64().unwrap();
    assert!((found - 22.0 / 48.0).abs() < 1e-12, "{found}");
    let change = clip["change"]["found"]["value"].as_f64().unwrap();
    assert!((change - (22.0 / 48.0 - 1.0)).abs() < 1e-12, "{change}");
    let median_s = clip["cracked"]["survival"]["median_s"]["value"].as_f64();
    assert!((median_s.unwrap() - 0.2).abs() < 1e-12, "half of four");
    assert_eq!(clip["cracked"]["frames"][9]["state"], json!("growing"));
    let mut files: Vec<_> = fs::read_dir(dir.path().join("out"))
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    files.sort();
    assert_eq!(
        files,
        [
            "evaluation.json",
            "numbers.csv",
            "report.html",
            "written.json"
        ]
    );
    let written = json(&dir.path().join("out/evaluation.json"));
    assert_eq!(
        written["evaluations"][0]["timelines"][0], clip,
        "the same in the file"
    );
    let csv = fs::read_to_string(dir.path().join("out/numbers.csv")).unwrap();
    assert!(
        csv.contains("median_time_to_failure_s_cracked[drive]"),
        "{csv}"
    );
    let none: [String; 0] = [];
    assert_eq!(repeated_keys(&csv), none, "each number once");
    let page = fs::read_to_string(dir.path().join("out/report.html")).unwrap();
    for said in [
        "damage at 0.80 s",
        "lost in frame 10, after 0.20 s",
        "objects not lost",
    ] {
        assert!(page.contains(said), "the page says {said:?}");
    }
}

#[test]
fn every_form_of_labels_and_detections_gives_the_same_fates() {
    let dir = scene();
    let at = dir.path();
    let expected = fates(&clip_of(at, &ARGS)["cracked"]);
    // Scalabel, by names.
    write(at, "s.json", &scalabel("drive", false, |_, _| true));
    write(at, "s_clean.json", &scalabel("drive", true, |_, _| true));
    write(
        at,
        "s_cracked.json",
        &scalabel("drive", true, is_found_cracked),
    );
    let track = ["--track", "drive.track.json"];
    let sides = ["--clean", "s_clean.json", "--cracked", "s_cracked.json"];
    let of_scalabel = clip_of(at, &[&["timeline", "s.json"], &sides[..], &track].concat());
    assert_eq!(fates(&of_scalabel["cracked"]), expected, "Scalabel");
    // By frame, as `detect clip:` numbers them.
    write(at, "f_clean.json", &coco_results(1, |_, _| true));
    write(at, "f_cracked.json", &coco_results(1, is_found_cracked));
    let sides = [
        "--clean",
        "f_clean.json",
        "--cracked",
        "f_cracked.json",
        "--by-frame",
    ];
    let by_frame = clip_of(
        at,
        &[&["timeline", "labels.json"], &sides[..], &track].concat(),
    );
    assert_eq!(fates(&by_frame["cracked"]), expected, "by frame");
    // KITTI's tracking benchmark, with results as a folder of frames.
    let mut rows =
        String::from("0 -1 DontCare -1 -1 -10 150 200 190 230 -1 -1 -1 -1000 -1000 -1000 -10\n");
    for frame in 0..N {
        for object in 1..=4 {
            let [x0, y0, x1, y1] = corners(object, frame);
            rows.push_str(&format!(
                "{frame} {object} Car 0 0 -1 {x0} {y0} {x1} {y1} 1 1 1 0 0 0 0\n"
            ));
        }
    }
    fs::create_dir_all(at.join("label_02")).unwrap();
    fs::write(at.join("label_02/drive.txt"), rows).unwrap();
    for (name, is_clean) in [("k_clean", true), ("k_cracked", false)] {
        fs::create_dir_all(at.join(name)).unwrap();
        for frame in 0..N {
            let mut rows = String::new();
            for object in (1..=4).filter(|k| is_clean || is_found_cracked(*k, frame)) {
                let [x0, y0, x1, y1] = corners(object, frame);
                rows.push_str(&format!(
                    "Car -1 -1 -10 {x0} {y0} {x1} {y1} -1 -1 -1 -1000 -1000 -1000 -10 0.8\n"
                ));
            }
            fs::write(at.join(name).join(format!("frame_{frame:06}.txt")), rows).unwrap();
        }
    }
    let sides = ["--clean", "k_clean", "--cracked", "k_cracked"];
    let of_kitti = clip_of(
        at,
        &[&["timeline", "label_02"], &sides[..], &track].concat(),
    );
    assert_eq!(fates(&of_kitti["cracked"]), expected, "KITTI");
    // A clip from elsewhere: no track, the onset by a flag.
    let plain = ["--fps", "10", "--onset-frame", "8"];
    let mut args = ARGS[..6].to_vec();
    args.extend(plain);
    assert_eq!(fates(&clip_of(at, &args)["cracked"]), expected, "no track");
    // Another onset than the track's, and states that no longer hold are gone.
    let later = clip_of(at, &[&ARGS[..], &["--onset-frame", "9"]].concat());
    assert_eq!(later["cracked"]["damage_onset"]["frame_idx"], json!(9));
    assert_eq!(later["cracked"]["frames"][0]["state"], Value::Null);
}

#[test]
fn faults_that_break_no_glass_begin_where_their_track_says() {
    let dir = scene();
    let mut track = track_file(N, "drive.mp4");
    for frame in track["frames"].as_array_mut().unwrap() {
        frame["state"] = json!("intact");
    }
    write(dir.path(), "foggy.track.json", &track);
    let mut args = ARGS;
    args[7] = "foggy.track.json";
    let clip = clip_of(dir.path(), &args);
    assert_eq!(clip["cracked"]["damage_onset"]["frame_idx"], json!(ONSET));
    assert_eq!(
        fates(&clip["cracked"]),
        ["lost 10 0.2", "lost 8 0.0", "kept", "kept"]
    );
}

#[test]
fn without_labels_the_clean_detections_are_the_objects_and_that_is_said() {
    let dir = scene();
    let at = dir.path();
    write(at, "f_clean.json", &coco_results(1, |_, _| true));
    write(at, "f_cracked.json", &coco_results(1, is_found_cracked));
    let args = [
        "timeline",
        "--clean",
        "f_clean.json",
        "--cracked",
        "f_cracked.json",
        "--track",
        "drive.track.json",
    ];
    let outcome = succeed(at, &[&args[..], &["-o", "out", "--json"]].concat());
    assert!(
        outcome.stderr.contains("there are no labels"),
        "{outcome:?}"
    );
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let clip = &result["timelines"][0];
    assert_eq!(clip["truth"]["kind"], json!("clean_detections"));
    assert!(
        result["warnings"][0]["text"]
            .as_str()
            .unwrap()
            .contains("no labels"),
        "{result}"
    );
    let mut all = fates(&clip["cracked"]);
    all.sort();
    assert_eq!(all, ["kept", "kept", "lost 10 0.2", "lost 8 0.0"]);
    let page = fs::read_to_string(at.join("out/report.html")).unwrap();
    assert!(page.contains("There are no labels"), "the page says so");
}

#[test]
fn of_several_clips_those_with_a_track_are_looked_at() {
    let dir = scene();
    let at = dir.path();
    let both = |is_result: bool, is_found: fn(u64, u64) -> bool| {
        let mut list = Vec::new();
        for clip in ["drive", "walk"] {
            list.extend(
                scalabel(clip, is_result, is_found)
                    .as_array()
                    .unwrap()
                    .clone(),
            );
        }
        Value::Array(list)
    };
    write(at, "two.json", &both(false, |_, _| true));
    write(at, "clean2.json", &both(true, |_, _| true));
    write(at, "cracked2.json", &both(true, is_found_cracked));
    fs::create_dir(at.join("tracks")).unwrap();
    write(
        &at.join("tracks"),
        "a.track.json",
        &track_file(N, "drive.mp4"),
    );
    write(
        &at.join("tracks"),
        "b.track.json",
        &track_file(N, "walk.mov"),
    );
    let args = [
        "timeline",
        "two.json",
        "--clean",
        "clean2.json",
        "--cracked",
        "cracked2.json",
        "--json",
    ];
    let run = |more: &[&str]| -> Vec<String> {
        let outcome = succeed(at, &[&args[..], more].concat());
        let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
        let clips = result["timelines"].as_array().unwrap();
        clips
            .iter()
            .map(|clip| clip["clip"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(run(&["--track", "tracks"]), ["drive", "walk"], "all");
    assert_eq!(
        run(&["--track", "tracks", "--clip", "walk"]),
        ["walk"],
        "one"
    );
    assert_eq!(
        run(&["--track", "tracks/a.track.json"]),
        ["drive"],
        "the one with a track"
    );
    assert_eq!(
        run(&["--track", "walk=tracks/a.track.json"]),
        ["walk"],
        "as said"
    );
}

#[test]
fn what_does_not_belong_together_is_refused_in_one_line() {
    let dir = scene();
    let at = dir.path();
    write(at, "other.track.json", &track_file(N, "holiday.mp4"));
    write(at, "short.track.json", &track_file(12, "drive.mp4"));
    let mut sized = track_file(N, "drive.mp4");
    sized["width_px"] = json!(640);
    write(at, "sized.track.json", &sized);
    let mut miscounted = track_file(N, "drive.mp4");
    miscounted["n_frames"] = json!(99);
    write(at, "miscounted.track.json", &miscounted);
    for (name, fps) in [("negative", -5.0), ("zero", 0.0), ("fast", 1e308)] {
        let mut rated = track_file(N, "drive.mp4");
        rated["fps"] = json!(fps);
        write(at, &format!("{name}.track.json"), &rated);
    }
    let mut two_onsets = track_file(N, "drive.mp4");
    two_onsets["damage_onset"]["frame_idx"] = json!(3);
    write(at, "two_onsets.track.json", &two_onsets);
    let mut backwards = track_file(N, "drive.mp4");
    backwards["frames"][4]["time_s"] = json!(0.0);
    write(at, "backwards.track.json", &backwards);
    for (name, frame, key, value) in [
        ("healed", 14, "state", json!("intact")),
        ("endless", 19, "time_s", json!(1e300)),
    ] {
        let mut track = track_file(N, "drive.mp4");
        track["frames"][frame][key] = value;
        write(at, &format!("{name}.track.json"), &track);
    }
    let mut torn = track_file(N, "drive.mp4");
    torn["damage_onset"]["time_s"] = json!(0.2);
    write(at, "torn.track.json", &torn);
    fs::write(at.join("text.track.json"), "no json\nat all").unwrap();
    let change = |name: &str, change: fn(&mut Value)| {
        let mut labels = coco("drive");
        change(&mut labels);
        write(at, name, &labels);
    };
    change("none.json", |labels| {
        for row in labels["annotations"].as_array_mut().unwrap() {
            row.as_object_mut().unwrap().remove("instance_id");
        }
    });
    change("some.json", |labels| {
        labels["annotations"][7]
            .as_object_mut()
            .unwrap()
            .remove("instance_id");
    });
    change("twice.json", |labels| {
        labels["annotations"][1]["instance_id"] = json!(71)
    });
    change("boxes.json", |labels| {
        for (k, row) in labels["annotations"]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .enumerate()
        {
            row["instance_id"] = json!(k);
        }
    });
    change("frames.json", |labels| {
        labels["images"][3]["frame_id"] = json!(2)
    });
    let mut lost = scalabel("drive", false, |_, _| true);
    lost[2]["labels"][1].as_object_mut().unwrap().remove("id");
    write(at, "lost.json", &lost);
    let nan = coco_results(101, |_, _| true)
        .to_string()
        .replacen("0.8", "NaN", 1);
    fs::write(at.join("nan.json"), nan).unwrap();
    write(at, "beyond.json", &coco_results(119, |_, _| true));
    fs::write(at.join("k.txt"), "0 1 Car 0 0 -1 0 0 nan 9 1 1 1 0 0 0 0\n").unwrap();

    let with =
        |labels: &'static str, clean: &'static str, track: &'static str| -> Vec<&'static str> {
            vec![
                "timeline",
                labels,
                "--clean",
                clean,
                "--cracked",
                "cracked.json",
                "--track",
                track,
                "-o",
                "out",
            ]
        };
    let plain =
        |more: &[&'static str]| -> Vec<&'static str> { [&ARGS[..], &["-o", "out"], more].concat() };
    let before = snapshot(at);
    let own = "drive.track.json";
    all_refused(
        at,
        &[
            (
                with("labels.json", "clean.json", "other.track.json"),
                "holiday",
            ),
            (
                with("labels.json", "clean.json", "short.track.json"),
                "12 frames",
            ),
            (
                with("labels.json", "clean.json", "sized.track.json"),
                "640 x 240 px",
            ),
            (
                with("labels.json", "clean.json", "miscounted.track.json"),
                "n_frames = 99",
            ),
            (
                with("labels.json", "clean.json", "negative.track.json"),
                "fps = -5e0; expected frames per second from 1e-6 to 1e6",
            ),
            (
                with("labels.json", "clean.json", "healed.track.json"),
                "the glass is intact after it was Still",
            ),
            (
                with("labels.json", "clean.json", "endless.track.json"),
                "at 1e300 s is out of order",
            ),
            (
                with("labels.json", "clean.json", "torn.track.json"),
                "its damage_onset is at 0.2 s, but that frame at",
            ),
            (
                with("labels.json", "clean.json", "zero.track.json"),
                "fps = 0e0; expected",
            ),
            (
                with("labels.json", "clean.json", "fast.track.json"),
                "fps = 1e308; expected",
            ),
            (
                with("labels.json", "clean.json", "two_onsets.track.json"),
                "damage_onset is frame 3",
            ),
            (
                with("labels.json", "clean.json", "backwards.track.json"),
                "out of order",
            ),
            (
                with("labels.json", "clean.json", "text.track.json"),
                "no track of `video`",
            ),
            (
                with("labels.json", "clean.json", "labels.json"),
                "no track of `video`",
            ),
            (
                with("labels.json", "clean.json", "absent.track.json"),
                "absent.track.json",
            ),
            (with("none.json", "clean.json", own), "have no tracks"),
            (with("some.json", "clean.json", own), "has no track"),
            (with("twice.json", "clean.json", own), "twice"),
            (
                with("boxes.json", "clean.json", own),
                "no object is in two frames",
            ),
            (
                with("frames.json", "clean.json", own),
                "frame 2 of clip \"drive\" is there twice",
            ),
            (with("lost.json", "clean.json", own), "has no track"),
            (with("labels.json", "nan.json", own), "NaN"),
            (
                with("labels.json", "beyond.json", own),
                "images that the labels lack",
            ),
            (with("k.txt", "clean.json", own), "nan"),
            (plain(&["--clip", "walk"]), "no clip \"walk\""),
            (plain(&["--onset-frame", "20"]), "has 20 frames"),
            (plain(&["--score-threshold", "NaN"]), "score"),
            (plain(&["--iou", "1.5"]), "1.5"),
            (plain(&["--first-frame", "1"]), "count from 1"),
            (plain(&["--by-frame"]), "frames that the clip lacks"),
            (ARGS[..6].to_vec(), "no track"),
        ],
    );
    assert_eq!(snapshot(at), before, "nothing is written");
    let outcome = starbreak(at, &plain(&["--lost-for", "0"]));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
}
