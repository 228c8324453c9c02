//! `starbreak generate` with a lens that distorts: sets are the same however they are made, and what cannot be moved is
//! refused.

use std::fs;
use std::path::Path;

use crate::moved::{
    BOXES, LENSES, args, box_at, generate, painted, write, write_kitti, write_sets,
};
use crate::program::{all_refused, folder, json, names, snapshot, starbreak, succeed};
use serde_json::{Value, json};

#[test]
fn detections_are_not_held_against_labels_that_lie_elsewhere() {
    let dir = folder();
    let root = dir.path();
    write_sets(root, &BOXES);
    fs::write(root.join("found.json"), "[]").unwrap();
    for (percent, is_refused) in [("30", true), ("0", false)] {
        let lens = [&*format!("distortion.corner_percent={percent}")];
        let out = format!("out{percent}");
        generate(root, "coco:coco", &out, &lens, &["--on-error", "skip"]);
        let set = format!("coco:{out}");
        let found = ["--clean", "found.json", "--damaged", "found.json"];
        for args in [
            vec!["evaluate", "coco:coco", "--damaged-set", &out],
            vec!["evaluate", &set],
        ] {
            let args = [&args[..], &found].concat();
            let outcome = starbreak(root, &args);
            let says = outcome.stderr.contains("have no labels in common");
            assert_eq!(says, is_refused, "{args:?}: {}", outcome.stderr);
            assert_eq!(outcome.code == Some(2), is_refused, "{}", outcome.stderr);
        }
        succeed(root, &["evaluate", &set, "--clean", "found.json"]);
    }
}

#[test]
fn moved_sets_are_the_same_however_they_are_made() {
    let dir = folder();
    let root = dir.path();
    write_sets(root, &BOXES);
    write_kitti(root);
    let lens = ["distortion.corner_percent=30"];
    let skip = ["--on-error", "skip"];
    for (source, label) in [
        ("kitti:in", "label_2/000001.txt"),
        ("coco:coco", "annotations/instances_val.json"),
    ] {
        let [out, merged, shards] =
            ["out", "merged", "shard"].map(|name| format!("{name}-{}", &source[..4]));
        generate(
            root,
            source,
            &out,
            &lens,
            &[&skip[..], &["--threads", "2"]].concat(),
        );
        let whole = snapshot(&root.join(&out));
        let again = generate(
            root,
            source,
            &out,
            &lens,
            &[&skip[..], &["--json"]].concat(),
        );
        let report: Value = serde_json::from_str(&again.stdout).unwrap();
        assert_eq!(report["n_made"], 0, "all are kept: {report}");
        assert!(snapshot(&root.join(&out)) == whole, "as they were");
        // A run that was interrupted before the end.
        for name in ["starbreak/manifest.json", "starbreak/files.jsonl", label] {
            fs::remove_file(root.join(&out).join(name)).unwrap();
        }
        generate(
            root,
            source,
            &out,
            &lens,
            &[&skip[..], &["--threads", "1"]].concat(),
        );
        assert!(snapshot(&root.join(&out)) == whole, "resumed");
        let checked = ["verify", &out, "--regenerate", "all", "--source", source];
        succeed(root, &checked);
        let parts: Vec<String> = (1..=2).map(|k| format!("{shards}{k}")).collect();
        for (k, part) in parts.iter().enumerate() {
            let shard = format!("{}/2", k + 1);
            generate(
                root,
                source,
                part,
                &lens,
                &[&skip[..], &["--shard", &shard]].concat(),
            );
        }
        succeed(root, &["merge", &parts[0], &parts[1], "-o", &merged]);
        let mut both = [snapshot(&root.join(&merged)), whole];
        for set in &mut both {
            set.retain(|path, _| {
                !path.starts_with("starbreak/made.jsonl") && !path.starts_with("starbreak/lock")
            });
        }
        assert!(
            both[0] == both[1],
            "{:?}, {:?}",
            names(&root.join(&merged)),
            names(&root.join(&out))
        );
    }
    // Labels of images that are taken alone, and only of these.
    generate(
        root,
        "kitti:in",
        "some",
        &lens,
        &[&skip[..], &["--limit", "2"]].concat(),
    );
    assert_eq!(
        names(&root.join("some/label_2")),
        ["000000.txt", "000001.txt"]
    );
}

/// Changes one label of a set of MS-COCO and of BDD100K.
fn set_label(root: &Path, member: &str, value: &Value) {
    write_sets(root, &BOXES);
    let index = root.join("coco/annotations/instances_val.json");
    let mut coco = json(&index);
    coco["annotations"][1][member] = value.clone();
    fs::write(index, coco.to_string()).unwrap();
    let index = root.join("bdd/labels/det_20/det_val.json");
    let mut bdd = json(&index);
    bdd[1]["labels"][0][member] = value.clone();
    fs::write(index, bdd.to_string()).unwrap();
}

#[test]
fn labels_that_cannot_be_moved_are_refused_before_anything_is_written() {
    let dir = folder();
    let root = dir.path();
    let lens = LENSES[0];
    for (format, member, value, named) in [
        ("coco", "dp_x", json!([1, 2, 3]), "annotation 2: its dp_x"),
        (
            "coco",
            "segmentation",
            json!([[1, 2, 3]]),
            "annotation 2: its segmentation",
        ),
        (
            "coco",
            "segmentation",
            json!({ "size": [2, 2], "counts": [1] }),
            "annotation 2: its segmentation (runs of 1",
        ),
        (
            "coco",
            "segmentation",
            json!("a.png"),
            "annotation 2: its segmentation, which is neither",
        ),
        (
            "coco",
            "keypoints",
            json!([1, 2]),
            "annotation 2: its keypoints of 2 numbers",
        ),
        (
            "bdd",
            "box3d",
            json!({ "location": [1, 2, 3] }),
            "frame images/100k/val/1.png, label a: its box3d",
        ),
        (
            "bdd",
            "rle",
            json!({ "counts": "0", "size": [1, 1] }),
            "label a: its rle",
        ),
        ("bdd", "graph", json!({ "nodes": [] }), "label a: its graph"),
        ("bdd", "skeleton", json!([[1, 2]]), "label a: its skeleton"),
    ] {
        set_label(root, member, &value);
        let source = format!("{format}:{format}");
        let cases = [
            args(&source, "out", lens, &[]),
            args(&source, "out", lens, &["--dry-run"]),
        ];
        all_refused(root, &cases.map(|args| (args, named)));
        // An image that is not taken has labels that nobody needs.
        generate(
            root,
            &source,
            &format!("{format}-{member}-first"),
            lens,
            &["--limit", "1"],
        );
        let _ = fs::remove_dir_all(root.join(format!("{format}-{member}-first")));
    }
    // What the header of an image alone tells ends the run, and leaves no part of the index.
    set_label(
        root,
        "segmentation",
        &json!({ "size": [10, 10], "counts": [100] }),
    );
    let outcome = starbreak(root, &args("coco:coco", "out", lens, &[]));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(
        outcome
            .stderr
            .contains("annotation 2: its mask of 10 x 10 px in an image of 320 x 200 px"),
        "{outcome:?}"
    );
    assert!(
        names(&root.join("out"))
            .iter()
            .all(|name| !name.contains("annotations/")),
        "no index"
    );
    assert!(
        !root.join("out/starbreak/manifest.json").exists(),
        "the set is not finished"
    );
}

#[test]
fn other_files_may_hold_labels_that_would_stay() {
    let dir = folder();
    let root = dir.path();
    write_sets(root, &BOXES);
    write(root, "coco/annotations/captions_val.json", "{}");
    write(root, "kitti/calib/000000.txt", "P0: 1 2 3\n");
    write(root, "folder/a.png", painted(box_at(BOXES[0])));
    write(root, "folder/notes.txt", "mine");
    for (source, named) in [
        ("coco:coco", "captions_val.json"),
        ("kitti:kitti", "calib/000000.txt"),
    ] {
        all_refused(root, &[(args(source, "out", LENSES[0], &[]), named)]);
        generate(root, source, "out", LENSES[0], &["--other-files", "skip"]);
        assert!(
            !names(&root.join("out"))
                .iter()
                .any(|name| name.ends_with(named)),
            "left out"
        );
        fs::remove_dir_all(root.join("out")).unwrap();
    }
    // Where nothing is known of labels, nothing is moved.
    generate(root, "folder:folder", "out", LENSES[0], &[]);
    assert_eq!(fs::read(root.join("out/notes.txt")).unwrap(), b"mine");
    // A broken image has no size: its labels go with it, and the run says so.
    write(root, "kitti/image_2/000001.png", "no image");
    write(root, "coco/val/1.png", "no image");
    for (source, out) in [("kitti:kitti", "broken-k"), ("coco:coco", "broken-c")] {
        let outcome = starbreak(
            root,
            &args(source, out, LENSES[0], &["--other-files", "skip"]),
        );
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
    }
    assert_eq!(
        names(&root.join("broken-k/label_2")),
        ["000000.txt", "000002.txt", "000003.txt"]
    );
    let index = json(&root.join("broken-c/annotations/instances_val.json"));
    let ids = |list: &str, key: &str| {
        index[list]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| it[key].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(ids("images", "id"), [1, 3, 4], "{index}");
    assert_eq!(ids("annotations", "image_id"), [1, 3, 4], "{index}");
}
