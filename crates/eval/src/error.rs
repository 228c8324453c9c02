use starbreak_dataset::DatasetError;

/// What is wrong with labels, detections, a model or the question asked, as one line: what, where,
/// the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// A file or an image.
    #[error(transparent)]
    Dataset(#[from] DatasetError),

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
    #[error("{which}[{bin}] = {value}; a count is finite and not negative")]
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
    #[error("alpha = {alpha} counts per bin; expected a finite number from 0 on, usually 0.5")]
    Smoothing {
        /// The value.
        alpha: f64,
    },
    /// Sides of a mean and a covariance that do not fit each other.
    #[error("{what} has {n_values} values; {n_dimensions} dimensions need {expected}")]
    Dimensions {
        /// What does not fit.
        what: &'static str,
        /// How many values it has.
        n_values: usize,
        /// Dimensions of the distribution.
        n_dimensions: usize,
        /// How many values it needs.
        expected: usize,
    },
    /// A matrix that is not the covariance of anything, or not one with an inverse.
    #[error("{what} is not a covariance: {fact}; {way_out}")]
    Covariance {
        /// Which one.
        what: &'static str,
        /// What is wrong with it.
        fact: String,
        /// What to do.
        way_out: &'static str,
    },
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
    /// Too few feature vectors for the measure.
    #[error("{n} feature vectors; {measure} needs {least} at least, so take more images")]
    FewVectors {
        /// How many there are.
        n: usize,
        /// The measure.
        measure: &'static str,
        /// How many it needs.
        least: usize,
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
    /// A kernel's width that is none.
    #[error("sigma = {sigma}; the width of the kernel is a finite number above 0")]
    KernelWidth {
        /// The value.
        sigma: f64,
    },
    /// A set in which no image could be read.
    #[error(
        "set {name:?} has no image that can be read ({n_failed} failed{first}); give a folder with PNG or JPEG images"
    )]
    EmptySet {
        /// Its name.
        name: String,
        /// How many could not be read.
        n_failed: usize,
        /// The first of them, and why.
        first: String,
    },
    /// A setting of the comparison out of its range.
    #[error("{name} = {value}; expected {expected}")]
    DivergenceSetting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// Sets that cannot be compared with each other.
    #[error("{fact}; {way_out}")]
    NotComparable {
        /// Why not.
        fact: String,
        /// What to do.
        way_out: &'static str,
    },
    /// A plot that the plotting library refuses.
    #[error("the plot of {what} cannot be drawn: {reason}; the numbers are in divergence.json")]
    Plot {
        /// What it shows.
        what: String,
        /// What the library says.
        reason: String,
    },
}
