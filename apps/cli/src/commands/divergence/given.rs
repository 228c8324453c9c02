//! Distributions that somebody else made: histograms in JSON, vectors in NumPy files.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use starbreak_dataset::{decode_array, read_bytes, read_text};
use starbreak_eval::divergence::{
    DEFINITION, FeatureVectors, HistogramDivergence, compare_vectors, histogram_divergence,
};

use super::show;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::screen::{Screen, path_text};

/// Longest file of histograms or vectors, bytes.
const MAX_BYTES: u64 = 1 << 31;

/// A list of pairs, alone or under `hist`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Document {
    List(Vec<Value>),
    Named { hist: Vec<Value> },
}

#[derive(Deserialize)]
struct Pair {
    p: Vec<f64>,
    q: Vec<f64>,
    #[serde(default = "jeffreys_prior")]
    alpha: f64,
}

fn jeffreys_prior() -> f64 {
    0.5
}

/// What is said of a pair.
#[derive(Serialize)]
#[serde(untagged)]
enum Answer {
    Measured {
        alpha: f64,
        #[serde(flatten)]
        divergence: HistogramDivergence,
    },
    Failed {
        error: String,
    },
}

fn measured(pair: Value) -> Result<Answer, String> {
    let pair: Pair = serde_json::from_value(pair).map_err(|error| error.to_string())?;
    let divergence = histogram_divergence(&pair.p, &pair.q, pair.alpha);
    Ok(Answer::Measured {
        alpha: pair.alpha,
        divergence: divergence.map_err(|error| error.to_string())?,
    })
}

pub(super) fn histograms(file: &Path, screen: &Screen) -> Result<u8, Failure> {
    let text = read_text(file, MAX_BYTES)?.text;
    let value: Value = serde_json::from_str(&text).map_err(|error| {
        Failure::wrong_input(format!(
            "{file:?} is not JSON: {error}; numbers are finite there"
        ))
    })?;
    let (Document::List(pairs) | Document::Named { hist: pairs }) = serde_json::from_value(value)
        .map_err(|_| {
        Failure::wrong_input(format!(
            "{file:?} holds no histograms; give a list of {{p, q, alpha}}, or an object with one under hist"
        ))
    })?;
    let answers = pairs
        .into_iter()
        .map(|pair| measured(pair).unwrap_or_else(|error| Answer::Failed { error }));
    let answers: Vec<Answer> = answers.collect();
    for (at, answer) in answers.iter().enumerate() {
        screen.say(&match answer {
            Answer::Failed { error } => format!("hist[{at}]: error {error}"),
            Answer::Measured { alpha, divergence: d } => format!(
                "hist[{at}]: alpha {alpha}, kl_pq {}, kl_qp {}, jeffreys {}, js {}, w1_bins {}, hellinger {}, tv {}",
                d.kl_pq, d.kl_qp, d.jeffreys, d.js, d.w1_bins, d.hellinger, d.tv
            ),
        });
    }
    screen.result(|| json!({ "definition": DEFINITION, "hist": answers }))?;
    let is_failed = |answer: &&Answer| matches!(answer, Answer::Failed { .. });
    let n_failed = answers.iter().filter(is_failed).count();
    if n_failed == 0 {
        return Ok(DONE);
    }
    Err(Failure {
        message: format!("{n_failed} entries of {file:?} have no numbers; each says why"),
        code: SOME_FAILED,
    })
}

pub(super) fn features(files: &[PathBuf], screen: &Screen) -> Result<u8, Failure> {
    let [a, b] = files else {
        return Err(Failure::wrong_input("--features takes two files"));
    };
    let compared = compare_vectors(&vectors(a)?, &vectors(b)?)
        .map_err(|error| Failure::wrong_input(format!("{a:?} and {b:?}: {error}")))?;
    show::vectors(&compared, screen);
    screen.result(|| json!({ "definition": DEFINITION, "activations": compared }))?;
    Ok(DONE)
}

/// The rows of a two-dimensional array.
fn vectors(file: &Path) -> Result<FeatureVectors, Failure> {
    let name = path_text(file);
    let array = decode_array(&name, &read_bytes(file, MAX_BYTES)?)?;
    let [_, d] = array.shape[..] else {
        return Err(Failure::wrong_input(format!(
            "{file:?} has the shape {:?}; expected two sides, n vectors of d features",
            array.shape
        )));
    };
    FeatureVectors::new(&name, d, array.values)
        .map_err(|error| Failure::wrong_input(format!("{file:?}: {error}")))
}
