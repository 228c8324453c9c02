//! Measures on two histograms over the same bins.

use serde::{Serialize, Serializer};

use super::sum::pairwise_sum;
use crate::EvalError;

/// Below this `1 − BC` half of its digits are lost in the difference.
const LOST_DIGITS: f64 = 1e-9;

/// How far two histograms over the same bins are apart.
///
/// Each has `P_k = (p_k + α) / Σ (p + α)`. Natural logarithms; divergences are in nats.
///
/// **Source**: \[KullbackLeibler1951\], \[Jeffreys1946\], \[Lin1991\]; formulas at the fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HistogramDivergence {
    /// `KL(P‖Q) = Σ P ln(P/Q)`, 0 to infinity: infinite where Q is 0 and P is not.
    #[serde(serialize_with = "finite_or_text")]
    pub kl_pq: f64,
    /// `KL(Q‖P)`.
    #[serde(serialize_with = "finite_or_text")]
    pub kl_qp: f64,
    /// Jeffreys: `KL(P‖Q) + KL(Q‖P)`.
    #[serde(serialize_with = "finite_or_text")]
    pub jeffreys: f64,
    /// Jensen-Shannon: `(KL(P‖M) + KL(Q‖M)) / 2` with `M = (P + Q) / 2`, 0 to ln 2. Not its root.
    pub js: f64,
    /// First Wasserstein distance of bins in a row, in widths of a bin: `Σ |F_P − F_Q|` over the
    /// cumulative sums. It means something only where the bins have an order.
    pub w1_bins: f64,
    /// Hellinger distance, 0 to 1: `√(1 − Σ √(P Q))`.
    pub hellinger: f64,
    /// Total variation, 0 to 1: `Σ |P − Q| / 2`.
    pub tv: f64,
}

/// The divergence of two histograms of counts, with `alpha` more counts in each bin (Laplace; 0.5
/// is Jeffreys' prior). Counts need not be whole.
///
/// # Errors
/// [`EvalError::HistogramBins`] for different or no bins, [`EvalError::HistogramCount`] for counts
/// that are negative or above 2⁵³, [`EvalError::HistogramEmpty`] where nothing was counted, whatever
/// alpha is, [`EvalError::Smoothing`] for an alpha that is negative or above 2⁵³.
///
/// # Example
/// ```
/// use starbreak_eval::divergence::histogram_divergence;
/// let d = histogram_divergence(&[0.0, 2.0], &[1.0, 1.0], 0.0)?;
/// assert!((d.kl_pq - std::f64::consts::LN_2).abs() < 1e-15);
/// assert_eq!(d.kl_qp, f64::INFINITY);
/// # Ok::<(), starbreak_eval::EvalError>(())
/// ```
pub fn histogram_divergence(
    p: &[f64],
    q: &[f64],
    alpha: f64,
) -> Result<HistogramDivergence, EvalError> {
    let (p, q) = shares(p, q, alpha)?;
    // As SciPy has it, which divides once more by the sum: the same bits as there.
    let (p_again, q_again) = (normalized(&p), normalized(&q));
    let kl = |p: &[f64], q: &[f64]| sum_of(p, q, relative_entropy).max(0.0);
    let kl_pq = kl(&p_again, &q_again);
    let kl_qp = kl(&q_again, &p_again);
    let middle: Vec<f64> = p_again
        .iter()
        .zip(&q_again)
        .map(|(p, q)| (p + q) / 2.0)
        .collect();
    let js = (sum_of(&p_again, &middle, relative_entropy)
        + sum_of(&q_again, &middle, relative_entropy))
        / 2.0;
    let gap = 1.0 - sum_of(&p, &q, |p, q| (p * q).sqrt());
    let gap = if gap < LOST_DIGITS {
        0.5 * sum_of(&p, &q, |p, q| (p.sqrt() - q.sqrt()).powi(2))
    } else {
        gap
    };
    let gaps = p.iter().zip(&q).scan(0.0, |sum, (p, q)| {
        *sum += p - q;
        Some(f64::abs(*sum))
    });
    let steps: Vec<f64> = gaps.collect();
    Ok(HistogramDivergence {
        kl_pq,
        kl_qp,
        jeffreys: kl_pq + kl_qp,
        js: js.clamp(0.0, std::f64::consts::LN_2),
        w1_bins: pairwise_sum(&steps),
        hellinger: gap.sqrt(),
        tv: 0.5 * sum_of(&p, &q, |p, q| (p - q).abs()),
    })
}

/// More counts than a bin can have: above it a number no longer tells one more, and sums of such end in
/// infinity, of which every share is 0.
const MOST_COUNTS: f64 = 9_007_199_254_740_992.0;

/// Both as shares that sum to 1.
fn shares(p: &[f64], q: &[f64], alpha: f64) -> Result<(Vec<f64>, Vec<f64>), EvalError> {
    if p.len() != q.len() || p.is_empty() {
        return Err(EvalError::HistogramBins {
            n_p: p.len(),
            n_q: q.len(),
        });
    }
    if !(0.0..=MOST_COUNTS).contains(&alpha) {
        return Err(EvalError::Smoothing { alpha });
    }
    Ok((share("p", p, alpha)?, share("q", q, alpha)?))
}

fn share(which: &'static str, counts: &[f64], alpha: f64) -> Result<Vec<f64>, EvalError> {
    let is_count = |count: &f64| (0.0..=MOST_COUNTS).contains(count);
    if let Some(bin) = counts.iter().position(|count| !is_count(count)) {
        let value = counts.get(bin).copied().unwrap_or(f64::NAN);
        return Err(EvalError::HistogramCount { which, bin, value });
    }
    if counts.iter().all(|&count| count <= 0.0) {
        return Err(EvalError::HistogramEmpty { which });
    }
    let smoothed: Vec<f64> = counts.iter().map(|count| count + alpha).collect();
    Ok(normalized(&smoothed))
}

fn normalized(values: &[f64]) -> Vec<f64> {
    let sum = pairwise_sum(values);
    values.iter().map(|value| value / sum).collect()
}

fn sum_of(p: &[f64], q: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let terms: Vec<f64> = p.iter().zip(q).map(|(&p, &q)| term(p, q)).collect();
    pairwise_sum(&terms)
}

/// `x ln(x/y)`, true to the last digits also where both are nearly equal.
fn relative_entropy(x: f64, y: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return f64::INFINITY;
    }
    let ratio = x / y;
    if ratio > 0.5 && ratio < 2.0 {
        x * libm::log1p((x - y) / y)
    } else if ratio > f64::MIN_POSITIVE && ratio.is_finite() {
        x * libm::log(ratio)
    } else {
        x * (libm::log(x) - libm::log(y))
    }
}

/// JSON has no infinity: the text `inf`.
fn finite_or_text<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
    if value.is_infinite() {
        return to.serialize_str("inf");
    }
    to.serialize_f64(*value)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_histogram_is_no_distance_from_itself() {
        let counts = [3.0, 0.0, 17.0, 5.5, 1e9];
        let d = histogram_divergence(&counts, &counts, 0.5).unwrap();
        for (name, value) in [("kl", d.kl_pq), ("js", d.js), ("hellinger", d.hellinger)] {
            assert!(value.abs() < 1e-30, "{name} = {value:e}");
        }
    }

    #[test]
    fn counts_whose_sum_would_be_infinite_are_refused() {
        let wild = [[1e308, 1e308], [1.0, f64::INFINITY]];
        for counts in wild {
            let error = histogram_divergence(&counts, &[1.0, 1.0], 0.5).unwrap_err();
            assert!(error.to_string().contains("from 0 to 2^53"), "{error}");
        }
        let error = histogram_divergence(&[1.0, 2.0], &[1.0, 1.0], 1e308).unwrap_err();
        assert!(error.to_string().contains("alpha = 1e308"), "{error}");
        let most = histogram_divergence(&[MOST_COUNTS; 2], &[0.0, 1.0], 0.0).unwrap();
        assert!((most.tv - 0.5).abs() < 1e-15, "{most:?}");
    }

    #[test]
    fn disjoint_histograms_are_as_far_as_a_measure_goes() {
        let d = histogram_divergence(&[1.0, 0.0], &[0.0, 1.0], 0.0).unwrap();
        assert!(d.kl_pq.is_infinite() && d.kl_qp.is_infinite(), "{d:?}");
        assert!((d.js - std::f64::consts::LN_2).abs() < 1e-15, "{d:?}");
        assert!((d.hellinger - 1.0).abs() < 1e-15, "{d:?}");
        assert!((d.tv - 1.0).abs() < 1e-15, "{d:?}");
    }

    #[test]
    fn what_is_no_histogram_is_refused_by_name() {
        let said = |p: &[f64], q: &[f64], alpha| {
            histogram_divergence(p, q, alpha).unwrap_err().to_string()
        };
        let cases = [
            (
                said(&[], &[], 0.5),
                "histograms of 0 and 0 bins; count both over the same bins, at least one",
            ),
            (
                said(&[1.0], &[1.0, 2.0], 0.5),
                "histograms of 1 and 2 bins; count both over the same bins, at least one",
            ),
            (
                said(&[0.0, 0.0], &[1.0, 1.0], 0.5),
                "p is empty: nothing was counted; leave it out",
            ),
            (
                said(&[1.0, 0.0], &[1.0, -2.0], 0.5),
                "q[1] = -2e0; a count is from 0 to 2^53 = 9.007e15",
            ),
            (
                said(&[f64::NAN], &[1.0], 0.5),
                "p[0] = NaN; a count is from 0 to 2^53 = 9.007e15",
            ),
            (
                said(&[1.0], &[1.0], -0.5),
                "alpha = -5e-1 counts per bin; expected 0 to 2^53, usually 0.5",
            ),
        ];
        for (got, expected) in cases {
            assert_eq!(got, expected, "one line");
        }
    }
}
