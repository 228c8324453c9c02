//! `starbreak video`: what is kept of a clip, and what the crack does to it.

use crate::clip::{Studio, states};
use crate::program::names;

/// As many frames at the same times, to the tolerance of a container, s.
fn same_times(found: &[f64], expected: &[f64], tolerance_s: f64, clip: &str) {
    assert_eq!(found.len(), expected.len(), "{clip}: frames");
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let off_s = (found - expected).abs();
        assert!(
            off_s <= tolerance_s,
            "{clip}: frame {k} at {found} s, not {expected} s"
        );
    }
}

#[test]
fn frames_rate_and_audio_are_kept_in_every_container() {
    let Some(studio) = Studio::open() else { return };
    let audio = "-f lavfi -i sine=440:d=1.5 -c:v libx264 -pix_fmt yuv420p -c:a libmp3lame";
    studio.make("s=160x120:r=30000/1001:d=1.5", audio, "in.mp4");
    let (times, sound_s) = studio.times("in.mp4");
    assert_eq!(times.len(), 45, "frames of the input");
    for (output, tolerance_s) in [
        ("a.mp4", 1e-9),
        ("a.mov", 1e-9),
        ("a.mkv", 6e-4),
        ("a.avi", 1e-3),
    ] {
        studio.succeed(&["in.mp4", "-o", output, "--replace"]);
        let (found, found_sound_s) = studio.times(output);
        same_times(&found, &times, tolerance_s, output);
        assert_eq!(
            studio.audio(output),
            studio.audio("in.mp4"),
            "{output}: audio"
        );
        let apart = |sound: Option<f64>, video: &[f64]| sound.unwrap() - video[0];
        let shift_s = apart(found_sound_s, &found) - apart(sound_s, &times);
        // A packet of audio lasts 26 ms; AVI keeps no time of its start.
        let most_s = if output.ends_with("avi") {
            0.05
        } else {
            1.1e-3
        };
        assert!(shift_s.abs() < most_s, "{output}: audio off by {shift_s} s");
        assert!(
            studio.described(output).contains("29.97 fps"),
            "{output}: rate"
        );
        let track = studio.track(output);
        assert_eq!(track["n_frames"], 45, "{output}: track");
        assert_eq!(
            track["fps_fraction"],
            serde_json::json!([30_000, 1001]),
            "{output}: rate"
        );
        assert_eq!(track["damage_onset"]["frame_idx"], 0, "{output}: onset");
    }
}

#[test]
fn packets_that_do_not_say_when_they_are_shown_are_no_fault() {
    let Some(studio) = Studio::open() else { return };
    for (codec, input) in [
        ("-c:v mpeg4 -bf 2", "xvid.avi"),
        ("-c:v mpeg2video -bf 2", "mpeg2.avi"),
        ("-c:v libx264", "h264.avi"),
        ("-c:v libx264", "bare.h264"),
    ] {
        studio.make("s=160x120:r=25:d=1", codec, input);
        let output = format!("{input}.mkv");
        studio.succeed(&[input, "-o", &output, "--impact-at", "0.5"]);
        let track = studio.track(&output);
        assert_eq!(track["n_frames"], 25, "{input}: frames");
        assert_eq!(
            track["damage_onset"]["frame_idx"]
                .as_u64()
                .map(|idx| idx.abs_diff(13) <= 1),
            Some(true),
            "{input}: the impact, {}",
            track["damage_onset"]
        );
    }
}

#[test]
fn a_video_that_starts_after_its_audio_still_does() {
    let Some(studio) = Studio::open() else { return };
    let late = "-f lavfi -i sine=440:d=2 -filter:v setpts=PTS+0.52/TB -fps_mode passthrough -c:v libx264 -c:a aac";
    studio.make("s=160x120:r=25:d=1", late, "in.mkv");
    let (times, sound_s) = studio.times("in.mkv");
    assert!(
        times[0] - sound_s.unwrap() > 0.5,
        "it does in the input: {times:?} {sound_s:?}"
    );
    for output in ["a.mkv", "a.mp4"] {
        studio.succeed(&["in.mkv", "-o", output]);
        let (found, found_sound_s) = studio.times(output);
        let late_s = |video: &[f64], sound: Option<f64>| video[0] - sound.unwrap();
        let shift_s = late_s(&found, found_sound_s) - late_s(&times, sound_s);
        assert!(shift_s.abs() < 2e-3, "{output}: off by {shift_s} s");
        assert_eq!(
            studio.track(output)["frames"][0]["time_s"],
            0.0,
            "time is since the first frame"
        );
    }
}

#[test]
fn a_variable_rate_is_kept() {
    let Some(studio) = Studio::open() else { return };
    let gaps = "-vf select='not(eq(mod(n,5),3))' -fps_mode passthrough -c:v libx264 -enc_time_base 1:90000";
    studio.make("s=160x120:r=30:d=2", gaps, "in.mp4");
    let (times, _) = studio.times("in.mp4");
    assert_eq!(times.len(), 48, "frames of the input");
    for (output, tolerance_s) in [("a.mp4", 1e-9), ("a.mkv", 6e-4)] {
        studio.succeed(&["in.mp4", "-o", output, "--replace"]);
        same_times(&studio.times(output).0, &times, tolerance_s, output);
        assert_eq!(
            studio.track(output)["constant_rate"],
            false,
            "{output}: track"
        );
    }
    let outcome = studio.video(&["in.mp4", "-o", "a.avi"]);
    assert_eq!(outcome.complaint("variable frame rate"), None, "avi");
}

#[test]
fn before_the_impact_every_bit_is_kept() {
    let Some(studio) = Studio::open() else { return };
    studio.make(
        "s=160x120:r=25:d=1",
        "-c:v libx264 -pix_fmt yuv420p",
        "in.mp4",
    );
    studio.succeed(&["in.mp4", "-o", "a.mkv", "--lossless", "--impact-at", "0.5"]);
    let (before, after) = (
        studio.frames("in.mp4", (160, 120)),
        studio.frames("a.mkv", (160, 120)),
    );
    assert_eq!(after.len(), before.len(), "frames");
    let first_changed = before.iter().zip(&after).position(|(a, b)| a != b);
    assert_eq!(first_changed, Some(13), "0.5 s is between frames 12 and 13");
    assert!(
        before.iter().zip(&after).skip(13).all(|(a, b)| a != b),
        "all after it"
    );
    let track = studio.track("a.mkv");
    assert_eq!(
        track["damage_onset"],
        serde_json::json!({ "frame_idx": 13, "time_s": 0.52 }),
        "onset"
    );
    assert_eq!(states(&track), "iiiiiiiiiiiiissssssssssss", "states");
}

#[test]
fn a_turned_clip_is_upright_and_without_a_tag() {
    let Some(studio) = Studio::open() else { return };
    studio.make(
        "s=160x96:r=25:d=0.4",
        "-c:v libx264 -pix_fmt yuv420p",
        "flat.mp4",
    );
    studio.ffmpeg(&[
        "-display_rotation",
        "90",
        "-i",
        "flat.mp4",
        "-c",
        "copy",
        "in.mp4",
    ]);
    assert!(
        studio.described("in.mp4").contains("rotation"),
        "the input is turned"
    );
    studio.succeed(&["in.mp4", "-o", "a.mkv", "--lossless", "--impact-at", "0.2"]);
    let said = studio.described("a.mkv");
    assert!(
        said.contains("96x160") && !said.contains("rotation"),
        "{said}"
    );
    let (before, after) = (
        studio.frames("in.mp4", (96, 160)),
        studio.frames("a.mkv", (96, 160)),
    );
    assert_eq!(before[..5], after[..5], "upright, before the impact");
    let track = studio.track("a.mkv");
    assert_eq!(
        (&track["width_px"], &track["height_px"]),
        (&96.into(), &160.into()),
        "track"
    );
}

#[test]
fn one_frame_and_odd_sides_are_clips_too() {
    let Some(studio) = Studio::open() else { return };
    let odd = "-frames:v 1 -vf scale=161:121 -c:v ffv1";
    studio.make("s=160x120:r=25", odd, "in.mkv");
    for (output, pixels) in [
        ("a.mp4", "yuv444p"),
        ("a.mkv", "yuv444p"),
        ("a.avi", "yuvj420p"),
    ] {
        let outcome = studio.succeed(&["in.mkv", "-o", output]);
        assert_eq!(
            outcome.stderr.contains("odd side"),
            pixels == "yuv444p",
            "{output}: note"
        );
        assert_eq!(
            studio.frames(output, (161, 121)).len(),
            1,
            "{output}: frames"
        );
        let said = studio.described(output);
        assert!(
            said.contains(pixels) && said.contains("161x121"),
            "{output}: {said}"
        );
    }
}

#[test]
fn a_gif_has_all_frames_and_their_colors_but_no_audio() {
    let Some(studio) = Studio::open() else { return };
    let audio = "-f lavfi -i sine=440:d=1 -c:v libx264 -crf 4 -pix_fmt yuv420p -c:a libmp3lame";
    studio.make("s=160x120:r=25:d=1", audio, "in.mp4");
    studio.succeed(&["in.mp4", "-o", "a.gif", "--impact-at", "0.5"]);
    studio.succeed(&["in.mp4", "-o", "a.mkv", "--impact-at", "0.5", "--lossless"]);
    let (times, sound) = studio.times("a.gif");
    assert_eq!(sound, None, "no audio");
    same_times(
        &times,
        &studio.times("in.mp4").0,
        5.1e-3,
        "a clock of 1/100 s",
    );
    let [gif, exact] = ["a.gif", "a.mkv"].map(|name| studio.frames(name, (160, 120)));
    assert_eq!(gif.len(), 25, "frames");
    for (k, (a, b)) in gif.iter().zip(&exact).enumerate() {
        let sum: f64 = a
            .iter()
            .zip(b)
            .map(|(a, b)| f64::from(a.abs_diff(*b)))
            .sum();
        let mean = sum / a.len() as f64;
        assert!(mean < 6.0, "frame {k}: {mean} codes off");
    }
    assert_eq!(studio.track("a.gif")["n_frames"], 25, "track");
    studio.make("s=160x120:r=60:d=0.2", "-c:v libx264", "fast.mp4");
    let refused = studio.video(&["fast.mp4", "-o", "fast.gif"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("at most 50"), "{refused:?}");
}

#[test]
fn color_tags_are_kept_and_the_matrix_is_the_same() {
    let Some(studio) = Studio::open() else { return };
    for (tags, said) in [
        (
            "-colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range tv",
            "bt709",
        ),
        ("-pix_fmt yuvj420p -color_range pc", "pc"),
        ("-pix_fmt yuv420p", "yuv420p"),
    ] {
        studio.make(
            "s=160x120:r=25:d=0.4",
            &format!("{tags} -c:v libx264 -crf 4"),
            "in.mp4",
        );
        studio.succeed(&["in.mp4", "-o", "a.mp4", "--impact-at", "0.36", "--replace"]);
        let described = studio.described("a.mp4");
        assert!(described.contains(said), "{tags}: {described}");
        let (before, after) = (
            studio.frames("in.mp4", (160, 120)),
            studio.frames("a.mp4", (160, 120)),
        );
        let off = |a: &[u8], b: &[u8]| {
            let sum: f64 = a
                .iter()
                .zip(b)
                .map(|(a, b)| f64::from(a.abs_diff(*b)))
                .sum();
            sum / a.len() as f64
        };
        // A wrong matrix or range is off by 5 to 16 codes.
        let mean = off(&before[0], &after[0]);
        assert!(mean < 3.0, "{tags}: {mean} codes off");
    }
}

#[test]
fn primaries_and_transfer_are_kept() {
    let Some(studio) = Studio::open() else { return };
    for (primaries, transfer, matrix, is_hdr) in [
        ("bt709", "bt709", "bt709", false),
        ("bt2020", "smpte2084", "bt2020nc", true),
        ("bt2020", "arib-std-b67", "bt2020nc", true),
        ("bt470bg", "bt470bg", "bt470bg", false),
    ] {
        let tags = format!(
            "-vf setparams=color_primaries={primaries}:color_trc={transfer}:colorspace={matrix}:range=tv \
             -pix_fmt yuv420p -c:v libx264"
        );
        studio.make("s=160x120:r=5:d=0.4", &tags, "in.mp4");
        let said = format!("{matrix}/{primaries}/{transfer}").replace("bt709/bt709/bt709", "bt709");
        let said = said.replace("bt470bg/bt470bg/bt470bg", "bt470bg");
        assert!(
            studio.described("in.mp4").contains(&said),
            "the input has its tags: {}",
            studio.described("in.mp4")
        );
        for output in ["a.mp4", "a.mkv", "a.mov"] {
            let outcome = studio.succeed(&["in.mp4", "-o", output, "--replace"]);
            let described = studio.described(output);
            let said = format!(" {said}, ");
            assert!(described.contains(&said), "{output}: {described}");
            let has_note = outcome.stderr.contains("8 bits are few");
            assert_eq!(has_note, is_hdr, "{transfer}: {outcome:?}");
        }
        studio.succeed(&["in.mp4", "-o", "l.mkv", "--lossless", "--replace"]);
        let described = studio.described("l.mkv");
        let said = format!("gbr/{primaries}/{transfer}");
        assert!(described.contains(&said), "lossless: {described}");
    }
}

#[test]
fn more_than_eight_bits_and_alpha_are_said_once() {
    let Some(studio) = Studio::open() else { return };
    for (pixels, codec, named) in [
        ("yuv420p10le", "ffv1", "10 bits per channel"),
        ("bgra", "ffv1", "alpha"),
        ("gray16le", "ffv1", "16 bits per channel"),
        ("rgba64be", "png", "16 bits per channel and alpha"),
        ("yuv420p", "ffv1", ""),
        ("bgr0", "ffv1", ""),
    ] {
        let args = format!("-pix_fmt {pixels} -c:v {codec}");
        studio.make("s=160x120:r=5:d=0.4", &args, "in.mkv");
        for output in [&["-o", "a.mkv", "--lossless"][..], &["-o", "a.mp4"]] {
            let stderr = studio
                .succeed(&[&["in.mkv", "--replace"], output].concat())
                .stderr;
            let n_said = stderr.matches("8-bit RGB").count();
            assert_eq!(n_said, usize::from(!named.is_empty()), "{pixels}: {stderr}");
            assert!(stderr.contains(named), "{pixels}: {stderr}");
        }
    }
    let help = crate::program::starbreak(studio.path(), &["video", "--help"]).stdout;
    let help: Vec<&str> = help.split_whitespace().collect();
    assert!(
        help.join(" ")
            .contains("8-bit RGB frames without further loss"),
        "the help of --lossless"
    );
}

#[test]
fn a_crack_grows_and_then_stands_still() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=160x120:r=10:d=1.2", "-c:v ffv1", "in.mkv");
    let args = [
        "in.mkv",
        "-o",
        "a.mkv",
        "--lossless",
        "--impact-at",
        "0.3",
        "--grow",
        "--growth-time",
        "0.5",
    ];
    studio.succeed(&[&args[..], &["--masks", "m"]].concat());
    let track = studio.track("a.mkv");
    assert_eq!(
        states(&track),
        "iiiggggsssss",
        "0.3 s intact, 0.5 s of growth"
    );
    let column = |key: &str| -> Vec<f64> {
        let frames = track["frames"].as_array().unwrap();
        frames
            .iter()
            .map(|frame| frame[key].as_f64().unwrap())
            .collect()
    };
    for key in ["growth", "crack_length_px", "region_fraction"] {
        let values = column(key);
        assert!(
            values[..3].iter().all(|v| v.to_bits() == 0),
            "{key}: {values:?}"
        );
        assert!(
            values[2..=7].windows(2).all(|pair| pair[0] <= pair[1]),
            "{key}: {values:?}"
        );
        assert!(values[7] > 1.2 * values[3], "{key} grows: {values:?}");
        assert!(
            values[7..]
                .windows(2)
                .all(|pair| pair[0].to_bits() == pair[1].to_bits()),
            "{key}: {values:?}"
        );
    }
    assert!(
        (column("growth")[7] - track["growth"]["last_arrival"].as_f64().unwrap()).abs() < 1e-9,
        "to the end"
    );
    let masks = names(&studio.path().join("m"));
    assert_eq!(masks.len(), 24, "two masks of each frame: {masks:?}");
    let mask = |k: u32, kind: &str| {
        std::fs::read(studio.path().join(format!("m/frame_{k:06}.{kind}.png"))).unwrap()
    };
    for kind in ["region", "crack"] {
        assert_eq!(mask(0, kind), mask(2, kind), "intact {kind}");
        assert_ne!(mask(3, kind), mask(5, kind), "growing {kind}");
        assert!(
            (8..12).all(|k| mask(k, kind) == mask(7, kind)),
            "still {kind}"
        );
    }
    let network = crate::program::json(&studio.path().join("a.mkv.network.json"));
    assert_eq!(
        network["schema"], "starbreak.crack-network/1",
        "the network is beside the clip"
    );
}

#[test]
fn threads_change_nothing() {
    let Some(studio) = Studio::open() else { return };
    studio.make("s=160x120:r=25:d=1", "-c:v libx264", "in.mp4");
    for (threads, output) in [("1", "one"), ("2", "two")] {
        let path = format!("{output}/a.mkv");
        let masks = format!("{output}/m");
        let args = [
            "in.mp4",
            "-o",
            &path,
            "--lossless",
            "--grow",
            "--growth-time",
            "0.4",
            "--masks",
            &masks,
        ];
        // The physical optics, whose light follows the scene.
        let ffmpeg = studio.ffmpeg.to_str().unwrap();
        let outcome = crate::program::starbreak(
            studio.path(),
            &[
                &["video"],
                &args[..],
                &["--threads", threads, "--ffmpeg", ffmpeg],
            ]
            .concat(),
        );
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    }
    let of = |folder: &str| crate::program::snapshot(&studio.path().join(folder));
    assert!(of("one").len() > 50, "frames and masks");
    assert!(
        of("one") == of("two"),
        "clip, masks, network and track have the same bytes"
    );
}
