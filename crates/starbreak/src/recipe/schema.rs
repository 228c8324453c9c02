//! The JSON Schema of recipes, generated from the definition that parses them.

use std::sync::OnceLock;

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::{Map, Value as Json, json};

use super::tables::{ModelWord, PaperRecipe, PhysicsRecipe};

/// The JSON Schema of a recipe, for editors: the keys of both models; those that only one has say
/// which. A recipe may leave out every key but `schema`.
#[must_use]
pub fn json_schema() -> Json {
    all().clone()
}

/// The schema of both models together.
pub(super) fn all() -> &'static Json {
    static ALL: OnceLock<Json> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = of_model(ModelWord::Physics).clone();
        if let (Some(all), Some(paper)) = (keys_mut(&mut all), keys(of_model(ModelWord::Paper))) {
            unite(all, paper);
        }
        all["required"] = json!(["schema"]);
        all
    })
}

/// The schema of one model.
pub(super) fn of_model(model: ModelWord) -> &'static Json {
    static PHYSICS: OnceLock<Json> = OnceLock::new();
    static PAPER: OnceLock<Json> = OnceLock::new();
    let generator = || {
        let settings = SchemaSettings::draft2020_12().with(|settings| {
            settings.inline_subschemas = true;
        });
        let optional = RecursiveTransform(|schema: &mut Schema| {
            schema.remove("required");
        });
        settings.with_transform(optional).into_generator()
    };
    match model {
        ModelWord::Physics => {
            PHYSICS.get_or_init(|| generator().into_root_schema_for::<PhysicsRecipe>().into())
        }
        ModelWord::Paper => {
            PAPER.get_or_init(|| generator().into_root_schema_for::<PaperRecipe>().into())
        }
    }
}

/// The keys of a table, or of each table in a list; none for what is no table.
pub(super) fn keys(table: &Json) -> Option<&Map<String, Json>> {
    table["properties"]
        .as_object()
        .or_else(|| table["items"]["properties"].as_object())
}

fn keys_mut(table: &mut Json) -> Option<&mut Map<String, Json>> {
    let place = if table["items"]["properties"].is_object() {
        "/items/properties"
    } else {
        "/properties"
    };
    table.pointer_mut(place)?.as_object_mut()
}

/// Adds the keys of the paper's model; keys that only one of the two has are marked.
fn unite(all: &mut Map<String, Json>, paper: &Map<String, Json>) {
    for (key, value) in all.iter_mut() {
        match paper.get(key) {
            None => mark(value, "physics"),
            Some(paper) => {
                if let (Some(all), Some(paper)) = (keys_mut(value), keys(paper)) {
                    unite(all, paper);
                }
            }
        }
    }
    for (key, value) in paper {
        all.entry(key.clone()).or_insert_with(|| {
            let mut value = value.clone();
            mark(&mut value, "paper");
            value
        });
    }
}

fn mark(value: &mut Json, model: &str) {
    let description = value["description"].as_str().unwrap_or_default();
    value["description"] = format!("({model}) {description}").into();
}
