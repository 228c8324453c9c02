//! Measures against those of SciPy and NumPy, where the shared reference is at hand.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::PathBuf;

use serde_json::Value;
use starbreak_eval::divergence::measure_given;

/// What `gen_kl_ref.py` made, or none, said loudly.
fn reference() -> Option<Value> {
    let path: PathBuf = [
        env!("CARGO_MANIFEST_DIR"),
        "../../../shared/reference/eval/kl_ref.json",
    ]
    .iter()
    .collect();
    if !path.exists() {
        #[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
        {
            eprintln!("SKIPPED: {} is not there", path.display());
        }
        return None;
    }
    let text = std::fs::read_to_string(path).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

#[test]
fn every_number_of_the_reference_comes_out() {
    let Some(reference) = reference() else { return };
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
    let Some(reference) = reference() else { return };
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
