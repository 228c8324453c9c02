//! A folder of images as a clip.

use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

use super::VideoError;
use crate::known_folders::is_temporary;
use crate::{DatasetError, image_size};

/// The PNG and JPEG files of a folder by their names, in the order of their names, in which a
/// run of digits counts as a number: `f2.png` comes before `f10.png`.
///
/// Subfolders, hidden files and files of other extensions are left alone.
///
/// # Errors
/// [`DatasetError::Read`] where the folder cannot be read, [`VideoError::NoFrames`] where there is
/// none.
pub fn frame_files(folder: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: folder.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(read_error)? {
        let path = entry.map_err(read_error)?.path();
        let extension = path
            .extension()
            .map(|own| own.to_string_lossy().to_lowercase());
        let is_image = matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg"));
        let is_hidden = path
            .file_name()
            .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if is_image && !is_hidden && path.is_file() {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(DatasetError::Video(VideoError::NoFrames {
            path: folder.to_owned(),
        }));
    }
    let name = |path: &Path| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    files.sort_by(|a, b| {
        let (a_name, b_name) = (name(a).unwrap_or_default(), name(b).unwrap_or_default());
        by_number(&a_name, &b_name).then_with(|| a.cmp(b))
    });
    Ok(files)
}

/// Refuses frames of several sizes, by their headers alone. One whose header cannot be read is left to
/// whoever reads its pixels.
///
/// # Errors
/// [`VideoError::FileSize`] with the first frame of another size than those before it.
pub fn check_frame_sizes(files: &[PathBuf]) -> Result<(), DatasetError> {
    let mut sized = files
        .iter()
        .filter_map(|path| Some((path, image_size(path).ok()?)));
    let Some((first, first_size)) = sized.next() else {
        return Ok(());
    };
    match sized.find(|(_, size)| *size != first_size) {
        None => Ok(()),
        Some((path, (width_px, height_px))) => Err(DatasetError::Video(VideoError::FileSize {
            path: path.clone(),
            width_px,
            height_px,
            first: first.clone(),
            first_width_px: first_size.0,
            first_height_px: first_size.1,
        })),
    }
}

/// Whether there is a folder.
#[must_use]
pub fn is_folder(path: &Path) -> bool {
    path.is_dir()
}

/// Whether there is a folder with anything in it but what runs that were killed have left
/// (`.starbreak-*`); one that cannot be read has nothing.
#[must_use]
pub fn holds_anything(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|entries| {
        entries
            .filter_map(Result::ok)
            .any(|entry| !is_temporary(&entry.path()))
    })
}

/// The order of names in which a run of digits counts as a number.
fn by_number(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let (Some(first_a), Some(first_b)) = (a.first(), b.first()) else {
            return a.len().cmp(&b.len());
        };
        if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (digits_a, rest_a) = digits(a);
            let (digits_b, rest_b) = digits(b);
            let order = digits_a
                .len()
                .cmp(&digits_b.len())
                .then(digits_a.cmp(digits_b));
            if order != Ordering::Equal {
                return order;
            }
            (a, b) = (rest_a, rest_b);
        } else if first_a != first_b {
            return first_a.cmp(first_b);
        } else {
            (a, b) = (
                a.get(1..).unwrap_or_default(),
                b.get(1..).unwrap_or_default(),
            );
        }
    }
}

/// The digits at the start without leading zeros, and what follows them.
fn digits(text: &[u8]) -> (&[u8], &[u8]) {
    let n = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (digits, rest) = text.split_at(n);
    let n_zeros = digits.iter().take_while(|byte| **byte == b'0').count();
    (digits.get(n_zeros..).unwrap_or_default(), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = [
            "f10.png", "f2.png", "f02b.png", "f.png", "e9.png", "f2a.png", "0003.png", "12.png",
        ];
        names.sort_by(|a, b| by_number(a, b));
        let expected = [
            "0003.png", "12.png", "e9.png", "f.png", "f2.png", "f2a.png", "f02b.png", "f10.png",
        ];
        assert_eq!(names, expected, "sorted");
    }
}
