//! KITTI's rules of what is ignored, with the matching of MS-COCO: for statistics.

use super::frame::{is_hard, is_low};
use super::{KittiClass, KittiDifficulty};
use crate::protocol::engine::{MatchRule, Restriction, match_images};
use crate::{
    Category, Detection, Detections, EvalError, ImageMatches, KittiDetections, KittiLabels,
    LabelSet, Object, ObjectKind, Outcome,
};

/// Which objects and detections of KITTI are matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiMatchRule<'a> {
    /// The class.
    pub class: KittiClass,
    /// How hard the objects are that are to be found; harder ones are ignored.
    pub difficulty: KittiDifficulty,
    /// The overlap that a detection must exceed, 0 to 1. KITTI's is
    /// [`KittiClass::min_overlap`].
    pub min_overlap: f64,
    /// What counts, if not all: objects outside are ignored, and detections outside that find
    /// nothing.
    pub region: Option<Restriction<'a>>,
}

/// What became of detections and objects of one class by KITTI's rules: harder objects and the
/// neighboring class are ignored; `DontCare` areas take any number of detections, by the share of
/// the detection in them; a detection that is too low and finds nothing counts for nothing.
///
/// Detections choose objects, by falling score, as in MS-COCO; KITTI's own program lets objects
/// choose, anew for each of its scores, which leaves nothing fixed that could be drawn again. The
/// curve of these matches is one of 101 recalls, without a ceiling for few objects.
///
/// Entries are of the evaluated frames that have any, by frame; places are those in the labels and
/// detections given.
///
/// # Errors
/// As [`match_images`](crate::match_images).
pub fn match_kitti(
    labels: &KittiLabels,
    detections: &KittiDetections,
    rule: &KittiMatchRule<'_>,
) -> Result<Vec<ImageMatches>, EvalError> {
    if let Some(region) = &rule.region {
        region.check(labels.set.objects.len(), detections.set.items.len())?;
    }
    let is_inside = |values: Option<&[f64]>, idx: usize| match (values, rule.region) {
        (Some(values), Some(region)) => {
            let range = region.range[0]..=region.range[1];
            values.get(idx).is_some_and(|value| range.contains(value))
        }
        _ => true,
    };
    let name_of = |category: u32| {
        let idx = usize::try_from(category).unwrap_or(usize::MAX);
        labels
            .set
            .categories
            .get(idx)
            .map_or("", |c| c.name.as_str())
    };
    let is_evaluated = |image: u32| detections.images.binary_search(&image).is_ok();
    let mut set = LabelSet {
        images: labels.set.images.clone(),
        categories: vec![Category {
            id: 1,
            name: rule.class.name().to_owned(),
            supercategory: None,
        }],
        objects: Vec::new(),
    };
    let mut object_places = Vec::new();
    for (idx, (object, facts)) in labels.set.objects.iter().zip(&labels.facts).enumerate() {
        let is = |name: &str| name_of(object.category).eq_ignore_ascii_case(name);
        let kind = if is("dontcare") {
            ObjectKind::Crowd
        } else if is(rule.class.name()) {
            let is_counted =
                !is_hard(facts, rule.difficulty) && is_inside(rule.region.map(|r| r.objects), idx);
            match is_counted {
                true => ObjectKind::Regular,
                false => ObjectKind::Ignored,
            }
        } else if rule.class.neighbor().is_some_and(is) {
            ObjectKind::Ignored
        } else {
            continue;
        };
        if is_evaluated(object.image) {
            object_places.push(place(idx));
            set.objects.push(Object {
                category: 0,
                kind,
                ..object.clone()
            });
        }
    }
    let mut said = Detections::default();
    let mut said_places = Vec::new();
    let mut said_values = Vec::new();
    let all = detections.set.items.iter().zip(&detections.corners_px);
    for (idx, (detection, corners)) in all.enumerate() {
        if !name_of(detection.category).eq_ignore_ascii_case(rule.class.name()) {
            continue;
        }
        let counts =
            !is_low(corners, rule.difficulty) && is_inside(rule.region.map(|r| r.detections), idx);
        said_places.push(place(idx));
        said_values.push(if counts { 1.0 } else { 0.0 });
        said.items.push(Detection {
            category: 0,
            ..*detection
        });
    }
    let object_values = vec![1.0; set.objects.len()];
    let values = Restriction {
        objects: &object_values,
        detections: &said_values,
        range: [1.0, 1.0],
    };
    let greedy = MatchRule {
        // More than the overlap, not as much.
        iou_threshold: rule.min_overlap.next_up().min(1.0),
        max_detections: u32::MAX,
        region: Some(values),
    };
    let category = crate::labels::kitti::place_of_type(&labels.set, rule.class.name());
    let original = |places: &[u32], idx: u32| {
        let idx = usize::try_from(idx).unwrap_or(usize::MAX);
        places.get(idx).copied().unwrap_or(u32::MAX)
    };
    let mut matches = match_images(&set, &said, &greedy)?;
    for image in &mut matches {
        image.category = category.unwrap_or(0);
        for detection in &mut image.detections {
            detection.detection = original(&said_places, detection.detection);
            if let Outcome::TruePositive { object, .. } = &mut detection.outcome {
                *object = original(&object_places, *object);
            }
        }
        for object in &mut image.objects {
            object.object = original(&object_places, object.object);
            object.detection = object.detection.map(|idx| original(&said_places, idx));
        }
    }
    Ok(matches)
}

fn place(idx: usize) -> u32 {
    u32::try_from(idx).unwrap_or(u32::MAX)
}
