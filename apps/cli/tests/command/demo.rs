//! `demo`: everything in one folder, whole, and the same each time.

use std::fs;
use std::path::Path;

use crate::program::{folder, json, names, raw_frames, raw_png, snapshot, succeed};
use serde_json::Value;

const FILES: [&str; 15] = [
    "far-focus.crack.png",
    "far-focus.json",
    "far-focus.png",
    "far-focus.region.png",
    "growth.png",
    "network.json",
    "network.svg",
    "recipe.toml",
    "scene.boxes.json",
    "scene.png",
    "short-focus.crack.png",
    "short-focus.json",
    "short-focus.png",
    "short-focus.region.png",
    "written.json",
];

const FRAME: (u32, u32) = (1242, 375);

#[test]
fn every_file_is_there_and_decodes() {
    let dir = folder();
    let outcome = succeed(dir.path(), &["demo", "--preset", "paper"]);
    let out = dir.path().join("starbreak-demo");
    assert_eq!(names(dir.path()).len(), FILES.len() + 1, "one folder");
    assert_eq!(names(&out), FILES, "files of the demo");
    for name in FILES {
        let said = name.replace("far-focus", "*").replace("short-focus", "*");
        let said = outcome.stdout.contains(name)
            || outcome.stdout.contains(&said)
            || (name.ends_with("focus.json") && outcome.stdout.contains("*-focus.json"));
        assert!(said, "{name} is not explained: {}", outcome.stdout);
        if name.ends_with("png") {
            assert_eq!(raw_png(&out.join(name)).size, FRAME, "{name}");
        } else if name.ends_with("json") {
            assert!(json(&out.join(name))["schema"].is_string(), "{name}");
        }
    }
    let growth = raw_frames(&out.join("growth.png"));
    assert!(growth.len() >= 10, "{} frames", growth.len());
    let scene = raw_png(&out.join("scene.png"));
    for focus in ["far", "short"] {
        let image = raw_png(&out.join(format!("{focus}-focus.png")));
        let region = raw_png(&out.join(format!("{focus}-focus.region.png")));
        assert!(image.data != scene.data, "{focus}: no crack");
        let outside = scene.pixels().zip(image.pixels()).zip(&region.data);
        let touched = outside.filter(|((a, b), region)| **region == 0 && a != b);
        assert_eq!(touched.count(), 0, "{focus}: changed outside the region");
    }
    let text = fs::read_to_string(out.join("recipe.toml")).unwrap();
    assert_eq!(
        text,
        succeed(dir.path(), &["recipe", "--preset", "paper"]).stdout,
        "its recipe"
    );
}

#[test]
fn boxes_lie_inside_the_scene() {
    let dir = folder();
    succeed(dir.path(), &["demo", "-o", "d", "-q", "--preset", "paper"]);
    let boxes = json(&dir.path().join("d/scene.boxes.json"));
    assert_eq!(boxes["width_px"], FRAME.0, "{boxes}");
    assert_eq!(boxes["height_px"], FRAME.1, "{boxes}");
    assert_eq!(boxes["image"], "scene.png", "{boxes}");
    let objects = boxes["objects"].as_array().unwrap();
    for object in objects {
        let corners: Vec<f64> = object["bbox_xyxy_px"]
            .as_array()
            .unwrap()
            .iter()
            .map(|corner| corner.as_f64().unwrap())
            .collect();
        let [x0, y0, x1, y1] = corners[..] else {
            panic!("{object}");
        };
        assert!(0.0 <= x0 && x1 <= f64::from(FRAME.0), "{object}");
        assert!(0.0 <= y0 && y1 <= f64::from(FRAME.1), "{object}");
        assert!(x1 - x0 > 2.0 && y1 - y0 > 2.0, "{object}: no area");
    }
    let kinds: Vec<&str> = objects
        .iter()
        .map(|object| object["category"].as_str().unwrap())
        .collect();
    for kind in ["Car", "Pedestrian", "TrafficSign"] {
        assert!(kinds.contains(&kind), "no {kind} among {kinds:?}");
    }
}

/// All files, provenance without its times.
fn without_times(dir: &Path) -> Vec<(String, Vec<u8>)> {
    snapshot(dir)
        .into_iter()
        .map(|(path, content)| {
            let name = path.to_str().unwrap().to_owned();
            let mut content = content.unwrap();
            if name.ends_with("-focus.json") {
                let mut record: Value = serde_json::from_slice(&content).unwrap();
                record
                    .as_object_mut()
                    .unwrap()
                    .remove("timings_ms")
                    .unwrap();
                content = record.to_string().into_bytes();
            }
            (name, content)
        })
        .collect()
}

#[test]
fn two_demos_are_one() {
    let dir = folder();
    let demo = |out: &str, more: &[&str]| {
        succeed(
            dir.path(),
            &[&["demo", "-q", "-o", out, "--preset", "paper"], more].concat(),
        );
        without_times(&dir.path().join(out))
    };
    let one = demo("one", &["--threads", "1"]);
    assert!(one == demo("one", &[]), "the second into the same folder");
    assert!(one == demo("two", &["--threads", "2"]), "two threads");
    let other = demo("other", &["--seed", "3"]);
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        let of_the_seed = !name.starts_with("scene") && name != "recipe.toml";
        let short_region = name == "short-focus.region.png";
        assert_eq!(one != other, of_the_seed && !short_region, "{name}, seed 3");
    }
}

/// The demo is made of the verbs: each of its results can be had by hand.
#[test]
fn the_demo_can_be_made_by_hand() {
    let dir = folder();
    succeed(dir.path(), &["demo", "-o", "d", "-q", "--preset", "paper"]);
    let at = |name: &str| dir.path().join(name);
    for focus in ["far", "short"] {
        let record = json(&at(&format!("d/{focus}-focus.json")));
        fs::write(at("r.toml"), record["recipe"].as_str().unwrap()).unwrap();
        let name = record["input"]["name"].as_str().unwrap();
        let input = format!("d/{name}");
        succeed(
            dir.path(),
            &["crack", &input, "--recipe", "r.toml", "-o", "hand", "-q"],
        );
        let by_hand = fs::read(at(&format!("hand/{name}"))).unwrap();
        assert!(
            by_hand == fs::read(at(&format!("d/{focus}-focus.png"))).unwrap(),
            "{focus}: another image"
        );
        let seed = record["item"]["seed"].to_string();
        succeed(
            dir.path(),
            &[
                "simulate", "-o", "n.json", "--preset", "paper", "--seed", &seed,
            ],
        );
        assert!(
            fs::read(at("n.json")).unwrap() == fs::read(at("d/network.json")).unwrap(),
            "{focus}: another network"
        );
    }
}

#[test]
fn a_demo_with_an_unbroken_pane_is_whole() {
    let dir = folder();
    succeed(
        dir.path(),
        &[
            "demo",
            "-o",
            "d",
            "--preset",
            "paper",
            "--set",
            "impact.force=1",
        ],
    );
    assert_eq!(names(&dir.path().join("d")), FILES, "files of the demo");
    let scene = raw_png(&dir.path().join("d/scene.png"));
    for focus in ["far", "short"] {
        let image = raw_png(&dir.path().join(format!("d/{focus}-focus.png")));
        // Focused on the glass, the lens blurs the scene all the same.
        assert_eq!(image == scene, focus == "far", "{focus}: the image");
    }
}

/// What the demo says about its files must fit the recipe.
#[test]
fn files_that_the_demo_names_exist() {
    let dir = folder();
    for set in ["output.format=jpeg", "output.masks=false"] {
        let out = set.replace(['.', '='], "_");
        let outcome = succeed(
            dir.path(),
            &["demo", "-o", &out, "--preset", "paper", "--set", set],
        );
        let files = names(&dir.path().join(&out));
        let (_, guide) = outcome.stdout.split_once(&format!("in {out}:")).unwrap();
        let (guide, next) = guide.split_once("next:").unwrap();
        for line in next.lines().filter(|line| line.contains("starbreak demo")) {
            assert!(
                line.contains(&format!("starbreak demo -o {out} ")),
                "{line}"
            );
        }
        for line in guide.lines().filter(|line| line.starts_with("  ")) {
            let (listed, _) = line.trim().split_once("  ").unwrap();
            for name in listed.split(", ") {
                let suffix = name.trim_start_matches('*');
                assert!(
                    files.iter().any(|file| file.ends_with(suffix)),
                    "{set}: {name} is named, but there are only {files:?}"
                );
            }
        }
    }
}
