//! Two sets of feature vectors compared: Fréchet distance and kernel distance.

use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;
use serde::Serialize;

use crate::EvalError;

/// Larger values would overflow in a covariance.
const LARGEST: f64 = 1e100;

/// Vectors of one length, one for each image, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureVectors {
    origin: String,
    n_dimensions: usize,
    values: Vec<f64>,
}

impl FeatureVectors {
    /// Vectors of `n_dimensions` values each, one after the other; `origin` says where they come from.
    ///
    /// # Errors
    /// [`EvalError::Dimensions`] where they do not come out even or there are none,
    /// [`EvalError::FeatureValue`] for one that is NaN, infinite or beyond 1e100.
    pub fn new(origin: &str, n_dimensions: usize, values: Vec<f64>) -> Result<Self, EvalError> {
        if n_dimensions == 0 || values.is_empty() || !values.len().is_multiple_of(n_dimensions) {
            return Err(EvalError::Dimensions {
                n_values: values.len(),
                n_dimensions,
            });
        }
        let is_bad = |value: &f64| !(value.is_finite() && value.abs() < LARGEST);
        if let Some(at) = values.iter().position(is_bad) {
            return Err(EvalError::FeatureValue {
                row: at / n_dimensions,
                column: at % n_dimensions,
                value: values[at],
            });
        }
        Ok(Self {
            origin: origin.to_owned(),
            n_dimensions,
            values,
        })
    }

    /// How many there are.
    pub(super) fn n(&self) -> usize {
        self.values.len() / self.n_dimensions
    }

    fn rows(&self) -> Vec<&[f64]> {
        self.values.chunks_exact(self.n_dimensions).collect()
    }
}

/// Two sets compared by feature vectors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VectorComparison {
    /// Where the vectors come from: model and layer, or files.
    pub origin: String,
    /// Values per vector.
    pub n_dimensions: usize,
    /// Vectors of the first set.
    pub n_a: usize,
    /// Vectors of the second set.
    pub n_b: usize,
    /// Whether a set has no more vectors than dimensions: then `frechet` is far too large, and `kid` is the
    /// number to read.
    pub is_rank_deficient: bool,
    /// Squared Fréchet distance of two normal distributions of these means and sample covariances (divided by
    /// n − 1), which is what is called FID:
    /// `|m_a − m_b|² + tr(S_a) + tr(S_b) − 2 tr((S_a^½ S_b S_a^½)^½)`. It is biased upward, the more the
    /// fewer vectors per dimension. **Source**: \[DowsonLandau1982\], \[Heusel2017\].
    pub frechet: f64,
    /// Kernel inception distance: the unbiased estimate of MMD² with the kernel `(x·y / d + 1)³`, over all
    /// pairs (no subsets). It may be slightly negative. **Source**: \[Binkowski2018\]; the estimate is that of
    /// \[Gretton2012\].
    pub kid: f64,
}

/// Two sets of feature vectors compared.
///
/// # Errors
/// [`EvalError::VectorLengths`], [`EvalError::FewVectors`] below two vectors in a set,
/// [`EvalError::Eigenvalues`].
pub fn compare_vectors(
    a: &FeatureVectors,
    b: &FeatureVectors,
) -> Result<VectorComparison, EvalError> {
    let n_dimensions = a.n_dimensions;
    if n_dimensions != b.n_dimensions {
        return Err(EvalError::VectorLengths {
            n_a: n_dimensions,
            n_b: b.n_dimensions,
        });
    }
    let n = a.n().min(b.n());
    if n < 2 {
        return Err(EvalError::FewVectors { n });
    }
    let origin = if a.origin == b.origin {
        a.origin.clone()
    } else {
        format!("{} and {}", a.origin, b.origin)
    };
    Ok(VectorComparison {
        origin,
        n_dimensions,
        n_a: a.n(),
        n_b: b.n(),
        is_rank_deficient: n <= n_dimensions,
        frechet: frechet_squared(&a.rows(), &b.rows(), n_dimensions)?,
        kid: kernel_inception_distance(&a.rows(), &b.rows()),
    })
}

/// [`VectorComparison::frechet`], in double precision: for `S_a = F Fᵀ`, whatever F is, the root's trace is the
/// sum of the roots of the eigenvalues of `Fᵀ S_b F`, which is symmetric, so that nothing complex comes up;
/// eigenvalues that rounding made negative count as 0.
fn frechet_squared(a: &[&[f64]], b: &[&[f64]], d: usize) -> Result<f64, EvalError> {
    let ((mean_a, of_a), (mean_b, of_b)) = (moments(a, d), moments(b, d));
    let trace = of_a.trace() + of_b.trace();
    // What is not finite has no eigenvalues, and looking for them would not end.
    if !trace.is_finite() {
        return Err(EvalError::Eigenvalues);
    }
    let half = half_of(of_a);
    let product = symmetric(half.tr_mul(&(of_b * &half)));
    if !product.iter().all(|entry| entry.is_finite()) {
        return Err(EvalError::Eigenvalues);
    }
    let values = product.symmetric_eigenvalues();
    let cross: f64 = values.iter().map(|value| value.max(0.0).sqrt()).sum();
    let gaps = mean_a.iter().zip(&mean_b).map(|(a, b)| (a - b).powi(2));
    Ok((gaps.sum::<f64>() + trace - 2.0 * cross).max(0.0))
}

/// F with F Fᵀ = S: Cholesky's, or, of a covariance that has none because it is of lower rank, the eigenvectors
/// times the roots of their values.
fn half_of(covariance: DMatrix<f64>) -> DMatrix<f64> {
    if let Some(cholesky) = Cholesky::new(covariance.clone()) {
        return cholesky.unpack();
    }
    let eigen = covariance.symmetric_eigen();
    let mut half = eigen.eigenvectors;
    for (mut column, value) in half.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column *= value.max(0.0).sqrt();
    }
    half
}

/// Mean and sample covariance.
fn moments(rows: &[&[f64]], d: usize) -> (Vec<f64>, DMatrix<f64>) {
    let mut mean = vec![0.0; d];
    for row in rows {
        for (sum, value) in mean.iter_mut().zip(*row) {
            *sum += value;
        }
    }
    let n = real(rows.len());
    for value in &mut mean {
        *value /= n;
    }
    // One vector per column, as they lie in memory.
    let centered = DMatrix::from_fn(d, rows.len(), |i, j| rows[j][i] - mean[i]);
    let product = &centered * centered.transpose();
    (mean, symmetric(product) / (n - 1.0))
}

/// A matrix that rounding made not quite symmetric.
fn symmetric(mut m: DMatrix<f64>) -> DMatrix<f64> {
    for i in 0..m.nrows() {
        for j in 0..i {
            m[(i, j)] = f64::midpoint(m[(i, j)], m[(j, i)]);
            m[(j, i)] = m[(i, j)];
        }
    }
    m
}

/// [`VectorComparison::kid`].
fn kernel_inception_distance(a: &[&[f64]], b: &[&[f64]]) -> f64 {
    let kernel = |x: &[f64], y: &[f64]| {
        let dot: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
        (dot / real(x.len()) + 1.0).powi(3)
    };
    // The sum of all x with those y that a place in the list leaves.
    let sum = |xs: &[&[f64]], of: &(dyn Fn(usize) -> f64 + Sync)| -> f64 {
        let sums: Vec<f64> = (0..xs.len()).into_par_iter().map(of).collect();
        sums.iter().sum()
    };
    let inside = |xs: &[&[f64]]| {
        let after = |i: usize| xs[i + 1..].iter().map(|y| kernel(xs[i], y)).sum::<f64>();
        let n = real(xs.len());
        sum(xs, &|i| 2.0 * after(i)) / (n * (n - 1.0))
    };
    let across = sum(a, &|i| b.iter().map(|y| kernel(a[i], y)).sum());
    inside(a) + inside(b) - 2.0 * across / (real(a.len()) * real(b.len()))
}

#[expect(clippy::cast_precision_loss, reason = "a number of images or values")]
fn real(n: usize) -> f64 {
    n as f64
}
