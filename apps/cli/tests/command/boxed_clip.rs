//! `detect clip:FILE --video OUT`: the clip with the boxes of a made-up detector.

use crate::clip::Studio;
use crate::onnx_graph::{Builder, fixed, seen};
use crate::program::{all_refused, json, succeed};

/// A gray clip of 128 x 128 px and a network that finds a person from (32, 64) to (96, 120), as sure as
/// the middle is red, and a car in the corner that is too unsure to be drawn.
fn scene() -> Option<Studio> {
    let studio = Studio::open()?;
    let gray = ["-f", "lavfi", "-i", "color=c=0xb0b0b0:s=128x128:r=25:d=0.4"];
    studio.ffmpeg(&[&gray[..], &["-c:v", "ffv1", "-pix_fmt", "bgr0", "in.mkv"]].concat());
    let row = |place: i64, numbers: [f32; 6]| {
        let numbers = (0..).zip(numbers);
        numbers.map(move |(k, number)| fixed(&[0, place, k], number))
    };
    let mut entries: Vec<_> = row(0, [32.0, 64.0, 96.0, 120.0, 0.0, 0.0]).collect();
    entries.push(seen(&[0, 0, 4], &[0, 0, 64, 64]));
    entries.extend(row(1, [2.0, 2.0, 20.0, 20.0, 0.2, 2.0]));
    Builder::default()
        .image("images", &[1, 3, 128, 128])
        .output("output0", &[1, 300, 6], &entries)
        .write(studio.path(), "model.onnx");
    Some(studio)
}

#[test]
fn the_boxes_of_a_clip_are_drawn_where_they_are() {
    let Some(studio) = scene() else { return };
    let ffmpeg = studio.ffmpeg.to_str().unwrap();
    let args = [
        "detect",
        "clip:in.mkv",
        "--model",
        "model.onnx",
        "-o",
        "dt.json",
        "--video",
        "boxes.mp4",
        "--ffmpeg",
        ffmpeg,
    ];
    succeed(studio.path(), &args);
    let found = json(&studio.path().join("dt.json"));
    assert_eq!(
        found.as_array().unwrap().len(),
        20,
        "two boxes in each of ten frames"
    );
    let frames = studio.frames("boxes.mp4", (128, 128));
    assert_eq!(frames.len(), 10, "each frame once");
    assert_eq!(studio.times("boxes.mp4").0.len(), 10, "and its time");
    let is_gray = |frame: &[u8], x: usize, y: usize| {
        let at = 3 * (y * 128 + x);
        frame[at..at + 3]
            .iter()
            .all(|code| code.abs_diff(0xb0) < 24)
    };
    for frame in &frames {
        for (x, y) in [(32, 90), (96, 90), (64, 120), (64, 64)] {
            assert!(!is_gray(frame, x, y), "a line at {x}, {y}");
        }
        assert!(!is_gray(frame, 36, 58), "words above the box");
        for (x, y) in [(64, 90), (20, 90), (110, 90), (64, 30), (2, 10), (20, 10)] {
            assert!(is_gray(frame, x, y), "nothing at {x}, {y}");
        }
    }
}

/// A contract may leave boxes beyond the frame.
#[test]
fn boxes_beyond_the_frame_are_drawn_as_far_as_they_are_in_it() {
    let Some(studio) = scene() else { return };
    let wide = [-3e8, 30.0, 3e8, 3e8, 0.9, 0.0];
    let outside = [-50.0, -50.0, -20.0, -20.0, 0.9, 0.0];
    let rows = [(0, wide), (1, outside)];
    let entries: Vec<_> = rows
        .into_iter()
        .flat_map(|(place, row)| {
            (0..)
                .zip(row)
                .map(move |(k, value)| fixed(&[0, place, k], value))
        })
        .collect();
    Builder::default()
        .image("images", &[1, 3, 128, 128])
        .output("output0", &[1, 300, 6], &entries)
        .write(studio.path(), "model.onnx");
    let contract = "schema = 1\npreset = \"yolov10\"\n[detections]\nclip = false\n";
    std::fs::write(studio.path().join("contract.toml"), contract).unwrap();
    let ffmpeg = studio.ffmpeg.to_str().unwrap();
    succeed(
        studio.path(),
        &[
            "detect",
            "clip:in.mkv",
            "--model",
            "model.onnx",
            "--contract",
            "contract.toml",
            "-o",
            "dt.json",
            "--video",
            "boxes.mkv",
            "--ffmpeg",
            ffmpeg,
            "--limit",
            "1",
        ],
    );
    let frames = studio.frames("boxes.mkv", (128, 128));
    assert_eq!(frames.len(), 1, "as many as were looked at");
    let blue = |x: usize, y: usize| frames[0][3 * (y * 128 + x) + 2];
    assert!(
        blue(120, 30).abs_diff(0xb0) > 24,
        "the upper side of the wide box"
    );
    assert!(
        blue(64, 8).abs_diff(0xb0) < 24 && blue(64, 80).abs_diff(0xb0) < 24,
        "nothing else"
    );
}

#[test]
fn a_clip_that_cannot_be_drawn_is_refused_before_the_work() {
    let Some(studio) = scene() else { return };
    let at = studio.path();
    std::fs::create_dir(at.join("frames")).unwrap();
    std::fs::write(at.join("taken.mp4"), "somebody's").unwrap();
    let ffmpeg = studio.ffmpeg.to_str().unwrap();
    let detect = |source: &'static str, video: &'static str| {
        vec![
            "detect",
            source,
            "--model",
            "model.onnx",
            "-o",
            "dt.json",
            "--video",
            video,
            "--ffmpeg",
            ffmpeg,
        ]
    };
    all_refused(
        at,
        &[
            (detect("clip:frames", "a.mp4"), "clip:FILE"),
            (detect("folder:frames", "a.mp4"), "clip:FILE"),
            (detect("clip:in.mkv", "in.mkv"), "in.mkv"),
            (detect("clip:in.mkv", "a.webm"), "a.webm"),
            (detect("clip:in.mkv", "taken.mp4"), "taken.mp4"),
            (detect("clip:in.mkv", "dt.json"), "dt.json"),
        ],
    );
    // Not after the work: of the same name, and audio that the container does not hold.
    let same = [
        "detect",
        "clip:in.mkv",
        "--model",
        "none.onnx",
        "-o",
        "a.mkv",
        "--video",
        "a.mkv",
    ];
    let wma = "-f lavfi -i sine=440:d=0.4 -c:v ffv1 -c:a wmav2";
    studio.make("s=64x64:r=25:d=0.4", wma, "wma.mkv");
    let audio = [
        "detect",
        "clip:wma.mkv",
        "--model",
        "none.onnx",
        "-o",
        "dt.json",
        "--video",
        "a.mp4",
    ];
    for args in [same, audio] {
        let refused = crate::program::starbreak(at, &[&args[..], &["--ffmpeg", ffmpeg]].concat());
        assert_ne!(refused.code, Some(0), "{refused:?}");
        assert!(
            !refused.stderr.contains("none.onnx"),
            "before the model: {refused:?}"
        );
    }
    assert!(!at.join("dt.json").exists(), "nothing is written");
}
