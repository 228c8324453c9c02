//! Objects that are taken for another class behind cracks.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::ObjectPair;
use crate::EvalError;
use crate::detections::Detections;
use crate::labels::LabelSet;
use crate::matching::{ImageMatches, Outcome};
use crate::resampling::Plan;
use crate::statistic::{Measured, clustered_share};

/// Which classes objects are taken for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClassFlips {
    /// Objects found clean.
    pub n_found_clean: u64,
    /// Those of them taken for another class in the cracked image.
    pub n_flipped: u64,
    /// Their share, with Wilson's interval over images or clusters.
    pub flip_rate: Measured,
    /// By class, then by the class they are taken for.
    pub table: Vec<ClassFlip>,
}

/// One kind of flip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClassFlip {
    /// Place of the object's category in [`LabelSet::categories`].
    pub category: u32,
    /// Place of the category that it is taken for.
    pub taken_for: u32,
    /// How often.
    pub n: u64,
}

/// Objects found clean and lost cracked that a false positive of another class of at least
/// `score_threshold` overlaps by at least `iou` in the cracked image; of several the one of the
/// highest score counts. A detection that rightly finds a neighbor of the other class is no flip.
///
/// # Errors
/// If an image is not in the plan.
pub fn class_flips(
    pairs: &[ObjectPair],
    cracked: &[ImageMatches],
    cracked_detections: &Detections,
    labels: &LabelSet,
    score_threshold: f64,
    iou: f64,
    plan: &Plan,
) -> Result<ClassFlips, EvalError> {
    let mut false_by_image = BTreeMap::<u32, Vec<usize>>::new();
    for item in cracked {
        for matched in &item.detections {
            if matched.outcome == Outcome::FalsePositive && matched.score >= score_threshold {
                let list = false_by_image.entry(item.image).or_default();
                list.push(matched.detection as usize);
            }
        }
    }
    // Per unit: flipped and found clean.
    let mut units = BTreeMap::<u32, [u64; 2]>::new();
    let mut flips = BTreeMap::<(u32, u32), u64>::new();
    for pair in pairs.iter().filter(|pair| pair.clean.is_some()) {
        let counts = units.entry(plan.unit(pair.image)?).or_default();
        counts[1] += 1;
        let Some(object) = labels.objects.get(pair.object as usize) else {
            continue;
        };
        if pair.cracked.is_some() {
            continue;
        }
        let list = false_by_image
            .get(&pair.image)
            .map_or(&[][..], Vec::as_slice);
        let best = list
            .iter()
            .filter_map(|idx| cracked_detections.items.get(*idx))
            .filter(|it| it.category != pair.category && it.box_px.iou(&object.box_px) >= iou)
            .max_by(|a, b| a.score.total_cmp(&b.score));
        if let Some(best) = best {
            *flips.entry((pair.category, best.category)).or_default() += 1;
            counts[0] += 1;
        }
    }
    let clusters: Vec<[u64; 2]> = units.into_values().collect();
    let table = flips
        .into_iter()
        .map(|((category, taken_for), n)| ClassFlip {
            category,
            taken_for,
            n,
        });
    Ok(ClassFlips {
        n_found_clean: clusters.iter().map(|it| it[1]).sum(),
        n_flipped: clusters.iter().map(|it| it[0]).sum(),
        flip_rate: clustered_share(&clusters, plan.level),
        table: table.collect(),
    })
}
