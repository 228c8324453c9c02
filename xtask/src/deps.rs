//! The dependency graph of our crates, written into ARCHITECTURE.md, so that it cannot lie.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::Failure;
use crate::metadata::{Kind, Metadata, Package};

/// The file that shows the graph.
const FILE: &str = "ARCHITECTURE.md";

/// The line before the graph.
const BEGIN: &str = "<!-- deps:begin -->";

/// The line after the graph.
const END: &str = "<!-- deps:end -->";

/// What is done with the graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// It is written into the file.
    Write,
    /// It is compared with the file.
    Check,
}

/// `cargo xtask deps [--check]`
///
/// # Errors
/// If the file or its markers are missing, or with [`Mode::Check`] if the graph is another.
pub fn run(root: &Path, mode: Mode) -> Result<(), Failure> {
    let path = root.join(FILE);
    let text = fs::read_to_string(&path).map_err(|cause| Failure::of_file(&path, &cause))?;
    let graph = graph(&Metadata::of_workspace(root)?.ours());
    let updated =
        replace_block(&text, &graph).map_err(|why| Failure::new(format!("{FILE}: {why}")))?;
    match mode {
        Mode::Write if updated != text => {
            fs::write(&path, updated).map_err(|cause| Failure::of_file(&path, &cause))?;
            println!("deps: {FILE} is updated");
        }
        Mode::Check if updated != text => {
            return Err(Failure::new(format!(
                "{FILE}: the dependency graph is stale; run `cargo xtask deps`"
            )));
        }
        Mode::Write | Mode::Check => println!("deps: {FILE} is up to date"),
    }
    Ok(())
}

/// The graph as a Mermaid block. A crate that stands alone (xtask) is left out.
fn graph(ours: &[&Package]) -> String {
    let edges: Vec<(&Package, Vec<&str>)> = ours
        .iter()
        .map(|package| (*package, used_by(package, ours)))
        .collect();
    let mut text = String::from(
        "```mermaid\ngraph LR\n%% `cargo xtask deps` writes this; A --> B means that A uses B\n",
    );
    for (package, used) in &edges {
        let name = package.name.as_str();
        if !used.is_empty() || edges.iter().any(|(_, used)| used.contains(&name)) {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {name}[\"{name}<br>{}\"]", package.folder);
        }
    }
    for (package, used) in edges.iter().filter(|(_, used)| !used.is_empty()) {
        let _ = writeln!(text, "  {} --> {}", package.name, used.join(" & "));
    }
    text.push_str("```\n");
    text
}

/// Which of our crates a crate uses, sorted.
fn used_by<'a>(package: &'a Package, ours: &[&Package]) -> Vec<&'a str> {
    let mut used: Vec<&str> = package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind == Kind::Normal)
        .map(|dependency| dependency.name.as_str())
        .filter(|name| ours.iter().any(|other| other.name == *name))
        .collect();
    used.sort_unstable();
    used
}

/// The text with what lies between the markers replaced.
fn replace_block(text: &str, block: &str) -> Result<String, String> {
    let missing = |marker: &str| format!("the marker {marker} is missing; the graph goes there");
    let begin = text.find(BEGIN).ok_or_else(|| missing(BEGIN))? + BEGIN.len();
    let len = text[begin..].find(END).ok_or_else(|| missing(END))?;
    let (before, after) = (&text[..begin], &text[begin + len..]);
    if before.matches(BEGIN).count() + after.matches(BEGIN).count() > 1 {
        return Err(format!("the marker {BEGIN} stands there twice"));
    }
    Ok(format!("{before}\n{block}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metadata::Dependency;

    #[test]
    fn the_block_is_replaced_and_stays() {
        let text = "# A\n<!-- deps:begin -->\nold\n<!-- deps:end -->\nrest\n";
        let once = "# A\n<!-- deps:begin -->\nnew\n<!-- deps:end -->\nrest\n";
        assert_eq!(
            replace_block(text, "new\n").as_deref(),
            Ok(once),
            "only the block"
        );
        assert_eq!(
            replace_block(once, "new\n").as_deref(),
            Ok(once),
            "a second run"
        );
    }

    #[test]
    fn missing_markers_are_named() {
        for (text, expected) in [
            ("# A\n", BEGIN),
            ("<!-- deps:begin -->\n", END),
            ("<!-- deps:end --> <!-- deps:begin -->", END),
            (
                "<!-- deps:begin --><!-- deps:end --><!-- deps:begin -->",
                "twice",
            ),
        ] {
            let result = replace_block(text, "new\n");
            let why = result.err().unwrap_or_default();
            assert!(why.contains(expected), "{text:?}: {why}");
        }
    }

    #[test]
    fn only_our_own_normal_dependencies_are_edges() {
        let package = |name: &str, used: &[(&str, Kind)]| Package {
            name: name.to_owned(),
            folder: format!("crates/{name}"),
            dependencies: used
                .iter()
                .map(|(name, kind)| Dependency {
                    name: (*name).to_owned(),
                    kind: *kind,
                    ..Dependency::default()
                })
                .collect(),
            ..Package::default()
        };
        let a = package(
            "a",
            &[
                ("c", Kind::Normal),
                ("b", Kind::Normal),
                ("serde", Kind::Normal),
            ],
        );
        let b = package("b", &[("c", Kind::Dev)]);
        let c = package("c", &[]);
        let alone = package("alone", &[]);
        let graph = graph(&[&a, &alone, &b, &c]);
        let edges: Vec<&str> = graph
            .lines()
            .filter(|line| line.contains("-->") && !line.contains("%%"))
            .collect();
        assert_eq!(edges, ["  a --> b & c"], "{graph}");
        assert!(!graph.contains("alone"), "nobody uses it: {graph}");
    }
}
