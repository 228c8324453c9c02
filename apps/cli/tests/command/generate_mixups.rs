//! What `starbreak generate` must never deliver: images without a crack, files of another set,
//! labels of another image.

use std::fs;
use std::path::Path;

use crate::program::{
    Outcome, SMALL, all_refused, folder, json, names, snapshot, starbreak, succeed, write_photo,
};
use serde_json::{Value, json};

fn args<'a>(source: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["generate", source, "-o", out], more, &SMALL].concat()
}

fn generate(dir: &Path, source: &str, out: &str, more: &[&str]) -> Outcome {
    starbreak(dir, &args(source, out, more))
}

fn write_kitti(root: &Path, n: usize) {
    for sub in ["image_2", "label_2"] {
        fs::create_dir_all(root.join(sub)).unwrap();
    }
    for k in 0..n {
        write_photo(&root.join(format!("image_2/{k:06}.png")));
        fs::write(root.join(format!("label_2/{k:06}.txt")), "").unwrap();
    }
}

fn write_coco(root: &Path, images: &Value, annotations: &Value) {
    fs::create_dir_all(root.join("annotations")).unwrap();
    fs::create_dir_all(root.join("val")).unwrap();
    let index = json!({ "images": images, "annotations": annotations,
        "categories": [{ "id": 1, "name": "car", "supercategory": "vehicle" }] });
    fs::write(
        root.join("annotations/instances_val.json"),
        index.to_string(),
    )
    .unwrap();
}

fn image(id: u32, name: &str) -> Value {
    json!({ "id": id, "file_name": name, "width": 160, "height": 100 })
}

#[test]
fn a_generated_set_is_no_source_with_its_own_files() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    succeed(dir.path(), &args("kitti:in", "first", &[]));
    let outcome = generate(dir.path(), "kitti:first", "second", &["--seed", "5"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(
        outcome.stderr.contains("is the source a generated set?"),
        "{outcome:?}"
    );
    assert!(!dir.path().join("second").exists(), "nothing is written");
    let more = ["--seed", "5", "--on-error", "skip"];
    succeed(dir.path(), &args("kitti:first", "second", &more));
    succeed(dir.path(), &["verify", "second"]);
    let record = json(
        &dir.path()
            .join("second/starbreak/provenance/image_2/000000.json"),
    );
    assert_eq!(record["seed"], 5, "its own records");
}

#[test]
fn images_that_nobody_names_are_not_carried_into_a_cracked_set() {
    let dir = folder();
    let root = dir.path().join("in");
    write_coco(&root, &json!([image(1, "a.png")]), &json!([]));
    for name in ["a.png", "unnamed.png", "other.webp"] {
        write_photo(&root.join("val").join(name));
    }
    fs::write(root.join("notes.txt"), "mine").unwrap();
    let outcome = generate(dir.path(), "coco:in", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(
        outcome
            .stderr
            .contains("2 image files that the dataset does not name"),
        "{outcome:?}"
    );
    assert_eq!(names(&dir.path().join("out/val")), ["a.png"]);
    assert!(
        dir.path().join("out/notes.txt").is_file(),
        "other files are carried"
    );
}

#[test]
fn annotations_of_an_id_that_two_images_have_go_to_neither() {
    let dir = folder();
    let root = dir.path().join("in");
    let annotations = json!([
        { "id": 7, "image_id": 34, "category_id": 1, "bbox": [1.0, 2.0, 30.0, 40.0], "area": 1200.0, "iscrowd": 0 },
        { "id": 8, "image_id": 9, "category_id": 1, "bbox": [1.0, 2.0, 30.0, 40.0], "area": 1200.0, "iscrowd": 0 },
    ]);
    let images = json!([image(34, "a.png"), image(34, "b.png"), image(9, "c.png")]);
    write_coco(&root, &images, &annotations);
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&root.join("val").join(name));
    }
    let outcome = generate(dir.path(), "coco:in", "out", &["--on-error", "skip"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(
        names(&dir.path().join("out/val")),
        ["c.png"],
        "only what is certain"
    );
    let index = json(&dir.path().join("out/annotations/instances_val.json"));
    assert_eq!(index["images"].as_array().unwrap().len(), 1, "{index}");
    let ids: Vec<_> = index["annotations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|a| &a["id"])
        .collect();
    assert_eq!(ids, [8], "{index}");
}

#[test]
fn shards_without_an_image_are_shards() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    succeed(dir.path(), &args("kitti:in", "whole", &[]));
    let mut merge = vec!["merge".to_owned(), "-o".to_owned(), "merged".to_owned()];
    for k in 1..=7 {
        let (part, shard) = (format!("p{k}"), format!("{k}/7"));
        succeed(dir.path(), &args("kitti:in", &part, &["--shard", &shard]));
        merge.push(part);
    }
    let merge: Vec<&str> = merge.iter().map(String::as_str).collect();
    succeed(dir.path(), &merge);
    assert!(
        snapshot(&dir.path().join("merged")) == snapshot(&dir.path().join("whole")),
        "five of the shards are empty, and the merged set is whole"
    );
}

#[test]
fn labels_of_poses_are_not_taken_for_boxes() {
    let dir = folder();
    let root = dir.path().join("in");
    for sub in ["images/train", "labels/train"] {
        fs::create_dir_all(root.join(sub)).unwrap();
    }
    write_photo(&root.join("images/train/0.png"));
    fs::write(
        root.join("labels/train/0.txt"),
        "0 0.5 0.5 0.2 0.2 0.45 0.45 0.55 0.5\n",
    )
    .unwrap();
    let data = "train: images/train\nkpt_shape: [2, 2]\nnames: [person]\n";
    fs::write(root.join("data.yaml"), data).unwrap();
    all_refused(dir.path(), &[(args("yolo:in", "out", &[]), "kpt_shape")]);
}

#[test]
fn a_bank_of_cracks_is_not_a_folder_of_photos() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 1);
    let bank = ["patterns", "-n", "1", "-o", "bank", "--size", "160x100"];
    succeed(dir.path(), &[&bank[..], &SMALL].concat());
    all_refused(
        dir.path(),
        &[
            (args("kitti:in", "out", &["--overlays", "bank"]), "--bank"),
            (
                vec!["verify", "bank", "--seed", "3"],
                "recipe and seed from the set itself",
            ),
        ],
    );
}

/// A file that is there when the run looks over the source, and gone when its turn comes.
#[test]
fn images_that_vanish_are_failures_and_come_later() {
    let dir = folder();
    let root = dir.path().join("in");
    let images: Vec<Value> = (0..60).map(|k| image(k, &format!("{k:02}.png"))).collect();
    write_coco(&root, &json!(images), &json!([]));
    for k in 0..60 {
        write_photo(&root.join(format!("val/{k:02}.png")));
    }
    let bytes = fs::read(root.join("val/59.png")).unwrap();
    let child = crate::program::command(dir.path(), &args("coco:in", "out", &["--threads", "1"]))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let begun = dir.path().join("out/val/00.png");
    for _ in 0..4000 {
        if begun.exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    fs::remove_file(root.join("val/59.png")).unwrap();
    let outcome: Outcome = child.wait_with_output().unwrap().into();
    if outcome.code == Some(0) {
        crate::program::skipped("vanishing images: the run was faster than the removal");
        return;
    }
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let failures = fs::read_to_string(dir.path().join("out/starbreak/failures.jsonl")).unwrap();
    assert!(failures.contains("val/59.png"), "{failures}");
    fs::write(root.join("val/59.png"), bytes).unwrap();
    succeed(dir.path(), &args("coco:in", "out", &[]));
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn labels_that_changed_since_are_measured_anew() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    let label = |k: u32, x0: u32| {
        let line = format!("Car 0 0 0 {x0} 20 90 80 1 1 1 1 1 1 1\n");
        fs::write(dir.path().join(format!("in/label_2/{k:06}.txt")), line).unwrap();
    };
    for k in 0..3 {
        label(k, 10);
    }
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    // One moved, one whose object is gone.
    label(1, 30);
    fs::write(dir.path().join("in/label_2/000002.txt"), "").unwrap();
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    succeed(dir.path(), &args("kitti:in", "fresh", &[]));
    let record = json(
        &dir.path()
            .join("out/starbreak/provenance/image_2/000001.json"),
    );
    assert_eq!(record["objects"][0]["box_px"][0], 30.0, "{record}");
    let of = |name: &str| snapshot(&dir.path().join(name));
    assert_eq!(of("out"), of("fresh"), "as an undisturbed run");
}

#[test]
fn what_was_altered_or_emptied_is_made_anew() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 4);
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    let whole = snapshot(&dir.path().join("out"));
    let at = |name: &str| dir.path().join("out").join(name);
    fs::write(at("image_2/000000.png"), "").unwrap();
    fs::copy(
        dir.path().join("in/image_2/000001.png"),
        at("image_2/000001.png"),
    )
    .unwrap();
    fs::write(at("starbreak/regions/image_2/000002.png"), "").unwrap();
    fs::remove_file(at("starbreak/cracks/image_2/000003.png")).unwrap();
    let outcome = starbreak(dir.path(), &["verify", "out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stdout.contains(
            "to mend it: starbreak generate kitti:PATH -o out --recipe out/starbreak/run.json"
        ),
        "the way out: {outcome:?}"
    );
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    assert_eq!(snapshot(&dir.path().join("out")), whole, "as it was");
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn nothing_else_is_put_into_a_set() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    write_photo(&dir.path().join("a.png"));
    fs::create_dir(dir.path().join("frames")).unwrap();
    write_photo(&dir.path().join("frames/0.png"));
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    let whole = snapshot(&dir.path().join("out"));
    let small = |first: &[&'static str]| -> Vec<&'static str> { [first, &SMALL[..]].concat() };
    let in_set = "is in the dataset";
    all_refused(
        dir.path(),
        &[
            (
                small(&["generate", "kitti:in", "-o", "out/deeper/still"]),
                in_set,
            ),
            (small(&["crack", "a.png", "-o", "out"]), in_set),
            (small(&["crack", "a.png", "-o", "out/image_2"]), in_set),
            (
                small(&["patterns", "-n", "1", "--size", "80x60", "-o", "out"]),
                in_set,
            ),
            (small(&["video", "frames", "-o", "out/frames"]), in_set),
            (
                small(&["video", "frames", "-o", "new", "--masks", "out/m"]),
                in_set,
            ),
        ],
    );
    assert_eq!(snapshot(&dir.path().join("out")), whole, "untouched");
}

#[test]
fn a_dry_run_is_refused_where_the_run_would_be() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    succeed(dir.path(), &args("kitti:in", "out", &[]));
    let dry = |more: &[&str]| {
        let outcome = generate(
            dir.path(),
            "kitti:in",
            "out",
            &[more, &["--dry-run"]].concat(),
        );
        assert!(!dir.path().join("out.preview.png").exists() || outcome.code == Some(0));
        outcome
    };
    let other = dry(&["--seed", "9"]);
    let real = generate(dir.path(), "kitti:in", "out", &["--seed", "9"]);
    assert_eq!(other.code, Some(2), "{other:?}");
    assert_eq!(other.stderr, real.stderr, "for the same reason");
    assert_eq!(dry(&[]).code, Some(0), "the same run");
}
