//! The pictures of presets and damage classes in the documentation.

use std::path::Path;

use crate::Failure;
use crate::command::{cargo, run as run_command};

/// Where they are written.
const FOLDER: &str = "docs/figures/gallery";

/// `cargo xtask gallery`: runs the example `gallery` of the crate `starbreak`.
///
/// # Errors
/// If it cannot be built, or fails.
pub fn run(root: &Path) -> Result<(), Failure> {
    let build = ["run", "--release", "--locked", "--package", "starbreak"];
    let what = ["--example", "gallery", "--", FOLDER];
    run_command(cargo(root, &[&build[..], &what].concat()))
}
