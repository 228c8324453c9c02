//! How sure a number is: what it would be had other images or drives been taken.
//!
//! A [`Plan`] says what is drawn and with which seed; [`bootstrap`] gives any statistic of weights
//! per image its replicates, [`permutation_test`] any statistic of swaps its p. Clean and cracked
//! images get the same draws, so that what both share cancels in their difference; an image is drawn
//! and swapped with the cracks of all its seeds. [`paired_average_precision`] does both for average
//! precision, [`paired_kitti_precision`] for that of KITTI; [`DrawnPrecisions`] are what they are measured from, which
//! takes sets of cracked images one after the other.

mod drawn;
mod draws;
mod intervals;
mod kitti;
mod paired;
mod permutation;
mod ranked;
mod replicates;

pub use drawn::{DrawnMean, DrawnPrecisions};
pub use draws::Plan;
pub(crate) use intervals::quantile;
pub use intervals::{Basis, expanded_interval, percentile_interval};
pub use kitti::{KittiRecalls, paired_kitti_precision};
pub use paired::{PairedPrecision, PairedPrecisions, paired_average_precision};
pub(crate) use permutation::permuted_draws;
pub use permutation::{Permuted, permutation_test};
pub use ranked::{RankedCategory, rank_by_category, rank_versions};
pub use replicates::{Replicates, bootstrap};
