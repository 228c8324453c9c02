//! Text to valid settings: parse, complete from a preset, override, validate, convert to SI.

mod assignment;
mod cameras;
mod deposit_tables;
mod error;
mod fault_tables;
mod faults;
mod known_keys;
mod lens_tables;
mod paper_tables;
mod physical_tables;
mod physics_tables;
mod presets;
mod print;
mod schema;
mod settings;
mod tables;

use toml::{Table, Value};

pub use assignment::Assignment;
pub use cameras::cameras;
pub use error::RecipeError;
pub use faults::{FAULTS, FaultKind, SCENARIOS, Scenario, presets};
pub use presets::{DEFAULT_PRESET, PRESETS};
pub use schema::json_schema;
pub use settings::{
    CameraSettings, DEFAULT_MAX_MEMORY_BYTES, FocalLength, FractureSettings,
    LEAST_MAX_MEMORY_BYTES, Mount, OpticsSettings, OutputFormat, OutputSettings, PaperSettings,
    PhysicsSettings, Settings, StoneSettings,
};

use crate::plain_words::in_plain_words;
use error::{Place, printable};
use presets::{KEYS_OF_KINDS, Preset};
use tables::{Choice, KindWord, ModelWord, OpticsWord};

/// Version of the recipe format, the value of its `schema` key.
pub const SCHEMA_VERSION: i64 = 1;

/// Longest text of a recipe, bytes: the parser takes some two hundred times as many.
pub const MAX_RECIPE_BYTES: usize = 1 << 20;

/// All parameters of a run, complete and checked.
///
/// # Example
/// ```
/// use starbreak::Recipe;
/// let recipe = Recipe::parse("mine.toml", "schema = 1\n[camera]\nf_px = 1900")?;
/// assert_eq!(recipe.settings()?.camera.f_px.of_frame(1920), 1900.0);
///
/// let typo = Recipe::parse("mine.toml", "schema = 1\n[camera]\nfpx = 1900").unwrap_err();
/// assert_eq!(
///     typo.to_string(),
///     "mine.toml: unknown key `camera.fpx`; did you mean `camera.f_px`?"
/// );
/// # Ok::<(), starbreak::RecipeError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    table: Table,
    /// Most memory of one picture, bytes, which no text says.
    max_memory_bytes: u64,
}

impl Recipe {
    /// A preset by its name.
    ///
    /// # Errors
    /// [`RecipeError::UnknownPreset`] with the names that exist.
    pub fn preset(name: &str) -> Result<Self, RecipeError> {
        let mut recipe = Self::of(Preset::named(name)?.table);
        // The others are complete.
        if !PRESETS.iter().any(|(glass, _)| *glass == name) {
            recipe.finish(&Place::preset(name))?;
        }
        Ok(recipe)
    }

    /// A preset scaled to a severity from 1 (mild) to 5 (severe); 3 is the preset itself. Each
    /// preset file says which physical parameters that sets.
    ///
    /// # Errors
    /// [`RecipeError::UnknownPreset`], [`RecipeError::Severity`].
    pub fn preset_at(name: &str, severity: u8) -> Result<Self, RecipeError> {
        let place = Place::preset(name);
        let preset = Preset::named(name)?;
        let mut recipe = Self::of(preset.table.clone());
        for (key, value) in preset.at(severity)? {
            recipe.edit(&place, key, value)?;
        }
        recipe.finish(&place)?;
        Ok(recipe)
    }

    /// A recipe from TOML text; `name` stands for it in messages. What it leaves out comes from
    /// `windshield-star` (without its long crack and its reach), or from `paper` where `fracture.model = "paper"`; its optics from
    /// `paper` where `optics.model = "paper"`; a pane of another kind from the preset that has one.
    /// If the text has `[[impact]]` tables, they replace the preset's.
    ///
    /// # Errors
    /// [`RecipeError`] in one line: syntax with line and column, an unknown key with the nearest
    /// known one, a key of the other model, a value of the wrong type or out of range.
    pub fn parse(name: &str, text: &str) -> Result<Self, RecipeError> {
        let place = Place::file(name);
        if text.len() > MAX_RECIPE_BYTES {
            return Err(RecipeError::TooLong { place });
        }
        let table = parse_table(&place, text)?;
        Self::of_table(place, table)
    }

    /// A recipe from tables, as [`Recipe::parse`]; `schema` may be left out.
    ///
    /// # Errors
    /// [`RecipeError`] as for [`Recipe::parse`], [`RecipeError::NotTables`] for a value that TOML
    /// does not have.
    pub fn from_json(name: &str, tables: &serde_json::Value) -> Result<Self, RecipeError> {
        let place = Place::file(name);
        let mut table = Table::try_from(tables).map_err(|cause| RecipeError::NotTables {
            place: place.clone(),
            what: printable(&cause.to_string()),
        })?;
        table.entry("schema").or_insert(SCHEMA_VERSION.into());
        Self::of_table(place, table)
    }

    fn of(table: Table) -> Self {
        Self {
            table,
            max_memory_bytes: DEFAULT_MAX_MEMORY_BYTES,
        }
    }

    /// Sets the most memory that one picture may take, bytes, in place of
    /// [`DEFAULT_MAX_MEMORY_BYTES`]; from [`LEAST_MAX_MEMORY_BYTES`] on
    /// it makes sense. It decides what is refused, and nothing of what is made.
    pub fn set_max_memory(&mut self, bytes: u64) {
        self.max_memory_bytes = bytes;
    }

    fn of_table(place: Place, table: Table) -> Result<Self, RecipeError> {
        let mut recipe = Self::of(table);
        match recipe.table.get("schema") {
            None => return Err(RecipeError::NoSchema { place }),
            Some(Value::Integer(SCHEMA_VERSION)) => {}
            Some(other) => {
                return Err(RecipeError::Schema {
                    place,
                    found: printable(&other.to_string()),
                });
            }
        }
        recipe.finish(&place)?;
        Ok(recipe)
    }

    /// Overrides one key: `table.key=value`, `impact.key=value` for every impact, or
    /// `impact.0.key=value` for one. The value is TOML, or else a string.
    ///
    /// `fracture.model=…` and `optics.model=…` drop the keys that only the old model has and fill
    /// in those of the new one; `glass.kind=…` does the same with the keys that only some kinds
    /// have.
    ///
    /// # Errors
    /// [`RecipeError`] as for [`Recipe::parse`]; the recipe is then unchanged.
    pub fn set(&mut self, assignment: &str) -> Result<(), RecipeError> {
        self.assign(&Assignment::parse(assignment)?)
    }

    fn assign(&mut self, assignment: &Assignment) -> Result<(), RecipeError> {
        let Assignment { place, key, value } = assignment;
        let mut changed = self.clone();
        changed.edit(place, key, value.clone())?;
        changed.finish(place)?;
        *self = changed;
        Ok(())
    }

    /// Lays a named camera over the recipe: what it sets of `[camera]` and `[glass]`. Keys that the
    /// recipe's models do not have are left out.
    ///
    /// # Errors
    /// [`RecipeError::UnknownCamera`] with the names that exist, or as for [`Recipe::set`]; the
    /// recipe is then unchanged.
    pub fn set_camera(&mut self, name: &str) -> Result<(), RecipeError> {
        let overlay = cameras::overlay(name)?;
        let place = Place::camera(name);
        let choice = self.choice(&place)?;
        let mut changed = self.clone();
        // Where nothing lies on a pane there is none.
        let has_pane = choice.fracture != ModelWord::None || self.table.contains_key("glass");
        for (table, key, value) in overlay {
            if schema::has(choice, &table, &key) && (has_pane || table != "glass") {
                changed.edit(&place, &format!("{table}.{key}"), value)?;
            }
        }
        changed.finish(&place)?;
        *self = changed;
        Ok(())
    }

    /// Lays a camera over the recipe, if one is named, then sets single keys in their order, each as
    /// [`Recipe::set`]; models are set before the camera, which sets only what they have.
    ///
    /// # Errors
    /// As for [`Recipe::set_camera`] and [`Recipe::set`].
    pub fn adjust(
        &mut self,
        camera: Option<&str>,
        assignments: &[Assignment],
    ) -> Result<(), RecipeError> {
        let chooses_model =
            |it: &&Assignment| ["fracture.model", "optics.model"].contains(&it.key.as_str());
        if let Some(camera) = camera {
            for assignment in assignments.iter().filter(chooses_model) {
                self.assign(assignment)?;
            }
            self.set_camera(camera)?;
        }
        for assignment in assignments {
            self.assign(assignment)?;
        }
        Ok(())
    }

    /// Writes one value, which nothing has checked yet.
    fn edit(&mut self, place: &Place, key: &str, value: Value) -> Result<(), RecipeError> {
        let place = place.clone();
        match key.split('.').collect::<Vec<_>>().as_slice() {
            ["impact", index, key] => {
                let impacts = self.impacts();
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
                if self.impacts().is_empty() {
                    // Where nothing breaks; what checks the recipe says so.
                    let impact = Table::from_iter([((*key).to_owned(), value)]);
                    let impacts = Value::Array(vec![impact.into()]);
                    self.table.insert("impact".to_owned(), impacts);
                    return Ok(());
                }
                for impact in self.impacts() {
                    if let Value::Table(impact) = impact {
                        impact.insert((*key).to_owned(), value.clone());
                    }
                }
            }
            [name, key] => {
                let table = self.table.entry(*name);
                let Value::Table(table) = table.or_insert_with(|| Table::new().into()) else {
                    return Err(RecipeError::NotAnAssignment { place });
                };
                if (*name, *key) == ("glass", "kind") {
                    table.retain(|key, _| !KEYS_OF_KINDS.contains(&key));
                }
                // A cover is round: one override gives its diameter.
                let is_cover = table.get("kind").and_then(Value::as_str) == Some("cover");
                if *name == "glass" && is_cover && ["width_mm", "height_mm"].contains(key) {
                    table.insert("width_mm".to_owned(), value.clone());
                    table.insert("height_mm".to_owned(), value.clone());
                }
                table.insert((*key).to_owned(), value);
                if ["fracture", "optics"].contains(name) && *key == "model" {
                    let choice = self.choice(&place)?;
                    known_keys::retain(&mut self.table, choice);
                    let has_deposit = self.has_deposit();
                    if choice.fracture == ModelWord::None && !has_deposit {
                        self.table.remove("glass");
                    }
                }
            }
            _ => return Err(RecipeError::NotAnAssignment { place }),
        }
        Ok(())
    }

    /// Whether anything lies on the pane.
    fn has_deposit(&self) -> bool {
        let mut faults = FAULTS.iter();
        faults.any(|fault| fault.needs_pane() && self.table.contains_key(fault.table))
    }

    /// Every key exists, and what was left out comes from presets; then all values are in range.
    fn finish(&mut self, place: &Place) -> Result<(), RecipeError> {
        let choice = self.choice(place)?;
        known_keys::check(place, &self.table, choice)?;
        let mut complete = presets::base(choice)?;
        let default_impact = complete.get("impact").and_then(|impacts| impacts.get(0));
        let default_impact = default_impact.and_then(Value::as_table).cloned();
        if let Some(kind) = self.table.get("glass").and_then(|glass| glass.get("kind")) {
            let kind: KindWord = word(place, "glass.kind", kind)?;
            complete.insert("glass".to_owned(), presets::glass_of(kind)?.into());
        }
        let has_pane = self.table.contains_key("glass") || self.has_deposit();
        if has_pane
            && choice.fracture == ModelWord::None
            && schema::has(choice, "glass", "rake_deg")
        {
            complete.insert("glass".to_owned(), presets::whole_pane()?.into());
        }
        for name in self.table.keys() {
            if let Some(table) = presets::optional(name)? {
                complete.insert(name.clone(), table.into());
            }
        }
        merge(&mut complete, std::mem::take(&mut self.table));
        self.table = complete;
        for impact in self.impacts() {
            if let (Value::Table(impact), Some(default)) = (impact, &default_impact) {
                for (key, value) in default {
                    impact.entry(key.clone()).or_insert_with(|| value.clone());
                }
            }
        }
        self.settings_of(place)?;
        Ok(())
    }

    /// The models that the recipe names, which decide the rest. The physics goes with the physical
    /// optics and the paper's fracture with its optics, unless the recipe says otherwise.
    fn choice(&self, place: &Place) -> Result<Choice, RecipeError> {
        let model = |name: &str| self.table.get(name).and_then(|table| table.get("model"));
        let fracture = match model("fracture") {
            Some(model) => word(place, "fracture.model", model)?,
            None => ModelWord::Physics,
        };
        let optics = match (model("optics"), fracture) {
            (Some(model), _) => word(place, "optics.model", model)?,
            (None, ModelWord::Physics | ModelWord::None) => OpticsWord::Physical,
            (None, ModelWord::Paper) => OpticsWord::Paper,
        };
        Ok(Choice::new(fracture, optics))
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
        // A recipe that was checked names models that exist.
        let choice = self.choice(&Place::recipe());
        print::commented(&self.table, choice.unwrap_or(Choice::ALL[0]))
    }

    /// The complete recipe as plain TOML: the same text for the same recipe.
    #[must_use]
    pub fn to_toml(&self) -> String {
        print::plain(&self.table)
    }

    /// The complete recipe as JSON, with the names of its TOML.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        // Tables of finite numbers, strings and lists.
        let mut tables = serde_json::to_value(&self.table).unwrap_or_default();
        tables["schema"] = SCHEMA_VERSION.into();
        tables
    }

    fn settings_of(&self, place: &Place) -> Result<Settings, RecipeError> {
        let settings = settings::of(place, &self.table, self.choice(place)?)?;
        Ok(Settings {
            max_memory_bytes: self.max_memory_bytes,
            ..settings
        })
    }

    fn impacts(&mut self) -> &mut [Value] {
        match self.table.get_mut("impact") {
            Some(Value::Array(impacts)) => impacts,
            _ => &mut [],
        }
    }
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

/// One of the words that a key knows.
fn word<T: serde::de::DeserializeOwned>(
    place: &Place,
    key: &str,
    value: &Value,
) -> Result<T, RecipeError> {
    T::deserialize(value.clone()).map_err(|error| RecipeError::Type {
        place: place.clone(),
        key: key.to_owned(),
        what: printable(&in_plain_words(error.message())),
    })
}
