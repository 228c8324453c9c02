//! How far sets of images, crack networks or feature vectors are apart, by the definition `div/1`.

mod compare;
mod draws;
mod estimate;
mod experiment;
mod features;
mod histogram;
mod matrix_plot;
mod report;
mod set;
mod sum;
mod summed;
mod table;
mod vectors;

pub use compare::compare_sets;
pub use experiment::{
    FeatureOrdering, Ordering, PAPER_SETS, PaperComparison, PaperExperiment, paper_experiment,
};
pub use features::{Background, Feature, ReadSettings};
pub use histogram::{HistogramDivergence, histogram_divergence};
pub use matrix_plot::divergence_svg;
pub use report::{
    CompareSettings, DEFINITION, DivergenceReport, Estimate, FeatureComparison, Measure,
    PairComparison, SetFloor,
};
pub use set::{FailedImage, ImageSet, Item, SetSummary};
pub use summed::SummedSets;
pub use table::divergence_csv;
pub use vectors::{FeatureVectors, VectorComparison, compare_vectors};
