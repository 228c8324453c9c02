//! A whole evaluation as plain values: what is computed, drawn, written and read back.
//!
//! Fractions stay fractions (an AP of 0.413, not 41.3); only what a person reads shows percent. A
//! number that would mislead is not there: its [`Estimate`] says why.

mod clean;
mod clip;
mod clip_sides;
pub(crate) mod compare;
mod damage_facts;
mod divergence_tables;
mod estimate;
mod evaluate;
mod failures;
mod many_tests;
mod over_seeds;
mod paired;
mod pooled_clips;
mod provenance;
mod results;
mod robustness;
mod study;
mod warning;
mod worst;

pub use clean::CleanResults;
pub use clip::{ClipInput, ClipSettings, TimelineResults, TrackSource};
pub use clip_sides::{ClipSide, check_end, check_sides};
pub use damage_facts::DamageFacts;
pub use estimate::Estimate;
pub use evaluate::{
    EvaluateInput, EvaluateSettings, ImageFolders, OverConditions, clean_results, evaluate,
};
pub use failures::{
    ClassFlip, DoseBin, DoseResponse, FailureResults, FailureRow, FlipRow, LogisticFit,
    NewFalsePositives, ShiftRow,
};
pub use over_seeds::OverSeeds;
pub use paired::{Group, GroupKind, PairedMetric, PairedRow, PrecisionCurves, Scope, ScopeKind};
pub use pooled_clips::{PooledClips, PooledUnit, pool_clips};
pub use provenance::{InputFile, Provenance, Settings, Versions};
pub use results::{
    GroupAp, KittiAp, LabelAudit, LabelVerdict, ProtocolResults, ShiftedLabel, TideErrors,
};
pub use study::{
    Condition, Counts, DivergenceResults, DivergenceTable, Evaluation, RobustnessRow, Study,
};
pub use warning::{Span, Warning, WarningKind};
pub use worst::{BoxRole, Change, ChangedObject, PicturePair, RoledBox, WorstFailure};
