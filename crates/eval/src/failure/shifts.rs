//! How score and overlap change where an object is found in both images.

use serde::{Deserialize, Serialize};

use super::{Group, ObjectPair};
use crate::EvalError;
use crate::resampling::Plan;
use crate::statistic::{Measured, TestOutcome, clustered_mean};

/// Changes of objects found in both images, cracked minus clean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shifts {
    /// Which objects.
    pub group: Group,
    /// How many were found in both.
    pub n_pairs: u64,
    /// Of the score.
    pub score: Shift,
    /// Of the overlap with the object.
    pub iou: Shift,
}

/// Changes of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// Mean, with a t interval by the variance between images or clusters.
    pub mean: Measured,
    /// Whether it is other than 0, by the same variance.
    pub test: TestOutcome,
}

/// Changes of score and overlap of the pairs in which both found the object. Objects of one unit of
/// the plan, an image or a cluster of images, may depend on each other.
///
/// # Errors
/// If an image is not in the plan.
pub fn shifts<'a>(
    group: Group,
    pairs: impl IntoIterator<Item = &'a ObjectPair>,
    plan: &Plan,
) -> Result<Shifts, EvalError> {
    // Per unit: sums of both changes, and pairs.
    let mut units = vec![(0.0, 0.0, 0_u64); plan.n_units() as usize];
    for pair in pairs {
        let (Some(clean), Some(cracked)) = (pair.clean, pair.cracked) else {
            continue;
        };
        let unit = &mut units[plan.unit(pair.image)? as usize];
        unit.0 += cracked.score - clean.score;
        unit.1 += cracked.iou - clean.iou;
        unit.2 += 1;
    }
    let shift = |clusters: Vec<(f64, u64)>| {
        let (mean, test) = clustered_mean(&clusters, plan.level);
        Shift { mean, test }
    };
    Ok(Shifts {
        group,
        n_pairs: units.iter().map(|unit| unit.2).sum(),
        score: shift(units.iter().map(|unit| (unit.0, unit.2)).collect()),
        iou: shift(units.iter().map(|unit| (unit.1, unit.2)).collect()),
    })
}
