//! `study --shard` and `--join`: shards of a study come to what one run would have made and found.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{all_refused, command, folder, snapshot, starbreak, succeed};
use crate::study_photos::{STUDY, world};
use image::{Rgb, RgbImage};

const SHARDS: [&str; 3] = ["shard-1", "shard-2", "shard-3"];

/// The study of two severities and of photographs, with more words.
fn study<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&STUDY[..], &["--severities", "1,5"], more].concat()
}

/// All files of a study, without the words that join it, and the hashes of the files with those words.
fn results(study: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut files = snapshot(study);
    files.retain(|_, bytes| bytes.is_some());
    files.remove(Path::new("written.json"));
    let join: String = SHARDS.map(|shard| format!(" --join {shard}")).concat();
    for name in ["report.html", "evaluation.json"] {
        let text = files.get_mut(Path::new(name)).unwrap().take().unwrap();
        let text = String::from_utf8(text).unwrap().replace(&join, "");
        files.insert(name.into(), Some(text.into_bytes()));
    }
    files
}

/// Asserts that two studies have the same files with the same bytes.
fn assert_same(found: &Path, expected: &Path) {
    let (found, expected) = (results(found), results(expected));
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        expected.keys().collect::<Vec<_>>(),
        "the same files"
    );
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{name:?}");
    }
}

#[test]
fn shards_come_to_the_same_bytes_as_one_run() {
    for more in [&[][..], &["--no-store"]] {
        let (whole, parts) = (folder(), folder());
        for dir in [&whole, &parts] {
            world(dir.path());
            // It can be neither broken nor looked at.
            fs::write(dir.path().join("coco/val2017/000000000007.png"), "none").unwrap();
        }
        let words = |out: &[&'static str]| [study(more), out.to_vec()].concat();
        let outcome = starbreak(whole.path(), &words(&["-o", "study"]));
        assert_eq!(outcome.code, Some(1), "one image fails: {}", outcome.stderr);

        let dir = parts.path();
        let part = |number: &'static str, out: &'static str| words(&["-o", out, "--shard", number]);
        let codes = [("1/3", SHARDS[0]), ("3/3", SHARDS[2])]
            .map(|(number, out)| starbreak(dir, &part(number, out)).code);
        // Whichever has that image says so.
        assert!(
            codes.iter().all(|code| matches!(code, Some(0 | 1))),
            "{codes:?}"
        );
        // The steps of one shard side by side.
        let steps = succeed(dir, &words(&["-o", "study", "--dry-run", "--json"]));
        let steps: serde_json::Value = serde_json::from_str(&steps.stdout).unwrap();
        let steps: Vec<String> = serde_json::from_value(steps["steps"].clone()).unwrap();
        assert_eq!(steps.len(), 4, "clean and three conditions: {steps:?}");
        let running: Vec<_> = steps
            .iter()
            .map(|step| {
                let shard = words(&["-o", SHARDS[1], "--shard", "2/3", "--step"]);
                let shard: Vec<&str> = shard.into_iter().chain([step.as_str()]).collect();
                command(dir, &shard).spawn().unwrap()
            })
            .collect();
        for mut step in running {
            let code = step.wait().unwrap().code();
            assert!(matches!(code, Some(0 | 1)), "{code:?}");
        }
        let shards = SHARDS.iter().flat_map(|shard| ["--join", shard]);
        let joining = [words(&["-o", "study"]), shards.collect()].concat();
        let outcome = starbreak(dir, &joining);
        assert_eq!(outcome.code, Some(1), "one image fails: {}", outcome.stderr);
        assert_same(&dir.join("study"), &whole.path().join("study"));
        // Joined again over an interrupted joining, and gone on with by itself.
        fs::remove_file(dir.join("study/evaluation.json")).unwrap();
        let log = dir.join("study/detections/model/photos-seed-0.jsonl");
        fs::write(&log, "half a li").unwrap();
        starbreak(dir, &joining);
        assert_same(&dir.join("study"), &whole.path().join("study"));
        starbreak(dir, &words(&["-o", "study"]));
        assert_same(&dir.join("study"), &whole.path().join("study"));
    }
}

#[test]
fn what_cannot_be_joined_is_refused() {
    let dir = folder();
    world(dir.path());
    let dir = dir.path();
    for (shard, out) in [("1/2", "one"), ("2/2", "two"), ("1/3", "third")] {
        succeed(dir, &study(&["-o", out, "--shard", shard]));
    }
    succeed(dir, &study(&["-o", "whole"]));
    succeed(
        dir,
        &study(&["-o", "begun", "--shard", "2/2", "--step", "clean"]),
    );
    succeed(dir, &study(&["-o", "half", "--shard", "2/2"]));
    // Its last image has not been looked at.
    let log = dir.join("half/detections/model/paper-severity-5-seed-0.jsonl");
    let text = fs::read_to_string(&log).unwrap();
    let last = text.trim_end().rfind('\n').unwrap() + 1;
    fs::write(&log, &text[..last]).unwrap();
    let join = |folders: &[&'static str]| {
        let folders = folders.iter().flat_map(|folder| ["--join", folder]);
        study(&["-o", "study"])
            .into_iter()
            .chain(folders)
            .collect::<Vec<_>>()
    };
    let more_seeds = |mut words: Vec<&'static str>| {
        words.extend(["--seeds", "0,1"]);
        words
    };
    all_refused(
        dir,
        &[
            (join(&["one"]), "shard 2 of 2 is missing"),
            (join(&["one", "two", "one"]), "shard 1/2 is there twice"),
            (
                join(&["one", "third"]),
                "shard 1/3, and the first is one of 2",
            ),
            (join(&["one", "whole"]), "a whole study"),
            (join(&["one", "none"]), "none"),
            (join(&["one", "coco"]), "coco"),
            (
                study(&["-o", "two/joined", "--join", "one", "--join", "two"]),
                "lies in it; join into a folder beside it",
            ),
            (study(&["-o", "one"]), "it is the shard 1/2"),
            (
                study(&["-o", "one", "--shard", "2/2"]),
                "it is the shard 1/2",
            ),
            (
                study(&["-o", "whole", "--shard", "2/2"]),
                "it is not a shard",
            ),
            (
                study(&["-o", "new", "--shard", "1/2", "--step", "dirty"]),
                "its steps are clean, paper-severity-1-seed-0",
            ),
            (study(&["-o", "new", "--step", "clean"]), "--shard"),
            (study(&["-o", "new", "--shard", "3/2"]), "I/N"),
        ],
    );
    for (folders, named) in [
        (join(&["one", "begun"]), "begun"),
        (join(&["one", "half"]), "has no intact line of"),
        (more_seeds(join(&["one", "two"])), "paper-severity-1-seed-1"),
    ] {
        let refused = starbreak(dir, &folders);
        assert_eq!(refused.code, Some(2), "{named}: {}", refused.stderr);
        assert!(
            refused.stderr.contains(named),
            "{named}: {}",
            refused.stderr
        );
        assert!(
            !dir.join("study/report.html").exists(),
            "{named}: no report"
        );
    }
    // A mask that was altered, a line in another place, and another image in the source.
    let mask = dir.join("two/sets/paper-severity-5-seed-0/starbreak/regions/val2017");
    let mask = fs::read_dir(mask).unwrap().next().unwrap().unwrap().path();
    let clean = dir.join("one/detections/model/clean.jsonl");
    let lines = fs::read_to_string(&clean).unwrap();
    let mut turned: Vec<&str> = lines.lines().collect();
    turned[1..].reverse();
    let source = dir.join("coco/val2017/000000000003.png");
    let other = fs::read(dir.join("coco/val2017/000000000004.png")).unwrap();
    for (path, bytes, named) in [
        (
            mask,
            b"no mask".to_vec(),
            "is not what the lists of its shard say",
        ),
        (
            clean,
            turned.join("\n").into_bytes(),
            "has no intact line of",
        ),
        (source, other, "have changed since"),
    ] {
        let good = fs::read(&path).unwrap();
        fs::write(&path, bytes).unwrap();
        let refused = starbreak(dir, &join(&["one", "two"]));
        assert_eq!(refused.code, Some(2), "{named}: {}", refused.stderr);
        assert!(
            refused.stderr.contains(named),
            "{named}: {}",
            refused.stderr
        );
        fs::write(&path, good).unwrap();
    }
    // With the shard mended the same folder is joined after all.
    succeed(dir, &study(&["-o", "half", "--shard", "2/2"]));
    succeed(dir, &join(&["one", "half"]));
}

/// What only breaking cannot use, since it takes more memory than is allowed, is told of as one run does.
#[test]
fn an_image_that_cannot_be_broken_is_told_of_as_by_one_run() {
    let dir = folder();
    world(dir.path());
    let dir = dir.path();
    let large = RgbImage::from_pixel(6000, 6000, Rgb([90, 90, 90]));
    let name = "coco/val2017/000000000003.png";
    large.save(dir.join(name)).unwrap();
    let labels = dir.join("coco/annotations/instances_val2017.json");
    let text = fs::read_to_string(&labels).unwrap();
    let at = text.find("000000000003.png").unwrap();
    let (before, image) = text.split_at(text[..at].rfind('{').unwrap());
    let image = image.replacen(":64", ":6000", 2);
    fs::write(&labels, format!("{before}{image}")).unwrap();
    let study = |more: &[&'static str]| {
        let words = [
            "--max-memory",
            "300MB",
            "--replicates",
            "20",
            "--divergence",
            "off",
        ];
        let words = [
            &["study", "--quiet", "coco:coco", "--model", "model.onnx"][..],
            &words,
        ]
        .concat();
        [
            &words[..],
            &["--presets", "paper", "--set", "fracture.particles=800"],
            more,
        ]
        .concat()
    };
    for (out, more) in [
        ("whole", &[][..]),
        ("part", &["--shard", "1/1"]),
        ("joined", &["--join", "part"]),
    ] {
        let outcome = starbreak(dir, &study(&[&["-o", out], more].concat()));
        assert_eq!(outcome.code, Some(1), "{out}: {}", outcome.stderr);
    }
    let unseen = |of: &str| fs::read_to_string(dir.join(of).join("unseen.jsonl")).unwrap();
    assert_eq!(unseen("joined"), unseen("whole"), "the same reason");
    let log =
        |of: &str| fs::read(dir.join(of).join("detections/model/paper-seed-0.jsonl")).unwrap();
    assert!(log("joined") == log("whole"), "the same lines");
    assert!(
        unseen("whole").contains("paper-seed-0: "),
        "{}",
        unseen("whole")
    );

    // Without images: it is tried again alone, and told of again; the others are not made for it.
    let removing = study(&["-o", "removed", "--no-store"]);
    assert_eq!(starbreak(dir, &removing).code, Some(1));
    assert_eq!(unseen("removed"), unseen("whole"), "the same reason");
    let regions = dir.join("removed/sets/paper-seed-0/starbreak/regions");
    let away = dir.join("away");
    fs::rename(&regions, &away).unwrap();
    let without = starbreak(dir, &removing);
    assert!(
        without.stderr.contains("starbreak/regions"),
        "it comes to the report: {}",
        without.stderr
    );
    assert!(!regions.exists(), "nothing is broken again");
    fs::rename(&away, &regions).unwrap();
    let again = starbreak(dir, &removing);
    assert_eq!(again.code, Some(1), "{}", again.stderr);
    assert_eq!(unseen("removed"), unseen("whole"), "again");
    let memory = removing.iter().position(|word| *word == "300MB").unwrap();
    let mut enough = removing.clone();
    enough[memory] = "4GB";
    let mended = starbreak(dir, &enough);
    assert_eq!(mended.code, Some(0), "{}", mended.stderr);
    assert_eq!(unseen("removed"), "", "it is broken now");
}
