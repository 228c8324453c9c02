//! The share of objects that stay found.

use std::collections::{BTreeMap, BTreeSet};

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
    product_limit(times_s, is_lost, None, level)
}

/// The same of objects that depend on each other within clusters, which `clusters` numbers from 0 per
/// object: the curve is the same, its variance that between clusters \[Williams1995\],
/// V = C/(C − 1) Σ_c (Σᵢ (d_ci − n_ci dᵢ/nᵢ)/(nᵢ − dᵢ))² over C clusters and the times up to t, at which
/// d_ci of the n_ci objects of cluster c are lost. With each object a cluster of its own it is
/// Greenwood's but for C/(C − 1).
///
/// # Errors
/// As [`kaplan_meier`], and where there is not one cluster per object or there are fewer than two.
pub fn kaplan_meier_of_clusters(
    times_s: &[f64],
    is_lost: &[bool],
    clusters: &[u32],
    level: f64,
) -> Result<Survival, EvalError> {
    if clusters.len() != times_s.len() {
        return Err(EvalError::StatisticLength {
            what: "clusters",
            found: clusters.len(),
            expected: times_s.len(),
            of: "objects",
        });
    }
    let n_clusters = clusters.iter().collect::<BTreeSet<_>>().len();
    if n_clusters < 2 {
        return Err(EvalError::StatisticSetting {
            what: "number of clusters",
            value: n_clusters as f64,
            range: "2 or more",
        });
    }
    product_limit(times_s, is_lost, Some(clusters), level)
}

/// How the variance of ln S grows from time to time.
enum Spread {
    /// Greenwood's sum.
    OfObjects(f64),
    /// Of each cluster how many objects are looked at, and its sum.
    OfClusters(BTreeMap<u32, (f64, f64)>),
}

impl Spread {
    fn new(clusters: Option<&[u32]>) -> Self {
        let Some(clusters) = clusters else {
            return Self::OfObjects(0.0);
        };
        let mut sums = BTreeMap::new();
        for cluster in clusters {
            sums.entry(*cluster).or_insert((0.0, 0.0)).0 += 1.0;
        }
        Self::OfClusters(sums)
    }

    /// Some of `n_at_risk` objects are lost: of each cluster in `lost` one.
    fn lose(&mut self, lost: &[u32], n_at_risk: f64) {
        let d = lost.len() as f64;
        match self {
            Self::OfObjects(sum) => *sum += d / (n_at_risk * (n_at_risk - d)),
            Self::OfClusters(sums) => {
                for (own_at_risk, sum) in sums.values_mut() {
                    *sum -= *own_at_risk * d / n_at_risk / (n_at_risk - d);
                }
                for cluster in lost {
                    if let Some((_, sum)) = sums.get_mut(cluster) {
                        *sum += 1.0 / (n_at_risk - d);
                    }
                }
            }
        }
    }

    /// Objects that are no longer looked at, by their clusters.
    fn leave(&mut self, gone: impl Iterator<Item = u32>) {
        if let Self::OfClusters(sums) = self {
            for cluster in gone {
                if let Some((own_at_risk, _)) = sums.get_mut(&cluster) {
                    *own_at_risk -= 1.0;
                }
            }
        }
    }

    fn variance(&self) -> f64 {
        match self {
            Self::OfObjects(sum) => *sum,
            Self::OfClusters(sums) => {
                let n = sums.len() as f64;
                let squares: f64 = sums.values().map(|(_, sum)| sum * sum).sum();
                n / (n - 1.0) * squares
            }
        }
    }

    fn method(&self) -> Method {
        match self {
            Self::OfObjects(_) => Method::GreenwoodLogLog,
            Self::OfClusters(_) => Method::WilliamsLogLog,
        }
    }
}

fn product_limit(
    times_s: &[f64],
    is_lost: &[bool],
    clusters: Option<&[u32]>,
    level: f64,
) -> Result<Survival, EvalError> {
    check(times_s, is_lost, level)?;
    let z = normal_quantile(0.5 + level / 2.0);
    let cluster_of = |idx: usize| clusters.and_then(|all| all.get(idx)).copied();
    let mut sorted: Vec<(f64, bool, u32)> = times_s
        .iter()
        .zip(is_lost)
        .enumerate()
        .map(|(idx, (time_s, is_lost))| (*time_s, *is_lost, cluster_of(idx).unwrap_or(0)))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = sorted.len() as u64;
    let (mut n_at_risk, mut share) = (n, 1.0_f64);
    let mut spread = Spread::new(clusters);
    let mut steps = Vec::new();
    for group in sorted.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        let lost: Vec<u32> = group.iter().filter(|it| it.1).map(|it| it.2).collect();
        let n_lost = lost.len() as u64;
        if n_lost > 0 {
            let (d, at_risk) = (n_lost as f64, n_at_risk as f64);
            share *= 1.0 - d / at_risk;
            spread.lose(&lost, at_risk);
            // Clusters that are all alike would give an interval of no width, which claims what is not known.
            let has_spread = n_lost < n_at_risk && spread.variance() > 1e-12;
            let interval = has_spread.then(|| {
                let log = libm::log(share);
                let half = z * spread.variance().sqrt() / log;
                let middle = libm::log(-log);
                let end = |it: f64| libm::exp(-libm::exp(it));
                Interval {
                    low: end(middle - half).min(end(middle + half)),
                    high: end(middle - half).max(end(middle + half)),
                    level,
                    method: spread.method(),
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
        spread.leave(group.iter().map(|it| it.2));
    }
    let (median_s, ends) = median(&steps, n, level);
    Ok(Survival {
        n,
        n_lost: steps.iter().map(|it| it.n_lost).sum(),
        steps,
        median_s,
        median_ends_s: ends,
    })
}

fn check(times_s: &[f64], is_lost: &[bool], level: f64) -> Result<(), EvalError> {
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
            what: "confidence level",
            value: level,
            range: "between 0 and 1",
        });
    }
    Ok(())
}

/// The first time by which half are lost, and the first times at which the ends of the interval reach one half.
fn median(steps: &[SurvivalStep], n: u64, level: f64) -> (Measured, [Option<f64>; 2]) {
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
    (median_s, ends)
}
