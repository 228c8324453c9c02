//! Distributions that somebody else made: histograms in JSON, vectors in NumPy files.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::{Value, json};
use starbreak_dataset::{decode_array, read_bytes, read_text};
use starbreak_eval::divergence::{
    CompareSettings, DEFINITION, FeatureVectors, compare_vectors, measure_given,
};

use super::show;
use crate::failure::{Failure, SOME_FAILED};
use crate::screen::{Screen, path_text};

/// Longest file of histograms or vectors, bytes.
const MAX_BYTES: u64 = 1 << 31;

pub(super) fn histograms(file: &Path, screen: &Screen) -> Result<ExitCode, Failure> {
    let text = read_text(file, MAX_BYTES)?.text;
    let document: Value = serde_json::from_str(&text).map_err(|error| {
        Failure::wrong_input(format!(
            "{file:?} is not JSON: {error}; numbers are finite there"
        ))
    })?;
    let (answer, n_failed) = measure_given(&document)
        .map_err(|error| Failure::wrong_input(format!("{file:?}: {error}")))?;
    let lists = answer.as_object().into_iter().flatten();
    for (name, entries) in lists.filter_map(|(name, list)| Some((name, list.as_array()?))) {
        for (at, entry) in entries.iter().enumerate() {
            screen.say(&format!("{name}[{at}]: {}", line(entry)));
        }
    }
    screen.result(|| answer)?;
    if n_failed == 0 {
        return Ok(ExitCode::SUCCESS);
    }
    Err(Failure {
        message: format!("{n_failed} entries of {file:?} have no numbers; each says why"),
        code: SOME_FAILED,
    })
}

fn line(entry: &Value) -> String {
    let fields = entry.as_object().into_iter().flatten();
    let fields: Vec<String> = fields
        .map(|(key, value)| match value {
            Value::String(text) => format!("{key} {text}"),
            value => format!("{key} {value}"),
        })
        .collect();
    fields.join(", ")
}

pub(super) fn features(
    files: &[PathBuf],
    sigma: f64,
    settings: &CompareSettings,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    let [a, b] = files else {
        return Err(Failure::wrong_input("--features takes two files"));
    };
    let (vectors_a, vectors_b) = (vectors(a)?, vectors(b)?);
    let origin = format!("{} and {}", path_text(a), path_text(b));
    let compared = compare_vectors(&vectors_a, &vectors_b, &origin, sigma, [0, 1], settings)
        .map_err(|error| Failure::wrong_input(format!("{a:?} and {b:?}: {error}")))?;
    show::vectors(&compared, screen);
    screen.result(|| {
        json!({
            "definition": DEFINITION,
            "settings": settings,
            "activations": compared,
        })
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The rows of a two-dimensional array.
fn vectors(file: &Path) -> Result<FeatureVectors, Failure> {
    let bytes = read_bytes(file, MAX_BYTES)?;
    let array = decode_array(&path_text(file), &bytes)?;
    let [_, d] = array.shape[..] else {
        return Err(Failure::wrong_input(format!(
            "{file:?} has the shape {:?}; expected two sides, n vectors of d features",
            array.shape
        )));
    };
    FeatureVectors::new(d, array.values)
        .map_err(|error| Failure::wrong_input(format!("{file:?}: {error}")))
}
