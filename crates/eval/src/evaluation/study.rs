use serde::{Deserialize, Serialize};

use super::{
    ChangedObject, CleanResults, Estimate, FailureResults, OverSeeds, PairedMetric, PairedRow,
    PooledClips, PrecisionCurves, ProtocolResults, Provenance, Scope, TideErrors, TimelineResults,
    Warning, WorstFailure,
};
use crate::SubsetRow;

/// Detectors times conditions, each evaluated, and what follows from all of them together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// [`Study::SCHEMA`].
    pub schema: String,
    /// What it is called on paper.
    pub title: String,
    /// Name of the data set.
    pub dataset: String,
    /// What all evaluations share.
    pub provenance: Provenance,
    /// What a reader must know first.
    #[serde(default)]
    pub warnings: Vec<Warning>,
    /// What each detector does on the clean images, whatever the condition.
    #[serde(default)]
    pub clean: Vec<CleanResults>,
    /// One per detector and condition, detectors first.
    pub evaluations: Vec<Evaluation>,
    /// The mean over seeds of conditions that differ in nothing else, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub over_seeds: Vec<OverSeeds>,
    /// mPC and rPC of each detector.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robustness: Vec<RobustnessRow>,
    /// How far the sets of images lie apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub divergence: Option<DivergenceResults>,
}

impl Study {
    /// Name and version of the format of its JSON.
    pub const SCHEMA: &'static str = "starbreak.evaluation/2";

    /// One evaluation alone, as a study of one detector and one condition; its clean results are to be
    /// put into [`Study::clean`].
    #[must_use]
    pub fn of_one(evaluation: Evaluation, dataset: &str, provenance: Provenance) -> Self {
        let mut study = Self {
            schema: Self::SCHEMA.to_owned(),
            title: format!("{} on {dataset}", evaluation.detector),
            dataset: dataset.to_owned(),
            provenance,
            warnings: Vec::new(),
            clean: Vec::new(),
            evaluations: vec![evaluation],
            over_seeds: Vec::new(),
            robustness: Vec::new(),
            divergence: None,
        };
        study.correct_for_many_tests();
        study
    }

    /// Whether intervals draw clips, drives or other clusters in the place of images.
    #[must_use]
    pub(crate) fn draws_clusters(&self) -> bool {
        let unit = self.provenance.settings.resampling_unit.as_str();
        !matches!(unit, "" | "image" | "object")
    }

    /// What a detector does on the clean images.
    #[must_use]
    pub(crate) fn clean_of(&self, detector: &str) -> Option<&CleanResults> {
        self.clean.iter().find(|one| one.detector == detector)
    }
}

/// One detector under one condition: the same images clean and cracked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Name of the detector.
    pub detector: String,
    /// What was done to the glass.
    pub condition: Condition,
    /// How much there is of everything.
    pub counts: Counts,
    /// What a reader must know first.
    #[serde(default)]
    pub warnings: Vec<Warning>,
    /// Whole cracked images.
    pub cracked: ProtocolResults,
    /// Clean against cracked, inside the region, outside of it, and everywhere.
    #[serde(default)]
    pub paired: Vec<PairedRow>,
    /// Precision over recall in the region and on whole images.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<PrecisionCurves>,
    /// Clean against cracked by bin of coverage, and by size in the region.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub subsets: Vec<SubsetRow>,
    /// What fails.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failures: Option<FailureResults>,
    /// Which kinds of errors, cracked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tide_cracked: Option<TideErrors>,
    /// Of clips: what is found when.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub timelines: Vec<TimelineResults>,
    /// The clips together, where several have damage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pooled_clips: Option<PooledClips>,
    /// The images in which most was lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub worst: Vec<WorstFailure>,
    /// All objects that are lost or recovered; a file of their own, not part of the JSON.
    #[serde(skip)]
    pub changed_objects: Vec<ChangedObject>,
}

/// What was done to the glass.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Condition {
    /// Its name: `windshield-star, severity 3, seed 1`.
    pub name: String,
    /// The family of cracks, over which mPC averages: a preset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub family: Option<String>,
    /// 1 to 5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub severity: Option<u8>,
    /// Seed of the cracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl Condition {
    /// Whether it is one of the families times severities that mPC averages over.
    pub(crate) fn is_of_grid(&self) -> bool {
        self.family.is_some() && self.severity.is_some()
    }
}

/// How much there is of everything.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Images.
    pub n_images: u64,
    /// Images that the region touches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_images_with_region: Option<u64>,
    /// Images that it does not touch: the cracks left them as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_images_intact: Option<u64>,
    /// Objects to be found.
    pub n_objects: u64,
    /// Objects to be found in the region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_objects_in_region: Option<u64>,
    /// Mean share of an image that the region covers, 0 to 1, over the images with a mask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_region_share: Option<f64>,
}

/// mPC and rPC of a detector: mean AP under corruption, and its share of the clean AP.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobustnessRow {
    /// The detector.
    pub detector: String,
    /// Where.
    pub scope: Scope,
    /// Which AP is averaged.
    pub metric: PairedMetric,
    /// AP of the clean images.
    pub clean: Estimate,
    /// Mean over families of the mean over severities of the mean over seeds. The interval, of AP50 and
    /// AP75, draws images or clusters, and seeds where there are several.
    pub mpc: Estimate,
    /// `mpc / clean`.
    pub rpc: Estimate,
    /// Seeds of every family and severity, where that number is the same; with 1 the intervals know
    /// nothing of how patterns differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_seeds: Option<u64>,
}

/// How far sets of images lie apart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DivergenceResults {
    /// Names of the sets.
    pub sets: Vec<String>,
    /// One table per feature and measure.
    pub tables: Vec<DivergenceTable>,
}

/// One measure over one feature between all sets.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DivergenceTable {
    /// What of the images is compared: `luma256`.
    pub feature: String,
    /// How: `KL(row ‖ column)`, nats.
    pub measure: String,
    /// Rows and columns in the order of the sets.
    pub values: Vec<Vec<Estimate>>,
    /// What two halves of the same set give, per set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub noise_floor: Vec<Option<f64>>,
}
