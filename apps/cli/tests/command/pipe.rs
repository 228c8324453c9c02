//! `starbreak pipe`: raw frames from standard input to standard output.

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::clip::Studio;
use crate::program::{
    Outcome, SMALL, command, folder, photo, png_bytes, starbreak, succeed, succeed_small,
};
use image::DynamicImage;
use serde_json::Value;

const SIZE: (u32, u32) = (96, 64);

/// The bytes of so many frames of RGB, each another.
fn frames_of_rgb(n: u32) -> Vec<u8> {
    let frame = |k: u32| {
        let mut pixels = photo(SIZE).to_rgb8();
        for code in &mut *pixels {
            *code = code.saturating_add(u8::try_from(3 * k).unwrap());
        }
        pixels.into_raw()
    };
    (0..n).flat_map(frame).collect()
}

/// The same in another format, with alpha 77.
fn converted(rgb: &[u8], pixels: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for pixel in rgb.chunks_exact(3) {
        let [r, g, b] = [pixel[0], pixel[1], pixel[2]];
        match pixels {
            "rgb24" => bytes.extend([r, g, b]),
            "bgr24" => bytes.extend([b, g, r]),
            "rgba" => bytes.extend([r, g, b, 77]),
            "bgra" => bytes.extend([b, g, r, 77]),
            _ => bytes.push(g),
        }
    }
    bytes
}

/// What came of a run, with the bytes of its standard output.
struct Piped {
    bytes: Vec<u8>,
    outcome: Outcome,
}

impl Piped {
    /// Its result in JSON, the last line of standard error.
    fn json(&self) -> Value {
        let line = self.outcome.stderr.lines().last().unwrap();
        serde_json::from_str(line).unwrap()
    }
}

fn start(dir: &Path, args: &[&str]) -> Child {
    let mut child = command(dir, &[&["pipe", "--size", "96x64"], args].concat());
    child
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    child.spawn().unwrap()
}

/// Sends bytes through `starbreak pipe` for frames of [`SIZE`].
fn pipe(dir: &Path, args: &[&str], input: &[u8]) -> Piped {
    let mut child = start(dir, args);
    let mut stdin = child.stdin.take().unwrap();
    let output = std::thread::scope(|scope| {
        scope.spawn(move || {
            // A command that refuses does not listen.
            let _ = stdin.write_all(input);
        });
        child.wait_with_output().unwrap()
    });
    let bytes = output.stdout.clone();
    let mut outcome = Outcome::from(output);
    outcome.stdout = String::new();
    Piped { bytes, outcome }
}

/// The same with the [`SMALL`] crack and JSON; it must succeed.
fn pipe_small(dir: &Path, args: &[&str], input: &[u8]) -> Piped {
    let piped = pipe(dir, &[args, &["--json"], &SMALL].concat(), input);
    assert_eq!(piped.outcome.code, Some(0), "{args:?}: {:?}", piped.outcome);
    piped
}

#[test]
fn the_first_frame_is_that_of_crack() {
    let dir = folder();
    let picture = photo(SIZE);
    std::fs::write(dir.path().join("photo.png"), png_bytes(&picture)).unwrap();
    let star = ["--preset", "windshield-star", "--set", "fracture.mesh=fast"];
    let noise = ["--preset", "noise"];
    for (k, set) in [&star[..], &noise, &SMALL].into_iter().enumerate() {
        let out = format!("out{k}");
        let crack = ["crack", "photo.png", "-o", &out, "--seed", "3"];
        succeed(dir.path(), &[&crack, set].concat());
        let made = image::open(dir.path().join(&out).join("photo.png")).unwrap();
        let made = made.to_rgb8().into_raw();
        assert_ne!(made, picture.to_rgb8().into_raw(), "{set:?}: it shows");
        let args = ["--pixels", "rgb24", "--name", "photo.png", "--seed", "3"];
        let raw = picture.to_rgb8().into_raw();
        let piped = pipe(dir.path(), &[&args, set].concat(), &raw);
        assert!(piped.bytes == made, "{set:?}: {:?}", piped.outcome);
    }
}

#[test]
fn frames_are_those_of_video_in_every_format() {
    let dir = folder();
    std::fs::create_dir(dir.path().join("in")).unwrap();
    let n = 12;
    let raw = frames_of_rgb(n);
    let n_bytes = SIZE.0 as usize * SIZE.1 as usize * 3;
    for (k, frame) in raw.chunks_exact(n_bytes).enumerate() {
        let pixels = image::RgbImage::from_raw(SIZE.0, SIZE.1, frame.to_vec()).unwrap();
        let name = dir.path().join(format!("in/{k:02}.png"));
        std::fs::write(name, png_bytes(&DynamicImage::from(pixels))).unwrap();
    }
    let grown = ["--impact-at", "0.3", "--grow", "--growth-time", "0.4"];
    let star = [
        "--preset",
        "windshield-star",
        "--set",
        "fracture.mesh=fast",
        "--set",
        "noise.read_e=30",
        "--set",
        "frames.frozen=0.3",
    ];
    let rain = ["--preset", "rain"];
    let late = ["--preset", "noise", "--set", "noise.onset_s=0.5"];
    for (k, (set, pixels)) in [
        ([&grown[..], &SMALL].concat(), "rgb24"),
        ([&grown[..], &SMALL].concat(), "bgr24"),
        ([&grown[..], &star].concat(), "bgra"),
        ([&["--light", "first"], &star[..]].concat(), "rgba"),
        (rain.to_vec(), "bgr24"),
        (late.to_vec(), "bgra"),
    ]
    .into_iter()
    .enumerate()
    {
        let out = format!("out{k}");
        let video = ["video", "in", "-o", &out, "--fps", "10", "--seed", "2"];
        succeed(dir.path(), &[&video[..], &set].concat());
        let made: Vec<u8> = (0..n)
            .flat_map(|k| {
                let name = dir.path().join(format!("{out}/{k:02}.png"));
                image::open(name).unwrap().to_rgb8().into_raw()
            })
            .collect();
        assert_ne!(made, raw, "{set:?}: it shows");
        let args = [
            "--pixels", pixels, "--name", "in", "--fps", "10", "--seed", "2", "--json",
        ];
        let piped = pipe(
            dir.path(),
            &[&args[..], &set].concat(),
            &converted(&raw, pixels),
        );
        assert_eq!(piped.outcome.code, Some(0), "{set:?}: {:?}", piped.outcome);
        let expected = converted(&made, pixels);
        let off = piped.bytes.iter().zip(&expected).filter(|(a, b)| a != b);
        assert_eq!(off.count(), 0, "{set:?}, {pixels}");
        assert_eq!(piped.bytes.len(), expected.len(), "{set:?}, {pixels}");
        let told = piped.json();
        assert_eq!(told["n_read"], n, "{told}");
        if set.contains(&"--impact-at") {
            assert_eq!(told["damage_onset"]["frame_idx"], 3, "{told}");
        }
    }
    let gray = pipe_small(dir.path(), &["--pixels", "gray"], &converted(&raw, "gray"));
    assert_eq!(gray.bytes.len(), raw.len() / 3, "gray");
    assert_ne!(gray.bytes, converted(&raw, "gray"), "gray: it shows");
}

#[test]
fn a_clip_goes_through_ffmpeg_and_back() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=96x64:r=10:d=2", "-c:v ffv1 -pix_fmt bgr0", "in.mkv");
    studio.succeed(&[
        "in.mkv",
        "-o",
        "video.mkv",
        "--lossless",
        "--impact-at",
        "0.5",
    ]);
    let raw = studio.ffmpeg(&["-i", "in.mkv", "-f", "rawvideo", "-pix_fmt", "bgr24", "-"]);
    let args = [
        "--pixels",
        "bgr24",
        "--fps",
        "10",
        "--name",
        "in.mkv",
        "--impact-at",
        "0.5",
    ];
    let piped = pipe_small(studio.path(), &args, &raw);
    std::fs::write(studio.path().join("raw"), &piped.bytes).unwrap();
    let back = "-f rawvideo -pixel_format bgr24 -video_size 96x64 -framerate 10 -i raw -c:v ffv1 -pix_fmt bgr0 pipe.mkv";
    studio.ffmpeg(&back.split(' ').collect::<Vec<_>>());
    let (found, expected) = (
        studio.frames("pipe.mkv", (96, 64)),
        studio.frames("video.mkv", (96, 64)),
    );
    assert_eq!(found.len(), 20, "frames");
    assert!(found == expected, "the frames of video");
    assert!(
        found[19] != studio.frames("in.mkv", (96, 64))[19],
        "it shows"
    );
}

#[test]
fn the_summary_has_counts_and_latencies() {
    let dir = folder();
    let told = pipe_small(dir.path(), &["--pixels", "rgb24"], &frames_of_rgb(8)).json();
    for (key, expected) in [("n_read", 8), ("n_written", 8), ("n_dropped", 0)] {
        assert_eq!(told[key], expected, "{key}: {told}");
    }
    let of = |key: &str| told["latency_ms"][key].as_f64().unwrap();
    assert!(
        of("p50") <= of("p99") && of("p99") <= of("maximum"),
        "{told}"
    );
    let args = ["--pixels", "rgb24", "--late", "drop", "--fps", "1000"];
    let piped = pipe(dir.path(), &[&args, &SMALL[..]].concat(), &frames_of_rgb(2));
    let said = &piped.outcome.stderr;
    for words in [
        "2 frames read",
        "dropped",
        "ms p50",
        "ms p99",
        "ms maximum",
        "per second",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let quiet = [&args[..], &["--quiet"], &SMALL].concat();
    let piped = pipe(dir.path(), &quiet, &frames_of_rgb(2));
    assert_eq!(piped.outcome.stderr, "", "quiet");
}

#[test]
fn late_frames_are_dropped_and_counted_or_waited_for() {
    let dir = folder();
    let n_bytes = SIZE.0 as usize * SIZE.1 as usize * 3;
    let n = 40;
    for (late, may_drop) in [("drop", true), ("wait", false)] {
        let args = [
            "--pixels", "rgb24", "--fps", "200", "--late", late, "--json",
        ];
        let mut child = start(dir.path(), &[&args, &SMALL[..]].concat());
        let mut stdin = child.stdin.take().unwrap();
        let mut stdout = child.stdout.take().unwrap();
        let input = frames_of_rgb(n);
        let bytes = std::thread::scope(|scope| {
            scope.spawn(move || stdin.write_all(&input).unwrap());
            // Whoever reads takes his time: four frames fill the pipe, and those behind them wait.
            std::thread::sleep(Duration::from_millis(400));
            let mut bytes = Vec::new();
            stdout.read_to_end(&mut bytes).unwrap();
            bytes
        });
        let outcome = Outcome::from(child.wait_with_output().unwrap());
        assert_eq!(outcome.code, Some(0), "{late}: {outcome:?}");
        let told: Value = serde_json::from_str(outcome.stderr.lines().last().unwrap()).unwrap();
        let of = |key: &str| told[key].as_u64().unwrap();
        assert_eq!(of("n_read"), u64::from(n), "{told}");
        assert_eq!(of("n_written") + of("n_dropped"), u64::from(n), "{told}");
        assert_eq!(
            bytes.len(),
            n_bytes * usize::try_from(of("n_written")).unwrap(),
            "{told}"
        );
        assert_eq!(of("n_dropped") > 0, may_drop, "{told}");
        assert!(of("n_late") > 0, "one waited for its reader: {told}");
    }
}

#[test]
fn a_frame_that_is_left_out_leaves_the_others_as_they_are() {
    let dir = folder();
    let n_bytes = SIZE.0 as usize * SIZE.1 as usize * 3;
    let input = frames_of_rgb(40);
    let args = [
        "--pixels",
        "rgb24",
        "--fps",
        "200",
        "--light",
        "first",
        "--impact-at",
        "0.05",
    ];
    let all = pipe(dir.path(), &[&args, &SMALL[..]].concat(), &input).bytes;
    let mut child = start(
        dir.path(),
        &[&args[..], &["--late", "drop"], &SMALL].concat(),
    );
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    let some = std::thread::scope(|scope| {
        scope.spawn(|| {
            stdin.write_all(&input).unwrap();
            drop(stdin);
        });
        std::thread::sleep(Duration::from_millis(300));
        let mut bytes = Vec::new();
        stdout.read_to_end(&mut bytes).unwrap();
        bytes
    });
    child.wait().unwrap();
    let mut whole = all.chunks_exact(n_bytes);
    for (k, frame) in some.chunks_exact(n_bytes).enumerate() {
        assert!(whole.any(|other| other == frame), "frame {k}, in its order");
    }
    assert!(some.len() < all.len(), "some are left out");
}

#[test]
fn a_truncated_last_frame_is_an_error_that_says_what_is_missing() {
    let dir = folder();
    let input = frames_of_rgb(3);
    let args = [&["--pixels", "rgb24"], &SMALL[..]].concat();
    let piped = pipe(dir.path(), &args, &input[..input.len() - 1000]);
    assert_eq!(piped.outcome.code, Some(2), "{:?}", piped.outcome);
    let said = &piped.outcome.stderr;
    let named = "standard input ended within frame 2: 17432 of its 18432 bytes came, 1000 are missing, after 2 whole frames";
    assert!(said.contains(named), "{said}");
    assert!(said.contains("--size 96x64 and --pixels rgb24"), "{said}");
    assert_eq!(piped.bytes.len(), 2 * 18432, "whole frames are written");
    let none = pipe(dir.path(), &args, &[]);
    assert_eq!(none.outcome.code, Some(2), "{:?}", none.outcome);
    assert!(
        none.outcome.stderr.contains("no frame came"),
        "{:?}",
        none.outcome
    );
}

#[test]
fn a_reader_that_goes_away_ends_it_cleanly() {
    let dir = folder();
    let args = [&["--pixels", "rgb24", "--json"], &SMALL[..]].concat();
    let mut child = start(dir.path(), &args);
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    let frame = frames_of_rgb(1);
    let mut first = vec![0; frame.len()];
    let outcome = std::thread::scope(|scope| {
        let frame = &frame;
        scope.spawn(move || while stdin.write_all(frame).is_ok() {});
        stdout.read_exact(&mut first).unwrap();
        drop(stdout);
        Outcome::from(child.wait_with_output().unwrap())
    });
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("closed it"), "{outcome:?}");
    assert_ne!(first, frame, "one frame came");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it_with_its_summary() {
    let dir = folder();
    let args = [&["--pixels", "rgb24", "--json"], &SMALL[..]].concat();
    let mut child = start(dir.path(), &args);
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    let mut frame = frames_of_rgb(1);
    stdin.write_all(&frame).unwrap();
    stdout.read_exact(&mut frame).unwrap();
    // No more comes, and the input stays open.
    let id = child.id().to_string();
    let killed = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(killed.unwrap().success(), "kill");
    let outcome = Outcome::from(child.wait_with_output().unwrap());
    drop(stdin);
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(
        outcome.stderr.contains("1 frames read, 1 written"),
        "{outcome:?}"
    );
    assert!(
        outcome.stderr.contains("interrupted after 1 frames"),
        "{outcome:?}"
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let dir = folder();
    for (args, named) in [
        (vec!["--pixels", "yuv420p"], "yuv420p"),
        (vec!["--pixels", "gray", "--fps", "0"], "0"),
        (
            vec!["--pixels", "gray", "--impact-at", "-1"],
            "expected a time from 0 on",
        ),
        (
            vec!["--pixels", "gray", "--impact-at", "nan"],
            "expected a time from 0 on",
        ),
        (vec!["--pixels", "gray", "--growth-time", "1"], "--grow"),
        (
            vec!["--pixels", "gray", "--grow", "--growth-time", "0"],
            "--growth-time 0 s",
        ),
        (vec!["--pixels", "gray", "--preset", "papr"], "paper"),
        (vec!["--pixels", "gray", "--bank", "none"], "none"),
        (
            vec!["--pixels", "gray", "--overlay-gain", "2"],
            "--overlay-gain",
        ),
        (
            vec!["--pixels", "gray", "--preset", "noise", "--impact-at", "1"],
            "no glass breaks",
        ),
    ] {
        let piped = pipe(dir.path(), &args, &[1; 100]);
        let complaint = piped.outcome.complaint(named);
        assert_eq!(complaint, None, "{args:?}");
        assert!(piped.bytes.is_empty(), "{args:?}: nothing is written");
    }
    for (size, named) in [
        ("96", "WIDTHxHEIGHT"),
        ("0x4", "WIDTHxHEIGHT"),
        ("32768x32768", "px at most"),
    ] {
        let outcome = starbreak(dir.path(), &["pipe", "--pixels", "gray", "--size", size]);
        assert_eq!(outcome.complaint(named), None, "{size}");
    }
}

#[test]
fn a_bank_a_network_and_a_photo_give_their_damage() {
    let dir = folder();
    let bank = ["patterns", "-n", "2", "-o", "bank", "--size", "96x64"];
    succeed_small(dir.path(), &bank);
    succeed_small(dir.path(), &["simulate", "-o", "n.json", "--size", "96x64"]);
    std::fs::write(dir.path().join("glass.png"), png_bytes(&photo(SIZE))).unwrap();
    let raw = frames_of_rgb(2);
    let paper = ["--preset", "paper"];
    for args in [
        [&["--bank", "bank"], &[][..]].concat(),
        [&["--network", "n.json"], &paper[..]].concat(),
        [
            &["--overlay", "glass.png", "--overlay-background", "black"],
            &paper[..],
        ]
        .concat(),
    ] {
        let piped = pipe(
            dir.path(),
            &[&["--pixels", "rgb24"], &args[..]].concat(),
            &raw,
        );
        assert_eq!(piped.outcome.code, Some(0), "{args:?}: {:?}", piped.outcome);
        assert_ne!(piped.bytes, raw, "{args:?}: it shows");
    }
}
