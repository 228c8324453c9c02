//! `starbreak generate` over a set that was damaged since: it is mended from the recipe or refused,
//! and never listed as it is now.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{Outcome, SMALL, folder, snapshot, starbreak, succeed, write_photo};
use serde_json::Value;

type Snapshot = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// A finished set of two labeled images, and what lies in its folder.
fn finished_set(dir: &Path) -> Snapshot {
    for sub in ["image_2", "label_2"] {
        fs::create_dir_all(dir.join("in").join(sub)).unwrap();
    }
    for k in 0..2 {
        write_photo(&dir.join(format!("in/image_2/{k:06}.png")));
        let label = "Car 0 0 0 10 10 90 60 1 1 1 1 1 1 1\n";
        fs::write(dir.join(format!("in/label_2/{k:06}.txt")), label).unwrap();
    }
    assert_eq!(generate(dir, &[]).code, Some(0), "made");
    snapshot(&dir.join("out"))
}

fn generate(dir: &Path, more: &[&str]) -> Outcome {
    let args = [&["generate", "kitti:in", "-o", "out"], more, &SMALL].concat();
    starbreak(dir, &args)
}

fn restore(dir: &Path, files: &Snapshot) {
    fs::remove_dir_all(dir).unwrap();
    for (name, bytes) in files {
        match bytes {
            Some(bytes) => {
                fs::create_dir_all(dir.join(name).parent().unwrap()).unwrap();
                fs::write(dir.join(name), bytes).unwrap();
            }
            None => fs::create_dir_all(dir.join(name)).unwrap(),
        }
    }
}

/// Does something to a file of the set, runs the same command again, and says whether the set is
/// then as it was made.
fn mends(dir: &Path, made: &Snapshot, name: &str, damage: impl FnOnce(&mut Vec<u8>)) -> bool {
    let path = dir.join("out").join(name);
    let mut bytes = fs::read(&path).unwrap();
    damage(&mut bytes);
    fs::write(&path, bytes).unwrap();
    let outcome = generate(dir, &[]);
    let is_as_made = outcome.code == Some(0) && snapshot(&dir.join("out")) == *made;
    if !is_as_made {
        restore(&dir.join("out"), made);
    }
    is_as_made
}

const RECORD: &str = "starbreak/provenance/image_2/000001.json";

#[test]
fn a_record_with_a_flipped_bit_is_made_again() {
    let dir = folder();
    let made = finished_set(dir.path());
    let n_bytes = made[Path::new(RECORD)].as_ref().unwrap().len();
    let laundered: Vec<usize> = (0..30)
        .filter(|k| {
            let at = k * n_bytes / 30;
            !mends(dir.path(), &made, RECORD, |bytes| {
                bytes[at] ^= 1 << (k % 7);
            })
        })
        .collect();
    assert_eq!(laundered, Vec::<usize>::new(), "flips that stayed");
}

#[test]
fn a_record_that_says_otherwise_is_made_again() {
    let dir = folder();
    let made = finished_set(dir.path());
    for (key, value) in [("n_segments", "1"), ("region_fraction", "0.5")] {
        let is_mended = mends(dir.path(), &made, RECORD, |bytes| {
            let text = String::from_utf8(bytes.clone()).unwrap();
            let at = text.find(&format!("\"{key}\"")).unwrap();
            let value_at = at + text[at..].find(':').unwrap() + 1;
            let n = text[value_at..].find([',', '\n', '}']).unwrap();
            bytes.splice(value_at..value_at + n, value.bytes());
        });
        assert!(is_mended, "{key}");
    }
}

#[test]
fn lists_and_the_identity_are_mended() {
    let dir = folder();
    let made = finished_set(dir.path());
    for name in [
        "run.json",
        "recipe.toml",
        "items.jsonl",
        "files.jsonl",
        "manifest.json",
    ] {
        let name = format!("starbreak/{name}");
        let n_bytes = made[Path::new(&name)].as_ref().unwrap().len();
        for k in 0..12 {
            let at = k * n_bytes / 12;
            let is_mended = mends(dir.path(), &made, &name, |bytes| bytes[at] ^= 1 << (k % 7));
            assert!(is_mended, "{name}: a bit of byte {at}");
        }
    }
}

#[test]
fn a_damage_outlives_no_interruption() {
    let dir = folder();
    let made = finished_set(dir.path());
    // As a run leaves it that was killed after it had begun.
    fs::remove_file(dir.path().join("out/starbreak/manifest.json")).unwrap();
    assert!(
        mends(dir.path(), &made, RECORD, |bytes| bytes[20] ^= 1),
        "after the lists were finished"
    );
    // As one that was killed before there were lists: nothing says what the record was.
    for name in ["manifest.json", "items.jsonl", "files.jsonl"] {
        fs::remove_file(dir.path().join("out/starbreak").join(name)).unwrap();
    }
    assert!(
        mends(dir.path(), &made, RECORD, |bytes| bytes[20] ^= 1),
        "before there were lists"
    );
}

#[test]
fn what_is_whole_is_not_made_again() {
    let dir = folder();
    finished_set(dir.path());
    let outcome = generate(dir.path(), &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(
        (&result["n_made"], &result["n_done_before"]),
        (&0.into(), &2.into()),
        "{result}"
    );
    succeed(dir.path(), &["verify", "out"]);
}

/// Runs a command as `verify` names it.
fn run_named(dir: &Path, command: &str) {
    match command.strip_prefix("starbreak ") {
        Some(args) => {
            let args: Vec<&str> = args.split(' ').collect();
            succeed(dir, &args);
        }
        None => {
            let done = Command::new("sh")
                .args(["-c", command])
                .current_dir(dir)
                .status();
            assert!(done.unwrap().success(), "{command}");
        }
    }
}

/// Damages a set, and says how.
type Damage = (&'static str, fn(&Path));

const DAMAGES: [Damage; 10] = [
    ("an image that is cut off", |set| {
        fs::write(set.join("image_2/000000.png"), "P").unwrap()
    }),
    ("no record", |set| {
        fs::remove_file(set.join(RECORD)).unwrap()
    }),
    ("another record", |set| {
        fs::write(set.join(RECORD), "{}").unwrap()
    }),
    ("a label less", |set| {
        fs::remove_file(set.join("label_2/000001.txt")).unwrap()
    }),
    ("a file of others", |set| {
        fs::write(set.join("image_2/mine 1.txt"), "mine").unwrap()
    }),
    ("an empty list of failures", |set| {
        fs::write(set.join("starbreak/failures.jsonl"), "").unwrap()
    }),
    ("a list of what was skipped", |set| {
        fs::write(set.join("starbreak/skipped.jsonl"), "{}\n").unwrap()
    }),
    ("another recipe", |set| {
        fs::write(set.join("starbreak/recipe.toml"), "x").unwrap()
    }),
    ("no list", |set| {
        fs::remove_file(set.join("starbreak/files.jsonl")).unwrap()
    }),
    ("a list cut off", |set| {
        fs::write(set.join("starbreak/items.jsonl"), "{").unwrap()
    }),
];

#[test]
fn verify_finds_it_and_names_the_commands_that_mend_it() {
    let dir = folder();
    let made = finished_set(dir.path());
    let verify = || {
        let outcome = starbreak(
            dir.path(),
            &["verify", "out", "--source", "kitti:in", "--json"],
        );
        let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
        (outcome, result)
    };
    let (whole, _) = verify();
    assert_eq!(whole.code, Some(0), "{whole:?}");
    assert!(
        whole
            .stderr
            .contains("not checked: whether the images are what source and recipe give"),
        "{whole:?}"
    );
    for (what, damage) in DAMAGES {
        damage(&dir.path().join("out"));
        let (outcome, result) = verify();
        assert_eq!(outcome.code, Some(1), "{what}: {outcome:?}");
        let mends = result["mend"].as_array().unwrap();
        assert!(!mends.is_empty(), "{what}: {outcome:?}");
        for mend in mends {
            run_named(dir.path(), mend.as_str().unwrap());
        }
        let (outcome, _) = verify();
        assert_eq!(
            outcome.code,
            Some(0),
            "{what}, after {mends:?}: {outcome:?}"
        );
        assert!(
            snapshot(&dir.path().join("out")) == made,
            "{what}: as it was made"
        );
    }
}

#[test]
fn a_stopped_run_goes_on_with_what_it_knows_to_be_whole() {
    let dir = folder();
    let made = finished_set(dir.path());
    let good = fs::read(dir.path().join("in/image_2/000001.png")).unwrap();
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    fs::write(dir.path().join("in/image_2/000001.png"), "no image").unwrap();
    let stopped = generate(dir.path(), &["--fail-fast", "--threads", "1"]);
    assert_eq!(stopped.code, Some(1), "{stopped:?}");
    fs::write(dir.path().join("in/image_2/000001.png"), good).unwrap();

    let record = dir
        .path()
        .join("out/starbreak/provenance/image_2/000000.json");
    let mut bytes = fs::read(&record).unwrap();
    let at = bytes
        .iter()
        .rposition(|byte| byte.is_ascii_digit())
        .unwrap();
    bytes[at] ^= 1;
    fs::write(&record, bytes).unwrap();
    let outcome = generate(dir.path(), &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["n_made"], 2, "the altered one, too: {result}");
    assert!(
        snapshot(&dir.path().join("out")) == made,
        "as an undisturbed run"
    );
}

#[test]
fn an_image_with_a_record_of_many_objects_is_not_lost() {
    let dir = folder();
    finished_set(dir.path());
    fs::remove_dir_all(dir.path().join("out")).unwrap();
    // 60 000 objects: a record of more than 16 MiB.
    let label: String = (0..60_000)
        .map(|k| {
            format!(
                "Car 0 0 0 {}.25 10 {}.5 60 1 1 1 1 1 1 1\n",
                k % 90,
                91 + k % 60
            )
        })
        .collect();
    fs::write(dir.path().join("in/label_2/000001.txt"), label).unwrap();
    for n_made in [2, 0] {
        let outcome = generate(dir.path(), &["--json"]);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
        assert_eq!(result["n_made"], n_made, "{result}");
        assert_eq!(result["manifest"]["n_items"], 2, "{result}");
    }
    let n_bytes = fs::metadata(dir.path().join("out").join(RECORD))
        .unwrap()
        .len();
    assert!(n_bytes > 1 << 24, "{n_bytes} bytes");
    succeed(dir.path(), &["verify", "out"]);
}
