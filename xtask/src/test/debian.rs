//! Programs out of Debian's packages, in the target folder where they are not installed.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::tools::answer;
use crate::Failure;

pub(super) fn is_on_path(program: &str) -> bool {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Fetches packages with those that they need and that are not installed, and unpacks them into
/// the folder, which is emptied before; nothing is installed, so anyone may. What comes out is the
/// folder that stands for `/`.
///
/// # Errors
/// If there is no Debian, or it does not give them.
pub(super) fn unpack(packages: &[&str], folder: &Path) -> Result<PathBuf, Failure> {
    if !is_on_path("apt-get") || !is_on_path("dpkg") {
        return Err(Failure::new(
            "there is no apt-get to fetch Debian's packages",
        ));
    }
    let names = packages.join(", ");
    println!("== Debian's {names}, unpacked into {}", folder.display());
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
    let install = [
        "install",
        "--yes",
        "--download-only",
        "--no-install-recommends",
    ];
    apt(&[&install, packages].concat())?;
    for package in files_in(&archives, ".deb")? {
        answer(Command::new("dpkg").arg("-x").arg(package).arg(&root))?;
    }
    let _ = fs::remove_dir_all(&cache);
    let _ = fs::remove_dir_all(&lists);
    Ok(root)
}

pub(super) fn files_in(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder).map_err(|cause| Failure::of_file(folder, &cause))?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    Ok(paths
        .filter(|path| path.to_string_lossy().ends_with(ending))
        .collect())
}

/// Writes a script that can be started, whole or not at all.
pub(super) fn write_program(path: &Path, text: &str) -> Result<(), Failure> {
    let wrong = |cause| Failure::of_file(path, &cause);
    let begun = path.with_extension("begun");
    fs::write(&begun, text).map_err(wrong)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(&begun, fs::Permissions::from_mode(0o755)).map_err(wrong)?;
    }
    fs::rename(&begun, path).map_err(wrong)
}
