//! The verb `study` on the real binary, with a real detector on real images.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use crate::program::{
    command, folder, jpeg_bytes, json, names, raw_png, repeated_keys, skipped, snapshot, starbreak,
};
use serde_json::Value;
use starbreak_dataset::{ImageLimits, read_image};

/// The shared data, where it is at hand.
fn data() -> Option<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let is_there = shared.join("onnx/FastestDet.onnx").is_file();
    if !is_there {
        skipped(&format!("{} is not at hand", shared.display()));
    }
    is_there.then(|| shared.canonicalize().unwrap())
}

/// Mean share of the images in the region, and how many of them it leaves alone, by the masks of the set
/// of a severity.
fn region_of(sets: &Path, severity: u8) -> (f64, u64) {
    let is_it = |name: &&String| name.contains(&format!("severity-{severity}"));
    let names = names(sets);
    let set = names
        .iter()
        .find(is_it)
        .unwrap_or_else(|| panic!("{names:?}"));
    let (mut sum, mut n, mut n_intact) = (0.0, 0.0, 0);
    let mut folders = vec![sets.join(set).join("starbreak/regions")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let mask = raw_png(&path);
            let n_inside = mask.data.iter().filter(|code| **code > 0).count();
            sum += n_inside as f64 / mask.data.len() as f64;
            n += 1.0;
            n_intact += u64::from(n_inside == 0);
        }
    }
    (sum / n, n_intact)
}

/// A study of eight images, two severities of coarse paper cracks, to the folder `out`.
fn arguments(data: &Path, out: &str) -> Vec<String> {
    let source = format!("coco:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    [
        "study",
        &source,
        "--model",
        &model,
        "--presets",
        "paper",
        "--severities",
        "1,5",
        "--set",
        "fracture.particles=800",
        "--limit",
        "8",
        "--replicates",
        "20",
        "--worst",
        "1",
        "-o",
        out,
    ]
    .map(str::to_owned)
    .to_vec()
}

#[test]
fn a_study_gives_one_report_and_a_killed_one_comes_to_the_same() {
    let Some(data) = data() else { return };
    let dir = folder();
    let whole = starbreak(dir.path(), &arguments(&data, "whole"));
    assert_eq!(whole.code, Some(0), "{}", whole.stderr);
    for name in ["report.html", "evaluation.json", "numbers.csv", "table.tex"] {
        assert!(dir.path().join("whole").join(name).is_file(), "{name}");
    }
    let csv = fs::read_to_string(dir.path().join("whole/numbers.csv")).unwrap();
    let none: [String; 0] = [];
    assert_eq!(repeated_keys(&csv), none, "each number once");
    let study = json(&dir.path().join("whole/evaluation.json"));
    let evaluations = study["evaluations"].as_array().unwrap();
    let of = |key: &str| -> Vec<&Value> {
        evaluations
            .iter()
            .map(|one| &one["condition"][key])
            .collect()
    };
    assert_eq!(of("severity"), [&Value::from(1), &Value::from(5)], "both");
    assert_eq!(of("family"), ["paper", "paper"], "of one family");
    for one in evaluations {
        assert_eq!(one["counts"]["n_images"], 8, "images of the limit only");
        assert_eq!(one["clean"], Value::Null, "not per condition");
    }
    assert_eq!(
        study["clean"].as_array().unwrap().len(),
        1,
        "one clean arm for all"
    );
    for (one, severity) in evaluations.iter().zip([1, 5]) {
        let (share, n_intact) = region_of(&dir.path().join("whole/sets"), severity);
        let said = one["counts"]["mean_region_share"].as_f64().unwrap();
        assert!(
            (said - share).abs() < 1e-9,
            "{said}, by the records {share}"
        );
        assert_eq!(one["counts"]["n_images_intact"], n_intact, "by the records");
    }

    // Killed at several moments, then left alone.
    for wait_ms in [300, 900, 1500, 2500] {
        let mut child = command(dir.path(), &arguments(&data, "killed"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait_ms));
        let _ = child.kill();
        child.wait().unwrap();
    }
    let resumed = starbreak(dir.path(), &arguments(&data, "killed"));
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    let files = |name: &str| {
        let mut files = snapshot(&dir.path().join(name));
        // What names the folder itself, in the command line and in paths, differs.
        for named in ["report.html", "evaluation.json", "written.json"] {
            files.remove(Path::new(named));
        }
        files
    };
    assert_eq!(
        files("killed").keys().collect::<Vec<_>>(),
        files("whole").keys().collect::<Vec<_>>(),
        "the same files"
    );
    for (name, bytes) in files("whole") {
        // Records hold how long each image took.
        let is_record = name.starts_with("sets") && name.extension().is_some_and(|e| e == "json");
        if !is_record {
            assert_eq!(files("killed").get(&name), Some(&bytes), "{name:?}");
        }
    }
    let numbers =
        |name: &str| json(&dir.path().join(name).join("evaluation.json"))["evaluations"].clone();
    assert_eq!(numbers("killed"), numbers("whole"), "the same numbers");
}

#[test]
fn what_cannot_be_studied_is_refused_before_anything_is_written() {
    let Some(data) = data() else { return };
    let dir = folder();
    let text = dir.path().join("text.onnx");
    fs::write(&text, "this is text").unwrap();
    let coco = format!("coco:{}", data.join("coco96").display());
    let pictures = format!("folder:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    let text = text.display().to_string();
    let cases: [(Vec<&str>, &str); 5] = [
        (vec![&coco, "--model", &text], "text.onnx"),
        (vec![&pictures, "--model", &model], "no labels"),
        (
            vec![&coco, "--model", &model, "--presets", "papper"],
            "did you mean",
        ),
        (
            vec![
                &coco,
                "--model",
                &model,
                "--contract",
                "auto",
                "--contract",
                "auto",
            ],
            "2 contracts for 1 models",
        ),
        (
            vec![&coco, "--model", &model, "--set", "output.format=\"png\""],
            "output.format",
        ),
    ];
    for (arguments, named) in cases {
        let mut all = vec!["study"];
        all.extend(arguments);
        all.extend(["--limit", "2", "-o", "out"]);
        let outcome = starbreak(dir.path(), &all);
        assert_eq!(outcome.code, Some(2), "{named}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains(named),
            "{named}: {}",
            outcome.stderr
        );
        assert!(!dir.path().join("out").exists(), "{named}: nothing written");
    }
}

/// A study of four images behind coarse cracks of the seeds given.
fn small(data: &Path, seeds: &str, more: &[&str]) -> Vec<String> {
    let source = format!("coco:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    let mut all = vec![
        "study",
        &source,
        "--model",
        &model,
        "--presets",
        "paper",
        "--severities",
        "5",
        "--set",
        "fracture.particles=800",
        "--limit",
        "4",
        "--replicates",
        "20",
        "--worst",
        "0",
        "-o",
        "out",
        "--seeds",
        seeds,
    ];
    all.extend(more);
    all.into_iter().map(str::to_owned).collect()
}

#[test]
fn another_study_in_the_folder_is_refused_and_more_of_the_same_is_added() {
    let Some(data) = data() else { return };
    let dir = folder();
    let first = starbreak(dir.path(), &small(&data, "1", &["--divergence", "off"]));
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let study = json(&dir.path().join("out/evaluation.json"));
    assert_eq!(study["divergence"], Value::Null, "off");
    assert_eq!(study["over_seeds"], Value::Null, "one seed");
    let before = snapshot(dir.path());

    let others: [(Vec<String>, &str); 6] = [
        (
            small(&data, "1", &["--no-store", "--divergence", "off"]),
            "it was made without --no-store; leave --no-store out",
        ),
        (
            small(&data, "2", &[]),
            "paper-severity-5-seed-1, which is left out",
        ),
        (
            small(&data, "1", &["--set", "fracture.particles=700"]),
            "condition paper-severity-5-seed-1 has another recipe",
        ),
        (
            small(&data, "1", &["--limit", "3"]),
            "its 4 images are not these 3",
        ),
        (
            small(&data, "1", &["--model", "yolox"]),
            "detector FastestDet, which is left out",
        ),
        (
            small(&data, "1", &["--severities", "4"]),
            "paper-severity-5-seed-1, which is left out",
        ),
    ];
    for (mut arguments, named) in others {
        // What is given twice is meant once.
        for flag in ["--limit", "--model", "--severities"] {
            let last = arguments.iter().rposition(|one| one == flag).unwrap();
            let first = arguments.iter().position(|one| one == flag).unwrap();
            if first < last {
                arguments.drain(first..first + 2);
            }
        }
        for one in &mut arguments {
            if one == "yolox" {
                *one = data.join("onnx/yolox_nano.onnx").display().to_string();
            }
        }
        let outcome = starbreak(dir.path(), &arguments);
        assert_eq!(outcome.code, Some(2), "{named}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains(named),
            "{named}: {}",
            outcome.stderr
        );
        assert!(
            outcome.stderr.contains("choose another folder"),
            "{}",
            outcome.stderr
        );
        assert_eq!(
            outcome.stderr.matches("error:").count(),
            1,
            "{}",
            outcome.stderr
        );
        assert!(snapshot(dir.path()) == before, "{named}: nothing written");
    }
    // What was altered since is not written over, and that is said before the work.
    let found = dir.path().join("out/detections/FastestDet/clean.json");
    let own = fs::read_to_string(&found).unwrap();
    fs::write(&found, format!("{own} ")).unwrap();
    let refused = starbreak(dir.path(), &small(&data, "1", &[]));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    let named = "clean.json\" is no longer as an earlier run wrote it";
    assert!(refused.stderr.contains(named), "{}", refused.stderr);
    assert!(!refused.stderr.contains("[1/"), "{}", refused.stderr);
    fs::write(&found, own).unwrap();
    assert!(snapshot(dir.path()) == before, "nothing written");

    // Detections by another runtime would be mixed with these.
    let file = dir.path().join("out/study.json");
    let own = fs::read_to_string(&file).unwrap();
    let mut other = json(&file);
    other["detectors"]["FastestDet"]["runtime"] = "ONNX Runtime of commit 1234567".into();
    fs::write(&file, other.to_string()).unwrap();
    let refused = starbreak(dir.path(), &small(&data, "1", &[]));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    let named = "detector FastestDet was run by ONNX Runtime of commit 1234567, not by rten";
    assert!(refused.stderr.contains(named), "{}", refused.stderr);
    fs::write(&file, own).unwrap();
    let more = starbreak(dir.path(), &small(&data, "1,2", &[]));
    assert_eq!(more.code, Some(0), "{}", more.stderr);
    let study = json(&dir.path().join("out/evaluation.json"));
    let csv = fs::read_to_string(dir.path().join("out/numbers.csv")).unwrap();
    let none: [String; 0] = [];
    assert_eq!(
        repeated_keys(&csv),
        none,
        "each number once, also of seeds taken together"
    );
    let pooled = study["over_seeds"].as_array().unwrap();
    assert_eq!(pooled.len(), 1, "both seeds");
    assert_eq!(pooled[0]["seeds"], serde_json::json!([1, 2]), "named");
    let lost = |one: &Value| -> u64 {
        let rates = one["rates"].as_array().unwrap();
        rates[0]["n_lost"].as_u64().unwrap()
    };
    let singles = study["evaluations"].as_array().unwrap();
    let sum: u64 = singles.iter().map(|one| lost(&one["failures"])).sum();
    assert_eq!(lost(&pooled[0]), sum, "of both");

    let divergence = &study["divergence"];
    let sets = serde_json::json!([
        "clean",
        "paper, severity 5, seed 1",
        "paper, severity 5, seed 2"
    ]);
    assert_eq!(divergence["sets"], sets, "all of them");
    let tables = divergence["tables"].as_array().unwrap();
    let of = |feature: &str, measure: &str| {
        let is_it = |table: &&Value| {
            table["feature"] == feature && table["measure"].as_str().unwrap().starts_with(measure)
        };
        tables.iter().find(is_it).unwrap()["values"].clone()
    };
    let js = of("luma256", "JS");
    let value = |row: usize, column: usize| js[row][column]["value"].as_f64().unwrap();
    assert!(value(0, 1) > 0.0, "cracks change the luma: {js}");
    assert!((value(0, 1) - value(1, 0)).abs() < 1e-12, "symmetric");
    assert!(value(0, 1) < std::f64::consts::LN_2, "at most ln 2");
    // Both sets get the same draws, or the whole interval would lie above the value.
    let ends = ["low", "high"].map(|end| js[0][1][end].as_f64().unwrap());
    assert!(ends[0] < value(0, 1) && value(0, 1) < ends[1], "{js}");
    let kl = of("luma256", "KL");
    assert_ne!(kl[0][1]["value"], kl[1][0]["value"], "both ways");

    // A study of another version of the program is told from this one.
    let file = dir.path().join("out/study.json");
    let mut earlier = json(&file);
    earlier["schema"] = "starbreak.study/1".into();
    earlier["detectors"]["FastestDet"]["contract"] = "Contract { name: … }".into();
    fs::write(&file, earlier.to_string()).unwrap();
    let refused = starbreak(dir.path(), &small(&data, "1,2", &[]));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(
        refused
            .stderr
            .contains("its form is \"starbreak.study/1\", not \"starbreak.study/2\""),
        "{}",
        refused.stderr
    );

    // A report that is of no study is not replaced either.
    fs::remove_file(dir.path().join("out/study.json")).unwrap();
    let refused = starbreak(dir.path(), &small(&data, "1,2", &[]));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(
        refused
            .stderr
            .contains("has a report.html, and no study.json"),
        "{}",
        refused.stderr
    );
}

#[test]
fn an_image_whose_pixels_have_changed_is_refused_until_it_is_put_back() {
    let Some(data) = data() else { return };
    let dir = folder();
    let coco = dir.path().join("coco");
    for part in ["annotations", "val2017"] {
        fs::create_dir_all(coco.join(part)).unwrap();
        for entry in fs::read_dir(data.join("coco96").join(part)).unwrap() {
            let from = entry.unwrap();
            fs::copy(from.path(), coco.join(part).join(from.file_name())).unwrap();
        }
    }
    let mut arguments = small(&data, "1", &["--divergence", "off"]);
    arguments[1] = format!("coco:{}", coco.display());
    let first = starbreak(dir.path(), &arguments);
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let before = snapshot(&dir.path().join("out"));

    // The third image by name, with other pixels in a file of the same name, size and time.
    let images = names(&coco.join("val2017"));
    let path = coco.join("val2017").join(&images[2]);
    let bytes = fs::read(&path).unwrap();
    let time = fs::metadata(&path).unwrap().modified().unwrap();
    let mut pixels = read_image(&path, &ImageLimits::default()).unwrap().pixels;
    pixels.invert();
    let mut other = jpeg_bytes(&pixels);
    other.resize(bytes.len().max(other.len()), 0);
    fs::write(&path, other).unwrap();
    let file = fs::File::options().append(true).open(&path).unwrap();
    file.set_modified(time).unwrap();
    let refused = starbreak(dir.path(), &arguments);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    for said in [
        "out",
        "1 of its 4 images have changed",
        &images[2],
        "choose another folder",
    ] {
        assert!(refused.stderr.contains(said), "{said}: {}", refused.stderr);
    }
    assert!(
        snapshot(&dir.path().join("out")) == before,
        "nothing written"
    );

    // Nor where the sets are gone, and only the detections know the file.
    fs::remove_dir_all(dir.path().join("out/sets")).unwrap();
    let without_sets = snapshot(&dir.path().join("out"));
    let refused = starbreak(dir.path(), &arguments);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    let said = "1 of its 4 images have changed";
    assert!(refused.stderr.contains(said), "{}", refused.stderr);
    assert!(
        snapshot(&dir.path().join("out")) == without_sets,
        "nothing written"
    );

    fs::write(&path, bytes).unwrap();
    let again = starbreak(dir.path(), &arguments);
    assert_eq!(again.code, Some(0), "{}", again.stderr);

    // Altered in the set: a cracked image and a mask.
    let set = dir.path().join("out/sets/paper-severity-5-seed-1");
    let regions = set.join("starbreak/regions/val2017");
    let masks = names(&regions);
    let altered = [
        set.join("val2017").join(&images[0]),
        regions.join(&masks[1]),
    ];
    let good = altered.each_ref().map(|path| fs::read(path).unwrap());
    fs::write(&altered[0], &good[0][..2000]).unwrap();
    fs::copy(regions.join(&masks[0]), &altered[1]).unwrap();
    let mended = starbreak(dir.path(), &arguments);
    assert_eq!(mended.code, Some(0), "{}", mended.stderr);
    let after = altered.each_ref().map(|path| fs::read(path).unwrap());
    assert!(after == good, "made again");
    let numbers = fs::read(dir.path().join("out/numbers.csv")).unwrap();
    let earlier = before.get(Path::new("numbers.csv")).unwrap();
    assert!(earlier.as_ref() == Some(&numbers), "the same numbers");

    // Labels of another size than the file.
    let labels = coco
        .join("annotations")
        .join(&names(&coco.join("annotations"))[0]);
    let mut all = json(&labels);
    let image = &mut all["images"].as_array_mut().unwrap()[0];
    let width = image["width"].as_u64().unwrap();
    image["width"] = (width - 4).into();
    fs::write(&labels, all.to_string()).unwrap();
    for one in arguments.iter_mut().filter(|one| *one == "out") {
        *one = "new".to_owned();
    }
    let refused = starbreak(dir.path(), &arguments);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    for said in [format!("{} x", width - 4), format!("{width} x")] {
        assert!(refused.stderr.contains(&said), "{}", refused.stderr);
    }
    assert!(!dir.path().join("new").exists(), "nothing written");
}

#[test]
fn a_study_that_keeps_no_images_comes_to_the_same_numbers() {
    let Some(data) = data() else { return };
    let dir = folder();
    let run = |out: &str, more: &[&str]| {
        let mut args = arguments(&data, out);
        args.extend(more.iter().map(|it| (*it).to_owned()));
        let outcome = starbreak(dir.path(), &args);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stderr
    };
    run("stored", &["--divergence", "off"]);
    run("removed", &["--no-store"]);
    let numbers = |out: &str| fs::read_to_string(dir.path().join(out).join("numbers.csv")).unwrap();
    assert_eq!(numbers("removed"), numbers("stored"), "the same numbers");
    let images = |out: &str| {
        let files = snapshot(&dir.path().join(out).join("sets"));
        let is_image = |path: &&PathBuf| path.extension().is_some_and(|end| end == "jpg");
        files.keys().filter(is_image).cloned().collect::<Vec<_>>()
    };
    assert_eq!(images("stored").len(), 16, "two conditions of eight");
    assert!(images("removed").is_empty(), "none");
    // What was looked at is not made again: a set that is gone but for its records stays so.
    let regions = dir
        .path()
        .join("removed/sets/paper-severity-1-seed-0/starbreak/regions");
    let away = dir.path().join("regions");
    fs::rename(&regions, &away).unwrap();
    let mut args = arguments(&data, "removed");
    args.extend(["--no-store".to_owned(), "--replace".to_owned()]);
    starbreak(dir.path(), &args);
    assert!(!regions.exists(), "no set is made again");
    fs::rename(&away, &regions).unwrap();
    run("removed", &["--no-store", "--replace"]);
    assert_eq!(numbers("removed"), numbers("stored"), "the same again");
    // Neither loses its images nor gets them by the way.
    for (out, more) in [("stored", "--no-store"), ("removed", "--replace")] {
        let mut args = arguments(&data, out);
        args.extend([more.to_owned(), "--replace".to_owned()]);
        args.dedup();
        let outcome = starbreak(dir.path(), &args);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("--no-store"), "{}", outcome.stderr);
    }
    assert_eq!(images("stored").len(), 16, "all are there");
    let mut args = arguments(&data, "x");
    args.extend(["--no-store", "--divergence", "on"].map(str::to_owned));
    let outcome = starbreak(dir.path(), &args);
    assert_eq!(outcome.code, Some(2), "without images nothing is compared");
}

#[test]
fn a_suite_is_all_of_its_presets() {
    let Some(data) = data() else { return };
    let dir = folder();
    let source = format!("coco:{}", data.join("coco96").display());
    let model = data.join("onnx/FastestDet.onnx").display().to_string();
    let args = [
        "study",
        &source,
        "--model",
        &model,
        "--suite",
        "camera",
        "--limit",
        "1",
        "--replicates",
        "20",
        "--no-store",
        "-o",
        "out",
    ];
    let outcome = starbreak(dir.path(), &args);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let n_sets = fs::read_dir(dir.path().join("out/sets")).unwrap().count();
    let expected: usize = starbreak::FAULTS
        .iter()
        .filter(|fault| fault.table != "distortion")
        .map(|fault| fault.presets.len())
        .sum();
    assert_eq!(n_sets, expected, "a condition for each");
    // What a lens moves, labels would miss.
    let alone = [
        "study",
        &source,
        "--model",
        &model,
        "--presets",
        "distortion",
        "-o",
        "a",
    ];
    let refused = starbreak(dir.path(), &alone);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    for named in ["condition distortion-seed-0", "starbreak evaluate"] {
        assert!(refused.stderr.contains(named), "{}", refused.stderr);
    }
    assert!(!dir.path().join("a").exists(), "nothing is written");
}
