//! Average precision of clean and cracked images with all that is known about its difference.

use serde::{Deserialize, Serialize};

use super::{DrawnPrecisions, Plan};
use crate::EvalError;
use crate::matching::ImageMatches;
use crate::statistic::{Measured, TestOutcome};

/// Average precision of one category, or the mean over categories, clean and cracked; of several
/// seeds the mean over them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedPrecision {
    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories); `None` for
    /// the mean over those that have objects.
    pub category: Option<u32>,
    /// In the clean images, 0 to 1. The n of all three are the units drawn: images or clusters.
    pub clean: Measured,
    /// In the cracked images.
    pub cracked: Measured,
    /// Cracked minus clean.
    pub difference: Measured,
    /// Permutation test of the difference.
    pub test: TestOutcome,
}

/// All categories and their mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedPrecisions {
    /// One per category, in the order of the label set.
    pub categories: Vec<PairedPrecision>,
    /// The mean over categories with objects.
    pub mean: PairedPrecision,
    /// How often images were drawn.
    pub n_replicates: u32,
    /// From which seed.
    pub seed: u64,
}

/// Average precision per category, clean and cracked, with intervals of both and of their
/// difference from the bootstrap, and a permutation test per category.
///
/// Of each seed of the cracks, `clean` are the matches of the clean images and `cracked` those of
/// the same images behind the cracks, all by the same rule; in a region, what counts in the clean
/// images depends on the seed, too. A value is the mean over the seeds: ranking the images of all
/// seeds together gives another number, since the scores of clean copies tie and those of cracked
/// ones interleave. Images are drawn, and exchanged, with all their seeds.
///
/// Replicates use the matches as they are, which is exact: matching never crosses images.
/// The interval of a difference reaches as far as permutations do from 0, so that it and the test say the same
/// ([`Permuted`](super::Permuted)). Those of either side are [`expanded`](super::expanded_interval): of a class by the
/// units that its objects lie in, of the mean over classes by all units and the harmonic mean of the
/// classes' own, since drawn images are fewer; and lower by what AP of few images leans to above, as halves of
/// the images tell.
///
/// # Errors
/// If both sides have not as many seeds, or none; if an image is beyond those of the plan, or the
/// plan has no replicates or no proper level.
pub fn paired_average_precision(
    clean: &[&[ImageMatches]],
    cracked: &[&[ImageMatches]],
    n_categories: usize,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    let wrong = EvalError::StatisticLength {
        what: "sets of damaged matches",
        found: cracked.len(),
        expected: clean.len().max(1),
        of: "sets of clean matches",
    };
    if clean.len() != cracked.len() {
        return Err(wrong);
    }
    let mut all: Option<DrawnPrecisions> = None;
    for (clean, cracked) in clean.iter().zip(cracked) {
        let one = DrawnPrecisions::of_matches(clean, cracked, n_categories, plan)?;
        match &mut all {
            Some(all) => all.add(&one)?,
            None => all = Some(one),
        }
    }
    all.ok_or(wrong)?.measured(plan)
}
