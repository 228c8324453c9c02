//! Running cargo.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use crate::Failure;

/// `cargo` with these arguments, in the root of the workspace.
#[must_use]
pub fn cargo(root: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or(OsString::from("cargo")));
    command.args(args).current_dir(root);
    // Set by the cargo that runs xtask; they are not meant for the one that it starts.
    for (name, _) in env::vars_os() {
        let is_ours = name.to_str().is_some_and(|name| {
            name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_")
        });
        if is_ours {
            command.env_remove(name);
        }
    }
    command
}

/// Prints what is run, and runs it.
///
/// # Errors
/// If it cannot be started, or fails.
pub fn run(mut command: Command) -> Result<(), Failure> {
    let line = line_of(&command);
    println!("\n== {line}");
    let status = command
        .status()
        .map_err(|cause| Failure::new(format!("{line}: {cause}")))?;
    if status.success() {
        Ok(())
    } else {
        Err(Failure::new(format!("{line}: {status}")))
    }
}

/// The command as one would type it.
#[must_use]
pub fn line_of(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem();
    let mut line = program.unwrap_or_default().to_string_lossy().into_owned();
    for arg in command.get_args() {
        line.push(' ');
        line.push_str(&arg.to_string_lossy());
    }
    line
}
