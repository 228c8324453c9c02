//! Seeds taken together: the two-way bootstrap against closed forms, and the pooled numbers against the
//! protocol's own on the same images written out.
#![expect(clippy::unwrap_used, reason = "a test")]

use starbreak_eval::failure::{Found, ObjectPair, Where, failure_table};
use starbreak_eval::resampling::{Plan, bootstrap, crossed_average_precision};
use starbreak_eval::{ImageMatches, MatchedDetection, MatchedObject, Outcome, average_precision};

/// A number in 0..1 from two counts, without a pattern.
fn hashed(a: u32, b: u32, salt: u32) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ salt;
    for shift in [16, 13, 16] {
        x ^= x >> shift;
        x = x.wrapping_mul(0xc2b2_ae35);
    }
    f64::from(x >> 8) / f64::from(1_u32 << 24)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let m = mean(values);
    mean(&values.iter().map(|v| (v - m).powi(2)).collect::<Vec<f64>>())
}

/// Variance of the pigeonhole bootstrap of the mean of a table of n rows and k columns, both drawn with
/// replacement: (σ²_cells + (k − 1) σ²_rows + (n − 1) σ²_columns) / (n k), σ²_rows that of the means of
/// rows and σ²_columns that of the means of columns, all without Bessel's correction [Owen2007, section 4].
fn pigeonhole_variance(table: &[Vec<f64>]) -> f64 {
    let (n, k) = (table.len(), table[0].len());
    let cells: Vec<f64> = table.iter().flatten().copied().collect();
    let rows: Vec<f64> = table.iter().map(|row| mean(row)).collect();
    let columns: Vec<f64> = (0..k)
        .map(|j| mean(&table.iter().map(|row| row[j]).collect::<Vec<f64>>()))
        .collect();
    (variance(&cells) + (k as f64 - 1.0) * variance(&rows) + (n as f64 - 1.0) * variance(&columns))
        / (n * k) as f64
}

#[test]
fn both_factors_give_the_variance_of_the_closed_form() {
    for (n, k, of_row, of_column) in [(40, 2, 1.0, 1.0), (30, 5, 0.2, 2.0), (50, 3, 2.0, 0.0)] {
        let table: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let cell =
                    |j| of_row * hashed(i, 0, 1) + of_column * hashed(j, 0, 2) + hashed(i, j, 3);
                (0..k).map(cell).collect()
            })
            .collect();
        let plan = Plan::of_images(n).with_patterns(k).with(20_000, 5, 0.95);
        let replicates = bootstrap(&plan, |weights| {
            let sum: f64 = table
                .iter()
                .zip(&weights.images)
                .flat_map(|(row, w)| {
                    row.iter()
                        .zip(&weights.patterns)
                        .map(move |(x, v)| (x, w * v))
                })
                .map(|(x, weight)| x * f64::from(weight))
                .sum();
            vec![Some(sum / f64::from(n * k))]
        })
        .unwrap();
        let values: Vec<f64> = replicates.values[0].iter().copied().flatten().collect();
        let (found, expected) = (variance(&values), pigeonhole_variance(&table));
        assert!(
            (found / expected - 1.0).abs() < 0.04,
            "{n} x {k}: {found} against {expected}"
        );
    }
}

/// One object per image, found clean by all; lost where `is_lost` says, which differs by pattern.
fn pairs(n: u32, k: u32, is_lost: impl Fn(u32, u32) -> bool) -> Vec<ObjectPair> {
    let found = Found {
        detection: 0,
        score: 0.9,
        iou: 0.8,
    };
    let pair = |pattern: u32, image: u32| ObjectPair {
        object: image,
        image,
        category: 0,
        pattern,
        coverage: 0.5,
        clean: Some(found),
        cracked: (!is_lost(image, pattern)).then_some(found),
    };
    (0..k)
        .flat_map(|pattern| (0..n).map(move |image| pair(pattern, image)))
        .collect()
}

/// The rate of failure is linear where each image has as many objects found clean, so that its interval
/// has the width of the closed form; drawing images alone gives one that is too narrow.
#[test]
fn the_interval_of_a_failure_rate_knows_that_patterns_differ() {
    let (n, k) = (200, 4);
    let share = |pattern: u32| [0.1, 0.5, 0.2, 0.6][pattern as usize];
    let is_lost = |image: u32, pattern: u32| hashed(image, pattern, 9) < share(pattern);
    let table: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..k).map(|j| f64::from(u8::from(is_lost(i, j)))).collect())
        .collect();
    let plan = Plan::of_images(n).with_patterns(k).with(8000, 3, 0.95);
    let rows = failure_table(&pairs(n, k, is_lost), &[Where::Image], 0.95, Some(&plan)).unwrap();
    let rate = rows[0].failure_rate_over_images.as_ref().unwrap();
    let interval = rate.interval.as_ref().unwrap();
    let expected = 2.0 * 1.96 * pigeonhole_variance(&table).sqrt();
    let found = interval.high - interval.low;
    assert!((found / expected - 1.0).abs() < 0.08, "{found} {expected}");
    let rows_only: Vec<f64> = table.iter().map(|row| mean(row)).collect();
    let images_only = 2.0 * 1.96 * (variance(&rows_only) / f64::from(n)).sqrt();
    assert!(found > 2.0 * images_only, "{found} against {images_only}");
}

/// One image of a pattern: two objects, three detections.
fn image(image: u32, pattern: u32, side: u32) -> ImageMatches {
    let detection = |k: u32| MatchedDetection {
        detection: k,
        score: hashed(image * 8 + k, pattern * 2 + side, 17),
        outcome: match hashed(image * 8 + k, pattern * 2 + side, 23) > 0.35 && k < 2 {
            true => Outcome::TruePositive {
                object: image * 2 + k,
                iou: 0.7,
            },
            false => Outcome::FalsePositive,
        },
    };
    let mut detections: Vec<MatchedDetection> = (0..3).map(detection).collect();
    detections.sort_by(|a, b| b.score.total_cmp(&a.score));
    let object = |k: u32| MatchedObject {
        object: image * 2 + k,
        // Each pattern has a region of its own.
        is_ignored: k == 1 && (image + pattern).is_multiple_of(3),
        detection: None,
    };
    ImageMatches {
        image,
        category: 0,
        detections,
        objects: (0..2).map(object).collect(),
    }
}

#[test]
fn pooled_precision_is_that_of_all_images_in_one_set() {
    let (n, k) = (25, 3);
    let side = |side: u32| -> Vec<Vec<ImageMatches>> {
        (0..k)
            .map(|pattern| (0..n).map(|i| image(i, pattern, side)).collect())
            .collect()
    };
    let (clean, cracked) = (side(0), side(1));
    let plan = Plan::of_images(n).with_patterns(k).with(50, 1, 0.95);
    let found = crossed_average_precision(
        &clean.iter().map(Vec::as_slice).collect::<Vec<_>>(),
        &cracked.iter().map(Vec::as_slice).collect::<Vec<_>>(),
        1,
        &plan,
    )
    .unwrap();
    for (sets, found) in [(&clean, &found.mean.clean), (&cracked, &found.mean.cracked)] {
        // The same images written out as one set of n·k.
        let all: Vec<ImageMatches> = sets
            .iter()
            .zip(0_u32..)
            .flat_map(|(set, pattern)| {
                set.iter().map(move |one| ImageMatches {
                    image: one.image * k + pattern,
                    ..one.clone()
                })
            })
            .collect();
        let expected = average_precision(&all, &vec![1; all.len()]).unwrap();
        assert!(
            (found.value.unwrap() - expected).abs() < 1e-15,
            "{found:?} {expected}"
        );
    }
    let fewer = crossed_average_precision(&[&clean[0]], &[&cracked[0]], 1, &plan);
    assert!(fewer.is_err(), "one pattern of three");
}
