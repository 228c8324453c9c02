//! Recipes whose keys are in range and that would take gigabytes or minutes: each runs within a bound
//! of memory and time, or is refused before the work with the key to change.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::{Outcome, all_refused, folder, photo, png_bytes, write_photo};

/// Runs the command with 3 GB of addresses and 40 s of a processor, beyond which it is ended.
fn within_bounds(dir: &Path, args: &[&str]) -> Outcome {
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 3000000; ulimit -t 40; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_starbreak"))
        .args(args)
        .args(["--threads", "1"])
        .current_dir(dir)
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .output();
    output.unwrap().into()
}

fn set<'a>(keys: &[&'a str]) -> Vec<&'a str> {
    keys.iter().flat_map(|key| ["--set", *key]).collect()
}

#[test]
fn discs_of_any_size_are_spread_in_little_room_and_time() {
    let dir = folder();
    write_photo(&dir.path().join("small.png"));
    fs::write(dir.path().join("kitti.png"), png_bytes(&photo((1242, 375)))).unwrap();
    let tele = set(&[
        "camera.focal_length_mm=300",
        "camera.f_number=2.8",
        "camera.pixel_pitch_um=4",
    ]);
    let portrait = set(&[
        "camera.focal_length_mm=85",
        "camera.f_number=1.4",
        "camera.pixel_pitch_um=4",
    ]);
    let narrow = set(&["camera.f_px=1e6"]);
    let all = set(&[
        "camera.f_px=1e6",
        "camera.focal_length_mm=1000",
        "camera.f_number=0.5",
        "camera.focus_distance_m=infinity",
        "glass.distance_m=0.001",
    ]);
    for preset in ["windshield-star", "windshield-spiderweb", "lens-cover-star"] {
        for keys in [&tele, &portrait, &narrow, &all] {
            for image in ["kitti.png", "small.png"] {
                let args = ["crack", image, "-o", "out", "--preset", preset];
                let outcome = within_bounds(dir.path(), &[&args[..], keys].concat());
                assert_eq!(outcome.code, Some(0), "{preset}, {keys:?}: {outcome:?}");
            }
        }
    }
}

#[test]
fn a_phone_behind_its_glass_takes_seconds_at_12_megapixels() {
    let dir = folder();
    fs::write(dir.path().join("a.png"), png_bytes(&photo((4000, 3000)))).unwrap();
    let args = ["crack", "a.png", "-o", "out", "--camera", "phone"];
    let outcome = within_bounds(dir.path(), &args);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn crowds_of_particles_and_hits_are_refused_before_the_work() {
    let dir = folder();
    fs::write(dir.path().join("one.png"), png_bytes(&photo((1, 1)))).unwrap();
    for (preset, keys, named) in [
        ("paper", "fracture.particles=20000", "take fewer particles"),
        ("paper", "fracture.branches=3", "neighbour_radius_px"),
        ("windshield-gravel", "impact.count=1000", "impact.0.count"),
        ("lens-cover-star", "impact.count=121", "impact.count = 121"),
        ("tempered-cover", "impact.count=600", "impact.count = 600"),
    ] {
        let args = ["crack", "one.png", "-o", "out", "--preset", preset];
        let outcome = within_bounds(dir.path(), &[&args[..], &set(&[keys])].concat());
        assert_eq!(outcome.complaint(named), None, "{preset}, {keys}");
    }
    // What the presets ask for, and more.
    let args = [
        "simulate",
        "-o",
        "network.json",
        "--preset",
        "paper",
        "--size",
        "1x1",
    ];
    let outcome = within_bounds(dir.path(), &args);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn every_verb_refuses_what_takes_more_memory_than_it_may() {
    let dir = folder();
    let frames = dir.path().join("frames");
    fs::create_dir(&frames).unwrap();
    for name in ["0.png", "1.png"] {
        fs::write(frames.join(name), png_bytes(&photo((800, 600)))).unwrap();
    }
    let (image, phone) = (
        "frames/0.png",
        ["--camera", "phone", "--max-memory", "64MiB"],
    );
    let showing = "raise camera.f_number or glass.distance_m), or raise that limit (--max-memory";
    let laminate = ["--preset", "windshield-spiderweb", "--max-memory", "64MiB"];
    let cases = [
        (vec!["crack", image, "-o", "out"], showing),
        (
            vec!["sweep", image, "-o", "out", "--over", "camera.f_number=2,4"],
            showing,
        ),
        (vec!["demo", "-o", "out"], showing),
        (
            vec!["patterns", "-n", "1", "-o", "out", "--size", "800x600"],
            showing,
        ),
        (vec!["video", "frames", "-o", "out", "--fps", "10"], showing),
        (
            vec!["pipe", "--size", "800x600", "--pixels", "gray"],
            showing,
        ),
    ]
    .map(|(args, named)| {
        (
            [
                &args[..],
                &phone,
                &["--preset", "lens-cover-star", "--set", "fracture.mesh=fast"],
            ]
            .concat(),
            named,
        )
    });
    // The stress of its plate takes more than it may.
    let breaking = ["simulate", "-o", "network.json"];
    let mut cases = cases.to_vec();
    cases.push((
        [&breaking[..], &laminate].concat(),
        "set fracture.mesh = \"fast\", or raise",
    ));
    all_refused(dir.path(), &cases);
}

#[test]
fn frames_of_any_size_are_refused_before_there_is_one() {
    let dir = folder();
    let args = ["patterns", "-n", "1", "-o", "out", "--size", "32000x32000"];
    let outcome = within_bounds(dir.path(), &[&args[..], &["--camera", "phone"]].concat());
    assert_eq!(outcome.complaint("more than the 4.0 GiB"), None);
}

#[test]
fn an_image_of_a_set_that_takes_too_much_fails_by_itself() {
    let dir = folder();
    let images = dir.path().join("images");
    fs::create_dir(&images).unwrap();
    write_photo(&images.join("small.png"));
    fs::write(images.join("large.png"), png_bytes(&photo((1000, 800)))).unwrap();
    let args = [
        "generate",
        "folder:images",
        "-o",
        "set",
        "--preset",
        "lens-cover-star",
    ];
    let limit = [
        "--camera",
        "phone",
        "--max-memory",
        "80MiB",
        "--set",
        "fracture.mesh=fast",
    ];
    let outcome = within_bounds(dir.path(), &[&args[..], &limit].concat());
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let failures = fs::read_to_string(dir.path().join("set/starbreak/failures.jsonl")).unwrap();
    assert!(
        failures.contains("large.png") && failures.contains("--max-memory"),
        "{failures}"
    );
    assert!(!failures.contains("small.png"), "{failures}");
}
