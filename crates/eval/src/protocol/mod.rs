//! What counts as found, and how that becomes one number: the protocols of benchmarks.

mod coco;
mod curve;
mod engine;

pub use coco::{AreaRange, CocoEvaluation, CocoParams, evaluate_coco};
pub use curve::{PrecisionCurve, RankedMatches, average_precision, mean_in_numpy_order};
pub use engine::{MatchRule, Restriction, match_images};
