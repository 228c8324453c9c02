//! Measures against those of SciPy and NumPy.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use serde_json::Value;
use starbreak_eval::divergence::measure_given;

/// The numbers of NumPy and SciPy.
fn numbers() -> Value {
    common::json(&common::reference("kl_ref.json"))
}

#[test]
fn every_number_of_the_reference_comes_out() {
    let reference = numbers();
    let (answer, n_failed) = measure_given(&reference).unwrap();
    assert_eq!(n_failed, 1, "the empty histogram");
    let mut n_compared = 0;
    for (list, keys, tolerance) in [
        (
            "hist",
            &[
                "kl_pq",
                "kl_qp",
                "jeffreys",
                "js",
                "w1_bins",
                "hellinger",
                "tv",
            ][..],
            1e-12,
        ),
        ("gauss", &["kl", "kl_rev"], 1e-12),
        ("frechet", &["d2"], 1e-8),
        ("mmd", &["kid_unbiased", "cmmd_biased_x1000"], 1e-12),
    ] {
        let entries = reference[list].as_array().unwrap();
        for (at, expected) in entries.iter().enumerate() {
            for key in keys {
                let (expected, got) = (&expected[key], &answer[list][at][key]);
                let (expected, got) = (expected.as_f64().unwrap(), got.as_f64().unwrap());
                let error = (got - expected).abs() / expected.abs();
                assert!(
                    error <= tolerance,
                    "{list}[{at}].{key}: {got} for {expected}, off by {error:e}"
                );
                n_compared += 1;
            }
        }
    }
    assert_eq!(n_compared, 16 * 7 + 5 * 2 + 4 + 3 * 2, "all of them");
}

#[test]
fn the_edges_are_as_the_reference_says() {
    let reference = numbers();
    let (answer, _) = measure_given(&reference).unwrap();
    for (at, expected) in reference["edge"].as_array().unwrap().iter().enumerate() {
        let (expected, got) = (&expected["kl"], &answer["edge"][at]["kl"]);
        match (expected.as_f64(), got.as_f64()) {
            (Some(expected), Some(got)) => {
                assert!((got - expected).abs() < 1e-15, "edge {at}: {got}");
            }
            _ => assert_eq!(got, expected, "edge {at}"),
        }
    }
}
