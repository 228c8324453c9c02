//! The playground: the modules in Rust and the page around them, as files for any web server.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Failure;
use crate::command::{cargo, run as run_command};
use crate::metadata::Metadata;
use crate::notices::{notice, notices};
use crate::test::standard_library;

/// What browsers run.
const TARGET: &str = "wasm32-unknown-unknown";

/// What breaks glass, and detectors for those who bring a model.
const MODULES: [&str; 2] = ["starbreak-web", "starbreak-web-detector"];

/// The page's own folder.
const PAGE: &str = "apps/web/page";

/// `cargo xtask web [--serve]`: builds the playground, and serves it on this machine alone.
///
/// # Errors
/// If it cannot be built or served.
pub fn run(root: &Path, serves: bool) -> Result<(), Failure> {
    prepare(root)?;
    let site = build(root)?;
    println!("the playground is {}", site.join("index.html").display());
    if serves {
        let mut serve = Command::new("node");
        serve.arg(root.join(PAGE).join("test/serve.mjs")).arg(&site);
        run_command(serve)?;
    }
    Ok(())
}

/// What it is built with: Rust's library for browsers, and the packages of the page.
///
/// # Errors
/// If they cannot be had.
pub(crate) fn prepare(root: &Path) -> Result<(), Failure> {
    standard_library(TARGET)?;
    install(&root.join(PAGE))
}

/// Builds it with what [`prepare`] got; gives the folder of the site.
///
/// # Errors
/// If it does not build.
pub(crate) fn build(root: &Path) -> Result<PathBuf, Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let what = ["build", "--locked", "--profile", "web", "--target", TARGET];
    let packages = MODULES.map(|name| ["--package", name]).concat();
    let mut command = cargo(root, &[&what[..], &packages].concat());
    command.env(
        "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS",
        "-C target-feature=+simd128",
    );
    run_command(command)?;
    let page = root.join(PAGE);
    // Not `web`, where cargo keeps what builds this profile.
    let site = target.join("playground");
    let modules = target.join(TARGET).join("web");
    let mut npm = npm(&page);
    npm.args(["run", "build", "--", "--emptyOutDir", "--outDir"]);
    npm.arg(&site).env("STARBREAK_WASM", &modules);
    run_command(npm)?;
    // Whoever gets the site gets what it is made of.
    let preact = page.join("node_modules/preact/LICENSE");
    let licence = fs::read_to_string(&preact).map_err(|cause| Failure::of_file(&preact, &cause))?;
    let text = notices(root, &MODULES)? + &notice("preact", licence.trim_end());
    let file = site.join("LICENSE-THIRD-PARTY.txt");
    fs::write(&file, text).map_err(|cause| Failure::of_file(&file, &cause))?;
    Ok(site)
}

/// The packages of the lock file, where they are not there yet.
fn install(page: &Path) -> Result<(), Failure> {
    let lock = page.join("package-lock.json");
    let wanted = fs::read(&lock).map_err(|cause| Failure::of_file(&lock, &cause))?;
    let installed = page.join("node_modules/.installed-lock.json");
    if fs::read(&installed).is_ok_and(|bytes| bytes == wanted) {
        return Ok(());
    }
    let mut command = npm(page);
    command.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"]);
    run_command(command)?;
    fs::write(&installed, wanted).map_err(|cause| Failure::of_file(&installed, &cause))
}

fn npm(page: &Path) -> Command {
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.current_dir(page);
    command
}

/// The test of the page in a browser.
pub(crate) fn page_test(root: &Path, site: &Path, starbreak: &Path) -> Command {
    let mut command = Command::new("node");
    command.arg(root.join(PAGE).join("test/playground.mjs"));
    command.arg(site).arg(starbreak);
    command
}
