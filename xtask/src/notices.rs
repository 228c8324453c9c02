//! The licences of what we link, as text: whoever gets a binary must get them, too.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::Failure;
use crate::command::{cargo, line_of};

/// Beginnings of the names of files that hold a licence, in capitals.
const NAMES: [&str; 6] = [
    "LICENSE",
    "LICENCE",
    "COPYING",
    "NOTICE",
    "UNLICENSE",
    "OFL",
];

/// `cargo xtask notices`: on the output, what the command and the Python package contain.
///
/// # Errors
/// If cargo does not say what is linked, or a file cannot be read.
pub fn run(root: &Path) -> Result<(), Failure> {
    print!("{}", notices(root, &["starbreak-cli", "starbreak-python"])?);
    Ok(())
}

/// Each text of a licence after those packages within some of ours that it is of.
///
/// # Errors
/// If cargo does not say what is linked, or a file cannot be read.
pub(crate) fn notices(root: &Path, ours: &[&str]) -> Result<String, Failure> {
    let linked = linked(root, ours)?;
    let metadata: Value = serde_json::from_str(&said(
        root,
        &["metadata", "--format-version", "1", "--locked"],
    )?)
    .map_err(|cause| Failure::new(format!("cargo metadata: {cause}")))?;
    let mut packages_of: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in metadata["packages"].as_array().into_iter().flatten() {
        let text = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
        let name = format!("{} v{}", text("name"), text("version"));
        if package["source"].is_null() || !linked.contains(&name) {
            continue;
        }
        let manifest = PathBuf::from(text("manifest_path"));
        let mut texts = licence_texts(manifest.parent().unwrap_or(&manifest))?;
        if texts.is_empty() {
            texts.push("(The package holds no text of its licence.)".to_owned());
        }
        for licence in texts {
            let user = format!("{name} ({})", text("license"));
            let users = packages_of.entry(licence).or_default();
            if !users.contains(&user) {
                users.push(user);
            }
        }
    }
    let head =
        "starbreak contains these packages. The text of each licence follows its packages.\n";
    let parts = packages_of
        .iter()
        .map(|(licence, packages)| notice(&packages.join("\n"), licence));
    Ok(head.to_owned() + &parts.collect::<String>())
}

/// A licence after what it is of.
pub(crate) fn notice(packages: &str, licence: &str) -> String {
    format!("\n{}\n\n{packages}\n\n{licence}\n", "=".repeat(80))
}

/// The packages within some of ours on any system, as `name vVERSION`.
fn linked(root: &Path, ours: &[&str]) -> Result<BTreeSet<String>, Failure> {
    let tree = ["tree", "--locked", "--edges", "normal", "--target", "all"];
    let ours: Vec<&str> = ours.iter().flat_map(|name| ["--package", name]).collect();
    let form = ["--prefix", "none"];
    let tree = said(root, &[&tree[..], &ours, &form].concat())?;
    Ok(packages_in(&tree))
}

fn packages_in(tree: &str) -> BTreeSet<String> {
    let words = |line: &str| line.split(' ').take(2).collect::<Vec<_>>().join(" ");
    tree.lines().map(words).collect()
}

/// The texts below the folder of a package, where also fonts, tables and C sources in it have theirs;
/// without spaces at the ends of lines, so that equal ones are found to be equal.
fn licence_texts(folder: &Path) -> Result<Vec<String>, Failure> {
    let mut texts = Vec::new();
    let entries = fs::read_dir(folder).map_err(|cause| Failure::of_file(folder, &cause))?;
    let mut paths: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            texts.extend(licence_texts(&path)?);
        } else if is_licence(&path) {
            let bytes = fs::read(&path).map_err(|cause| Failure::of_file(&path, &cause))?;
            let text = String::from_utf8_lossy(&bytes);
            let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
            texts.push(lines.join("\n").trim_matches('\n').to_owned());
        }
    }
    Ok(texts)
}

fn is_licence(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_uppercase();
    !name.ends_with(".RS") && NAMES.iter().any(|start| name.starts_with(start))
}

/// What cargo prints.
fn said(root: &Path, args: &[&str]) -> Result<String, Failure> {
    let mut command = cargo(root, args);
    let line = line_of(&command);
    let output = command
        .output()
        .map_err(|cause| Failure::new(format!("{line}: {cause}")))?;
    if !output.status.success() {
        let complained = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
        return Err(Failure::new(format!("{line}: {}", complained.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_the_first_two_words_of_a_line() {
        let tree = "a v1.0.0\nb v0.2.0 (proc-macro)\na v1.0.0 (*)\n";
        let expected = ["a v1.0.0", "b v0.2.0"].map(str::to_owned);
        assert_eq!(packages_in(tree), BTreeSet::from(expected), "{tree}");
    }

    #[test]
    fn licences_are_known_by_their_names() {
        for (name, expected) in [
            ("LICENSE-MIT", true),
            ("license.md", true),
            ("NOTICE", true),
            ("Cargo.toml", false),
            ("license.rs", false),
        ] {
            assert_eq!(is_licence(Path::new(name)), expected, "{name}");
        }
    }
}
