//! The normal distribution, and Student's.

use statrs::distribution::{ContinuousCDF, StudentsT};
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

/// The t with P(T ≤ t) = p under so many degrees of freedom; NaN where these are not above 0.
pub(crate) fn student_quantile(p: f64, n_degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, n_degrees).map_or(f64::NAN, |student| student.inverse_cdf(p))
}

/// P(|T| ≥ |t|) under so many degrees of freedom; NaN where these are not above 0.
pub(crate) fn two_sided_student_p(t: f64, n_degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, n_degrees).map_or(f64::NAN, |student| 2.0 * student.cdf(-t.abs()))
}

#[cfg(test)]
mod tests {
    use super::{
        normal_cdf, normal_quantile, student_quantile, two_sided_normal_p, two_sided_student_p,
    };

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

    #[test]
    fn those_of_student_are_those_of_tables() {
        // scipy.stats.t.ppf
        for (n, t) in [
            (1.0, 12.706204736432095),
            (4.0, 2.7764451051977987),
            (95.0, 1.9852510035054973),
        ] {
            let found = student_quantile(0.975, n);
            assert!((found - t).abs() < 1e-8, "quantile of {n}: {found}");
            let p = two_sided_student_p(-t, n);
            assert!((p - 0.05).abs() < 1e-9, "and back of {n}: {p}");
        }
        assert!(student_quantile(0.975, 0.0).is_nan(), "of nothing");
    }
}
