//! How far sets of images are apart, by the definition `div/1`.

mod activations;
mod compare;
mod draws;
mod estimate;
mod experiment;
mod features;
mod given;
mod matrix_plot;
mod measures;
mod notes;
mod report;
mod sets;
mod table;

pub use activations::compare_vectors;
pub use compare::{OrderingClaim, compare_sets};
pub use experiment::{PaperComparison, PaperExperiment, PaperRole, paper_experiment};
pub use features::{AnalysisSize, Background, BinAxis, CrackGeometry, Feature};
pub use given::measure_given;
pub use matrix_plot::divergence_svg;
pub use measures::{
    CMMD_SCALE, CMMD_SIGMA, FeatureVectors, FrechetDistance, Gaussian, HistogramDivergence,
    KernelSums, MmdKernel, circular_w1_bins, frechet_distance, frechet_squared, gaussian_kl,
    histogram_divergence, kernel_inception_distance, mmd_rbf_biased,
};
pub use report::{
    CompareSettings, DEFINITION, DivergenceReport, Estimate, FeatureComparison, FeatureOrdering,
    Measure, OrderingTest, PairComparison, REPORT_SCHEMA, SetFloor, VectorComparison,
};
pub use sets::{
    FailedImage, ImageFile, ImageSet, NamedPattern, PixelsOf, ReadSettings, SetSummary, VectorOf,
};
pub use table::divergence_csv;
