//! The walls of the house: which crate may use what, and what no library does.
//!
//! The tables say what is allowed where, with a reason; a new line in one needs a reason, too.
//! Each rule is seen to fail in the module at the end.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot read the workspace has failed"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use xtask::metadata::{Kind, Metadata, Package};
use xtask::root;
use xtask::rust_source::{code_only, files_below, has_word, uses_std, without_tests};

/// Which of our crates each of them may use; their tests and examples may use others.
const OURS: &[(&str, &[&str])] = &[
    ("starbreak-seed", &[]),
    ("starbreak-glass", &["starbreak-seed"]),
    ("starbreak-fracture", &["starbreak-seed", "starbreak-glass"]),
    ("starbreak-deposit", &["starbreak-seed"]),
    (
        "starbreak-optics",
        &["starbreak-seed", "starbreak-glass", "starbreak-deposit"],
    ),
    ("starbreak-sensor", &["starbreak-seed"]),
    ("starbreak-dataset", &[]),
    ("starbreak-detect", &["starbreak-dataset"]),
    ("starbreak-eval", &["starbreak-dataset"]),
    (
        "starbreak",
        &[
            "starbreak-deposit",
            "starbreak-sensor",
            "starbreak-seed",
            "starbreak-glass",
            "starbreak-fracture",
            "starbreak-optics",
        ],
    ),
    (
        "starbreak-runs",
        &[
            "starbreak",
            "starbreak-seed",
            "starbreak-glass",
            "starbreak-fracture",
            "starbreak-optics",
            "starbreak-dataset",
            "starbreak-detect",
            "starbreak-eval",
        ],
    ),
    (
        "starbreak-cli",
        &[
            "starbreak",
            "starbreak-runs",
            "starbreak-dataset",
            "starbreak-detect",
            "starbreak-eval",
        ],
    ),
    // The wheel has the command, too.
    (
        "starbreak-python",
        &["starbreak", "starbreak-runs", "starbreak-cli"],
    ),
    // The playground needs no threads; detectors are a module of their own, for those who bring a model.
    ("starbreak-web-desk", &[]),
    (
        "starbreak-web",
        &["starbreak", "starbreak-dataset", "starbreak-web-desk"],
    ),
    (
        "starbreak-web-detector",
        &["starbreak-detect", "starbreak-web-desk"],
    ),
    (
        "starbreak-fuzz",
        &[
            "starbreak",
            "starbreak-runs",
            "starbreak-dataset",
            "starbreak-detect",
            "starbreak-eval",
        ],
    ),
    ("xtask", &[]),
];

/// Packages that only the named crates may use directly: package, users, reason.
const RESERVED: &[(&str, &[&str], &str)] = &[
    ("clap", SHELL, "libraries have no command line"),
    ("clap_complete", SHELL, "libraries have no command line"),
    ("clap_mangen", SHELL, "libraries have no command line"),
    ("ctrlc", SHELL, "libraries do not own the process"),
    ("mimalloc", SHELL, "the allocator is the process's"),
    ("indicatif", SHELL, "libraries do not print"),
    ("pyo3", PYTHON, "libraries know no Python"),
    ("numpy", PYTHON, "libraries know no Python"),
    ("ab_glyph", SHELL, "libraries draw no letters"),
    ("ab_glyph_rasterizer", SHELL, "libraries draw no letters"),
    ("epaint_default_fonts", SHELL, "libraries draw no letters"),
    (
        "hotcoco",
        &["starbreak-eval"],
        "the protocol of MS-COCO stands in one place",
    ),
    (
        "minijinja",
        &["starbreak-eval"],
        "only the report is made from a template",
    ),
    (
        "base64",
        &["starbreak-eval"],
        "only the report holds pictures as text",
    ),
    ("anyhow", SHELL, "libraries name their errors"),
    ("png", CODECS, "files are read and written in one place"),
    (
        "jpeg-encoder",
        &["starbreak-dataset", "starbreak-sensor"],
        "files are written in one place, and the link of a camera is the other codec",
    ),
    (
        "ffmpeg-sidecar",
        CODECS,
        "clips are read and written in one place",
    ),
    (
        "lz4_flex",
        CODECS,
        "only the records of banks are compressed",
    ),
    (
        "crc32fast",
        &["starbreak-dataset", "starbreak-runs"],
        "only the records of banks have checksums of our own, and those of bags are checked",
    ),
    ("mcap", BAGS, "bags are read and written in one place"),
    ("lz4", BAGS, "only the chunks of bags are compressed by it"),
    ("zstd", BAGS, "only the chunks of bags are compressed by it"),
    ("saphyr-parser", CODECS, "only data.yaml of YOLO is YAML"),
    (
        "serde",
        &[
            "starbreak-seed",
            "starbreak-glass",
            "starbreak-dataset",
            "starbreak-detect",
            "starbreak-eval",
            "starbreak",
            "starbreak-runs",
            "starbreak-cli",
            "starbreak-web",
            "starbreak-web-detector",
        ],
        "solvers do not serialize; serialization is a boundary",
    ),
    (
        "serde_json",
        &[
            "starbreak-seed",
            "starbreak-glass",
            "starbreak-dataset",
            "starbreak-eval",
            "starbreak",
            "starbreak-runs",
            "starbreak-cli",
            "starbreak-python",
            "starbreak-web",
            "starbreak-web-desk",
            "starbreak-web-detector",
            "xtask",
        ],
        "solvers do not serialize; serialization is a boundary",
    ),
    (
        "toml",
        &["starbreak", "starbreak-detect"],
        "only a recipe and a detector's contract are TOML",
    ),
    (
        "rten",
        &["starbreak-detect"],
        "detectors are run in one place",
    ),
    (
        "ort",
        &["starbreak-detect"],
        "detectors are run in one place",
    ),
    (
        "rayon",
        &[
            "starbreak-dataset",
            "starbreak-eval",
            "starbreak-runs",
            "starbreak-cli",
        ],
        "the chain runs in a browser, too, which has no threads",
    ),
    ("roxmltree", &["starbreak"], "only an import reads SVG"),
    ("simplecss", &["starbreak"], "only an import reads SVG"),
    ("svgtypes", &["starbreak"], "only an import reads SVG"),
    ("spdx", &["xtask"], "a chore"),
];

/// The command.
const SHELL: &[&str] = &["starbreak-cli"];

/// The Python package.
const PYTHON: &[&str] = &["starbreak-python"];

/// The crate that puts bags behind glass.
const BAGS: &[&str] = &["starbreak-runs"];

/// The crate that touches files and codecs.
const CODECS: &[&str] = &["starbreak-dataset"];

/// Features of `image` that each crate may turn on.
const IMAGE_FEATURES: &[(&str, &[&str])] =
    &[("starbreak-dataset", &["bmp", "jpeg", "png", "webp"])];

/// What library code may use only in certain places: what, prefixes of paths, reason.
const LIBRARY_USES: &[(Use, &[&str], &str)] = &[
    (
        Use::Word("println!"),
        &[],
        "libraries return, they do not print",
    ),
    (
        Use::Word("eprintln!"),
        &[],
        "libraries return, they do not print",
    ),
    (
        Use::Word("print!"),
        &[],
        "libraries return, they do not print",
    ),
    (
        Use::Word("eprint!"),
        &[],
        "libraries return, they do not print",
    ),
    (
        Use::Std("process"),
        &["crates/dataset/src/video/"],
        "libraries do not own the process; clips are read and written by the program ffmpeg",
    ),
    (
        Use::Std("env"),
        &[],
        "settings are arguments, never ambient",
    ),
    (Use::Std("net"), &[], "nothing here is online"),
    (
        Use::Std("fs"),
        &["crates/dataset/src/"],
        "dataset is the one crate that touches files",
    ),
    (
        Use::PathOnDisk,
        &["crates/dataset/src/"],
        "dataset is the one crate that touches files",
    ),
    (
        Use::Word("Instant"),
        &["crates/starbreak/src/timings.rs"],
        "the chain times its stages; results do not depend on time",
    ),
    (
        Use::Word("HashMap"),
        &["crates/fracture/src/arrangement.rs"],
        "iteration is unordered; this one is only looked up in, never walked",
    ),
    (Use::Word("HashSet"), &[], "iteration is unordered"),
    (
        Use::Word("mul_add"),
        &[],
        "`wide` fuses it or not by the processor, and results do not depend on that",
    ),
];

/// What no code uses, tests included: word, reason.
const NOWHERE: &[(&str, &str)] = &[
    ("thread_rng", "randomness comes from a Seed"),
    ("rand::random", "randomness comes from a Seed"),
    ("StdRng", "its numbers change with its version"),
    ("OsRng", "randomness comes from a Seed"),
    ("SystemTime", "results do not depend on the date"),
];

/// What solvers must not write: word, crates.
const NOT_IN_SOLVERS: &[&str] = &["Serialize", "Deserialize", "serde"];

/// The solvers.
const SOLVERS: &[&str] = &["crates/fracture/src/", "crates/optics/src/"];

/// Names that say nothing about what is inside.
const EMPTY_NAMES: &[&str] = &[
    "common", "core", "helper", "helpers", "misc", "types", "util", "utils",
];

/// Lines of a source file from which on it is to be split.
const MAX_LINES: usize = 500;

/// Files that may be longer: path, reason.
const LONG_FILES: &[(&str, &str)] = &[];

/// Something that code may use.
#[derive(Debug, Clone, Copy)]
enum Use {
    /// A word, whole.
    Word(&'static str),
    /// `std::<module>`, also in a group.
    Std(&'static str),
    /// A method of `Path` that asks the disk, no `std::fs` needed.
    PathOnDisk,
}

/// Methods of `Path` that ask the disk.
const PATH_ON_DISK: [&str; 8] = [
    "canonicalize",
    "exists",
    "is_dir",
    "is_file",
    "read_dir",
    "read_link",
    "symlink_metadata",
    "try_exists",
];

impl Use {
    fn is_in(self, code: &str) -> bool {
        match self {
            Self::Word(word) => has_word(code, word),
            Self::Std(module) => uses_std(code, module),
            Self::PathOnDisk => PATH_ON_DISK.iter().any(|word| has_word(code, word)),
        }
    }

    fn name(self) -> String {
        match self {
            Self::Word(word) => word.to_owned(),
            Self::Std(module) => format!("std::{module}"),
            Self::PathOnDisk => "methods of Path that ask the disk".to_owned(),
        }
    }
}

/// A Rust file of ours.
struct Source {
    path: String,
    n_lines: usize,
    /// Without comments and strings.
    code: String,
}

impl Source {
    fn of(path: &str, text: &str) -> Self {
        Self {
            path: path.to_owned(),
            n_lines: text.lines().count(),
            code: code_only(text),
        }
    }

    /// Whether it is compiled into a library or command, not into a test.
    fn is_shipped(&self) -> bool {
        self.path.contains("/src/") && !self.path.ends_with("/tests.rs")
    }

    fn is_library(&self) -> bool {
        self.path.starts_with("crates/") && self.is_shipped()
    }
}

fn sources() -> Vec<Source> {
    let folders = ["crates", "apps", "xtask/src"];
    let files = folders.map(|folder| files_below(root(), folder, "rs").unwrap());
    let read = |path: &String| Source::of(path, &fs::read_to_string(root().join(path)).unwrap());
    files.iter().flatten().map(read).collect()
}

fn packages() -> Vec<Package> {
    let metadata = Metadata::of_workspace(root()).unwrap();
    metadata.ours().into_iter().cloned().collect()
}

fn check(findings: Vec<String>) {
    assert!(findings.is_empty(), "\n{}\n", findings.join("\n"));
}

fn allowed<'a>(table: &[(&str, &'a [&'a str])], name: &str) -> Option<&'a [&'a str]> {
    table
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, list)| *list)
}

#[test]
fn our_crates_use_each_other_as_drawn() {
    check(edges_not_drawn(&packages()));
}

fn edges_not_drawn(packages: &[Package]) -> Vec<String> {
    let mut findings = Vec::new();
    for package in packages {
        let Some(drawn) = allowed(OURS, &package.name) else {
            findings.push(format!("{} is not in the plan", package.name));
            continue;
        };
        for used in package.dependencies.iter().filter(|d| d.kind != Kind::Dev) {
            let is_ours = allowed(OURS, &used.name).is_some() || used.source.is_none();
            if is_ours && !drawn.contains(&used.name.as_str()) {
                findings.push(format!("{} must not use {}", package.name, used.name));
            }
        }
    }
    findings
}

#[test]
fn modules_import_each_other_in_no_circle() {
    let sources = sources();
    let mut findings = Vec::new();
    for package in packages() {
        let Some(name) = package.name.strip_prefix("starbreak") else {
            continue;
        };
        let folder = match name.trim_start_matches('-') {
            "" => "starbreak",
            name => name,
        };
        if let Some(circle) = circle_in(&sources, &format!("crates/{folder}/src/")) {
            findings.push(format!("{folder}: {}", circle.join(" -> ")));
        }
    }
    check(findings);
}

/// Modules of the root of a crate, each of which imports the next and the last the first; of those that
/// there are the first by name.
fn circle_in(sources: &[Source], root: &str) -> Option<Vec<String>> {
    let library = sources.iter().find(|s| s.path == format!("{root}lib.rs"))?;
    let code = without_tests(&library.code);
    let of_item = |line: &str| -> Option<(String, Vec<String>)> {
        // `pub use module::{A, B};`: A and B stand for the module.
        let (module, names) = line.split_once("use ")?.1.split_once("::")?;
        let names = names.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let names = names.filter(|name| !name.is_empty());
        Some((module.to_owned(), names.map(str::to_owned).collect()))
    };
    let modules: BTreeSet<String> = code
        .split(';')
        .filter_map(|item| Some(item.rsplit_once("mod ")?.1.trim().to_owned()))
        .collect();
    let exported: BTreeMap<String, String> = code
        .split(';')
        .filter_map(of_item)
        .filter(|(module, _)| modules.contains(module))
        .flat_map(|(module, names)| names.into_iter().map(move |name| (name, module.clone())))
        .collect();
    let mut imports: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for source in sources.iter().filter(|s| s.is_shipped()) {
        let Some(path) = source.path.strip_prefix(root) else {
            continue;
        };
        let Some(module) = modules.get(path.trim_end_matches(".rs").split('/').next()?) else {
            continue;
        };
        for word in names_behind_crate(&without_tests(&source.code)) {
            let used = modules.get(&word).or_else(|| exported.get(&word));
            if let Some(used) = used.filter(|used| *used != module) {
                imports.entry(module).or_default().insert(used);
            }
        }
    }
    let reaches = |from: &str| -> Option<Vec<String>> {
        let mut ways = vec![vec![from.to_owned()]];
        let mut seen = BTreeSet::new();
        while let Some(way) = ways.pop() {
            for next in imports.get(way.last()?.as_str()).into_iter().flatten() {
                if *next == from {
                    return Some(way);
                }
                if seen.insert(*next) {
                    ways.push([&way[..], &[(*next).to_owned()]].concat());
                }
            }
        }
        None
    };
    modules.iter().find_map(|module| reaches(module))
}

/// The first names of all paths that begin with `crate::`, also in groups.
fn names_behind_crate(code: &str) -> Vec<String> {
    let mut names = Vec::new();
    for part in code.split("crate::").skip(1) {
        let of = |text: &str| -> String {
            let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
            text.trim_start().chars().take_while(is_part).collect()
        };
        let Some(group) = part.strip_prefix('{') else {
            names.push(of(part));
            continue;
        };
        let (mut depth, mut start) = (0_i32, 0);
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => {
                    names.push(of(&group[start..]));
                    break;
                }
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    names.push(of(&group[start..]));
                    start = at + 1;
                }
                _ => {}
            }
        }
    }
    names
}

#[test]
fn packages_stay_where_they_belong() {
    check(packages_out_of_place(&packages()));
}

fn packages_out_of_place(packages: &[Package]) -> Vec<String> {
    let mut findings = Vec::new();
    for package in packages {
        for used in package.dependencies.iter().filter(|d| d.kind != Kind::Dev) {
            for (_, users, why) in RESERVED.iter().filter(|rule| rule.0 == used.name) {
                if !users.contains(&package.name.as_str()) {
                    findings.push(format!(
                        "{} must not use {}: {why}",
                        package.name, used.name
                    ));
                }
            }
        }
    }
    findings
}

#[test]
fn only_dataset_turns_on_codecs() {
    check(codecs_out_of_place(&packages()));
}

fn codecs_out_of_place(packages: &[Package]) -> Vec<String> {
    let mut findings = Vec::new();
    for package in packages {
        let features = allowed(IMAGE_FEATURES, &package.name).unwrap_or_default();
        for used in package.dependencies.iter().filter(|d| d.name == "image") {
            if used.uses_default_features {
                findings.push(format!("{} uses image with all codecs", package.name));
            }
            for feature in &used.features {
                if !features.contains(&feature.as_str()) {
                    findings.push(format!(
                        "{} must not turn on `{feature}` of image",
                        package.name
                    ));
                }
            }
        }
    }
    findings
}

#[test]
fn libraries_are_pure() {
    check(impurities(&sources()));
}

fn impurities(sources: &[Source]) -> Vec<String> {
    let mut findings = Vec::new();
    for source in sources.iter().filter(|source| source.is_library()) {
        let code = without_tests(&source.code);
        for (what, places, why) in LIBRARY_USES {
            let is_allowed = places.iter().any(|place| source.path.starts_with(place));
            if !is_allowed && what.is_in(&code) {
                findings.push(format!(
                    "{} must not use {}: {why}",
                    source.path,
                    what.name()
                ));
            }
        }
    }
    findings
}

#[test]
fn no_entry_of_a_table_is_dead() {
    let sources = sources();
    let mut findings = Vec::new();
    for (what, places, _) in LIBRARY_USES {
        for place in *places {
            let is_used = sources
                .iter()
                .any(|source| source.path.starts_with(place) && what.is_in(&source.code));
            if !is_used {
                findings.push(format!("{place} does not use {}", what.name()));
            }
        }
    }
    for (path, _) in LONG_FILES {
        let is_long = |source: &Source| source.path == *path && source.n_lines > MAX_LINES;
        if !sources.iter().any(is_long) {
            findings.push(format!("{path} is not long"));
        }
    }
    check(findings);
}

#[test]
fn nothing_is_random_but_by_seed() {
    check(ambient(&sources()));
}

fn ambient(sources: &[Source]) -> Vec<String> {
    let mut findings = Vec::new();
    for source in sources {
        for (word, why) in NOWHERE {
            if has_word(&source.code, word) {
                findings.push(format!("{} must not use {word}: {why}", source.path));
            }
        }
    }
    findings
}

#[test]
fn solvers_do_not_serialize() {
    check(serializing_solvers(&sources()));
}

fn serializing_solvers(sources: &[Source]) -> Vec<String> {
    let is_solver = |source: &&Source| SOLVERS.iter().any(|solver| source.path.starts_with(solver));
    let mut findings = Vec::new();
    for source in sources.iter().filter(is_solver) {
        for word in NOT_IN_SOLVERS {
            if has_word(&source.code, word) {
                findings.push(format!("{} must not use {word}", source.path));
            }
        }
    }
    findings
}

#[test]
fn names_say_what_is_inside() {
    check(empty_names(&sources()));
}

fn empty_names(sources: &[Source]) -> Vec<String> {
    let mut findings = Vec::new();
    for Source { path, .. } in sources.iter().filter(|source| source.is_shipped()) {
        let Some((_, inside)) = path.split_once("/src/") else {
            continue;
        };
        for name in inside.trim_end_matches(".rs").split('/') {
            if EMPTY_NAMES.contains(&name) {
                findings.push(format!(
                    "{path}: {name:?} says nothing; name what is inside"
                ));
            }
        }
    }
    findings
}

#[test]
fn files_are_short() {
    check(long_files(&sources()));
}

fn long_files(sources: &[Source]) -> Vec<String> {
    let is_long = |source: &&Source| {
        source.is_shipped()
            && source.n_lines > MAX_LINES
            && !LONG_FILES.iter().any(|(path, _)| *path == source.path)
    };
    sources
        .iter()
        .filter(is_long)
        .map(|source| {
            format!(
                "{} has {} lines; split it, or give a reason in LONG_FILES",
                source.path, source.n_lines
            )
        })
        .collect()
}

#[test]
fn every_file_of_tests_is_run() {
    let manifest =
        |folder: &str| fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
    check(forgotten_tests(&sources(), manifest));
}

/// Files of tests that neither the program `all` of their crate takes in nor its manifest names, where cargo is told
/// to look for none itself.
fn forgotten_tests(sources: &[Source], manifest: impl Fn(&str) -> String) -> Vec<String> {
    let mut findings = Vec::new();
    for Source { path, .. } in sources {
        let Some((folder, file)) = path.split_once("/tests/") else {
            continue;
        };
        let Some(name) = file.strip_suffix(".rs").filter(|name| !name.contains('/')) else {
            continue;
        };
        let named = manifest(folder);
        let all = format!("{folder}/tests/all.rs");
        let is_in_all = |all: &Source| all.code.contains(&format!("mod {name};"));
        let is_run = !named.contains("autotests = false")
            || named.contains(&format!("[[test]]\nname = \"{name}\""))
            || sources
                .iter()
                .any(|source| source.path == all && is_in_all(source));
        if !is_run {
            findings.push(format!("{path} is not run: name it in {all}"));
        }
    }
    findings
}

mod each_rule_can_fail {
    use xtask::metadata::Dependency;

    use super::*;

    fn package(name: &str, used: &str, features: &[&str]) -> [Package; 1] {
        [Package {
            name: name.to_owned(),
            dependencies: vec![Dependency {
                name: used.to_owned(),
                features: features.iter().map(|f| (*f).to_owned()).collect(),
                source: Some("registry".to_owned()),
                ..Dependency::default()
            }],
            ..Package::default()
        }]
    }

    #[test]
    fn on_dependencies() {
        for (name, used) in [
            ("starbreak-glass", "starbreak-optics"),
            ("starbreak-fracture", "starbreak-optics"),
            ("starbreak-optics", "starbreak-fracture"),
            ("starbreak-dataset", "starbreak-glass"),
            ("starbreak-cli", "starbreak-glass"),
            ("starbreak-new", "starbreak-glass"),
        ] {
            let found = edges_not_drawn(&package(name, used, &[]));
            assert_eq!(found.len(), 1, "{name} -> {used}: {found:?}");
        }
        for (name, used) in [
            ("starbreak", "clap"),
            ("starbreak-dataset", "indicatif"),
            ("starbreak-optics", "ab_glyph"),
            ("starbreak-fracture", "serde"),
            ("starbreak-optics", "png"),
            ("starbreak-glass", "svgtypes"),
        ] {
            let found = packages_out_of_place(&package(name, used, &[]));
            assert_eq!(found.len(), 1, "{name} -> {used}: {found:?}");
        }
        let found = codecs_out_of_place(&package("starbreak-optics", "image", &["png"]));
        assert_eq!(found.len(), 1, "{found:?}");
    }

    #[test]
    fn on_sources() {
        let check = |rule: fn(&[Source]) -> Vec<String>, path: &str, text: &str, n: usize| {
            let found = rule(&[Source::of(path, text)]);
            assert_eq!(found.len(), n, "{path}: {text}: {found:?}");
        };
        let library = "crates/optics/src/blur.rs";
        for bad in [
            "fn f() { println!(\"a\") }",
            "fn f() { eprintln!(\"a\") }",
            "use std::process::Command;",
            "use std::{env, io};",
            "use std::fs::File;",
            "use std::time::Instant;",
            "fn f(path: &Path) -> bool { path.exists() }",
            "use std::collections::HashMap;",
            "use std::collections::HashSet;",
        ] {
            check(impurities, library, bad, 1);
        }
        check(
            impurities,
            library,
            "// println!\n/// std::fs\nfn f() {}",
            0,
        );
        check(
            impurities,
            library,
            "#[cfg(test)]\nmod tests { use std::fs; }",
            0,
        );
        check(impurities, "crates/dataset/src/paths.rs", "use std::fs;", 0);
        check(
            impurities,
            "crates/dataset/tests/paths.rs",
            "use std::env;",
            0,
        );
        for bad in ["rand::thread_rng()", "rand::random()", "SystemTime::now()"] {
            check(ambient, "apps/cli/tests/command/demo.rs", bad, 1);
        }
        check(
            serializing_solvers,
            library,
            "#[derive(Clone, Serialize)]\nstruct A;",
            1,
        );
        check(empty_names, "crates/glass/src/utils.rs", "", 1);
        check(empty_names, "apps/cli/src/common/paint.rs", "", 1);
        check(empty_names, "apps/cli/tests/common.rs", "", 0);
        check(long_files, library, &"\n".repeat(MAX_LINES + 1), 1);
        check(long_files, library, &"\n".repeat(MAX_LINES), 0);
    }

    #[test]
    fn a_forgotten_test_is_found() {
        let sources = |names: &str| {
            let file = |name: &str| Source::of(&format!("crates/glass/tests/{name}.rs"), "");
            let all = Source::of("crates/glass/tests/all.rs", names);
            [all, file("network"), file("golden"), file("network/plain")]
        };
        let manifest = |_: &str| {
            "autotests = false\n[[test]]\nname = \"all\"\n\n[[test]]\nname = \"golden\"\n"
                .to_owned()
        };
        let forgotten = forgotten_tests(&sources("mod net;"), manifest);
        assert_eq!(forgotten.len(), 1, "{forgotten:?}");
        assert!(forgotten_tests(&sources("mod network;"), manifest).is_empty());
    }

    #[test]
    fn a_circle_of_modules_is_found() {
        let sources = |b: &str| {
            [
                (
                    "crates/x/src/lib.rs",
                    "pub mod a;\nmod b;\nmod c;\npub use b::{B, Other};",
                ),
                ("crates/x/src/a/mod.rs", "use crate::{c::{C, D}, Other};"),
                ("crates/x/src/b.rs", b),
                ("crates/x/src/c.rs", "fn c() {}"),
            ]
            .map(|(path, text)| Source::of(path, text))
        };
        assert_eq!(circle_in(&sources("use crate::c;"), "crates/x/src/"), None);
        let circle = circle_in(&sources("fn b() { crate::a::f() }"), "crates/x/src/");
        assert_eq!(circle, Some(vec!["a".to_owned(), "b".to_owned()]));
        let in_tests = "#[cfg(test)]\nmod tests { use crate::a; }";
        assert_eq!(circle_in(&sources(in_tests), "crates/x/src/"), None);
    }
}
