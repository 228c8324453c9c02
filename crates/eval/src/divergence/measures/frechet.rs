//! The Fréchet distance of two normal distributions, as FID has it.

use faer::{Mat, MatRef, Side};
use serde::Serialize;

use super::gaussian::Gaussian;
use super::vectors::FeatureVectors;
use crate::EvalError;

/// A negative eigenvalue below this part of the largest is no rounding.
const NEGATIVE: f64 = 1e-7;

/// The Fréchet distance of two sets of feature vectors, without and with shrinkage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrechetDistance {
    /// Squared distance by the unbiased sample covariances, which is what is called FID. It is
    /// biased upward, the more the fewer vectors per dimension.
    pub d2: f64,
    /// The same with each covariance shrunk by its own share.
    pub d2_shrunk: f64,
    /// Share of the first covariance that is replaced by its mean variance in every direction, 0 to 1.
    pub shrinkage_a: f64,
    /// The same of the second.
    pub shrinkage_b: f64,
    /// Whether a set has no more vectors than dimensions: then trust `d2_shrunk` for the order only, and
    /// neither as a number to compare with that of other sets.
    pub is_rank_deficient: bool,
}

/// The Fréchet distance of two sets of feature vectors.
///
/// **Source**: \[DowsonLandau1982\], \[Heusel2017\]; shrinkage \[LedoitWolf2004\], towards
/// the mean variance times the identity.
///
/// # Errors
/// [`EvalError::VectorLengths`], and [`EvalError::FewVectors`] below two vectors.
pub fn frechet_distance(
    a: &FeatureVectors,
    b: &FeatureVectors,
) -> Result<FrechetDistance, EvalError> {
    a.check_like(b)?;
    let (rows_a, rows_b): (Vec<&[f64]>, Vec<&[f64]>) = (a.rows().collect(), b.rows().collect());
    frechet_of_rows(&rows_a, &rows_b, a.n_dimensions())
}

/// As [`frechet_distance`], of some of the vectors.
pub(in crate::divergence) fn frechet_of_rows(
    a: &[&[f64]],
    b: &[&[f64]],
    d: usize,
) -> Result<FrechetDistance, EvalError> {
    let (plain_a, plain_b) = (Gaussian::of_rows(a, d)?, Gaussian::of_rows(b, d)?);
    let (shrinkage_a, shrinkage_b) = (ledoit_wolf(a, &plain_a), ledoit_wolf(b, &plain_b));
    Ok(FrechetDistance {
        d2: frechet_squared(&plain_a, &plain_b)?,
        d2_shrunk: frechet_squared(&plain_a.shrunk(shrinkage_a), &plain_b.shrunk(shrinkage_b))?,
        shrinkage_a,
        shrinkage_b,
        is_rank_deficient: a.len() <= d || b.len() <= d,
    })
}

/// The squared Fréchet (2-Wasserstein) distance of two normal distributions:
/// `|m_a − m_b|² + tr(S_a) + tr(S_b) − 2 tr((S_a^½ S_b S_a^½)^½)`, by two symmetric eigenvalue
/// problems in double precision, so that nothing complex comes up; eigenvalues that rounding made
/// negative count as 0.
///
/// **Source**: \[DowsonLandau1982\].
///
/// # Errors
/// [`EvalError::VectorLengths`] for different dimensions, [`EvalError::Covariance`] for a matrix with
/// a truly negative eigenvalue.
pub fn frechet_squared(a: &Gaussian, b: &Gaussian) -> Result<f64, EvalError> {
    let d = a.n_dimensions();
    if d != b.n_dimensions() {
        return Err(EvalError::VectorLengths {
            n_a: d,
            n_b: b.n_dimensions(),
        });
    }
    let root = square_root(a.matrix(), "that of the first")?;
    let product = &root * b.matrix() * &root;
    let symmetric = Mat::from_fn(d, d, |i, j| f64::midpoint(product[(i, j)], product[(j, i)]));
    let values = symmetric
        .self_adjoint_eigenvalues(Side::Lower)
        .map_err(|_| no_eigenvalues("that of both"))?;
    check_positive(&values, "that of the second")?;
    let cross: f64 = values.iter().map(|value| value.max(0.0).sqrt()).sum();
    let gap: f64 = a
        .mean()
        .iter()
        .zip(b.mean())
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    let trace = |m: MatRef<'_, f64>| (0..d).map(|i| m[(i, i)]).sum::<f64>();
    Ok((gap + trace(a.matrix()) + trace(b.matrix()) - 2.0 * cross).max(0.0))
}

/// The symmetric root of a symmetric matrix.
fn square_root(matrix: MatRef<'_, f64>, what: &'static str) -> Result<Mat<f64>, EvalError> {
    let d = matrix.nrows();
    let eigen = matrix
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| no_eigenvalues(what))?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let values: Vec<f64> = (0..d).map(|i| values[i]).collect();
    check_positive(&values, what)?;
    let scaled = Mat::from_fn(d, d, |i, j| {
        vectors[(i, j)] * values.get(j).copied().unwrap_or_default().max(0.0).sqrt()
    });
    Ok(&scaled * vectors.transpose())
}

fn check_positive(values: &[f64], what: &'static str) -> Result<(), EvalError> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values
        .iter()
        .copied()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    if least >= -NEGATIVE * most {
        return Ok(());
    }
    Err(EvalError::Covariance {
        what,
        fact: format!("its eigenvalues go from {least:e} to {most:e}"),
        way_out: "give a matrix without negative eigenvalues",
    })
}

fn no_eigenvalues(what: &'static str) -> EvalError {
    EvalError::Covariance {
        what,
        fact: "its eigenvalues do not converge".to_owned(),
        way_out: "scale the features to about 1",
    }
}

/// The share of shrinkage that makes the mean squared error of the covariance least.
///
/// With `S` divided by n: `λ = min(β, δ) / δ`, `δ = |S − μI|²`, `β = Σ |x xᵀ − S|² / n²`.
fn ledoit_wolf(rows: &[&[f64]], gaussian: &Gaussian) -> f64 {
    let d = gaussian.n_dimensions();
    #[expect(
        clippy::cast_precision_loss,
        reason = "numbers of images and dimensions"
    )]
    let (n, n_dimensions) = (rows.len() as f64, d as f64);
    let part = (n - 1.0) / n;
    let square: f64 = gaussian
        .covariance()
        .iter()
        .map(|v| (v * part).powi(2))
        .sum();
    let diagonal = gaussian.covariance().iter().step_by(d + 1);
    let level = diagonal.sum::<f64>() * part / n_dimensions;
    let delta = square - n_dimensions * level * level;
    // Σ |x xᵀ − S|² = Σ |x|⁴ − n |S|².
    let fourth: f64 = rows
        .iter()
        .map(|row| {
            let squares = row
                .iter()
                .zip(gaussian.mean())
                .map(|(v, m)| (v - m).powi(2));
            squares.sum::<f64>().powi(2)
        })
        .sum();
    let beta = (fourth / n - square) / n;
    if delta <= 0.0 || beta <= 0.0 {
        return if delta <= 0.0 { 1.0 } else { 0.0 };
    }
    (beta / delta).min(1.0)
}
