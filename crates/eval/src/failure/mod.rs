//! What fails: objects found in the clean image and not in the cracked one, and what else changes.
//!
//! [`pair_objects`] puts what became of each object in both images side by side, at one overlap and
//! from one score on; rates, shifts and dose-response are functions of these pairs.
//! [`new_false_positives`] and [`class_flips`] look at detections instead.

mod dose;
mod false_positives;
mod flips;
mod logistic;
mod pairs;
mod rates;
mod shifts;

pub use dose::{DoseBin, DoseResponse, dose_response, quantile_edges};
pub use false_positives::{FalsePositiveAreas, FalsePositives, new_false_positives};
pub use flips::{ClassFlip, ClassFlips, class_flips};
pub use logistic::{Coefficient, LogisticFit, fit_logistic};
pub use pairs::{Found, ObjectPair, pair_objects};
pub use rates::{FailureRates, Group, Where, failure_rates, failure_table};
pub use shifts::{Shift, Shifts, shifts};

/// Score from which a detection counts, where nothing else is asked.
pub(crate) const SCORE_THRESHOLD: f64 = 0.3;
