//! What tests use that we did not write: a Python with packages, the ffmpeg in one of them, and a
//! browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::browser;
use crate::Failure;
use crate::metadata::Metadata;

/// The packages, with their versions.
const REQUIREMENTS: &str = "xtask/test-requirements.txt";

/// Python that prints the library in the package onnxruntime, or nothing.
const LIBRARY_OF_ONNX_RUNTIME: &str =
    include_str!("../../../apps/cli/src/args/library_of_onnxruntime.py");

/// Copy of the requirements that the environment was made for, written last.
const MADE_FOR: &str = "made-for.txt";

/// Programs that tests ask for by these variables of the environment.
#[derive(Debug)]
pub(super) struct Tools {
    python: PathBuf,
    ffmpeg: PathBuf,
    /// The library of ONNX Runtime; its package has none for old Pythons.
    onnx_runtime: Option<PathBuf>,
    target: PathBuf,
}

impl Tools {
    /// The tools, made in the target folder if they are not there for these requirements.
    ///
    /// # Errors
    /// If there is no Python with venv, or PyPI does not give the packages: tests that need them
    /// would else pass without having run.
    pub(super) fn prepare(root: &Path) -> Result<Self, Failure> {
        let target = Metadata::of_workspace(root)?.target_directory;
        let python = environment(root, REQUIREMENTS, &target.join("test-venv"))?;
        let mut ask = Command::new(&python);
        ask.args([
            "-c",
            "import imageio_ffmpeg; print(imageio_ffmpeg.get_ffmpeg_exe())",
        ]);
        // It would name another ffmpeg.
        let said = answer(ask.env_remove("IMAGEIO_FFMPEG_EXE"))?;
        let mut ask = Command::new(&python);
        let library = answer(ask.args(["-c", LIBRARY_OF_ONNX_RUNTIME]))?;
        let library = library.trim();
        Ok(Self {
            python,
            ffmpeg: PathBuf::from(said.trim()),
            onnx_runtime: (!library.is_empty()).then(|| PathBuf::from(library)),
            target,
        })
    }

    /// The Python that has the packages.
    pub(super) fn python(&self) -> &Path {
        &self.python
    }

    /// The ffmpeg of the tests.
    pub(super) fn ffmpeg(&self) -> &Path {
        &self.ffmpeg
    }

    /// Whether there is a browser.
    pub(super) fn has_chromium(&self) -> bool {
        browser::is_found() || browser::prepare(&self.target).is_some()
    }

    /// Names the tools to a command.
    pub(super) fn name_to(&self, command: &mut Command) {
        command.env("STARBREAK_TEST_PYTHON", &self.python);
        command.env("STARBREAK_TEST_FFMPEG", &self.ffmpeg);
        if let Some(library) = &self.onnx_runtime {
            command.env("STARBREAK_TEST_ONNXRUNTIME", library);
        }
        if let Some(chromium) = browser::prepare(&self.target) {
            command.env("STARBREAK_TEST_CHROMIUM", chromium);
        }
    }
}

/// The Python of a virtual environment with the packages of a file of requirements, made if it is
/// not there for these.
///
/// # Errors
/// If there is no Python with venv, or PyPI does not give the packages.
pub(crate) fn environment(
    root: &Path,
    requirements: &str,
    venv: &Path,
) -> Result<PathBuf, Failure> {
    let file = root.join(requirements);
    let wanted = fs::read_to_string(&file).map_err(|cause| Failure::of_file(&file, &cause))?;
    let made_for = venv.join(MADE_FOR);
    let python = venv.join(if cfg!(windows) {
        "Scripts/python.exe"
    } else {
        "bin/python"
    });
    if fs::read_to_string(&made_for).ok().as_deref() != Some(&wanted) {
        println!("== python3 -m venv {}", venv.display());
        let base = if cfg!(windows) { "python" } else { "python3" };
        let mut make = Command::new(base);
        answer(make.args(["-m", "venv", "--clear"]).arg(venv))?;
        println!("== pip install -r {requirements}");
        let mut install = Command::new(&python);
        install.args(["-m", "pip", "install", "--quiet"]);
        install.args(["--disable-pip-version-check", "--requirement"]);
        answer(install.arg(&file))?;
        fs::write(&made_for, wanted).map_err(|cause| Failure::of_file(&made_for, &cause))?;
    }
    Ok(python)
}

/// What a program prints.
pub(super) fn answer(command: &mut Command) -> Result<String, Failure> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|cause| {
        let way_out = if program.starts_with("python") {
            "; the tests need Python 3.10 or newer with venv: install python3 and python3-venv"
        } else {
            ""
        };
        Failure::new(format!("{program} did not start: {cause}{way_out}"))
    })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(Failure::new(why(&program, &output)))
}

/// Why a program failed, in one line.
fn why(program: &str, output: &Output) -> String {
    let (said, complained) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    let lines: Vec<&str> = said.lines().chain(complained.lines()).collect();
    if lines.iter().any(|line| line.contains("ensurepip")) {
        return format!(
            "{program} has no venv, which the tests need; install the package python3-venv (Debian, Ubuntu), or a \
             Python that is whole"
        );
    }
    let last = lines.iter().rev().find(|line| !line.trim().is_empty());
    format!(
        "the tools of the tests could not be made: {program}: {}",
        last.map_or("it failed", |line| line.trim())
    )
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::ExitStatus;

    use super::*;

    fn failed(stdout: &str, stderr: &str) -> String {
        let output = Output {
            status: ExitStatus::from_raw(256),
            stdout: stdout.into(),
            stderr: stderr.into(),
        };
        why("python3", &output)
    }

    #[test]
    fn a_python_without_venv_is_told_how_to_get_it() {
        let said = failed(
            "The virtual environment was not created successfully because ensurepip is not\navailable.",
            "",
        );
        assert!(said.contains("python3-venv"), "{said}");
    }

    #[test]
    fn the_last_line_says_why() {
        let said = failed("", "Traceback\nERROR: No matching distribution found\n\n");
        assert!(
            said.ends_with("ERROR: No matching distribution found"),
            "{said}"
        );
    }
}
