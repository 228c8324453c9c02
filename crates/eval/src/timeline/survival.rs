//! The share of objects that stay found.

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::statistic::{Interval, Measured, Method, normal_quantile};

/// How the share of objects that are not yet lost falls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Survival {
    /// Objects.
    pub n: u64,
    /// Those lost while looked at.
    pub n_lost: u64,
    /// At each time at which objects are lost; before the first, the share is 1.
    pub steps: Vec<SurvivalStep>,
    /// First time at which half or more are lost, s; with an interval where it has two ends.
    pub median_s: Measured,
    /// Ends of the median's interval, s; `None` for the upper end where the video is too short to
    /// tell, for both where not even the lower one is reached.
    pub median_ends_s: [Option<f64>; 2],
}

/// The share from one time on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurvivalStep {
    /// From this time on, s.
    pub time_s: f64,
    /// Objects looked at up to there.
    pub n_at_risk: u64,
    /// Those lost there.
    pub n_lost: u64,
    /// Share not lost, with its interval; without one where all are lost.
    pub share: Measured,
}

/// The product-limit estimate \[KaplanMeier1958\] of Kaplan and Meier, S(t) = Π (1 − dᵢ/nᵢ) over the
/// times up to t at which dᵢ of nᵢ objects are lost. An object that leaves at a time counts as
/// looked at up to and at that time.
///
/// The interval is exp(−exp(ln(−ln S) ± z √V / ln S)) with Greenwood's V = Σ dᵢ/(nᵢ(nᵢ − dᵢ))
/// \[Greenwood1926\], which stays within 0 and 1.
///
/// The interval of the median begins and ends where the lower and the upper ends of those intervals
/// first come down to one half \[Brookmeyer1982\].
///
/// # Errors
/// If there is not one time per object, a time is negative or not finite, or the level is not
/// between 0 and 1.
pub fn kaplan_meier(times_s: &[f64], is_lost: &[bool], level: f64) -> Result<Survival, EvalError> {
    if times_s.len() != is_lost.len() {
        return Err(EvalError::StatisticLength {
            what: "times",
            found: times_s.len(),
            expected: is_lost.len(),
            of: "objects",
        });
    }
    if let Some(time) = times_s.iter().find(|it| !(it.is_finite() && **it >= 0.0)) {
        return Err(EvalError::StatisticSetting {
            what: "time to a loss in s",
            value: *time,
            range: "of 0 or more",
        });
    }
    if !(level > 0.0 && level < 1.0) {
        return Err(EvalError::StatisticSetting {
            what: "level of confidence",
            value: level,
            range: "between 0 and 1",
        });
    }
    let z = normal_quantile(0.5 + level / 2.0);
    let mut sorted: Vec<(f64, bool)> = times_s
        .iter()
        .copied()
        .zip(is_lost.iter().copied())
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = sorted.len() as u64;
    let (mut n_at_risk, mut share, mut variance) = (n, 1.0_f64, 0.0_f64);
    let mut steps = Vec::new();
    for group in sorted.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        let n_lost = group.iter().filter(|it| it.1).count() as u64;
        if n_lost > 0 {
            let (d, at_risk) = (n_lost as f64, n_at_risk as f64);
            share *= 1.0 - d / at_risk;
            variance += d / (at_risk * (at_risk - d));
            let interval = (n_lost < n_at_risk).then(|| {
                let log = libm::log(share);
                let spread = z * variance.sqrt() / log;
                let middle = libm::log(-log);
                let end = |it: f64| libm::exp(-libm::exp(it));
                Interval {
                    low: end(middle - spread).min(end(middle + spread)),
                    high: end(middle - spread).max(end(middle + spread)),
                    level,
                    method: Method::GreenwoodLogLog,
                }
            });
            let measured = Measured::of(share, n_at_risk, Method::KaplanMeier).within(interval);
            steps.push(SurvivalStep {
                time_s: group[0].0,
                n_at_risk,
                n_lost,
                share: measured,
            });
        }
        n_at_risk -= group.len() as u64;
    }
    let first = |end: fn(&SurvivalStep) -> Option<f64>| {
        let step = steps
            .iter()
            .find(|it| end(it).is_some_and(|share| share <= 0.5));
        step.map(|it| it.time_s)
    };
    let ends = [
        first(|it| it.share.interval.map(|it| it.low)),
        first(|it| it.share.interval.map(|it| it.high)),
    ];
    let interval = match ends {
        [Some(low), Some(high)] => Some(Interval {
            low,
            high,
            level,
            method: Method::BrookmeyerCrowley,
        }),
        _ => None,
    };
    let median_s = first(|it| it.share.value).map_or_else(
        || {
            let why = match n {
                0 => "no object is at risk",
                _ => "the share not lost stays above one half as long as objects are followed",
            };
            Measured::none(n, Method::KaplanMeier, why)
        },
        |time_s| Measured::of(time_s, n, Method::KaplanMeier).within(interval),
    );
    Ok(Survival {
        n,
        n_lost: steps.iter().map(|it| it.n_lost).sum(),
        steps,
        median_s,
        median_ends_s: ends,
    })
}
