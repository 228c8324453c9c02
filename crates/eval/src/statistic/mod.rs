//! Numbers with what they rest on, and the small tests and intervals that all parts share.
//!
//! All tests are two-sided. A number that cannot be given is absent, with the reason; NaN does not
//! occur.

mod holm;
mod measured;
mod normal;
mod proportion;
mod signed_rank;

pub use holm::holm;
pub use measured::{Interval, Measured, Method, TestOutcome};
pub(crate) use normal::{normal_cdf, normal_quantile, two_sided_normal_p};
pub(crate) use proportion::paired_difference;
pub use proportion::{McNemar, mcnemar, proportion, wilson_interval};
pub use signed_rank::{SignedRank, signed_rank_test};
