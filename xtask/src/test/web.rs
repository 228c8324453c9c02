//! The playground in a browser.

use std::env;
use std::path::Path;
use std::process::Stdio;

use super::debian;
use super::report::Report;
use super::tools::Tools;
use crate::Failure;
use crate::command::line_of;
use crate::metadata::Metadata;
use crate::web::{build, page_test, prepare};

/// Builds the playground and tries it in Chromium, beside the command that the tests have built. What cannot
/// be had is skipped, and said.
///
/// # Errors
/// If it does not build, or a test fails.
pub(super) fn test(root: &Path, tools: &Tools, report: &mut Report) -> Result<(), Failure> {
    let what = "the playground in a browser";
    if let Some(missing) = ["node", "npm"]
        .into_iter()
        .find(|it| !debian::is_on_path(it))
    {
        report.skip(what, &format!("there is no {missing}"));
        return Ok(());
    }
    if let Err(why) = prepare(root) {
        report.skip(what, &why.to_string());
        return Ok(());
    }
    let site = build(root)?;
    if !tools.has_chromium() {
        report.skip(what, "there is no Chromium");
        return Ok(());
    }
    let target = Metadata::of_workspace(root)?.target_directory;
    let starbreak = target.join(format!("debug/starbreak{}", env::consts::EXE_SUFFIX));
    let mut command = page_test(root, &site, &starbreak);
    tools.name_to(&mut command);
    let line = line_of(&command);
    println!("\n== {line}");
    let broken = |cause| Failure::new(format!("{line}: {cause}"));
    let output = command.stderr(Stdio::inherit()).output().map_err(broken)?;
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        if report.read(line) {
            println!("{line}");
        }
    }
    match output.status.success() {
        true => Ok(()),
        false => Err(Failure::new(format!("{line}: {}", output.status))),
    }
}
