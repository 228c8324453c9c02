//! Average precision of weighted images, from detections sorted once.

use std::array::from_fn;
use std::ops::Range;

use crate::matching::{ImageMatches, Outcome};
use crate::protocol::mean_in_numpy_order;

/// Places on the axis of recall.
const N_RECALLS: usize = 101;

/// Draws that are gone through side by side.
pub(super) const N_SIDE_BY_SIDE: usize = 8;

/// Weights of several draws, cell by cell.
#[derive(Debug, Default)]
pub(super) struct SideBySide {
    /// Columns without a draw are 0.
    cells: Vec<[u32; N_SIDE_BY_SIDE]>,
    greatest: u32,
}

impl SideBySide {
    /// Puts the weights of one more draw, of as many cells, beside those of others.
    pub(super) fn put(&mut self, draw: usize, weights: &[u32]) {
        self.cells.resize(weights.len(), [0; N_SIDE_BY_SIDE]);
        for (of_cell, weight) in self.cells.iter_mut().zip(weights) {
            of_cell[draw] = *weight;
            self.greatest = self.greatest.max(*weight);
        }
    }

    /// Those of one draw.
    pub(super) fn of_draw(&self, draw: usize) -> Vec<u32> {
        self.cells.iter().map(|of_cell| of_cell[draw]).collect()
    }
}

/// Something with an average precision under weights per cell.
pub(super) trait Ranked: Sync {
    /// Place of its category, or whatever tells it from the others.
    fn category(&self) -> u32;
    /// The cells with objects to be found, in order, and how many each has.
    fn objects(&self) -> &[(u32, u32)];
    /// Of each draw; `None` where there is nothing to be found, or where weights are missing.
    fn average_precisions(&self, weights: &SideBySide) -> [Option<f64>; N_SIDE_BY_SIDE];
}

impl Ranked for RankedCategory {
    fn category(&self) -> u32 {
        self.category()
    }

    fn objects(&self) -> &[(u32, u32)] {
        &self.objects
    }

    fn average_precisions(&self, weights: &SideBySide) -> [Option<f64>; N_SIDE_BY_SIDE] {
        self.under(&weights.cells, weights.greatest)
    }
}

/// The counted detections of one category by falling score, ready to be weighted. What is ignored is gone, and so is
/// what comes after the last true positive, which no precision that counts includes; of a detection stays the cell of
/// its image, and whether it found something.
///
/// It gives the average precision of [`RankedMatches`](crate::RankedMatches), to the last bit, and
/// nothing else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RankedCategory {
    category: u32,
    /// The cells of the detections, up to the last true positive.
    cells: Vec<u32>,
    /// How many detections there are up to each true positive, with it.
    ends: Vec<usize>,
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
    rank_run(versions, 0..n_categories)
}

/// The same of some categories, which all matches are of.
pub(super) fn rank_run(
    versions: &[&[ImageMatches]],
    categories: Range<usize>,
) -> Vec<RankedCategory> {
    let n_versions = u32::try_from(versions.len()).unwrap_or(u32::MAX);
    let mut by_category: Vec<Vec<(&ImageMatches, u32)>> = vec![Vec::new(); categories.len()];
    for (matches, version) in versions.iter().zip(0..) {
        for item in *matches {
            let place = (item.category as usize).checked_sub(categories.start);
            if let Some(list) = place.and_then(|place| by_category.get_mut(place)) {
                list.push((item, item.image * n_versions + version));
            }
        }
    }
    let categories = categories.map(|it| u32::try_from(it).unwrap_or(u32::MAX));
    (by_category.into_iter().zip(categories))
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
        let mut scored: Vec<(f64, u32, bool)> = Vec::new();
        let mut objects = Vec::new();
        let mut n_cells = 0_usize;
        for (item, cell) in matches {
            n_cells = n_cells.max(cell as usize + 1);
            for detection in &item.detections {
                match detection.outcome {
                    Outcome::TruePositive { .. } => scored.push((detection.score, cell, true)),
                    Outcome::FalsePositive => scored.push((detection.score, cell, false)),
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
        let places = scored.iter().zip(1..);
        let ends = places.filter_map(|((_, _, is_true), end)| is_true.then_some(end));
        let ends: Vec<usize> = ends.collect();
        scored.truncate(ends.last().copied().unwrap_or(0));
        Self {
            category,
            cells: scored.into_iter().map(|(_, cell, _)| cell).collect(),
            ends,
            objects,
            n_cells,
        }
    }

    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories).
    #[must_use]
    pub fn category(&self) -> u32 {
        self.category
    }

    /// Average precision of the images, each as often as its weight says; `None` where there is
    /// nothing to be found, or where weights are missing.
    ///
    /// Mean over 101 recalls of the greatest precision at that recall or beyond,
    /// tp / (tp + fp + 2⁻⁵²), as the COCO API has it, to the last bit for weights of 1 \[Lin2014\].
    #[must_use]
    pub fn average_precision(&self, weights: &[u32]) -> Option<f64> {
        let greatest = weights.iter().copied().max().unwrap_or(0);
        let (weights, _) = weights.as_chunks::<1>();
        self.under(weights, greatest)[0]
    }

    /// The same of several draws, whose weights lie side by side for each cell: detections are gone through once.
    fn under<const N: usize>(&self, weights: &[[u32; N]], greatest: u32) -> [Option<f64>; N] {
        if weights.len() < self.n_cells {
            return [None; N];
        }
        let mut n_objects = [0.0; N];
        for (cell, n) in &self.objects {
            for (sum, weight) in n_objects.iter_mut().zip(&weights[*cell as usize]) {
                *sum += f64::from(*weight) * f64::from(*n);
            }
        }
        if n_objects.iter().all(|n| *n <= 0.0) {
            return [None; N];
        }
        let precisions = self.precisions(weights, greatest, &n_objects);
        from_fn(|draw| match n_objects[draw] > 0.0 {
            true => mean_in_numpy_order(&precisions[draw]),
            false => None,
        })
    }

    /// Of each draw the greatest precision at each recall or beyond. Numbers of detections are whole, up to 2⁵³.
    #[expect(
        clippy::needless_range_loop,
        reason = "counted, loops over draws become a few instructions on several numbers at once"
    )]
    fn precisions<const N: usize>(
        &self,
        weights: &[[u32; N]],
        greatest: u32,
        n_objects: &[f64; N],
    ) -> [[f64; N_RECALLS]; N] {
        // So many weights fit 32 bits.
        let n_at_once = (u32::MAX / greatest.max(1)) as usize;
        // Recall, and with it precision that counts, changes at true positives only.
        let mut steps: Vec<Step<N>> = Vec::with_capacity(self.ends.len());
        let (mut n_true, mut n_all) = ([0.0; N], [0.0; N]);
        let mut start = 0;
        for end in &self.ends {
            for cells in self.cells[start..*end].chunks(n_at_once) {
                add(&mut n_all, &sums_of(cells, weights));
            }
            add(&mut n_true, &weights[self.cells[end - 1] as usize]);
            let mut step = Step {
                precision: n_true,
                recall: n_true,
            };
            for draw in 0..N {
                step.precision[draw] /= n_all[draw] + f64::EPSILON;
                step.recall[draw] /= n_objects[draw];
            }
            steps.push(step);
            start = *end;
        }
        let mut best = [0.0_f64; N];
        for step in steps.iter_mut().rev() {
            for draw in 0..N {
                best[draw] = best[draw].max(step.precision[draw]);
            }
            step.precision = best;
        }
        let mut at_recalls = [[0.0; N_RECALLS]; N];
        let mut next = [0; N];
        for step in &steps {
            for draw in 0..N {
                while next[draw] < N_RECALLS && recall(next[draw]) <= step.recall[draw] {
                    at_recalls[draw][next[draw]] = step.precision[draw];
                    next[draw] += 1;
                }
            }
        }
        at_recalls
    }
}

/// What is reached at a true positive, under each draw.
struct Step<const N: usize> {
    precision: [f64; N],
    recall: [f64; N],
}

/// Adds weights.
fn add<const N: usize>(sums: &mut [f64; N], weights: &[u32; N]) {
    for draw in 0..N {
        sums[draw] += f64::from(weights[draw]);
    }
}

/// Sums of the weights of some cells.
fn sums_of<const N: usize>(cells: &[u32], weights: &[[u32; N]]) -> [u32; N] {
    let mut sums = [0; N];
    for cell in cells {
        let of_cell = &weights[*cell as usize];
        for draw in 0..N {
            sums[draw] += of_cell[draw];
        }
    }
    sums
}

/// `numpy.linspace(0, 1, 101)[i]`.
fn recall(i: usize) -> f64 {
    if i + 1 == N_RECALLS {
        1.0
    } else {
        i as f64 * 0.01
    }
}
