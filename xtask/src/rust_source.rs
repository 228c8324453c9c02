//! Rust files as text: which there are, what is comment and what is code.

use std::fs;
use std::path::Path;

use crate::Failure;

/// Files with an extension below a folder, sorted, relative to the root and with `/`. A folder
/// that does not exist has none; build outputs are passed over.
///
/// # Errors
/// If a folder cannot be read.
pub fn files_below(root: &Path, folder: &str, ext: &str) -> Result<Vec<String>, Failure> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let path = root.join(&folder);
        if !path.is_dir() {
            continue;
        }
        let entries = fs::read_dir(&path).map_err(|cause| Failure::of_file(&path, &cause))?;
        for entry in entries {
            let entry = entry.map_err(|cause| Failure::of_file(&path, &cause))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let file = format!("{folder}/{name}");
            if entry.path().is_dir() {
                if name != "target" && name != "node_modules" {
                    folders.push(file);
                }
            } else if Path::new(&name).extension().is_some_and(|e| e == ext) {
                files.push(file);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Lines of `///` and `//!` comments, with their numbers from 1.
pub fn doc_comments(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines()).filter_map(|(number, line)| {
        let line = line.trim_start();
        let comment = line
            .strip_prefix("///")
            .or_else(|| line.strip_prefix("//!"))?;
        Some((number, comment))
    })
}

/// The code alone: comments, and what stands in strings and characters, become spaces; lines
/// stay where they are.
#[must_use]
pub fn code_only(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let after_name = code.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let len = hidden_len(rest, after_name);
        if len > 0 {
            code.extend(
                rest[..len]
                    .chars()
                    .map(|c| if c == '\n' { '\n' } else { ' ' }),
            );
            rest = &rest[len..];
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    code
}

/// `code` (as [`code_only`] makes it) without the items under `#[cfg(test)]`.
#[must_use]
pub fn without_tests(code: &str) -> String {
    let mut kept = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        kept.push_str(&rest[..at]);
        let item = &rest[at..];
        let len = item_len(item);
        kept.extend(item[..len].chars().filter(|c| *c == '\n'));
        rest = &item[len..];
    }
    kept.push_str(rest);
    kept
}

/// Whether the code names `std::<module>`, also as `std::{…, <module>, …}`.
#[must_use]
pub fn uses_std(code: &str, module: &str) -> bool {
    code.match_indices("std::").any(|(at, _)| {
        let is_whole = !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let path = code[at + "std::".len()..].trim_start();
        is_whole
            && match path.strip_prefix('{') {
                None => starts_with_word(path, module),
                Some(group) => group_names(group, module),
            }
    })
}

/// Whether the code has the word, whole.
#[must_use]
pub fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(at, _)| {
        !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_')
            && starts_with_word(&code[at..], word)
    })
}

fn starts_with_word(text: &str, word: &str) -> bool {
    text.strip_prefix(word)
        .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// Whether a use group, from after its `{`, names the module on its first level.
fn group_names(group: &str, module: &str) -> bool {
    let mut depth = 0_usize;
    let mut is_start = true;
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => return false,
            '}' => depth -= 1,
            ',' if depth == 0 => is_start = true,
            c if c.is_whitespace() => {}
            _ if depth == 0 && is_start => {
                if starts_with_word(&group[at..], module) {
                    return true;
                }
                is_start = false;
            }
            _ => {}
        }
    }
    false
}

/// Length of an item with its attributes: to the end of its braces, or to its semicolon.
fn item_len(item: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in item.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth <= 1 => return at + 1,
            '}' => depth -= 1,
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    item.len()
}

/// Length of the comment, string or character that the text starts with, else 0.
fn hidden_len(text: &str, after_name: bool) -> usize {
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if text.starts_with("/*") {
        return block_comment_len(text);
    }
    if text.starts_with('"') {
        return quoted_len(text, '"').unwrap_or(text.len());
    }
    if let Some(body) = text.strip_prefix('\'') {
        // Otherwise it is a lifetime.
        let is_char = body.starts_with('\\') || body.chars().nth(1) == Some('\'');
        let len = if is_char {
            quoted_len(text, '\'')
        } else {
            None
        };
        return len.unwrap_or(0);
    }
    if after_name {
        return 0;
    }
    let raw = text.trim_start_matches(['b', 'c']);
    if let Some(raw) = raw.strip_prefix('r')
        && text.len() - raw.len() <= 2
    {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        if let Some(body) = raw[hashes..].strip_prefix('"') {
            let end = format!("\"{}", "#".repeat(hashes));
            let start = text.len() - body.len();
            return body
                .find(&end)
                .map_or(text.len(), |at| start + at + end.len());
        }
    }
    0
}

/// Rust's block comments nest.
fn block_comment_len(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        if rest.starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest.starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

fn quoted_len(text: &str, quote: char) -> Option<usize> {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            c if c == quote => return Some(at + c.len_utf8()),
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_strings_are_hidden() {
        let check = |text: &str, expected: &str| {
            let words: Vec<String> = code_only(text)
                .split_whitespace()
                .map(str::to_owned)
                .collect();
            assert_eq!(words.join(" "), expected, "{text}");
        };
        check("a // b\nc", "a c");
        check("a /* b /* c */ d */ e", "a e");
        check(r#"a("b \" c", d)"#, "a( , d)");
        check(r###"a(r#"b " c"#, br"d", b"e")"###, "a( , , b )");
        check(
            r"x('\'', '/', 'a', '\u{e9}') + &'static y",
            "x( , , , ) + &'static y",
        );
        check("fn f<'a>(x: &'a str)", "fn f<'a>(x: &'a str)");
        check("var\"s\" r#type", "var r#type");
        assert_eq!(
            code_only("/* a\nb */\nc").lines().count(),
            3,
            "lines stay where they are"
        );
    }

    #[test]
    fn tests_are_left_out() {
        let code = "use a;\n#[cfg(test)]\nmod tests {\n  fn f() { x }\n}\nfn g() {}\n\
                    #[cfg(test)]\nmod more;\nfn h() {}";
        let kept = without_tests(code);
        assert!(
            !kept.contains("tests") && !kept.contains("more"),
            "without: {kept}"
        );
        assert!(
            kept.contains("fn g") && kept.contains("fn h"),
            "with: {kept}"
        );
        assert_eq!(kept.lines().count(), code.lines().count(), "lines stay");
    }

    #[test]
    fn std_modules_are_found_in_paths_and_groups() {
        let check = |code: &str, expected: bool| {
            assert_eq!(uses_std(code, "fs"), expected, "{code}");
        };
        check("use std::fs;", true);
        check("std::fs::read(x)", true);
        check("use std::{io, fs::{self, File}};", true);
        check("use std::{io::{self, Read},\n    fs};", true);
        check("use std::io::{self, fs};", false);
        check("use std::{io::{fs}};", false);
        check("use std::fsx; mystd::fs", false);
        assert!(has_word("let x: Instant;", "Instant"), "whole");
        assert!(!has_word("let x: Instantly;", "Instant"), "a part");
    }
}
