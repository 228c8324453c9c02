//! Text files, whole.

use std::path::Path;

use crate::error::DatasetError;
use crate::ordinary_file::{check_file_len, read_file};
use crate::provenance::sha256_hex;

/// The text of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct TextFile {
    /// The text, all bytes of the file.
    pub text: String,
}

impl TextFile {
    /// Its lines, without the marks of UTF-8 that some editors put at the beginning, and that files
    /// which were joined have anywhere.
    #[must_use]
    pub fn unmarked(&self) -> String {
        self.text.replace('\u{feff}', "")
    }

    /// SHA-256 of the bytes of the file, 64 lowercase hexadecimal digits.
    #[must_use]
    pub fn sha256(&self) -> String {
        sha256_hex(self.text.as_bytes())
    }
}

/// The text in the file at `path`, which has `max_bytes` at most.
///
/// Pipes, sockets and devices are refused without opening them.
///
/// # Errors
/// [`DatasetError::Read`], [`DatasetError::NotAFile`], [`DatasetError::FileTooLong`],
/// [`DatasetError::EmptyFile`] and [`DatasetError::NotText`].
pub fn read_text(path: &Path, max_bytes: u64) -> Result<TextFile, DatasetError> {
    let name = path.to_string_lossy();
    let bytes = read_file(path, &name, max_bytes)?;
    let n_bytes = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
    check_file_len(&name, n_bytes, max_bytes)?;
    if bytes.is_empty() {
        return Err(DatasetError::EmptyFile {
            name: name.into_owned(),
        });
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(TextFile { text }),
        Err(error) => Err(DatasetError::NotText {
            name: name.into_owned(),
            at: error.utf8_error().valid_up_to(),
        }),
    }
}
