//! How far two distributions are apart: measures on counts, on normal distributions and on vectors.

mod frechet;
mod gaussian;
mod histogram;
mod mmd;
mod sum;
mod vectors;

pub(super) use frechet::frechet_of_rows;
pub use frechet::{FrechetDistance, frechet_distance, frechet_squared};
pub use gaussian::{Gaussian, gaussian_kl};
pub use histogram::{HistogramDivergence, circular_w1_bins, histogram_divergence};
pub use mmd::{
    CMMD_SCALE, CMMD_SIGMA, KernelSums, MmdKernel, kernel_inception_distance, mmd_rbf_biased,
};
pub use vectors::FeatureVectors;
