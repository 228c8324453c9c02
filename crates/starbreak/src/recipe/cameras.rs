//! The named cameras: what each sets of a recipe.

use toml::{Table, Value};

use super::error::{Place, RecipeError};
use super::parse_table;

const TEXT: &str = include_str!("../../presets/cameras.toml");

/// The key that says what a camera is; all else are tables of a recipe.
const PURPOSE: &str = "purpose";

/// Names of the cameras, with what each is.
///
/// # Errors
/// None: the list is part of the program, and its tests read it.
pub fn cameras() -> Result<Vec<(String, String)>, RecipeError> {
    let each = all()?.into_iter().map(|(name, camera)| {
        let purpose = camera.get(PURPOSE).and_then(Value::as_str);
        (name, purpose.unwrap_or_default().to_owned())
    });
    Ok(each.collect())
}

/// What a camera sets: tables, keys and values.
pub(super) fn overlay(name: &str) -> Result<Vec<(String, String, Value)>, RecipeError> {
    let mut all = all()?;
    let Some(Value::Table(camera)) = all.remove(name) else {
        let names: Vec<String> = all.keys().cloned().collect();
        return Err(RecipeError::unknown_camera(name, &names));
    };
    let tables = camera.into_iter().filter_map(|(table, keys)| match keys {
        Value::Table(keys) => Some((table, keys)),
        _ => None,
    });
    let each = tables.flat_map(|(table, keys)| {
        keys.into_iter()
            .map(move |(key, value)| (table.clone(), key, value))
    });
    Ok(each.collect())
}

fn all() -> Result<Table, RecipeError> {
    parse_table(&Place::cameras(), TEXT)
}
