//! Text to valid settings: parse, complete from a preset, override, validate, convert to SI.

mod error;
mod known_keys;
mod print;
mod settings;
mod tables;

use std::sync::OnceLock;

use toml::{Table, Value};

pub use error::RecipeError;
pub use settings::{OutputFormat, OutputSettings, Settings};

use error::{Place, printable};

/// Version of the recipe format, the value of its `schema` key.
pub const SCHEMA_VERSION: i64 = 1;

/// Names of the presets, with what each is for.
pub const PRESETS: [(&str, &str); 1] = [(
    "paper",
    "the model of \"Fractured Glass, Failing Cameras\": stress propagation and grey cracks",
)];

/// The preset that fills in what a recipe leaves out.
const BASE: &str = "paper";

/// All parameters of a run, complete and checked.
///
/// # Example
/// ```
/// use starbreak::Recipe;
/// let recipe = Recipe::parse("mine.toml", "schema = 1\n[fracture]\nparticles = 500")?;
/// assert_eq!(recipe.settings()?.fracture.particles, 500);
///
/// let typo = Recipe::parse("mine.toml", "schema = 1\n[fracture]\npartikles = 500").unwrap_err();
/// assert_eq!(
///     typo.to_string(),
///     "mine.toml: unknown key `fracture.partikles`; did you mean `fracture.particles`?"
/// );
/// # Ok::<(), starbreak::RecipeError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    table: Table,
}

impl Recipe {
    /// A preset by its name.
    ///
    /// # Errors
    /// [`RecipeError::UnknownPreset`] with the names that exist.
    pub fn preset(name: &str) -> Result<Self, RecipeError> {
        if !PRESETS.iter().any(|(known, _)| *known == name) {
            return Err(RecipeError::unknown_preset(name));
        }
        let table = parse_table(
            &Place::preset(name),
            include_str!("../../presets/paper.toml"),
        )?;
        Ok(Self { table })
    }

    /// A recipe from TOML text; what it leaves out comes from the preset `paper`. `name` stands
    /// for the text in messages. If the text has `[[impact]]` tables, they replace the preset's.
    ///
    /// # Errors
    /// [`RecipeError`] in one line: syntax with line and column, an unknown key with the nearest
    /// known one, a value of the wrong type or out of range.
    pub fn parse(name: &str, text: &str) -> Result<Self, RecipeError> {
        let place = Place::file(name);
        let given = parse_table(&place, text)?;
        known_keys::check(&place, &given)?;
        match given.get("schema") {
            None => return Err(RecipeError::NoSchema { place }),
            Some(Value::Integer(SCHEMA_VERSION)) => {}
            Some(other) => {
                return Err(RecipeError::Schema {
                    place,
                    found: printable(&other.to_string()),
                });
            }
        }
        let mut recipe = Self::preset(BASE)?;
        merge(&mut recipe.table, given);
        complete_impacts(&mut recipe.table, &Self::preset(BASE)?.table);
        recipe.settings_of(&place)?;
        Ok(recipe)
    }

    /// Overrides one key: `table.key=value`, `impact.key=value` for every impact, or
    /// `impact.0.key=value` for one. The value is TOML, or else a string.
    ///
    /// # Errors
    /// [`RecipeError`] as for [`Recipe::parse`]; the recipe is then unchanged.
    pub fn set(&mut self, assignment: &str) -> Result<(), RecipeError> {
        let place = Place::assignment(assignment);
        let Some((key, text)) = assignment.split_once('=') else {
            return Err(RecipeError::NotAnAssignment { place });
        };
        let value = parse_value(text.trim());
        let parts: Vec<&str> = key.trim().split('.').collect();
        let mut changed = self.clone();
        match parts.as_slice() {
            ["impact", index, key] => {
                let impacts = changed.impacts();
                let count = impacts.len();
                let impact = index
                    .parse::<usize>()
                    .ok()
                    .and_then(|index| impacts.get_mut(index));
                let Some(Value::Table(impact)) = impact else {
                    return Err(RecipeError::NoSuchImpact {
                        place,
                        index: printable(index),
                        count,
                    });
                };
                impact.insert((*key).to_owned(), value);
            }
            ["impact", key] => {
                for impact in changed.impacts() {
                    if let Value::Table(impact) = impact {
                        impact.insert((*key).to_owned(), value.clone());
                    }
                }
            }
            [table, key] => match changed.table.get_mut(*table) {
                Some(Value::Table(table)) => {
                    table.insert((*key).to_owned(), value);
                }
                _ => {
                    let unknown =
                        Table::from_iter([((*table).to_owned(), Value::Table(Table::new()))]);
                    known_keys::check(&place, &unknown)?;
                    return Err(RecipeError::NotAnAssignment { place });
                }
            },
            _ => return Err(RecipeError::NotAnAssignment { place }),
        }
        known_keys::check(&place, &changed.table)?;
        changed.settings_of(&place)?;
        *self = changed;
        Ok(())
    }

    /// The recipe in SI units, every value in its range.
    ///
    /// # Errors
    /// [`RecipeError`] naming the key, its value and what is possible.
    pub fn settings(&self) -> Result<Settings, RecipeError> {
        self.settings_of(&Place::recipe())
    }

    /// The complete recipe as TOML, each key with a comment that says what it is.
    #[must_use]
    pub fn to_commented_toml(&self) -> String {
        print::commented(&self.table)
    }

    /// The complete recipe as plain TOML: the same text for the same recipe.
    #[must_use]
    pub fn to_toml(&self) -> String {
        print::plain(&self.table)
    }

    fn settings_of(&self, place: &Place) -> Result<Settings, RecipeError> {
        let tables = tables::RecipeTables::from_table(place, &self.table)?;
        settings::from_tables(place, &tables)
    }

    fn impacts(&mut self) -> &mut [Value] {
        match self.table.get_mut("impact") {
            Some(Value::Array(impacts)) => impacts,
            _ => &mut [],
        }
    }
}

/// The JSON Schema of a recipe, for editors; generated from the definition that parses it.
#[must_use]
pub fn json_schema() -> serde_json::Value {
    schema().clone()
}

/// The schema, generated once.
fn schema() -> &'static serde_json::Value {
    static SCHEMA: OnceLock<serde_json::Value> = OnceLock::new();
    SCHEMA.get_or_init(|| serde_json::Value::from(schemars::schema_for!(tables::RecipeTables)))
}

fn parse_table(place: &Place, text: &str) -> Result<Table, RecipeError> {
    text.parse::<Table>().map_err(|cause| {
        let (line, column) = cause
            .span()
            .map_or((1, 1), |span| line_and_column(text, span.start));
        let what = printable(&cause.message().replace('\n', ", "));
        RecipeError::Syntax {
            place: place.clone(),
            line,
            column,
            what,
        }
    })
}

fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
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

/// Writes `given` over `table`, table by table.
fn merge(table: &mut Table, given: Table) {
    for (key, value) in given {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => merge(old, new),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

/// Fills in what an impact leaves out.
fn complete_impacts(table: &mut Table, base: &Table) {
    let Some(Value::Array(defaults)) = base.get("impact") else {
        return;
    };
    let Some(Value::Table(default)) = defaults.first() else {
        return;
    };
    if let Some(Value::Array(impacts)) = table.get_mut("impact") {
        for impact in impacts {
            if let Value::Table(impact) = impact {
                for (key, value) in default {
                    impact.entry(key.clone()).or_insert_with(|| value.clone());
                }
            }
        }
    }
}
