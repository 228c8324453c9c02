//! A class and difficulty of KITTI, matched once and ready to be weighted.

use super::frame::{Frame, Part, Parts, frames};
use super::{KittiClass, KittiCurve, KittiDifficulty, precision_of, score_thresholds};
use crate::protocol::engine::Restriction;
use crate::{EvalError, KittiDetections, KittiLabels};

/// What the program of the benchmark counts in the frames of one class and difficulty, above any
/// score, so that a curve of weighted frames takes no matching.
///
/// The program matches anew above each of its scores. What it counts in a frame changes only where
/// the score passes that of a detection of the frame, so that these changes say all.
#[derive(Debug, Clone, PartialEq)]
pub struct KittiRanking {
    class: KittiClass,
    difficulty: KittiDifficulty,
    /// Scores at which objects are found, and the cell of each, falling.
    found: Vec<(f64, u32)>,
    /// By falling score.
    changes: Vec<Change>,
    /// Objects to be found per cell, where there are any.
    objects: Vec<(u32, u32)>,
    /// Cells that weights must have.
    n_cells: usize,
}

/// How the counts of a cell change where its detections down to a score take part.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    score: f64,
    cell: u32,
    /// Found objects, false detections, missed objects.
    by: [i32; 3],
}

/// Each class and difficulty, in the order of [`evaluate_kitti`](super::evaluate_kitti). Cells are
/// the evaluated frames, in their order in [`KittiDetections::images`].
///
/// # Errors
/// As [`evaluate_kitti`](super::evaluate_kitti).
pub fn rank_kitti(
    labels: &KittiLabels,
    detections: &KittiDetections,
    restriction: Option<&Restriction<'_>>,
) -> Result<Vec<KittiRanking>, EvalError> {
    if let Some(restriction) = restriction {
        restriction.check(labels.set.objects.len(), detections.set.items.len())?;
    }
    let frames = frames(labels, detections, restriction);
    let mut rankings = Vec::new();
    for class in KittiClass::ALL {
        let overlaps: Vec<Vec<f64>> = frames.iter().map(|frame| frame.overlaps(class)).collect();
        for difficulty in KittiDifficulty::ALL {
            rankings.push(KittiRanking::new(class, difficulty, &frames, &overlaps));
        }
    }
    Ok(rankings)
}

impl KittiRanking {
    fn new(
        class: KittiClass,
        difficulty: KittiDifficulty,
        frames: &[Frame<'_>],
        overlaps: &[Vec<f64>],
    ) -> Self {
        let mut ranking = Self {
            class,
            difficulty,
            found: Vec::new(),
            changes: Vec::new(),
            objects: Vec::new(),
            n_cells: frames.len(),
        };
        for ((frame, overlaps), cell) in frames.iter().zip(overlaps).zip(0u32..) {
            let parts = Parts {
                objects: frame.objects_of(class, difficulty),
                detections: frame.detections_of(class, difficulty),
            };
            let counted = parts.objects.iter().filter(|part| **part == Part::Counts);
            let n_objects = u32::try_from(counted.count()).unwrap_or(u32::MAX);
            if n_objects > 0 {
                ranking.objects.push((cell, n_objects));
            }
            let found = frame.scores(class, &parts, overlaps);
            ranking
                .found
                .extend(found.into_iter().map(|score| (score, cell)));
            let mut before = [0, 0, i64::from(n_objects)];
            for score in frame.distinct_scores(&parts) {
                let counts = frame.counts(class, &parts, overlaps, score);
                let counts = counts.map(|n| i64::try_from(n).unwrap_or(i64::MAX));
                let by: [i32; 3] = std::array::from_fn(|k| {
                    i32::try_from(counts[k] - before[k]).unwrap_or(i32::MAX)
                });
                before = counts;
                if by != [0; 3] {
                    ranking.changes.push(Change { score, cell, by });
                }
            }
        }
        ranking.sort();
        ranking
    }

    fn sort(&mut self) {
        // Stable; -0 equals 0.
        self.found
            .sort_by(|a, b| (b.0 + 0.0).total_cmp(&(a.0 + 0.0)));
        self.changes
            .sort_by(|a, b| (b.score + 0.0).total_cmp(&(a.score + 0.0)));
    }

    /// Several sets of detections in the same frames as one: the cell of a frame in version `k` of
    /// `n` is `frame · n + k`.
    #[must_use]
    pub(crate) fn crossed(versions: &[&Self]) -> Option<Self> {
        let n = u32::try_from(versions.len()).ok()?;
        let first = versions.first()?;
        let mut all = Self {
            class: first.class,
            difficulty: first.difficulty,
            found: Vec::new(),
            changes: Vec::new(),
            objects: Vec::new(),
            n_cells: versions.iter().map(|v| v.n_cells).max()? * versions.len(),
        };
        for (version, place) in versions.iter().zip(0..) {
            let cell = |frame: u32| frame * n + place;
            let found = version.found.iter();
            all.found
                .extend(found.map(|(score, frame)| (*score, cell(*frame))));
            let changes = version.changes.iter();
            all.changes.extend(changes.map(|change| Change {
                cell: cell(change.cell),
                ..*change
            }));
            let objects = version.objects.iter();
            all.objects
                .extend(objects.map(|(frame, n)| (cell(*frame), *n)));
        }
        all.sort();
        Some(all)
    }

    /// The class.
    #[must_use]
    pub fn class(&self) -> KittiClass {
        self.class
    }

    /// The difficulty.
    #[must_use]
    pub fn difficulty(&self) -> KittiDifficulty {
        self.difficulty
    }

    /// Cells that weights must have.
    #[must_use]
    pub fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// The cells with objects to be found, in order, and how many each has.
    #[must_use]
    pub(crate) fn objects(&self) -> &[(u32, u32)] {
        &self.objects
    }

    /// Objects to be found under the weights.
    #[must_use]
    pub fn n_objects(&self, weights: &[u32]) -> u64 {
        let objects = self.objects.iter();
        objects
            .map(|(cell, n)| u64::from(weight(weights, *cell)) * u64::from(*n))
            .sum()
    }

    /// The curve of the program if each cell were there as often as its weight says; with weights of
    /// 1 what the program gives. Cells beyond the weights count as absent.
    #[must_use]
    pub fn curve(&self, weights: &[u32]) -> KittiCurve {
        let n_gt = self.n_objects(weights);
        let scores = self
            .found
            .iter()
            .flat_map(|(score, cell)| std::iter::repeat_n(*score, weight(weights, *cell) as usize));
        let thresholds = score_thresholds(scores.collect(), n_gt);
        let mut sum = [0, 0, i64::try_from(n_gt).unwrap_or(i64::MAX)];
        let mut changes = self.changes.iter().peekable();
        let counts_above = |least: &f64| {
            while let Some(change) = changes.next_if(|change| change.score >= *least) {
                let weight = i64::from(weight(weights, change.cell));
                sum.iter_mut()
                    .zip(change.by)
                    .for_each(|(sum, by)| *sum += weight * i64::from(by));
            }
            sum.map(|n| u64::try_from(n).unwrap_or(0))
        };
        let counts: Vec<[u64; 3]> = thresholds.iter().map(counts_above).collect();
        let frames = self.objects.iter();
        KittiCurve {
            class: self.class,
            difficulty: self.difficulty,
            n_gt,
            n_images: frames
                .map(|(cell, _)| u64::from(weight(weights, *cell)))
                .sum(),
            precision: precision_of(&counts),
            thresholds,
            counts,
        }
    }
}

fn weight(weights: &[u32], cell: u32) -> u32 {
    weights.get(cell as usize).copied().unwrap_or(0)
}
