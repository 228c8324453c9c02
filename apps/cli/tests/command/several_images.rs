//! Many images in one run: what one bad image does to the others, and what is said about it.

use std::fs;
use std::path::Path;

use crate::program::{folder, names, snapshot, starbreak_small, succeed_small, write_photo};
use serde_json::Value;

/// Three photos, the middle one cut short.
fn with_one_bad(dir: &Path) {
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&dir.join(name));
    }
    let whole = fs::read(dir.join("b.png")).unwrap();
    fs::write(dir.join("b.png"), &whole[..whole.len() / 2]).unwrap();
}

fn files_of(stem: &str) -> [String; 4] {
    ["crack.png", "json", "png", "region.png"].map(|suffix| format!("{stem}.{suffix}"))
}

const THREE: [&str; 6] = ["crack", "a.png", "b.png", "c.png", "-o", "out"];

#[test]
fn one_bad_image_does_not_stop_the_others() {
    let dir = folder();
    with_one_bad(dir.path());
    let outcome = starbreak_small(dir.path(), &THREE);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome
            .stderr
            .lines()
            .all(|line| line.starts_with("error: ")),
        "{outcome:?}"
    );
    assert_eq!(
        outcome.stderr.matches("b.png").count(),
        1,
        "the bad image is named, once: {outcome:?}"
    );
    assert!(outcome.stderr.contains("failures.jsonl"), "{outcome:?}");

    let out = dir.path().join("out");
    let whole = [
        &files_of("a")[..],
        &files_of("c"),
        &["failures.jsonl".to_owned()],
    ]
    .concat();
    assert_eq!(names(&out), whole, "the others, and the list of failures");
    let list = fs::read_to_string(out.join("failures.jsonl")).unwrap();
    let records: Vec<Value> = list
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(records.len(), 1, "{list}");
    assert_eq!(records[0]["input"], "b.png", "{list}");
    let error = records[0]["error"].as_str().unwrap();
    assert!(error.contains("cut short"), "{list}");

    // The others are those of a run without the bad one.
    succeed_small(dir.path(), &["crack", "a.png", "c.png", "-o", "clean"]);
    for stem in ["a", "c"] {
        for name in files_of(stem).iter().filter(|name| name.ends_with("png")) {
            let read = |folder: &str| fs::read(dir.path().join(folder).join(name)).unwrap();
            assert!(read("out") == read("clean"), "{name} differs");
        }
    }
}

#[test]
fn a_clean_run_removes_the_list_of_failures() {
    let dir = folder();
    with_one_bad(dir.path());
    assert_eq!(
        starbreak_small(dir.path(), &THREE).code,
        Some(1),
        "one fails"
    );
    write_photo(&dir.path().join("b.png"));
    succeed_small(dir.path(), &THREE);
    let all = ["a", "b", "c"].map(files_of).concat();
    assert_eq!(names(&dir.path().join("out")), all, "no list of failures");
}

#[test]
fn a_failure_leaves_the_results_of_earlier_runs() {
    let dir = folder();
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&dir.path().join(name));
    }
    succeed_small(dir.path(), &THREE);
    let before = snapshot(&dir.path().join("out"));
    fs::write(dir.path().join("b.png"), "spoiled").unwrap();
    let again = [&THREE[..], &["--seed", "9"]].concat();
    assert_eq!(starbreak_small(dir.path(), &again).code, Some(1), "b fails");
    let after = snapshot(&dir.path().join("out"));
    for name in files_of("b") {
        let name = Path::new(&name);
        assert!(before[name] == after[name], "{name:?} was touched");
    }
    let name = Path::new("a.png");
    assert!(before[name] != after[name], "{name:?} was done again");
}

#[test]
fn all_bad_images_are_listed_in_the_order_given() {
    let dir = folder();
    let args = [
        "crack",
        "z.png",
        "y.png",
        "x.png",
        "-o",
        "out",
        "--threads",
        "2",
    ];
    let outcome = starbreak_small(dir.path(), &args);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let list = fs::read_to_string(dir.path().join("out/failures.jsonl")).unwrap();
    let inputs: Vec<Value> = list
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["input"].clone())
        .collect();
    assert_eq!(inputs, ["z.png", "y.png", "x.png"], "{list}");
}

#[test]
fn quiet_says_nothing_on_success() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    for args in [
        &["crack", "a.png", "-o", "o", "--quiet", "--preset", "paper"][..],
        &["crack", "a.png", "-o", "o", "-q", "--preset", "paper"],
        &["simulate", "-o", "n.json", "-q", "--preset", "paper"],
        &[
            "simulate",
            "-o",
            "n.json",
            "-q",
            "--preset",
            "paper",
            "--set",
            "impact.force=1",
        ],
        &["demo", "-o", "d", "-q", "--preset", "paper"],
        &["man", "-o", "m", "-q"],
    ] {
        let outcome = crate::program::succeed(dir.path(), args);
        assert_eq!(
            (outcome.stdout.as_str(), outcome.stderr.as_str()),
            ("", ""),
            "starbreak {args:?}"
        );
    }
    let outcome = crate::program::succeed(dir.path(), &["simulate", "-q", "--preset", "paper"]);
    assert!(outcome.stdout.starts_with('{'), "data is no chatter");
    assert_eq!(outcome.stderr, "", "simulate -q");
}

#[test]
fn quiet_still_says_what_is_wrong() {
    let dir = folder();
    let outcome = starbreak_small(dir.path(), &["crack", "nope.png", "-o", "o", "-q"]);
    assert_eq!(outcome.complaint("nope.png"), None, "quiet, but not mute");
}

/// One document on standard output: it parses as a whole.
fn document(outcome: &crate::program::Outcome) -> Value {
    serde_json::from_str(&outcome.stdout).unwrap_or_else(|cause| panic!("{cause}: {outcome:?}"))
}

#[test]
fn json_is_one_document_and_nothing_else() {
    let dir = folder();
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&dir.path().join(name));
    }
    let json = |args: &[&str]| {
        // `man` takes no recipe.
        let flags = ["--json", "--preset", "paper"];
        let flags = if args[0] == "man" {
            &flags[..1]
        } else {
            &flags
        };
        document(&crate::program::succeed(
            dir.path(),
            &[args, flags].concat(),
        ))
    };
    let cracked = json(&THREE);
    let images = cracked["images"].as_array().unwrap();
    assert_eq!(images.len(), 3, "{cracked}");
    for image in images {
        for key in ["image", "region", "crack", "provenance"] {
            let path = image[key].as_str().unwrap();
            assert!(dir.path().join(path).is_file(), "{key}: {path}");
        }
        assert_eq!(image["intact"], false, "{image}");
    }
    let simulated = json(&["simulate", "-o", "n.json"]);
    assert_eq!(simulated["network"], "n.json", "{simulated}");
    assert_eq!(json(&["demo", "-o", "d"])["output"], "d", "demo");
    assert!(json(&["recipe"])["recipe"].is_string(), "recipe");
    assert!(json(&["recipe", "--list"])["presets"].is_array(), "presets");
    assert!(
        json(&["recipe", "--schema"])["properties"].is_object(),
        "schema"
    );
    assert!(json(&["man", "-o", "m"])["pages"].is_array(), "man");
    let bench = json(&[
        "bench",
        "--model",
        "paper",
        "-o",
        "b",
        "--runs",
        "1",
        "--particles",
        "50",
    ]);
    assert_eq!(bench["series"].as_array().map(Vec::len), Some(1), "{bench}");
}

#[test]
fn json_lists_the_failures_as_well() {
    let dir = folder();
    with_one_bad(dir.path());
    let outcome = starbreak_small(dir.path(), &[&THREE[..], &["--json"]].concat());
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let result = document(&outcome);
    assert_eq!(
        result["images"].as_array().map(Vec::len),
        Some(2),
        "{result}"
    );
    assert_eq!(result["failed"][0]["input"], "b.png", "{result}");
}

/// File names are bytes on Unix, and a folder may be called anything.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf8_do_not_panic() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let odd = OsStr::from_bytes(b"odd\xff");
    write_photo(&dir.path().join(OsStr::from_bytes(b"odd\xff.png")));
    let word = OsStr::new;
    for (args, code) in [
        (vec![word("crack"), word("a.png"), word("-o"), odd], 0),
        (
            vec![word("simulate"), word("-o"), OsStr::from_bytes(b"n\xff")],
            0,
        ),
        (vec![word("man"), word("-o"), odd], 0),
        (
            vec![
                word("crack"),
                OsStr::from_bytes(b"odd\xff.png"),
                word("-o"),
                word("o"),
            ],
            0,
        ),
        (
            vec![word("crack"), odd, word("a.png"), word("-o"), word("o2")],
            1,
        ),
    ] {
        let of_recipe = [word("--preset"), word("paper")];
        // `man` takes no recipe.
        let of_recipe = if args[0] == word("man") {
            &[][..]
        } else {
            &of_recipe
        };
        let args = [&args[..], of_recipe].concat();
        let outcome = crate::program::starbreak(dir.path(), &args);
        assert_eq!(outcome.code, Some(code), "starbreak {args:?}: {outcome:?}");
    }
}
