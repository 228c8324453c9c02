//! How score and overlap change where an object is found in both images.

use serde::{Deserialize, Serialize};

use super::{Group, ObjectPair};
use crate::resampling::quantile;
use crate::statistic::{Interval, Measured, Method, SignedRank, normal_quantile, signed_rank_test};

/// Changes of objects found in both images, cracked minus clean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shifts {
    /// Which objects.
    pub group: Group,
    /// How many were found in both.
    pub n_pairs: u64,
    /// Of the score.
    pub score: Shift,
    /// Of the overlap with the object.
    pub iou: Shift,
}

/// Changes of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// Mean, with Wald's interval of n > 1 pairs taken as independent.
    pub mean: Measured,
    /// Median.
    pub median: Measured,
    /// Wilcoxon's signed-rank test with its effect size.
    pub signed_rank: SignedRank,
}

/// Changes of score and overlap of the pairs in which both found the object.
#[must_use]
pub fn shifts<'a>(
    group: Group,
    pairs: impl IntoIterator<Item = &'a ObjectPair>,
    level: f64,
) -> Shifts {
    let (mut scores, mut ious) = (Vec::new(), Vec::new());
    for pair in pairs {
        if let (Some(clean), Some(cracked)) = (pair.clean, pair.cracked) {
            scores.push(cracked.score - clean.score);
            ious.push(cracked.iou - clean.iou);
        }
    }
    Shifts {
        group,
        n_pairs: scores.len() as u64,
        score: shift(&scores, level),
        iou: shift(&ious, level),
    }
}

fn shift(differences: &[f64], level: f64) -> Shift {
    let mut sorted = differences.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as u64;
    let why = "no object was found in both images";
    let (mean, median) = match quantile(&sorted, 0.5) {
        Some(median) => (
            mean_of(&sorted, level),
            Measured::of(median, n, Method::Median),
        ),
        None => (
            Measured::none(0, Method::Mean, why),
            Measured::none(0, Method::Median, why),
        ),
    };
    Shift {
        mean,
        median,
        signed_rank: signed_rank_test(differences),
    }
}

/// Mean ± z s/√n.
fn mean_of(values: &[f64], level: f64) -> Measured {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let measured = Measured::of(mean, values.len() as u64, Method::Mean);
    if values.len() < 2 || !(level > 0.0 && level < 1.0) {
        return measured;
    }
    let squares: f64 = values.iter().map(|it| (it - mean).powi(2)).sum();
    let half = normal_quantile(0.5 + level / 2.0) * (squares / (n - 1.0) / n).sqrt();
    measured.within(Some(Interval {
        low: mean - half,
        high: mean + half,
        level,
        method: Method::Wald,
    }))
}
