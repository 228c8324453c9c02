//! Wilcoxon's signed-rank test.

use serde::{Deserialize, Serialize};

use super::proportion::as_f64;
use super::{Measured, Method, TestOutcome, two_sided_normal_p};

/// Differences up to which all signs are gone through.
const EXACT_UP_TO: usize = 200;

/// Whether differences lie around 0, and how far to one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SignedRank {
    /// Sum of the ranks of differences above 0.
    pub w_plus: f64,
    /// Sum of the ranks of differences below 0.
    pub w_minus: f64,
    /// Differences that are 0, which are left out \[Wilcoxon1945\].
    pub n_zero: u64,
    /// The test; its n are the differences that are not 0.
    pub test: TestOutcome,
    /// Effect: (W⁺ − W⁻)/(W⁺ + W⁻), −1 to 1 \[Kerby2014\].
    pub effect: Measured,
}

/// Wilcoxon's signed-rank test of differences, two-sided; equal sizes share their mean rank.
///
/// For up to 200 differences p is exact, over all 2ⁿ signs of the ranks at hand, so with ties, too:
/// min(1, 2 min(P(W ≤ W⁺), P(W ≥ W⁺))). For more it is by the normal distribution with the variance
/// Σ rank²/4, no correction for continuity. What is not finite is left out with the zeros.
#[must_use]
pub fn signed_rank_test(differences: &[f64]) -> SignedRank {
    let mut sizes: Vec<(f64, bool)> = differences
        .iter()
        .filter(|d| d.is_finite() && d.abs() > 0.0)
        .map(|d| (d.abs(), *d > 0.0))
        .collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ranks = doubled_ranks(&sizes);
    let n = sizes.len() as u64;
    let n_zero = differences.len() as u64 - n;
    let total: u64 = ranks.iter().sum();
    let above: u64 = ranks
        .iter()
        .zip(&sizes)
        .filter(|(_, it)| it.1)
        .map(|(rank, _)| rank)
        .sum();
    let (w_plus, w_minus) = (as_f64(above) / 2.0, as_f64(total - above) / 2.0);
    if n == 0 {
        let why = "no difference is other than 0";
        return SignedRank {
            w_plus,
            w_minus,
            n_zero,
            test: TestOutcome::none(0, Method::SignedRankExact, why),
            effect: Measured::none(0, Method::RankBiserial, why),
        };
    }
    let test = if sizes.len() <= EXACT_UP_TO {
        TestOutcome::of(exact_p(&ranks, above, total), n, Method::SignedRankExact)
    } else {
        let variance: f64 = ranks.iter().map(|rank| as_f64(*rank).powi(2)).sum::<f64>() / 16.0;
        let z = (w_plus - as_f64(total) / 4.0) / variance.sqrt();
        TestOutcome::of(two_sided_normal_p(z), n, Method::SignedRankNormal)
    };
    let effect = (w_plus - w_minus) / (w_plus + w_minus);
    SignedRank {
        w_plus,
        w_minus,
        n_zero,
        test,
        effect: Measured::of(effect, n, Method::RankBiserial),
    }
}

/// Twice the rank of each, equal ones with their mean: whole numbers.
fn doubled_ranks(sorted: &[(f64, bool)]) -> Vec<u64> {
    let mut ranks = Vec::with_capacity(sorted.len());
    for group in sorted.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        let first = ranks.len() as u64 + 1;
        let last = ranks.len() as u64 + group.len() as u64;
        ranks.extend(std::iter::repeat_n(first + last, group.len()));
    }
    ranks
}

/// Two-sided p of a doubled sum over all signs.
fn exact_p(ranks: &[u64], above: u64, total: u64) -> f64 {
    let Ok(n_sums) = usize::try_from(total + 1) else {
        return f64::NAN;
    };
    // chance[s]: probability that the ranks so far with a plus sum to s.
    let mut chance = vec![0.0_f64; n_sums];
    chance[0] = 1.0;
    let mut reached = 0_usize;
    for rank in ranks {
        let Ok(rank) = usize::try_from(*rank) else {
            return f64::NAN;
        };
        reached += rank;
        for sum in (0..=reached).rev() {
            let with = if sum >= rank { chance[sum - rank] } else { 0.0 };
            chance[sum] = 0.5 * (chance[sum] + with);
        }
    }
    // By symmetry the upper tail at `above` is the lower one at `total - above`.
    let Ok(low) = usize::try_from(above.min(total - above)) else {
        return f64::NAN;
    };
    let tail: f64 = chance[..=low].iter().sum();
    (2.0 * tail).min(1.0)
}
