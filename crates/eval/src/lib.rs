//! Detections to numbers: what a detector finds in clean and in cracked images, and how sure the
//! difference is.
//!
//! It is: the running of detectors, readers of labels and detections, the protocols of MS-COCO,
//! KITTI and BDD100K, evaluation inside a region of the image, paired statistics of failure,
//! distances between sets of images, and the report.
//! It is not: anything that knows how an image was broken. It gets labels, detections, masks and
//! pixels, so that no metric can peek at the simulator.

mod boxes;
mod detections;
pub mod detector;
mod error;
pub mod evaluation;
mod json_record;
mod labels;
mod matching;
mod protocol;

pub mod report;

// Statistics.
pub mod failure;
pub mod resampling;
pub mod statistic;
pub mod tide;

pub mod divergence;

pub use boxes::BoxPx;
pub use detections::{Detection, Detections, KittiDetections, ReadDetections, Unused};
pub use error::EvalError;
pub use labels::{Category, KittiFacts, KittiLabels, LabelSet, LabeledImage, Object, ObjectKind};
pub use matching::{ImageMatches, MatchedDetection, MatchedObject, Outcome};
pub use protocol::{
    AreaRange, CocoEvaluation, CocoParams, KittiClass, KittiCurve, KittiDifficulty, MatchRule,
    N_KITTI_RECALLS, PrecisionCurve, RankedMatches, Restriction, average_precision, evaluate_coco,
    evaluate_kitti, match_images, mean_in_numpy_order,
};
