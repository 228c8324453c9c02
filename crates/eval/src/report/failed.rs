//! The single objects that are lost or recovered, one line each.

use crate::EvalError;
use crate::evaluation::Study;

/// Every object that only one of both images shows to the detector, as JSON lines: detector, condition,
/// image, number and class of the label, box, `lost` or `recovered`, coverage, and by which score it is
/// found.
///
/// # Errors
/// [`EvalError::Report`] if serde gives up, which no such value makes it do.
pub fn failures_jsonl(study: &Study) -> Result<String, EvalError> {
    let mut text = String::new();
    for evaluation in &study.evaluations {
        for object in &evaluation.changed_objects {
            let line = serde_json::json!({
                "detector": evaluation.detector,
                "condition": evaluation.condition.name,
                "image": object.image,
                "object_id": object.object_id,
                "class": object.class,
                "box_px": object.box_px.corners(),
                "change": object.change,
                "coverage": object.coverage,
                "score": object.score,
                "iou": object.iou,
            });
            let line = serde_json::to_string(&line).map_err(|cause| EvalError::Report {
                reason: cause.to_string(),
            })?;
            text.push_str(&line);
            text.push('\n');
        }
    }
    Ok(text)
}
