//! Objects with what became of them in the clean and in the cracked image.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::labels::LabelSet;
use crate::matching::{ImageMatches, Outcome};

/// An object that was to be found, and by what it was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectPair {
    /// Its place in [`LabelSet::objects`].
    pub object: u32,
    /// Place of its image in [`LabelSet::images`].
    pub image: u32,
    /// Place of its category in [`LabelSet::categories`].
    pub category: u32,
    /// Share of its box that the cracks' region covers, 0 to 1.
    pub coverage: f64,
    /// By what it is found in the clean image.
    pub clean: Option<Found>,
    /// By what it is found in the cracked image.
    pub cracked: Option<Found>,
}

/// A detection that found an object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Its place in [`Detections::items`](crate::Detections::items).
    pub detection: u32,
    /// Its score.
    pub score: f64,
    /// How much it overlaps the object, 0 to 1.
    pub iou: f64,
}

impl ObjectPair {
    /// Found clean, missed cracked.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.clean.is_some() && self.cracked.is_none()
    }
}

/// All objects that were to be found, in their order, with what found them among the detections of
/// at least `score_threshold`.
///
/// `coverage` has a value for each object of the label set. Pairs of several seeds are made one seed
/// after the other and put together.
///
/// Both sets of matches are of the same labels by the same rule, without a region, so that inside
/// and outside can be told apart by coverage later. Where matching goes by falling score, as in
/// MS-COCO, cutting by score afterwards is the same as before.
///
/// # Errors
/// If the two differ in the objects that they count, name objects that `labels` does not have, or
/// give one twice; if an object has no coverage; or if the threshold is not finite.
pub fn pair_objects(
    clean: &[ImageMatches],
    cracked: &[ImageMatches],
    labels: &LabelSet,
    coverage: &[f64],
    score_threshold: f64,
) -> Result<Vec<ObjectPair>, EvalError> {
    if coverage.len() != labels.objects.len() {
        return Err(EvalError::StatisticLength {
            what: "coverages",
            found: coverage.len(),
            expected: labels.objects.len(),
            of: "objects",
        });
    }
    if !score_threshold.is_finite() {
        return Err(EvalError::StatisticSetting {
            what: "score threshold",
            value: score_threshold,
            range: "that is finite",
        });
    }
    let clean = found_by_object(clean, score_threshold)?;
    let cracked = found_by_object(cracked, score_threshold)?;
    if !clean.keys().eq(cracked.keys()) {
        return Err(EvalError::NotPaired {
            what: format!(
                "the objects they count ({} and {})",
                clean.len(),
                cracked.len()
            ),
        });
    }
    clean
        .iter()
        .zip(cracked.values())
        .map(|((object, clean), cracked)| {
            let place = *object as usize;
            let Some((label, coverage)) = labels.objects.get(place).zip(coverage.get(place)) else {
                return Err(EvalError::NotPaired {
                    what: format!(
                        "object {object}, which the {} labels do not have",
                        labels.objects.len()
                    ),
                });
            };
            Ok(ObjectPair {
                object: *object,
                image: label.image,
                category: label.category,
                coverage: *coverage,
                clean: *clean,
                cracked: *cracked,
            })
        })
        .collect()
}

/// What found each object that counts.
fn found_by_object(
    matches: &[ImageMatches],
    score_threshold: f64,
) -> Result<BTreeMap<u32, Option<Found>>, EvalError> {
    let mut found = BTreeMap::new();
    for item in matches {
        for object in item.objects.iter().filter(|it| !it.is_ignored) {
            if found.insert(object.object, None).is_some() {
                return Err(EvalError::NotPaired {
                    what: format!("object {}, which is there twice", object.object),
                });
            }
        }
        for detection in &item.detections {
            let Outcome::TruePositive { object, iou } = detection.outcome else {
                continue;
            };
            if detection.score < score_threshold {
                continue;
            }
            if let Some(slot @ None) = found.get_mut(&object) {
                *slot = Some(Found {
                    detection: detection.detection,
                    score: detection.score,
                    iou,
                });
            }
        }
    }
    Ok(found)
}
