use serde::{Deserialize, Serialize};

use super::{Condition, FailureRow, PairedRow};

/// One detector under conditions that differ in nothing but their seed, taken together.
///
/// The cracked images of all seeds are one set, of which an image is a part once per seed; so an object
/// counts once for each seed in which it is in the region. Intervals draw images (or clusters) and seeds,
/// each on its own, as crossed factors (the pigeonhole bootstrap \[Owen2007\]), which errs on the wide
/// side where, as in sets of this program, a seed gives every image a pattern of its own. There is no p:
/// the same object behind several patterns is no independent pair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PooledSeeds {
    /// Name of the detector.
    pub detector: String,
    /// What was done to the glass; without a seed.
    pub condition: Condition,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// Clean against cracked in the region at the first τ, out of it, and everywhere: AP50 and AP75.
    #[serde(default)]
    pub paired: Vec<PairedRow>,
    /// What is lost in these places; the interval of the failure rate is the two-way one.
    #[serde(default)]
    pub rates: Vec<FailureRow>,
}
