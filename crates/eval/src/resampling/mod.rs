//! How sure a number is: what it would be had other images, drives or crack patterns been taken.
//!
//! A [`Plan`] says what is drawn and with which seed; [`bootstrap`] gives any statistic of weights
//! per image its replicates, [`permutation_test`] any statistic of swaps its p. Clean and cracked
//! images get the same draws, so that what both share cancels in their difference.
//! [`paired_average_precision`] does both for average precision, [`paired_kitti_precision`] for
//! that of KITTI, [`crossed_average_precision`] the first over several crack patterns, each with a
//! region of its own.

mod crossed;
mod draws;
mod intervals;
mod kitti;
mod paired;
mod permutation;
mod ranked;
mod replicates;

pub use crossed::crossed_average_precision;
pub use draws::{Plan, Weights};
pub(crate) use intervals::quantile;
pub use intervals::{basic_interval, bca_interval, percentile_interval};
pub use kitti::{KittiRecalls, paired_kitti_precision};
pub use paired::{PairedPrecision, PairedPrecisions, paired_average_precision};
pub use permutation::permutation_test;
pub use ranked::{RankedCategory, rank_by_category};
pub use replicates::{Replicates, bootstrap};
