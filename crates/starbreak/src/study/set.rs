//! The cracked twin of the source under one condition.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use starbreak_dataset::Source;

use super::Condition;
use crate::Error;
use crate::generate::{
    Event, GenerateOptions, GenerateReport, Patterns, Plan, Selection, Survey, generate,
};
use crate::pipeline::RunContext;

/// Makes the set of a condition in a folder, or goes on with it.
pub(super) fn make_set(
    (source, survey): (&Source, &Survey),
    selection: Selection,
    condition: &Condition,
    folder: &Path,
    stop: &AtomicBool,
    tell: &(dyn Fn(Event<'_>) + Sync),
) -> Result<GenerateReport, Error> {
    let context = RunContext::new(&condition.recipe, condition.seed, folder)?;
    let options = GenerateOptions {
        selection,
        other_files: None,
        ..GenerateOptions::default()
    };
    let plan = Plan {
        source,
        context: &context,
        patterns: &Patterns::Fresh,
        options: &options,
        survey,
    };
    generate(&plan, stop, tell)
}
