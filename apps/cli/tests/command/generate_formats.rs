//! `starbreak generate` over every format: labels after are labels before, by public loaders where
//! there are some.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{
    Outcome, SMALL, folder, json, names, skipped, snapshot, starbreak, write_photo,
};
use serde_json::{Value, json};

fn generate(dir: &Path, source: &str, out: &str, more: &[&str]) -> Outcome {
    starbreak(
        dir,
        &[&["generate", source, "-o", out], more, &SMALL].concat(),
    )
}

fn write(path: PathBuf, text: &str) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// Loads source and set with a public tool and compares; says so where there is none.
fn compare_by_loader(dir: &Path, source: &str, out: &str, format: &str, more: &[&str]) {
    let Some(python) = std::env::var_os("STARBREAK_TEST_PYTHON") else {
        skipped(
            "public loaders: STARBREAK_TEST_PYTHON is not set; `cargo xtask test` provides a Python",
        );
        return;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/dataset_loaders.py");
    let output = Command::new(python)
        .arg(script)
        .args([source, out, format])
        .args(more)
        .current_dir(dir)
        .output()
        .unwrap();
    let said: Outcome = output.into();
    assert_eq!(said.code, Some(0), "{format}: {said:?}");
    assert!(said.stdout.contains("same"), "{format}: {said:?}");
}

/// The real data, if it is beside the checkout.
fn shared(name: &str) -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if path.exists() {
        return Some(path.to_str().unwrap().to_owned());
    }
    skipped(&format!(
        "real {name}: no ../shared/data beside the checkout"
    ));
    None
}

#[test]
fn real_coco_labels_come_through_whole_and_in_part() {
    let dir = folder();
    let Some(coco) = shared("coco96") else { return };
    let outcome = generate(dir.path(), &format!("coco:{coco}"), "out", &["--json"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["n_made"], 96, "{result}");
    let name = "annotations/instances_val2017.json";
    let before = fs::read(Path::new(&coco).join(name)).unwrap();
    assert!(
        before == fs::read(dir.path().join("out").join(name)).unwrap(),
        "byte for byte"
    );
    compare_by_loader(dir.path(), &coco, "out", "coco", &[]);
    // As many objects in the records as annotations in the file.
    let n_objects: usize = names(&dir.path().join("out/starbreak/provenance"))
        .iter()
        .filter(|name| name.ends_with(".json"))
        .map(|name| json(&dir.path().join("out/starbreak/provenance").join(name)))
        .map(|record| record["objects"].as_array().unwrap().len())
        .sum();
    assert_eq!(n_objects, 710, "annotations of coco96");

    let outcome = generate(
        dir.path(),
        &format!("coco:{coco}"),
        "part",
        &["--sample", "10"],
    );
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let part = json(&dir.path().join("part").join(name));
    assert_eq!(
        part["images"].as_array().unwrap().len(),
        10,
        "the index is of what is there"
    );
    compare_by_loader(dir.path(), &coco, "part", "coco", &["--subset"]);
    let outcome = starbreak(dir.path(), &["verify", "part"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn real_kitti_labels_come_through() {
    let dir = folder();
    let Some(kitti) = shared("kitti") else { return };
    let outcome = generate(dir.path(), &format!("kitti:{kitti}"), "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    compare_by_loader(dir.path(), &kitti, "out", "kitti", &[]);
}

fn write_bdd(root: &Path) {
    let frame =
        |name: &str, labels: Value| json!({ "name": name, "timestamp": 10000, "labels": labels });
    let label = |id: &str, category: &str, x: f64| {
        json!({ "id": id, "category": category, "attributes": { "occluded": false, "truncated": false },
                "box2d": { "x1": x, "y1": 10.25, "x2": x + 30.5, "y2": 60.75 } })
    };
    let frames = json!([
        frame(
            "a.jpg",
            json!([label("1", "car", 20.1), label("2", "trailer", 60.0)])
        ),
        frame("b.jpg", Value::Null),
        frame("c.jpg", json!([label("3", "person", 5.5)])),
    ]);
    write(root.join("labels/det_20/det_val.json"), &frames.to_string());
    for name in ["a", "b", "c"] {
        let path = root.join(format!("images/100k/val/{name}.jpg"));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(
            path,
            crate::program::jpeg_bytes(&crate::program::photo((160, 100))),
        )
        .unwrap();
    }
}

#[test]
fn bdd_labels_come_through_with_null_labels_and_ignored_classes() {
    let dir = folder();
    write_bdd(&dir.path().join("in"));
    let outcome = generate(dir.path(), "bdd:in", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let name = "labels/det_20/det_val.json";
    let read = |root: &str| fs::read(dir.path().join(root).join(name)).unwrap();
    assert_eq!(read("in"), read("out"), "byte for byte");
    let record = json(
        &dir.path()
            .join("out/starbreak/provenance/images/100k/val/a.json"),
    );
    let kinds: Vec<_> = record["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|o| &o["kind"])
        .collect();
    assert_eq!(kinds, ["regular", "ignored"], "a trailer is ignored");
    assert_eq!(
        record["objects"][0]["box_px"],
        json!([20.1, 10.25, 50.6, 60.75]),
        "its own numbers"
    );
    let record = json(
        &dir.path()
            .join("out/starbreak/provenance/images/100k/val/b.json"),
    );
    assert_eq!(record["objects"], json!([]), "null labels");

    let outcome = generate(dir.path(), "bdd:in", "part", &["--limit", "2"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let part = json(&dir.path().join("part").join(name));
    let whole = json(&dir.path().join("in").join(name));
    assert_eq!(
        part.as_array().unwrap()[..],
        whole.as_array().unwrap()[..2],
        "the first two as they were"
    );
}

#[test]
fn yolo_labels_come_through_and_the_set_does_not_lead_back_to_the_source() {
    let dir = folder();
    let root = dir.path().join("in");
    for (part, k) in [("train", 0), ("train", 1), ("val", 2)] {
        let image = root.join(format!("images/{part}/{k}.png"));
        fs::create_dir_all(image.parent().unwrap()).unwrap();
        write_photo(&image);
        write(
            root.join(format!("labels/{part}/{k}.txt")),
            "0 0.5 0.5 0.25 0.5\n1 0.1 0.1 0.1 0.1\n",
        );
    }
    let absolute = root.to_str().unwrap();
    let data = format!(
        "# mine\npath: {absolute}\ntrain: images/train\nval: {absolute}/images/val\nnames:\n  0: car\n  1: dog\n"
    );
    write(root.join("data.yaml"), &data);
    let outcome = generate(dir.path(), "yolo:in", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    for (path, content) in snapshot(&root) {
        if path.starts_with("labels") {
            assert_eq!(
                snapshot(&dir.path().join("out"))[&path],
                content,
                "{path:?}"
            );
        }
    }
    let data = fs::read_to_string(dir.path().join("out/data.yaml")).unwrap();
    assert!(
        !data.contains(absolute),
        "it leads back to the source: {data}"
    );
    assert!(
        data.contains("# mine") && data.contains("0: car"),
        "all else stays: {data}"
    );
    let record = json(
        &dir.path()
            .join("out/starbreak/provenance/images/train/0.json"),
    );
    assert_eq!(
        record["objects"][0]["box_px"],
        json!([60.0, 25.0, 100.0, 75.0]),
        "in px of 160 x 100"
    );
    assert_eq!(record["objects"][1]["category"], "dog");
    // The set is a source itself, once its own folder is out of the way.
    fs::rename(dir.path().join("out/starbreak"), dir.path().join("aside")).unwrap();
    let outcome = generate(dir.path(), "yolo:out", "again", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn text_lists_come_through() {
    let dir = folder();
    for name in ["x/1.png", "x/2.png", "y/3.png"] {
        let path = dir.path().join("in").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        write_photo(&path);
    }
    write(
        dir.path().join("in/list.txt"),
        "# two of them\nx/1.png\ny/3.png\n",
    );
    let outcome = generate(dir.path(), "list:in/list.txt", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let images: Vec<_> = names(&dir.path().join("out"))
        .into_iter()
        .filter(|name| name.ends_with(".png") && !name.starts_with("starbreak"))
        .collect();
    assert_eq!(images, ["x/1.png", "y/3.png"]);
    let read = |root: &str| fs::read(dir.path().join(root).join("list.txt")).unwrap();
    assert_eq!(read("in"), read("out"));
}

/// Names in annotations that lead out of the dataset, and records that contradict each other.
#[test]
fn hostile_and_contradictory_annotations_are_refused_with_their_place() {
    let dir = folder();
    let write_coco = |images: Value, annotations: Value| {
        let _ = fs::remove_dir_all(dir.path().join("in"));
        fs::create_dir_all(dir.path().join("in/val")).unwrap();
        for name in ["a.png", "b.png"] {
            write_photo(&dir.path().join("in/val").join(name));
        }
        let index = json!({ "images": images, "annotations": annotations,
            "categories": [{ "id": 1, "name": "car", "supercategory": "vehicle" }] });
        write(
            dir.path().join("in/annotations/instances_val.json"),
            &index.to_string(),
        );
    };
    let image =
        |id: u32, name: &str| json!({ "id": id, "file_name": name, "width": 160, "height": 100 });
    let boxed = |id: u32, image: u32, category: u32| {
        json!({ "id": id, "image_id": image, "category_id": category, "bbox": [1.0, 2.0, 30.0, 40.0],
                "area": 1200.0, "iscrowd": 0 })
    };
    write_photo(&dir.path().join("secret.png"));
    let secret = dir.path().join("secret.png");
    let good = || json!([image(1, "a.png"), image(2, "b.png")]);
    let cases = [
        (
            json!([image(1, "a.png"), image(2, "../../secret.png")]),
            json!([]),
            "secret.png",
        ),
        (
            json!([image(1, "a.png"), image(2, secret.to_str().unwrap())]),
            json!([]),
            "secret.png",
        ),
        (
            json!([image(1, "a.png"), image(2, "..\\..\\secret.png")]),
            json!([]),
            "secret.png",
        ),
        (
            json!([image(1, "a.png"), image(1, "a2.png"), image(2, "b.png")]),
            json!([]),
            "1",
        ),
        (
            json!([image(1, "a.png"), image(2, "a.png")]),
            json!([]),
            "a.png",
        ),
        (
            json!([image(1, "a.png"), image(2, "missing.png")]),
            json!([]),
            "missing.png",
        ),
        (good(), json!([boxed(7, 1, 1), boxed(7, 2, 1)]), "7"),
        (good(), json!([boxed(7, 99, 1)]), "99"),
        (good(), json!([boxed(7, 1, 42)]), "42"),
    ];
    for (images, annotations, named) in cases {
        write_coco(images.clone(), annotations.clone());
        let outcome = generate(dir.path(), "coco:in", "out", &[]);
        assert_eq!(outcome.code, Some(2), "{images} {annotations}: {outcome:?}");
        assert!(
            outcome.stderr.contains(named),
            "{images} {annotations}: {outcome:?}"
        );
        assert!(!dir.path().join("out").exists(), "nothing is written");
        let outcome = generate(dir.path(), "coco:in", "out", &["--on-error", "skip"]);
        assert_eq!(outcome.code, Some(0), "{images} {annotations}: {outcome:?}");
        assert!(
            !names(&dir.path().join("out"))
                .iter()
                .any(|name| name.contains("secret")),
            "it leaked"
        );
        let index = json(&dir.path().join("out/annotations/instances_val.json"));
        for image in index["images"].as_array().unwrap() {
            let name = image["file_name"].as_str().unwrap();
            assert!(
                dir.path().join("out/val").join(name).is_file(),
                "the index names {name}: {index}"
            );
        }
        fs::remove_dir_all(dir.path().join("out")).unwrap();
    }
}
