//! The golden digests on processors that this machine may not be.
//!
//! One of x86-64 without AVX, on what the tests have built, and one of aarch64, for which they are
//! built once more, with the compiler of Debian's packages for what is C; that is a job of its own.
//! QEMU emulates both. WebAssembly, for which the chain is built, runs in Node. What cannot be had is
//! skipped, and said.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::ALL_TESTS;
use super::debian;
use super::report::Report;
use super::tools::answer;
use crate::Failure;
use crate::command::{cargo, line_of};

/// The tests whose digests hold everywhere: those of the chain, and those of sets of files.
const TESTS_OF_CHAIN: [&str; 2] = ["golden", "golden_physics"];
const TESTS: [&str; 3] = [TESTS_OF_CHAIN[0], TESTS_OF_CHAIN[1], "golden_sets"];

/// The folder of the emulator and that of the compiler, in the target folder.
const EMULATOR: &str = "test-emulator";
const COMPILER: &str = "test-cross-compiler";

/// The other kind of processor, and what Debian calls it.
const AARCH64: &str = "aarch64-unknown-linux-gnu";
const AARCH64_DEBIAN: &str = "aarch64-linux-gnu";

/// WebAssembly with a system to read files from.
const WASI: &str = "wasm32-wasip1";

/// Runs a program of it in Node.
const WASI_RUNNER: &str = "xtask/src/test/wasi.mjs";

/// Where what is built runs on x86-64 without AVX, too.
const IS_X86_LINUX: bool = cfg!(all(target_os = "linux", target_arch = "x86_64"));

/// Gets what [`x86_without_avx`] runs in.
///
/// # Errors
/// If it cannot be had.
pub(super) fn fetch(target: &Path) -> Result<(), Failure> {
    match IS_X86_LINUX {
        true => emulator(target, "x86_64").map(|_| ()),
        false => Ok(()),
    }
}

/// The golden digests on x86-64 without AVX.
///
/// # Errors
/// If they differ there, or do not build.
pub(super) fn x86_without_avx(
    root: &Path,
    target: &Path,
    report: &mut Report,
) -> Result<(), Failure> {
    let what = "golden digests on x86-64 without AVX";
    if !IS_X86_LINUX {
        report.skip(what, "what was built here is not for it");
        return Ok(());
    }
    match emulator(target, "x86_64") {
        Ok(emulator) => {
            let tests = build(all_tests(root), &TESTS)?;
            run(&tests, report, || {
                let mut command = Command::new(&emulator);
                command.args(["-cpu", "Nehalem"]);
                command
            })
        }
        Err(why) => {
            report.skip(what, &why.to_string());
            Ok(())
        }
    }
}

/// The golden digests on aarch64. From nothing the build takes as long as that of all tests.
///
/// # Errors
/// If they differ there, or do not build.
pub(super) fn aarch64(root: &Path, target: &Path, report: &mut Report) -> Result<(), Failure> {
    let what = "golden digests on aarch64";
    if !IS_X86_LINUX {
        report.skip(what, "it is cross-built on x86-64 Linux alone");
        return Ok(());
    }
    let tools = standard_library(AARCH64)
        .and_then(|()| Ok((emulator(target, "aarch64")?, compiler(target)?)));
    match tools {
        Ok((emulator, compiler)) => {
            let mut command = all_tests(root);
            command.args(["--target", AARCH64]);
            let name = AARCH64.replace('-', "_");
            command.env(format!("CC_{name}"), &compiler);
            let linker = format!("CARGO_TARGET_{}_LINKER", name.to_uppercase());
            command.env(linker, &compiler);
            let tests = build(command, &TESTS)?;
            let libraries = target.join(COMPILER).join("root/usr").join(AARCH64_DEBIAN);
            run(&tests, report, || {
                let mut command = Command::new(&emulator);
                command.arg("-L").arg(&libraries);
                command
            })
        }
        Err(why) => {
            report.skip(what, &why.to_string());
            Ok(())
        }
    }
}

/// The golden digests of networks and pictures on WebAssembly. From nothing the build takes three minutes, so that
/// the tests leave it to the playground's, which compares pixels.
///
/// # Errors
/// If they differ there, or do not build.
pub(super) fn wasm(root: &Path, report: &mut Report) -> Result<(), Failure> {
    let what = "golden digests on WebAssembly";
    if !debian::is_on_path("node") {
        report.skip(what, "there is no node");
        return Ok(());
    }
    if let Err(why) = standard_library(WASI) {
        report.skip(what, &why.to_string());
        return Ok(());
    }
    let mut command = cargo(root, &["test", "--package", "starbreak", "--locked"]);
    command.args(["--no-run", "--target", WASI]);
    let tests = build(command, &TESTS_OF_CHAIN)?;
    run(&tests, report, || {
        let mut command = Command::new("node");
        command.arg("--no-warnings").arg(root.join(WASI_RUNNER));
        command
    })
}

/// QEMU for programs of a kind of processor.
fn emulator(target: &Path, processor: &str) -> Result<PathBuf, Failure> {
    let names = [
        format!("qemu-{processor}"),
        format!("qemu-{processor}-static"),
    ];
    if let Some(name) = names.iter().find(|name| debian::is_on_path(name)) {
        return Ok(PathBuf::from(name));
    }
    let folder = target.join(EMULATOR);
    let program = folder.join("root/usr/bin").join(&names[1]);
    if !program.is_file() {
        // Linked to nothing, so that it runs wherever it lies.
        debian::unpack(&["qemu-user-static"], &folder)?;
    }
    if program.is_file() {
        Ok(program)
    } else {
        Err(Failure::new(format!(
            "the package of this system has no {}",
            names[1]
        )))
    }
}

/// Sees that Rust's own library is there for a target; rustup is asked for it if it is not.
///
/// # Errors
/// If rustup does not have it, or is not there.
pub(crate) fn standard_library(of: &str) -> Result<(), Failure> {
    let mut ask = Command::new("rustc");
    ask.args(["--print", "target-libdir", "--target", of]);
    let folder = answer(&mut ask)?;
    if Path::new(folder.trim()).is_dir() {
        return Ok(());
    }
    println!("== rustup target add {of}");
    answer(Command::new("rustup").args(["target", "add", of]))?;
    Ok(())
}

/// A C compiler for aarch64, which also links.
fn compiler(target: &Path) -> Result<PathBuf, Failure> {
    let folder = target.join(COMPILER);
    let starter = folder.join("cc");
    if !starter.is_file() {
        let c_library = "libc6-dev-arm64-cross";
        let root = debian::unpack(&["gcc-aarch64-linux-gnu", c_library], &folder)?;
        let root = root.display();
        let text = format!(
            "#!/bin/sh\n\
             export LD_LIBRARY_PATH='{root}/usr/lib/x86_64-linux-gnu'\n\
             exec '{root}/usr/bin/{AARCH64_DEBIAN}-gcc' --sysroot='{root}' \"$@\"\n"
        );
        debian::write_program(&starter, &text)?;
    }
    Ok(starter)
}

/// The tests of the workspace as the test command has them, not run.
pub(super) fn all_tests(root: &Path) -> Command {
    cargo(root, &[&ALL_TESTS[..], &["--no-run"]].concat())
}

/// Builds these tests by a command that names none.
fn build(mut command: Command, tests: &[&str]) -> Result<Vec<PathBuf>, Failure> {
    command.args(tests.iter().flat_map(|test| ["--test", test]));
    println!("== {}", line_of(&command));
    command.args(["--message-format", "json-render-diagnostics"]);
    let line = line_of(&command);
    let broken = |cause| Failure::new(format!("{line}: {cause}"));
    let output = command.stderr(Stdio::inherit()).output().map_err(broken)?;
    if !output.status.success() {
        return Err(Failure::new(format!("{line}: {}", output.status)));
    }
    let programs = programs_in(&String::from_utf8_lossy(&output.stdout));
    if programs.len() == tests.len() {
        Ok(programs)
    } else {
        Err(Failure::new(format!(
            "{line}: {} tests, not {}",
            programs.len(),
            tests.len()
        )))
    }
}

/// The programs that cargo says it has built.
fn programs_in(messages: &str) -> Vec<PathBuf> {
    let messages = messages.lines().map(serde_json::from_str::<Value>);
    messages
        .filter_map(|message| Some(PathBuf::from(message.ok()?.get("executable")?.as_str()?)))
        .collect()
}

/// Runs tests, passes on what a reader wants to see, and counts.
fn run(
    tests: &[PathBuf],
    report: &mut Report,
    emulated: impl Fn() -> Command,
) -> Result<(), Failure> {
    let mut result = Ok(());
    for test in tests {
        let mut command = emulated();
        command.arg(test).stdout(Stdio::piped());
        // It warns of features of the processor that it does not emulate, none of which are used.
        command.stderr(Stdio::null());
        println!("\n== {}", line_of(&command));
        let broken = |cause| Failure::new(format!("{}: {cause}", test.display()));
        let mut child = command.spawn().map_err(broken)?;
        if let Some(stdout) = child.stdout.take() {
            for line in BufReader::new(stdout).lines() {
                let line = line.map_err(broken)?;
                if report.read(&line) {
                    println!("{line}");
                }
            }
        }
        let status = child.wait().map_err(broken)?;
        if !status.success() {
            result = Err(Failure::new(format!("{}: {status}", line_of(&command))));
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_found_among_the_messages() {
        let messages = "{\"reason\":\"compiler-artifact\",\"executable\":null}\n\
                        not json\n\
                        {\"reason\":\"compiler-artifact\",\"executable\":\"/t/golden-1\"}\n\
                        {\"reason\":\"build-finished\",\"success\":true}\n";
        assert_eq!(programs_in(messages), [PathBuf::from("/t/golden-1")]);
    }
}
