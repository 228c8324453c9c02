//! What counts as found, and how that becomes one number: the protocols of benchmarks.

mod bdd;
mod coco;
mod curve;
mod engine;
mod kitti;

pub(crate) use bdd::{bdd_detections, bdd_labels};
pub(crate) use coco::evaluate_boxes;
pub(crate) use curve::{exact, mean_in_numpy_order};
pub(crate) use engine::{Boxes, runs_of_categories};

pub use coco::{AreaRange, CocoEvaluation, CocoParams, evaluate_coco};
pub use curve::{PrecisionCurve, RankedMatches, average_precision};
pub use engine::{MatchRule, Restriction, match_images};
pub use kitti::{
    KittiClass, KittiCurve, KittiDifficulty, KittiRanking, evaluate_kitti, rank_kitti,
};
