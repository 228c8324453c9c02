//! Every link of a page leads to a file of the project, and to a heading that it has.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::Failure;
use crate::rust_source::files_below;

/// Where pages are, besides the root.
const FOLDERS: [&str; 4] = ["docs", "apps", "crates", "validation"];

/// `cargo xtask links`
///
/// # Errors
/// If a relative link leads nowhere.
pub fn run(root: &Path) -> Result<(), Failure> {
    let mut findings = Vec::new();
    let mut n_links = 0;
    let pages = pages(root)?;
    for page in &pages {
        let text = read(&root.join(page))?;
        for (line, target) in links(&text) {
            n_links += 1;
            if let Err(why) = check(root, page, target)? {
                findings.push(format!("{page}:{line}: {target}: {why}"));
            }
        }
    }
    Failure::from_findings(&findings, "links lead nowhere")?;
    println!(
        "links: {n_links} links of {} pages lead somewhere",
        pages.len()
    );
    Ok(())
}

/// The pages, relative to the root.
fn pages(root: &Path) -> Result<Vec<String>, Failure> {
    let mut all = Vec::new();
    for folder in FOLDERS {
        all.extend(files_below(root, folder, "md")?);
    }
    let unread = |cause| Failure::of_file(root, &cause);
    for entry in fs::read_dir(root).map_err(unread)? {
        let name = entry.map_err(unread)?.file_name();
        let name = name.to_string_lossy();
        if name.ends_with(".md") {
            all.push(name.into_owned());
        }
    }
    all.sort();
    Ok(all)
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|cause| Failure::of_file(path, &cause))
}

/// What is wrong with a link of a page, if anything is.
fn check(root: &Path, page: &str, target: &str) -> Result<Result<(), &'static str>, Failure> {
    let (file, heading) = target.split_once('#').unwrap_or((target, ""));
    let page = Path::new(page);
    let linked = match file {
        "" => Some(page.to_path_buf()),
        file => plain(&page.parent().unwrap_or(Path::new("")).join(file)),
    };
    let Some(linked) = linked.map(|linked| root.join(linked)) else {
        return Ok(Err("it leads out of the project"));
    };
    if !linked.exists() {
        return Ok(Err("there is no such file"));
    }
    if heading.is_empty() || linked.extension().is_none_or(|ending| ending != "md") {
        return Ok(Ok(()));
    }
    let text = read(&linked)?;
    let has_it = headings(&text).any(|known| known == heading);
    Ok(if has_it {
        Ok(())
    } else {
        Err("the page has no such heading")
    })
}

/// A path without `..`, if it stays inside.
pub(crate) fn plain(path: &Path) -> Option<PathBuf> {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                if !plain.pop() {
                    return None;
                }
            }
            Component::CurDir => {}
            other => plain.push(other),
        }
    }
    Some(plain)
}

/// Lines outside of code blocks, with their numbers.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_code = false;
    (1..).zip(text.lines()).filter(move |(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Targets of the relative links and pictures of a page, with their lines.
pub(crate) fn links(text: &str) -> impl Iterator<Item = (usize, &str)> {
    prose(text).flat_map(|(number, line)| {
        let targets = line.split("](").skip(1);
        targets.filter_map(move |rest| {
            let target = rest.split([')', ' ']).next()?;
            let is_ours = !target.contains("://") && !target.starts_with("mailto:");
            is_ours.then_some((number, target))
        })
    })
}

/// The anchors that GitHub makes of the headings of a page.
fn headings(text: &str) -> impl Iterator<Item = String> {
    prose(text).filter_map(|(_, line)| {
        let heading = line.strip_prefix('#')?.trim_start_matches('#');
        let heading = heading.strip_prefix(' ')?.trim().to_lowercase();
        let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
        let kept = heading.chars().filter(kept);
        Some(kept.map(|c| if c == ' ' { '-' } else { c }).collect())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_prose_are_found_and_those_of_code_and_of_others_are_not() {
        let text =
            "a [b](c.md#d), ![e](f/g.png)\n```\n[x](y)\n```\n[z](https://example.org) [h](#i)";
        let found: Vec<_> = links(text).collect();
        assert_eq!(found, [(1, "c.md#d"), (1, "f/g.png"), (5, "#i")]);
    }

    #[test]
    fn a_heading_has_the_anchor_of_github() {
        let text = "# What `--json` prints, and --curves\n## A study\n#no\n";
        let found: Vec<_> = headings(text).collect();
        assert_eq!(found, ["what---json-prints-and---curves", "a-study"]);
    }

    #[test]
    fn a_link_that_leads_nowhere_is_found() {
        let root = crate::root();
        let check = |target| check(root, "docs/python.md", target).ok();
        assert_eq!(check("python-pipelines.md"), Some(Ok(())));
        assert_eq!(check("../README.md#install"), Some(Ok(())));
        assert_eq!(check("no.md"), Some(Err("there is no such file")));
        assert_eq!(
            check("../README.md#no"),
            Some(Err("the page has no such heading"))
        );
        assert_eq!(check("../../x"), Some(Err("it leads out of the project")));
    }
}
