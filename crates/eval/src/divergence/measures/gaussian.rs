//! Normal distributions: mean and covariance.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};

use super::vectors::FeatureVectors;
use crate::EvalError;

/// How far a covariance may be from its mirror image, as a part of its largest value.
const ASYMMETRY: f64 = 1e-8;

/// A normal distribution in d dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    mean: Vec<f64>,
    /// Row by row, symmetric.
    covariance: Vec<f64>,
}

impl Gaussian {
    /// The distribution of this mean and covariance (row by row).
    ///
    /// # Errors
    /// [`EvalError::Dimensions`] where their lengths do not fit, [`EvalError::Covariance`] where the
    /// matrix is not finite or not symmetric. That it is positive is checked where it matters.
    pub fn new(mean: Vec<f64>, covariance: Vec<f64>) -> Result<Self, EvalError> {
        let d = mean.len();
        let expected = d.saturating_mul(d);
        if d == 0 || covariance.len() != expected {
            return Err(EvalError::Dimensions {
                what: "a covariance",
                n_values: covariance.len(),
                n_dimensions: d,
                expected,
            });
        }
        let refuse = |fact: String| EvalError::Covariance {
            what: "the matrix",
            fact,
            way_out: "give finite means and a symmetric matrix, row by row",
        };
        if !mean.iter().chain(&covariance).all(|v| v.is_finite()) {
            return Err(refuse("a value is not finite".to_owned()));
        }
        let largest = covariance.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut gaussian = Self { mean, covariance };
        for i in 0..d {
            for j in 0..i {
                let (low, high) = (gaussian.at(i, j), gaussian.at(j, i));
                if (low - high).abs() > ASYMMETRY * largest {
                    return Err(refuse(format!(
                        "its ({i}, {j}) is {low} and its ({j}, {i}) is {high}"
                    )));
                }
                let middle = f64::midpoint(low, high);
                gaussian.set(i, j, middle);
                gaussian.set(j, i, middle);
            }
        }
        Ok(gaussian)
    }

    /// Mean and unbiased covariance (divided by n − 1) of feature vectors.
    ///
    /// # Errors
    /// [`EvalError::FewVectors`] below two.
    pub fn of(vectors: &FeatureVectors) -> Result<Self, EvalError> {
        let rows: Vec<&[f64]> = vectors.rows().collect();
        Self::of_rows(&rows, vectors.n_dimensions())
    }

    /// As [`Gaussian::of`], of some of the vectors.
    pub(super) fn of_rows(rows: &[&[f64]], d: usize) -> Result<Self, EvalError> {
        let n = rows.len();
        if n < 2 {
            return Err(EvalError::FewVectors {
                n,
                measure: "a covariance",
                least: 2,
            });
        }
        let mut mean = vec![0.0; d];
        for row in rows {
            for (sum, value) in mean.iter_mut().zip(*row) {
                *sum += value;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a number of images")]
        let count = n as f64;
        for value in &mut mean {
            *value /= count;
        }
        let centered = Mat::from_fn(n, d, |i, j| {
            let value = rows.get(i).and_then(|row| row.get(j));
            value.copied().unwrap_or_default() - mean.get(j).copied().unwrap_or_default()
        });
        let product = centered.transpose() * &centered;
        let covariance = (0..d)
            .flat_map(|i| (0..d).map(move |j| (i, j)))
            .map(|(i, j)| f64::midpoint(product[(i, j)], product[(j, i)]) / (count - 1.0))
            .collect();
        Ok(Self { mean, covariance })
    }

    /// Its dimensions.
    #[must_use]
    pub fn n_dimensions(&self) -> usize {
        self.mean.len()
    }

    /// Its mean.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Its covariance, row by row.
    #[must_use]
    pub fn covariance(&self) -> &[f64] {
        &self.covariance
    }

    pub(super) fn matrix(&self) -> MatRef<'_, f64> {
        let d = self.mean.len();
        MatRef::from_row_major_slice(&self.covariance, d, d)
    }

    /// With a share `lambda` of the covariance replaced by its mean variance in every direction.
    pub(super) fn shrunk(mut self, lambda: f64) -> Self {
        let d = self.mean.len();
        let trace: f64 = (0..d).map(|i| self.at(i, i)).sum();
        #[expect(clippy::cast_precision_loss, reason = "a number of dimensions")]
        let level = trace / d as f64;
        for (at, value) in self.covariance.iter_mut().enumerate() {
            *value *= 1.0 - lambda;
            if at % (d + 1) == 0 {
                *value += lambda * level;
            }
        }
        self
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        let place = i * self.mean.len() + j;
        self.covariance.get(place).copied().unwrap_or_default()
    }

    fn set(&mut self, i: usize, j: usize, value: f64) {
        let place = i * self.mean.len() + j;
        if let Some(slot) = self.covariance.get_mut(place) {
            *slot = value;
        }
    }
}

/// `KL(a‖b)` of two normal distributions, nats:
/// `½ (tr(S_b⁻¹ S_a) + (m_b − m_a)ᵀ S_b⁻¹ (m_b − m_a) − d + ln(det S_b / det S_a))`.
///
/// **Source**: \[KullbackLeibler1951\]; by Cholesky factors, no inverse is formed.
///
/// # Errors
/// [`EvalError::VectorLengths`] for different dimensions, [`EvalError::Covariance`] where one is not
/// positive definite: then the divergence is infinite or without meaning.
///
/// # Example
/// ```
/// use starbreak_eval::divergence::{Gaussian, gaussian_kl};
/// let narrow = Gaussian::new(vec![0.0], vec![1.0])?;
/// let wide = Gaussian::new(vec![1.0], vec![4.0])?;
/// assert!((gaussian_kl(&narrow, &wide)? - 0.443_147_180_559_945_3).abs() < 1e-15);
/// # Ok::<(), starbreak_eval::EvalError>(())
/// ```
pub fn gaussian_kl(a: &Gaussian, b: &Gaussian) -> Result<f64, EvalError> {
    let d = a.n_dimensions();
    if d != b.n_dimensions() {
        return Err(EvalError::VectorLengths {
            n_a: d,
            n_b: b.n_dimensions(),
        });
    }
    let refuse = |what| EvalError::Covariance {
        what,
        fact: "it is not positive definite".to_owned(),
        way_out: "take more images than dimensions, or shrink it",
    };
    let factor_a = a
        .matrix()
        .llt(Side::Lower)
        .map_err(|_| refuse("that of the first"))?;
    let factor_b = b
        .matrix()
        .llt(Side::Lower)
        .map_err(|_| refuse("that of the second"))?;
    let log_det = |factor: MatRef<'_, f64>| -> f64 {
        let logs = (0..d).map(|i| libm::log(factor[(i, i)]));
        2.0 * logs.sum::<f64>()
    };
    let spread = factor_b.solve(a.matrix());
    let trace: f64 = (0..d).map(|i| spread[(i, i)]).sum();
    let gap = Mat::from_fn(d, 1, |i, _| {
        b.mean.get(i).copied().unwrap_or_default() - a.mean.get(i).copied().unwrap_or_default()
    });
    let pulled = factor_b.solve(&gap);
    let distance: f64 = (0..d).map(|i| gap[(i, 0)] * pulled[(i, 0)]).sum();
    #[expect(clippy::cast_precision_loss, reason = "a number of dimensions")]
    let kl = 0.5 * (trace + distance - d as f64 + log_det(factor_b.L()) - log_det(factor_a.L()));
    if kl.is_finite() {
        return Ok(kl.max(0.0));
    }
    Err(refuse("one of the two"))
}
