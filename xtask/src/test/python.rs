//! The Python package: its wheel, built and installed, and its tests.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::available_parallelism;

use super::report::Report;
use super::tools::{Tools, answer};
use crate::Failure;
use crate::command::run as run_command;
use crate::metadata::Metadata;

/// The folder of the package.
const FOLDER: &str = "apps/python";

/// Where the wheel is put, in the target folder.
const WHEELS: &str = "test-wheels";

/// Processes of tests at most: each takes up to half a gigabyte, and some start others.
const MOST_WORKERS: usize = 4;

/// The feature with which dependencies are those of the tests of the workspace.
const FEATURE: &str = "as-in-workspace";

/// Installs the wheel where the tools are, and runs its tests against the command.
pub(super) fn test(root: &Path, tools: &Tools, report: &mut Report) -> Result<(), Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    install(tools.python(), &build(root, tools)?)?;

    let mut test = Command::new(tools.python());
    let n_workers = available_parallelism().map_or(1, |n| n.get().min(MOST_WORKERS));
    test.args(["-m", "pytest", "--quiet", "-rs", "--dist", "loadgroup"]);
    test.args(["-n", &n_workers.to_string()]);
    test.current_dir(root.join(FOLDER));
    test.env("PYTHONDONTWRITEBYTECODE", "1");
    let name = format!("starbreak{}", std::env::consts::EXE_SUFFIX);
    test.env("STARBREAK_TEST_COMMAND", target.join("debug").join(name));
    run_tests(test, report)
}

/// Builds the wheel beside what the tests of the workspace have built.
pub(super) fn build(root: &Path, tools: &Tools) -> Result<PathBuf, Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let wheels = target.join(WHEELS);
    let _ = fs::remove_dir_all(&wheels);
    let mut build = Command::new(tools.python());
    build.args(["-m", "maturin", "build", "--locked", "--quiet"]);
    build.args(["--profile", "dev", "--features", FEATURE]);
    build.args(["--manifest-path", "apps/python/Cargo.toml", "--out"]);
    build.arg(&wheels).current_dir(root);
    run_command(build)?;
    wheel_in(&wheels)
}

/// Installs a wheel, in place of an earlier one.
pub(crate) fn install(python: &Path, wheel: &Path) -> Result<(), Failure> {
    let mut install = Command::new(python);
    install.args(["-m", "pip", "install", "--quiet", "--no-index", "--no-deps"]);
    install.args(["--disable-pip-version-check", "--force-reinstall"]);
    answer(install.arg(wheel))?;
    Ok(())
}

/// The one wheel in a folder.
fn wheel_in(folder: &Path) -> Result<PathBuf, Failure> {
    let unread = |cause| Failure::of_file(folder, &cause);
    let entries = fs::read_dir(folder).map_err(unread)?;
    let wheel = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|path| path.extension().is_some_and(|ending| ending == "whl"));
    wheel.ok_or_else(|| Failure::new(format!("{}: no wheel was built", folder.display())))
}

/// Runs pytest, passes on what it says, and counts.
fn run_tests(mut test: Command, report: &mut Report) -> Result<(), Failure> {
    println!("\n== python -m pytest {FOLDER}");
    let broken = |cause: std::io::Error| Failure::new(format!("pytest: {cause}"));
    let mut child = test.stdout(Stdio::piped()).spawn().map_err(broken)?;
    if let Some(stdout) = child.stdout.take() {
        for bytes in BufReader::new(stdout).split(b'\n') {
            let bytes = bytes.map_err(broken)?;
            let line = String::from_utf8_lossy(&bytes);
            report.read_pytest(&line);
            println!("{line}");
        }
    }
    let status = child.wait().map_err(broken)?;
    match status.success() {
        true => Ok(()),
        false => Err(Failure::new(format!("pytest {FOLDER}: {status}"))),
    }
}
