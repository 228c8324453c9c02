//! The documentation site: it is built, its links are followed, and what its pages tell a reader to
//! run is run.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::Failure;
use crate::command::{cargo, run as run_command};
use crate::metadata::Metadata;
use crate::test::{environment, install_wheel, python_with_package};

mod source;

/// The version of mdBook.
const MDBOOK: &str = "0.5.4";

/// What makes the reference of the Python package.
const REQUIREMENTS: &str = "docs/requirements.txt";

/// Where that reference is in the site.
const PYTHON_API: &str = "api/python";

/// `cargo xtask docs`: builds the site, checks its links, and runs the commands of the pages.
///
/// # Errors
/// If it cannot be built, a link leads nowhere, or a command fails.
pub fn run(root: &Path) -> Result<(), Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let site = target.join("docs-site");
    let _ = fs::remove_dir_all(&site);
    let book = target.join("docs-src");
    source::write(root, &book, PYTHON_API)?;
    let mut build = Command::new(mdbook(root, &target)?);
    build.arg("build").arg(&book).arg("--dest-dir").arg(&site);
    run_command(build)?;

    let (python, wheel) = python_with_package(root)?;
    let of_docs = environment(root, REQUIREMENTS, &target.join("docs-venv"))?;
    install_wheel(&of_docs, &wheel)?;
    let api = site.join(PYTHON_API);
    run_script(root, &of_docs, "python_api.py", &[&api])?;
    let links = run_script(root, &python, "check_links.py", &[&site]);

    // All members, as the tests have them, so that both build their packages alike.
    let command = ["build", "--locked", "--workspace", "--bin", "starbreak"];
    run_command(cargo(root, &command))?;
    let name = format!("starbreak{}", env::consts::EXE_SUFFIX);
    let starbreak = target.join("debug").join(name);
    let commands = run_script(root, &python, "run_commands.py", &[&starbreak]);
    println!("the site is {}", site.join("index.html").display());
    links.and(commands)
}

/// Runs a script of the folder docs.
fn run_script(root: &Path, python: &Path, script: &str, args: &[&Path]) -> Result<(), Failure> {
    let mut command = Command::new(python);
    command.arg(Path::new("docs").join(script)).args(args);
    command
        .current_dir(root)
        .env("PYTHONDONTWRITEBYTECODE", "1");
    run_command(command)
}

/// mdBook, installed in the target folder where this version is not on PATH.
fn mdbook(root: &Path, target: &Path) -> Result<PathBuf, Failure> {
    let folder = target.join("test-mdbook");
    let name = format!("mdbook{}", env::consts::EXE_SUFFIX);
    let installed = folder.join("bin").join(name);
    for program in [PathBuf::from("mdbook"), installed.clone()] {
        let said = Command::new(&program).arg("--version").output();
        if said.is_ok_and(|said| is_wanted(&String::from_utf8_lossy(&said.stdout))) {
            return Ok(program);
        }
    }
    let what = ["install", "mdbook", "--locked", "--version", MDBOOK];
    // It need neither serve pages nor watch for changes.
    let features = ["--no-default-features", "--features", "search"];
    let mut install = cargo(root, &[&what[..], &features].concat());
    install.arg("--root").arg(&folder);
    run_command(install)?;
    Ok(installed)
}

/// Whether this is what our version says of itself.
fn is_wanted(said: &str) -> bool {
    said.trim() == format!("mdbook v{MDBOOK}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_version_of_mdbook_is_not_taken() {
        assert!(is_wanted(&format!("mdbook v{MDBOOK}\n")));
        assert!(!is_wanted("mdbook v0.4.52\n"));
        assert!(!is_wanted(""));
    }
}
