//! `starbreak video` with folders of frames, which need no ffmpeg unless a clip is on one side.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::clip::{Studio, states};
use crate::program::{
    folder, jpeg_bytes, json, names, photo, png_bytes, starbreak, starbreak_small, succeed,
    succeed_small,
};

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
            &["in", "-o", "out", "--fps", "10", "--impact-at", "-1"],
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
        (
            &["mixed", "-o", "out"],
            "\"mixed/b.png\" is 100 x 160 px, but \"mixed/a.png\", a frame before it, is 160 x 100 px",
        ),
        (&["nowhere", "-o", "out"], "ffmpeg"),
        (
            &["in", "-o", "out.mp4", "--fps", "9", "--ffmpeg", "no/ffmpeg"],
            "winget",
        ),
    ] {
        let before = crate::program::snapshot(dir.path());
        let mut all = vec!["video"];
        all.extend(args);
        if !args.contains(&"--ffmpeg") {
            all.extend(["--ffmpeg", "no/ffmpeg"]);
        }
        let outcome = starbreak_small(dir.path(), &all);
        if let Some(complaint) = outcome.complaint(named) {
            complaints.push(format!("{args:?}: {complaint}"));
        }
        if crate::program::snapshot(dir.path()) != before {
            complaints.push(format!("{args:?} changed the folder"));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn a_folder_that_holds_something_is_not_mixed_into() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    for name in ["full", "empty"] {
        fs::create_dir(dir.path().join(name)).unwrap();
    }
    fs::write(dir.path().join("full/frame_000099.png"), "of another clip").unwrap();
    let args = |output, masks| vec!["video", "in", "-o", output, "--masks", masks];
    let args = |output, masks| [args(output, masks), crate::program::SMALL.to_vec()].concat();
    crate::program::all_refused(
        dir.path(),
        &[
            (args("full", "empty"), "is not empty"),
            (args("empty", "full"), "is not empty"),
            (args("full/", "empty"), "is not empty"),
        ],
    );
    succeed_small(dir.path(), &["video", "in", "-o", "empty", "--masks", "m"]);
    assert_eq!(names(&dir.path().join("empty")).len(), 12, "an empty one");
}

#[test]
fn frames_that_lie_on_their_side_stay_so() {
    let dir = folder();
    fs::create_dir(dir.path().join("in")).unwrap();
    // JPEGs that are to be turned by a quarter: SOI, then EXIF with orientation 6.
    let upright = jpeg_bytes(&photo((160, 100)));
    let exif =
        b"\xff\xe1\x00\x22Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let turned = [&upright[..2], exif, &upright[2..]].concat();
    for k in 0..4 {
        fs::write(dir.path().join(format!("in/{k}.jpg")), &turned).unwrap();
    }
    let args = "video in -o out --fps 10 --impact-at 0.2 --masks m";
    let args: Vec<&str> = args.split(' ').collect();
    succeed_small(dir.path(), &args);
    let read = |path: String| {
        let limits = starbreak_dataset::ImageLimits::default();
        starbreak_dataset::read_image(&dir.path().join(path), &limits).unwrap()
    };
    for k in 0..4 {
        for path in [
            format!("out/{k}.jpg"),
            format!("m/{k}.region.png"),
            format!("m/{k}.crack.png"),
        ] {
            let file = read(path.clone());
            let turn = image::metadata::Orientation::Rotate90;
            assert_eq!(file.orientation, turn, "{path} is stored as the source is");
            let size = (file.pixels.width(), file.pixels.height());
            assert_eq!(size, (100, 160), "{path}: upright when read by it");
        }
    }
    let mask = read("m/3.crack.png".to_owned()).pixels.into_luma8();
    let frames = [0, 3].map(|k| read(format!("out/{k}.jpg")).pixels.into_rgb8());
    let off = |x, y| frames[0].get_pixel(x, y).0[0].abs_diff(frames[1].get_pixel(x, y).0[0]);
    let (mut on_mask, mut n_mask, mut beside) = (0_u64, 0_u64, 0_u64);
    for (x, y, pixel) in mask.enumerate_pixels() {
        if pixel.0[0] > 0 {
            on_mask += u64::from(off(x, y));
            n_mask += 1;
        } else {
            beside += u64::from(off(x, y));
        }
    }
    let n_beside = 160 * 100 - n_mask;
    assert!(
        n_mask > 0 && on_mask * n_beside > 2 * beside * n_mask,
        "the crack is where its mask is: {on_mask} on {n_mask} px, {beside} on {n_beside} px"
    );
}

/// One crack across a frame of 160 x 100 px, in three parts; `times` is more of its columns.
fn write_network(path: &Path, times: &str) {
    let text = format!(
        r#"{{"schema":"starbreak.crack-network/1","generator":{{"name":"by hand","version":"1"}},
        "model":"imported","unit":"px","pane":{{"width":160.0,"height":100.0}},"impacts":[{{"x":20.0,"y":50.0}}],
        "nodes":{{"x":[20.0,60.0,100.0,140.0],"y":[50.0,50.0,50.0,50.0]}},
        "segments":{{"from":[0,1,2],"to":[1,2,3],"kind":["radial","radial","radial"]{times}}}}}"#
    );
    fs::write(path, text).unwrap();
}

#[test]
fn a_network_without_times_is_full_grown() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    write_network(&dir.path().join("n.json"), "");
    // Both optics, of which one sees the network on raked glass.
    for (output, preset) in [("out", "paper"), ("raked", "windshield-star")] {
        let args = format!(
            "video in -o {output} --fps 10 --impact-at 0.5 --network n.json --preset {preset}"
        );
        let args: Vec<&str> = args.split(' ').collect();
        succeed(dir.path(), &args);
        let track = json(&dir.path().join(format!("{output}.track.json")));
        for (k, frame) in track["frames"].as_array().unwrap().iter().enumerate() {
            let (growth, length_px) = if k < 5 { (0.0, 0.0) } else { (1.0, 120.0) };
            assert_eq!(frame["growth"], growth, "{preset}, frame {k}: growth");
            let found_px = frame["crack_length_px"].as_f64().unwrap();
            let off_px = (found_px - length_px).abs();
            assert!(off_px < 1e-6, "{preset}, frame {k}: {found_px} px");
        }
    }
}

#[test]
fn the_first_visible_frame_comes_after_the_onset() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    let times = r#","arrival_us":[50.0,70.0,90.0]"#;
    write_network(&dir.path().join("n.json"), times);
    let grow = "video in -o out --fps 10 --impact-at 0.2 --network n.json --grow --growth-time 0.4";
    let grow: Vec<&str> = grow.split(' ').collect();
    succeed_small(dir.path(), &grow);
    let track = json(&dir.path().join("out.track.json"));
    assert_eq!(states(&track), "iigggsssssss", "0.4 s of growth");
    // From 50 us (a hair before) to 90 us in four frames: 60, 70, 80, 90.
    let frames = track["frames"].as_array().unwrap();
    for (k, expected_us) in [(2, 60.0), (3, 70.0), (4, 80.0), (5, 90.0)] {
        let growth = frames[k]["growth"].as_f64().unwrap();
        assert!(
            (growth - expected_us).abs() < 0.01,
            "frame {k}: {growth} us"
        );
    }
    assert_eq!(track["damage_onset"]["frame_idx"], 2, "the impact");
    let first = frames
        .iter()
        .find(|frame| frame["region_fraction"].as_f64().unwrap() > 0.0)
        .unwrap();
    assert_eq!(
        track["first_visible"],
        serde_json::json!({ "frame_idx": first["frame_idx"], "time_s": first["time_s"] }),
        "the first frame whose region is not empty"
    );
    // A pane without a crack has none.
    let text = fs::read_to_string(dir.path().join("n.json")).unwrap();
    let far = text.replace(r#""kind":["radial","radial","radial"]"#, r#""kind":[]"#);
    let far = far.replace(r#""from":[0,1,2],"to":[1,2,3]"#, r#""from":[],"to":[]"#);
    let far = far.replace(times, "");
    fs::write(dir.path().join("none.json"), far).unwrap();
    succeed_small(
        dir.path(),
        &["video", "in", "-o", "none", "--network", "none.json"],
    );
    let track = json(&dir.path().join("none.track.json"));
    assert_eq!(track["first_visible"], Value::Null, "none");
    assert!(track.get("first_visible").is_some(), "said as null");
}

#[test]
fn what_is_no_network_is_called_so() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    fs::write(dir.path().join("n.bin"), b"\xff\xfe\x00\x81").unwrap();
    let args = ["video", "in", "-o", "out", "--network", "n.bin"];
    let outcome = starbreak_small(dir.path(), &args);
    let named = "is neither an SVG drawing nor a network in JSON";
    assert_eq!(outcome.complaint(named), None, "not UTF-8");
}

#[test]
fn hidden_files_are_no_frames_and_remains_of_a_killed_run_are_no_hindrance() {
    let dir = folder();
    write_frames(&dir.path().join("in"));
    fs::write(dir.path().join("in/._f1.png"), "of another system").unwrap();
    fs::copy(
        dir.path().join("in/f1.png"),
        dir.path().join("in/.hidden.png"),
    )
    .unwrap();
    for left in ["out", "m"] {
        fs::create_dir(dir.path().join(left)).unwrap();
        fs::write(dir.path().join(left).join(".starbreak-a1B2c3"), "half").unwrap();
    }
    succeed_small(dir.path(), &["video", "in", "-o", "out", "--masks", "m"]);
    let track = json(&dir.path().join("out.track.json"));
    assert_eq!(track["frames"].as_array().unwrap().len(), 12, "{track}");
    assert_eq!(track["frames"][0]["file"], "f1.png", "{track}");
    fs::write(dir.path().join("m/other.png"), "").unwrap();
    let outcome = starbreak_small(dir.path(), &["video", "in", "-o", "out2", "--masks", "m"]);
    assert_eq!(
        outcome.code,
        Some(2),
        "a folder with other files: {outcome:?}"
    );
}

/// The folder `in` to the folder `out`.
const TO_OUT: [&str; 6] = ["video", "in", "-o", "out", "--fps", "10"];

/// Twenty-four frames, no two alike.
fn write_distinct(folder: &Path) {
    fs::create_dir(folder).unwrap();
    for k in 0..24_u8 {
        let code = |at: u32| 100 + u8::try_from(at).unwrap();
        let pixels =
            image::RgbImage::from_fn(48, 32, |x, y| image::Rgb([10 * k, code(x), code(y)]));
        fs::write(
            folder.join(format!("f{k:02}.png")),
            png_bytes(&pixels.into()),
        )
        .unwrap();
    }
}

#[test]
fn frames_that_do_not_arrive_are_told_of_and_repeat_the_last_that_did() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let settings = [
        "frames.black=0.15",
        "frames.white=0.1",
        "frames.frozen=0.25",
        "frames.dropped=0.1",
        "frames.burst_frames=2",
        "noise.white_e=200",
    ];
    let recipe: Vec<&str> = settings.iter().flat_map(|it| ["--set", it]).collect();
    let run = |out: &str, threads: &str| {
        let args = [
            "video", "in", "-o", out, "--fps", "10", "--seed", "4", "--masks",
        ];
        let masks = format!("{out}-masks");
        let more = [
            masks.as_str(),
            "--preset",
            "no-filters",
            "--threads",
            threads,
        ];
        succeed(dir.path(), &[&args[..], &more, &recipe].concat());
        json(&dir.path().join(format!("{out}.track.json")))
    };
    let track = run("out", "1");
    let read = |folder: &str, idx: usize| {
        let path = dir.path().join(folder).join(format!("f{idx:02}.png"));
        image::open(path).unwrap().to_rgb8()
    };
    let mut n_of = std::collections::BTreeMap::new();
    let mut last_good = None;
    let frames = track["frames"].as_array().unwrap();
    for (idx, frame) in frames.iter().enumerate() {
        let state = frame["arrival"]["state"].as_str().unwrap();
        *n_of.entry(state).or_insert(0) += 1;
        let pixels = read("out", idx);
        let shows = frame["arrival"]["shows_frame_idx"].as_u64();
        match state {
            "good" => {
                assert_eq!(shows, Some(idx as u64), "itself");
                last_good = Some(idx);
            }
            "black" | "white" => {
                let code = if state == "black" { 0 } else { 255 };
                assert!(pixels.iter().all(|it| *it == code), "{idx} is {state}");
                assert_eq!(shows, None, "none");
            }
            _ => {
                // Before any good one the first.
                let shown = last_good.unwrap_or(0);
                assert!(
                    pixels == read("out", shown),
                    "{idx}, {state}: also its noise"
                );
                let is_blank = frames[shown]["arrival"]["shows_frame_idx"].is_null();
                assert_eq!(shows, (!is_blank).then_some(shown as u64), "{state}");
                let share = frame["region_fraction"].as_f64().unwrap();
                assert!(shown == idx || share > 0.99, "another frame: {share}");
            }
        }
    }
    assert_eq!(n_of.len(), 5, "all states: {n_of:?}");
    assert_eq!(
        run("again", "3")["frames"],
        track["frames"],
        "for any number of threads"
    );
    for idx in 0..24 {
        assert!(read("out", idx) == read("again", idx), "frame {idx}");
    }
}

#[test]
fn what_lies_on_the_pane_is_there_from_the_first_frame() {
    for preset in ["rain", "fogged"] {
        let dir = folder();
        write_distinct(&dir.path().join("in"));
        succeed(
            dir.path(),
            &[
                &TO_OUT[..],
                &["--preset", preset, "--severity", "5"],
                // A narrow view, which holds few drops.
                &["--set", "camera.f_px=100"],
                // No wiper.
                &["--set", "drops.wiper_period_s=0"][..if preset == "rain" { 2 } else { 0 }],
            ]
            .concat(),
        );
        let track = json(&dir.path().join("out.track.json"));
        assert_eq!(track["damage_onset"]["frame_idx"], 0, "{preset}");
        for frame in track["frames"].as_array().unwrap() {
            let share = frame["region_fraction"].as_f64().unwrap();
            assert!(share > 0.02, "{preset}: {share}");
            assert_eq!(frame["state"], "intact", "{preset} breaks no glass");
        }
    }
}

#[test]
fn what_lies_on_the_pane_changes_from_frame_to_frame_and_the_track_says_how() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let coverages = |sets: &[&str], table: &str, threads: &str| -> Vec<f64> {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let args: Vec<&str> = TO_OUT.into_iter().chain(sets).collect();
        let _ = fs::remove_dir_all(dir.path().join("out"));
        let _ = fs::remove_file(dir.path().join("out.track.json"));
        succeed(dir.path(), &[&args[..], &["--threads", threads]].concat());
        let track = json(&dir.path().join("out.track.json"));
        let frames = track["frames"].as_array().unwrap().clone();
        frames
            .iter()
            .map(|frame| frame["on_glass"][table]["coverage"].as_f64().unwrap())
            .collect()
    };
    let rain = [
        "fracture.model=none",
        "drops.rain_mm_h=50",
        "drops.age_s=1",
        "camera.f_px=100",
    ];
    let falls = coverages(&rain, "drops", "2");
    assert!(
        falls.windows(2).all(|two| two[1] > 0.95 * two[0]),
        "{falls:?}"
    );
    assert!(falls[23] > 1.5 * falls[0], "it rains on: {falls:?}");
    let name = |folder: &str| dir.path().join(folder).join("f23.png");
    let two = fs::read(name("out")).unwrap();
    assert_eq!(
        coverages(&rain, "drops", "1"),
        falls,
        "for any number of threads"
    );
    assert!(fs::read(name("out")).unwrap() == two, "to the byte");
    let wiped = coverages(
        &[&rain[..], &["drops.wiper_period_s=2"]].concat(),
        "drops",
        "2",
    );
    // From a second on a wiper goes there and back, in 0.7 s each.
    assert!(
        wiped[9] > 3.0 * wiped[16] && wiped[9] > 3.0 * wiped[23],
        "wiped: {wiped:?}"
    );
    let frost = [
        "fracture.model=none",
        "frost.age_s=100",
        "frost.front_um_s=1000",
        "camera.f_px=40",
    ];
    let grows = coverages(&frost, "frost", "2");
    assert!(grows[23] > grows[0], "{grows:?}");
    let melts = [
        "frost.melts_from_s=102",
        "frost.melting_um_s=500",
        "frost.heated_by=pane",
    ];
    let melts = coverages(&[&frost[..], &melts].concat(), "frost", "2");
    assert_eq!(melts[..10], grows[..10], "it melts from 2 s on");
    assert!(melts[23] < 0.8 * melts[9], "{melts:?}");
    let fog = [
        "fracture.model=none",
        "condensation.age_s=50",
        "condensation.clears_from_s=50",
        "condensation.clearing_um_s=0.6",
        "camera.f_px=40",
    ];
    let clears = coverages(&fog, "condensation", "2");
    assert!(clears.windows(2).all(|two| two[1] <= two[0]), "{clears:?}");
    assert!(
        clears[0] > 0.1 && clears[23] < 0.5 * clears[0],
        "{clears:?}"
    );
}

#[test]
fn the_sun_turns_over_cracks_and_the_track_says_where_it_is() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let frames = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let hit = ["--impact-at", "0"];
        let args: Vec<&str> = TO_OUT.into_iter().chain(hit).chain(sets).collect();
        let _ = fs::remove_dir_all(dir.path().join("out"));
        let _ = fs::remove_file(dir.path().join("out.track.json"));
        succeed(dir.path(), &args);
        let track = json(&dir.path().join("out.track.json"));
        let read = |k: usize| fs::read(dir.path().join(format!("out/f{k:02}.png"))).unwrap();
        (track, [0, 12].map(read))
    };
    let sun = [
        "camera.f_px=100",
        "optics.sun_irradiance=20",
        "optics.sun_elevation_deg=20",
        "optics.sun_azimuth_deg=10",
    ];
    let (still, of_still) = frames(&sun);
    assert_eq!(still["frames"][12]["sun_azimuth_deg"], Value::Null);
    let turns = [&sun[..], &["optics.sun_turns_deg_s=10"]].concat();
    let (turning, of_turning) = frames(&turns);
    for k in [0, 12] {
        let frame = &turning["frames"][k];
        let degrees = 10.0 + 10.0 * frame["time_s"].as_f64().unwrap();
        let said = frame["sun_azimuth_deg"].as_f64().unwrap();
        assert!((said - degrees).abs() < 1e-5, "{said}, not {degrees}");
        assert_eq!(frame["on_glass"], Value::Null, "nothing lies on it");
        assert_eq!(
            frame["crack_length_px"],
            still["frames"][k]["crack_length_px"]
        );
    }
    assert!(of_turning[0] == of_still[0], "before it has turned");
    assert!(of_turning[1] != of_still[1], "the glint moves");
    // As a picture of that time shows it.
    let then = &turning["frames"][12]["sun_azimuth_deg"];
    let azimuth = format!("optics.sun_azimuth_deg={then}");
    let there = [&sun[..3], &[&azimuth]].concat();
    let (_, of_there) = frames(&there);
    assert!(
        of_turning[1] == of_there[1],
        "cracks under the sun of that time"
    );
}

#[test]
fn mud_on_whole_glass_is_lit_and_cracks_keep_their_class_behind_a_coat() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let mud = [
        "--preset",
        "muddy",
        "--set",
        "mud.coverage_percent=80",
        "--set",
        "mud.absorption_per_mm=[0, 0, 0]",
        "--set",
        "camera.f_px=60",
    ];
    succeed(dir.path(), &[&TO_OUT[..], &mud].concat());
    let read = |folder: &str, name: &str| image::open(dir.path().join(folder).join(name)).unwrap();
    let darkest = read("out", "f12.png")
        .to_luma8()
        .iter()
        .copied()
        .min()
        .unwrap();
    assert!(
        darkest > 40,
        "white mud shines with the light outside: {darkest}"
    );
    // An opaque crack is opaque also where a veil lies over all.
    let cracks = [
        "--preset",
        "lens-cover-shattered",
        "--masks",
        "masks",
        "--set",
        "output.classes=true",
        "--set",
        "dust.coverage_percent=1",
    ];
    for folder in ["out", "masks"] {
        let _ = fs::remove_dir_all(dir.path().join(folder));
    }
    fs::remove_file(dir.path().join("out.track.json")).unwrap();
    succeed(dir.path(), &[&TO_OUT[..], &cracks].concat());
    let mask = names(&dir.path().join("masks"))
        .into_iter()
        .find(|name| name.contains("f12") && name.contains("region"));
    let mask = read("masks", &mask.unwrap()).to_luma8();
    let n = |code: u8| mask.iter().filter(|it| **it == code).count();
    assert!(
        n(255) + n(170) > 0 && n(85) > 0,
        "{} {} {}",
        n(85),
        n(170),
        n(255)
    );
}

#[test]
fn a_fault_begins_at_its_onset() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let onset = ["--preset", "no-demosaicing", "--set", "mosaic.onset_s=1.0"];
    succeed(dir.path(), &[&TO_OUT[..], &onset].concat());
    let track = json(&dir.path().join("out.track.json"));
    for (idx, frame) in track["frames"].as_array().unwrap().iter().enumerate() {
        let read = |folder: &str| {
            let name = frame["file"].as_str().unwrap();
            fs::read(dir.path().join(folder).join(name)).unwrap()
        };
        assert_eq!(read("in") == read("out"), idx < 10, "frame {idx}");
        let share = frame["region_fraction"].as_f64().unwrap();
        let expected = if idx < 10 { 0.0 } else { 0.5 };
        assert!((share - expected).abs() < 1e-9, "frame {idx}: {share}");
    }
    assert_eq!(track["damage_onset"]["frame_idx"], 10, "it begins");
    assert_eq!(track["first_visible"]["frame_idx"], 10, "then it is seen");
    assert_eq!(track["faults"]["mosaic"]["onset_s"], 1.0, "and told of");
}

#[test]
fn a_clip_that_is_frozen_from_the_beginning_shows_its_first_frame() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let frozen = ["frames.black=0", "--set", "frames.frozen=1"];
    let frozen = [&["--preset", "blank-frames", "--set"], &frozen[..]].concat();
    succeed(dir.path(), &[&TO_OUT[..], &frozen].concat());
    let read = |folder: &str, name: &str| {
        let path = dir.path().join(folder).join(name);
        image::open(path).unwrap().to_rgb8()
    };
    for name in names(&dir.path().join("in")) {
        assert!(read("out", &name) == read("in", "f00.png"), "{name}");
    }
    // Where no glass breaks, nothing is hit.
    for more in [&["--impact-at", "1"][..], &["--grow", "--growth-time", "1"]] {
        let args = ["video", "in", "-o", "x", "--fps", "10", "--preset", "noise"];
        let outcome = starbreak(dir.path(), &[&args[..], more].concat());
        assert_eq!(outcome.code, Some(2), "{more:?}");
        assert!(outcome.stderr.contains("onset_s"), "{}", outcome.stderr);
    }
}

#[test]
fn frozen_frames_do_not_move_the_impact() {
    let dir = folder();
    write_distinct(&dir.path().join("in"));
    let impact = ["--impact-at", "0.5"];
    let frozen = [
        "--set",
        "frames.black=0",
        "--set",
        "frames.frozen=0.6",
        "--set",
        "frames.burst_frames=6",
    ];
    for seed in ["4", "5", "6"] {
        let args = [
            &TO_OUT[..],
            &impact,
            &frozen,
            &["--seed", seed, "--replace"],
        ]
        .concat();
        succeed_small(dir.path(), &args);
        let track = json(&dir.path().join("out.track.json"));
        assert_eq!(track["damage_onset"]["frame_idx"], 5, "seed {seed}");
        fs::remove_dir_all(dir.path().join("out")).unwrap();
    }
}
