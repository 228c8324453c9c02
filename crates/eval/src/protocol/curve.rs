//! Precision over recall, and its mean, from what became of each detection.

use crate::{ImageMatches, Outcome};

/// Recalls at which precision is read: 0, 0.01, … 1, as `numpy.linspace(0, 1, 101)` has them.
pub(crate) const N_RECALLS: usize = 101;

/// What pycocotools adds to the number of detections before it divides by it: `numpy.spacing(1)`.
const SPACING: f64 = f64::EPSILON;

/// Precision, and the score that reaches it, at 101 recalls.
#[derive(Debug, Clone, PartialEq)]
pub struct PrecisionCurve {
    /// The best precision at this recall or a higher one, 0 to 1; 0 where it is not reached.
    pub precision: [f64; N_RECALLS],
    /// The score of the first detection that reaches the recall; 0 where it is not reached.
    pub scores: [f64; N_RECALLS],
    /// The highest recall reached, 0 to 1.
    pub recall: f64,
}

impl PrecisionCurve {
    /// The mean precision, 0 to 1: average precision at one threshold of overlap.
    #[must_use]
    pub fn average_precision(&self) -> f64 {
        mean_in_numpy_order(&self.precision).unwrap_or(0.0)
    }
}

/// A detection of one category, reduced to what a curve needs.
#[derive(Debug, Clone, Copy)]
struct Ranked {
    score: f64,
    image: u32,
    /// The place in its image by falling score.
    rank: u32,
    /// Whether it found something; nothing where it counts for nothing.
    found: Option<bool>,
}

/// The detections of one category by falling score, ready for many curves: the sorting is done
/// once, and each choice of images, such as a replicate of a bootstrap, is one pass.
#[derive(Debug, Clone, Default)]
pub struct RankedMatches {
    detections: Vec<Ranked>,
    /// Image, and how many objects are to be found there.
    n_objects: Vec<(u32, u32)>,
}

impl RankedMatches {
    /// The detections of matches of one category, image by image in the order of the images, which
    /// decides between equal scores.
    #[must_use]
    pub fn of<'m>(matches: impl IntoIterator<Item = &'m ImageMatches>) -> Self {
        let mut ranked = Self::default();
        for of_image in matches {
            let image = of_image.image;
            let outcomes = of_image.detections.iter().map(|detection| {
                let found = match detection.outcome {
                    Outcome::TruePositive { .. } => Some(true),
                    Outcome::FalsePositive => Some(false),
                    Outcome::Ignored => None,
                };
                (detection.score, found)
            });
            let counted = of_image.objects.iter().filter(|object| !object.is_ignored);
            ranked.push(image, outcomes, counted.count());
        }
        ranked.sort();
        ranked
    }

    /// Adds the detections of an image by falling score; [`sort`](Self::sort) comes after the last.
    pub(crate) fn push(
        &mut self,
        image: u32,
        detections: impl Iterator<Item = (f64, Option<bool>)>,
        n_objects: usize,
    ) {
        self.detections
            .extend(detections.zip(0..).map(|((score, found), rank)| Ranked {
                score,
                image,
                rank,
                found,
            }));
        let n_objects = u32::try_from(n_objects).unwrap_or(u32::MAX);
        self.n_objects.push((image, n_objects));
    }

    pub(crate) fn sort(&mut self) {
        // Stable, as the merge sort of pycocotools; -0 equals 0.
        self.detections
            .sort_by(|a, b| (b.score + 0.0).total_cmp(&(a.score + 0.0)));
    }

    /// How many objects are to be found.
    #[must_use]
    pub fn n_objects(&self) -> u64 {
        self.n_objects.iter().map(|(_, n)| u64::from(*n)).sum()
    }

    /// The curve with each image counted as often as its weight says, as if it were there so many
    /// times; images beyond the end of the weights are not there. Nothing where no object is to be
    /// found.
    ///
    /// With all weights 1 this is the curve of the protocol, to the last bit.
    #[must_use]
    pub fn curve(&self, weights: &[u32]) -> Option<PrecisionCurve> {
        self.curve_of_first(u32::MAX, |image| {
            let idx = usize::try_from(image).ok();
            idx.and_then(|idx| weights.get(idx))
                .map_or(0, |w| u64::from(*w))
        })
    }

    /// [`curve`](Self::curve), of no more than so many detections per image.
    pub(crate) fn curve_of_first(
        &self,
        max_detections: u32,
        weight_of: impl Fn(u32) -> u64,
    ) -> Option<PrecisionCurve> {
        let n_objects: u64 = self
            .n_objects
            .iter()
            .map(|(image, n)| weight_of(*image) * u64::from(*n))
            .sum();
        if n_objects == 0 {
            return None;
        }
        let n_objects = exact(n_objects);
        let (mut n_found, mut n_false) = (0u64, 0u64);
        // Recall, precision and score after each detection.
        let mut points: Vec<(f64, f64, f64)> = Vec::with_capacity(self.detections.len());
        for detection in &self.detections {
            let weight = weight_of(detection.image);
            if weight == 0 || detection.rank >= max_detections {
                continue;
            }
            match detection.found {
                Some(true) => n_found += weight,
                Some(false) => n_false += weight,
                None => {}
            }
            let (found, wrong) = (exact(n_found), exact(n_false));
            let precision = found / (wrong + found + SPACING);
            points.push((found / n_objects, precision, detection.score));
        }
        let mut curve = PrecisionCurve {
            precision: [0.0; N_RECALLS],
            scores: [0.0; N_RECALLS],
            recall: points.last().map_or(0.0, |point| point.0),
        };
        let mut best = f64::NEG_INFINITY;
        for point in points.iter_mut().rev() {
            best = best.max(point.1);
            point.1 = best;
        }
        let mut at = 0;
        let slots = curve.precision.iter_mut().zip(&mut curve.scores);
        for ((precision, score), recall) in slots.zip(recalls()) {
            let rest = points.get(at..).unwrap_or(&[]);
            at += rest.partition_point(|point| point.0 < recall);
            let Some(point) = points.get(at) else { break };
            (*precision, *score) = (point.1, point.2);
        }
        Some(curve)
    }

    /// The average precision with each image counted as often as its weight says; nothing where no
    /// object is to be found.
    #[must_use]
    pub fn average_precision(&self, weights: &[u32]) -> Option<f64> {
        self.curve(weights).map(|curve| curve.average_precision())
    }
}

/// The average precision of matches of one category, 0 to 1, with each image counted as often as
/// its weight says; nothing where no object is to be found. Where many weightings of the same
/// matches are asked for, [`RankedMatches`] sorts but once.
#[must_use]
pub fn average_precision<'m>(
    matches: impl IntoIterator<Item = &'m ImageMatches>,
    weights: &[u32],
) -> Option<f64> {
    RankedMatches::of(matches).average_precision(weights)
}

/// `numpy.linspace(0, 1, 101)`.
fn recalls() -> impl Iterator<Item = f64> {
    (0..N_RECALLS).map(|idx| match idx {
        100 => 1.0,
        idx => exact(u64::try_from(idx).unwrap_or(0)) * 0.01,
    })
}

/// The mean with the order of additions of `numpy.mean`, so that it is equal to the last bit:
/// pairwise, with eight running sums up to 128 values. Nothing of no values.
#[must_use]
pub(crate) fn mean_in_numpy_order(values: &[f64]) -> Option<f64> {
    let n_values = u64::try_from(values.len()).ok().filter(|n| *n > 0)?;
    Some(pairwise_sum(values) / exact(n_values))
}

fn pairwise_sum(values: &[f64]) -> f64 {
    const LANES: usize = 8;
    if values.len() > 128 {
        let half = values.len() / 2;
        let (first, second) = values.split_at(half - half % LANES);
        return pairwise_sum(first) + pairwise_sum(second);
    }
    let (blocks, tail) = values.as_chunks::<LANES>();
    let Some((first, blocks)) = blocks.split_first() else {
        return tail.iter().fold(0.0, |sum, value| sum + value);
    };
    let mut lanes = *first;
    for block in blocks {
        for (lane, value) in lanes.iter_mut().zip(block) {
            *lane += value;
        }
    }
    let [a, b, c, d, e, f, g, h] = lanes;
    let head = ((a + b) + (c + d)) + ((e + f) + (g + h));
    tail.iter().fold(head, |sum, value| sum + value)
}

/// A count as a number, exact up to 2^53.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn exact(n: u64) -> f64 {
    n as f64
}
