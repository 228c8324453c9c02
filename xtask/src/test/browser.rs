//! The browser of the tests: Debian's Chromium, in the target folder where none is installed.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::tools::answer;
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
    let is_named = env::var_os("STARBREAK_TEST_CHROMIUM").is_some();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    if is_named || names.into_iter().any(is_on_path) {
        return None;
    }
    let folder = target.join(FOLDER);
    let starter = folder.join(STARTER);
    if !starter.is_file() {
        if !is_on_path("apt-get") || !is_on_path("dpkg") {
            println!("== no chromium, and no apt-get to fetch Debian's");
            return None;
        }
        if let Err(failure) = unpack(&folder, &starter) {
            println!("== no chromium: {failure}");
            return None;
        }
    }
    Some(starter)
}

fn is_on_path(program: &str) -> bool {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Fetches the package with those that it needs and that are not installed, and unpacks them into
/// the folder; nothing is installed, so anyone may.
fn unpack(folder: &Path, starter: &Path) -> Result<(), Failure> {
    println!("== Debian's chromium, unpacked into {}", folder.display());
    let _ = fs::remove_dir_all(folder);
    let [lists, cache, root] = ["lists", "cache", "root"].map(|name| folder.join(name));
    let archives = cache.join("archives");
    let partial = [&lists, &archives].map(|folder| folder.join("partial"));
    for made in partial.iter().chain([&root]) {
        fs::create_dir_all(made).map_err(|cause| Failure::of_file(made, &cause))?;
    }
    let apt = |verb: &[&str]| {
        let mut apt = Command::new("apt-get");
        apt.args(["-qq", "-o", "Debug::NoLocking=1"]);
        apt.args(["-o", "APT::Sandbox::User="]);
        apt.arg("-o")
            .arg(format!("Dir::State::Lists={}", lists.display()));
        apt.arg("-o").arg(format!("Dir::Cache={}", cache.display()));
        answer(apt.args(verb))
    };
    apt(&["update"])?;
    apt(&[
        "install",
        "--yes",
        "--download-only",
        "--no-install-recommends",
        "chromium",
    ])?;
    for package in files_in(&archives, ".deb")? {
        answer(Command::new("dpkg").arg("-x").arg(package).arg(&root))?;
    }
    if !root.join(PROGRAM).is_file() {
        return Err(Failure::new(format!(
            "the package of this system has no {PROGRAM}"
        )));
    }
    let libraries = files_in(&root.join("usr/lib"), "-linux-gnu")?;
    write_starter(starter, &root, &libraries)?;
    let _ = fs::remove_dir_all(&cache);
    let _ = fs::remove_dir_all(&lists);
    Ok(())
}

fn files_in(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder).map_err(|cause| Failure::of_file(folder, &cause))?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    Ok(paths
        .filter(|path| path.to_string_lossy().ends_with(ending))
        .collect())
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
    let wrong = |cause| Failure::of_file(starter, &cause);
    let begun = starter.with_extension("begun");
    fs::write(&begun, text).map_err(wrong)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(&begun, fs::Permissions::from_mode(0o755)).map_err(wrong)?;
    }
    fs::rename(&begun, starter).map_err(wrong)
}
