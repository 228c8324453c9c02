//! Average precision over several crack patterns per image, each with a region of its own.

use super::Plan;
use super::paired::{PairedPrecisions, check_cells, precisions_of_ranked, rank};
use crate::EvalError;
use crate::matching::ImageMatches;

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
        check_cells(versions, n_patterns as usize, plan)?;
    }
    precisions_of_ranked(
        &rank(clean, n_categories, n_patterns),
        &rank(cracked, n_categories, n_patterns),
        true,
        plan,
    )
}
