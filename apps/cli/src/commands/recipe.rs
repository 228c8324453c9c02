//! `starbreak recipe`: what can be set, and to what it is set.

use serde_json::json;
use starbreak::{cameras, json_schema, presets};

use crate::args::Global;
use crate::failure::{DONE, Failure};
use crate::screen::Screen;

pub(crate) fn run(
    global: &Global,
    schema: bool,
    list: bool,
    screen: &Screen,
) -> Result<u8, Failure> {
    if schema {
        screen.data(&format!("{:#}", json_schema()))?;
    } else if list {
        let cameras = cameras()?;
        if global.json {
            let listed =
                |(name, purpose): (&str, &str)| json!({ "name": name, "purpose": purpose });
            let presets: Vec<_> = presets().map(listed).collect();
            let cameras: Vec<_> = (cameras.iter())
                .map(|(name, purpose)| listed((name, purpose)))
                .collect();
            screen.result(|| json!({ "presets": presets, "cameras": cameras }))?;
        } else {
            for (name, purpose) in presets() {
                screen.data(&format!("{name:24} {purpose}"))?;
            }
            screen.data("\na fault of a scenario alone: its name and the table with a dot, as rainy-drive.drops")?;
            screen.data("\ncameras (--camera NAME):")?;
            for (name, purpose) in cameras {
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
    Ok(DONE)
}
