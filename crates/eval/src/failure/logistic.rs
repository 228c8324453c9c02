//! A logistic curve through yes and no over one dose.

use serde::{Deserialize, Serialize};

use crate::statistic::{
    Interval, MIN_UNITS, Measured, Method, TestOutcome, normal_quantile, student_quantile,
    two_sided_normal_p, two_sided_student_p,
};

/// Rounds after which a fit that has not settled is given up.
const MAX_ROUNDS: u32 = 100;

/// P(failure) = 1 / (1 + exp(−(intercept + slope · dose))), by maximum likelihood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogisticFit {
    /// Objects fitted.
    pub n: u64,
    /// Those that failed.
    pub n_failures: u64,
    /// At dose 0, as log odds.
    pub intercept: Coefficient,
    /// Per unit of the dose, as log odds.
    pub slope: Coefficient,
    /// How well the dose tells failures from the rest: probability that a failure has the higher
    /// one, equal ones by half. It needs no fit.
    pub auc: Measured,
    /// Rounds of the fit.
    pub n_rounds: u32,
    /// Why there is no curve, where there is none.
    pub reason: Option<String>,
}

/// A coefficient of the curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coefficient {
    /// Its estimate, with Wald's interval by the standard error over clusters where there is one.
    pub estimate: Measured,
    /// Standard error for independent objects.
    pub standard_error: Option<f64>,
    /// Standard error that lets objects of one cluster (image, drive) depend on each other
    /// \[LiangZeger1986\]; `None` for fewer than two clusters.
    pub standard_error_clustered: Option<f64>,
    /// Wald's test of 0 by the standard error of the interval.
    pub test: TestOutcome,
}

impl LogisticFit {
    /// The probability of failure at a dose; `None` without a curve.
    #[must_use]
    pub fn probability(&self, dose: f64) -> Option<f64> {
        let log_odds = self.intercept.estimate.value? + self.slope.estimate.value? * dose;
        Some(1.0 / (1.0 + libm::exp(-log_odds)))
    }
}

/// Fits a logistic curve to `failed` over `dose` by iteratively reweighted least squares
/// \[McCullaghNelder1989\], with standard errors from the information and, over `clusters`, from the
/// sandwich with the factor G/(G−1) · (n−1)/(n−2).
///
/// There is no curve, and a reason instead, where the dose does not vary, all or none failed, the
/// doses of failures and the rest do not overlap (then the likelihood has no maximum
/// \[AlbertAnderson1984\]; at most one shared dose is no overlap either), or the fit has not settled after
/// 100 rounds. Doses that are not finite are left out.
#[must_use]
pub fn fit_logistic(dose: &[f64], failed: &[bool], clusters: &[u32], level: f64) -> LogisticFit {
    let rows: Vec<Row> = dose
        .iter()
        .zip(failed)
        .zip(clusters)
        .filter(|((dose, _), _)| dose.is_finite())
        .map(|((dose, failed), cluster)| Row {
            dose: *dose,
            failed: *failed,
            cluster: *cluster,
        })
        .collect();
    let n = rows.len() as u64;
    let n_failures = rows.iter().filter(|row| row.failed).count() as u64;
    let auc = rank_auc(&rows);
    let fitted = why_none(&rows).map_or_else(|| solve(&rows), Err);
    match fitted {
        Ok(curve) => {
            let coefficient = |place: usize| curve.coefficient(place, n, level);
            LogisticFit {
                n,
                n_failures,
                intercept: coefficient(0),
                slope: coefficient(1),
                auc,
                n_rounds: curve.n_rounds,
                reason: None,
            }
        }
        Err(reason) => LogisticFit {
            n,
            n_failures,
            intercept: Coefficient::none(n, &reason),
            slope: Coefficient::none(n, &reason),
            auc,
            n_rounds: 0,
            reason: Some(reason),
        },
    }
}

#[derive(Debug, Clone, Copy)]
struct Row {
    dose: f64,
    failed: bool,
    cluster: u32,
}

impl Coefficient {
    /// The coefficient over so many units with their variance alone: an interval and a test by t of
    /// as many degrees of freedom as they leave, and neither of fewer than 5 units, where z and the
    /// sandwich would claim what they cannot know.
    pub(super) fn between_units(&self, n_units: usize, level: f64) -> (Measured, TestOutcome) {
        let mut estimate = self.estimate.clone();
        estimate.interval = None;
        let none = |why: &str| TestOutcome::none(estimate.n, Method::ClusteredT, why);
        let error = self.standard_error_clustered;
        let error = error.filter(|_| n_units >= MIN_UNITS as usize);
        let (Some(value), Some(error)) = (estimate.value, error) else {
            let test = none("there is no curve, or the objects are in too few resampling units");
            return (estimate, test);
        };
        let n_degrees = (n_units - 1) as f64;
        let reach = student_quantile(0.5 + level / 2.0, n_degrees) * error;
        let p = two_sided_student_p(value / error, n_degrees);
        let test = TestOutcome::of(p, estimate.n, Method::ClusteredT);
        let interval = Interval {
            low: value - reach,
            high: value + reach,
            level,
            method: Method::ClusteredT,
        };
        (estimate.within(Some(interval)), test)
    }

    fn none(n: u64, reason: &str) -> Self {
        Self {
            estimate: Measured::none(n, Method::Logistic, reason),
            standard_error: None,
            standard_error_clustered: None,
            test: TestOutcome::none(n, Method::WaldTest, reason),
        }
    }
}

/// Why no curve can be fitted.
fn why_none(rows: &[Row]) -> Option<String> {
    let range = |failed: bool| {
        rows.iter()
            .filter(|row| row.failed == failed)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
                (low.min(row.dose), high.max(row.dose))
            })
    };
    let ((low_no, high_no), (low_yes, high_yes)) = (range(false), range(true));
    if rows.is_empty() {
        return Some("no objects have a dose".to_owned());
    }
    if !rows.iter().any(|row| row.failed) {
        return Some("no object failed".to_owned());
    }
    if rows.iter().all(|row| row.failed) {
        return Some("all objects failed".to_owned());
    }
    if low_no.min(low_yes) >= high_no.max(high_yes) {
        return Some(format!("all doses are {low_no}"));
    }
    if high_no <= low_yes || high_yes <= low_no {
        return Some(
            "the dose separates failures from the rest, so the best fit is infinitely steep"
                .to_owned(),
        );
    }
    None
}

/// A fitted curve.
struct Curve {
    beta: [f64; 2],
    variance: [f64; 2],
    clustered: Option<[f64; 2]>,
    n_rounds: u32,
}

impl Curve {
    fn coefficient(&self, place: usize, n: u64, level: f64) -> Coefficient {
        let value = self.beta[place];
        let standard_error = self.variance[place].sqrt();
        let clustered = self
            .clustered
            .map(|variance| variance[place].max(0.0).sqrt());
        let error = clustered.filter(|it| *it > 0.0).unwrap_or(standard_error);
        let half = normal_quantile(0.5 + level / 2.0) * error;
        let interval = Interval {
            low: value - half,
            high: value + half,
            level,
            method: Method::Wald,
        };
        Coefficient {
            estimate: Measured::of(value, n, Method::Logistic).within(Some(interval)),
            standard_error: Some(standard_error).filter(|it| it.is_finite()),
            standard_error_clustered: clustered.filter(|it| it.is_finite()),
            test: TestOutcome::of(two_sided_normal_p(value / error), n, Method::WaldTest),
        }
    }
}

/// Newton's rounds on doses brought to mean 0 and spread 1, where steps are well scaled.
fn solve(rows: &[Row]) -> Result<Curve, String> {
    let n = rows.len() as f64;
    let mean = rows.iter().map(|row| row.dose).sum::<f64>() / n;
    let spread = (rows
        .iter()
        .map(|row| (row.dose - mean).powi(2))
        .sum::<f64>()
        / n)
        .sqrt();
    let scaled: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| ((row.dose - mean) / spread, f64::from(u8::from(row.failed))))
        .collect();
    let (mut a, mut b) = (0.0_f64, 0.0_f64);
    for n_rounds in 1..=MAX_ROUNDS {
        let (score, information) = derivatives(&scaled, a, b);
        let [[var_a, cov], [_, var_b]] =
            inverse(information).ok_or("the information matrix is singular")?;
        let step = [
            var_a * score[0] + cov * score[1],
            cov * score[0] + var_b * score[1],
        ];
        // A long step can overshoot where the curve is flat.
        let longest = step[0].abs().max(step[1].abs());
        let scale = if longest > 5.0 { 5.0 / longest } else { 1.0 };
        a += scale * step[0];
        b += scale * step[1];
        if longest < 1e-10 * (1.0 + a.abs().max(b.abs())) {
            return Ok(curve(rows, &scaled, [a, b], [mean, spread], n_rounds));
        }
    }
    Err(format!(
        "the fit did not converge in {MAX_ROUNDS} iterations"
    ))
}

/// First derivative of the log likelihood, and minus the second.
fn derivatives(rows: &[(f64, f64)], a: f64, b: f64) -> ([f64; 2], [[f64; 2]; 2]) {
    let mut score = [0.0; 2];
    let mut information = [[0.0; 2]; 2];
    for (x, y) in rows {
        let p = 1.0 / (1.0 + libm::exp(-(a + b * x)));
        let (rest, weight) = (y - p, p * (1.0 - p));
        score[0] += rest;
        score[1] += rest * x;
        information[0][0] += weight;
        information[0][1] += weight * x;
        information[1][1] += weight * x * x;
    }
    information[1][0] = information[0][1];
    (score, information)
}

fn inverse([[a, b], [_, d]]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let determinant = a * d - b * b;
    (determinant > 1e-14 * a * d).then(|| {
        [
            [d / determinant, -b / determinant],
            [-b / determinant, a / determinant],
        ]
    })
}

/// Back to the doses as they are: slope b/s, intercept a − b m/s.
fn curve(
    rows: &[Row],
    scaled: &[(f64, f64)],
    [a, b]: [f64; 2],
    [mean, spread]: [f64; 2],
    n_rounds: u32,
) -> Curve {
    let (_, information) = derivatives(scaled, a, b);
    let bread = inverse(information).unwrap_or([[f64::NAN; 2]; 2]);
    let unscaled = |[[aa, ab], [_, bb]]: [[f64; 2]; 2]| {
        let shift = mean / spread;
        [
            aa - 2.0 * shift * ab + shift * shift * bb,
            bb / (spread * spread),
        ]
    };
    let clustered = filling(rows, scaled, [a, b]).map(|meat| unscaled(sandwich(bread, meat)));
    Curve {
        beta: [a - b * mean / spread, b / spread],
        variance: unscaled(bread),
        clustered,
        n_rounds,
    }
}

/// Σ over clusters of the outer product of their score, with the factor for few of them.
fn filling(rows: &[Row], scaled: &[(f64, f64)], [a, b]: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let mut by_cluster = std::collections::BTreeMap::<u32, [f64; 2]>::new();
    for (row, (x, y)) in rows.iter().zip(scaled) {
        let rest = y - 1.0 / (1.0 + libm::exp(-(a + b * x)));
        let score = by_cluster.entry(row.cluster).or_default();
        score[0] += rest;
        score[1] += rest * x;
    }
    let (n, n_clusters) = (rows.len() as f64, by_cluster.len() as f64);
    if by_cluster.len() < 2 || rows.len() < 3 {
        return None;
    }
    let factor = n_clusters / (n_clusters - 1.0) * (n - 1.0) / (n - 2.0);
    let mut sum = [[0.0; 2]; 2];
    for score in by_cluster.values() {
        for (row, first) in sum.iter_mut().zip(score) {
            for (cell, second) in row.iter_mut().zip(score) {
                *cell += factor * first * second;
            }
        }
    }
    Some(sum)
}

fn sandwich(bread: [[f64; 2]; 2], meat: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let product = |a: [[f64; 2]; 2], b: [[f64; 2]; 2]| {
        let mut out = [[0.0; 2]; 2];
        for (i, row) in out.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell = a[i][0] * b[0][j] + a[i][1] * b[1][j];
            }
        }
        out
    };
    product(product(bread, meat), bread)
}

/// Mann and Whitney's statistic over both numbers \[HanleyMcNeil1982\].
fn rank_auc(rows: &[Row]) -> Measured {
    let mut sorted = rows.to_vec();
    sorted.sort_by(|a, b| a.dose.total_cmp(&b.dose));
    let (mut sum, mut n_below, mut n_yes) = (0.0, 0.0, 0.0);
    for group in sorted.chunk_by(|a, b| a.dose.total_cmp(&b.dose).is_eq()) {
        let yes = group.iter().filter(|row| row.failed).count() as f64;
        let no = group.len() as f64 - yes;
        sum += yes * (n_below + no / 2.0);
        n_below += no;
        n_yes += yes;
    }
    let n = rows.len() as u64;
    if n_yes < 1.0 || n_below < 1.0 {
        return Measured::none(
            n,
            Method::RankAuc,
            "it needs both failures and non-failures",
        );
    }
    Measured::of(sum / (n_yes * n_below), n, Method::RankAuc)
}
