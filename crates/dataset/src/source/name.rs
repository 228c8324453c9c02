//! Names inside a dataset: which are safe, which are those of images.

use std::path::{Path, PathBuf};

/// The name without `.` and doubled slashes, if it stays inside the folder it is relative to.
///
/// The same names are refused on every system, so that a dataset is good or bad everywhere.
pub(super) fn checked(text: &str) -> Result<String, String> {
    let refuse = |why: &str| Err(format!("the name {text:?} {why}"));
    if text.is_empty() {
        return refuse("is empty");
    }
    if text.contains('\0') {
        return refuse("holds a NUL character");
    }
    if text.contains('\\') {
        return refuse("holds a backslash; write it with '/'");
    }
    if text.starts_with('/') || has_drive(text) {
        return refuse("is absolute; make it relative to the dataset");
    }
    if text.ends_with('/') {
        return refuse("is that of a folder");
    }
    let mut parts = Vec::new();
    for part in text.split('/') {
        match part {
            "" | "." => {}
            ".." => return refuse("leads out with '..'; make it relative to the dataset"),
            part => parts.push(part),
        }
    }
    match parts.last() {
        Some(_) if !text.ends_with("/.") => Ok(parts.join("/")),
        _ => refuse("is that of a folder"),
    }
}

/// `C:` and the like, which begin an absolute path on Windows.
fn has_drive(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next().is_some_and(|c| c.is_ascii_alphabetic()) && chars.next() == Some(':')
}

/// The path of a checked name.
pub(super) fn path_below(root: &Path, name: &str) -> PathBuf {
    let mut path = root.to_owned();
    path.extend(name.split('/'));
    path
}

/// Whether the extension is that of PNG or JPEG, in any case.
pub(super) fn is_image_name(name: &str) -> bool {
    split_extension(name).is_some_and(|(_, extension)| {
        ["png", "jpg", "jpeg"]
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    })
}

/// The name before its last dot and the extension after it.
pub(crate) fn split_extension(name: &str) -> Option<(&str, &str)> {
    let (stem, extension) = name.rsplit_once('.')?;
    let has_stem = !stem.is_empty() && !stem.ends_with('/') && !extension.contains('/');
    has_stem.then_some((stem, extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_stay_inside_are_kept() {
        for (text, name) in [
            ("a.png", "a.png"),
            ("./val//a b\n.png", "val/a b\n.png"),
            ("12:30.png", "12:30.png"),
            ("..a/b..png", "..a/b..png"),
            ("été/日.jpg", "été/日.jpg"),
        ] {
            assert_eq!(checked(text), Ok(name.to_owned()), "{text:?}");
        }
    }

    #[test]
    fn names_that_lead_out_are_refused() {
        for text in [
            "",
            ".",
            "..",
            "/",
            "/etc/passwd",
            "a/../../b.png",
            "../b.png",
            "..\\b.png",
            "a\\b.png",
            "C:/b.png",
            "c:b.png",
            "a\0.png",
            "a/",
            "a/.",
            "a/..",
        ] {
            let checked = checked(text);
            assert!(checked.is_err(), "{text:?} gave {checked:?}");
        }
    }

    #[test]
    fn images_are_known_by_extension_in_any_case() {
        for name in ["a.png", "b/c.JPG", "d.e.Jpeg"] {
            assert!(is_image_name(name), "{name}");
        }
        for name in ["png", ".png", "a/.jpg", "a.png/b", "a.txt", "a.png.bak"] {
            assert!(!is_image_name(name), "{name}");
        }
    }
}
