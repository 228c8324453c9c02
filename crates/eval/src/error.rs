use std::path::PathBuf;

use starbreak_dataset::DatasetError;

/// What is wrong with labels, detections, a model or the question asked, as one line: what, where,
/// the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// A file or an image.
    #[error(transparent)]
    Dataset(#[from] DatasetError),

    // Labels and detections.
    /// A record of a file of labels or detections breaks the rules of its format.
    #[error("{path:?}: {place}: {reason}")]
    Record {
        /// The file.
        path: PathBuf,
        /// The record, with its line or byte.
        place: String,
        /// What is wrong, with the value, and the way out.
        reason: String,
    },
    /// A file of labels or detections is not what it should be as a whole.
    #[error("{path:?}: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// Detections in images that the labels lack.
    #[error(
        "{path:?}: {n_detections} of {n_all} detections are in images that the labels lack, the first in image {first}; give the detections of the labeled images"
    )]
    UnknownImages {
        /// The file.
        path: PathBuf,
        /// How many such detections there are.
        n_detections: usize,
        /// How many detections there are.
        n_all: usize,
        /// The first such image.
        first: String,
    },
    /// The region mask of an image is missing or is not its.
    #[error("region mask {path:?} of image {image:?}: {reason}")]
    Mask {
        /// The name of the image.
        image: String,
        /// The mask.
        path: PathBuf,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// Numbers that say how to evaluate and do not go together, or a limit of the engine.
    #[error("{0}")]
    Rule(String),
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

    // Detectors.
    /// A contract of a model does not say what it must, or something that means nothing.
    #[error("contract {contract:?}: {key}: {reason}")]
    Contract {
        /// The file or the preset.
        contract: String,
        /// The key, with its table.
        key: String,
        /// What is wrong, with the value, and the way out.
        reason: String,
    },
    /// A model that cannot be used.
    #[error("model {model:?} {reason}")]
    Model {
        /// Its file.
        model: String,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// A model that failed on an image, or said what cannot be taken for detections.
    #[error("model {model:?} on {image:?}: {reason}")]
    Inference {
        /// Its file.
        model: String,
        /// The image.
        image: String,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// Names of classes which do not fit.
    #[error("label map {map:?}: {reason}")]
    LabelMap {
        /// The file, or what it was made from.
        map: String,
        /// What is wrong, and the way out.
        reason: String,
    },

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
