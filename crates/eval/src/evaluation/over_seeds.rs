use serde::{Deserialize, Serialize};

use super::{Condition, FailureRow, PairedRow};

/// One detector under conditions that differ in nothing but their seed: the mean over the seeds.
///
/// An AP is the mean of the APs of the seeds, clean and cracked; ranking the images of all seeds
/// together would be another number, in which the scores of clean copies tie and those of cracked
/// ones interleave. A share of objects is that of the objects of all seeds, so that one counts once
/// for each seed in which it is in the region. Intervals and tests draw and exchange images (or
/// clusters) with all their seeds; they hold for other images behind other cracks of the same kind,
/// where, as in sets of this program, each image has cracks of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OverSeeds {
    /// Name of the detector.
    pub detector: String,
    /// What was done to the glass; without a seed.
    pub condition: Condition,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// Clean against cracked in the region at the first τ, out of it, and everywhere: AP50 and AP75.
    #[serde(default)]
    pub paired: Vec<PairedRow>,
    /// What is lost in these places.
    #[serde(default)]
    pub rates: Vec<FailureRow>,
}
