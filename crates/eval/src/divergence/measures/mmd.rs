//! Maximum mean discrepancy of two sets of feature vectors.

use rayon::prelude::*;

use super::vectors::FeatureVectors;
use crate::EvalError;

/// Width of the kernel of CMMD.
pub const CMMD_SIGMA: f64 = 10.0;

/// What CMMD is multiplied by, so that its numbers can be read.
pub const CMMD_SCALE: f64 = 1000.0;

/// How alike two feature vectors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MmdKernel {
    /// `(x·y / d + 1)³`, the kernel of KID.
    Cubic,
    /// `exp(−|x − y|² / 2σ²)`, the kernel of CMMD.
    Rbf {
        /// Its width, in the units of the features.
        sigma: f64,
    },
}

impl MmdKernel {
    /// Its value for two vectors of one length.
    pub(in crate::divergence) fn of(self, x: &[f64], y: &[f64]) -> f64 {
        match self {
            Self::Cubic => {
                let dot: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
                #[expect(clippy::cast_precision_loss, reason = "a number of dimensions")]
                let d = x.len() as f64;
                (dot / d + 1.0).powi(3)
            }
            Self::Rbf { sigma } => {
                let square: f64 = x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum();
                libm::exp(-square / (2.0 * sigma * sigma))
            }
        }
    }
}

/// Sums of a kernel inside and between two sets, out of which both estimates are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelSums {
    /// Vectors of the first set.
    pub n_a: f64,
    /// Vectors of the second set.
    pub n_b: f64,
    /// Sum over pairs of different vectors of the first set.
    pub between_a: f64,
    /// The same of the second.
    pub between_b: f64,
    /// Sum over the vectors of the first set with themselves.
    pub self_a: f64,
    /// The same of the second.
    pub self_b: f64,
    /// Sum over pairs of one of the first and one of the second.
    pub across: f64,
}

impl KernelSums {
    /// The sums for two sets, by all pairs.
    fn of(a: &FeatureVectors, b: &FeatureVectors, kernel: MmdKernel) -> Result<Self, EvalError> {
        a.check_like(b)?;
        let inside = |set: &FeatureVectors| -> (f64, f64) {
            let rows: Vec<&[f64]> = set.rows().collect();
            let sums: Vec<(f64, f64)> = rows
                .par_iter()
                .enumerate()
                .map(|(i, x)| {
                    let after = rows.iter().skip(i + 1).map(|y| kernel.of(x, y));
                    (2.0 * after.sum::<f64>(), kernel.of(x, x))
                })
                .collect();
            sums.iter()
                .fold((0.0, 0.0), |(b, s), (x, y)| (b + x, s + y))
        };
        let rows_b: Vec<&[f64]> = b.rows().collect();
        let rows_a: Vec<&[f64]> = a.rows().collect();
        let across: Vec<f64> = rows_a
            .par_iter()
            .map(|x| rows_b.iter().map(|y| kernel.of(x, y)).sum())
            .collect();
        let ((between_a, self_a), (between_b, self_b)) = (inside(a), inside(b));
        #[expect(clippy::cast_precision_loss, reason = "numbers of images")]
        let (n_a, n_b) = (a.n() as f64, b.n() as f64);
        Ok(Self {
            n_a,
            n_b,
            between_a,
            between_b,
            self_a,
            self_b,
            across: across.iter().sum(),
        })
    }

    /// The unbiased estimate of MMD², without the pairs of a vector with itself; may be negative.
    #[must_use]
    pub fn unbiased(&self) -> f64 {
        let Self { n_a, n_b, .. } = *self;
        self.between_a / (n_a * (n_a - 1.0)) + self.between_b / (n_b * (n_b - 1.0))
            - 2.0 * self.across / (n_a * n_b)
    }

    /// The estimate of MMD² with all pairs, from 0 on; biased upward.
    #[must_use]
    pub fn biased(&self) -> f64 {
        let Self { n_a, n_b, .. } = *self;
        let inside_a = (self.between_a + self.self_a) / (n_a * n_a);
        let inside_b = (self.between_b + self.self_b) / (n_b * n_b);
        (inside_a + inside_b - 2.0 * self.across / (n_a * n_b)).max(0.0)
    }
}

/// The kernel inception distance: the unbiased estimate of MMD² with the cubic kernel
/// `(x·y / d + 1)³`, over all pairs (no subsets). It may be slightly negative.
///
/// **Source**: \[Binkowski2018\]; the estimate is that of \[Gretton2012\].
///
/// # Errors
/// [`EvalError::VectorLengths`], and [`EvalError::FewVectors`] below two vectors.
pub fn kernel_inception_distance(a: &FeatureVectors, b: &FeatureVectors) -> Result<f64, EvalError> {
    let n = a.n().min(b.n());
    if n < 2 {
        return Err(EvalError::FewVectors {
            n,
            measure: "KID",
            least: 2,
        });
    }
    Ok(KernelSums::of(a, b, MmdKernel::Cubic)?.unbiased())
}

/// The biased estimate of MMD² with the kernel `exp(−|x − y|² / 2σ²)`. CMMD is this with
/// [`CMMD_SIGMA`], times [`CMMD_SCALE`], over CLIP features of length 1.
///
/// **Source**: \[Jayasumana2024\], \[Gretton2012\].
///
/// # Errors
/// [`EvalError::VectorLengths`], [`EvalError::KernelWidth`].
pub fn mmd_rbf_biased(
    a: &FeatureVectors,
    b: &FeatureVectors,
    sigma: f64,
) -> Result<f64, EvalError> {
    if !(sigma.is_finite() && sigma > 0.0) {
        return Err(EvalError::KernelWidth { sigma });
    }
    Ok(KernelSums::of(a, b, MmdKernel::Rbf { sigma })?.biased())
}
