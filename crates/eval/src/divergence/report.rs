//! The result of a comparison as plain values.

use std::collections::BTreeMap;

use serde::Serialize;

use super::features::{BinAxis, Feature};
use super::sets::{ReadSettings, SetSummary};

/// The definition that all numbers follow.
pub const DEFINITION: &str = "div/1";

/// The schema of [`DivergenceReport`] as JSON.
pub const REPORT_SCHEMA: &str = "starbreak.divergence/1";

/// A measure of how far two distributions are apart.
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
    /// First Wasserstein distance in the feature's own unit; around a circle where the bins are.
    W1,
    /// The same in widths of a bin.
    W1Bins,
    /// Hellinger distance, 0 to 1.
    Hellinger,
    /// Total variation, 0 to 1.
    Tv,
    /// Squared Fréchet distance.
    Frechet,
    /// Squared Fréchet distance of shrunk covariances.
    FrechetShrunk,
    /// Unbiased MMD² with the cubic kernel.
    Kid,
    /// 1000 times the biased MMD² with the RBF kernel of width 10.
    MmdRbf,
}

impl Measure {
    /// Its word, such as `kl_ab`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::KlAb => "kl_ab",
            Self::KlBa => "kl_ba",
            Self::Jeffreys => "jeffreys",
            Self::Js => "js",
            Self::W1 => "w1",
            Self::W1Bins => "w1_bins",
            Self::Hellinger => "hellinger",
            Self::Tv => "tv",
            Self::Frechet => "frechet",
            Self::FrechetShrunk => "frechet_shrunk",
            Self::Kid => "kid",
            Self::MmdRbf => "mmd_rbf_x1000",
        }
    }
}

/// A value and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The value for the sets as they are.
    pub value: f64,
    /// Percentile interval by bootstrap over the images of both sets, of [paired](PairComparison::is_paired)
    /// sets with the same draws for both; none where a set has one image.
    ///
    /// Resampling adds noise, so that near the floor the whole interval lies above the value: then
    /// read the p-value.
    pub interval: Option<[f64; 2]>,
    /// Mean over random split-halves, of the set whose mean is larger: what two samples of *one*
    /// distribution, each of half that set, differ by.
    pub floor: Option<f64>,
    /// 95 % quantile over the same split-halves.
    pub floor_q95: Option<f64>,
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
    /// How they lie.
    pub axis: BinAxis,
    /// What was measured, by measure; empty where `missing` says why.
    pub measures: BTreeMap<Measure, Estimate>,
    /// Why there is no number.
    pub missing: Option<String>,
}

/// Two sets compared by the activations of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VectorComparison {
    /// Where the vectors come from: model and layer, or files.
    pub origin: String,
    /// Values per vector.
    pub n_dimensions: usize,
    /// Vectors of the first set.
    pub n_a: usize,
    /// Vectors of the second set.
    pub n_b: usize,
    /// Share of shrinkage of both covariances \[LedoitWolf2004\].
    pub shrinkage: [f64; 2],
    /// Whether a set has no more vectors than dimensions.
    pub is_rank_deficient: bool,
    /// Width of the RBF kernel, in the units of the features.
    pub rbf_sigma: f64,
    /// Most resamples of each kind behind Fréchet distances, which take long for long vectors; where
    /// it is less than what the settings ask for, it is what was made.
    pub n_frechet_resamples: usize,
    /// Whether KID and MMD have floor, interval and p-value: not beyond 4000 vectors.
    pub is_kernel_resampled: bool,
    /// What was measured.
    pub measures: BTreeMap<Measure, Estimate>,
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
    /// p-values of features exchange the two versions of an image, and see much smaller differences.
    pub is_paired: bool,
    /// By feature.
    pub features: Vec<FeatureComparison>,
    /// By activations, where there are any.
    pub activations: Option<VectorComparison>,
}

/// Whether one pair of sets is closer than another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrderingTest {
    /// The pair that is claimed to be closer.
    pub closer: [String; 2],
    /// The pair that is claimed to be farther.
    pub farther: [String; 2],
    /// The measure that is compared.
    pub measure: Measure,
    /// By feature.
    pub features: Vec<FeatureOrdering>,
    /// Features in which it holds with a probability above 0.95.
    pub n_holding: usize,
    /// Features that could be compared.
    pub n_features: usize,
    /// Whether it holds in at least four features with a probability above 0.95.
    pub holds: bool,
}

/// An ordering in one feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureOrdering {
    /// The feature.
    pub feature: Feature,
    /// Value of the pair that is claimed to be closer.
    pub closer: f64,
    /// Value of the other pair.
    pub farther: f64,
    /// Share of bootstrap replicates in which it is; none without replicates.
    pub probability: Option<f64>,
}

/// How the numbers were made.
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
    /// Share that an interval covers. **Default** 0.95.
    pub confidence: f64,
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
            confidence: 0.95,
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
    /// By feature and measure: mean and 95 % quantile over the splits.
    pub features: BTreeMap<&'static str, BTreeMap<Measure, [f64; 2]>>,
}

/// Sets compared, every pair of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DivergenceReport {
    /// [`REPORT_SCHEMA`].
    pub schema: &'static str,
    /// [`DEFINITION`].
    pub definition: &'static str,
    /// `e`: divergences are in nats.
    pub log_base: &'static str,
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
    /// Orderings that were asked for.
    pub orderings: Vec<OrderingTest>,
    /// What a reader must know: sets of one image, shared images, images that could not be read.
    pub notes: Vec<String>,
}
