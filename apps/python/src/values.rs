//! Plain values: seeds, boxes, and JSON as Python has it.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use starbreak::Seed;

/// A seed, from anything that is a whole number to Python.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeedArg(pub(crate) Seed);

impl SeedArg {
    /// What is taken where none is given.
    pub(crate) const ZERO: Self = Self(Seed(0));
}

impl<'a, 'py> FromPyObject<'a, 'py> for SeedArg {
    type Error = PyErr;

    fn extract(seed: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match seed.extract::<u64>() {
            Ok(number) => Ok(Self(Seed(number))),
            Err(_) => Err(PyValueError::new_err(format!(
                "seed = {}; expected a whole number from 0 to {}",
                seed.repr()?,
                u64::MAX
            ))),
        }
    }
}

/// The seed of an item: of its name and number where it has a name, as the command has it, else
/// the seed itself.
pub(crate) fn seed_of(seed: SeedArg, name: Option<&str>, sample_index: u64) -> Seed {
    match name {
        Some(name) => seed.0.of_item(name, sample_index),
        None => seed.0,
    }
}

/// What `json.loads` makes of a value.
pub(crate) fn python_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?
        .call_method1("loads", (value.to_string(),))
}

/// What `json.dumps` makes of a Python value; scalars and arrays of NumPy are what `tolist` says.
pub(crate) fn json_text_of(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = value.py();
    let options = PyDict::new(py);
    options.set_item(
        "default",
        py.import("operator")?
            .call_method1("methodcaller", ("tolist",))?,
    )?;
    let text = py
        .import("json")?
        .call_method("dumps", (value,), Some(&options));
    let wrong =
        |cause: PyErr| PyValueError::new_err(format!("not a plain value: {}", cause.value(py)));
    text.map_err(wrong)?.extract()
}

/// As [`json_text_of`], read.
pub(crate) fn value_of(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let text = json_text_of(value)?;
    serde_json::from_str(&text)
        .map_err(|cause| PyValueError::new_err(format!("not a plain value: {cause}")))
}
