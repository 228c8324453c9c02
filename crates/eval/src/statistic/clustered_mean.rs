use super::{
    Interval, MIN_UNITS, Measured, Method, TestOutcome, student_quantile, two_sided_student_p,
};

/// The mean of values that come in clusters (images, drives), with a t interval by the variance
/// between clusters and the test of 0 that goes with it.
///
/// Of clusters with sums sᵢ of nᵢ values: mean m = Σsᵢ/Σnᵢ, standard error
/// √(g/(g−1) Σ(sᵢ − m nᵢ)²)/Σnᵢ over g clusters, t with g − 1 degrees of freedom. Fewer than five
/// clusters, or such that are all alike, have neither.
#[must_use]
pub(crate) fn clustered_mean(clusters: &[(f64, u64)], level: f64) -> (Measured, TestOutcome) {
    let with: Vec<(f64, f64)> = clusters
        .iter()
        .filter(|(_, n)| *n > 0)
        .map(|(sum, n)| (*sum, *n as f64))
        .collect();
    let n: u64 = clusters.iter().map(|(_, n)| n).sum();
    let none = |why: &str| TestOutcome::none(n, Method::ClusteredT, why);
    if n == 0 {
        let why = "there are no pairs";
        return (Measured::none(0, Method::Mean, why), none(why));
    }
    let mean = with.iter().map(|(sum, _)| sum).sum::<f64>() / n as f64;
    let measured = Measured::of(mean, n, Method::Mean);
    if with.len() < MIN_UNITS as usize {
        return (measured, none("the pairs are in too few resampling units"));
    }
    let g = with.len() as f64;
    let squares: f64 = with.iter().map(|(sum, n)| (sum - mean * n).powi(2)).sum();
    let error = (g / (g - 1.0) * squares).sqrt() / n as f64;
    // What only rounding spreads is alike.
    if error <= 1e-12 * mean.abs() {
        return (measured, none("all resampling units have the same mean"));
    }
    let half = student_quantile(0.5 + level / 2.0, g - 1.0) * error;
    let interval = Interval {
        low: mean - half,
        high: mean + half,
        level,
        method: Method::ClusteredT,
    };
    let p = two_sided_student_p(mean / error, g - 1.0);
    let test = TestOutcome::of(p, n, Method::ClusteredT);
    (measured.within(Some(interval)), test)
}

#[cfg(test)]
mod tests {
    use super::clustered_mean;

    #[test]
    fn of_single_values_it_is_students() {
        // scipy.stats.ttest_1samp([0.1, -0.2, 0.4, 0.3, 0.05], 0) and its confidence_interval().
        let clusters: Vec<(f64, u64)> = [0.1, -0.2, 0.4, 0.3, 0.05].map(|it| (it, 1)).to_vec();
        let (mean, test) = clustered_mean(&clusters, 0.95);
        let interval = mean.interval.unwrap_or_else(|| panic!("{mean:?}"));
        assert!((interval.low + 0.159_869_379).abs() < 1e-8, "{interval:?}");
        assert!((interval.high - 0.419_869_379).abs() < 1e-8, "{interval:?}");
        assert!(
            (test.p.unwrap_or(-1.0) - 0.281_031_066).abs() < 1e-8,
            "{test:?}"
        );
    }

    #[test]
    fn values_of_one_cluster_are_one() {
        let (one, _) = clustered_mean(
            &[(1.0, 10), (-0.2, 10), (0.4, 10), (0.1, 10), (0.3, 10)],
            0.95,
        );
        let (ten, _) = clustered_mean(
            &[(0.1, 1), (-0.02, 1), (0.04, 1), (0.01, 1), (0.03, 1)],
            0.95,
        );
        let width = |it: &crate::statistic::Measured| {
            it.interval
                .map_or(-1.0, |interval| interval.high - interval.low)
        };
        assert!((width(&one) - width(&ten)).abs() < 1e-12, "{one:?} {ten:?}");
    }

    #[test]
    fn four_clusters_are_too_few() {
        let (mean, test) = clustered_mean(&[(1.0, 10), (-0.2, 10), (0.4, 10), (0.1, 10)], 0.95);
        assert_eq!((mean.interval, test.p), (None, None), "{mean:?}");
        assert!(mean.value.is_some(), "but the mean is there");
    }
}
