//! What counts as found, and how that becomes one number: the protocols of benchmarks.

mod coco;
mod curve;
mod engine;
mod kitti;

pub use coco::{AreaRange, CocoEvaluation, CocoParams, evaluate_coco};
pub use curve::{PrecisionCurve, RankedMatches, average_precision, mean_in_numpy_order};
pub use engine::{MatchRule, Restriction, match_images};
pub use kitti::{KittiClass, KittiCurve, KittiDifficulty, N_KITTI_RECALLS, evaluate_kitti};
