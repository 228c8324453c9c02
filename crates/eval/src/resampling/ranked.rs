//! Average precision of weighted images, from detections sorted once.

use crate::matching::{ImageMatches, Outcome};
use crate::protocol::mean_in_numpy_order;

/// Places on the axis of recall.
const N_RECALLS: usize = 101;

/// Something with an average precision under weights per cell.
pub(super) trait Ranked: Sync {
    /// Place of its category, or whatever tells it from the others.
    fn category(&self) -> u32;
    /// The cells with objects to be found, in order, and how many each has.
    fn objects(&self) -> &[(u32, u32)];
    /// `None` where there is nothing to be found, or where weights are missing.
    fn average_precision(&self, weights: &[u32]) -> Option<f64>;
}

impl Ranked for RankedCategory {
    fn category(&self) -> u32 {
        self.category()
    }

    fn objects(&self) -> &[(u32, u32)] {
        &self.objects
    }

    fn average_precision(&self, weights: &[u32]) -> Option<f64> {
        self.average_precision(weights)
    }
}

/// The counted detections of one category by falling score, ready to be weighted: what is ignored
/// is gone, and each detection knows only its image and whether it found something.
///
/// It gives the average precision of [`RankedMatches`](crate::RankedMatches), to the last bit, and
/// nothing else: without a curve a replicate takes a tenth of the time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RankedCategory {
    category: u32,
    /// Cell times 2, plus 1 for a true positive.
    entries: Vec<u32>,
    /// Objects to be found per cell, where there are any.
    objects: Vec<(u32, u32)>,
    /// Cells that weights must have.
    n_cells: usize,
}

/// The matches of one set of images, by category, sorted; one entry per category up to
/// `n_categories`. Cells are the images.
#[must_use]
pub fn rank_by_category(matches: &[ImageMatches], n_categories: usize) -> Vec<RankedCategory> {
    rank_versions(&[matches], n_categories)
}

/// The same of several versions of the images in one ranking, such as clean and cracked: the cell of an image is its
/// number times the number of versions, plus that of its version.
#[must_use]
pub fn rank_versions(versions: &[&[ImageMatches]], n_categories: usize) -> Vec<RankedCategory> {
    let n_versions = u32::try_from(versions.len()).unwrap_or(u32::MAX);
    let mut by_category: Vec<Vec<(&ImageMatches, u32)>> = vec![Vec::new(); n_categories];
    for (matches, version) in versions.iter().zip(0..) {
        for item in *matches {
            if let Some(list) = by_category.get_mut(item.category as usize) {
                list.push((item, item.image * n_versions + version));
            }
        }
    }
    by_category
        .into_iter()
        .zip(0..)
        .map(|(cells, category)| RankedCategory::new(category, cells))
        .collect()
}

impl RankedCategory {
    /// Sorts the matches of one category, each with the cell whose weight it has.
    ///
    /// Equal scores stay in the order of the cells, then in that of the matches, as in the COCO API.
    #[must_use]
    pub fn new(category: u32, mut matches: Vec<(&ImageMatches, u32)>) -> Self {
        matches.sort_by_key(|(_, cell)| *cell);
        let mut scored: Vec<(f64, u32)> = Vec::new();
        let mut objects = Vec::new();
        let mut n_cells = 0_usize;
        for (item, cell) in matches {
            n_cells = n_cells.max(cell as usize + 1);
            for detection in &item.detections {
                match detection.outcome {
                    Outcome::TruePositive { .. } => scored.push((detection.score, cell * 2 + 1)),
                    Outcome::FalsePositive => scored.push((detection.score, cell * 2)),
                    Outcome::Ignored => {}
                }
            }
            let n = item.objects.iter().filter(|it| !it.is_ignored).count();
            if let Ok(n @ 1..) = u32::try_from(n) {
                objects.push((cell, n));
            }
        }
        // Stable; -0 equals 0.
        scored.sort_by(|a, b| (b.0 + 0.0).total_cmp(&(a.0 + 0.0)));
        Self {
            category,
            entries: scored.into_iter().map(|(_, entry)| entry).collect(),
            objects,
            n_cells,
        }
    }

    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories).
    #[must_use]
    pub fn category(&self) -> u32 {
        self.category
    }

    /// Objects to be found under the weights.
    #[must_use]
    pub fn n_objects(&self, weights: &[u32]) -> u64 {
        self.objects
            .iter()
            .map(|(cell, n)| {
                u64::from(weights.get(*cell as usize).copied().unwrap_or(0)) * u64::from(*n)
            })
            .sum()
    }

    /// Average precision of the images, each as often as its weight says; `None` where there is
    /// nothing to be found, or where weights are missing.
    ///
    /// Mean over 101 recalls of the greatest precision at that recall or beyond,
    /// tp / (tp + fp + 2⁻⁵²), as the COCO API has it, to the last bit for weights of 1 \[Lin2014\].
    #[must_use]
    pub fn average_precision(&self, weights: &[u32]) -> Option<f64> {
        let n_objects = self.n_objects(weights);
        if n_objects == 0 || weights.len() < self.n_cells {
            return None;
        }
        let n_objects = n_objects as f64;
        // Recall, and with it precision that counts, changes at true positives only.
        let mut steps: Vec<(u64, u64)> = Vec::new();
        let (mut n_true, mut n_all) = (0_u64, 0_u64);
        for entry in &self.entries {
            let weight = u64::from(weights[(entry >> 1) as usize]);
            n_all += weight;
            if entry & 1 == 1 && weight > 0 {
                n_true += weight;
                steps.push((n_true, n_all));
            }
        }
        let mut at_recall = [0.0_f64; N_RECALLS];
        let mut next = N_RECALLS;
        let mut greatest = 0.0_f64;
        for (place, (n_true, n_all)) in steps.iter().enumerate().rev() {
            let precision = *n_true as f64 / (*n_all as f64 + f64::EPSILON);
            greatest = greatest.max(precision);
            // Recalls above what the step before reaches belong to this one.
            let before = match place.checked_sub(1).and_then(|it| steps.get(it)) {
                Some((n_true, _)) => *n_true as f64 / n_objects,
                None => -1.0,
            };
            let reached = *n_true as f64 / n_objects;
            while next > 0 && recall(next - 1) > reached {
                next -= 1;
            }
            while next > 0 && recall(next - 1) > before {
                next -= 1;
                at_recall[next] = greatest;
            }
        }
        mean_in_numpy_order(&at_recall)
    }
}

/// `numpy.linspace(0, 1, 101)[i]`.
fn recall(i: usize) -> f64 {
    if i + 1 == N_RECALLS {
        1.0
    } else {
        i as f64 * 0.01
    }
}
