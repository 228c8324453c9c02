//! The project's test command.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;

use crate::Failure;
use crate::command::{cargo, line_of, run as run_command};
use crate::metadata::Metadata;
use crate::web::prepare as prepare_web;

mod browser;
mod debian;
mod processors;
mod python;
mod report;
mod tools;
mod web;

pub(crate) use processors::standard_library;
pub(crate) use python::install as install_wheel;
pub(crate) use tools::environment;

use report::Report;
use tools::Tools;

/// What cargo runs.
const ALL_TESTS: [&str; 3] = ["test", "--workspace", "--locked"];

/// `cargo xtask test`: the tools of the tests, all tests and doctests with the replay of the fuzz
/// corpus, the golden digests on a processor without AVX, then the tests of the Python package in its wheel, and those of
/// the playground in a browser, whose WebAssembly makes the pixels of the command.
///
/// # Errors
/// If the tools or the wheel cannot be made, or a test fails.
pub fn run(root: &Path) -> Result<(), Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let tools = tools_beside_compiling(root, &target)?;
    let (mut report, tests) = run_tests(root, &tools)?;
    let without_avx = processors::x86_without_avx(root, &target, &mut report);
    let of_python = python::test(root, &tools, &mut report);
    let of_web = web::test(root, &tools, &mut report);
    tell(&report);
    tests.and(without_avx).and(of_python).and(of_web)
}

/// The ffmpeg of the tests.
///
/// # Errors
/// If the tools of the tests cannot be made.
pub(crate) fn ffmpeg(root: &Path) -> Result<PathBuf, Failure> {
    Ok(Tools::prepare(root)?.ffmpeg().to_path_buf())
}

/// The Python of the tests, in which the package is then installed, and the package's wheel.
///
/// # Errors
/// If the tools of the tests or the wheel cannot be made.
pub(crate) fn python_with_package(root: &Path) -> Result<(PathBuf, PathBuf), Failure> {
    let tools = Tools::prepare(root)?;
    let wheel = python::build(root, &tools)?;
    python::install(tools.python(), &wheel)?;
    Ok((tools.python().to_path_buf(), wheel))
}

/// `cargo xtask processors`: the golden digests on a processor without AVX, on WebAssembly, and on aarch64.
///
/// # Errors
/// If they differ there, or do not build.
pub fn run_on_processors(root: &Path) -> Result<(), Failure> {
    let mut report = Report::default();
    let target = Metadata::of_workspace(root)?.target_directory;
    let without_avx = processors::x86_without_avx(root, &target, &mut report);
    let wasm = processors::wasm(root, &mut report);
    let aarch64 = processors::aarch64(root, &target, &mut report);
    tell(&report);
    without_avx.and(wasm).and(aarch64)
}

/// What the tests use is fetched while they are compiled: the one waits for a network, the other for processors.
fn tools_beside_compiling(root: &Path, target: &Path) -> Result<Tools, Failure> {
    let fetch = || {
        let tools = Tools::prepare(root).inspect_err(|failure| println!("== {failure}"))?;
        // What of these cannot be had is said again where it is missed.
        let _ = browser::prepare(target);
        let _ = processors::fetch(target);
        let _ = prepare_web(root);
        Ok(tools)
    };
    thread::scope(|scope| {
        let tools = scope.spawn(fetch);
        let compiled = run_command(processors::all_tests(root));
        let tools = tools
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        tools.and_then(|tools| compiled.map(|()| tools))
    })
}

fn tell(report: &Report) {
    println!();
    for skipped in report.skipped() {
        println!("skipped: {skipped}");
    }
    println!("{report}");
}

/// Runs cargo test, passes on what a reader wants to see, and counts.
fn run_tests(root: &Path, tools: &Tools) -> Result<(Report, Result<(), Failure>), Failure> {
    // --show-output, because tests say on their own output what they skip.
    let args = ["--no-fail-fast", "--", "--show-output"];
    let mut command = cargo(root, &[&ALL_TESTS[..], &args].concat());
    tools.name_to(&mut command);
    let line = line_of(&command);
    println!("== {line}");
    let broken = |cause: std::io::Error| Failure::new(format!("{line}: {cause}"));
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(broken)?;
    let mut report = Report::default();
    if let Some(stdout) = child.stdout.take() {
        for bytes in BufReader::new(stdout).split(b'\n') {
            let bytes = bytes.map_err(broken)?;
            let text = String::from_utf8_lossy(&bytes);
            if report.read(&text) {
                println!("{text}");
            }
        }
    }
    let status = child.wait().map_err(broken)?;
    let result = if status.success() {
        Ok(())
    } else {
        Err(Failure::new(format!("{line}: {status}")))
    };
    Ok((report, result))
}
