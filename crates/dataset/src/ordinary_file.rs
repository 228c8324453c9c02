//! Ordinary files, read without waiting for somebody else.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

use crate::error::DatasetError;

/// The bytes of an ordinary file, as [`crate::read_image`] reads them; the messages call it by its path.
///
/// # Errors
///
/// [`DatasetError::Read`], [`DatasetError::NotAFile`] and [`DatasetError::FileTooLong`].
pub fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>, DatasetError> {
    read_file(path, &path.to_string_lossy(), max_bytes)
}

/// The bytes of an ordinary file; one more than `max_bytes` where it grew beyond that.
pub(crate) fn read_file(path: &Path, name: &str, max_bytes: u64) -> Result<Vec<u8>, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let file = open_file(path)?;
    let n_bytes = file.metadata().map_err(read_error)?.len();
    check_file_len(name, n_bytes, max_bytes)?;

    let mut bytes = Vec::new();
    let n_expected = usize::try_from(n_bytes).unwrap_or(usize::MAX);
    bytes
        .try_reserve_exact(n_expected)
        .map_err(|_| read_error(io::ErrorKind::OutOfMemory.into()))?;
    // The file may grow while it is read.
    file.take(max_bytes.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(read_error)?;
    Ok(bytes)
}

/// A file is not longer than its limit.
pub(crate) fn check_file_len(name: &str, n_bytes: u64, max_bytes: u64) -> Result<(), DatasetError> {
    if n_bytes > max_bytes {
        return Err(DatasetError::FileTooLong {
            name: name.to_owned(),
            max_bytes,
        });
    }
    Ok(())
}

/// An ordinary file, open for reading, for those that do not read it at once.
///
/// # Errors
///
/// [`DatasetError::Read`] and [`DatasetError::NotAFile`].
pub fn open_file(path: &Path) -> Result<File, DatasetError> {
    refuse_no_file(path)?;
    File::open(path).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })
}

/// Refuses what is there and no ordinary file, before it is opened: to open a pipe waits for its other end.
pub(crate) fn refuse_no_file(path: &Path) -> Result<(), DatasetError> {
    match fs::metadata(path).ok().as_ref().and_then(not_a_file) {
        None => Ok(()),
        Some(what) => Err(DatasetError::NotAFile {
            path: path.to_owned(),
            what,
        }),
    }
}

/// What the thing is when it is not an ordinary file, with its article.
pub(crate) fn not_a_file(metadata: &fs::Metadata) -> Option<&'static str> {
    let file_type = metadata.file_type();
    if file_type.is_file() {
        return None;
    }
    if file_type.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if file_type.is_fifo() {
            return Some("a pipe");
        }
        if file_type.is_socket() {
            return Some("a socket");
        }
        if file_type.is_char_device() || file_type.is_block_device() {
            return Some("a device");
        }
    }
    Some("not an ordinary file")
}
