use starbreak_dataset::DatasetError;

/// What is wrong with labels, detections, a model or the question asked, as one line: what, where,
/// the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// A file or an image.
    #[error(transparent)]
    Dataset(#[from] DatasetError),

    // Statistics.
    /// Two things that belong together differ in number.
    #[error("{what}: {found}, but {expected} {of}; give one for each")]
    StatisticLength {
        /// What there is too much or too little of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
        /// What each of them belongs to.
        of: &'static str,
    },
    /// A setting that makes no sense.
    #[error("{what} is {value}; give one {range}")]
    StatisticSetting {
        /// Which.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// Matches of clean and cracked images that do not belong together.
    #[error(
        "matches of clean and cracked images differ in {what}; match both with the same labels by the same rule"
    )]
    NotPaired {
        /// In what.
        what: String,
    },
    /// A track that is not one object through the frames.
    #[error(
        "track {track} is there twice: in one frame, in two categories or out of order; give each object its own number"
    )]
    Track {
        /// Its number.
        track: u64,
    },
}
