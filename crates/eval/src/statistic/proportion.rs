//! Shares of counts and their differences between pairs.

use serde::{Deserialize, Serialize};

use super::{
    Interval, MIN_UNITS, Measured, Method, TestOutcome, normal_quantile, student_quantile,
};

/// The share `k / n` with Wilson's interval; without a value where `n` is 0.
///
/// The interval takes the n things as independent; objects of one image are not quite, so intervals
/// over images come from [`resampling`](crate::resampling).
#[must_use]
pub fn proportion(k: u64, n: u64, level: f64) -> Measured {
    if n == 0 {
        return Measured::none(0, Method::Share, "nothing was counted");
    }
    Measured::of(as_f64(k) / as_f64(n), n, Method::Share).within(wilson_interval(k, n, level))
}

/// Wilson's score interval of the share `k / n` \[Wilson1927\]; `None` where `n` is 0 or `level` is
/// not between 0 and 1.
///
/// (p̂ + z²/2n ± z √(p̂(1−p̂)/n + z²/4n²)) / (1 + z²/n)
#[must_use]
pub fn wilson_interval(k: u64, n: u64, level: f64) -> Option<Interval> {
    if n == 0 || k > n || !(level > 0.0 && level < 1.0) {
        return None;
    }
    let z = normal_quantile(0.5 + level / 2.0);
    let share = as_f64(k) / as_f64(n);
    let [low, high] = score_interval((k == 0, share, k == n), as_f64(n), z)?;
    Some(Interval {
        low,
        high,
        level,
        method: Method::Wilson,
    })
}

/// A share of objects that come in clusters (images, drives), each with how many of its objects count
/// and how many there are: Wilson's score interval for n/D objects, D being by how much the variance
/// between clusters is above that of independent objects \[RaoScott1992\], with t of m − 1 degrees of
/// freedom for z, m being the clusters with objects.
///
/// D = m/(m−1) Σᵢ (kᵢ − p nᵢ)² / (n p (1 − p)); where all or none count it is not known and taken as 1.
/// There is no interval of fewer than 5 clusters.
#[must_use]
pub(crate) fn clustered_share(clusters: &[[u64; 2]], level: f64) -> Measured {
    let with: Vec<[u64; 2]> = clusters.iter().copied().filter(|it| it[1] > 0).collect();
    let (k, n) = with
        .iter()
        .fold((0, 0), |(k, n), it| (k + it[0], n + it[1]));
    if n == 0 {
        return Measured::none(0, Method::Share, "there are no objects");
    }
    let share = as_f64(k) / as_f64(n);
    let measured = Measured::of(share, n, Method::Share);
    if with.len() < MIN_UNITS as usize {
        let mut without = measured;
        without.reason = Some(format!(
            "no interval: its objects are in {} resampling units, fewer than {MIN_UNITS}",
            with.len()
        ));
        return without;
    }
    let m = with.len() as f64;
    let squares: f64 = with
        .iter()
        .map(|[k, n]| (as_f64(*k) - share * as_f64(*n)).powi(2))
        .sum();
    let independent = as_f64(n) * share * (1.0 - share);
    // Where clusters happen to be more alike than chance makes them, that is no more objects.
    let excess = match k > 0 && k < n {
        true => (m / (m - 1.0) * squares / independent).max(1.0 / m),
        false => 1.0,
    };
    let interval = score_interval(
        (k == 0, share, k == n),
        as_f64(n) / excess,
        student_quantile(0.5 + level / 2.0, m - 1.0),
    );
    measured.within(interval.map(|[low, high]| Interval {
        low,
        high,
        level,
        method: Method::WilsonClustered,
    }))
}

/// The ends of the score interval of a share of n, n being a number of any kind; exactly 0 or 1 where
/// none or all count.
fn score_interval((is_none, share, is_all): (bool, f64, bool), n: f64, z: f64) -> Option<[f64; 2]> {
    let middle = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    // Exactly, where rounding would leave a trace.
    let low = match is_none {
        true => 0.0,
        false => ((middle - half) / scale).max(0.0),
    };
    let high = match is_all {
        true => 1.0,
        false => ((middle + half) / scale).min(1.0),
    };
    (low.is_finite() && high.is_finite()).then_some([low, high])
}

/// `McNemar`'s tests of two counts of pairs that changed, one way and the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct McNemar {
    /// Exact, conditional on the number of pairs that changed.
    pub exact: TestOutcome,
    /// The same with half the weight of what is as far off as seen: less conservative, and close to
    /// its level \[Fagerland2013\].
    pub mid_p: TestOutcome,
}

/// `McNemar`'s exact test, two-sided, of `b` changes one way against `c` the other way.
///
/// Under the null hypothesis b is binomial with b + c draws at ½:
/// p = min(1, 2 P(B ≤ min(b, c))) \[McNemar1947\]; mid-p = p − P(B = b), or 1 − P(B = b)/2 for b = c.
#[must_use]
pub fn mcnemar(b: u64, c: u64) -> McNemar {
    let n = b + c;
    if n == 0 {
        let why = "no pair changed";
        return McNemar {
            exact: TestOutcome::none(0, Method::McNemarExact, why),
            mid_p: TestOutcome::none(0, Method::McNemarMidP, why),
        };
    }
    let (tail, point) = half_binomial_tail(b.min(c), n);
    let (exact, mid_p) = if b == c {
        (1.0, 1.0 - point / 2.0)
    } else {
        ((2.0 * tail).min(1.0), 2.0 * tail - point)
    };
    McNemar {
        exact: TestOutcome::of(exact, n, Method::McNemarExact),
        mid_p: TestOutcome::of(mid_p, n, Method::McNemarMidP),
    }
}

/// P(B ≤ k) and P(B = k) for B binomial with n draws at ½.
///
/// Summed from k down, where each term is the one before times i/(n−i+1); the first is by log-gamma,
/// so that its relative error grows with n: 10⁻¹³ at 1000, 10⁻¹¹ at 10⁵.
fn half_binomial_tail(k: u64, n: u64) -> (f64, f64) {
    let ln_factorial = |m: u64| libm::lgamma(as_f64(m) + 1.0);
    let ln_point = ln_factorial(n)
        - ln_factorial(k)
        - ln_factorial(n - k)
        - as_f64(n) * std::f64::consts::LN_2;
    let point = libm::exp(ln_point);
    let (mut term, mut sum) = (point, point);
    for i in (1..=k).rev() {
        term *= as_f64(i) / as_f64(n - i + 1);
        sum += term;
        if term < sum * 1e-18 {
            break;
        }
    }
    (sum, point)
}

/// A count as a number; exact below 2⁵³.
pub(crate) fn as_f64(count: u64) -> f64 {
    count as f64
}
