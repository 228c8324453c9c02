//! A study as JSON, and back.

use crate::EvalError;
use crate::evaluation::Study;

/// A study as JSON of the schema [`Study::SCHEMA`], indented, with a line feed at its end; pictures are
/// not part of it.
///
/// # Errors
/// [`EvalError::Report`] if serde gives up, which no value of a study makes it do.
pub fn json(study: &Study) -> Result<String, EvalError> {
    let text = serde_json::to_string_pretty(study).map_err(|cause| EvalError::Report {
        reason: cause.to_string(),
    })?;
    Ok(text + "\n")
}

/// A study from its JSON.
///
/// # Errors
/// [`EvalError::ReportFile`] if it is not JSON of this schema, or not of this version.
pub fn read_json(text: &str) -> Result<Study, EvalError> {
    let study: Study = serde_json::from_str(text).map_err(|cause| EvalError::ReportFile {
        reason: cause.to_string().replace('\n', " "),
    })?;
    if study.schema != Study::SCHEMA {
        let found: String = study
            .schema
            .chars()
            .filter(|c| !c.is_control())
            .take(60)
            .collect();
        return Err(EvalError::ReportFile {
            reason: format!(
                "its schema is {found:?}, this program reads {:?}",
                Study::SCHEMA
            ),
        });
    }
    Ok(study)
}
