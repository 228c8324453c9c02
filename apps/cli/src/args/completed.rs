//! What a shell completes flags of the recipe with.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, Command};
use serde_json::Value;
use starbreak::{cameras, json_schema, presets};

/// Any text, which a shell may complete with names; what is no such name is refused by the recipe, with the nearest.
#[derive(Clone)]
pub(super) struct Completed(fn() -> Vec<String>);

impl Completed {
    /// Names of presets.
    pub(super) const PRESET: Self = Self(|| presets().map(|(name, _)| name.to_owned()).collect());
    /// Names of cameras.
    pub(super) const CAMERA: Self = Self(|| {
        let all = cameras().unwrap_or_default();
        all.into_iter().map(|(name, _)| name).collect()
    });
    /// Keys of recipes, each with its table and an equals sign.
    pub(super) const SET: Self = Self(|| {
        let schema = json_schema();
        let keys = |table: &Value| -> Vec<String> {
            let own = table["properties"].as_object();
            let keys = own.or_else(|| table["items"]["properties"].as_object());
            keys.into_iter()
                .flat_map(|keys| keys.keys().cloned())
                .collect()
        };
        let tables = schema["properties"].as_object().into_iter().flatten();
        let of_table = |(name, table): (&String, &Value)| -> Vec<String> {
            let keys = keys(table).into_iter();
            keys.map(|key| format!("{name}.{key}=")).collect()
        };
        tables.flat_map(of_table).collect()
    });
}

impl TypedValueParser for Completed {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.0)().into_iter().map(PossibleValue::new)))
    }
}
