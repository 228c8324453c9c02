//! Single records of JSON files, and where they go wrong.

use std::path::Path;

use serde::de::{DeserializeOwned, Error as _, Visitor};
use serde::{Deserialize, Deserializer};
use starbreak_dataset::JsonRecord;

use crate::EvalError;

/// The record as a value.
pub(crate) fn parse<T: DeserializeOwned>(
    path: &Path,
    record: &JsonRecord<'_>,
) -> Result<T, EvalError> {
    serde_json::from_slice(record.bytes).map_err(|error| {
        let behind = offset_in(record.bytes, error.line(), error.column());
        let text = error.to_string();
        let reason = text.split(" at line ").next().unwrap_or(&text);
        let at = record.bytes.get(behind.saturating_sub(1)..);
        let is_word = at.is_some_and(|b| matches!(b.first(), Some(b'N' | b'I')));
        let reason = match reason {
            "expected value" | "invalid number" if is_word => {
                "NaN and Infinity are no numbers of JSON; leave such records out"
            }
            reason => reason,
        };
        let byte = record.offset + u64::try_from(behind.saturating_sub(1)).unwrap_or(0);
        refuse(path, format!("{}, byte {byte}", place(record)), reason)
    })
}

/// Where a record stands: `annotations[7]`, or `[7]` in a file that is one list.
pub(crate) fn place(record: &JsonRecord<'_>) -> String {
    match record.idx {
        Some(idx) => format!("{}[{idx}]", record.key.escape_debug()),
        None => record.key.escape_debug().to_string(),
    }
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

/// Bytes before a line and column, which both count from 1.
fn offset_in(bytes: &[u8], line: usize, column: usize) -> usize {
    let before: usize = bytes
        .split_inclusive(|&byte| byte == b'\n')
        .take(line.saturating_sub(1))
        .map(<[u8]>::len)
        .sum();
    before + column
}

/// A whole number; also one that a table program wrote as 17.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Id(pub(crate) i64);

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IdVisitor;

        impl Visitor<'_> for IdVisitor {
            type Value = Id;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a whole number as id")
            }

            fn visit_i64<E: serde::de::Error>(self, id: i64) -> Result<Id, E> {
                Ok(Id(id))
            }

            fn visit_u64<E: serde::de::Error>(self, id: u64) -> Result<Id, E> {
                i64::try_from(id)
                    .map(Id)
                    .map_err(|_| E::custom(format!("the id {id} is above {}", i64::MAX)))
            }

            fn visit_f64<E: serde::de::Error>(self, id: f64) -> Result<Id, E> {
                match format!("{id:.0}").parse() {
                    Ok(whole) if id.fract().abs() <= 0.0 && id.abs() < 9e15 => Ok(Id(whole)),
                    _ => Err(E::custom(format!("the id {id} is not a whole number"))),
                }
            }
        }
        deserializer.deserialize_any(IdVisitor)
    }
}

/// `0`, `1`, `false` or `true`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Flag(pub(crate) bool);

impl<'de> Deserialize<'de> for Flag {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match serde_json::Value::deserialize(deserializer)? {
            serde_json::Value::Bool(is_set) => Ok(Self(is_set)),
            value => match value.as_f64() {
                Some(0.0) => Ok(Self(false)),
                Some(1.0) => Ok(Self(true)),
                _ => Err(D::Error::custom(format!("{value} is neither 0 nor 1"))),
            },
        }
    }
}
