//! `starbreak video` with damage out of a bank, and with a photograph of broken glass.

use std::fs;
use std::path::Path;

use crate::clip::states;
use crate::program::{all_refused, folder, json, names, photo, png_bytes, starbreak, succeed};
use image::{GrayImage, Luma};

/// Six equal frames, and a photograph of white rays on black.
fn write_inputs(dir: &Path) {
    fs::create_dir(dir.join("in")).unwrap();
    let frame = png_bytes(&photo((160, 100)));
    for k in 1..=6 {
        fs::write(dir.join(format!("in/f{k}.png")), &frame).unwrap();
    }
    let star = GrayImage::from_fn(160, 100, |x, y| {
        let (u, v) = (f64::from(x) - 80.0, f64::from(y) - 50.0);
        let is_ray = (v.atan2(u) * 5.0).sin().abs() > 0.9 && u.hypot(v) < 45.0;
        Luma([if is_ray { 230 } else { 2 }])
    });
    fs::write(dir.join("star.png"), png_bytes(&star.into())).unwrap();
}

fn video<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let args = ["video", "in", "-o", out, "--fps", "10", "--masks"];
    [&args[..], more].concat()
}

#[test]
fn a_pattern_of_a_bank_is_shown_and_grows() {
    let dir = folder();
    write_inputs(dir.path());
    let made = ["patterns", "-n", "3", "-o", "bank", "--size", "160x100"];
    for (preset, fast) in [
        ("paper", "fracture.particles=1500"),
        ("windshield-star", "fracture.mesh=fast"),
    ] {
        let recipe = ["--preset", preset, "--set", fast, "--replace"];
        succeed(dir.path(), &[&made[..], &recipe].concat());
        let bank = ["--bank", "bank"];
        let [still, grown] = [format!("{preset}-still"), format!("{preset}-grown")];
        let [masks_a, masks_b] = [format!("{still}-m"), format!("{grown}-m")];
        succeed(
            dir.path(),
            &video(&still, &[&[masks_a.as_str()], &bank[..]].concat()),
        );
        let grow = ["--grow", "--growth-time", "0.3"];
        let more = [&[masks_b.as_str()], &bank[..], &grow[..]].concat();
        succeed(dir.path(), &video(&grown, &more));

        let track = json(&dir.path().join(format!("{still}.track.json")));
        let idx = track["pattern"]["idx"].as_u64().unwrap();
        assert!(idx < 3, "{preset}: one of the bank");
        assert_eq!(states(&track), "ssssss", "{preset}: all at once");
        let network = json(&dir.path().join(format!("{still}.network.json")));
        let n_segments = network["segments"]["from"].as_array().unwrap().len();
        assert_eq!(
            track["network"]["summary"]["n_segments"], n_segments,
            "{preset}: its network"
        );
        let track = json(&dir.path().join(format!("{grown}.track.json")));
        assert_eq!(states(&track), "ggssss", "{preset}: it grows");
        let lengths: Vec<f64> = track["frames"]
            .as_array()
            .unwrap()
            .iter()
            .map(|frame| frame["crack_length_px"].as_f64().unwrap())
            .collect();
        assert!(
            lengths[0] < lengths[1] && lengths[1] < lengths[2] && lengths[2] > 20.0,
            "{preset}: {lengths:?}"
        );
        let read = |folder: &str, name| fs::read(dir.path().join(folder).join(name)).unwrap();
        for name in ["f3.png", "f6.png"] {
            assert!(
                read(&still, name) == read(&grown, name),
                "{preset}, {name}: the same once it is grown"
            );
        }
        assert!(
            read(&still, "f1.png") != read(&grown, "f1.png"),
            "{preset}: and not before"
        );
        assert!(
            read(&still, "f1.png") != read("in", "f1.png"),
            "{preset}: nothing to see"
        );
        // How frames are written is said by the run, not by the recipe of the bank.
        let jpeg = [&["mj", "--set", "output.format=jpeg"], &bank[..]].concat();
        succeed(dir.path(), &video("jpeg", &jpeg));
        let written = names(&dir.path().join("jpeg"));
        assert_eq!(written[0], "f1.jpg", "{preset}: {written:?}");
        for folder in ["jpeg", "mj"] {
            fs::remove_dir_all(dir.path().join(folder)).unwrap();
        }
    }
}

#[test]
fn a_photograph_of_glass_is_shown_as_crack_shows_it() {
    let dir = folder();
    write_inputs(dir.path());
    for preset in ["windshield-star", "paper"] {
        let glass = ["--overlay", "star.png", "--preset", preset];
        let masks = format!("{preset}-m");
        let impact = ["--impact-at", "0.2"];
        let more = [&[masks.as_str()], &glass[..], &impact[..]].concat();
        succeed(dir.path(), &video(preset, &more));
        let out = format!("{preset}-image");
        succeed(
            dir.path(),
            &[&["crack", "in/f3.png", "-o", &out][..], &glass].concat(),
        );
        let read = |folder: &str, name: &str| fs::read(dir.path().join(folder).join(name)).unwrap();
        assert!(
            read(preset, "f3.png") == read(&out, "f3.png"),
            "{preset}: the same picture"
        );
        assert!(
            read(preset, "f1.png") == read("in", "f1.png"),
            "{preset}: nothing before the impact"
        );
        assert_eq!(names(&dir.path().join(&masks)).len(), 12, "{preset}: masks");
        let track = json(&dir.path().join(format!("{preset}.track.json")));
        assert_eq!(states(&track), "iissss", "{preset}: at 0.2 s");
        assert_eq!(track["overlay"]["name"], "star.png", "{preset}: which");
        assert!(track["network"].is_null(), "{preset}: no network");
        assert!(
            track["frames"][3]["crack_length_px"].is_null(),
            "{preset}: no length"
        );
        let network = dir.path().join(format!("{preset}.network.json"));
        assert!(!network.exists(), "{preset}: no file of a network");
    }
}

#[test]
fn sources_that_exclude_each_other_are_refused() {
    let dir = folder();
    write_inputs(dir.path());
    let mut cases = Vec::new();
    for (more, named) in [
        (vec!["m", "--overlay", "star.png", "--grow"], "--grow"),
        (
            vec!["m", "--overlay", "star.png", "--growth-time", "1"],
            "--growth-time",
        ),
        (vec!["m", "--overlay", "star.png", "--bank", "b"], "--bank"),
        (vec!["m", "--overlay", "none.png"], "none.png"),
        (vec!["m", "--overlay-random"], "--overlay"),
        (vec!["m", "--overlay-gain", "2"], "--overlay"),
        (vec!["m", "--bank", "none"], "none"),
        (vec!["m", "--bank", "b", "--preset", "paper"], "--preset"),
    ] {
        cases.push((video("out", &more), named));
    }
    all_refused(dir.path(), &cases);
    let outcome = starbreak(dir.path(), &["video", "--help"]);
    assert!(outcome.stdout.contains("--overlay"), "{outcome:?}");
}

/// The bank is read, so no output takes its place; and a photograph leaves no network of an earlier run.
#[test]
fn banks_stay_and_networks_of_earlier_runs_go() {
    let dir = folder();
    write_inputs(dir.path());
    let size = ["--size", "160x100"];
    let paper = ["--preset", "paper", "--set", "fracture.particles=1500"];
    let made = ["patterns", "-n", "1", "-o", "bank"];
    succeed(dir.path(), &[&made[..], &size, &paper].concat());
    let bank = dir.path().join("bank/patterns.bank");
    let mut cases = Vec::new();
    for name in ["out.network.json", "out.track.json"] {
        fs::copy(&bank, dir.path().join(name)).unwrap();
        let more = ["m", "--replace", "--bank", name];
        cases.push((video("out", &more), "would replace the bank"));
    }
    fs::create_dir(dir.path().join("glass")).unwrap();
    fs::copy(dir.path().join("star.png"), dir.path().join("glass/s.png")).unwrap();
    let photos = ["patterns", "-n", "1", "-o", "photos", "--overlays", "glass"];
    succeed(dir.path(), &[&photos[..], &size].concat());
    cases.push((
        video("out", &["m", "--bank", "photos"]),
        "is a bank of photos",
    ));
    all_refused(dir.path(), &cases);

    let there = |name: &str| dir.path().join(name).exists();
    succeed(dir.path(), &video("a", &["ma", "--bank", "bank"]));
    assert!(there("a.network.json"), "written");
    for folder in ["a", "ma"] {
        fs::remove_dir_all(dir.path().join(folder)).unwrap();
    }
    succeed(dir.path(), &video("a", &["ma", "--overlay", "star.png"]));
    assert!(!there("a.network.json"), "of another crack");
    // A file of somebody else's is in nobody's way.
    fs::write(dir.path().join("b.network.json"), "mine").unwrap();
    succeed(dir.path(), &video("b", &["mb", "--overlay", "star.png"]));
    let mine = fs::read_to_string(dir.path().join("b.network.json"));
    assert_eq!(mine.unwrap(), "mine", "it stays");
}
