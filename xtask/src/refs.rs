//! Every citation has an entry in a bibliography.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::Failure;
use crate::rust_source::{doc_comments, files_below};

/// The bibliographies.
const BIBLIOGRAPHIES: [&str; 2] = ["docs/references.bib", "crates/glass/data/literature.bib"];

/// Folders whose Rust doc comments cite.
const RUST: [&str; 3] = ["crates", "apps", "validation"];

/// The folder whose pages cite.
const PAGES: &str = "docs/theory";

/// The folder whose data files name their sources.
const DATA: &str = "crates/glass/data";

/// `cargo xtask refs`
///
/// # Errors
/// If a citation has no entry. An entry without a citation is only a warning.
pub fn run(root: &Path) -> Result<(), Failure> {
    let mut keys = BTreeMap::new();
    for bibliography in BIBLIOGRAPHIES {
        match fs::read_to_string(root.join(bibliography)) {
            Ok(text) => keys.extend(bib_keys(&text).map(|key| (key.to_owned(), bibliography))),
            Err(cause) => println!("refs: warning: {bibliography}: {cause}"),
        }
    }
    let mut findings = Vec::new();
    let mut cited = BTreeSet::new();
    for (place, tag) in citations(root)? {
        if !keys.contains_key(&tag) {
            findings.push(format!(
                "{place}: [{tag}] is in none of {}",
                BIBLIOGRAPHIES.join(", ")
            ));
        }
        cited.insert(tag);
    }
    let data = read_all(root, DATA, "json")?;
    for (key, bibliography) in &keys {
        let is_named_in_data = data.iter().any(|(_, text)| text.contains(key.as_str()));
        if !cited.contains(key) && !is_named_in_data {
            println!("refs: warning: {bibliography}: nothing cites {key}");
        }
    }
    Failure::from_findings(&findings, "citations have no entry")?;
    println!("refs: {} works are cited, all are listed", cited.len());
    Ok(())
}

/// All citations with `file:line`.
fn citations(root: &Path) -> Result<Vec<(String, String)>, Failure> {
    let mut all = Vec::new();
    let mut add = |file: &str, line: usize, text: &str| {
        all.extend(tags(text).map(|tag| (format!("{file}:{line}"), tag.to_owned())));
    };
    for folder in RUST {
        for (file, text) in read_all(root, folder, "rs")? {
            for (line, comment) in doc_comments(&text) {
                add(&file, line, comment);
            }
        }
    }
    for (file, text) in read_all(root, PAGES, "md")? {
        for (line, text) in (1..).zip(text.lines()) {
            add(&file, line, text);
        }
    }
    Ok(all)
}

/// Names (relative to the root) and texts of all files with an extension.
fn read_all(root: &Path, folder: &str, ext: &str) -> Result<Vec<(String, String)>, Failure> {
    files_below(root, folder, ext)?
        .into_iter()
        .map(|file| {
            let path = root.join(&file);
            let text =
                fs::read_to_string(&path).map_err(|cause| Failure::of_file(&path, &cause))?;
            Ok((file, text))
        })
        .collect()
}

/// Keys of the entries of a bibliography: the word after `@kind{`.
fn bib_keys(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let (kind, rest) = line.trim_start().strip_prefix('@')?.split_once('{')?;
        let is_entry =
            !["comment", "string", "preamble"].contains(&kind.trim().to_ascii_lowercase().as_str());
        let key = rest.split(',').next()?.trim();
        (is_entry && !key.is_empty()).then_some(key)
    })
}

/// Citation tags of a line: `[AuthorYear]`, `[AuthorYear, eq. 3]`, `[AuthorYear; OtherYear]`,
/// each also as `\[…\]`. The bracket may close on a later line. A link to a page is none, nor is the
/// target of one, `[name]: …` at the start of a line.
fn tags(line: &str) -> impl Iterator<Item = &str> {
    let is_first = line.trim_start().starts_with('[');
    line.split('[')
        .skip(1)
        .enumerate()
        .flat_map(move |(k, rest)| {
            let (inside, after) = rest.split_once(']').unwrap_or((rest, ""));
            let is_target = is_first && k == 0 && after.starts_with(':');
            let is_link = is_target || after.starts_with('(');
            inside
                .split(';')
                .filter_map(|part| part.split([',', '\\']).next())
                .map(str::trim)
                .filter(move |tag| !is_link && is_tag(tag))
        })
}

/// A name that starts with a capital, four digits, and perhaps a letter.
fn is_tag(text: &str) -> bool {
    let text = text
        .strip_suffix(|c: char| c.is_ascii_lowercase())
        .unwrap_or(text);
    let name = text.trim_end_matches(|c: char| c.is_ascii_digit());
    text.len() - name.len() == 4
        && name.len() >= 2
        && name.starts_with(|c: char| c.is_ascii_uppercase())
        && name.chars().all(|c| c.is_ascii_alphabetic() || c == '-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_of_a_line() {
        let check = |line: &str, expected: &[&str]| {
            assert_eq!(tags(line).collect::<Vec<_>>(), expected, "{line}");
        };
        check("predicates [Shewchuk1997], exact", &["Shewchuk1997"]);
        check("energy [Irwin1957, eq. 12].", &["Irwin1957"]);
        check(r"J/m² \[Irwin1957\].", &["Irwin1957"]);
        check(r"\[BoseMorin2004, fig. 2\]", &["BoseMorin2004"]);
        check(
            "[Irwin1957, p. 3; Griffith1921b]",
            &["Irwin1957", "Griffith1921b"],
        );
        check("closes on the next line [Irwin1957, eqs. 3", &["Irwin1957"]);
        check("a range [0, 1], a list [Foo, 2004], [A]", &[]);
        check("an item [`Seed2000`], [Seed]", &[]);
        check("a link [Irwin1957](https://example.org)", &[]);
        check("[Irwin1957]: https://example.org", &[]);
        check("as there [Irwin1957]: the rate", &["Irwin1957"]);
        check(r"\[Irwin1957\]: the rate", &["Irwin1957"]);
        check("no tag [irwin1957], [Irwin57], [Irwin19577]", &[]);
    }

    #[test]
    fn keys_of_a_bibliography() {
        let text = "@article{Irwin1957,\n title={a}\n}\n@comment{x,}\n @book{ Lawn1993 ,\n}\n";
        assert_eq!(
            bib_keys(text).collect::<Vec<_>>(),
            ["Irwin1957", "Lawn1993"],
            "entries only"
        );
    }
}
