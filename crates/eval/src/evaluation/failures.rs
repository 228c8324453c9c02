use serde::{Deserialize, Serialize};

use super::{Estimate, Group, Scope};

/// What is found in the clean images and not in the cracked ones, and what else changes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FailureResults {
    /// Rates per scope and group.
    pub rates: Vec<FailureRow>,
    /// Rates over how strongly an object is hit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dose_responses: Vec<DoseResponse>,
    /// Detections that the cracks brought.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub new_false_positives: Vec<NewFalsePositives>,
    /// How score and overlap change where an object is found in both.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shifts: Vec<ShiftRow>,
    /// Objects found as another class.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flips: Vec<FlipRow>,
}

/// How many of the objects found clean are lost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailureRow {
    /// Where.
    pub scope: Scope,
    /// Of which objects.
    pub group: Group,
    /// Objects to be found.
    pub n_objects: u64,
    /// Found in the clean images.
    pub n_found_clean: u64,
    /// Found in the cracked images.
    pub n_found_cracked: u64,
    /// Found clean and not cracked.
    pub n_lost: u64,
    /// Found cracked and not clean.
    pub n_recovered: u64,
    /// Lost of those found clean.
    pub failure_rate: Estimate,
    /// Recovered of those not found clean.
    pub recovery_rate: Estimate,
    /// Probability of a difference between lost and recovered objects as large if cracked and clean were
    /// exchangeable, image by image or cluster by cluster.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// The same, corrected by Holm's method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_holm: Option<f64>,
}

/// Failure over a measure of the damage to the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DoseResponse {
    /// The measure: `coverage`, `displacement`, `blur radius`, `contrast lost`.
    pub fact: String,
    /// Its unit, empty for a share.
    pub unit: String,
    /// Of which objects.
    pub group: Group,
    /// By rising dose.
    pub bins: Vec<DoseBin>,
    /// Why there are no bins, in plain words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// A logistic curve through the single objects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<LogisticFit>,
}

/// Objects with a dose in `[low, high)`, the last bin with its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DoseBin {
    /// Least dose.
    pub low: f64,
    /// Greatest dose.
    pub high: f64,
    /// Mean dose of its objects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Found clean.
    pub n: u64,
    /// Lost of those.
    pub n_lost: u64,
    /// The share.
    pub rate: Estimate,
}

/// `P(lost) = 1 / (1 + exp(−(intercept + slope · dose)))`, by maximum likelihood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogisticFit {
    /// At no dose.
    pub intercept: f64,
    /// Per unit of the dose.
    pub slope: Estimate,
    /// Probability of a slope as steep if the dose were without effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// The same, corrected by Holm's method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_holm: Option<f64>,
}

/// False positives that were not there in the clean image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewFalsePositives {
    /// Where.
    pub scope: Scope,
    /// False positives in the clean images.
    pub n_clean: u64,
    /// False positives in the cracked images.
    pub n_cracked: u64,
    /// Those of them that no clean detection overlaps by half.
    pub n_new: u64,
    /// Area that they can lie in, millions of pixels.
    pub area_mpx: f64,
    /// New ones per million pixels of it.
    pub new_per_mpx: Estimate,
}

/// How score and overlap change where an object is found in both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShiftRow {
    /// Where.
    pub scope: Scope,
    /// Of which objects.
    pub group: Group,
    /// Objects found in both.
    pub n_pairs: u64,
    /// Mean of the score, cracked minus clean.
    pub score: Estimate,
    /// Test of it, by the variance between images or clusters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_score: Option<f64>,
    /// The same, corrected by Holm's method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_score_holm: Option<f64>,
    /// Mean of the overlap with the truth, cracked minus clean.
    pub iou: Estimate,
    /// Test of it, as above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_iou: Option<f64>,
    /// The same, corrected by Holm's method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_iou_holm: Option<f64>,
}

/// Objects found clean as what they are, and cracked as something else.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlipRow {
    /// Where.
    pub scope: Scope,
    /// Found clean.
    pub n: u64,
    /// Found cracked as another class, and not as their own.
    pub n_flipped: u64,
    /// The share.
    pub rate: Estimate,
    /// The commonest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub commonest: Vec<ClassFlip>,
}

/// From which class to which.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClassFlip {
    /// What it is.
    pub from: String,
    /// What it is taken for.
    pub to: String,
    /// How often.
    pub n: u64,
}
