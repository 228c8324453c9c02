//! Two sets of feature vectors compared: Fréchet distance and kernel distance.

use nalgebra::{Cholesky, DMatrix, SVD, SymmetricEigen};
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

/// Most steps in search of the eigenvalues or singular values of a matrix, per row; two or three are usual.
const STEPS_PER_ROW: usize = 100;

/// [`VectorComparison::frechet`], in double precision: for `S_a = F Fᵀ` and `S_b = G Gᵀ`, whatever F and G are, the
/// root's trace is the sum of the singular values of `Fᵀ G`, so that nothing complex comes up and no root is taken of
/// what rounding left of 0.
fn frechet_squared(a: &[&[f64]], b: &[&[f64]], d: usize) -> Result<f64, EvalError> {
    let ((mean_a, of_a), (mean_b, of_b)) = (moments(a, d), moments(b, d));
    let trace = of_a.trace() + of_b.trace();
    let halves = half_of(of_a).zip(half_of(of_b));
    let cross = halves.and_then(|(a, b)| singular_sum(a.transpose() * b));
    let cross = cross.ok_or(EvalError::Eigenvalues)?;
    let gaps = mean_a.iter().zip(&mean_b).map(|(a, b)| (a - b).powi(2));
    let squared = gaps.sum::<f64>() + trace - 2.0 * cross;
    // Infinite where covariances overflow.
    match squared.is_finite() {
        true => Ok(squared.max(0.0)),
        false => Err(EvalError::Eigenvalues),
    }
}

/// F with F Fᵀ = S: Cholesky's, or, of a covariance that has none because it is of lower rank, the eigenvectors
/// times the roots of their values, of which rounding made some negative. None where they are not found.
fn half_of(covariance: DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !covariance.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    if let Some(cholesky) = Cholesky::new(covariance.clone()) {
        return Some(cholesky.unpack());
    }
    let n_most = STEPS_PER_ROW * covariance.nrows();
    let eigen = SymmetricEigen::try_new(covariance, f64::EPSILON, n_most)?;
    let mut half = eigen.eigenvectors;
    for (mut column, value) in half.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column *= value.max(0.0).sqrt();
    }
    Some(half)
}

/// Sum of the singular values, if they are found.
fn singular_sum(m: DMatrix<f64>) -> Option<f64> {
    if !m.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let n_most = STEPS_PER_ROW * m.nrows();
    let svd = SVD::try_new(m, false, false, f64::EPSILON, n_most)?;
    Some(svd.singular_values.iter().sum())
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

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    /// The distance of two sets of vectors.
    fn frechet(a: &[&[f64]], b: &[&[f64]]) -> Result<f64, EvalError> {
        frechet_squared(a, b, a[0].len())
    }

    #[test]
    fn of_one_value_it_is_that_of_means_and_deviations() {
        // Deviations 1 and 3, means 0 and 5.
        let root = 0.5_f64.sqrt();
        let (a, b) = ([[-root], [root]], [[5.0 - 3.0 * root], [5.0 + 3.0 * root]]);
        let squared = frechet(&[&a[0], &a[1]], &[&b[0], &b[1]]).unwrap();
        assert!((squared - (25.0 + 4.0)).abs() < 1e-12, "{squared}");
    }

    #[test]
    fn of_lower_rank_it_is_that_within_the_line() {
        // Along one direction of space, with values that are always 0 beside it, and equal ones.
        let line = |t: f64| [t, 2.0 * t, 2.0 * t, 0.0, 0.0];
        let (a, b) = ([-1.0, 0.0, 1.0].map(line), [-3.0, 0.0, 3.0].map(line));
        let (a, b): (Vec<_>, Vec<_>) = (
            a.iter().map(<[f64; 5]>::as_slice).collect(),
            b.iter().map(<[f64; 5]>::as_slice).collect(),
        );
        // Deviations 3 and 9 along it.
        let squared = frechet(&a, &b).unwrap();
        assert!((squared - 36.0).abs() < 1e-9, "{squared}");
        assert!(frechet(&a, &a).unwrap() < 1e-9, "none from itself");
        let still = [&[1.0; 5][..], &[1.0; 5]];
        let squared = frechet(&a, &still).unwrap();
        assert!((squared - 9.0 - 5.0).abs() < 1e-9, "{squared}");
    }

    #[test]
    fn zeros_and_ones_and_what_overflows_come_to_an_end() {
        let bits = |k: u32| {
            (0..12)
                .map(|bit| f64::from(((k * 37) >> (bit % 6)) & 1))
                .collect()
        };
        let rows: Vec<Vec<f64>> = (0..30).map(bits).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        assert!(frechet(&rows, &rows).unwrap() < 1e-9);
        let huge = [&[1e99, 1.0][..], &[-1e99, 2.0], &[0.0, 3.0]];
        let squared = frechet(&huge, &huge).unwrap();
        assert!(squared < 1e190, "{squared}, of 1e198");
        let beyond = [&[1e200, 1.0][..], &[-1e200, 2.0], &[0.0, 3.0]];
        assert!(frechet(&beyond, &beyond).is_err());
    }
}
