//! The result of a comparison as plain values.

use std::collections::BTreeMap;

use serde::Serialize;

use super::features::{Feature, ReadSettings};
use super::histogram::HistogramDivergence;
use super::set::SetSummary;
use super::vectors::VectorComparison;

/// The definition that all numbers follow.
pub const DEFINITION: &str = "div/1";

/// The schema of [`DivergenceReport`] as JSON.
pub(super) const REPORT_SCHEMA: &str = "starbreak.divergence/2";

/// Share that an interval covers.
pub(super) const CONFIDENCE: f64 = 0.95;

/// A measure of how far two histograms are apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// `KL(A‖B)`, nats.
    KlAb,
    /// `KL(B‖A)`, nats.
    KlBa,
    /// `KL(A‖B) + KL(B‖A)`, nats.
    Jeffreys,
    /// Jensen-Shannon divergence, nats, 0 to ln 2.
    Js,
    /// First Wasserstein distance in the feature's own unit; none where bins are in no row.
    W1,
    /// Hellinger distance, 0 to 1.
    Hellinger,
    /// Total variation, 0 to 1.
    Tv,
}

impl Measure {
    /// All of them.
    pub(super) const ALL: [Self; 7] = [
        Self::KlAb,
        Self::KlBa,
        Self::Jeffreys,
        Self::Js,
        Self::W1,
        Self::Hellinger,
        Self::Tv,
    ];

    /// Its word, such as `kl_ab`.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::KlAb => "kl_ab",
            Self::KlBa => "kl_ba",
            Self::Jeffreys => "jeffreys",
            Self::Js => "js",
            Self::W1 => "w1",
            Self::Hellinger => "hellinger",
            Self::Tv => "tv",
        }
    }

    /// It alone; W1 in widths of a bin.
    pub(super) const fn of(self, all: &HistogramDivergence) -> f64 {
        match self {
            Self::KlAb => all.kl_pq,
            Self::KlBa => all.kl_qp,
            Self::Jeffreys => all.jeffreys,
            Self::Js => all.js,
            Self::W1 => all.w1_bins,
            Self::Hellinger => all.hellinger,
            Self::Tv => all.tv,
        }
    }

    /// What one of [`Measure::of`] is worth in the unit of a feature; none where it means nothing.
    pub(super) fn unit(self, feature: Feature) -> Option<f64> {
        match self {
            Self::W1 => feature.bin_width().map(|(width, _)| width),
            _ => Some(1.0),
        }
    }
}

/// A value and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The value for the sets as they are.
    pub value: f64,
    /// 95 % percentile interval by bootstrap over the images of both sets, of
    /// [paired](PairComparison::is_paired) sets with the same draws for both; none where a set has one image.
    ///
    /// Resampling adds noise, so that near the floor the whole interval lies above the value, and there is
    /// none: then read the p-value.
    pub interval: Option<[f64; 2]>,
    /// The [floor](SetFloor) of the set where it is larger.
    pub floor: Option<f64>,
    /// Value over floor: about 1 or less where there is no difference to be seen.
    pub effect: Option<f64>,
    /// Share of random relabelings of all images of both that are at least as far apart,
    /// `(1 + k) / (1 + n)`; of [paired](PairComparison::is_paired) sets inside each pair.
    pub p_value: Option<f64>,
}

/// Two sets compared by one feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureComparison {
    /// The feature.
    pub feature: Feature,
    /// Number of its bins.
    pub n_bins: usize,
    /// Unit of W1, where there is one.
    pub w1_unit: Option<&'static str>,
    /// What was measured, by measure; empty where `missing` says why.
    pub measures: BTreeMap<Measure, Estimate>,
    /// Why there is no number.
    pub missing: Option<&'static str>,
}

/// Two sets compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairComparison {
    /// Name of the first set, A.
    pub a: String,
    /// Name of the second set, B.
    pub b: String,
    /// Images of A.
    pub n_a: usize,
    /// Images of B.
    pub n_b: usize,
    /// Files that are in both, by their bytes.
    pub n_shared: usize,
    /// Whether both have the same images by name, such as a clean set and its cracked twin: then the
    /// p-values exchange the two versions of an image, and see much smaller differences.
    pub is_paired: bool,
    /// By feature.
    pub features: Vec<FeatureComparison>,
    /// By the activations of a model, where there are any of two images or more.
    pub activations: Option<VectorComparison>,
}

/// How the numbers are made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompareSettings {
    /// Counts added to each bin. **Default** 0.5, Jeffreys' prior.
    pub alpha: f64,
    /// Bootstrap replicates; 0 for no intervals. **Default** 1000.
    pub n_bootstrap: usize,
    /// Random relabelings; 0 for no p-values. **Default** 999.
    pub n_permutations: usize,
    /// Random split-halves; 0 for no floor. **Default** 100.
    pub n_splits: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            alpha: 0.5,
            n_bootstrap: 1000,
            n_permutations: 999,
            n_splits: 100,
            seed: 0,
        }
    }
}

/// What random halves of one set differ by: the noise floor of that set alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetFloor {
    /// Name of the set.
    pub set: String,
    /// Images in the smaller half.
    pub n_half: usize,
    /// By feature and measure: the mean over the splits.
    pub features: BTreeMap<&'static str, BTreeMap<Measure, f64>>,
}

/// Sets compared, every pair of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DivergenceReport {
    /// `starbreak.divergence/2`.
    pub schema: &'static str,
    /// [`DEFINITION`].
    pub definition: &'static str,
    /// `e`: divergences are in nats.
    pub log_base: &'static str,
    /// Share that an interval covers.
    pub confidence: f64,
    /// How the numbers were made.
    pub settings: CompareSettings,
    /// How the images were looked at.
    pub reading: ReadSettings,
    /// The sets.
    pub sets: Vec<SetSummary>,
    /// Every pair of them, first with second, first with third, …
    pub pairs: Vec<PairComparison>,
    /// The noise floor of each set of two images and more.
    pub floors: Vec<SetFloor>,
    /// What a reader must know: sets of one image, shared images, images that could not be read.
    pub notes: Vec<String>,
}

impl DivergenceReport {
    /// The noise floor of a set.
    pub(crate) fn floor(&self, set: &str, feature: Feature, measure: Measure) -> Option<f64> {
        floor_of(&self.floors, set, feature, measure)
    }
}

/// The noise floor of a set among others.
pub(super) fn floor_of(
    floors: &[SetFloor],
    set: &str,
    feature: Feature,
    measure: Measure,
) -> Option<f64> {
    let of_set = floors.iter().find(|floor| floor.set == set)?;
    let of_feature = of_set.features.get(feature.name())?;
    of_feature.get(&measure).copied()
}
