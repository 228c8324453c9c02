//! What detections and labels call the same boxes.

use super::AuditSettings;
use crate::EvalError;
use crate::detections::{Detection, Detections};
use crate::labels::{LabelSet, Object, ObjectKind};

/// How often a detected class lies on a labeled one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Confusion {
    n_categories: usize,
    /// Rows are detected classes.
    counts: Vec<u64>,
}

impl Confusion {
    fn new(n_categories: usize) -> Self {
        Self {
            n_categories,
            counts: vec![0; n_categories * n_categories],
        }
    }

    /// All pairs.
    #[must_use]
    pub fn n_pairs(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Categories of the labels.
    #[must_use]
    pub fn n_categories(&self) -> usize {
        self.n_categories
    }

    /// Detected class, labeled class and how often, where that is not 0.
    pub fn cells(&self) -> impl Iterator<Item = (u32, u32, u64)> + '_ {
        (0_u32..)
            .zip(self.counts.chunks(self.n_categories.max(1)))
            .flat_map(|(detected, row)| {
                (0_u32..)
                    .zip(row)
                    .map(move |(labeled, n)| (detected, labeled, *n))
            })
            .filter(|(_, _, n)| *n > 0)
    }

    /// Pairs whose detected class a map takes to the labeled one.
    pub(super) fn n_agreeing(&self, map: impl Fn(u32) -> Option<u32>) -> u64 {
        self.cells()
            .filter(|(detected, labeled, _)| map(*detected) == Some(*labeled))
            .map(|(_, _, n)| n)
            .sum()
    }

    pub(super) fn sum(halves: &[Self; 2]) -> Self {
        let [a, b] = halves;
        Self {
            n_categories: a.n_categories,
            counts: a.counts.iter().zip(&b.counts).map(|(a, b)| a + b).collect(),
        }
    }

    pub(super) fn counts(&self) -> &[u64] {
        &self.counts
    }
}

/// What the detections of all images call the objects they lie on.
///
/// Per image and by falling score, each detection takes the object of any class that it overlaps
/// most and at least by the setting's IoU among those that are left. Crowds and ignored objects
/// take no part.
///
/// # Errors
/// If a detection or object is of an image or category that the labels do not have, or a setting is
/// not finite.
pub fn confusion(
    labels: &LabelSet,
    detections: &Detections,
    settings: AuditSettings,
) -> Result<Confusion, EvalError> {
    Ok(Confusion::sum(&by_halves(labels, detections, settings)?))
}

/// The same, apart for images at even and at odd places.
pub(super) fn by_halves(
    labels: &LabelSet,
    detections: &Detections,
    settings: AuditSettings,
) -> Result<[Confusion; 2], EvalError> {
    for (what, value) in [
        ("score threshold", settings.score_threshold),
        ("overlap", settings.iou),
        ("margin", settings.margin),
    ] {
        if !value.is_finite() {
            return Err(EvalError::StatisticSetting {
                what,
                value,
                range: "that is finite",
            });
        }
    }
    let n_images = labels.images.len();
    let n_categories = labels.categories.len();
    let mut objects: Vec<Vec<&Object>> = vec![Vec::new(); n_images];
    let mut by_image: Vec<Vec<&Detection>> = vec![Vec::new(); n_images];
    for object in &labels.objects {
        check(object.image, n_images, "image of an object")?;
        check(object.category, n_categories, "category of an object")?;
        if object.kind == ObjectKind::Regular {
            objects[object.image as usize].push(object);
        }
    }
    for detection in &detections.items {
        check(detection.image, n_images, "image of a detection")?;
        check(detection.category, n_categories, "category of a detection")?;
        if detection.score >= settings.score_threshold {
            by_image[detection.image as usize].push(detection);
        }
    }
    let mut halves = [Confusion::new(n_categories), Confusion::new(n_categories)];
    for (image, (objects, detections)) in objects.iter().zip(&mut by_image).enumerate() {
        detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut is_taken = vec![false; objects.len()];
        for detection in detections {
            let best = objects
                .iter()
                .enumerate()
                .filter(|(place, _)| !is_taken[*place])
                .map(|(place, object)| (place, object.box_px.iou(&detection.box_px)))
                .filter(|(_, iou)| *iou >= settings.iou)
                .reduce(|best, it| if it.1 > best.1 { it } else { best });
            if let Some((place, _)) = best {
                is_taken[place] = true;
                let row = detection.category as usize * n_categories;
                halves[image % 2].counts[row + objects[place].category as usize] += 1;
            }
        }
    }
    Ok(halves)
}

fn check(place: u32, n: usize, what: &'static str) -> Result<(), EvalError> {
    if (place as usize) < n {
        return Ok(());
    }
    Err(EvalError::StatisticLength {
        what,
        found: place as usize,
        expected: n,
        of: "are in the labels",
    })
}
