//! One record, and where it goes wrong.

use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::DatasetError;

/// One value of a file: an element of a list, or a member that is no list.
#[derive(Debug, Clone, Copy)]
pub struct JsonRecord<'a> {
    /// The key of the list or member; empty where the file is one list.
    pub key: &'a str,
    /// Its place in the list, from 0; nothing of a member that is no list.
    pub idx: Option<u64>,
    /// Place of its first byte in the file, from 0.
    pub offset: u64,
    /// Its very characters. Brackets and quotes are balanced; nothing else is known of them.
    pub text: &'a str,
}

/// Why a record is not what it should be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordFault {
    /// Place of the byte in the file, from 0.
    pub at_byte: u64,
    /// What is wrong there.
    pub reason: String,
    /// Whether it is JSON, and only says something else than it should.
    pub is_json: bool,
}

impl<'a> JsonRecord<'a> {
    /// The record as a value.
    ///
    /// # Errors
    /// Where it is no JSON, or not that of such a value.
    pub fn parse<T: Deserialize<'a>>(&self) -> Result<T, RecordFault> {
        serde_json::from_str(self.text).map_err(|error| {
            let behind = offset_in(self.text, error.line(), error.column()).saturating_sub(1);
            let at = self.text.as_bytes().get(behind);
            let reason = match reason_of(&error).as_str() {
                "expected value" | "invalid number" if matches!(at, Some(b'N' | b'I')) => {
                    "NaN and Infinity are no numbers of JSON; leave such records out".to_owned()
                }
                reason => reason.to_owned(),
            };
            RecordFault {
                at_byte: self.offset + u64::try_from(behind).unwrap_or(0),
                reason,
                is_json: error.is_data(),
            }
        })
    }

    /// The record as a value, or why it is none; what is no JSON is a fault of the whole file.
    pub(crate) fn row<T: Deserialize<'a>>(
        &self,
        path: &Path,
    ) -> Result<Result<T, String>, DatasetError> {
        match self.parse() {
            Ok(row) => Ok(Ok(row)),
            Err(fault) if fault.is_json => Ok(Err(fault.reason)),
            Err(RecordFault {
                at_byte, reason, ..
            }) => Err(DatasetError::JsonText {
                path: path.to_owned(),
                at_byte,
                reason,
            }),
        }
    }

    /// That it is JSON, whatever it says.
    pub(crate) fn check(&self, path: &Path) -> Result<(), DatasetError> {
        self.row::<IgnoredAny>(path).map(drop)
    }

    /// Where it stands: `annotations[7]`, or `[7]` in a file that is one list.
    #[must_use]
    pub fn place(&self) -> String {
        match self.idx {
            Some(idx) => format!("{}[{idx}]", self.key.escape_debug()),
            None => self.key.escape_debug().to_string(),
        }
    }
}

/// What serde says, without the line and column, which count inside the record.
pub(crate) fn reason_of(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rsplit_once(" at line ") {
        Some((reason, _)) => reason.to_owned(),
        None => text,
    }
}

/// Bytes before a line and column, which both count from 1.
fn offset_in(text: &str, line: usize, column: usize) -> usize {
    let lines = text.split_inclusive('\n').take(line.saturating_sub(1));
    lines.map(str::len).sum::<usize>() + column
}
