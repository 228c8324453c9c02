//! All files of a report.

use super::{csv, failures_jsonl, html, json, latex};
use crate::EvalError;
use crate::evaluation::Study;

/// The files of a report with their names: `report.html`, `evaluation.json`, `numbers.csv`, `table.tex`,
/// `failures.jsonl`; to be written all or none.
///
/// # Errors
/// As [`html()`] and [`json()`].
pub fn report_files(study: &Study) -> Result<Vec<(&'static str, String)>, EvalError> {
    Ok(vec![
        ("failures.jsonl", failures_jsonl(study)?),
        ("table.tex", latex(study)),
        ("numbers.csv", csv(study)),
        ("evaluation.json", json(study)?),
        ("report.html", html(study)?),
    ])
}
