//! Rates of failure and recovery, by class and by place.

use serde::{Deserialize, Serialize};

use super::ObjectPair;
use crate::EvalError;
use crate::resampling::Plan;
use crate::statistic::{Measured, TestOutcome, clustered_share, sign_exchange_test};

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
    /// Lost of those found clean, with Wilson's interval over images or clusters.
    pub failure_rate: Measured,
    /// Recovered of those missed clean, with the same.
    pub recovery_rate: Measured,
    /// Lost against recovered, by exchange of signs image by image or cluster by cluster.
    pub test: TestOutcome,
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

/// The rates of one group. Objects of one unit of the plan, an image or a cluster of images, may depend
/// on each other; those of a unit behind the cracks of several seeds, too.
///
/// Failure rate = #(found clean, missed cracked) / #(found clean).
///
/// # Errors
/// If an image is not in the plan.
pub fn failure_rates<'a>(
    group: Group,
    pairs: impl IntoIterator<Item = &'a ObjectPair>,
    plan: &Plan,
) -> Result<FailureRates, EvalError> {
    // Per unit: missed, recovered, lost, kept.
    let mut units = vec![[0_u64; 4]; plan.n_units() as usize];
    let mut images = Vec::new();
    for pair in pairs {
        let place = usize::from(pair.clean.is_some()) * 2 + usize::from(pair.cracked.is_some());
        units[plan.unit(pair.image)? as usize][place] += 1;
        images.push(pair.image);
    }
    images.sort_unstable();
    images.dedup();
    let total = |place: usize| units.iter().map(|counts| counts[place]).sum::<u64>();
    let [n_missed, n_recovered, n_lost, n_kept] = [0, 1, 2, 3].map(total);
    let share = |k: usize, other: usize| {
        let of_unit = |counts: &[u64; 4]| [counts[k], counts[k] + counts[other]];
        clustered_share(&units.iter().map(of_unit).collect::<Vec<_>>(), plan.level)
    };
    let signed = |count: u64| i64::try_from(count).unwrap_or(i64::MAX);
    let net = |counts: &[u64; 4]| signed(counts[2]) - signed(counts[1]);
    Ok(FailureRates {
        group,
        n_objects: n_missed + n_recovered + n_lost + n_kept,
        n_images: images.len() as u64,
        n_kept,
        n_lost,
        n_recovered,
        n_missed,
        failure_rate: share(2, 3),
        recovery_rate: share(1, 0),
        test: sign_exchange_test(&units.iter().map(net).collect::<Vec<_>>()),
    })
}

/// The rates of all groups of a table: each place for all objects and for each category that has
/// any.
///
/// # Errors
/// If an image is not in the plan.
pub fn failure_table(
    pairs: &[ObjectPair],
    places: &[Where],
    plan: &Plan,
) -> Result<Vec<FailureRates>, EvalError> {
    let mut categories: Vec<u32> = pairs.iter().map(|it| it.category).collect();
    categories.sort_unstable();
    categories.dedup();
    let groups = || std::iter::once(None).chain(categories.iter().copied().map(Some));
    let mut table = Vec::new();
    for place in places {
        for category in groups() {
            let group = Group {
                category,
                place: *place,
            };
            let is_member = |pair: &&ObjectPair| {
                category.is_none_or(|it| it == pair.category) && place.holds(pair.coverage)
            };
            let row = failure_rates(group, pairs.iter().filter(is_member), plan)?;
            if category.is_none() || row.n_objects > 0 {
                table.push(row);
            }
        }
    }
    Ok(table)
}
