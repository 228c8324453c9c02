use serde::{Deserialize, Serialize};

/// A number with its interval and with what it rests on, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The number; finite.
    pub value: Option<f64>,
    /// How many things it rests on: objects, pairs, images; the item that holds it says which.
    pub n: u64,
    /// Where the number may lie.
    pub interval: Option<Interval>,
    /// How it was got.
    pub method: Method,
    /// Why there is no number or no interval.
    pub reason: Option<String>,
}

impl Measured {
    /// A number alone; one that is not finite is left out, with that as the reason.
    #[must_use]
    pub fn of(value: f64, n: u64, method: Method) -> Self {
        if value.is_finite() {
            Self {
                value: Some(value),
                n,
                interval: None,
                method,
                reason: None,
            }
        } else {
            Self::none(n, method, "the result is not a finite number")
        }
    }

    /// No number, and why.
    #[must_use]
    pub fn none(n: u64, method: Method, reason: impl Into<String>) -> Self {
        Self {
            value: None,
            n,
            interval: None,
            method,
            reason: Some(reason.into()),
        }
    }

    /// The same with an interval; ends that are not finite are left out.
    #[must_use]
    pub fn within(mut self, interval: Option<Interval>) -> Self {
        self.interval = interval.filter(|it| it.low.is_finite() && it.high.is_finite());
        self
    }
}

/// An interval of confidence, two-sided.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How often such intervals hold the truth, 0 to 1.
    pub level: f64,
    /// How it was got.
    pub method: Method,
}

/// What a two-sided test says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestOutcome {
    /// Probability of what was seen or something as far off, if nothing differs.
    pub p: Option<f64>,
    /// How many things the test weighs.
    pub n: u64,
    /// Which test.
    pub method: Method,
    /// Why there is no p.
    pub reason: Option<String>,
}

impl TestOutcome {
    /// The outcome of a test; p is brought into 0 to 1.
    #[must_use]
    pub fn of(p: f64, n: u64, method: Method) -> Self {
        if p.is_finite() {
            Self {
                p: Some(p.clamp(0.0, 1.0)),
                n,
                method,
                reason: None,
            }
        } else {
            Self::none(n, method, "the result is not a finite number")
        }
    }

    /// No outcome, and why.
    #[must_use]
    pub fn none(n: u64, method: Method, reason: impl Into<String>) -> Self {
        Self {
            p: None,
            n,
            method,
            reason: Some(reason.into()),
        }
    }
}

/// How a number, an interval or a p was got.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Method {
    /// A share of counts.
    Share,
    /// Arithmetic mean.
    Mean,
    /// Count over an area or over images.
    Density,
    /// Average precision over 101 recalls, as MS-COCO has it.
    AveragePrecision,
    /// A difference, cracked minus clean.
    Difference,
    /// A quotient.
    Ratio,
    /// Maximum likelihood, logistic.
    Logistic,
    /// Area under the curve of true over false positives, by ranks.
    RankAuc,
    /// Product-limit estimate of Kaplan and Meier.
    KaplanMeier,
    /// Wilson's score interval.
    Wilson,
    /// Wald's: estimate ± z standard errors.
    Wald,
    /// Wilson's with the variance between clusters, and t for z.
    WilsonClustered,
    /// Mean ± t standard errors, with the variance between clusters.
    ClusteredT,
    /// Greenwood's variance on the log-log scale.
    GreenwoodLogLog,
    /// Williams's variance between clusters on the log-log scale.
    WilliamsLogLog,
    /// Brookmeyer and Crowley's of a median: where the ends of the curve's interval pass one half.
    BrookmeyerCrowley,
    /// Percentiles of bootstrap replicates.
    BootstrapPercentile,
    /// Percentiles of bootstrap replicates, widened for few units.
    BootstrapExpanded,
    /// `McNemar`'s exact test.
    McNemarExact,
    /// `McNemar`'s test with the mid-p value.
    McNemarMidP,
    /// All ways to exchange the signs of clusters.
    SignsExact,
    /// Exchange of the signs of clusters, by the normal distribution.
    SignsNormal,
    /// Wald's test of a coefficient.
    WaldTest,
    /// All ways to swap clean and cracked.
    PermutationExact,
    /// Random ways to swap clean and cracked.
    PermutationSampled,
    /// As far on either side as such ways reach from 0.
    PermutationReach,
}

#[cfg(test)]
mod tests {
    use super::{Interval, Measured, Method, TestOutcome};

    #[test]
    fn what_is_not_finite_is_absent_with_a_reason() {
        let infinite = Interval {
            low: f64::NEG_INFINITY,
            high: 1.0,
            level: 0.95,
            method: Method::Wald,
        };
        let none = Measured::of(f64::NAN, 3, Method::Mean);
        assert_eq!(none.value, None, "no value");
        assert!(none.reason.is_some(), "but a reason");
        let open = Measured::of(0.5, 3, Method::Mean).within(Some(infinite));
        assert_eq!(open.interval, None, "an interval has two ends");
        assert_eq!(
            TestOutcome::of(f64::INFINITY, 1, Method::WaldTest).p,
            None,
            "no p"
        );
    }
}
