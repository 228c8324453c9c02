//! `Recipe`: all parameters of a run.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyString};
use starbreak::{Assignment, DEFAULT_PRESET, LEAST_MAX_MEMORY_BYTES, Settings};
use starbreak_runs::dataset::{read_text, sha256_hex};

use crate::arguments::{Given, List, NameArg, Whole, shown};
use crate::errors::{of_recipe, raised};
use crate::values::{python_of, value_of};

/// Longest recipe file, bytes.
const MAX_RECIPE_FILE_BYTES: u64 = 1 << 20;

/// All parameters of a run, complete and checked. Immutable.
///
/// preset: name of a preset, see `presets`.
/// severity: 1 (mild) to 5 (severe); 3 is the preset itself.
/// camera: name of a camera to apply, see `cameras`. It sets those of its keys that the models of
/// the recipe have; for the preset `paper` that is only `camera.f_px`.
/// set: keys to change, as {"table.key": value} or ["table.key=value"]; `impact.key` sets the key
/// in every impact, `impact.0.key` in one.
/// max_memory: limit of the memory that one picture may take, bytes, at least 64 << 20; default 4
/// GiB. A picture that would take more raises `ValueError` before the work. The limit is not part
/// of the recipe's text.
///
/// Raises `ValueError` for a name, key or value that does not exist; for `set` the message begins
/// with the key, followed by the message of the command.
///
/// >>> import starbreak
/// >>> recipe = starbreak.Recipe("windshield-star", set={"impact.speed_m_s": 25.0})
/// >>> recipe.to_dict()["impact"][0]["speed_m_s"]
/// 25.0
/// >>> starbreak.Recipe(set={"camera.fnumber": 2.0})
/// Traceback (most recent call last):
/// ValueError: set["camera.fnumber"]: unknown key `camera.fnumber`; did you mean `camera.f_number`?
#[pyclass(frozen, eq, module = "starbreak")]
#[derive(Debug, Clone)]
pub(crate) struct Recipe {
    recipe: starbreak::Recipe,
    settings: Arc<Settings>,
}

impl PartialEq for Recipe {
    fn eq(&self, other: &Self) -> bool {
        self.recipe == other.recipe
    }
}

impl Recipe {
    pub(crate) fn of(recipe: starbreak::Recipe) -> PyResult<Self> {
        let settings = recipe.settings().map_err(|error| of_recipe(&error))?;
        Ok(Self {
            recipe,
            settings: Arc::new(settings),
        })
    }

    pub(crate) fn recipe(&self) -> &starbreak::Recipe {
        &self.recipe
    }

    pub(crate) fn settings(&self) -> Arc<Settings> {
        Arc::clone(&self.settings)
    }

    /// A preset, at a severity if one is given.
    pub(crate) fn named(preset: &str, severity: Option<&Whole>) -> PyResult<Self> {
        let recipe = match severity {
            Some(severity) => {
                starbreak::Recipe::preset_at(preset, severity.within("severity", 1..=5)?)
            }
            None => starbreak::Recipe::preset(preset),
        };
        Self::of(recipe.map_err(|error| of_recipe(&error))?)
    }

    fn adjusted(
        mut recipe: starbreak::Recipe,
        camera: Option<Given<String>>,
        set: Option<&Bound<'_, PyAny>>,
        max_memory: Option<&Whole>,
    ) -> PyResult<Self> {
        if let Some(max_memory) = max_memory {
            recipe.set_max_memory(
                max_memory.within("max_memory", LEAST_MAX_MEMORY_BYTES..=u64::MAX)?,
            );
        }
        let camera = Given::if_given(camera, "camera")?;
        let assignments = set.map(assignments).transpose()?.unwrap_or_default();
        recipe
            .adjust(camera.as_deref(), &assignments)
            .map_err(|error| of_recipe(&error))?;
        Self::of(recipe)
    }
}

#[pymethods]
impl Recipe {
    #[new]
    #[pyo3(
    signature = (preset = Given::of(DEFAULT_PRESET.to_owned()), *, severity = None, camera = None, set = None, max_memory = None),
    text_signature = "(preset='windshield-spiderweb', *, severity=None, camera=None, set=None, max_memory=None)"
)]
    fn new(
        preset: Given<String>,
        severity: Option<Whole>,
        camera: Option<Given<String>>,
        set: Option<&Bound<'_, PyAny>>,
        max_memory: Option<Whole>,
    ) -> PyResult<Self> {
        let base = Self::named(&preset.named("preset")?, severity.as_ref())?;
        Self::adjusted(base.recipe, camera, set, max_memory.as_ref())
    }

    /// A recipe from TOML text, as in a recipe file. Keys that are left out come from a preset.
    /// `name` names the text in error messages.
    ///
    /// >>> import starbreak
    /// >>> recipe = starbreak.Recipe.from_toml("schema = 1\n[camera]\nf_px = 1900.0")
    /// >>> starbreak.Recipe.from_toml(recipe.to_toml()) == recipe
    /// True
    #[staticmethod]
    #[pyo3(
    signature = (text, *, name = None),
    text_signature = "(text, *, name='recipe')"
)]
    fn from_toml(text: Given<String>, name: Option<NameArg>) -> PyResult<Self> {
        let text = text.named("text")?;
        let name = name.as_ref().map_or("recipe", |name| &name.0);
        Self::of(starbreak::Recipe::parse(name, &text).map_err(|error| of_recipe(&error))?)
    }

    /// A recipe from a TOML file. Raises `OSError` if it cannot be read.
    #[staticmethod]
    fn from_file(path: Given<PathBuf>) -> PyResult<Self> {
        let path = path.named("path")?;
        let file =
            read_text(&path, MAX_RECIPE_FILE_BYTES).map_err(|error| raised(&error.into()))?;
        let name = NameArg(path.to_string_lossy().into_owned());
        Self::from_toml(Given::of(file.text), Some(name))
    }

    /// A recipe from its tables as dicts. Keys that are left out come from the preset
    /// `windshield-star` (without its long crack and `fracture.until_reach_mm`), or from `paper` if
    /// the tables say `fracture.model = "paper"`.
    ///
    /// >>> import starbreak
    /// >>> recipe = starbreak.Recipe.from_dict({"camera": {"f_px": 1900.0}})
    /// >>> recipe.to_dict()["camera"]["f_px"], recipe.to_dict()["glass"]["thickness_mm"]
    /// (1900.0, 2.1)
    #[staticmethod]
    fn from_dict(py: Python<'_>, tables: Given<Py<PyMapping>>) -> PyResult<Self> {
        let value = value_of("", tables.named("tables")?.bind(py).as_any())?;
        Self::of(starbreak::Recipe::from_json("recipe", &value).map_err(|error| of_recipe(&error))?)
    }

    /// A copy of the recipe with some keys changed; `set`, `camera` and `max_memory` as in the
    /// constructor.
    ///
    /// >>> import starbreak
    /// >>> starbreak.Recipe().replace({"fracture.mesh": "fast"}).to_dict()["fracture"]["mesh"]
    /// 'fast'
    #[pyo3(signature = (set = None, *, camera = None, max_memory = None))]
    fn replace(
        &self,
        set: Option<&Bound<'_, PyAny>>,
        camera: Option<Given<String>>,
        max_memory: Option<Whole>,
    ) -> PyResult<Self> {
        Self::adjusted(self.recipe.clone(), camera, set, max_memory.as_ref())
    }

    /// The complete recipe as TOML, with comments if asked for. Equal recipes give equal text.
    #[pyo3(
    signature = (*, comments = Given::of(false)),
    text_signature = "($self, *, comments=False)"
)]
    fn to_toml(&self, comments: Given<bool>) -> PyResult<String> {
        Ok(match comments.named("comments")? {
            true => self.recipe.to_commented_toml(),
            false => self.recipe.to_toml(),
        })
    }

    /// The complete recipe as dicts, with the names used in TOML.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.recipe.to_json())
    }

    /// SHA-256 of `to_toml()`, hexadecimal, by which records identify a recipe.
    #[getter]
    fn sha256(&self) -> String {
        sha256_hex(self.recipe.to_toml().as_bytes())
    }

    fn __repr__(&self) -> String {
        format!("<starbreak.Recipe {}>", &self.sha256()[..12])
    }

    fn __hash__(&self) -> u64 {
        u64::from_str_radix(&self.sha256()[..15], 16).unwrap_or(0)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, u64))> {
        let restored = py.get_type::<Self>().getattr("_restored")?;
        let max_memory = self.settings.max_memory_bytes;
        Ok((restored, (self.recipe.to_toml(), max_memory)))
    }

    /// The recipe of such a text and limit, for `pickle`.
    #[staticmethod]
    fn _restored(text: Given<String>, max_memory: Whole) -> PyResult<Self> {
        let recipe = Self::from_toml(text, None)?.recipe;
        Self::adjusted(recipe, None, None, Some(&max_memory))
    }
}

/// What is to be set, from a mapping of keys to values or from a list of texts `table.key=value`.
fn assignments(set: &Bound<'_, PyAny>) -> PyResult<Vec<Assignment>> {
    let Ok(mapping) = set.cast::<PyMapping>() else {
        let texts: List<String> = set.extract().map_err(|_| {
            PyTypeError::new_err(format!(
                "set = {}; expected a dict {{\"table.key\": value}} or a list [\"table.key=value\"]",
                shown(set)
            ))
        })?;
        let each = texts.0.iter().map(|text| Assignment::parse(text));
        return each
            .collect::<Result<_, _>>()
            .map_err(|error| of_recipe(&error));
    };
    let entry = |entry: Bound<'_, PyAny>| {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = entry.extract()?;
        let Ok(key) = key.extract::<String>() else {
            return Err(PyValueError::new_err(format!(
                "set has the key {}; expected text, such as \"impact.speed_m_s\"",
                shown(&key)
            )));
        };
        Assignment::of(&key, &value_of(&key, &value)?).map_err(|error| of_recipe(&error))
    };
    mapping.items()?.iter().map(entry).collect()
}

/// A recipe as an argument: itself, the name of a preset, or tables as dicts.
pub(crate) struct RecipeArg {
    pub(crate) recipe: Recipe,
    /// The preset's name, if that was given.
    preset: Option<String>,
}

impl RecipeArg {
    /// The recipe, or the default preset.
    pub(crate) fn or_default(recipe: Option<Self>) -> PyResult<Recipe> {
        match recipe {
            Some(Self { recipe, .. }) => Ok(recipe),
            None => Recipe::named(DEFAULT_PRESET, None),
        }
    }

    /// The same with a preset at a severity, if one is given.
    pub(crate) fn at_severity(recipe: Option<Self>, severity: Option<&Whole>) -> PyResult<Recipe> {
        let Some(severity) = severity else {
            return Self::or_default(recipe);
        };
        let preset = match &recipe {
            None => Some(DEFAULT_PRESET),
            Some(recipe) => recipe.preset.as_deref(),
        };
        match preset {
            Some(preset) => Recipe::named(preset, Some(severity)),
            None => Err(PyValueError::new_err(
                "severity scales a preset, but recipe says its values itself; give the name of a preset, or \
                 Recipe(preset, severity=…)",
            )),
        }
    }

    /// A recipe as it is.
    pub(crate) fn of(recipe: Recipe) -> Self {
        Self {
            recipe,
            preset: None,
        }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for RecipeArg {
    type Error = PyErr;

    fn extract(recipe: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(recipe) = recipe.cast::<Recipe>() {
            return Ok(Self::of(recipe.get().clone()));
        }
        if let Ok(name) = recipe.cast::<PyString>() {
            let preset = name.to_str()?.to_owned();
            return Ok(Self {
                recipe: Recipe::named(&preset, None)?,
                preset: Some(preset),
            });
        }
        if let Ok(tables) = recipe.cast::<PyDict>() {
            return Ok(Self::of(Recipe::from_dict(
                tables.py(),
                Given::of(tables.as_mapping().to_owned().unbind()),
            )?));
        }
        Err(PyTypeError::new_err(format!(
            "recipe = {}; expected a starbreak.Recipe, the name of a preset or a dict",
            shown(&recipe)
        )))
    }
}

/// The presets, as name and description.
///
/// >>> import starbreak
/// >>> starbreak.presets()["windshield-star"]
/// 'a sharp stone on a laminated windscreen: straight legs out of one point'
#[pyfunction]
pub(crate) fn presets(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, purpose) in starbreak::presets() {
        all.set_item(name, purpose)?;
    }
    Ok(all)
}

/// The cameras that a recipe can use, as name and description.
///
/// >>> import starbreak
/// >>> "kitti" in starbreak.cameras()
/// True
#[pyfunction]
pub(crate) fn cameras(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, purpose) in starbreak::cameras().map_err(|error| of_recipe(&error))? {
        all.set_item(name, purpose)?;
    }
    Ok(all)
}

/// The JSON Schema of recipes, which describes every key.
///
/// >>> import starbreak
/// >>> "camera" in starbreak.json_schema()["properties"]
/// True
#[pyfunction]
pub(crate) fn json_schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    python_of(py, &starbreak::json_schema())
}
