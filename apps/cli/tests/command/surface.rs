//! Completions, man pages, help, recipes, bench and closed pipes.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::{Outcome, QUICK_BENCH, folder, names, raw_png, succeed};
use serde_json::Value;

const VERBS: [&str; 20] = [
    "demo",
    "crack",
    "generate",
    "verify",
    "merge",
    "study",
    "detect",
    "evaluate",
    "timeline",
    "divergence",
    "patterns",
    "video",
    "bag",
    "pipe",
    "sweep",
    "simulate",
    "recipe",
    "bench",
    "completions",
    "man",
];

#[test]
fn completions_know_every_verb() {
    let dir = folder();
    for shell in ["bash", "zsh", "fish"] {
        let script = succeed(dir.path(), &["completions", shell]).stdout;
        for word in VERBS.iter().chain(&["preset", "frames-to"]) {
            assert!(script.contains(word), "{shell}: {word}");
        }
        if shell == "bash" && Path::new("/bin/bash").exists() {
            fs::write(dir.path().join("s"), &script).unwrap();
            let checked = Command::new("/bin/bash")
                .args(["-n", "s"])
                .current_dir(dir.path())
                .output()
                .unwrap();
            assert!(checked.status.success(), "bash refuses it: {checked:?}");
        }
    }
}

#[test]
fn there_is_a_man_page_for_every_verb() {
    let dir = folder();
    succeed(dir.path(), &["man", "-o", "man"]);
    let mut expected: Vec<String> = VERBS
        .iter()
        .map(|verb| format!("starbreak-{verb}.1"))
        .collect();
    expected.push("starbreak.1".to_owned());
    expected.sort();
    assert_eq!(names(&dir.path().join("man")), expected, "pages");
    for name in expected {
        let page = fs::read_to_string(dir.path().join("man").join(&name)).unwrap();
        assert!(page.contains(".SH NAME"), "{name}: {page:.200}");
        assert!(page.contains(".SH SYNOPSIS"), "{name}: {page:.200}");
    }
}

#[test]
fn every_verb_helps() {
    let dir = folder();
    let all = succeed(dir.path(), &["--help"]);
    for verb in VERBS {
        assert!(all.stdout.contains(verb), "{verb}: {}", all.stdout);
        let help = succeed(dir.path(), &[verb, "--help"]);
        let usage = format!("Usage: starbreak {verb}");
        assert!(help.stdout.contains(&usage), "{verb}: {}", help.stdout);
        // What else a verb shows is in flags.rs.
        assert!(help.stdout.contains("--quiet"), "{verb}: {}", help.stdout);
        assert_eq!(help.stderr, "", "{verb}: help is no error");
    }
    let version = succeed(dir.path(), &["--version"]).stdout;
    assert_eq!(
        version,
        format!("starbreak {}\n", env!("CARGO_PKG_VERSION")),
        "version"
    );
}

#[test]
fn presets_are_listed_and_each_prints() {
    let dir = folder();
    let list = succeed(dir.path(), &["recipe", "--list"]).stdout;
    assert!(list.starts_with("windshield-star "), "{list}");
    let (presets, cameras) = list.split_once("\n\ncameras (--camera NAME):\n").unwrap();
    let (presets, alone) = presets.split_once("\n\n").unwrap();
    let alone = alone.split_whitespace().last().unwrap();
    assert_eq!(alone, "rainy-drive.drops", "{list}");
    for (line, flag) in presets
        .lines()
        .chain([alone])
        .map(|line| (line, "--preset"))
        .chain(cameras.lines().map(|line| (line, "--camera")))
    {
        let name = line.split_whitespace().next().unwrap();
        let recipe = succeed(dir.path(), &["recipe", flag, name]).stdout;
        fs::write(dir.path().join("r.toml"), &recipe).unwrap();
        let again = succeed(dir.path(), &["recipe", "--recipe", "r.toml"]).stdout;
        assert_eq!(recipe, again, "{name}");
    }
}

#[test]
fn the_schema_holds_every_key_of_the_recipe() {
    let dir = folder();
    let text = succeed(dir.path(), &["recipe", "--schema"]).stdout;
    let schema: Value = serde_json::from_str(&text).unwrap();
    let definition = |table: &str| {
        let property = &schema["properties"][table];
        let items = &property["items"];
        let table = if items.is_object() { items } else { property };
        table.clone()
    };
    let recipe = succeed(dir.path(), &["recipe"]).stdout;
    let (mut table, mut n_keys, mut described) = (String::new(), 0, false);
    for line in recipe.lines() {
        let comment = line.starts_with('#');
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).to_owned();
            assert!(described, "[{table}] has no comment");
        } else if let Some((key, _)) = line.split_once(" = ").filter(|_| !comment) {
            n_keys += 1;
            assert!(described, "{table}.{key} has no comment");
            let known = if table.is_empty() {
                schema["properties"][key].is_object()
            } else {
                definition(&table)["properties"][key].is_object()
            };
            assert!(known, "{table}.{key} is not in the schema");
        }
        described = comment;
    }
    assert!(n_keys >= 20, "{n_keys} keys");
    assert_eq!(
        schema["additionalProperties"], false,
        "unknown keys are refused"
    );
}

#[test]
fn bench_writes_table_rows_and_plots() {
    let dir = folder();
    let args = [
        "bench",
        "--model",
        "paper",
        "--runs",
        "2",
        "--particles",
        "500,1000",
        "-o",
        "b",
    ];
    let outcome = succeed(dir.path(), &args);
    let out = dir.path().join("b");
    assert_eq!(
        names(&out),
        ["bench.csv", "bench.png", "bench.svg", "bench.txt"],
        "files"
    );
    let table = fs::read_to_string(out.join("bench.txt")).unwrap();
    assert!(outcome.stdout.contains(&table), "the table is shown");
    for word in [
        "500 particles",
        "1000 particles",
        "mesh",
        "mst",
        "render",
        "total",
    ] {
        assert!(table.contains(word), "{word}: {table}");
    }
    let csv = fs::read_to_string(out.join("bench.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 5, "a header and four runs: {csv}");
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    let column = |name: &str| {
        let at = rows[0].iter().position(|column| *column == name).unwrap();
        rows[1..].iter().map(move |row| row[at])
    };
    assert_eq!(
        column("particles").collect::<Vec<_>>(),
        ["500", "500", "1000", "1000"],
        "{csv}"
    );
    assert_eq!(
        column("run").collect::<Vec<_>>(),
        ["0", "1", "0", "1"],
        "{csv}"
    );
    let milliseconds = rows[0].iter().filter(|name| name.ends_with("_ms"));
    for name in milliseconds {
        let times = column(name).map(|time| time.parse::<f64>().unwrap());
        assert!(times.into_iter().all(|time| time >= 0.0), "{name}: {csv}");
    }
    let svg = fs::read_to_string(out.join("bench.svg")).unwrap();
    assert!(
        svg.contains("<svg") && svg.trim_end().ends_with("</svg>"),
        "SVG"
    );
    assert!(!svg.contains("NaN"), "the plot has numbers");
    let png = raw_png(&out.join("bench.png"));
    assert!(png.data.iter().any(|byte| *byte != png.data[0]), "PNG");
}

#[test]
fn every_verb_bears_a_closed_pipe() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    for args in [
        &["simulate", "--preset", "paper"][..],
        &["simulate", "--json", "-o", "n.json", "--preset", "paper"],
        &["recipe"],
        &["recipe", "--schema"],
        &["recipe", "--list"],
        &["completions", "bash"],
        &["man", "-o", "m"],
        &["demo", "-o", "d", "--preset", "paper"],
        &["crack", "a.png", "-o", "o", "--preset", "paper"],
        &[&QUICK_BENCH[..], &["-o", "b"]].concat(),
        &["--help"],
        &["crack", "--help"],
        &["--version"],
        &["crack", "nope.png", "-o", "o"],
    ] {
        let mut child = crate::program::command(dir.path(), args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let outcome: Outcome = child.wait_with_output().unwrap().into();
        let expected = if args.contains(&"nope.png") { 2 } else { 0 };
        assert_eq!(
            outcome.code,
            Some(expected),
            "starbreak {args:?}: {outcome:?}"
        );
        assert!(
            !outcome.stderr.contains("panic"),
            "starbreak {args:?}: {outcome:?}"
        );
    }
}
