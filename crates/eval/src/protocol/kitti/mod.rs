//! The protocol of KITTI, object detection in 2-D, as the benchmark's own program has it.
//!
//! **Source**: `evaluate_object.cpp` of the object development kit, with all its habits: the height
//! of a detection is cut to whole pixels; a detection that is too low is ignored whatever its class,
//! so that it may take an object; objects choose detections, in the order of the file.

mod frame;
mod ranked;

pub use ranked::{KittiRanking, rank_kitti};

use super::curve::exact;
use super::engine::Restriction;
use crate::{EvalError, KittiDetections, KittiLabels};

/// Recalls at which precision is read.
pub(crate) const N_KITTI_RECALLS: usize = 41;

/// The classes that the benchmark evaluates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum KittiClass {
    /// Cars; vans count for nothing.
    Car,
    /// Pedestrians; people who sit count for nothing.
    Pedestrian,
    /// Cyclists.
    Cyclist,
}

impl KittiClass {
    /// All of them, in the order of the benchmark.
    pub const ALL: [Self; 3] = [Self::Car, Self::Pedestrian, Self::Cyclist];

    /// Its name in lower case: `car`, `pedestrian`, `cyclist`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Pedestrian => "pedestrian",
            Self::Cyclist => "cyclist",
        }
    }

    /// The overlap (IoU) that a detection must exceed: 0.7 for cars, else 0.5.
    #[must_use]
    pub const fn min_overlap(self) -> f64 {
        match self {
            Self::Car => 0.7,
            Self::Pedestrian | Self::Cyclist => 0.5,
        }
    }

    /// The class that is so like it that taking one for the other is no error.
    const fn neighbor(self) -> Option<&'static str> {
        match self {
            Self::Car => Some("van"),
            Self::Pedestrian => Some("person_sitting"),
            Self::Cyclist => None,
        }
    }
}

/// How hard the objects are that are to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum KittiDifficulty {
    /// 40 px high, not hidden, at most 15 % outside of the frame.
    Easy,
    /// 25 px high, partly hidden, at most 30 % outside of the frame.
    Moderate,
    /// 25 px high, mostly hidden, at most 50 % outside of the frame.
    Hard,
}

impl KittiDifficulty {
    /// All of them, from easy to hard.
    pub const ALL: [Self; 3] = [Self::Easy, Self::Moderate, Self::Hard];

    /// Its name: `easy`, `moderate`, `hard`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Easy => "easy",
            Self::Moderate => "moderate",
            Self::Hard => "hard",
        }
    }

    /// Least height in px, greatest occlusion (0 to 3), greatest truncation (0 to 1).
    const fn limits(self) -> (f64, f64, f64) {
        match self {
            Self::Easy => (40.0, 0.0, 0.15),
            Self::Moderate => (25.0, 1.0, 0.30),
            Self::Hard => (25.0, 2.0, 0.50),
        }
    }
}

/// The result of one class and difficulty.
#[derive(Debug, Clone, PartialEq)]
pub struct KittiCurve {
    /// The class.
    pub class: KittiClass,
    /// The difficulty.
    pub difficulty: KittiDifficulty,
    /// Objects that are to be found.
    pub n_gt: u64,
    /// Frames with at least one of them.
    pub n_images: u64,
    /// Scores above which detections are counted, one per recall, falling.
    pub thresholds: Vec<f64>,
    /// Found objects, false detections and missed objects above each threshold.
    pub counts: Vec<[u64; 3]>,
    /// The best precision at this recall or a higher one, 0 to 1; 0 where the recall is not
    /// reached, NaN where nothing at all is counted, as in the benchmark's program.
    pub precision: [f64; N_KITTI_RECALLS],
}

impl KittiCurve {
    /// Recall at each threshold, 0 to 1.
    #[must_use]
    pub fn recall(&self) -> Vec<f64> {
        let recall_of = |[found, _, missed]: &[u64; 3]| exact(*found) / exact(found + missed);
        self.counts.iter().map(recall_of).collect()
    }

    /// Average precision at 11 recalls, 0, 0.1, … 1, in percent: the benchmark until 2019.
    #[must_use]
    pub fn ap11(&self) -> f64 {
        let sum: f64 = self.precision.iter().step_by(4).sum();
        sum / 11.0 * 100.0
    }

    /// Average precision at 40 recalls, 1/40 to 1, in percent: the benchmark since October 2019.
    #[must_use]
    pub fn ap40(&self) -> f64 {
        let sum: f64 = self.precision.iter().skip(1).sum();
        sum / 40.0 * 100.0
    }

    /// The AP11 and AP40 in percent of a detector that finds all and errs nowhere, for so many
    /// objects: below 41 objects less than 100.
    #[must_use]
    pub fn ceiling(n_gt: u64) -> [f64; 2] {
        // From 41 objects on nothing changes any more.
        let n_gt = n_gt.min(1000);
        let n_scores = usize::try_from(n_gt).unwrap_or(0);
        let perfect = KittiCurve::of_precision(score_thresholds(vec![1.0; n_scores], n_gt).len());
        [perfect.ap11(), perfect.ap40()]
    }

    /// A curve that is 1 at so many recalls.
    fn of_precision(n_reached: usize) -> Self {
        let mut precision = [0.0; N_KITTI_RECALLS];
        precision.iter_mut().take(n_reached).for_each(|p| *p = 1.0);
        Self {
            class: KittiClass::Car,
            difficulty: KittiDifficulty::Easy,
            n_gt: 0,
            n_images: 0,
            thresholds: Vec::new(),
            counts: Vec::new(),
            precision,
        }
    }
}

/// Evaluates detections by the protocol of KITTI: for each class, the three difficulties. Frames
/// without a result file are left out, as in the benchmark's program.
///
/// With a restriction, objects outside its range are ignored, and so is a detection outside its
/// range that finds nothing, like one on a `DontCare` area.
///
/// # Errors
/// [`EvalError::Rule`] for a restriction of other objects or detections.
pub fn evaluate_kitti(
    labels: &KittiLabels,
    detections: &KittiDetections,
    restriction: Option<&Restriction<'_>>,
) -> Result<Vec<KittiCurve>, EvalError> {
    let rankings = rank_kitti(labels, detections, restriction)?;
    Ok(rankings
        .iter()
        .map(|ranking| ranking.curve(&vec![1; ranking.n_cells()]))
        .collect())
}

/// The best precision at each recall or a higher one, by the counts above each score.
fn precision_of(counts: &[[u64; 3]]) -> [f64; N_KITTI_RECALLS] {
    let mut precision = [0.0; N_KITTI_RECALLS];
    for (precision, [found, wrong, _]) in precision.iter_mut().zip(counts) {
        *precision = exact(*found) / exact(found + wrong);
    }
    let raw = precision;
    for (idx, precision) in precision.iter_mut().enumerate().take(counts.len()) {
        // `max_element` of C++: a NaN at the beginning stays, later ones are passed over.
        let rest = raw.get(idx + 1..).unwrap_or(&[]);
        *precision = rest
            .iter()
            .fold(*precision, |best, p| if best < *p { *p } else { best });
    }
    precision
}

/// The scores that come nearest to 41 recalls at equal distances.
fn score_thresholds(mut scores: Vec<f64>, n_gt: u64) -> Vec<f64> {
    scores.sort_by(|a, b| b.total_cmp(a));
    let n_gt = exact(n_gt);
    let mut thresholds = Vec::new();
    let mut recall = 0.0;
    for (idx, score) in (1u64..).zip(&scores) {
        let is_last = usize::try_from(idx) == Ok(scores.len());
        let here = exact(idx) / n_gt;
        let next = match is_last {
            true => here,
            false => exact(idx + 1) / n_gt,
        };
        if next - recall < recall - here && !is_last {
            continue;
        }
        thresholds.push(*score);
        recall += 1.0 / 40.0;
    }
    thresholds
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a perfect detector gets, from the run of the benchmark's program.
    #[test]
    fn few_objects_put_a_ceiling_on_the_precision() {
        for (n_gt, ap11, ap40) in [
            (0, 0.0, 0.0),
            (1, 9.09, 0.0),
            (2, 9.09, 2.5),
            (5, 18.18, 10.0),
            (10, 27.27, 22.5),
            (20, 45.45, 47.5),
            (40, 90.91, 97.5),
            (41, 100.0, 100.0),
            (100_000, 100.0, 100.0),
        ] {
            let [found11, found40] = KittiCurve::ceiling(n_gt);
            assert!((found11 - ap11).abs() < 0.005, "{n_gt}: AP11 {found11}");
            assert!((found40 - ap40).abs() < 0.005, "{n_gt}: AP40 {found40}");
        }
    }
}
