//! The convention of BDD100K and Scalabel, on top of the protocol of MS-COCO.

use crate::{BoxPx, Detections, LabelSet, ObjectKind};

/// The box with its last pixels in it: one pixel wider and higher, as `box2d_to_bbox` of Scalabel
/// has it, `w = x2 - x1 + 1`.
fn inclusive(box_px: BoxPx) -> BoxPx {
    BoxPx {
        width: box_px.width + 1.0,
        height: box_px.height + 1.0,
        ..box_px
    }
}

/// Labels as Scalabel evaluates them: boxes one pixel wider and higher, their area, and what is
/// ignored taken for a crowd.
#[must_use]
pub(crate) fn bdd_labels(labels: &LabelSet) -> LabelSet {
    let mut labels = labels.clone();
    for object in &mut labels.objects {
        object.box_px = inclusive(object.box_px);
        object.area_px2 = object.box_px.area_px2();
        if object.kind == ObjectKind::Ignored {
            object.kind = ObjectKind::Crowd;
        }
    }
    labels
}

/// Detections as Scalabel evaluates them: boxes one pixel wider and higher.
#[must_use]
pub(crate) fn bdd_detections(detections: &Detections) -> Detections {
    let mut detections = detections.clone();
    for detection in &mut detections.items {
        detection.box_px = inclusive(detection.box_px);
    }
    detections
}
