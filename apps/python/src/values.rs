//! Plain values: JSON as Python has it, and what a recipe is made of.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use serde_json::{Map, Value};

use crate::arguments::shown;

/// How deep lists and dicts of a recipe lie in each other at most; a recipe needs three.
const MAX_DEPTH: usize = 16;

/// How many values a recipe has at most, of lists and dicts that occur twice each time.
const MAX_VALUES: usize = 100_000;

/// What `json.loads` makes of a value.
pub(crate) fn python_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?
        .call_method1("loads", (value.to_string(),))
}

/// A value of a recipe, whose dotted key is for messages: a number, a bool, text, a list or a dict
/// of these; scalars and arrays of NumPy are what `tolist` says.
pub(crate) fn value_of(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    value_at(key, value, MAX_DEPTH, &mut 0)
}

fn value_at(
    key: &str,
    value: &Bound<'_, PyAny>,
    depth: usize,
    n_values: &mut usize,
) -> PyResult<Value> {
    *n_values += 1;
    if *n_values > MAX_VALUES {
        let said = format!("{key}: the recipe has more than {MAX_VALUES} values by then");
        return Err(PyValueError::new_err(said));
    }
    let wrong = |expected: &str| {
        let said = format!("{key} = {}; expected {expected}", shown(value));
        PyValueError::new_err(said)
    };
    let Some(depth) = depth.checked_sub(1) else {
        let said = format!("{key}: lists and dicts lie in each other more than {MAX_DEPTH} deep");
        return Err(PyValueError::new_err(said));
    };
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_str()?.into());
    }
    if value.is_instance_of::<PyInt>() {
        let number = value.extract::<i64>();
        return number
            .map(Value::from)
            .map_err(|_| wrong("a number of at most 64 bits"));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        let number = serde_json::Number::from_f64(number.value());
        return number
            .map(Value::Number)
            .ok_or_else(|| wrong("a finite number"));
    }
    if let Ok(table) = value.cast::<PyMapping>() {
        return table_at(key, table, depth, n_values);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        // An iterator of one's own may go on for ever.
        let entries = value.try_iter()?.take(value.len()?).enumerate();
        let entries = entries
            .map(|(idx, entry)| value_at(&format!("{key}[{idx}]"), &entry?, depth, n_values));
        return Ok(Value::Array(entries.collect::<PyResult<_>>()?));
    }
    match value.getattr_opt("tolist")? {
        Some(tolist) => value_at(key, &tolist.call0()?, depth, n_values),
        None if value.is_none() => Err(wrong("a value; leave the key out for that of the preset")),
        None => Err(wrong(
            "a number, true or false, text, or a list or dict of these",
        )),
    }
}

fn table_at(
    key: &str,
    table: &Bound<'_, PyMapping>,
    depth: usize,
    n_values: &mut usize,
) -> PyResult<Value> {
    let mut values = Map::new();
    for entry in table.items()?.iter() {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = entry.extract()?;
        let Ok(name) = name.extract::<String>() else {
            let place = if key.is_empty() { "the recipe" } else { key };
            return Err(PyValueError::new_err(format!(
                "{place} has the key {}; expected text",
                shown(&name)
            )));
        };
        let key = match key.is_empty() {
            true => name.clone(),
            false => format!("{key}.{name}"),
        };
        values.insert(name, value_at(&key, &value, depth, n_values)?);
    }
    Ok(Value::Object(values))
}
