//! One key of a recipe and the value that it gets.

use toml::{Table, Value};

use super::error::{Place, RecipeError, printable};

/// A key of a recipe, `table.key`, with the value that it gets.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// What messages call it.
    pub(super) place: Place,
    pub(super) key: String,
    pub(super) value: Value,
}

impl Assignment {
    /// From the text `table.key=value`; the value is TOML, or else a string.
    ///
    /// # Errors
    /// [`RecipeError::NotAnAssignment`].
    pub fn parse(text: &str) -> Result<Self, RecipeError> {
        let place = Place::assignment(text);
        let Some((key, value)) = text.split_once('=') else {
            return Err(RecipeError::NotAnAssignment { place });
        };
        Ok(Self {
            place,
            key: key.trim().to_owned(),
            value: parse_value(value.trim()),
        })
    }

    /// From a key and its value as they are.
    ///
    /// # Errors
    /// [`RecipeError::NotTables`] for a value that TOML does not have.
    pub fn of(key: &str, value: &serde_json::Value) -> Result<Self, RecipeError> {
        let place = Place::key(key);
        match Value::try_from(value) {
            Ok(value) => Ok(Self {
                place,
                key: key.to_owned(),
                value,
            }),
            Err(cause) => Err(RecipeError::NotTables {
                place,
                what: printable(&cause.to_string()),
            }),
        }
    }
}

/// TOML if it is TOML, else the text itself: `--set camera.focus_distance_m=short`.
fn parse_value(text: &str) -> Value {
    let parsed = format!("value = {text}")
        .parse::<Table>()
        .ok()
        .and_then(|mut table| {
            let value = table.remove("value");
            // More than one key means that the text went on to a new line.
            if table.is_empty() { value } else { None }
        });
    parsed.unwrap_or_else(|| Value::String(text.to_owned()))
}
