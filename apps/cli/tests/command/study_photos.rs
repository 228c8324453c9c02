//! `study --overlays`: photographs of broken glass beside simulated cracks, by a made-up detector.

use std::fs;
use std::path::Path;

use crate::onnx_graph::{Builder, fixed, seen};
use crate::program::{all_refused, folder, json, raw_png, snapshot, starbreak, succeed};
use image::{Rgb, RgbImage};
use serde_json::json;

/// Images of 64 x 64 px, each with one person in its middle; a network that finds each person, as
/// sure as the middle pixel is red; photographs of broken glass on black.
pub(crate) fn world(dir: &Path) {
    let root = dir.join("coco");
    fs::create_dir_all(root.join("val2017")).unwrap();
    fs::create_dir_all(root.join("annotations")).unwrap();
    let (mut images, mut annotations) = (Vec::new(), Vec::new());
    for id in 1..=12_u8 {
        let name = format!("{id:012}.png");
        let pixels = RgbImage::from_pixel(64, 64, Rgb([110 + 8 * id, 90, 60]));
        pixels.save(root.join("val2017").join(&name)).unwrap();
        images.push(json!({ "id": id, "file_name": name, "width": 64, "height": 64 }));
        annotations.push(json!({
            "id": id, "image_id": id, "category_id": 1, "iscrowd": 0, "area": 1024,
            "bbox": [16, 16, 32, 32],
        }));
    }
    let categories = [json!({ "id": 1, "name": "person", "supercategory": "person" })];
    let labels = json!({ "images": images, "annotations": annotations, "categories": categories });
    let index = root.join("annotations/instances_val2017.json");
    fs::write(index, labels.to_string()).unwrap();

    let corners = [16.0, 16.0, 48.0, 48.0];
    let mut entries: Vec<_> = (0..)
        .zip(corners)
        .map(|(k, at)| fixed(&[0, 0, k], at))
        .collect();
    entries.push(seen(&[0, 0, 4], &[0, 0, 32, 32]));
    Builder::default()
        .image("images", &[1, 3, 64, 64])
        .output("output0", &[1, 300, 6], &entries)
        .write(dir, "model.onnx");

    fs::create_dir(dir.join("glass")).unwrap();
    for k in 0..3_u32 {
        let on_line = |x: u32, y: u32| (x + y * k).is_multiple_of(23) || y.is_multiple_of(19 + k);
        let photo = RgbImage::from_fn(160, 160, |x, y| Rgb([255 * u8::from(on_line(x, y)); 3]));
        photo.save(dir.join(format!("glass/{k}.png"))).unwrap();
    }
}

pub(crate) const STUDY: [&str; 15] = [
    "study",
    "--quiet",
    "coco:coco",
    "--model",
    "model.onnx",
    "--presets",
    "paper",
    "--set",
    "fracture.particles=800",
    "--replicates",
    "20",
    "--divergence",
    "off",
    "--overlays",
    "glass",
];

#[test]
fn photographs_are_a_condition_beside_the_simulated_ones() {
    let dir = folder();
    world(dir.path());
    let run = |out: &str| succeed(dir.path(), &[&STUDY[..], &["-o", out]].concat());
    run("study");
    let at = |name: &str| dir.path().join("study").join(name);
    let sets = ["paper-seed-0", "photos-seed-0"];
    for set in sets {
        assert!(at("sets").join(set).is_dir(), "{set}");
    }
    let study = json(&at("evaluation.json"));
    let conditions: Vec<&str> = study["evaluations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["condition"]["family"].as_str().unwrap())
        .collect();
    assert_eq!(conditions, ["paper", "photos"], "in the report");
    let table = fs::read_to_string(at("table.tex")).unwrap();
    assert!(
        table.contains("paper") && table.contains("photos"),
        "{table}"
    );
    // Each image has a part of a photograph, lit by the optics of the paper.
    let run_json = json(&at("sets/photos-seed-0/starbreak/run.json"));
    assert_eq!(
        run_json["patterns"]["overlays"]["n_photos"], 3,
        "{run_json}"
    );
    assert!(
        run_json["recipe"]
            .as_str()
            .unwrap()
            .contains("model = \"paper\""),
        "{run_json}"
    );
    let cracks = |set: &str, k: u8| {
        let name = format!("sets/{set}/starbreak/cracks/val2017/{k:012}.png");
        raw_png(&at(&name)).data
    };
    assert_ne!(cracks(sets[0], 1), cracks(sets[1], 1), "other glass");
    assert_ne!(
        cracks(sets[1], 1),
        cracks(sets[1], 2),
        "another part for another image"
    );

    let before = snapshot(&at("sets"));
    run("study");
    assert_eq!(
        snapshot(&at("sets")),
        before,
        "it goes on, and does nothing twice"
    );
    let verified = starbreak(
        dir.path(),
        &[
            "verify",
            "study/sets/photos-seed-0",
            "--regenerate",
            "3",
            "--source",
            "coco:coco",
            "--overlays",
            "glass",
        ],
    );
    assert_eq!(verified.code, Some(0), "{}", verified.stderr);
}

#[test]
fn other_photographs_and_useless_ones_are_refused() {
    let dir = folder();
    world(dir.path());
    succeed(dir.path(), &[&STUDY[..], &["-o", "study"]].concat());
    let photo = dir.path().join("glass/1.png");
    let kept = fs::read(&photo).unwrap();
    RgbImage::from_fn(160, 160, |x, _| Rgb([255 * u8::from(x % 9 == 0); 3]))
        .save(&photo)
        .unwrap();
    let in_study = [&STUDY[..], &["-o", "study"]].concat();
    let without = [&STUDY[..13], &["-o", "study"]].concat();
    let in_photos = [&STUDY[..], &["-o", "glass/study"]].concat();
    let no_photos = [&STUDY[..14], &["coco/annotations", "-o", "new"]].concat();
    let idle = [&STUDY[..13], &["--overlay-floor", "0.1", "-o", "new"]].concat();
    let gain = [&STUDY[..], &["--overlay-gain", "2", "-o", "new"]].concat();
    all_refused(
        dir.path(),
        &[
            (
                in_study.clone(),
                "photos of its condition photos-seed-0 are others",
            ),
            (without, "photos-seed-0, which is left out now"),
            (in_photos, "glass"),
            (no_photos, "annotations"),
            (idle, "--overlay-floor"),
            (gain, "--overlay-gain"),
        ],
    );
    assert!(
        !dir.path().join("new").exists(),
        "before anything is written"
    );
    fs::write(&photo, kept).unwrap();
    succeed(dir.path(), &in_study);
}
