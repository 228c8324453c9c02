//! `starbreak video` where the clip, the disk or ffmpeg itself fails: one line, and nothing left.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::clip::Studio;
use crate::program::{Outcome, snapshot};

/// What speaks against a failure with this code in one line with these words, which leaves the folder as it was.
fn refused(studio: &Studio, args: &[&str], code: i32, named: &str) -> Option<String> {
    let before = snapshot(studio.path());
    let outcome = studio.video(&[args, &["--quiet"]].concat());
    let is_one_line = outcome.stderr.starts_with("error: ")
        && outcome.stderr.lines().count() == 1
        && outcome.stderr.contains(named);
    let is_as_before = snapshot(studio.path()) == before;
    (outcome.code != Some(code) || !is_one_line || !is_as_before).then(|| {
        format!("{args:?}: expected {code} and {named:?}, folder kept: {is_as_before}; {outcome:?}")
    })
}

fn none(complaints: Vec<Option<String>>) {
    let complaints: Vec<String> = complaints.into_iter().flatten().collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// A program in the place of ffmpeg: a shell script in which `$REAL` is the real one.
fn with_stand_in(studio: &Studio, script: &str) -> Studio {
    let dir = crate::program::folder();
    let ffmpeg = dir.path().join("stand-in.sh");
    let real = studio.ffmpeg.display();
    fs::write(&ffmpeg, format!("#!/bin/sh\nREAL='{real}'\n{script}\n")).unwrap();
    fs::set_permissions(&ffmpeg, fs::Permissions::from_mode(0o755)).unwrap();
    fs::copy(studio.path().join("in.mkv"), dir.path().join("in.mkv")).unwrap();
    Studio { dir, ffmpeg }
}

#[test]
fn what_is_no_clip_is_refused() {
    let Some(studio) = Studio::open() else { return };
    let write = |name: &str, bytes: &[u8]| fs::write(studio.path().join(name), bytes).unwrap();
    write("text.mp4", b"this is a text\n");
    write("empty.mp4", b"");
    studio.ffmpeg(&["-f", "lavfi", "-i", "sine=d=1", "-c:a", "aac", "sound.m4a"]);
    none(vec![
        refused(
            &studio,
            &["text.mp4", "-o", "a.mp4"],
            2,
            "cannot be read as a clip",
        ),
        refused(&studio, &["empty.mp4", "-o", "a.mp4"], 2, "is empty"),
        refused(
            &studio,
            &["sound.m4a", "-o", "a.mp4"],
            2,
            "has no video stream",
        ),
        refused(&studio, &["nowhere.mp4", "-o", "a.mp4"], 2, "no such file"),
        refused(
            &studio,
            &["sound.m4a", "-o", "sound.m4a"],
            2,
            "choose another name",
        ),
    ]);
}

#[test]
fn a_damaged_clip_is_refused_in_all_containers() {
    let Some(studio) = Studio::open() else { return };
    let mut complaints = Vec::new();
    for name in ["c.mkv", "c.mp4", "c.avi"] {
        studio.make(
            "s=320x240:r=25:d=2",
            "-c:v libx264 -g 25 -movflags +faststart",
            name,
        );
        let bytes = fs::read(studio.path().join(name)).unwrap();
        let half = bytes.len() / 2;
        fs::write(studio.path().join(format!("cut_{name}")), &bytes[..half]).unwrap();
        let mut flipped = bytes;
        for byte in &mut flipped[half..half + 400] {
            *byte ^= 0x5a;
        }
        fs::write(studio.path().join(format!("flipped_{name}")), flipped).unwrap();
        for kind in ["cut", "flipped"] {
            let input = format!("{kind}_{name}");
            complaints.push(refused(
                &studio,
                &[&input, "-o", "a.mp4"],
                2,
                "repair it first",
            ));
        }
    }
    none(complaints);
}

#[test]
fn a_clip_that_is_cut_in_its_audio_or_between_packets_is_refused() {
    let Some(studio) = Studio::open() else { return };
    let mut complaints = Vec::new();
    for (name, codecs) in [
        ("c.avi", "-c:v libx264 -c:a libmp3lame"),
        (
            "c.mp4",
            "-c:v libx264 -c:a aac -movflags frag_keyframe+empty_moov",
        ),
        ("d.mp4", "-c:v libx264 -c:a aac -movflags +faststart"),
        // Its index is at the end: ffmpeg takes what is left of it for all.
        ("e.mp4", "-c:v libx264 -c:a aac"),
    ] {
        let both = format!("-f lavfi -i sine=440:d=1 {codecs}");
        studio.make("s=160x120:r=25:d=1", &both, name);
        let bytes = fs::read(studio.path().join(name)).unwrap();
        let near_end = [20, 300, 700, 1100, 1500].map(|n| bytes.len() - n);
        for n_bytes in (1..12).map(|part| bytes.len() * part / 12).chain(near_end) {
            let input = format!("cut_{name}");
            fs::write(studio.path().join(&input), &bytes[..n_bytes]).unwrap();
            let complaint = refused(&studio, &[&input, "-o", "a.mp4"], 2, "repair it first");
            complaints.push(complaint.map(|why| format!("{n_bytes} bytes of {name}: {why}")));
        }
    }
    none(complaints);
}

#[test]
fn a_cut_clip_is_refused_though_a_complaint_ends_a_line_about_a_frame() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=320x240:r=25:d=2", "-c:v libx264 -g 25", "in.mkv");
    let path = studio.path().join("in.mkv");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    // As ffmpeg's threads do it now and then, in one run of thirty or so.
    let script = r#"exec 3>&1
case "$*" in *showinfo*) "$REAL" "$@" 2>&1 >&3 3>&- |
    sed -u 's/^.*\[error\] File ended/[Parsed_showinfo_0 @ 0x1] [info] color_range:tvFile ended/' >&2;;
*) exec "$REAL" "$@";; esac"#;
    let studio = with_stand_in(&studio, script);
    none(vec![refused(
        &studio,
        &["in.mkv", "-o", "a.mp4"],
        2,
        "repair it first",
    )]);
}

#[test]
fn an_absent_ffmpeg_says_how_to_get_one() {
    let dir = crate::program::folder();
    fs::write(dir.path().join("in.mp4"), "not empty").unwrap();
    for (ffmpeg, named) in [("no/ffmpeg", "apt"), ("/bin/echo", "is not ffmpeg")] {
        let args = ["video", "in.mp4", "-o", "a.mp4", "--ffmpeg", ffmpeg];
        let outcome = crate::program::starbreak_small(dir.path(), &args);
        let named = if named == "apt" {
            "package ffmpeg"
        } else {
            named
        };
        assert_eq!(outcome.complaint(named), None, "{ffmpeg}");
    }
    assert_eq!(
        crate::program::names(dir.path()),
        ["in.mp4"],
        "nothing is left"
    );
}

#[test]
fn an_ffmpeg_that_is_killed_leaves_nothing() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=320x240:r=25:d=4", "-c:v ffv1", "in.mkv");
    let encoder = r#"case "$*" in *libx264*) head -c 2000000 >/dev/null; kill -9 $$;; esac
exec "$REAL" "$@""#;
    // At the speed of the clip, which is not at its end by then.
    let decoder = r#"case "$*" in *rawvideo*) "$REAL" -re "$@" & sleep 0.5; kill -9 $!; kill -9 $$;; esac
exec "$REAL" "$@""#;
    let (encoder, decoder) = (
        with_stand_in(&studio, encoder),
        with_stand_in(&studio, decoder),
    );
    none(vec![
        refused(&encoder, &["in.mkv", "-o", "a.mp4"], 1, "signal: 9"),
        refused(&decoder, &["in.mkv", "-o", "a.mp4"], 2, "signal: 9"),
        refused(&decoder, &["in.mkv", "-o", "frames/"], 2, "signal: 9"),
    ]);
}

#[test]
fn a_script_around_ffmpeg_does_not_hold_up_the_end() {
    let Some(studio) = Studio::open() else { return };
    studio.make(
        "s=320x240:r=25:d=60",
        "-c:v libx264 -preset ultrafast",
        "in.mkv",
    );
    // At the speed of the clip, and not in the place of the shell.
    let script = r#"case "$*" in *rawvideo*) "$REAL" -re "$@"; exit;; esac
"$REAL" "$@"; exit"#;
    let studio = with_stand_in(&studio, script);
    let started = Instant::now();
    none(vec![refused(
        &studio,
        &["in.mkv", "-o", "a.mp4", "--masks", "in.mkv"],
        2,
        "not a folder",
    )]);
    assert!(started.elapsed().as_secs() < 55, "the clip lasts 60 s");
}

#[test]
fn an_ffmpeg_without_the_encoder_says_what_to_do() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=320x240:r=25:d=1", "-c:v ffv1", "in.mkv");
    let script = r#"for a in "$@"; do shift; [ "$a" = libx264 ] && a=libx26four; set -- "$@" "$a"; done
exec "$REAL" "$@""#;
    let studio = with_stand_in(&studio, script);
    none(vec![refused(
        &studio,
        &["in.mkv", "-o", "a.mp4"],
        1,
        "choose .avi",
    )]);
}

#[test]
fn a_file_that_may_not_grow_leaves_nothing() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=320x240:r=25:d=4", "-c:v libx264", "in.mkv");
    let before = snapshot(studio.path());
    let outcome: Outcome = Command::new("sh")
        .args([
            "-c",
            "ulimit -f 40; exec \"$@\"",
            "sh",
            env!("CARGO_BIN_EXE_starbreak"),
        ])
        .args(studio.args(&["in.mkv", "-o", "a.mkv", "--lossless"]))
        .current_dir(studio.path())
        .output()
        .unwrap()
        .into();
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("cannot be written"), "{outcome:?}");
    assert!(snapshot(studio.path()) == before, "nothing is left");
}

#[test]
fn an_interrupted_clip_leaves_nothing() {
    let Some(studio) = Studio::open() else { return };
    studio.make(
        "s=320x240:r=25:d=40",
        "-c:v libx264 -preset ultrafast",
        "in.mp4",
    );
    let before = snapshot(studio.path());
    let child = crate::program::command(
        studio.path(),
        &studio.args(&["in.mp4", "-o", "new/a.mkv", "--masks", "m"]),
    )
    .stdout(Stdio::piped())
    .stderr(Stdio::piped())
    .spawn()
    .unwrap();
    let started = Instant::now();
    while !studio.path().join("m").exists() {
        assert!(started.elapsed().as_secs() < 60, "nothing began");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success(), "the command had ended before");
    let outcome: Outcome = child.wait_with_output().unwrap().into();
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(
        outcome.stderr.contains("nothing was written"),
        "{outcome:?}"
    );
    assert!(snapshot(studio.path()) == before, "nothing is left");
}
