//! Numbers out of range, found by the schema that the definition generates.

use serde_json::Value as Json;
use toml::{Table, Value};

use super::super::error::{Place, RecipeError, short_number};
use super::super::schema::{keys, of_choice};
use super::super::tables::Choice;
use super::out_of_range;

/// How keys end, with the unit in words; of two that fit the first.
const UNITS: [(&str, &str); 13] = [
    ("_deg_s", " degrees/s"),
    ("_mm_h", " mm/h"),
    ("_um_s", " um/s"),
    ("_m_s", " m/s"),
    ("_kg_m3", " kg/m3"),
    ("_mpa", " MPa"),
    ("_deg", " degrees"),
    ("_mm", " mm"),
    ("_um", " um"),
    ("_px", " px"),
    ("_m", " m"),
    ("_k", " K"),
    ("_s", " s"),
];

/// Every number of a recipe is in the range of its key.
pub(super) fn check(place: &Place, recipe: &Table, choice: Choice) -> Result<(), RecipeError> {
    for (name, value) in recipe {
        let own = keys(&of_choice(choice)["properties"][name]);
        let tables: Vec<(String, &Value)> = match value {
            Value::Array(tables) => (tables.iter().enumerate())
                .map(|(k, table)| (format!("{name}.{k}"), table))
                .collect(),
            table => vec![(name.clone(), table)],
        };
        for (name, table) in tables {
            for (key, value) in table.as_table().into_iter().flatten() {
                match own.and_then(|own| own.get(key)) {
                    Some(schema) if !is_in_range(schema, value) => {
                        let expected = possible(schema, key, value);
                        let key = format!("{name}.{key}");
                        return Err(out_of_range(place, &key, shown(value), &expected));
                    }
                    _ => {}
                }
            }
        }
    }
    Ok(())
}

/// Each number in a value is in the range of its key, and finite unless it only has a least value;
/// what is no number is judged by its type.
fn is_in_range(schema: &Json, value: &Value) -> bool {
    let bound = |name: &str| schema[name].as_f64();
    let number = match value {
        #[expect(clippy::cast_precision_loss, reason = "no bound is as large")]
        Value::Integer(number) => *number as f64,
        Value::Float(number) => *number,
        Value::Array(list) => return list.iter().all(|value| is_in_range(schema, value)),
        _ => return true,
    };
    let is_high = match (bound("minimum"), bound("exclusiveMinimum")) {
        (Some(least), _) => number >= least,
        (None, Some(above)) => number > above,
        (None, None) => number.is_finite(),
    };
    is_high && bound("maximum").is_none_or(|most| number <= most)
}

/// What a key may be: `"auto", or 0.1 to 1000 um`.
fn possible(schema: &Json, key: &str, value: &Value) -> String {
    let bound = |name: &str| {
        let bound = schema[name].as_f64()?;
        let is_plain = bound == 0.0 || (1e-6..1e9).contains(&bound.abs());
        Some(if is_plain {
            format!("{bound}")
        } else {
            format!("{bound:e}")
        })
    };
    let range = match (
        bound("minimum"),
        bound("exclusiveMinimum"),
        bound("maximum"),
    ) {
        (Some(least), _, Some(most)) => format!("{least} to {most}"),
        (Some(least), _, None) => format!("{least} or more"),
        (None, Some(above), Some(most)) => format!("above {above} and up to {most}"),
        _ => "a finite number".to_owned(),
    };
    let unit = UNITS.iter().find(|(end, _)| key.ends_with(end));
    let unit = unit.map_or("", |(_, unit)| unit);
    let each = if value.is_array() { " each" } else { "" };
    let words: String = words(schema).map(|word| format!("{word}, ")).collect();
    let or = if words.is_empty() { "" } else { "or " };
    format!("{words}{or}{range}{unit}{each}")
}

/// The words that a key knows.
fn words(schema: &Json) -> Box<dyn Iterator<Item = &Json> + '_> {
    let lists = [&schema["enum"], &schema["anyOf"], &schema["oneOf"]];
    let kinds = lists.into_iter().filter_map(Json::as_array).flatten();
    let inner = kinds.flat_map(|kind| {
        if kind.is_string() {
            Box::new(std::iter::once(kind))
        } else {
            words(kind)
        }
    });
    Box::new(schema.get("const").into_iter().chain(inner))
}

/// A number as a message shows it, or a list of them.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) => short_number(number.to_string()),
        Value::Array(list) => {
            let list: Vec<String> = list.iter().map(shown).collect();
            format!("[{}]", list.join(", "))
        }
        other => other.to_string(),
    }
}
