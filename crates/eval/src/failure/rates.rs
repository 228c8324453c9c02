//! Rates of failure and recovery, by class and by place.

use serde::{Deserialize, Serialize};

use super::ObjectPair;
use crate::EvalError;
use crate::resampling::{Plan, Weights, bootstrap};
use crate::statistic::{McNemar, Measured, Method, holm, mcnemar, paired_difference, proportion};

/// What became of a group of objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailureRates {
    /// Which objects.
    pub group: Group,
    /// How many.
    pub n_objects: u64,
    /// In how many images.
    pub n_images: u64,
    /// Found in both.
    pub n_kept: u64,
    /// Found clean, missed cracked.
    pub n_lost: u64,
    /// Missed clean, found cracked.
    pub n_recovered: u64,
    /// Missed in both.
    pub n_missed: u64,
    /// Lost of those found clean, with Wilson's interval.
    pub failure_rate: Measured,
    /// The same with an interval from drawing images or clusters, if asked for; its n are those.
    pub failure_rate_over_images: Option<Measured>,
    /// Recovered of those missed clean, with Wilson's interval.
    pub recovery_rate: Measured,
    /// Lost minus recovered, of all objects: the drop in recall at this score.
    pub net_loss: Measured,
    /// Lost against recovered.
    pub test: McNemar,
    /// Its exact p after Holm's correction over the table.
    pub p_holm: Option<f64>,
}

/// Which objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories); `None` for
    /// all.
    pub category: Option<u32>,
    /// Where in the image.
    pub place: Where,
}

/// Where objects are, by the share of their box that the cracks' region covers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Where {
    /// Anywhere.
    Image,
    /// Coverage of at least τ (for τ = 0: more than 0).
    Region {
        /// τ, 0 to 1.
        tau: f64,
    },
    /// The rest: the control.
    Outside {
        /// τ, 0 to 1.
        tau: f64,
    },
    /// Coverage from `low` to below `high`; up to `high` where that is 1.
    Coverage {
        /// From here.
        low: f64,
        /// To here.
        high: f64,
    },
}

impl Where {
    /// Whether a coverage belongs here.
    #[must_use]
    pub fn holds(self, coverage: f64) -> bool {
        match self {
            Self::Image => true,
            Self::Region { tau } => coverage >= tau && coverage > 0.0,
            Self::Outside { tau } => coverage < tau || coverage <= 0.0,
            Self::Coverage { low, high } => {
                coverage >= low && (coverage < high || high >= 1.0 && coverage <= high)
            }
        }
    }
}

/// The rates of one group. Intervals take objects as independent.
///
/// Failure rate = #(found clean, missed cracked) / #(found clean).
#[must_use]
pub fn failure_rates<'a>(
    group: Group,
    pairs: impl IntoIterator<Item = &'a ObjectPair>,
    level: f64,
) -> FailureRates {
    let mut counts = [[0_u64; 2]; 2];
    let mut images = Vec::new();
    for pair in pairs {
        counts[usize::from(pair.clean.is_some())][usize::from(pair.cracked.is_some())] += 1;
        images.push(pair.image);
    }
    images.sort_unstable();
    images.dedup();
    let [[n_missed, n_recovered], [n_lost, n_kept]] = counts;
    let n_objects = n_missed + n_recovered + n_lost + n_kept;
    FailureRates {
        group,
        n_objects,
        n_images: images.len() as u64,
        n_kept,
        n_lost,
        n_recovered,
        n_missed,
        failure_rate: proportion(n_lost, n_lost + n_kept, level),
        failure_rate_over_images: None,
        recovery_rate: proportion(n_recovered, n_recovered + n_missed, level),
        net_loss: paired_difference(n_lost, n_recovered, n_objects, level),
        test: mcnemar(n_lost, n_recovered),
        p_holm: None,
    }
}

/// The rates of all groups of a table: each place for all objects and for each category that has
/// any, with Holm's correction over the rows and, if a plan is given, intervals of the failure rate
/// over images or clusters.
///
/// # Errors
/// If an image or a pattern is not in the plan, or the plan cannot be carried out.
pub fn failure_table(
    pairs: &[ObjectPair],
    places: &[Where],
    level: f64,
    plan: Option<&Plan>,
) -> Result<Vec<FailureRates>, EvalError> {
    let mut categories: Vec<u32> = pairs.iter().map(|it| it.category).collect();
    categories.sort_unstable();
    categories.dedup();
    let groups = || std::iter::once(None).chain(categories.iter().copied().map(Some));
    let mut table = Vec::new();
    let mut members: Vec<Vec<&ObjectPair>> = Vec::new();
    for place in places {
        for category in groups() {
            let group = Group {
                category,
                place: *place,
            };
            let is_member = |pair: &&ObjectPair| {
                category.is_none_or(|it| it == pair.category) && place.holds(pair.coverage)
            };
            let of_group: Vec<&ObjectPair> = pairs.iter().filter(is_member).collect();
            if category.is_none() || !of_group.is_empty() {
                table.push(failure_rates(group, of_group.iter().copied(), level));
                members.push(of_group);
            }
        }
    }
    let p: Vec<Option<f64>> = table.iter().map(|row| row.test.exact.p).collect();
    for (row, corrected) in table.iter_mut().zip(holm(&p)) {
        row.p_holm = corrected;
    }
    if let Some(plan) = plan {
        over_images(&mut table, &members, plan)?;
    }
    Ok(table)
}

fn over_images(
    table: &mut [FailureRates],
    members: &[Vec<&ObjectPair>],
    plan: &Plan,
) -> Result<(), EvalError> {
    let images = members.iter().flatten().map(|pair| pair.image as usize + 1);
    let n_images = images.max().unwrap_or(0);
    if n_images > plan.n_images() {
        return Err(EvalError::StatisticLength {
            what: "images with objects",
            found: n_images,
            expected: plan.n_images(),
            of: "images of the plan",
        });
    }
    let patterns = members
        .iter()
        .flatten()
        .map(|pair| pair.pattern as usize + 1);
    let n_patterns = patterns.max().unwrap_or(0);
    if n_patterns > plan.n_patterns() as usize {
        return Err(EvalError::StatisticLength {
            what: "patterns with objects",
            found: n_patterns,
            expected: plan.n_patterns() as usize,
            of: "patterns of the plan",
        });
    }
    let rate = |pairs: &Vec<&ObjectPair>, weights: &Weights| {
        let (mut n_found, mut n_lost) = (0_u64, 0_u64);
        for pair in pairs.iter().filter(|pair| pair.clean.is_some()) {
            let weight = u64::from(weights.images[pair.image as usize])
                * u64::from(weights.patterns[pair.pattern as usize]);
            n_found += weight;
            n_lost += weight * u64::from(pair.cracked.is_none());
        }
        (n_found > 0).then(|| n_lost as f64 / n_found as f64)
    };
    let replicates = bootstrap(plan, |weights| {
        members.iter().map(|pairs| rate(pairs, weights)).collect()
    })?;
    for (place, row) in table.iter_mut().enumerate() {
        row.failure_rate_over_images = Some(replicates.percentile(place, Method::Share));
    }
    Ok(())
}
