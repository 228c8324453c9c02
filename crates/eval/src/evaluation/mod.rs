//! A whole evaluation as plain values: what is computed, drawn, written and read back.
//!
//! Fractions stay fractions (an AP of 0.413, not 41.3); only what a person reads shows percent. A
//! number that would mislead is not there: its [`Estimate`] says why.

mod estimate;
mod failures;
mod paired;
mod provenance;
mod results;
mod study;
mod worst;

pub use estimate::Estimate;
pub use failures::{
    ClassFlip, DoseBin, DoseResponse, FailureResults, FailureRow, FlipRow, LogisticFit,
    NewFalsePositives, ShiftRow,
};
pub use paired::{Group, GroupKind, PairedMetric, PairedRow, Scope, ScopeKind};
pub use provenance::{InputFile, Provenance, Settings, Versions};
pub use results::{GroupAp, KittiAp, LabelAudit, ProtocolResults, ShiftedLabel, TideErrors};
pub use study::{
    Condition, Counts, DivergenceResults, DivergenceTable, Evaluation, RobustnessRow, Study,
    TimelineFrame, TimelineResults, TrackResult, Warning, WarningKind,
};
pub use worst::{BoxRole, PicturePair, RoledBox, WorstFailure};
