//! The normal distribution.

use statrs::function::erf::erfc_inv;

/// P(Z ≤ z) of the standard normal distribution.
pub(crate) fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// The z with P(Z ≤ z) = p, for p in (0, 1).
pub(crate) fn normal_quantile(p: f64) -> f64 {
    -std::f64::consts::SQRT_2 * erfc_inv(2.0 * p)
}

/// P(|Z| ≥ |z|).
pub(crate) fn two_sided_normal_p(z: f64) -> f64 {
    libm::erfc(z.abs() / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::{normal_cdf, normal_quantile, two_sided_normal_p};

    #[test]
    fn quantiles_are_those_of_tables() {
        // scipy.stats.norm.ppf
        for (p, z) in [
            (0.975, 1.959963984540054),
            (0.5, 0.0),
            (0.005, -2.575829303548901),
            (1e-9, -5.997807015007744),
        ] {
            assert!((normal_quantile(p) - z).abs() < 1e-12, "quantile at {p}");
            assert!((normal_cdf(z) - p).abs() < 1e-15, "and back at {p}");
        }
        assert!(
            (two_sided_normal_p(-1.959963984540054) - 0.05).abs() < 1e-15,
            "both tails"
        );
    }
}
