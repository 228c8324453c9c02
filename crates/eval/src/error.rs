use starbreak_dataset::DatasetError;

/// What is wrong with labels, detections, a model or the question asked, as one line: what, where,
/// the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// A file or an image.
    #[error(transparent)]
    Dataset(#[from] DatasetError),

    // The report.
    /// The page could not be made.
    #[error(
        "the report could not be made: {reason}; this is a fault of the program, please report it"
    )]
    Report {
        /// What the template says.
        reason: String,
    },
    /// A file of numbers is not one.
    #[error(
        "not a file of evaluation numbers: {reason}; give the evaluation.json of an evaluation or study"
    )]
    ReportFile {
        /// What is wrong with it.
        reason: String,
    },
}
