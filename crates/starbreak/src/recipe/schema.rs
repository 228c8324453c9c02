//! The JSON Schema of recipes, generated from the definition that parses them.

use std::sync::OnceLock;

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value as Json, json};

use super::tables::{
    Choice, CommonTables, DepositTables, FaultTables, GlassMountTables, LensTables, ModelWord,
    OpticsWord, PaperFractureTables, PaperOpticsTables, PhysicalOpticsTables,
    PhysicsFractureTables, WholePaneTables, WholeTables,
};

/// The JSON Schema of a recipe, for editors: the keys of all models; those that only some have say
/// which. A recipe may leave out every key but `schema`.
#[must_use]
pub fn json_schema() -> Json {
    all().clone()
}

/// The schema of all models together.
pub(super) fn all() -> &'static Json {
    static ALL: OnceLock<Json> = OnceLock::new();
    ALL.get_or_init(|| {
        let tables: Vec<(Choice, &Map<String, Json>)> = Choice::ALL
            .iter()
            .filter_map(|choice| Some((*choice, keys(of_choice(*choice))?)))
            .collect();
        let mut all = root(unite(&tables));
        all["required"] = json!(["schema"]);
        all
    })
}

/// The schema of one choice of models.
pub(super) fn of_choice(choice: Choice) -> &'static Json {
    // Each by itself, since most programs ask for one.
    static EACH: [OnceLock<Json>; Choice::ALL.len()] =
        [const { OnceLock::new() }; Choice::ALL.len()];
    let at = Choice::ALL.iter().position(|known| *known == choice);
    EACH[at.unwrap_or(0)].get_or_init(|| root(tables_of(choice)))
}

/// Whether a table has a key with these models; with "" for a table, whether there is such a table.
pub(super) fn has(choice: Choice, table: &str, key: &str) -> bool {
    keys_of(of_choice(choice), table).is_some_and(|keys| keys.contains_key(key))
}

/// The keys of a table of a schema; with "" for a table, the tables.
pub(super) fn keys_of<'a>(schema: &'a Json, table: &str) -> Option<&'a Map<String, Json>> {
    keys(if table.is_empty() {
        schema
    } else {
        &schema["properties"][table]
    })
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

fn root(tables: Map<String, Json>) -> Json {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "starbreak recipe",
        "description": "A starbreak recipe: all parameters of a cracked glass.",
        "type": "object",
        "properties": tables,
        "additionalProperties": false,
    })
}

/// The tables that these models read.
fn tables_of(choice: Choice) -> Map<String, Json> {
    let mut tables = properties::<CommonTables>();
    tables.extend(match choice.fracture {
        ModelWord::Physics => properties::<PhysicsFractureTables>(),
        ModelWord::Paper => properties::<PaperFractureTables>(),
        ModelWord::None => properties::<WholeTables>(),
    });
    tables.extend(match choice.optics {
        OpticsWord::Physical => properties::<PhysicalOpticsTables>(),
        OpticsWord::Paper => properties::<PaperOpticsTables>(),
    });
    if choice == Choice::new(ModelWord::Paper, OpticsWord::Physical) {
        tables.extend(properties::<GlassMountTables>());
    }
    if choice == Choice::new(ModelWord::None, OpticsWord::Physical) {
        tables.extend(properties::<WholePaneTables>());
    }
    tables.extend(properties::<DepositTables>());
    tables.extend(properties::<LensTables>());
    tables.extend(properties::<FaultTables>());
    tables
}

fn properties<T: JsonSchema>() -> Map<String, Json> {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.inline_subschemas = true;
    });
    let optional = RecursiveTransform(|schema: &mut Schema| {
        schema.remove("required");
    });
    let generator = settings.with_transform(optional).into_generator();
    let schema: Json = generator.into_root_schema_for::<T>().into();
    keys(&schema).cloned().unwrap_or_default()
}

/// The keys of all these tables; those that only some have are marked.
fn unite(tables: &[(Choice, &Map<String, Json>)]) -> Map<String, Json> {
    let mut all = Map::new();
    for (key, value) in tables.iter().flat_map(|(_, table)| table.iter()) {
        if all.contains_key(key) {
            continue;
        }
        let having: Vec<(Choice, &Json)> = tables
            .iter()
            .filter_map(|(choice, table)| Some((*choice, table.get(key)?)))
            .collect();
        let inner: Vec<(Choice, &Map<String, Json>)> = having
            .iter()
            .filter_map(|(choice, value)| Some((*choice, keys(value)?)))
            .collect();
        let mut united = value.clone();
        if let Some(own) = keys_mut(&mut united) {
            *own = unite(&inner);
        } else if let Some(variants) = variants(&having) {
            united = variants;
        }
        if having.len() < tables.len() {
            mark(
                &mut united,
                &models(having.iter().map(|(choice, _)| *choice)),
            );
        }
        all.insert(key.clone(), united);
    }
    all
}

/// A key that means different things to different models; none if it means one thing to all.
fn variants(having: &[(Choice, &Json)]) -> Option<Json> {
    let mut distinct: Vec<(&Json, Vec<Choice>)> = Vec::new();
    for (choice, value) in having {
        match distinct.iter_mut().find(|(known, _)| known == value) {
            Some((_, choices)) => choices.push(*choice),
            None => distinct.push((value, vec![*choice])),
        }
    }
    if distinct.len() < 2 {
        return None;
    }
    let mut any_of = Vec::new();
    let mut descriptions = Vec::new();
    for (value, choices) in distinct {
        let mut value = value.clone();
        mark(&mut value, &models(choices.into_iter()));
        descriptions.push(value["description"].as_str().unwrap_or_default().to_owned());
        any_of.push(value);
    }
    Some(json!({ "description": descriptions.join(" "), "anyOf": any_of }))
}

/// The models of which each goes with one of these choices, whatever it is combined with.
fn models(choices: impl Iterator<Item = Choice> + Clone) -> String {
    // Where nothing breaks there is no model to tell apart, unless it has the key, too.
    let with_none = (choices.clone()).any(|choice| choice.fracture == ModelWord::None);
    let complete = |of: &dyn Fn(&Choice) -> bool| {
        let mut told = Choice::ALL
            .iter()
            .filter(|choice| of(choice) && (with_none || choice.fracture != ModelWord::None))
            .peekable();
        told.peek().is_some() && told.all(|choice| choices.clone().any(|having| having == *choice))
    };
    let mut names = Vec::new();
    for fracture in ModelWord::ALL {
        if complete(&|choice| choice.fracture == fracture) {
            names.push(fracture.name());
        }
    }
    for optics in [OpticsWord::Physical, OpticsWord::Paper] {
        if complete(&|choice| choice.optics == optics) {
            names.push(optics.name());
        }
    }
    names.join(" or ")
}

fn mark(value: &mut Json, models: &str) {
    let description = value["description"].as_str().unwrap_or_default();
    value["description"] = format!("({models}) {description}").into();
}
