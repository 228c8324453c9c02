use std::path::PathBuf;

use starbreak_dataset::DatasetError;

/// What is wrong with labels, detections or the question asked, as one line: what, where,
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
    #[error("{what} is {value:?}; give one {range}")]
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

    // Divergence.
    /// Two histograms of different numbers of bins.
    #[error("histograms of {n_p} and {n_q} bins; count both over the same bins, at least one")]
    HistogramBins {
        /// Bins of the first.
        n_p: usize,
        /// Bins of the second.
        n_q: usize,
    },
    /// A count that is none.
    #[error("{which}[{bin}] = {value:e}; a count is from 0 to 2^53 = 9.007e15")]
    HistogramCount {
        /// `p` or `q`.
        which: &'static str,
        /// The bin, from 0.
        bin: usize,
        /// The value.
        value: f64,
    },
    /// A histogram in which nothing was counted.
    #[error("{which} is empty: nothing was counted; leave it out")]
    HistogramEmpty {
        /// `p` or `q`.
        which: &'static str,
    },
    /// A smoothing that is none.
    #[error("alpha = {alpha:e} counts per bin; expected 0 to 2^53, usually 0.5")]
    Smoothing {
        /// The value.
        alpha: f64,
    },
    /// Feature vectors that do not come out even.
    #[error("{n_values} values are no feature vectors of {n_dimensions} values each")]
    Dimensions {
        /// How many values there are.
        n_values: usize,
        /// How many each vector should have.
        n_dimensions: usize,
    },
    /// A covariance whose eigenvalues cannot be found.
    #[error("the eigenvalues of a covariance do not converge; scale the features to about 1")]
    Eigenvalues,
    /// A feature vector with a value that is none.
    #[error(
        "feature {column} of vector {row} is {value}; expected finite numbers, all below 1e100"
    )]
    FeatureValue {
        /// The vector, from 0.
        row: usize,
        /// The feature, from 0.
        column: usize,
        /// The value.
        value: f64,
    },
    /// Too few feature vectors for a distance.
    #[error("{n} feature vectors; a distance needs 2 at least of each set, so take more images")]
    FewVectors {
        /// How many there are.
        n: usize,
    },
    /// Feature vectors of different lengths.
    #[error(
        "feature vectors of {n_a} and of {n_b} values; compare those of one layer of one model"
    )]
    VectorLengths {
        /// Length of those of the first set.
        n_a: usize,
        /// Length of those of the second set.
        n_b: usize,
    },
    /// A set in which no image could be read.
    #[error(
        "set {name:?} has no image that can be read ({n_failed} failed{first}); give a folder with PNG or JPEG \
         images, or with networks (JSON) where the set is one of networks"
    )]
    EmptySet {
        /// Its name.
        name: String,
        /// How many could not be read.
        n_failed: usize,
        /// The first of them, and why.
        first: String,
    },
    /// Sets that cannot be compared with each other.
    #[error("{fact}; {way_out}")]
    NotComparable {
        /// Why not.
        fact: String,
        /// What to do.
        way_out: &'static str,
    },
}
