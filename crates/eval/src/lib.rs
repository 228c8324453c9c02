//! Detections to numbers: what a detector finds in clean and in cracked images, and how sure the
//! difference is.
//!
//! It is: readers of labels and detections, the protocols of MS-COCO, KITTI and BDD100K, evaluation
//! inside a region of the image, paired statistics of failure, distances between sets of images, and
//! the report.
//! It is not: anything that knows how an image was broken. It gets labels, detections, masks and
//! pixels, so that no metric can peek at the simulator.

mod boxes;
pub mod chart;
mod detections;
mod error;
pub mod evaluation;
mod json_record;
mod labels;
mod matching;
mod protocol;
mod region;
mod truth;

pub mod report;

// Statistics.
pub mod failure;
pub mod label_audit;
mod mean_performance;
pub mod resampling;
pub mod statistic;
pub mod tide;
pub mod timeline;

pub mod divergence;

pub use boxes::BoxPx;
pub use detections::{Detection, Detections, KittiDetections, Pooling, ReadDetections, Unused};
pub use error::EvalError;
pub use evaluation::compare::{
    CompareParams, Compared, Evaluated, RegionResults, SubsetAp, SubsetParams, SubsetRow,
    compare_pair, evaluate, subset_curves, subset_precision,
};
pub use labels::{Category, KittiFacts, KittiLabels, LabelSet, LabeledImage, Object, ObjectKind};
pub use matching::{ImageMatches, MatchedDetection, MatchedObject, Outcome};
pub use mean_performance::{
    CrackedPrecision, MeanPerformance, PerformanceCell, measured_performance,
};
pub use protocol::{
    AreaRange, CocoEvaluation, CocoParams, KittiClass, KittiCurve, KittiDifficulty, KittiRanking,
    MatchRule, PrecisionCurve, RankedMatches, Restriction, average_precision, evaluate_coco,
    evaluate_kitti, match_images, rank_kitti,
};
pub use region::{CoverageOf, Coverages, RegionMask, RegionMasks, Size, Subset, SubsetValues};
pub use truth::{
    ClipLabels, GroundTruth, LabeledClip, LabeledFrame, Protocol, SaidDetections, TrackName,
    TrackedLabels, frames_of, said_categories,
};

pub(crate) use evaluation::compare::{COVERAGE_BINS, MIN_OBJECTS};
pub(crate) use mean_performance::mean_performance;
pub(crate) use protocol::{bdd_detections, bdd_labels};
