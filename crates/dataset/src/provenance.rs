use std::io::Read as _;
use std::path::Path;

use serde_json::Value;
use sha2::{Digest as _, Sha256};

use crate::error::{DatasetError, one_line};
use crate::ordinary_file::open_file;

/// SHA-256 of `bytes`, as 64 lowercase hexadecimal digits.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// SHA-256 of the bytes of a file of any length, as 64 lowercase hexadecimal digits.
///
/// # Errors
///
/// [`DatasetError::Read`] where the file cannot be read, [`DatasetError::NotAFile`] where it is a
/// folder, a pipe or a device.
pub fn sha256_file(path: &Path) -> Result<String, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let mut file = open_file(path)?;
    let mut digest = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer).map_err(read_error)? {
            0 => return Ok(hex(&digest.finalize())),
            n => digest.update(buffer.get(..n).unwrap_or_default()),
        }
    }
}

/// BLAKE3 of `bytes`, as 64 lowercase hexadecimal digits.
///
/// Three times as fast as SHA-256 where the processor has instructions for that, ten times and more
/// where it has none. It is the digest of images, and of all files of a generated set.
#[must_use]
pub fn blake3_hex(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_string()
}

/// BLAKE3 of the bytes of a file of any length, as 64 lowercase hexadecimal digits: what
/// `b3sum` prints.
///
/// # Errors
///
/// As for [`sha256_file`].
pub fn blake3_file(path: &Path) -> Result<String, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let file = open_file(path)?;
    let mut digest = blake3::Hasher::new();
    digest.update_reader(file).map_err(read_error)?;
    Ok(digest.finalize().to_string())
}

/// Bytes as lowercase hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes
        .iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .map(|nibble| char::from(DIGITS[usize::from(nibble)]))
        .collect()
}

/// A record of how a sample came about: a JSON object which this crate stores and does not read.
///
/// The only field it insists on is the text `schema`, such as `starbreak.provenance/2`, by which
/// a reader knows what the others mean.
///
/// # Example
///
/// ```
/// use starbreak_dataset::Provenance;
///
/// # fn main() -> Result<(), starbreak_dataset::DatasetError> {
/// let record = serde_json::json!({ "schema": "starbreak.provenance/2", "seed": 7 });
/// let provenance = Provenance::new(record)?;
/// assert_eq!(Provenance::from_bytes(&provenance.to_bytes())?, provenance);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance(Value);

impl Provenance {
    /// The record made of `value`.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Provenance`] unless it is an object with a non-empty text `schema`.
    pub fn new(value: Value) -> Result<Self, DatasetError> {
        let reason = match value.get("schema") {
            _ if !value.is_object() => "it is not an object",
            None => "\"schema\" is missing",
            Some(Value::String(schema)) if schema.is_empty() => "\"schema\" is empty",
            Some(Value::String(_)) => return Ok(Self(value)),
            Some(_) => "\"schema\" is not a text",
        };
        Err(DatasetError::Provenance {
            reason: reason.to_owned(),
        })
    }

    /// The record in a JSON text.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Provenance`] where the text is not JSON, and as for [`Provenance::new`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DatasetError> {
        let value = serde_json::from_slice(bytes).map_err(|e| DatasetError::Provenance {
            reason: one_line(&e),
        })?;
        Self::new(value)
    }

    /// The name and version of the record's format.
    #[must_use]
    pub fn schema(&self) -> &str {
        self.0.get("schema").and_then(Value::as_str).unwrap_or("")
    }

    /// The whole record.
    #[must_use]
    pub const fn value(&self) -> &Value {
        &self.0
    }

    /// The record as indented JSON in UTF-8 with a line feed at the end.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        // A value always has a JSON form.
        let mut bytes = serde_json::to_vec_pretty(&self.0).unwrap_or_default();
        bytes.push(b'\n');
        bytes
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::expect_used, reason = "a test may panic")]

    use serde_json::json;

    use super::*;

    #[test]
    fn sha256_of_the_standard_examples() {
        // FIPS 180-2, appendix B.1, and the empty text.
        for (text, hex) in [
            (
                "abc",
                "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            ),
            (
                "",
                "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
            ),
        ] {
            assert_eq!(sha256_hex(text.as_bytes()), hex, "{text:?}");
        }
    }

    #[test]
    fn blake3_of_the_test_vectors() {
        // The official ones: bytes 0, 1, …, 250, 0, 1, ….
        for (len, hex) in [
            (
                0_usize,
                "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262",
            ),
            (
                1024,
                "42214739f095a406f3fc83deb889744ac00df831c10daa55189b5d121c855af7",
            ),
            (
                102_400,
                "bc3e3d41a1146b069abffad3c0d44860cf664390afce4d9661f7902e7943e085",
            ),
        ] {
            let bytes: Vec<u8> = (0..=250).cycle().take(len).collect();
            assert_eq!(blake3_hex(&bytes), hex, "{len} bytes");
            let file = tempfile::NamedTempFile::new().expect("a file");
            std::fs::write(file.path(), &bytes).expect("written");
            assert_eq!(
                blake3_file(file.path()).expect("read"),
                hex,
                "a file of {len} bytes"
            );
        }
    }

    #[test]
    fn only_objects_with_a_schema_are_records() {
        for value in [
            json!([1]),
            json!({}),
            json!({ "schema": 1 }),
            json!({ "schema": "" }),
        ] {
            let result = Provenance::new(value.clone());
            assert!(result.is_err(), "{value} was accepted");
        }
        assert!(Provenance::from_bytes(b"{\n").is_err(), "half a record");
    }

    #[test]
    fn text_is_indented_and_ends_with_a_line_feed() {
        let text = Provenance::new(json!({ "schema": "a/1", "seed": 7 })).map(|p| p.to_bytes());
        assert_eq!(
            text.ok().as_deref(),
            Some(&b"{\n  \"schema\": \"a/1\",\n  \"seed\": 7\n}\n"[..]),
            "the exact text"
        );
    }
}
