//! Cracked detections beside clean ones by a protocol, before any statistics.

use super::pairs::check_pair;
use super::{CompareParams, Evaluated, RegionResults, compare_in_regions, cover, evaluate};
use crate::evaluation::{Counts, Warning};
use crate::{Coverages, EvalError, GroundTruth, RegionMasks, SaidDetections};

/// What a protocol says of cracked detections beside clean ones.
#[derive(Debug, Clone)]
pub struct Compared {
    /// What to mind of both.
    pub warnings: Vec<Warning>,
    /// How much there is.
    pub counts: Counts,
    /// How much of each box the regions cover, of clean (0) and cracked (1) detections; nothing
    /// without regions.
    pub coverages: Option<Coverages>,
    /// The cracked detections on whole images, where there are any.
    pub cracked: Option<Evaluated>,
    /// Numbers of the region; nothing without regions.
    pub regions: Option<RegionResults>,
}

/// Cracked detections beside clean ones, on whole images and in the regions of the masks; without
/// cracked ones the clean ones alone in the regions. What the protocol says of the clean ones on whole
/// images, whatever the cracks, is [`evaluate`]'s.
///
/// # Errors
/// [`EvalError::Rule`] where both are not of the same frames, or for parameters that make no sense, and
/// those of [`RegionMasks::coverages`].
pub fn compare_pair(
    truth: &GroundTruth,
    clean: &SaidDetections,
    cracked: Option<&SaidDetections>,
    masks: Option<RegionMasks<'_>>,
    params: &CompareParams,
) -> Result<Compared, EvalError> {
    let warnings = check_pair(truth, clean, cracked)?;
    let sets: Vec<&SaidDetections> = [Some(clean), cracked].into_iter().flatten().collect();
    let (counts, coverages) = cover(truth, &sets, masks, params.tau())?;
    let of_cracked = cracked.map(|cracked| evaluate(truth, cracked, params));
    let regions = coverages
        .as_ref()
        .map(|coverages| compare_in_regions(truth, clean, cracked, coverages, params));
    Ok(Compared {
        warnings,
        counts,
        cracked: of_cracked.transpose()?,
        regions: regions.transpose()?,
        coverages,
    })
}
