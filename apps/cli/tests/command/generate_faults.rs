//! `starbreak generate` when something goes wrong: kills, full disks, broken and odd files.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::program::{
    Outcome, SMALL, SmallDisk, all_refused, folder, json, names, skipped, snapshot, starbreak,
    succeed, write_photo,
};
use serde_json::Value;

/// `generate` of a source into `out` with the small crack and more arguments.
fn args<'a>(source: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["generate", source, "-o", "out"], more, &SMALL].concat()
}

fn generate(dir: &Path, source: &str, more: &[&str]) -> Outcome {
    starbreak(dir, &args(source, more))
}

fn write_photos(folder: &Path, n: usize) {
    fs::create_dir_all(folder).unwrap();
    for k in 0..n {
        write_photo(&folder.join(format!("{k:04}.png")));
    }
}

fn lines(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Numbers in [0, 1) that repeat.
fn fractions() -> impl Iterator<Item = f64> {
    let mut state = 0x9e37_79b9_u32;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / 4_294_967_296.0
    })
}

#[test]
fn a_run_that_is_killed_at_twenty_moments_ends_as_an_undisturbed_one() {
    let dir = folder();
    let source = dir.path().join("in");
    for sub in ["image_2", "label_2"] {
        fs::create_dir_all(source.join(sub)).unwrap();
    }
    for k in 0..60 {
        write_photo(&source.join(format!("image_2/{k:06}.png")));
        fs::write(source.join(format!("label_2/{k:06}.txt")), "").unwrap();
    }
    let started = std::time::Instant::now();
    // With a fault behind the lens, too.
    let noise = ["--set", "noise.white_e=300"];
    let undisturbed = ["generate", "kitti:in", "-o", "undisturbed"];
    let undisturbed = [&undisturbed[..], &noise, &SMALL].concat();
    succeed(dir.path(), &undisturbed);
    let whole_run = started.elapsed();
    let (mut n_killed, mut n_killed_at_work) = (0, 0);
    for fraction in fractions().take(200) {
        let mut child = crate::program::command(dir.path(), &args("kitti:in", &noise))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // A run gets a fifth of the way at most, so that twenty kills fit before the end.
        std::thread::sleep(whole_run.mul_f64(0.2 * fraction));
        let had_ended = child.try_wait().unwrap().is_some();
        // SIGKILL.
        let _ = child.kill();
        child.wait().unwrap();
        n_killed += usize::from(!had_ended);
        let is_begun = dir.path().join("out/starbreak/run.json").exists();
        let is_finished = dir.path().join("out/starbreak/manifest.json").exists();
        n_killed_at_work += usize::from(!had_ended && is_begun && !is_finished);
        if is_finished {
            // Later kills hit the check of what is done, the lists and the labels.
            fs::remove_file(dir.path().join("out/starbreak/manifest.json")).unwrap();
            let images = dir.path().join("out/starbreak/provenance/image_2");
            for entry in fs::read_dir(images).unwrap().take(20) {
                fs::remove_file(entry.unwrap().path()).unwrap();
            }
        }
        if n_killed_at_work >= 20 {
            break;
        }
    }
    assert!(
        n_killed >= 20 && n_killed_at_work >= 20,
        "{n_killed} kills, {n_killed_at_work} at work"
    );
    let outcome = generate(dir.path(), "kitti:in", &[&["--json"][..], &noise].concat());
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(
        result["n_done_before"].as_u64().unwrap() > 0,
        "nothing was kept: {result}"
    );
    assert!(
        snapshot(&dir.path().join("out")) == snapshot(&dir.path().join("undisturbed")),
        "the sets differ: {:?} and {:?}",
        names(&dir.path().join("out")),
        names(&dir.path().join("undisturbed"))
    );
}

#[test]
fn a_corrupt_image_stops_nothing_and_is_listed() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 6);
    let good = fs::read(dir.path().join("in/0002.png")).unwrap();
    fs::write(dir.path().join("in/0002.png"), &good[..good.len() / 2]).unwrap();
    fs::write(dir.path().join("in/0004.png"), "not an image").unwrap();
    let outcome = generate(dir.path(), "folder:in", &[]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stderr.contains("0002.png") && outcome.stderr.contains("0004.png"),
        "{outcome:?}"
    );
    let failures = lines(&dir.path().join("out/starbreak/failures.jsonl"));
    let failed: Vec<_> = failures
        .iter()
        .map(|line| line["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        failed,
        ["0002.png", "0004.png"],
        "in the order of the source"
    );
    for k in [0, 1, 3, 5] {
        assert!(
            dir.path().join(format!("out/{k:04}.png")).is_file(),
            "{k} is made"
        );
    }
    for k in [2, 4] {
        assert!(
            !dir.path().join(format!("out/{k:04}.png")).exists(),
            "{k} is not"
        );
    }
    assert_eq!(
        json(&dir.path().join("out/starbreak/manifest.json"))["n_failed"],
        2
    );
    let outcome = starbreak(dir.path(), &["verify", "out"]);
    assert_eq!(
        outcome.code,
        Some(1),
        "a set that lacks images is not whole: {outcome:?}"
    );

    // Once they are mended the same command does them, and only them.
    fs::write(dir.path().join("in/0002.png"), &good).unwrap();
    fs::write(dir.path().join("in/0004.png"), &good).unwrap();
    let outcome = generate(dir.path(), "folder:in", &["--json"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(
        (&result["n_made"], &result["n_done_before"]),
        (&2.into(), &4.into()),
        "{result}"
    );
    assert!(
        !dir.path().join("out/starbreak/failures.jsonl").exists(),
        "nothing fails any more"
    );
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn a_run_stops_at_as_many_failures_as_asked() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 40);
    for k in 0..40 {
        fs::write(dir.path().join(format!("in/{k:04}.png")), "no image").unwrap();
    }
    for (more, most) in [(vec!["--fail-fast"], 1), (vec!["--max-failures", "4"], 5)] {
        let more = [&more[..], &["--threads", "1"]].concat();
        let outcome = generate(dir.path(), "folder:in", &more);
        assert_eq!(outcome.code, Some(1), "{more:?}: {outcome:?}");
        let n = lines(&dir.path().join("out/starbreak/failures.jsonl")).len();
        assert_eq!(n, most, "{more:?}");
        assert!(outcome.stderr.contains("not begun"), "{outcome:?}");
        assert!(
            !dir.path().join("out/starbreak/manifest.json").exists(),
            "it is not finished"
        );
    }
}

#[test]
fn an_image_that_vanishes_during_the_run_is_listed() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 80);
    let child = crate::program::command(dir.path(), &args("folder:in", &["--threads", "1"]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = dir.path().join("out/0001.png");
    for _ in 0..4000 {
        if begun.exists() {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    // The listing may have been read by now, so that it is not simply fewer images.
    let _ = fs::remove_file(dir.path().join("in/0079.png"));
    let outcome: Outcome = child.wait_with_output().unwrap().into();
    let is_listed = outcome.code == Some(1) && outcome.stderr.contains("0079.png");
    let was_late = outcome.code == Some(0) && dir.path().join("out/0079.png").exists();
    assert!(is_listed || was_late, "{outcome:?}");
    if was_late {
        skipped("vanishing image: the run was faster than the removal");
        return;
    }
    assert!(
        dir.path().join("out/0078.png").is_file(),
        "the others are made"
    );
}

#[test]
fn a_full_disk_ends_the_run_and_room_lets_it_go_on() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 12);
    let Some(disk) = SmallDisk::mount("400k") else {
        skipped("full disk: `mount -t tmpfs` is not allowed here");
        return;
    };
    let out = format!("{}/out", disk.root());
    let run = [&["generate", "folder:in", "-o", &out], &SMALL[..]].concat();
    let outcome = starbreak(dir.path(), &run);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("no space left"), "{outcome:?}");
    let left = names(Path::new(&out));
    assert!(
        !left.iter().any(|name| name.contains(".starbreak-")),
        "nothing half-written: {left:?}"
    );
    assert!(
        !left.iter().any(|name| name.ends_with("manifest.json")),
        "not finished"
    );
    assert!(
        left.iter().any(|name| name.ends_with("0000.json")),
        "something was done: {left:?}"
    );
    disk.resize("20m");
    let outcome = starbreak(dir.path(), &run);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    succeed(dir.path(), &["verify", &out]);
    succeed(dir.path(), &args("folder:in", &[]));
    assert!(
        snapshot(Path::new(&out)) == snapshot(&dir.path().join("out")),
        "as on a large disk"
    );
}

#[test]
fn labels_without_images_and_images_without_labels_are_named() {
    let dir = folder();
    for sub in ["image_2", "label_2"] {
        fs::create_dir_all(dir.path().join("in").join(sub)).unwrap();
    }
    for k in [0, 1] {
        write_photo(&dir.path().join(format!("in/image_2/{k:06}.png")));
    }
    let label = "Car 0 0 0 1 1 20 20 1 1 1 1 1 1 1\n";
    for k in [0, 7] {
        fs::write(dir.path().join(format!("in/label_2/{k:06}.txt")), label).unwrap();
    }
    let outcome = generate(dir.path(), "kitti:in", &[]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(
        outcome.stderr.contains("000001"),
        "an image without labels: {outcome:?}"
    );
    assert!(
        outcome.stderr.contains("--on-error skip"),
        "the way out: {outcome:?}"
    );
    assert!(!dir.path().join("out").exists(), "nothing is written");

    let outcome = generate(dir.path(), "kitti:in", &["--on-error", "skip"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let skipped = lines(&dir.path().join("out/starbreak/skipped.jsonl"));
    assert!(
        skipped
            .iter()
            .any(|line| line.to_string().contains("000001")),
        "{skipped:?}"
    );
    assert_eq!(
        names(&dir.path().join("out/image_2")).len(),
        2,
        "the image itself stands"
    );
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn a_label_that_cannot_be_read_is_named_with_its_line() {
    let dir = folder();
    for sub in ["image_2", "label_2"] {
        fs::create_dir_all(dir.path().join("in").join(sub)).unwrap();
    }
    write_photo(&dir.path().join("in/image_2/000000.png"));
    let labels = "Car 0 0 0 1 1 20 20 1 1 1 1 1 1 1\nCar 0 0 0 nan 1 20 20 1 1 1 1 1 1 1\n";
    fs::write(dir.path().join("in/label_2/000000.txt"), labels).unwrap();
    let outcome = generate(dir.path(), "kitti:in", &[]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(
        outcome.stderr.contains("label_2/000000.txt:2"),
        "{outcome:?}"
    );
}

#[test]
fn odd_names_come_through() {
    let dir = folder();
    let odd = [
        "a b.png",
        "ünï/日本.png",
        "new\nline.png",
        "quote\".png",
        "-dash.png",
        "a.b.c.png",
    ];
    for name in odd {
        let path = dir.path().join("in").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        write_photo(&path);
    }
    succeed(dir.path(), &args("folder:in", &[]));
    for name in odd {
        assert!(dir.path().join("out").join(name).is_file(), "{name:?}");
    }
    succeed(
        dir.path(),
        &[
            "verify",
            "out",
            "--regenerate",
            "all",
            "--source",
            "folder:in",
        ],
    );
}

#[test]
fn names_that_would_collide_or_cannot_be_told_are_refused() {
    let dir = folder();
    let case = |names: &[&OsStr]| {
        let source = dir.path().join("in");
        let _ = fs::remove_dir_all(&source);
        let _ = fs::remove_dir_all(dir.path().join("out"));
        write_photos(&source, 1);
        for name in names {
            write_photo(&source.join(name));
        }
        let stopped = generate(dir.path(), "folder:in", &[]);
        assert_eq!(stopped.code, Some(2), "{names:?}: {stopped:?}");
        assert!(
            !dir.path().join("out").exists(),
            "{names:?}: nothing is written"
        );
        let outcome = generate(dir.path(), "folder:in", &["--on-error", "skip"]);
        assert_eq!(outcome.code, Some(0), "{names:?}: {outcome:?}");
        let skipped = lines(&dir.path().join("out/starbreak/skipped.jsonl"));
        assert!(!skipped.is_empty(), "{names:?}");
        succeed(dir.path(), &["verify", "out"]);
    };
    case(&["a.png", "A.png"].map(OsStr::new));
    case(&["a.png", "a.jpg"].map(OsStr::new));
    case(&[OsStr::from_bytes(b"not-utf8-\xff.png")]);
}

#[test]
fn a_source_that_cannot_be_written_is_no_hindrance() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 2);
    let set = |mode| {
        for path in ["in", "in/0000.png", "in/0001.png"] {
            fs::set_permissions(dir.path().join(path), fs::Permissions::from_mode(mode)).unwrap();
        }
    };
    set(0o555);
    let before = snapshot(&dir.path().join("in"));
    let outcome = generate(dir.path(), "folder:in", &[]);
    set(0o755);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(
        before == snapshot(&dir.path().join("in")),
        "the source is as it was"
    );
}

#[test]
fn output_and_input_must_not_lie_in_each_other() {
    let dir = folder();
    write_photos(&dir.path().join("in/deep"), 2);
    symlink("in", dir.path().join("alias")).unwrap();
    let to = |source: &'static str, out: &'static str| -> Vec<&'static str> {
        [&["generate", source, "-o", out], &SMALL[..]].concat()
    };
    all_refused(
        dir.path(),
        &[
            (to("folder:in", "in/out"), "lie in each other"),
            (to("folder:in", "in"), "lie in each other"),
            (to("folder:in", "alias/out"), "lie in each other"),
            (to("folder:in/deep", "in"), "lie in each other"),
            (to("folder:in", "."), "lie in each other"),
        ],
    );
}

#[test]
fn two_runs_at_once_do_not_share_a_folder() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 60);
    let mut first = crate::program::command(dir.path(), &args("folder:in", &["--threads", "1"]))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = dir.path().join("out/0000.png");
    for _ in 0..4000 {
        if begun.exists() {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let second = generate(dir.path(), "folder:in", &[]);
    let first_had_ended = first.try_wait().unwrap().is_some();
    assert_eq!(
        first.wait().unwrap().code(),
        Some(0),
        "the first is not disturbed"
    );
    if second.code == Some(0) && first_had_ended {
        skipped("two runs at once: the first was too fast");
        return;
    }
    assert_eq!(second.code, Some(2), "{second:?}");
    assert!(
        second.stderr.contains("in use by another run"),
        "{second:?}"
    );
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn ctrl_c_keeps_what_is_done_and_the_same_command_goes_on() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 120);
    let child = crate::program::command(dir.path(), &args("folder:in", &["--threads", "1"]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = dir.path().join("out/0002.png");
    for _ in 0..4000 {
        if begun.exists() {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    Command::new("kill").args(["-INT", &id]).status().unwrap();
    let outcome: Outcome = child.wait_with_output().unwrap().into();
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(
        outcome.stderr.contains("the same command goes on"),
        "{outcome:?}"
    );
    let left = names(&dir.path().join("out"));
    assert!(
        !left.iter().any(|name| name.contains(".starbreak-")),
        "{left:?}"
    );
    let outcome = generate(dir.path(), "folder:in", &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(result["n_done_before"].as_u64().unwrap() >= 3, "{result}");
    assert_eq!(result["finished"], true, "{result}");
}

#[test]
fn bad_command_lines_are_refused() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 2);
    fs::create_dir(dir.path().join("empty")).unwrap();
    let with = |source: &'static str, more: &[&'static str]| args(source, more);
    all_refused(
        dir.path(),
        &[
            (with("in", &[]), "folder:in"),
            (with("voc:in", &[]), "kitti"),
            (with("folder:", &[]), "no path"),
            (with("folder:nowhere", &[]), "nowhere"),
            (with("folder:empty", &[]), "no image"),
            (with("folder:in", &["--limit", "0"]), "no image"),
            (with("folder:in", &["--samples", "0"]), "--samples"),
            (with("folder:in", &["--shard", "3/2"]), "--shard"),
            (with("folder:in", &["--shard", "0/2"]), "--shard"),
            (
                with("folder:in", &["--limit", "1", "--sample", "1"]),
                "--sample",
            ),
            (
                with("folder:in", &["--set", "output.format=\"jpeg\""]),
                "output.format",
            ),
            (with("kitti:in", &[]), "image_2"),
            (vec!["verify", "in"], "not a generated set"),
            (vec!["verify", "in", "--regenerate", "2"], "--source"),
        ],
    );
}
