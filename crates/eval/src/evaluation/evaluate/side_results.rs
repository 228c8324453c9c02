//! Kinds of errors, and whether the classes are the right ones.

use crate::evaluation::{Estimate, LabelAudit, LabelVerdict, ShiftedLabel, TideErrors};
use crate::label_audit::{AuditSettings, Verdict, confusion, label_audit};
use crate::statistic::Measured;
use crate::tide::{ErrorKind, TideSettings, tide};
use crate::{Detections, EvalError, GroundTruth, LabelSet};

/// Disagreements that are listed.
const N_DISAGREEMENTS: usize = 20;

/// The kinds of errors; nothing of fewer than 20 objects.
pub(super) fn tide_errors(
    labels: &LabelSet,
    detections: &Detections,
    settings: TideSettings,
) -> Result<Option<TideErrors>, EvalError> {
    let n_objects = labels
        .objects
        .iter()
        .filter(|it| it.is_to_be_found())
        .count();
    if (n_objects as u64) < crate::MIN_OBJECTS {
        return Ok(None);
    }
    let found = tide(labels, detections, settings)?;
    let Some(ap) = found.ap else {
        return Ok(None);
    };
    let share = |percent: Option<f64>| percent.unwrap_or(0.0) / 100.0;
    let of = |kind: ErrorKind| {
        let cost = found.errors.iter().find(|error| error.kind == kind);
        share(cost.and_then(|cost| cost.d_ap))
    };
    Ok(Some(TideErrors {
        ap50: ap / 100.0,
        classification: of(ErrorKind::Cls),
        localization: of(ErrorKind::Loc),
        both: of(ErrorKind::Both),
        duplicate: of(ErrorKind::Dupe),
        background: of(ErrorKind::Bkg),
        missed: of(ErrorKind::Miss),
        false_positive: share(found.false_positive_d_ap),
        false_negative: share(found.false_negative_d_ap),
    }))
}

/// The audit, and what to warn of.
pub(super) fn audit(
    labels: &LabelSet,
    detections: &Detections,
) -> Result<(LabelAudit, Option<String>), EvalError> {
    let settings = AuditSettings::default();
    let found = label_audit(labels, detections, settings)?;
    let (verdict, advice) = match found.verdict {
        Verdict::Fits => (LabelVerdict::Fits, None),
        Verdict::Wrong { advice, .. } => (LabelVerdict::Wrong, Some(advice)),
        Verdict::Unexplained { advice } => (LabelVerdict::Unexplained, Some(advice)),
        Verdict::TooFew { needed } => (
            LabelVerdict::TooFew,
            Some(format!(
                "only {} objects overlap well with a detection; at least {needed} are needed to check the \
                 classes",
                found.n_pairs
            )),
        ),
    };
    let name = |place: u32| {
        let category = labels.categories.get(place as usize);
        category.map_or(String::new(), |category| category.name.clone())
    };
    let mut disagreements: Vec<ShiftedLabel> = confusion(labels, detections, settings)?
        .cells()
        .filter(|(detected, labeled, _)| detected != labeled)
        .map(|(detected, labeled, n)| ShiftedLabel {
            truth: name(labeled),
            detected: name(detected),
            n,
        })
        .collect();
    disagreements.sort_by(|a, b| (b.n, &a.truth, &a.detected).cmp(&(a.n, &b.truth, &b.detected)));
    disagreements.truncate(N_DISAGREEMENTS);
    let audit = LabelAudit {
        n_pairs: found.n_pairs,
        agreement: estimate(&found.agreement),
        verdict,
        advice: advice.clone(),
        disagreements,
    };
    let warning = advice.filter(|_| verdict != LabelVerdict::Fits);
    Ok((audit, warning))
}

/// The area of each image, px; nothing where the size of one is not known.
pub(super) fn image_areas_px(truth: &GroundTruth) -> Option<Vec<f64>> {
    let of_image = |image: &crate::LabeledImage| {
        let size = match (image.width_px, image.height_px, &truth.root) {
            (Some(width), Some(height), _) => Some((width, height)),
            (_, _, Some(root)) => starbreak_dataset::image_size(&root.join(&image.name)).ok(),
            _ => None,
        };
        size.map(|(width, height)| f64::from(width) * f64::from(height))
    };
    truth.labels.images.iter().map(of_image).collect()
}

/// A measured number as a reader gets it; without a number the reason is there.
pub(super) fn estimate(measured: &Measured) -> Estimate {
    Estimate::from(measured)
}
