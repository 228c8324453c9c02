//! Measures of histograms, normal distributions and vectors that somebody else made.

use serde_json::{Map, Value, json};

use super::measures::{
    CMMD_SCALE, CMMD_SIGMA, FeatureVectors, Gaussian, frechet_squared, gaussian_kl,
    histogram_divergence, kernel_inception_distance, mmd_rbf_biased,
};
use crate::EvalError;

/// What one list of a document holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Histograms,
    Gaussians,
    Frechet,
    Vectors,
}

/// The lists of a document by their keys.
const LISTS: [(&str, Kind); 5] = [
    ("hist", Kind::Histograms),
    ("edge", Kind::Histograms),
    ("gauss", Kind::Gaussians),
    ("frechet", Kind::Frechet),
    ("mmd", Kind::Vectors),
];

/// The measures of given distributions: each list of a document, entry by entry, and how many
/// entries have an error in place of numbers.
///
/// A document is a list of `{p, q, alpha}`, or an object with any of the lists `hist` and `edge`
/// (`p`, `q`, `alpha`, 0.5 where it is left out), `gauss` and `frechet` (`m0`, `S0`, `m1`, `S1`), `mmd` (`X`, `Y`).
/// The answer has the same lists: of histograms `kl_pq`, `kl_qp`, `jeffreys`, `js`, `w1_bins`, `hellinger`,
/// `tv` (and `kl`, which is `kl_pq`, under `edge`), of normal distributions `kl`, `kl_rev`, under `frechet` `d2`, of
/// vectors `kid_unbiased` and `cmmd_biased_x1000`. What is infinite is the text `"inf"`. Under `edge`
/// an empty histogram has the `kl` `"error:empty"`.
///
/// # Errors
/// [`EvalError::NotComparable`] for a document without such a list.
pub fn measure_given(document: &Value) -> Result<(Value, usize), EvalError> {
    let refuse = |fact: &str| EvalError::NotComparable {
        fact: fact.to_owned(),
        way_out: "give a list of {p, q, alpha}, or an object with lists under hist, edge, gauss, frechet or mmd",
    };
    let mut n_failed = 0;
    let mut answer = |name: &str, kind: Kind, entries: &[Value]| -> Value {
        let answers = entries.iter().map(|entry| {
            measured(kind, name == "edge", entry).unwrap_or_else(|error| {
                n_failed += 1;
                failed(name, &error)
            })
        });
        Value::Array(answers.collect())
    };
    if let Value::Array(entries) = document {
        let answers = answer("hist", Kind::Histograms, entries);
        return Ok((
            json!({ "definition": super::DEFINITION, "hist": answers }),
            n_failed,
        ));
    }
    let lists = document
        .as_object()
        .ok_or_else(|| refuse("the file holds neither a list nor an object"))?;
    let mut answers = Map::new();
    answers.insert("definition".to_owned(), json!(super::DEFINITION));
    for (name, kind) in LISTS {
        if let Some(entries) = lists.get(name) {
            let entries = entries
                .as_array()
                .ok_or_else(|| refuse(&format!("{name:?} is not a list")))?;
            answers.insert(name.to_owned(), answer(name, kind, entries));
        }
    }
    if answers.len() == 1 {
        return Err(refuse("the object has none of the lists"));
    }
    Ok((Value::Object(answers), n_failed))
}

/// An entry without numbers.
fn failed(list: &str, error: &EvalError) -> Value {
    let mut entry = json!({ "error": error.to_string() });
    if list == "edge" {
        let short = match error {
            EvalError::HistogramEmpty { .. } => "error:empty",
            _ => "error",
        };
        entry["kl"] = json!(short);
    }
    entry
}

fn measured(kind: Kind, is_edge: bool, entry: &Value) -> Result<Value, EvalError> {
    let numbers = |key: &'static str| numbers(entry, key);
    match kind {
        Kind::Histograms => {
            let alpha = match entry.get("alpha") {
                None => 0.5,
                Some(alpha) => alpha.as_f64().ok_or_else(|| no_number("alpha"))?,
            };
            let d = histogram_divergence(&numbers("p")?, &numbers("q")?, alpha)?;
            let mut answer = json!({
                "alpha": alpha,
                "kl_pq": number(d.kl_pq),
                "kl_qp": number(d.kl_qp),
                "jeffreys": number(d.jeffreys),
                "js": d.js,
                "w1_bins": d.w1_bins,
                "hellinger": d.hellinger,
                "tv": d.tv,
            });
            if is_edge {
                answer["kl"] = number(d.kl_pq);
            }
            Ok(answer)
        }
        Kind::Gaussians | Kind::Frechet => {
            let (a, b) = (gaussian(entry, "m0", "S0")?, gaussian(entry, "m1", "S1")?);
            if kind == Kind::Frechet {
                return Ok(json!({ "d2": frechet_squared(&a, &b)? }));
            }
            Ok(json!({ "kl": gaussian_kl(&a, &b)?, "kl_rev": gaussian_kl(&b, &a)? }))
        }
        Kind::Vectors => {
            let (x, y) = (vectors(entry, "X")?, vectors(entry, "Y")?);
            let cmmd = mmd_rbf_biased(&x, &y, CMMD_SIGMA)? * CMMD_SCALE;
            Ok(json!({
                "kid_unbiased": kernel_inception_distance(&x, &y)?,
                "cmmd_biased_x1000": cmmd,
            }))
        }
    }
}

/// JSON has no infinity.
fn number(value: f64) -> Value {
    if value.is_infinite() {
        return json!("inf");
    }
    json!(value)
}

fn gaussian(
    entry: &Value,
    mean: &'static str,
    covariance: &'static str,
) -> Result<Gaussian, EvalError> {
    let (_, values) = rows(entry, covariance)?;
    Gaussian::new(numbers(entry, mean)?, values)
}

fn vectors(entry: &Value, key: &'static str) -> Result<FeatureVectors, EvalError> {
    let (d, values) = rows(entry, key)?;
    FeatureVectors::new(d, values)
}

fn numbers(entry: &Value, key: &'static str) -> Result<Vec<f64>, EvalError> {
    let list = entry.get(key).and_then(Value::as_array);
    list.and_then(|list| list.iter().map(Value::as_f64).collect())
        .ok_or_else(|| no_number(key))
}

/// Length of a row, and all rows one after the other.
fn rows(entry: &Value, key: &'static str) -> Result<(usize, Vec<f64>), EvalError> {
    let mut values = Vec::new();
    let mut length = None;
    let list = entry.get(key).and_then(Value::as_array);
    for row in list.ok_or_else(|| no_number(key))? {
        let row = row.as_array().ok_or_else(|| no_number(key))?;
        if *length.get_or_insert(row.len()) != row.len() {
            return Err(no_number(key));
        }
        for value in row {
            values.push(value.as_f64().ok_or_else(|| no_number(key))?);
        }
    }
    Ok((length.unwrap_or_default(), values))
}

fn no_number(key: &str) -> EvalError {
    EvalError::NotComparable {
        fact: format!(
            "an entry has no {key:?} made of numbers, or rows of different lengths there"
        ),
        way_out: "give numbers, of matrices a list of rows",
    }
}
