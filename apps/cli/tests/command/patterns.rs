//! `starbreak patterns`: a bank with its statistics, and what is said of it.

use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{SMALL, all_refused, folder, names, starbreak, succeed, succeed_small};
use serde_json::Value;

const FILES: [&str; 4] = [
    "patterns.bank",
    "statistics.csv",
    "statistics.png",
    "statistics.svg",
];

#[test]
fn faults_behind_the_lens_come_on_top_of_a_bank() {
    let dir = folder();
    fs::create_dir(dir.path().join("in")).unwrap();
    crate::program::write_photo(&dir.path().join("in/a.png"));
    let bank = ["patterns", "-n", "2", "--size", "320x200", "-o", "bank"];
    succeed_small(dir.path(), &bank);
    let generate = |out: &str, set: &[&str]| {
        let args = ["generate", "folder:in", "--bank", "bank", "-o", out];
        succeed(dir.path(), &[&args[..], set].concat());
        fs::read(dir.path().join(out).join("a.png")).unwrap()
    };
    let cracked = generate("cracked", &[]);
    let noisy = generate("noisy", &["--set", "noise.white_e=100"]);
    assert!(cracked != noisy, "noise comes on top");
    succeed(
        dir.path(),
        &[
            "verify",
            "noisy",
            "--regenerate",
            "all",
            "--source",
            "folder:in",
            "--bank",
            "bank",
        ],
    );
    let refused = [
        (
            vec![
                "generate",
                "folder:in",
                "--bank",
                "bank",
                "-o",
                "x",
                "--set",
                "camera.f_px=900",
            ],
            "exposure, banding",
        ),
        (
            vec![
                "patterns", "-n", "1", "--size", "32x32", "-o", "x", "--preset", "noise",
            ],
            "nothing to keep in a bank; coats and faults of the camera are made anew",
        ),
        (
            vec![
                "patterns", "-n", "1", "--size", "32x32", "-o", "x", "--preset", "rain",
            ],
            "nothing to keep in a bank; a bank keeps [drops] only together with cracks",
        ),
    ];
    all_refused(dir.path(), &refused);
    assert!(!dir.path().join("x").exists(), "nothing more");
}

/// The paper's gray lines; of the physical model crack masks.
#[test]
fn a_bank_is_written_out_as_images_of_its_patterns() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    let small = ["patterns", "-n", "3", "--size", "320x200", "-o"];
    succeed_small(dir.path(), &[&small[..], &["paper"]].concat());
    let physics = [
        "physics",
        "--preset",
        "windshield-star",
        "--set",
        "fracture.mesh=fast",
    ];
    succeed(dir.path(), &[&small[..], &physics].concat());
    for bank in ["paper", "physics"] {
        let out = format!("{bank}-images");
        succeed(dir.path(), &["patterns", "--images-of", bank, "-o", &out]);
        let files = [
            "pattern_000000.png",
            "pattern_000001.png",
            "pattern_000002.png",
        ];
        let with_list = [&files[..], &["written.json"]].concat();
        assert_eq!(names(&at(&out)), with_list, "{bank}");
        let images = files.map(|name| crate::program::raw_png(&at(&out).join(name)));
        for image in &images {
            assert_eq!(image.size, (320, 200), "{bank}");
            let n_dark = image.data.iter().filter(|code| **code == 0).count();
            assert!(n_dark * 2 > image.data.len(), "{bank}: on black");
            assert!(n_dark < image.data.len(), "{bank}: cracks");
        }
        assert_ne!(images[0].data, images[1].data, "{bank}: each its own");
        let first = fs::read(at(&out).join(files[0])).unwrap();
        let again = [
            "patterns",
            "--images-of",
            bank,
            "-n",
            "1",
            "-o",
            "first",
            "--replace",
        ];
        succeed(dir.path(), &again);
        assert_eq!(
            first,
            fs::read(at("first").join(files[0])).unwrap(),
            "{bank}: -n"
        );
    }
    // Those of another bank take the place of all of them, and of nobody else's.
    let fewer = [
        "patterns",
        "--images-of",
        "physics",
        "-n",
        "1",
        "-o",
        "paper-images",
    ];
    succeed(dir.path(), &fewer);
    let left = ["pattern_000000.png", "written.json"];
    assert_eq!(names(&at("paper-images")), left, "no patterns of two banks");
    fs::create_dir(at("taken")).unwrap();
    fs::write(at("taken/pattern_000001.png"), "somebody's").unwrap();
    let cases = [
        (
            vec!["patterns", "--images-of", "paper", "-o", "taken"],
            "pattern_000001.png",
        ),
        (
            vec![
                "patterns",
                "--images-of",
                "paper",
                "-o",
                "new",
                "--overlay-gain",
                "3",
            ],
            "--overlay-gain",
        ),
        (
            vec![
                "patterns",
                "--images-of",
                "paper",
                "-o",
                "new",
                "--seed",
                "3",
            ],
            "--seed",
        ),
        (
            vec!["patterns", "--images-of", "paper", "-n", "4", "-o", "new"],
            "has 3 patterns",
        ),
        (vec!["patterns", "--images-of", "none", "-o", "new"], "none"),
        (vec!["patterns", "--images-of", "paper"], "--output"),
    ];
    all_refused(dir.path(), &cases);
    assert!(!at("new").exists(), "nothing half-written");
}

#[test]
fn a_bank_comes_with_a_table_and_a_figure() {
    let dir = folder();
    let made = succeed_small(
        dir.path(),
        &[
            "patterns", "-n", "12", "-o", "bank", "--size", "200x120", "--json",
        ],
    );
    assert_eq!(names(&dir.path().join("bank")), FILES, "nothing else");
    let result: Value = serde_json::from_str(&made.stdout).unwrap();
    assert_eq!(result["n_patterns"], 12, "{result}");
    assert_eq!(
        result["sizes_px"],
        serde_json::json!([[200, 120]]),
        "{result}"
    );
    assert_eq!(result["statistics"]["classes"]["paper"], 12, "{result}");
    let length = fs::metadata(dir.path().join("bank/patterns.bank"))
        .unwrap()
        .len();
    assert_eq!(result["bytes"], length, "{result}");

    let table = fs::read_to_string(dir.path().join("bank/statistics.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 13, "a heading and a row per pattern");
    assert!(rows.iter().all(|row| row.len() == 12), "{table}");
    let column = |name: &str| rows[0].iter().position(|cell| *cell == name).unwrap();
    let number = |row: &[&str], name: &str| row[column(name)].parse::<f64>().unwrap();
    for row in &rows[1..] {
        let area = number(row, "area_share");
        assert!(area > 0.0 && area < 1.0, "{row:?}");
        let density = number(row, "density_px_per_px2") * 200.0 * 120.0;
        let length = number(row, "total_length_px");
        assert!((density / length - 1.0).abs() < 1e-9, "{row:?}");
        let width = number(row, "right_px") - number(row, "left_px");
        assert!(width > 0.0 && width <= 200.0, "{row:?}");
    }
    let svg = fs::read_to_string(dir.path().join("bank/statistics.svg")).unwrap();
    for text in [
        "12 patterns in frames of 200",
        "cracks cover of the frame",
        "px/px²",
        "paper",
    ] {
        assert!(svg.contains(text), "the figure does not say {text:?}");
    }
    assert!(
        crate::program::raw_png(&dir.path().join("bank/statistics.png"))
            .size
            .0
            > 1000,
        "a figure"
    );

    let info = succeed(dir.path(), &["patterns", "--info", "bank", "--json"]);
    let info: Value = serde_json::from_str(&info.stdout).unwrap();
    assert_eq!(info["sha256"], result["sha256"], "{info}");
    assert_eq!(info["n_patterns"], 12, "{info}");
    assert!(
        info["recipe"].as_str().unwrap().contains("particles = 300"),
        "{info}"
    );
    let said = succeed(dir.path(), &["patterns", "--info", "bank/patterns.bank"]);
    for text in [
        "12 patterns in ",
        "frames of 200 × 120 px",
        "particles = 300",
    ] {
        assert!(said.stdout.contains(text), "{said:?}");
    }
    let checked = succeed(dir.path(), &["patterns", "--check", "bank"]);
    assert!(
        checked.stdout.contains("is whole: 12 patterns"),
        "{checked:?}"
    );
}

#[test]
fn a_bank_for_a_dataset_has_its_most_frequent_sizes() {
    let dir = folder();
    fs::create_dir(dir.path().join("set")).unwrap();
    for (k, (width, height)) in [(40, 30), (64, 48), (40, 30), (30, 40), (30, 40), (30, 40)]
        .into_iter()
        .enumerate()
    {
        let path = dir.path().join(format!("set/{k}.png"));
        image::RgbImage::new(width, height).save(path).unwrap();
    }
    let make = |most: &str, out: &str| {
        let args = [
            "patterns",
            "-n",
            "2",
            "-o",
            out,
            "--sizes-of",
            "folder:set",
            "--most-sizes",
            most,
            "--json",
        ];
        succeed_small(dir.path(), &args)
    };
    let made = make("2", "bank");
    let result: Value = serde_json::from_str(&made.stdout).unwrap();
    let expected = serde_json::json!([[30, 40], [40, 30]]);
    assert_eq!(result["sizes_px"], expected, "by frequency");
    assert!(
        made.stderr.contains("1 images have one of 1 further sizes"),
        "{made:?}"
    );
    let all = make("9", "all");
    let result: Value = serde_json::from_str(&all.stdout).unwrap();
    let expected = serde_json::json!([[30, 40], [40, 30], [64, 48]]);
    assert_eq!(result["sizes_px"], expected, "all of them");
    assert!(!all.stderr.contains("further"), "{all:?}");
    fs::create_dir(dir.path().join("none")).unwrap();
    let args = |of: &'static str| vec!["patterns", "-n", "2", "-o", "x", "--sizes-of", of];
    let both = [args("folder:set"), vec!["--size", "9x9"]].concat();
    all_refused(
        dir.path(),
        &[
            (args("folder:none"), "no image"),
            (args("folder:absent"), "absent"),
            (both, "--size"),
        ],
    );
}

#[test]
fn the_bytes_of_a_bank_do_not_depend_on_threads() {
    let dir = folder();
    for (threads, out) in [("1", "one"), ("2", "two")] {
        let args = [
            "patterns",
            "-n",
            "9",
            "--size",
            "200x120",
            "--threads",
            threads,
            "-o",
            out,
        ];
        succeed_small(dir.path(), &args);
    }
    for name in FILES {
        let [one, two] =
            ["one", "two"].map(|out| fs::read(dir.path().join(out).join(name)).unwrap());
        assert!(one == two, "{name} differs");
    }
}

#[test]
fn several_frame_sizes_are_baked_into_one_bank() {
    let dir = folder();
    let sizes = [
        "--size", "200x120", "--size", "150x150", "--size", "200x120",
    ];
    let args = [&["patterns", "-n", "2", "-o", "bank", "--json"][..], &sizes].concat();
    let made = succeed_small(dir.path(), &args);
    let result: Value = serde_json::from_str(&made.stdout).unwrap();
    let sizes = serde_json::json!([[200, 120], [150, 150]]);
    assert_eq!(result["sizes_px"], sizes, "each once, in order");
    succeed(dir.path(), &["patterns", "--check", "bank"]);
}

#[test]
fn a_bank_is_replaced_only_on_request() {
    let dir = folder();
    let make = ["patterns", "-n", "2", "-o", "bank", "--size", "100x80"];
    let make = [&make[..], &SMALL].concat();
    succeed(dir.path(), &make);
    let before = fs::read(dir.path().join("bank/patterns.bank")).unwrap();
    all_refused(
        dir.path(),
        &[(
            make.clone(),
            "patterns.bank\" is there already; choose another name or folder, or give --replace",
        )],
    );
    succeed(
        dir.path(),
        &[&make[..], &["--seed", "1", "--replace"]].concat(),
    );
    let after = fs::read(dir.path().join("bank/patterns.bank")).unwrap();
    assert!(after != before, "another seed, another bank");
}

#[test]
fn wrong_requests_are_refused_in_one_line() {
    let dir = folder();
    fs::write(dir.path().join("text"), "not a bank at all").unwrap();
    let make = ["patterns", "-n", "2", "-o", "bank", "--size", "100x80"];
    succeed(dir.path(), &[&make[..], &SMALL].concat());
    let bank = dir.path().join("bank/patterns.bank");
    let mut bytes = fs::read(&bank).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::create_dir(dir.path().join("damaged")).unwrap();
    fs::write(dir.path().join("damaged/patterns.bank"), bytes).unwrap();
    all_refused(
        dir.path(),
        &[
            (vec!["patterns"], "--number"),
            (vec!["patterns", "-n", "3"], "--output"),
            (vec!["patterns", "-n", "0", "-o", "b"], "0 is not in 1.."),
            (
                vec!["patterns", "-n", "3", "-o", "b", "--size", "3"],
                "WIDTHxHEIGHT",
            ),
            (
                vec!["patterns", "-n", "3", "-o", "text/b"],
                "is a file, not a folder",
            ),
            (
                vec!["patterns", "-n", "3", "-o", "b", "--info", "bank"],
                "cannot be used with",
            ),
            (vec!["patterns", "--info", "none"], "no such file"),
            (
                vec!["patterns", "--info", "text"],
                "does not begin like a bank",
            ),
            (vec!["patterns", "--check", "damaged"], "wrong checksum"),
        ],
    );
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_no_bank() {
    let dir = folder();
    let args = [
        "patterns", "-n", "100000", "-o", "bank", "--size", "200x120",
    ];
    let mut child = crate::program::command(dir.path(), &[&args[..], &SMALL].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    let bank = dir.path().join("bank");
    while names_of(&bank).is_empty() {
        assert!(started.elapsed().as_secs() < 60, "nothing began");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    child.kill().unwrap();
    child.wait().unwrap();
    let left = names_of(&bank);
    assert!(
        left.iter().all(|name| name.starts_with(".starbreak-")),
        "{left:?}"
    );
    let outcome = starbreak(dir.path(), &["patterns", "--info", "bank"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
}

fn names_of(folder: &std::path::Path) -> Vec<String> {
    fs::read_dir(folder).map_or_else(
        |_| Vec::new(),
        |entries| {
            entries
                .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
                .collect()
        },
    )
}
