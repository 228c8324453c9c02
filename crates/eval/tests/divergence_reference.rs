//! Measures against those of SciPy and NumPy.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;

use serde_json::Value;
use starbreak_eval::EvalError;
use starbreak_eval::divergence::{
    FeatureVectors, HistogramDivergence, compare_vectors, histogram_divergence,
};

/// The entries of a list of the numbers of NumPy and SciPy.
fn entries(list: &str) -> Vec<Value> {
    let numbers = common::json(&common::reference("kl_ref.json"));
    numbers[list].as_array().unwrap().clone()
}

fn list(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(list).collect()
}

fn vectors(rows: &[Vec<f64>]) -> FeatureVectors {
    FeatureVectors::new("test", rows[0].len(), rows.concat()).unwrap()
}

fn divergence(entry: &Value) -> Result<HistogramDivergence, EvalError> {
    let alpha = entry["alpha"].as_f64().unwrap();
    histogram_divergence(&list(&entry["p"]), &list(&entry["q"]), alpha)
}

fn assert_near(got: f64, expected: &Value, tolerance: f64, what: &str) {
    let expected = expected.as_f64().unwrap();
    let error = (got - expected).abs() / expected.abs();
    assert!(
        error <= tolerance,
        "{what}: {got} for {expected}, off by {error:e}"
    );
}

#[test]
fn every_number_of_histograms_comes_out() {
    let entries = entries("hist");
    assert_eq!(entries.len(), 16, "all of them");
    for (at, entry) in entries.iter().enumerate() {
        let d = divergence(entry).unwrap();
        for (key, got) in [
            ("kl_pq", d.kl_pq),
            ("kl_qp", d.kl_qp),
            ("jeffreys", d.jeffreys),
            ("js", d.js),
            ("w1_bins", d.w1_bins),
            ("hellinger", d.hellinger),
            ("tv", d.tv),
        ] {
            assert_near(got, &entry[key], 1e-12, &format!("hist[{at}].{key}"));
        }
    }
}

#[test]
fn the_edges_are_as_the_reference_says() {
    for (at, entry) in entries("edge").iter().enumerate() {
        let got = divergence(entry).map(|d| d.kl_pq);
        match (&entry["kl"], got) {
            (Value::Number(expected), Ok(got)) => {
                let error = (got - expected.as_f64().unwrap()).abs();
                assert!(error < 1e-15, "edge {at}: {got}");
            }
            (kl, Ok(got)) => assert!(kl == "inf" && got.is_infinite(), "edge {at}: {got}"),
            (kl, Err(EvalError::HistogramEmpty { .. })) => {
                assert_eq!(kl, "error:empty", "edge {at}");
            }
            (_, Err(error)) => panic!("edge {at}: {error}"),
        }
    }
}

/// Vectors of this mean and this sample covariance: two on each column of its Cholesky factor.
fn vectors_of(mean: &[f64], covariance: &[Vec<f64>]) -> FeatureVectors {
    let d = mean.len();
    let mut factor = vec![vec![0.0; d]; d];
    for i in 0..d {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let left = covariance[i][j] - known;
            factor[i][j] = if i == j {
                left.sqrt()
            } else {
                left / factor[j][j]
            };
        }
    }
    let far = (f64::from(u32::try_from(2 * d - 1).unwrap()) / 2.0).sqrt();
    let row = |j: usize, side: f64| {
        (0..d)
            .map(|i| mean[i] + side * far * factor[i][j])
            .collect()
    };
    let all: Vec<Vec<f64>> = (0..d).flat_map(|j| [row(j, 1.0), row(j, -1.0)]).collect();
    vectors(&all)
}

#[test]
fn frechet_and_kernel_distances_come_out() {
    let of = |list: &str, n: usize| {
        let entries = entries(list);
        assert_eq!(entries.len(), n, "all of {list}");
        entries
    };
    for entry in of("frechet", 4) {
        let side = |mean: &str, of: &str| vectors_of(&list(&entry[mean]), &rows(&entry[of]));
        let compared = compare_vectors(&side("m0", "S0"), &side("m1", "S1")).unwrap();
        assert_near(compared.frechet, &entry["d2"], 1e-8, "frechet");
    }
    for entry in of("mmd", 3) {
        let (x, y) = (vectors(&rows(&entry["X"])), vectors(&rows(&entry["Y"])));
        let compared = compare_vectors(&x, &y).unwrap();
        assert_near(compared.kid, &entry["kid_unbiased"], 1e-12, "KID");
    }
}
