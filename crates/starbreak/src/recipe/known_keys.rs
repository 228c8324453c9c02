//! Unknown keys, found by the schema that the definition generates.

use serde_json::{Map, Value as Json};
use toml::{Table, Value};

use super::error::{Place, RecipeError};
use super::schema::{all, has, keys, keys_of, of_choice};
use super::tables::{Choice, ModelWord};

/// Names of the presets or keys nearer than this are suggested.
const NEAR: f64 = 0.6;

/// Keys by their names, with what the schema says of each.
type Keys = Map<String, Json>;

/// Every key of a recipe exists, and in these models.
pub(super) fn check(place: &Place, given: &Table, choice: Choice) -> Result<(), RecipeError> {
    let Some(own) = keys(of_choice(choice)) else {
        return Ok(());
    };
    check_table(place, "", given, own, choice)?;
    for (name, value) in given {
        let Some(own_keys) = keys(&own[name]) else {
            continue;
        };
        match value {
            Value::Table(table) if own[name]["items"].is_null() => {
                check_table(place, name, table, own_keys, choice)?;
            }
            Value::Array(entries) if own[name]["items"].is_object() => {
                for (k, entry) in entries.iter().enumerate() {
                    let name = format!("{name}.{k}");
                    let Value::Table(table) = entry else {
                        return Err(no_table(place, &name, entry));
                    };
                    check_table(place, &name, table, own_keys, choice)?;
                }
            }
            other => return Err(no_table(place, name, other)),
        }
    }
    Ok(())
}

/// Drops the keys and tables that these models do not have.
pub(super) fn retain(recipe: &mut Table, choice: Choice) {
    let Some(own) = keys(of_choice(choice)) else {
        return;
    };
    recipe.retain(|name, _| own.contains_key(name));
    for (name, value) in recipe {
        let Some(own) = keys(&own[name]) else {
            continue;
        };
        let tables: &mut [Value] = match value {
            Value::Array(entries) => entries,
            one => std::slice::from_mut(one),
        };
        for table in tables.iter_mut().filter_map(Value::as_table_mut) {
            table.retain(|key, _| own.contains_key(key));
        }
    }
}

/// "did you mean …?" for a near name, else the list of all.
pub(super) fn hint<'a>(
    given: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    what: &str,
) -> String {
    // The British word, and a name without its unit or its kind.
    let lower = given.to_lowercase().replace("windscreen", "windshield");
    let begins = |name: &&str| {
        let rest = name.strip_prefix(&*lower);
        rest.is_some_and(|rest| rest.starts_with(['_', '-']))
    };
    let nearness = |name: &'a str| (strsim::normalized_damerau_levenshtein(&lower, name), name);
    let nearest = match known.clone().find(begins) {
        Some(name) => Some((1.0, name)),
        None => known
            .clone()
            .map(nearness)
            .max_by(|a, b| a.0.total_cmp(&b.0)),
    };
    match nearest {
        Some((nearness, name)) if nearness >= NEAR => format!("did you mean `{name}`?"),
        _ => format!("known {what}: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

fn check_table(
    place: &Place,
    name: &str,
    table: &Table,
    own: &Keys,
    choice: Choice,
) -> Result<(), RecipeError> {
    let Some(key) = table.keys().find(|key| !own.contains_key(*key)) else {
        return Ok(());
    };
    let what = if name.is_empty() { "table" } else { "key" };
    let prefix = if name.is_empty() {
        String::new()
    } else {
        format!("{name}.")
    };
    let full = format!("{prefix}{}", key.escape_debug());
    // The table's name without the number of an impact.
    let table = name.split('.').next().unwrap_or_default();
    if let Some((by, model, other)) = other_model(table, key, choice) {
        return Err(RecipeError::OtherModel {
            place: place.clone(),
            key: full,
            what,
            other,
            model,
            choice: by,
        });
    }
    let known = keys_of(all(), table).into_iter().flat_map(Keys::keys);
    let hint = hint(key, known.map(String::as_str), &format!("{what}s"));
    Err(RecipeError::UnknownKey {
        place: place.clone(),
        key: full,
        hint: hint.replace("mean `", &format!("mean `{prefix}")),
    })
}

/// What to change for a key to exist: the key that chooses a model, that model and the other one.
fn other_model(
    table: &str,
    key: &str,
    choice: Choice,
) -> Option<(&'static str, &'static str, &'static str)> {
    let Choice { fracture, optics } = choice;
    for other in ModelWord::ALL {
        if has(Choice::new(other, optics), table, key) {
            return Some(("fracture.model", fracture.name(), other.name()));
        }
    }
    has(Choice::new(fracture, optics.other()), table, key)
        .then(|| ("optics.model", optics.name(), optics.other().name()))
}

fn no_table(place: &Place, name: &str, found: &Value) -> RecipeError {
    let what = match found {
        // Where a table does not do, a list of them is meant.
        Value::Table(_) => format!("expected a list of tables, [[{name}]], found one table"),
        _ => format!("expected a table, found {}", found.type_str()),
    };
    RecipeError::Type {
        place: place.clone(),
        key: name.to_owned(),
        what,
    }
}
