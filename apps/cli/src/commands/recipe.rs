//! `starbreak recipe`: what can be set, and to what it is set.

use std::process::ExitCode;

use serde_json::json;
use starbreak::{PRESETS, json_schema};

use crate::args::Global;
use crate::failure::Failure;
use crate::screen::Screen;

pub(crate) fn run(
    global: &Global,
    schema: bool,
    list: bool,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    if schema {
        screen.data(&format!("{:#}", json_schema()))?;
    } else if list {
        let presets = PRESETS
            .iter()
            .map(|(name, purpose)| json!({ "name": name, "purpose": purpose }));
        if global.json {
            screen.result(|| json!({ "presets": presets.collect::<Vec<_>>() }))?;
        } else {
            for (name, purpose) in PRESETS {
                screen.data(&format!("{name:24} {purpose}"))?;
            }
        }
    } else {
        let recipe = global.recipe()?;
        if global.json {
            screen.result(|| json!({ "recipe": recipe.to_toml() }))?;
        } else {
            screen.data(&recipe.to_commented_toml())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
