//! `detect clip:…` and `timeline` on a clip that `video` broke, with a real detector.

use std::fs;
use std::path::{Path, PathBuf};

use crate::clip::Studio;
use crate::program::{all_refused, json, photo, png_bytes, skipped, starbreak, succeed};
use serde_json::Value;

/// A file or folder of the shared data, or `None` with a note on the error output.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    skipped(&format!("{} is not there", path.display()));
    None
}

/// A studio with `clean.mkv`, 16 lossless frames that pan over a photo of people, and a model.
fn scene() -> Option<(Studio, String)> {
    let (Some(model), Some(photo)) = (
        shared("onnx/FastestDet.onnx"),
        shared("onnx/fastestdet_3.jpg"),
    ) else {
        return None;
    };
    let studio = Studio::open()?;
    let photo = photo.to_str().unwrap();
    let pan = "scale=440:320,crop=416:320:n:0";
    let input = ["-loop", "1", "-framerate", "10", "-i", photo];
    let output = [
        "-frames:v",
        "16",
        "-vf",
        pan,
        "-c:v",
        "ffv1",
        "-pix_fmt",
        "bgr0",
        "clean.mkv",
    ];
    studio.ffmpeg(&[&input[..], &output].concat());
    Some((studio, model.to_str().unwrap().to_owned()))
}

#[test]
fn a_clip_is_detected_as_its_frames_are() {
    let Some((studio, model)) = scene() else {
        return;
    };
    let at = studio.path();
    let ffmpeg = studio.ffmpeg.to_str().unwrap().to_owned();
    fs::create_dir(at.join("frames")).unwrap();
    let names = ["-start_number", "0", "frames/frame_%06d.png"];
    studio.ffmpeg(&[&["-i", "clean.mkv", "-pix_fmt", "rgb24"][..], &names].concat());
    let detect = |source: &str, out: &str, more: &[&str]| {
        let args = [
            "detect", "--model", &model, source, "-o", out, "--ffmpeg", &ffmpeg,
        ];
        succeed(at, &[&args[..], more].concat());
        fs::read(at.join(out)).unwrap()
    };
    let of_clip = detect("clip:clean.mkv", "clip.json", &["--threads", "3"]);
    assert!(
        json(&at.join("clip.json")).as_array().unwrap().len() > 16,
        "boxes"
    );
    let one_thread = detect("clip:clean.mkv", "one.json", &["--threads", "1"]);
    assert!(of_clip == one_thread, "any number of threads");
    assert!(
        of_clip == detect("clip:frames", "f.json", &[]),
        "frames in their order"
    );
    assert!(
        of_clip == detect("folder:frames", "d.json", &[]),
        "a folder"
    );
    detect(
        "clip:clean.mkv",
        "first.json",
        &["--limit", "2", "--format", "bdd"],
    );
    let first = json(&at.join("first.json"));
    let name = |k: usize| [first[k]["name"].as_str(), first[k]["videoName"].as_str()];
    assert_eq!(
        name(0),
        [Some("frame_000000.png"), Some("clean")],
        "frame 0"
    );
    assert_eq!(
        name(1),
        [Some("frame_000001.png"), Some("clean")],
        "frame 1"
    );
    assert_eq!(first.as_array().unwrap().len(), 2, "only so many");
    fs::create_dir(at.join("mixed")).unwrap();
    for (k, size) in [(9, (64, 48)), (10, (48, 64)), (11, (32, 32))] {
        let bytes = png_bytes(&photo(size));
        fs::write(at.join(format!("mixed/f{k}.png")), bytes).unwrap();
    }
    // Its header is no size: it is named by whoever reads it.
    fs::write(at.join("mixed/f8.png"), "no picture").unwrap();
    let cut = fs::read(at.join("clean.mkv")).unwrap();
    fs::write(at.join("cut.mkv"), &cut[..cut.len() / 2]).unwrap();
    fs::write(at.join("text.mp4"), "no clip").unwrap();
    let case = |source: &'static str| -> Vec<String> {
        [
            "detect", "--model", &model, source, "-o", "x.json", "--ffmpeg", &ffmpeg, "--quiet",
        ]
        .map(str::to_owned)
        .into()
    };
    let cases = [
        (
            case("clip:mixed"),
            "\"mixed/f10.png\" is 48 x 64 px, but \"mixed/f9.png\", a frame before it, is 64 x 48 px",
        ),
        (case("clip:cut.mkv"), "cut.mkv"),
        (case("clip:text.mp4"), "text.mp4"),
        (case("clip:absent.mp4"), "absent.mp4"),
        (case("clip:"), "no path"),
        (case("clean.mkv"), "a clip is clip:FILE"),
    ];
    let cases: Vec<(Vec<&str>, &str)> = cases
        .iter()
        .map(|(args, said)| (args.iter().map(String::as_str).collect(), *said))
        .collect();
    all_refused(at, &cases);
}

#[test]
fn a_clip_is_broken_detected_and_followed() {
    let Some((studio, model)) = scene() else {
        return;
    };
    let at = studio.path();
    let ffmpeg = studio.ffmpeg.to_str().unwrap().to_owned();
    let video = [
        "clean.mkv",
        "-o",
        "cracked.mkv",
        "--lossless",
        "--impact-at",
        "0.6",
    ];
    studio.succeed(&video);
    for (clip, out) in [
        ("clip:clean.mkv", "clean.json"),
        ("clip:cracked.mkv", "cracked.json"),
    ] {
        let args = [
            "detect", "--model", &model, clip, "-o", out, "--ffmpeg", &ffmpeg,
        ];
        succeed(at, &[&args[..], &["--score-threshold", "0.2"]].concat());
    }
    let args = [
        "timeline",
        "--clean",
        "clean.json",
        "--cracked",
        "cracked.json",
        "--track",
        "cracked.mkv.track.json",
        "--lost-for",
        "3",
        "-o",
        "out",
        "--json",
    ];
    let outcome = succeed(at, &args);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let clip = &result["timelines"][0];
    assert_eq!(clip["clip"], "clean", "the name of what was cracked");
    assert_eq!(clip["cracked"]["damage_onset"]["frame_idx"], 6, "{clip}");
    assert!(
        !clip["objects"].as_array().unwrap().is_empty(),
        "somebody is followed"
    );
    // Before the impact the frames are the same to the last bit.
    let frames = |side: &str| clip[side]["frames"].as_array().unwrap()[..6].to_vec();
    assert_eq!(frames("clean"), frames("cracked"), "intact frames");
    assert_eq!(
        clip["clean"]["after"]["found"]["value"], 1.0,
        "by construction"
    );
    assert!(at.join("out/report.html").is_file(), "the report");
    // The same of the frames: the results do not depend on the form of the clip.
    let again = starbreak(at, &args);
    assert_eq!(again.stdout, outcome.stdout, "the same again");
}
