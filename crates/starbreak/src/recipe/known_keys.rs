//! Unknown keys, found by the schema that the definition generates.

use serde_json::Value as Json;
use toml::{Table, Value};

use super::error::{Place, RecipeError};
use super::schema;

/// Names of the presets or keys nearer than this are suggested.
const NEAR: f64 = 0.6;

/// Every key of a recipe exists.
pub(super) fn check(place: &Place, given: &Table) -> Result<(), RecipeError> {
    let schema = schema();
    let tables = keys(schema);
    for (name, value) in given {
        if !tables.contains(name) {
            return Err(unknown(place, name, "", &tables));
        }
        let known = keys(table_schema(schema, name));
        if known.is_empty() {
            continue;
        }
        match value {
            Value::Table(table) if !schema["properties"][name]["items"].is_object() => {
                check_table(place, name, table, &known)?;
            }
            Value::Array(entries) if schema["properties"][name]["items"].is_object() => {
                for (k, entry) in entries.iter().enumerate() {
                    let name = format!("{name}.{k}");
                    match entry {
                        Value::Table(table) => check_table(place, &name, table, &known)?,
                        other => return Err(no_table(place, &name, other)),
                    }
                }
            }
            other => return Err(no_table(place, name, other)),
        }
    }
    Ok(())
}

/// "did you mean …?" for a near name, else the list of all.
pub(super) fn hint(given: &str, known: &[String], what: &str) -> String {
    let lower = given.to_lowercase();
    let nearest = known
        .iter()
        .map(|name| (strsim::normalized_damerau_levenshtein(&lower, name), name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((nearness, name)) if nearness >= NEAR => format!("did you mean `{name}`?"),
        _ => format!("known {what}: {}", known.join(", ")),
    }
}

/// The schema of a table of the recipe, whether it stands alone or in a list.
pub(super) fn table_schema<'a>(schema: &'a Json, name: &str) -> &'a Json {
    let property = &schema["properties"][name];
    let target = if property["items"].is_object() {
        &property["items"]
    } else {
        property
    };
    let reference = target["$ref"]
        .as_str()
        .or_else(|| target["allOf"][0]["$ref"].as_str());
    match reference.and_then(|path| path.strip_prefix("#/$defs/")) {
        Some(definition) => &schema["$defs"][definition],
        None => target,
    }
}

fn check_table(
    place: &Place,
    name: &str,
    table: &Table,
    known: &[String],
) -> Result<(), RecipeError> {
    match table.keys().find(|key| !known.contains(key)) {
        Some(key) => Err(unknown(place, key, &format!("{name}."), known)),
        None => Ok(()),
    }
}

fn no_table(place: &Place, name: &str, found: &Value) -> RecipeError {
    let what = format!("expected a table, found {}", found.type_str());
    RecipeError::Type {
        place: place.clone(),
        key: name.to_owned(),
        what,
    }
}

fn unknown(place: &Place, key: &str, prefix: &str, known: &[String]) -> RecipeError {
    let what = if prefix.is_empty() { "tables" } else { "keys" };
    let hint = hint(key, known, what).replace("mean `", &format!("mean `{prefix}"));
    RecipeError::UnknownKey {
        place: place.clone(),
        key: format!("{prefix}{}", key.escape_debug()),
        hint,
    }
}

fn keys(schema: &Json) -> Vec<String> {
    schema["properties"]
        .as_object()
        .map(|all| all.keys().cloned().collect())
        .unwrap_or_default()
}
