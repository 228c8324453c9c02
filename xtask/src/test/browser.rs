//! The browser of the tests: Debian's Chromium, in the target folder where none is installed.

use std::env;
use std::path::{Path, PathBuf};

use super::debian;
use crate::Failure;

/// The folder, in the target folder.
const FOLDER: &str = "test-browser";

/// Starts the browser with what was unpacked beside it; written last.
const STARTER: &str = "chromium";

/// The program, where its package puts it.
const PROGRAM: &str = "usr/lib/chromium/chromium";

/// Where Chromium is for the tests; none where they find one by themselves, or where there is
/// none to be had, which is said: the tests that need it are then skipped and listed.
pub(super) fn prepare(target: &Path) -> Option<PathBuf> {
    if is_found() {
        return None;
    }
    let folder = target.join(FOLDER);
    let starter = folder.join(STARTER);
    if !starter.is_file()
        && let Err(failure) = unpack(&folder, &starter)
    {
        println!("== no chromium: {failure}");
        return None;
    }
    Some(starter)
}

/// Whether the tests find one by themselves.
pub(super) fn is_found() -> bool {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    env::var_os("STARBREAK_TEST_CHROMIUM").is_some() || names.into_iter().any(debian::is_on_path)
}

/// Unpacks the package and what it needs, and writes the starter.
fn unpack(folder: &Path, starter: &Path) -> Result<(), Failure> {
    let root = debian::unpack(&["chromium"], folder)?;
    if !root.join(PROGRAM).is_file() {
        return Err(Failure::new(format!(
            "the package of this system has no {PROGRAM}"
        )));
    }
    let libraries = debian::files_in(&root.join("usr/lib"), "-linux-gnu")?;
    write_starter(starter, &root, &libraries)
}

fn write_starter(starter: &Path, root: &Path, libraries: &[PathBuf]) -> Result<(), Failure> {
    let libraries: Vec<String> = libraries
        .iter()
        .flat_map(|folder| [folder.clone(), folder.join("pulseaudio")])
        .map(|folder| folder.display().to_string())
        .collect();
    let root = root.display();
    let text = format!(
        "#!/bin/sh\n\
         export LD_LIBRARY_PATH='{}' XDG_DATA_HOME='{root}/usr/share'\n\
         [ -e /etc/fonts/fonts.conf ] || export FONTCONFIG_PATH='{root}/etc/fonts'\n\
         exec '{root}/{PROGRAM}' \"$@\"\n",
        libraries.join(":")
    );
    debian::write_program(starter, &text)
}
