//! What a set is made from, so that two recipes never mix in one folder.

use std::path::Path;

use serde_json::Value;

use super::read_json;
use crate::error::DatasetError;

/// The identity in a `run.json`.
pub(super) fn read(path: &Path) -> Result<Value, DatasetError> {
    let identity = read_json(path)?;
    if identity["schema"] != super::SET_SCHEMA {
        return Err(DatasetError::OtherVersion {
            path: path.to_owned(),
            found: identity["schema"].to_string(),
            wanted: super::SET_SCHEMA,
        });
    }
    Ok(identity)
}

/// What the `run.json` of an identity holds.
pub(super) fn text(identity: &Value) -> String {
    format!("{identity:#}\n")
}

/// Refuses a set of another identity, naming the first thing in which the two differ.
///
/// # Errors
/// [`DatasetError::OtherSet`].
pub fn compare_identity(root: &Path, found: &Value, wanted: &Value) -> Result<(), DatasetError> {
    match difference(found, wanted, "") {
        None => Ok(()),
        Some((key, found, wanted)) => Err(DatasetError::OtherSet {
            path: root.to_owned(),
            key,
            found: short(&found),
            wanted: short(&wanted),
        }),
    }
}

/// The first key whose value differs, and its two values.
pub(super) fn difference(
    found: &Value,
    wanted: &Value,
    key: &str,
) -> Option<(String, Value, Value)> {
    let (Value::Object(found_map), Value::Object(wanted_map)) = (found, wanted) else {
        return (found != wanted).then(|| (key.to_owned(), found.clone(), wanted.clone()));
    };
    let keys = wanted_map.keys().chain(
        found_map
            .keys()
            .filter(|key| !wanted_map.contains_key(*key)),
    );
    keys.into_iter().find_map(|name| {
        let path = if key.is_empty() {
            name.clone()
        } else {
            format!("{key}.{name}")
        };
        difference(&found[name.as_str()], &wanted[name.as_str()], &path)
    })
}

/// A value as a few characters.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 80 {
        return text;
    }
    let head: String = text.chars().take(79).collect();
    format!("{head}…")
}
