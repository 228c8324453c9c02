use std::fmt;

use super::{MAX_RECIPE_BYTES, SCHEMA_VERSION, Scenario, presets};

/// Where a recipe text came from, for messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place(String);

impl Place {
    pub(super) fn file(name: &str) -> Self {
        Self(name.escape_debug().to_string())
    }

    pub(super) fn preset(name: &str) -> Self {
        Self(format!("preset {name}"))
    }

    pub(super) fn cameras() -> Self {
        Self("cameras".to_owned())
    }

    pub(super) fn camera(name: &str) -> Self {
        Self(format!("camera {name}"))
    }

    pub(super) fn assignment(text: &str) -> Self {
        Self(format!("--set {}", text.escape_debug()))
    }

    pub(super) fn key(key: &str) -> Self {
        Self(format!("set[{key:?}]"))
    }

    pub(super) fn recipe() -> Self {
        Self("recipe".to_owned())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// What is wrong with a recipe. Every message is one line that names the place and the key.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecipeError {
    /// Two conditions of a study that cannot be told apart.
    #[error(
        "the condition {what} is there twice; give each preset, severity and seed once, and recipes files of \
         different names"
    )]
    Twice {
        /// Its name.
        what: String,
    },
    /// More text than any recipe has.
    #[error("{place} is longer than {MAX_RECIPE_BYTES} bytes; a recipe has some thousand")]
    TooLong {
        /// Where the text came from.
        place: Place,
    },
    /// Not TOML.
    #[error("{place}:{line}:{column}: {what}")]
    Syntax {
        /// Where the text came from.
        place: Place,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser says.
        what: String,
    },
    /// Tables that TOML could not hold.
    #[error("{place}: {what}; a recipe is made of tables, numbers, strings and lists")]
    NotTables {
        /// Where they came from.
        place: Place,
        /// What they hold.
        what: String,
    },
    /// The version is missing.
    #[error(
        "{place}: the key `schema` is missing; begin the recipe with `schema = {SCHEMA_VERSION}`"
    )]
    NoSchema {
        /// Where the text came from.
        place: Place,
    },
    /// Another version.
    #[error("{place}: schema = {found}; this version reads schema = {SCHEMA_VERSION}")]
    Schema {
        /// Where the text came from.
        place: Place,
        /// What it says.
        found: String,
    },
    /// A key that does not exist.
    #[error("{place}: unknown key `{key}`; {hint}")]
    UnknownKey {
        /// Where the text came from.
        place: Place,
        /// The key with its table.
        key: String,
        /// The nearest known key, or all of them.
        hint: String,
    },
    /// A key or table of another model of fracture or optics.
    #[error(
        "{place}: {key} is a {what} of model \"{other}\", but this recipe's model is \"{model}\"; remove it or set \
         {choice} = \"{other}\""
    )]
    OtherModel {
        /// Where the text came from.
        place: Place,
        /// The key with its table.
        key: String,
        /// "key" or "table".
        what: &'static str,
        /// The model that has it.
        other: &'static str,
        /// The model of the recipe.
        model: &'static str,
        /// The key that chooses between the two.
        choice: &'static str,
    },
    /// A severity that presets do not have.
    #[error("severity {found}; expected 1 (mild) to 5 (severe), 3 is the preset itself")]
    Severity {
        /// What was asked for.
        found: i64,
    },
    /// A preset that does not exist.
    #[error("unknown preset `{name}`; {hint}")]
    UnknownPreset {
        /// What was asked for.
        name: String,
        /// The nearest preset, and all of them.
        hint: String,
    },
    /// A camera that does not exist.
    #[error("unknown camera `{name}`; {hint}")]
    UnknownCamera {
        /// What was asked for.
        name: String,
        /// The nearest camera, or all of them.
        hint: String,
    },
    /// A value of the wrong type.
    #[error("{place}: {key}: {what}")]
    Type {
        /// Where the text came from.
        place: Place,
        /// The key with its table.
        key: String,
        /// What was found and what was expected.
        what: String,
    },
    /// A value out of range.
    #[error("{place}: {key} = {value}; expected {expected}")]
    Range {
        /// Where the text came from.
        place: Place,
        /// The key with its table.
        key: String,
        /// What was given.
        value: String,
        /// What is possible.
        expected: String,
    },
    /// Values that do not go together, each in the range of its key.
    #[error("{place}: {what}")]
    Together {
        /// Where the text came from.
        place: Place,
        /// The key with its table, its value and what is possible.
        what: String,
    },
    /// Not of the form `table.key=value`, or no key in a table.
    #[error(
        "{place}: not an override; name a table, its key and a value, e.g. impact.speed_m_s=30"
    )]
    NotAnAssignment {
        /// The text.
        place: Place,
    },
    /// An impact that is not in the recipe.
    #[error("{place}: there is no impact `{index}`; the recipe has {count}, counted from 0")]
    NoSuchImpact {
        /// The text.
        place: Place,
        /// What was asked for.
        index: String,
        /// How many there are.
        count: usize,
    },
}

/// Text with its control characters written out, so that a message stays one printable line.
pub(super) fn printable(text: &str) -> String {
    text.chars()
        .flat_map(|c| {
            let escaped = c.is_control().then(|| c.escape_default());
            escaped
                .into_iter()
                .flatten()
                .chain((!c.is_control()).then_some(c))
        })
        .collect()
}

/// A number with so many digits that nobody counts them, by its power of ten.
pub(super) fn short_number(text: String) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.len() > 24 => format!("{value:e}"),
        _ => text,
    }
}

impl RecipeError {
    pub(super) fn unknown_preset(name: &str) -> Self {
        let names = presets().map(|(known, _)| known);
        let hint = super::known_keys::hint(name, names, "presets");
        Self::UnknownPreset {
            name: name.escape_debug().to_string(),
            hint,
        }
    }

    /// A fault that a scenario does not have.
    pub(super) fn unknown_part(name: &str, scenario: &Scenario) -> Self {
        let parts: Vec<String> = scenario.alone().collect();
        let hint = format!("this scenario has {}", parts.join(", "));
        Self::UnknownPreset {
            name: name.escape_debug().to_string(),
            hint,
        }
    }

    pub(super) fn unknown_camera(name: &str, known: &[String]) -> Self {
        let names = known.iter().map(String::as_str);
        let hint = super::known_keys::hint(name, names, "cameras");
        Self::UnknownCamera {
            name: name.escape_debug().to_string(),
            hint,
        }
    }

    /// What a model refuses although each value is in the range of its key; the error begins with
    /// the name of a parameter.
    pub(super) fn of_model(place: &Place, table: &str, error: impl fmt::Display) -> Self {
        Self::Together {
            place: place.clone(),
            what: format!("{table}.{error}"),
        }
    }
}
