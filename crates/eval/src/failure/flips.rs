//! Objects that are taken for another class behind cracks.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::ObjectPair;
use crate::detections::Detections;
use crate::labels::LabelSet;
use crate::matching::{ImageMatches, Outcome};
use crate::statistic::{Measured, proportion};

/// Which classes objects are taken for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClassFlips {
    /// Objects found clean.
    pub n_found_clean: u64,
    /// Those of them taken for another class in the cracked image.
    pub n_flipped: u64,
    /// Their share, with Wilson's interval.
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
    /// Objects of the category found clean.
    pub n_found_clean: u64,
    /// The share, with Wilson's interval.
    pub rate: Measured,
}

/// Objects found clean and lost cracked that a false positive of another class of at least
/// `score_threshold` overlaps by at least `iou` in the cracked image; of several the one of the
/// highest score counts. A detection that rightly finds a neighbor of the other class is no flip.
#[must_use]
pub fn class_flips(
    pairs: &[ObjectPair],
    cracked: &[ImageMatches],
    cracked_detections: &Detections,
    labels: &LabelSet,
    score_threshold: f64,
    iou: f64,
    level: f64,
) -> ClassFlips {
    let mut false_by_image = BTreeMap::<u32, Vec<usize>>::new();
    for item in cracked {
        for matched in &item.detections {
            if matched.outcome == Outcome::FalsePositive && matched.score >= score_threshold {
                let list = false_by_image.entry(item.image).or_default();
                list.push(matched.detection as usize);
            }
        }
    }
    let mut n_found = BTreeMap::<u32, u64>::new();
    let mut flips = BTreeMap::<(u32, u32), u64>::new();
    for pair in pairs.iter().filter(|pair| pair.clean.is_some()) {
        *n_found.entry(pair.category).or_default() += 1;
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
        }
    }
    let n_found_clean = n_found.values().sum();
    let n_flipped = flips.values().sum();
    let table = flips
        .into_iter()
        .map(|((category, taken_for), n)| {
            let n_found_clean = n_found.get(&category).copied().unwrap_or(0);
            ClassFlip {
                category,
                taken_for,
                n,
                n_found_clean,
                rate: proportion(n, n_found_clean, level),
            }
        })
        .collect();
    ClassFlips {
        n_found_clean,
        n_flipped,
        flip_rate: proportion(n_flipped, n_found_clean, level),
        table,
    }
}
