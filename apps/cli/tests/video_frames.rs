//! `starbreak video` with folders of frames, which need no ffmpeg unless a clip is on one side.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[expect(dead_code, reason = "each test file uses its own part")]
mod clip;
mod common;

use std::fs;
use std::path::Path;

use clip::{Studio, states};
use common::{folder, jpeg_bytes, json, names, photo, png_bytes, starbreak_small, succeed_small};

/// Eight frames whose names sort by number: f1.png, f2.jpg, …, and a file that is none.
fn write_frames(folder: &Path) {
    fs::create_dir(folder).unwrap();
    for k in 1..=12 {
        let mut pixels = photo((160, 100)).into_rgb8();
        pixels.put_pixel(0, 0, image::Rgb([k; 3]));
        let pixels = pixels.into();
        if k % 2 == 0 {
            fs::write(folder.join(format!("f{k}.jpg")), jpeg_bytes(&pixels)).unwrap();
        } else {
            fs::write(folder.join(format!("f{k}.png")), png_bytes(&pixels)).unwrap();
        }
    }
    fs::write(folder.join("notes.txt"), "not a frame").unwrap();
}

#[test]
fn a_folder_becomes_a_folder_of_the_same_names() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    let args = [
        "video",
        "in",
        "-o",
        "out",
        "--fps",
        "10",
        "--impact-at",
        "0.35",
        "--masks",
        "m",
    ];
    // A program that is not there: none is needed.
    succeed_small(
        dir.path(),
        &[&args[..], &["--ffmpeg", "no/ffmpeg"]].concat(),
    );
    let mut expected = names(&dir.path().join("in"));
    expected.retain(|name| name != "notes.txt");
    assert_eq!(names(&dir.path().join("out")), expected, "names");
    assert_eq!(names(&dir.path().join("m")).len(), 24, "masks");
    let track = json(&dir.path().join("out.track.json"));
    assert_eq!(states(&track), "iiiissssssss", "0.35 s at 10 per second");
    let read = |folder: &str, name: &str| fs::read(dir.path().join(folder).join(name)).unwrap();
    for (k, frame) in track["frames"].as_array().unwrap().iter().enumerate() {
        let name = frame["file"].as_str().unwrap();
        assert!(
            name.starts_with(&format!("f{}.", k + 1)),
            "{name} is frame {k}"
        );
        assert_eq!(
            read("in", name) == read("out", name),
            k < 4,
            "{name}: the same bytes before the impact"
        );
    }
    assert_eq!(
        json(&dir.path().join("out.network.json"))["unit"],
        "px",
        "network"
    );
}

#[test]
fn the_digest_of_a_folder_is_that_of_its_list() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    succeed_small(dir.path(), &["video", "in", "-o", "out"]);
    let list: String = (1..=12)
        .map(|k| {
            let name = format!("f{k}.{}", if k % 2 == 0 { "jpg" } else { "png" });
            let bytes = fs::read(dir.path().join("in").join(&name)).unwrap();
            format!("{}  {name}\n", starbreak_dataset::sha256_hex(&bytes))
        })
        .collect();
    let track = json(&dir.path().join("out.track.json"));
    let expected = starbreak_dataset::sha256_hex(list.as_bytes());
    assert_eq!(track["input"]["sha256"], expected, "as sha256sum lists it");
}

#[test]
fn frames_and_clips_become_each_other() {
    let Some(studio) = Studio::open() else { return };
    write_frames(&studio.path().join("in"));
    studio.succeed(&["in", "-o", "a.mkv", "--lossless", "--fps", "30000/1001"]);
    assert_eq!(
        studio.frames("a.mkv", (160, 100)).len(),
        12,
        "frames into a clip"
    );
    assert!(studio.described("a.mkv").contains("29.97 fps"), "rate");
    studio.succeed(&["a.mkv", "-o", "frames/"]);
    let expected: Vec<String> = (0..12).map(|k| format!("frame_{k:06}.png")).collect();
    assert_eq!(
        names(&studio.path().join("frames")),
        expected,
        "a clip into frames"
    );
    let outcome = studio.video(&["in", "-o", "b.mp4"]);
    assert_eq!(outcome.complaint("--fps"), None, "a folder has no rate");
    let outcome = studio.video(&["a.mkv", "-o", "b.mp4", "--fps", "10"]);
    assert_eq!(outcome.complaint("of its own"), None, "a clip has one");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    fs::create_dir(dir.path().join("empty")).unwrap();
    fs::create_dir(dir.path().join("mixed")).unwrap();
    for (name, size) in [("a.png", (160, 100)), ("b.png", (100, 160))] {
        fs::write(dir.path().join("mixed").join(name), png_bytes(&photo(size))).unwrap();
    }
    let mut complaints = Vec::new();
    for (args, named) in [
        (&["in", "-o", "in"][..], "would replace"),
        (&["in", "-o", "in/out"], "inside the input folder"),
        (
            &["in", "-o", "out", "--masks", "in/m"],
            "inside the input folder",
        ),
        (&["in", "-o", "out", "--masks", "out"], "one folder"),
        (&["in", "-o", "out", "--lossless"], "--lossless"),
        (&["in", "-o", "out.webm", "--fps", "9"], ".mp4"),
        (&["in", "-o", "out.mp4", "--fps", "9", "--lossless"], ".mkv"),
        (&["in", "-o", "out", "--impact-at", "1"], "--fps"),
        (
            &["in", "-o", "out", "--fps", "10", "--impact-at", "1.2"],
            "1.100 s",
        ),
        (
            &["in", "-o", "out", "--fps", "10", "--impact-at=-1"],
            "0 to that",
        ),
        (
            &["in", "-o", "out", "--fps", "10", "--impact-at", "nan"],
            "0 to that",
        ),
        (&["in", "-o", "out", "--fps", "fast"], "30000/1001"),
        (&["in", "-o", "out", "--growth-time", "2"], "--grow"),
        (
            &[
                "in",
                "-o",
                "out",
                "--fps",
                "10",
                "--grow",
                "--growth-time",
                "0",
            ],
            "more than 0",
        ),
        // The paper's cracks count steps.
        (
            &["in", "-o", "out", "--fps", "10", "--grow"],
            "--growth-time",
        ),
        (&["empty", "-o", "out"], "no frames"),
        (&["mixed", "-o", "out"], "100 x 160"),
        (&["nowhere", "-o", "out"], "ffmpeg"),
        (
            &["in", "-o", "out.mp4", "--fps", "9", "--ffmpeg", "no/ffmpeg"],
            "winget",
        ),
    ] {
        let before = common::snapshot(dir.path());
        let mut all = vec!["video"];
        all.extend(args);
        if !args.contains(&"--ffmpeg") {
            all.extend(["--ffmpeg", "no/ffmpeg"]);
        }
        let outcome = starbreak_small(dir.path(), &all);
        if let Some(complaint) = outcome.complaint(named) {
            complaints.push(format!("{args:?}: {complaint}"));
        }
        if common::snapshot(dir.path()) != before {
            complaints.push(format!("{args:?} changed the folder"));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}
