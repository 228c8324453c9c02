//! Everything that judges the text of the project without running it.

use std::path::Path;

use crate::command::{cargo, run as run_command};
use crate::deps::{self, Mode};
use crate::{Failure, advisories, licences, links, refs};

/// `cargo xtask lint`: all checks, also after one has failed.
///
/// # Errors
/// If one of them fails.
pub fn run(root: &Path) -> Result<(), Failure> {
    let clippy = ["--all-targets", "--locked", "--keep-going"];
    let deny = ["--", "-D", "warnings"];
    let with = |head: &[&str], tail: &[&str]| cargo(root, &[head, tail].concat());
    let mut rustdoc = with(
        &["doc", "--workspace", "--no-deps"],
        &["--locked", "--keep-going"],
    );
    rustdoc.env("RUSTDOCFLAGS", "-D warnings");
    let fuzz_fmt = with(
        &["fmt", "--manifest-path", "fuzz/libfuzzer/Cargo.toml"],
        &["--check"],
    );
    // Fails where the lock file of that workspace is not that of its crates.
    let fuzz_lock = with(
        &["tree", "--manifest-path", "fuzz/libfuzzer/Cargo.toml"],
        &["--locked", "--depth", "0"],
    );
    let results = [
        run_command(with(&["fmt", "--all"], &["--check"])),
        run_command(fuzz_fmt),
        run_command(fuzz_lock),
        run_command(with(
            &["clippy", "--workspace"],
            &[&clippy[..], &deny].concat(),
        )),
        run_command(rustdoc),
        section("licences", licences::run(root)),
        section("advisories", advisories::run(root)),
        section("deps --check", deps::run(root, Mode::Check)),
        section("refs", refs::run(root)),
        section("links", links::run(root)),
    ];
    let failures: Vec<String> = results
        .into_iter()
        .filter_map(Result::err)
        .map(|failure| failure.to_string())
        .collect();
    println!();
    Failure::from_findings(&failures, "checks failed")?;
    println!("lint: all checks passed");
    Ok(())
}

fn section(task: &str, result: Result<(), Failure>) -> Result<(), Failure> {
    result.map_err(|failure| Failure::new(format!("{task}: {failure}")))
}
