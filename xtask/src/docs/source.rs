//! What mdBook reads: the pages that docs/SUMMARY.md lists, in the folders of the repository, and
//! what they link to.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Failure;
use crate::links::{links, plain};

/// The list of pages.
const SUMMARY: &str = "docs/SUMMARY.md";

/// The settings of mdBook.
const SETTINGS: &str = "docs/book.toml";

/// The page after which the reference of the Python package comes, and the page that leads there.
const PYTHON_PAGE: &str = "docs/python.md";
const PYTHON_REFERENCE: &str = "docs/python-reference.md";

/// Writes the book's source into a folder; `python_api` is where in the site the reference of the
/// Python package will be.
///
/// # Errors
/// If a page cannot be read, or links to a page that is not listed.
pub(super) fn write(root: &Path, book: &Path, python_api: &str) -> Result<(), Failure> {
    let _ = fs::remove_dir_all(book);
    let pages_folder = book.join("src");
    let summary = read(&root.join(SUMMARY))?;
    let pages = pages(&summary)?;
    let mut findings = Vec::new();
    let mut linked = BTreeSet::new();
    for page in &pages {
        let text = read(&root.join(page))?;
        for (line, target) in targets(page, &text) {
            let place = format!("{}:{line}", page.display());
            let name = target.display();
            let is_page = target.extension().is_some_and(|ending| ending == "md");
            if !root.join(&target).exists() {
                findings.push(format!("{place}: there is no {name}"));
            } else if !is_page {
                linked.insert(target);
            } else if !pages.contains(&target) {
                findings.push(format!(
                    "{place}: {name} is no page yet; list it in {SUMMARY}"
                ));
            }
        }
        let to = pages_folder.join(as_index(&page.to_string_lossy()));
        put(&to, &indexed(&text))?;
    }
    Failure::from_findings(&findings, "links lead nowhere or out of the site")?;
    for target in &linked {
        copy(root, target, &pages_folder)?;
    }
    put(&book.join("book.toml"), &read(&root.join(SETTINGS))?)?;
    let summary = indexed(&from_root(&summary));
    put(&pages_folder.join("SUMMARY.md"), &summary)?;
    put(&pages_folder.join(PYTHON_REFERENCE), &reference(python_api))
}

/// The listed pages, relative to the root.
fn pages(summary: &str) -> Result<BTreeSet<PathBuf>, Failure> {
    let listed = links(summary).map(|(line, link)| {
        target(Path::new(SUMMARY), link).ok_or_else(|| {
            Failure::new(format!(
                "{SUMMARY}:{line}: {link} leads out of the project; list pages of the project"
            ))
        })
    });
    listed.collect()
}

/// What the links of a page lead to, with their lines.
fn targets(page: &Path, text: &str) -> Vec<(usize, PathBuf)> {
    links(text)
        .filter_map(|(line, link)| Some((line, target(page, link)?)))
        .collect()
}

/// What a link of a page leads to, relative to the root; none for a place on the page itself.
fn target(page: &Path, link: &str) -> Option<PathBuf> {
    let (file, _) = link.split_once('#').unwrap_or((link, ""));
    if file.is_empty() {
        return None;
    }
    plain(&page.parent()?.join(file))
}

/// The list of pages as it reads from the root, with the reference of the Python package.
fn from_root(summary: &str) -> String {
    let mut text = String::new();
    for line in summary.lines() {
        let link = links(line).next().map(|(_, link)| link);
        let page = link.and_then(|link| target(Path::new(SUMMARY), link));
        let (Some(link), Some(page)) = (link, page) else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        let listed = line.replace(&format!("({link})"), &format!("({})", page.display()));
        text.push_str(&listed);
        text.push('\n');
        if page == Path::new(PYTHON_PAGE) {
            let _ = writeln!(text, "  - [Functions and classes]({PYTHON_REFERENCE})");
        }
    }
    text
}

/// The same with links to `README.md` as links to `index.md`: mdBook makes `index.html` of both, but
/// of the links to the first `README.html`.
fn indexed(text: &str) -> String {
    let mut parts = text.split("](");
    let mut indexed = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (link, rest) = part.split_at(part.find(')').unwrap_or(0));
        indexed.push_str("](");
        if link.contains("://") {
            indexed.push_str(link);
        } else {
            indexed.push_str(&as_index(link));
        }
        indexed.push_str(rest);
    }
    indexed
}

/// A path or a link whose page is called `index.md` where it was `README.md`.
fn as_index(link: &str) -> String {
    link.replace("README.md", "index.md")
}

/// The page that leads to the reference, which is not made by mdBook.
fn reference(python_api: &str) -> String {
    format!(
        "# Functions and classes\n\n\
         Made from the docstrings of the package: [`starbreak`](../{python_api}/starbreak.html),\n\
         [`starbreak.carla`](../{python_api}/starbreak/carla.html) and\n\
         [`starbreak.transforms`](../{python_api}/starbreak/transforms.html). The modules for frameworks\n\
         are described under [training pipelines](python-pipelines.md).\n"
    )
}

/// Copies a file; of a folder its files, with a page that lists them.
fn copy(root: &Path, target: &Path, to: &Path) -> Result<(), Failure> {
    let from = root.join(target);
    if !from.is_dir() {
        return put_bytes(&to.join(target), &read_bytes(&from)?);
    }
    let unread = |cause| Failure::of_file(&from, &cause);
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(&from).map_err(unread)? {
        let entry = entry.map_err(unread)?;
        if entry.path().is_file() {
            names.insert(entry.file_name().to_string_lossy().into_owned());
        }
    }
    let mut list = format!(
        "<!doctype html><title>{0}</title><h1>{0}</h1><ul>",
        target.display()
    );
    for name in names.iter().filter(|name| !name.ends_with(".md")) {
        put_bytes(&to.join(target).join(name), &read_bytes(&from.join(name))?)?;
        let _ = write!(list, "<li><a href=\"{name}\">{name}</a>");
    }
    put(&to.join(target).join("index.html"), &list)
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|cause| Failure::of_file(path, &cause))
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|cause| Failure::of_file(path, &cause))
}

fn put(path: &Path, text: &str) -> Result<(), Failure> {
    put_bytes(path, text.as_bytes())
}

fn put_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|cause| Failure::of_file(folder, &cause))?;
    }
    fs::write(path, bytes).map_err(|cause| Failure::of_file(path, &cause))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_of_pages_reads_from_the_root() {
        let summary =
            "# Use\n\n[start](../README.md)\n- [Python](python.md)\n  - [A](decisions/a.md)\n";
        let expected = "# Use\n\n[start](README.md)\n- [Python](docs/python.md)\n  \
                        - [Functions and classes](docs/python-reference.md)\n  - [A](docs/decisions/a.md)\n";
        assert_eq!(from_root(summary), expected);
    }

    #[test]
    fn links_to_a_readme_lead_to_the_index_and_those_of_others_stay() {
        let text = "README.md [a](../README.md#x) [b](https://example.org/README.md) [c](d.md)";
        let expected = "README.md [a](../index.md#x) [b](https://example.org/README.md) [c](d.md)";
        assert_eq!(indexed(text), expected);
    }

    #[test]
    fn a_list_that_leads_out_of_the_project_is_refused() {
        let said = pages("[x](../../x.md)").map_err(|failure| failure.to_string());
        assert!(said.is_err_and(|said| said.starts_with("docs/SUMMARY.md:1: ../../x.md")));
    }

    #[test]
    fn all_pages_of_the_folder_are_listed() -> Result<(), Failure> {
        let root = crate::root();
        let listed = pages(&read(&root.join(SUMMARY))?)?;
        for page in crate::rust_source::files_below(root, "docs", "md")? {
            let is_listed = page == SUMMARY || listed.contains(Path::new(&page));
            assert!(is_listed, "{page} is not in {SUMMARY}");
        }
        Ok(())
    }
}
