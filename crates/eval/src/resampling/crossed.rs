//! Average precision over several crack patterns per image, each with a region of its own.

use super::paired::{
    MeanOfPairs, N_VALUES, PairedPrecision, PairedPrecisions, cell_weights, four_values, rank,
};
use super::{Plan, bootstrap};
use crate::EvalError;
use crate::matching::ImageMatches;
use crate::statistic::{Method, TestOutcome};

/// Average precision per category over all patterns, clean and cracked, with two-way bootstrap intervals
/// of both, of their difference and of their ratio: images (or clusters) and patterns are drawn each on
/// their own, and an image behind a pattern weighs the product \[Owen2007\].
///
/// As [`paired_average_precision`](super::paired_average_precision), but the clean images are matched once
/// per pattern, too: in a region, what counts in them depends on the pattern. The images behind all
/// patterns make one ranking. There is no permutation test: clean and cracked are exchanged within a
/// pattern, and the clean images of two patterns are the same images.
///
/// # Errors
/// If the plan does not fit: another number of patterns, an image beyond its images; or if it has no
/// replicates or no proper level.
pub fn crossed_average_precision(
    clean: &[&[ImageMatches]],
    cracked: &[&[ImageMatches]],
    n_categories: usize,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    plan.check()?;
    let n_patterns = plan.n_patterns();
    for versions in [clean, cracked] {
        if versions.len() != n_patterns as usize {
            return Err(EvalError::StatisticLength {
                what: "sets of matches",
                found: versions.len(),
                expected: n_patterns as usize,
                of: "patterns of the plan",
            });
        }
        let images = versions.iter().copied().flatten().map(|it| it.image);
        let n_needed = images.max().map_or(0, |image| image as usize + 1);
        if n_needed > plan.n_images() {
            return Err(EvalError::StatisticLength {
                what: "images with matches",
                found: n_needed,
                expected: plan.n_images(),
                of: "images of the plan",
            });
        }
    }
    // A cell and one bit more must fit 32 bits.
    if plan.n_images().saturating_mul(n_patterns as usize) >= 1 << 31 {
        return Err(EvalError::StatisticSetting {
            what: "images times patterns",
            value: plan.n_images() as f64 * f64::from(n_patterns),
            range: "below 2^31",
        });
    }
    let clean_ranked = rank(clean, n_categories, n_patterns);
    let cracked_ranked = rank(cracked, n_categories, n_patterns);
    let replicates = bootstrap(plan, |weights| {
        let cells = cell_weights(&weights.images, &weights.patterns);
        let mut values = Vec::with_capacity((n_categories + 1) * N_VALUES);
        let mut sums = MeanOfPairs::default();
        for (clean, cracked) in clean_ranked.iter().zip(&cracked_ranked) {
            let pair = clean
                .average_precision(&cells)
                .zip(cracked.average_precision(&cells));
            sums.add(pair);
            values.extend(four_values(pair));
        }
        values.extend(four_values(sums.mean()));
        values
    })?;
    let ones = vec![1; plan.n_images() * n_patterns as usize];
    let row = |place: usize, category: Option<u32>, n_objects: u64| PairedPrecision {
        category,
        n_objects,
        clean: replicates.basic(place * N_VALUES, Method::AveragePrecision, [0.0, 1.0]),
        cracked: replicates.basic(place * N_VALUES + 1, Method::AveragePrecision, [0.0, 1.0]),
        difference: replicates.basic(place * N_VALUES + 2, Method::Difference, [-1.0, 1.0]),
        ratio: replicates.percentile(place * N_VALUES + 3, Method::Ratio),
        test: TestOutcome::none(
            u64::from(plan.n_units()),
            Method::PermutationSampled,
            "there is no test over several patterns",
        ),
        p_holm: None,
    };
    let categories: Vec<PairedPrecision> = clean_ranked
        .iter()
        .enumerate()
        .map(|(place, ranked)| row(place, Some(ranked.category()), ranked.n_objects(&ones)))
        .collect();
    let n_objects = categories.iter().map(|it| it.n_objects).sum();
    let mean = row(n_categories, None, n_objects);
    Ok(PairedPrecisions {
        categories,
        mean,
        n_replicates: plan.n_replicates,
        seed: plan.seed,
    })
}
