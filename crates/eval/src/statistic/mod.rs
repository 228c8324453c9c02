//! Numbers with what they rest on, and the small tests and intervals that all parts share.
//!
//! All tests are two-sided. A number that cannot be given is absent, with the reason; NaN does not
//! occur.

mod clustered_mean;
mod holm;
mod measured;
mod normal;
mod proportion;
mod signs;

pub(crate) use clustered_mean::clustered_mean;
pub use holm::holm;
pub use measured::{Interval, Measured, Method, TestOutcome};
pub(crate) use normal::{
    normal_cdf, normal_quantile, student_quantile, two_sided_normal_p, two_sided_student_p,
};
pub(crate) use proportion::clustered_share;
pub use proportion::{McNemar, mcnemar, proportion, wilson_interval};
pub(crate) use signs::sign_exchange_test;

/// Fewer units than these, and their spread is no picture of other units.
pub(crate) const MIN_UNITS: u32 = 5;
