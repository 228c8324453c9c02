//! The exchange of signs: clean and cracked swapped, cluster by cluster.

use super::{Method, TestOutcome, two_sided_normal_p};

/// Steps of the exact sum of all signs, beyond which the normal distribution is taken.
const MAX_STEPS: u64 = 1 << 27;

/// Whether the differences of clusters are on one side of 0 by more than chance makes them, two-sided:
/// in which share of all 2ⁿ exchanges of their signs the sum is as far from 0 as it is.
///
/// If the cracks did nothing, each cluster (an image, a drive) would as likely have the difference
/// −d as d. Of clusters with one object each it is `McNemar`'s exact test. All exchanges are summed up
/// exactly; where that takes more than some 10⁸ steps, the normal distribution with the variance Σd²
/// stands in.
#[must_use]
pub(crate) fn sign_exchange_test(differences: &[i64]) -> TestOutcome {
    let sizes: Vec<u64> = differences
        .iter()
        .map(|it| it.unsigned_abs())
        .filter(|it| *it > 0)
        .collect();
    let n = sizes.len() as u64;
    if n == 0 {
        return TestOutcome::none(0, Method::SignsExact, "all differences are 0");
    }
    let total: u64 = sizes.iter().sum();
    let sum: i64 = differences.iter().sum();
    let far = sum.unsigned_abs();
    if total.saturating_mul(n) > MAX_STEPS {
        let squares: f64 = sizes.iter().map(|it| (*it as f64).powi(2)).sum();
        let z = far as f64 / squares.sqrt();
        return TestOutcome::of(two_sided_normal_p(z), n, Method::SignsNormal);
    }
    let (Ok(length), Ok(below)) = (
        usize::try_from(total + 1),
        usize::try_from((total - far) / 2),
    ) else {
        return TestOutcome::none(n, Method::SignsExact, "the differences are too large");
    };
    // chance[s]: probability that the sizes with a plus sum to s; the sum of all is 2 s − total.
    let mut chance = vec![0.0_f64; length];
    chance[0] = 1.0;
    let mut reached = 0;
    for size in sizes.iter().filter_map(|it| usize::try_from(*it).ok()) {
        reached += size;
        for s in (0..=reached).rev() {
            let with = if s >= size { chance[s - size] } else { 0.0 };
            chance[s] = 0.5 * (chance[s] + with);
        }
    }
    let tail: f64 = chance.iter().take(below + 1).sum();
    TestOutcome::of((2.0 * tail).min(1.0), n, Method::SignsExact)
}

#[cfg(test)]
mod tests {
    use super::sign_exchange_test;
    use crate::statistic::{Method, mcnemar};

    #[test]
    fn of_single_objects_it_is_mcnemars() {
        for (lost, recovered) in [(7, 1), (4, 4), (12, 0), (30, 18)] {
            let mut differences = vec![1_i64; lost];
            differences.extend(vec![-1; recovered]);
            let found = sign_exchange_test(&differences).p.unwrap_or(-1.0);
            let expected = mcnemar(lost as u64, recovered as u64)
                .exact
                .p
                .unwrap_or(-2.0);
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn one_image_with_many_losses_is_no_evidence() {
        let p = sign_exchange_test(&[20, -1, 1]).p;
        assert_eq!(
            p,
            Some(0.75),
            "22, 20 and 20 of the four sums of a sign are as far"
        );
        // All 2^4 sums of 3, 2, 2, 1 by hand: 8 and −8, 6 and −6 are as far as 6.
        let p = sign_exchange_test(&[3, 2, 2, -1, 0]).p;
        assert_eq!(p, Some(0.25), "4 of 16");
        assert_eq!(sign_exchange_test(&[0, 0]).p, None, "nothing changed");
    }

    #[test]
    fn the_normal_distribution_takes_over_where_it_is_the_same() {
        let wide: Vec<i64> = (1..=700)
            .map(|k| if k % 40 < 21 { k } else { -k })
            .collect();
        let test = sign_exchange_test(&wide);
        assert_eq!(test.method, Method::SignsNormal, "{test:?}");
        let narrow: Vec<i64> = wide
            .iter()
            .map(|k| k.signum() * (k.abs() / 10 + 1))
            .collect();
        let exact = sign_exchange_test(&narrow);
        assert_eq!(exact.method, Method::SignsExact, "{exact:?}");
        let (a, b) = (test.p.unwrap_or(-1.0), exact.p.unwrap_or(1.0));
        assert!((a / b).ln().abs() < 0.2, "{a} {b}");
    }
}
