//! A frame of KITTI: which objects and detections take part, and who finds whom.

use super::{KittiClass, KittiDifficulty};
use crate::protocol::engine::Restriction;
use crate::{KittiDetections, KittiFacts, KittiLabels, ObjectKind};

/// What is in a frame.
pub(super) struct Frame<'a> {
    objects: Vec<Thing<'a>>,
    /// `DontCare` areas.
    areas: Vec<[f64; 4]>,
    detections: Vec<Thing<'a>>,
}

/// An object or a detection.
#[derive(Clone, Copy)]
pub(super) struct Thing<'a> {
    name: &'a str,
    corners_px: [f64; 4],
    score: f64,
    occlusion: f64,
    truncation: f64,
    /// Whether it is inside of the restriction.
    is_inside: bool,
}

pub(super) fn frames<'a>(
    labels: &'a KittiLabels,
    detections: &'a KittiDetections,
    restriction: Option<&Restriction<'_>>,
) -> Vec<Frame<'a>> {
    let is_inside = |values: Option<&[f64]>, idx: usize, range: [f64; 2]| match values {
        None => true,
        Some(values) => {
            let value = values.get(idx).copied().unwrap_or(f64::NAN);
            value >= range[0] && value <= range[1]
        }
    };
    let range = restriction.map_or([0.0; 2], |r| r.range);
    let mut by_image: Vec<Frame<'a>> = labels
        .set
        .images
        .iter()
        .map(|_| Frame {
            objects: Vec::new(),
            areas: Vec::new(),
            detections: Vec::new(),
        })
        .collect();
    let name_of = |category: u32| {
        let idx = usize::try_from(category).unwrap_or(usize::MAX);
        labels
            .set
            .categories
            .get(idx)
            .map_or("", |c| c.name.as_str())
    };
    let place = |image: u32| usize::try_from(image).unwrap_or(usize::MAX);
    for (idx, (object, facts)) in labels.set.objects.iter().zip(&labels.facts).enumerate() {
        let Some(frame) = by_image.get_mut(place(object.image)) else {
            continue;
        };
        let name = name_of(object.category);
        if object.kind == ObjectKind::Ignored {
            frame.areas.push(facts.corners_px);
        }
        frame.objects.push(Thing {
            name,
            corners_px: facts.corners_px,
            score: 0.0,
            occlusion: facts.occlusion,
            truncation: facts.truncation,
            is_inside: is_inside(restriction.map(|r| r.objects), idx, range),
        });
    }
    let said = detections.set.items.iter().zip(&detections.corners_px);
    for (idx, (detection, corners_px)) in said.enumerate() {
        if let Some(frame) = by_image.get_mut(place(detection.image)) {
            frame.detections.push(Thing {
                name: name_of(detection.category),
                corners_px: *corners_px,
                score: detection.score,
                occlusion: 0.0,
                truncation: 0.0,
                is_inside: is_inside(restriction.map(|r| r.detections), idx, range),
            });
        }
    }
    let kept = by_image.into_iter().zip(0u32..);
    kept.filter(|(_, image)| detections.images.binary_search(image).is_ok())
        .map(|(frame, _)| frame)
        .collect()
}

/// How a thing takes part.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// It counts.
    Counts,
    /// It may be assigned, and counts for nothing.
    Ignored,
    /// It does not take part.
    Absent,
}

impl Frame<'_> {
    /// Overlaps of all detections with the objects that may take part, object by object.
    pub(super) fn overlaps(&self, class: KittiClass) -> Vec<f64> {
        let of_object = |object: &Thing<'_>| {
            let takes_part = Self::is_near(object, class);
            let corners = object.corners_px;
            self.detections
                .iter()
                .map(move |detection| match takes_part {
                    true => overlap(&detection.corners_px, &corners, Of::Union),
                    false => 0.0,
                })
        };
        self.objects.iter().flat_map(of_object).collect()
    }

    fn is_near(object: &Thing<'_>, class: KittiClass) -> bool {
        let is = |name: &str| object.name.eq_ignore_ascii_case(name);
        is(class.name()) || class.neighbor().is_some_and(is)
    }

    pub(super) fn objects_of(&self, class: KittiClass, difficulty: KittiDifficulty) -> Vec<Part> {
        let part_of = |object: &Thing<'_>| {
            let facts = KittiFacts {
                corners_px: object.corners_px,
                truncation: object.truncation,
                occlusion: object.occlusion,
            };
            let is_hard = is_hard(&facts, difficulty);
            match Self::is_near(object, class) {
                false => Part::Absent,
                true if !object.name.eq_ignore_ascii_case(class.name()) => Part::Ignored,
                true if is_hard || !object.is_inside => Part::Ignored,
                true => Part::Counts,
            }
        };
        self.objects.iter().map(part_of).collect()
    }

    pub(super) fn detections_of(
        &self,
        class: KittiClass,
        difficulty: KittiDifficulty,
    ) -> Vec<Part> {
        let part_of = |detection: &Thing<'_>| {
            if is_low(&detection.corners_px, difficulty) {
                Part::Ignored
            } else if detection.name.eq_ignore_ascii_case(class.name()) {
                Part::Counts
            } else {
                Part::Absent
            }
        };
        self.detections.iter().map(part_of).collect()
    }

    /// The scores at which objects are found, each by the detection with the highest score.
    pub(super) fn scores(&self, class: KittiClass, parts: &Parts, overlaps: &[f64]) -> Vec<f64> {
        let mut is_taken = vec![false; self.detections.len()];
        let mut scores = Vec::new();
        let rows = overlaps.chunks(self.detections.len().max(1));
        for (object, row) in parts.objects.iter().zip(rows) {
            if *object == Part::Absent {
                continue;
            }
            let mut best: Option<(usize, f64)> = None;
            let candidates = self.detections.iter().zip(&parts.detections).zip(row);
            for (idx, ((detection, part), overlap)) in candidates.enumerate() {
                let is_free = is_taken.get(idx) == Some(&false) && *part != Part::Absent;
                let beats = best.is_none_or(|(_, score)| detection.score > score);
                // The program begins its search below any score that is meant seriously.
                let is_score = detection.score > -10_000_000.0;
                if is_free && *overlap > class.min_overlap() && beats && is_score {
                    best = Some((idx, detection.score));
                }
            }
            let Some((idx, score)) = best else { continue };
            if let Some(is_taken) = is_taken.get_mut(idx) {
                *is_taken = true;
            }
            if *object == Part::Counts && parts.detections.get(idx) == Some(&Part::Counts) {
                scores.push(score);
            }
        }
        scores
    }

    /// The scores of the detections that take part, falling, each once.
    pub(super) fn distinct_scores(&self, parts: &Parts) -> Vec<f64> {
        let takes_part = self.detections.iter().zip(&parts.detections);
        let mut scores: Vec<f64> = takes_part
            .filter(|(_, part)| **part != Part::Absent)
            .map(|(detection, _)| detection.score + 0.0)
            .collect();
        scores.sort_by(|a, b| b.total_cmp(a));
        scores.dedup_by(|a, b| a.total_cmp(b).is_eq());
        scores
    }

    /// Found objects, false detections and missed objects above a score.
    pub(super) fn counts(
        &self,
        class: KittiClass,
        parts: &Parts,
        overlaps: &[f64],
        least: f64,
    ) -> [u64; 3] {
        let min_overlap = class.min_overlap();
        let mut is_taken = vec![false; self.detections.len()];
        let (mut n_found, mut n_missed) = (0, 0);
        let rows = overlaps.chunks(self.detections.len().max(1));
        // A frame without detections has no rows, but objects.
        let rows = rows.map(Some).chain(std::iter::repeat(None));
        for (object, row) in parts.objects.iter().zip(rows) {
            if *object == Part::Absent {
                continue;
            }
            let mut best: Option<(usize, f64, Part)> = None;
            let candidates = self.detections.iter().zip(&parts.detections);
            for (idx, ((detection, part), overlap)) in
                candidates.zip(row.unwrap_or(&[])).enumerate()
            {
                let is_free = is_taken.get(idx) == Some(&false) && *part != Part::Absent;
                if !is_free || detection.score < least || *overlap <= min_overlap {
                    continue;
                }
                let beats = match (part, best) {
                    (_, None) => true,
                    // One that counts replaces one that is ignored, whatever their overlaps.
                    (Part::Counts, Some((_, _, Part::Ignored))) => true,
                    (Part::Counts, Some((_, most, _))) => *overlap > most,
                    (_, Some(_)) => false,
                };
                if beats {
                    best = Some((idx, *overlap, *part));
                }
            }
            match best {
                Some((idx, _, part)) => {
                    if let Some(is_taken) = is_taken.get_mut(idx) {
                        *is_taken = true;
                    }
                    n_found += u64::from(*object == Part::Counts && part == Part::Counts);
                }
                None => n_missed += u64::from(*object == Part::Counts),
            }
        }
        let is_on_area = |detection: &Thing<'_>| {
            let areas = self.areas.iter();
            areas
                .map(|area| overlap(&detection.corners_px, area, Of::First))
                .any(|overlap| overlap > min_overlap)
        };
        let said = self.detections.iter().zip(&parts.detections).zip(&is_taken);
        let n_false = said
            .filter(|((detection, part), is_taken)| {
                **part == Part::Counts
                    && !**is_taken
                    && detection.score >= least
                    && detection.is_inside
                    && !is_on_area(detection)
            })
            .count();
        [
            n_found,
            u64::try_from(n_false).unwrap_or(u64::MAX),
            n_missed,
        ]
    }
}

/// How the things of a frame take part for one class and difficulty.
pub(super) struct Parts {
    pub(super) objects: Vec<Part>,
    pub(super) detections: Vec<Part>,
}

/// Whether an object is harder than those that are to be found.
pub(super) fn is_hard(facts: &KittiFacts, difficulty: KittiDifficulty) -> bool {
    let (min_height, max_occlusion, max_truncation) = difficulty.limits();
    let [_, y0, _, y1] = facts.corners_px;
    facts.occlusion > max_occlusion || facts.truncation > max_truncation || y1 - y0 < min_height
}

/// Whether a detection is too low, in whole pixels.
pub(super) fn is_low(corners_px: &[f64; 4], difficulty: KittiDifficulty) -> bool {
    let (min_height, ..) = difficulty.limits();
    let [_, y0, _, y1] = corners_px;
    (y0 - y1).abs().trunc() < min_height
}

/// What an overlap is a share of.
#[derive(Clone, Copy)]
enum Of {
    /// The area of both.
    Union,
    /// The area of the first.
    First,
}

fn overlap(a: &[f64; 4], b: &[f64; 4], of: Of) -> f64 {
    let width = a[2].min(b[2]) - a[0].max(b[0]);
    let height = a[3].min(b[3]) - a[1].max(b[1]);
    if width <= 0.0 || height <= 0.0 {
        return 0.0;
    }
    let both = width * height;
    let area = |c: &[f64; 4]| (c[2] - c[0]) * (c[3] - c[1]);
    match of {
        Of::Union => both / (area(a) + area(b) - both),
        Of::First => both / area(a),
    }
}
