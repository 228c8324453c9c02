//! Single records of JSON files, and where they go wrong.

use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::JsonRecord;

use crate::EvalError;

/// The record as a value.
pub(crate) fn parse<'a, T: Deserialize<'a>>(
    path: &Path,
    record: &JsonRecord<'a>,
) -> Result<T, EvalError> {
    record.parse().map_err(|fault| {
        let place = format!("{}, byte {}", record.place(), fault.at_byte);
        refuse(path, place, fault.reason)
    })
}

pub(crate) fn refuse(
    path: &Path,
    place: impl Into<String>,
    reason: impl Into<String>,
) -> EvalError {
    EvalError::Record {
        path: path.to_owned(),
        place: place.into(),
        reason: printable(&reason.into()),
    }
}

pub(crate) fn refuse_file(path: &Path, reason: impl Into<String>) -> EvalError {
    EvalError::File {
        path: path.to_owned(),
        reason: printable(&reason.into()),
    }
}

/// What a parser says may repeat what it read, control characters and all.
fn printable(text: &str) -> String {
    let escaped = |c: char| match c.is_control() {
        true => c.escape_default().to_string(),
        false => c.to_string(),
    };
    text.chars().map(escaped).collect()
}
