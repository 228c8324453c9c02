//! What lies where a verb writes: files of others stay unless `--replace` is given, inputs stay always,
//! and what an earlier run has written goes.

use std::fs;
use std::path::Path;

use crate::program::{
    NO_DRAWS, QUICK_BENCH, SMALL, all_refused, folder, names, photo, png_bytes, snapshot,
    starbreak, succeed, succeed_small, write_photo,
};
use serde_json::json;

/// Labels and detections of one image, images, and a set.
fn write_inputs(dir: &Path) {
    write_photo(&dir.join("a.png"));
    fs::create_dir(dir.join("in")).unwrap();
    write_photo(&dir.join("in/a.png"));
    fs::write(dir.join("in/b.png"), png_bytes(&photo((120, 90)))).unwrap();
    let object = json!({ "id": 1, "image_id": 1, "category_id": 1, "bbox": [2.0, 2.0, 20.0, 20.0], "area": 400.0, "iscrowd": 0 });
    let labels = json!({
        "images": [{ "id": 1, "file_name": "a.png", "width": 160, "height": 100 }],
        "annotations": [object],
        "categories": [{ "id": 1, "name": "car" }],
    });
    fs::write(dir.join("labels.json"), labels.to_string()).unwrap();
    let said =
        json!([{ "image_id": 1, "category_id": 1, "bbox": [2.0, 2.0, 20.0, 20.0], "score": 0.9 }]);
    fs::write(dir.join("said.json"), said.to_string()).unwrap();
    fs::write(dir.join("text.onnx"), "no model").unwrap();
}

const EVALUATE: [&str; 5] = [
    "evaluate",
    "--ground-truth",
    "labels.json",
    "--clean",
    "said.json",
];

/// A command, and files of others where it writes.
fn writers() -> Vec<(Vec<&'static str>, &'static str)> {
    let small = |args: &[&'static str]| [args, &SMALL].concat();
    let crack = small(&["crack", "a.png", "-o", "out"]);
    let sweep = small(&[
        "sweep",
        "a.png",
        "-o",
        "out",
        "--over",
        "output.masks=true,false",
    ]);
    let demo = small(&["demo", "-o", "out"]);
    let frames = small(&[
        "simulate",
        "--frames",
        "2",
        "--frames-to",
        "out",
        "-o",
        "n.json",
    ]);
    let evaluate = [&EVALUATE, &["-o", "out", "--curves", "curves"][..]].concat();
    let divergence = [
        &["divergence", "folder:in", "b=folder:in"][..],
        &NO_DRAWS,
        &["-o", "out"],
    ]
    .concat();
    let bench = [&QUICK_BENCH[..], &["-o", "out"]].concat();
    vec![
        (crack.clone(), "out/a.png"),
        (crack.clone(), "out/a.json"),
        (crack, "out/a.region.png"),
        (sweep.clone(), "out/a.sweep.png"),
        (sweep.clone(), "out/a.sweep.csv"),
        (sweep, "out/a.01-true.json"),
        (demo.clone(), "out/scene.png"),
        (demo.clone(), "out/growth.png"),
        (demo, "out/recipe.toml"),
        (small(&["simulate", "-o", "n.json"]), "n.json"),
        (
            small(&["simulate", "-o", "n.json", "--svg", "n.svg"]),
            "n.svg",
        ),
        (frames, "out/frame_00002.png"),
        (
            small(&["patterns", "-n", "1", "-o", "out", "--size", "90x60"]),
            "out/statistics.csv",
        ),
        (
            small(&["generate", "folder:in", "-o", "set", "--dry-run"]),
            "set.preview.png",
        ),
        (
            small(&["video", "in2", "--fps", "10", "-o", "clip"]),
            "clip.track.json",
        ),
        (evaluate.clone(), "out/table.tex"),
        (evaluate.clone(), "out/report.html"),
        (evaluate, "curves/clean/precision.npy"),
        (divergence, "out/divergence.csv"),
        (bench, "out/bench.txt"),
        (vec!["man", "-o", "out"], "out/starbreak-crack.1"),
    ]
}

#[test]
fn files_of_others_stay_unless_they_are_to_be_replaced() {
    let mut complaints = Vec::new();
    for (args, place) in writers() {
        let dir = folder();
        write_inputs(dir.path());
        fs::create_dir(dir.path().join("in2")).unwrap();
        write_photo(&dir.path().join("in2/f1.png"));
        let place = dir.path().join(place);
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        // As others have it: a picture, or a text.
        let theirs = match place.extension().unwrap().to_str() {
            Some("png") => png_bytes(&photo((30, 20))),
            Some("json") => b"{\"schema\": \"other/1\"}\n".to_vec(),
            _ => b"of somebody else\n".to_vec(),
        };
        fs::write(&place, &theirs).unwrap();
        let before = snapshot(dir.path());
        let refused = starbreak(dir.path(), &args);
        let name = place.file_name().unwrap().to_str().unwrap();
        if let Some(complaint) = refused.complaint(name) {
            // A note may stand before the error.
            if refused.code != Some(2) || !refused.stderr.contains("--replace") {
                complaints.push(format!("{args:?} over {name}: {complaint}"));
            }
        }
        if snapshot(dir.path()) != before {
            complaints.push(format!("{args:?} over {name}: the folder changed"));
            fs::write(&place, &theirs).unwrap();
        }
        let replaced = starbreak(dir.path(), &[&args[..], &["--replace"]].concat());
        if replaced.code != Some(0) || fs::read(&place).unwrap() == theirs {
            complaints.push(format!("{args:?} over {name} with --replace: {replaced:?}"));
        }
    }
    assert!(
        complaints.is_empty(),
        "{} complaints:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}

#[test]
fn the_same_command_again_is_no_hindrance() {
    let mut complaints = Vec::new();
    for (args, place) in writers() {
        // Measured and encoded anew each time: not known by their bytes.
        if args[0] == "bench"
            || args[0] == "video"
            || args[0] == "patterns"
            || args[0] == "divergence"
        {
            continue;
        }
        let dir = folder();
        write_inputs(dir.path());
        succeed(dir.path(), &args);
        let before = names(dir.path());
        let again = starbreak(dir.path(), &args);
        if again.code != Some(0) || names(dir.path()) != before {
            complaints.push(format!("{args:?} ({place}): {again:?}"));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn inputs_stay_whatever_is_to_be_replaced() {
    let dir = folder();
    write_inputs(dir.path());
    fs::create_dir(dir.path().join("coco")).unwrap();
    fs::create_dir(dir.path().join("coco/annotations")).unwrap();
    fs::create_dir(dir.path().join("coco/val2017")).unwrap();
    write_photo(&dir.path().join("coco/val2017/a.png"));
    let index = dir.path().join("coco/annotations/instances_val2017.json");
    fs::copy(dir.path().join("labels.json"), &index).unwrap();
    fs::create_dir(dir.path().join("mine")).unwrap();
    fs::copy(
        dir.path().join("labels.json"),
        dir.path().join("mine/evaluation.json"),
    )
    .unwrap();
    let detect = |out: &'static str, more: &[&'static str]| -> Vec<&'static str> {
        [
            &["detect", "--model", "text.onnx", "coco:coco", "-o", out],
            more,
        ]
        .concat()
    };
    let evaluate = |gt: &'static str, out: &'static str| -> Vec<&'static str> {
        let args = [
            "evaluate",
            "--ground-truth",
            gt,
            "--clean",
            "said.json",
            "-o",
            out,
            "--replace",
        ];
        args.to_vec()
    };
    let is_input = "would replace the input";
    // Said before it is read: it holds no labels.
    fs::write(dir.path().join("mine/table.tex"), "no labels").unwrap();
    let labels = "coco/annotations/instances_val2017.json";
    all_refused(
        dir.path(),
        &[
            (detect(labels, &[]), "--replace"),
            (detect("coco/val2017/a.png", &[]), "--replace"),
            (detect(labels, &["--replace"]), is_input),
            (detect("coco/val2017/a.png", &["--replace"]), is_input),
            (
                detect("coco", &["--format", "kitti", "--replace"]),
                is_input,
            ),
            (detect("text.onnx", &["--replace"]), is_input),
            (evaluate("mine/evaluation.json", "mine"), is_input),
            (evaluate("mine/table.tex", "mine"), is_input),
        ],
    );
}

#[test]
fn what_an_earlier_run_has_written_goes_and_what_was_altered_since_stays() {
    let dir = folder();
    write_inputs(dir.path());
    let crack = |more: &[&str]| {
        let mesh = [
            "--set",
            "fracture.particles=300",
            "--set",
            "fracture.neighbour_radius_px=20",
        ];
        let args = [
            &["crack", "a.png", "-o", "out", "--preset", "paper"],
            &mesh[..],
            more,
        ]
        .concat();
        starbreak(dir.path(), &args)
    };
    assert_eq!(crack(&[]).code, Some(0), "first");
    assert_eq!(
        crack(&["--seed", "5"]).code,
        Some(0),
        "another crack in the place of the first"
    );
    let maskless = crack(&["--set", "output.masks=false"]);
    assert_eq!(maskless.code, Some(0), "{maskless:?}");
    let out = dir.path().join("out");
    assert_eq!(
        names(&out),
        ["a.json", "a.png"],
        "the masks of the first run are gone"
    );

    write_photo(&out.join("a.png"));
    let refused = crack(&[]);
    assert_eq!(
        refused.code,
        Some(2),
        "a picture that was altered since: {refused:?}"
    );
    assert_eq!(
        fs::read(out.join("a.png")).unwrap(),
        png_bytes(&photo((160, 100))),
        "stays"
    );
    assert_eq!(crack(&["--replace"]).code, Some(0), "unless it is to go");
}

#[test]
fn no_stale_frames_or_steps_stay_among_new_ones() {
    let dir = folder();
    write_inputs(dir.path());
    for n in ["5", "3"] {
        succeed_small(
            dir.path(),
            &[
                "simulate",
                "-o",
                "n.json",
                "--frames",
                n,
                "--frames-to",
                "frames",
            ],
        );
    }
    let frames = [
        "frame_00001.png",
        "frame_00002.png",
        "frame_00003.png",
        "written.json",
    ];
    assert_eq!(
        names(&dir.path().join("frames")),
        frames,
        "of the second run"
    );

    let sweep = |over: &str| {
        let more = ["sweep", "a.png", "-o", "swept", "--over", over, "--replace"];
        succeed_small(dir.path(), &more);
    };
    fs::create_dir(dir.path().join("swept")).unwrap();
    fs::write(dir.path().join("swept/a.07-mine.json"), "{}").unwrap();
    sweep("optics.sun_azimuth_deg=10,20,30");
    sweep("optics.sun_azimuth_deg=10");
    let steps: Vec<String> = names(&dir.path().join("swept"));
    let n_steps = steps.iter().filter(|name| name.ends_with(".json")).count();
    assert_eq!(
        n_steps, 2,
        "one of the sweep, one of somebody else: {steps:?}"
    );
}

#[test]
fn nothing_is_written_into_a_generated_set() {
    let dir = folder();
    write_inputs(dir.path());
    succeed_small(dir.path(), &["generate", "folder:in", "-o", "set"]);
    let before = snapshot(dir.path());
    for (args, _) in writers() {
        let args: Vec<&str> = args
            .iter()
            .map(|arg| match *arg {
                "out" | "curves" => "set/sub",
                "n.json" => "set/n.json",
                "n.svg" => "set/n.svg",
                "clip" => "set/clip",
                "in2" => "in",
                "set" => "set/inner",
                other => other,
            })
            .collect();
        let outcome = starbreak(dir.path(), &[&args[..], &["--replace"]].concat());
        assert_eq!(outcome.code, Some(2), "{args:?}: {outcome:?}");
    }
    let detect = [
        "detect",
        "--model",
        "text.onnx",
        "folder:set",
        "-o",
        "set/said.json",
    ];
    assert_eq!(starbreak(dir.path(), &detect).code, Some(2), "detect");
    assert!(snapshot(dir.path()) == before, "nothing is written");
    succeed(dir.path(), &["verify", "set"]);
}
