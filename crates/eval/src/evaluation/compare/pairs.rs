//! Whether clean and cracked detections are a pair.

use crate::evaluation::{Warning, WarningKind};
use crate::protocol::exact;
use crate::{EvalError, GroundTruth, KittiDetections, LabelSet, Object, SaidDetections};

/// Objects that no range of areas holds.
fn areas_below_0(labels: &LabelSet) -> Option<Warning> {
    let is_below = |object: &&Object| object.area_px2 < 0.0;
    let mut objects = labels.objects.iter().filter(is_below);
    let first = objects.next()?;
    Some(Warning {
        kind: WarningKind::Protocol,
        text: format!(
            "{} objects have an area below 0 in the labels, the first is object {} with {} px²; as by the rules of \
             MS-COCO they are in no range of areas and count nowhere; mend `area` if they are to count",
            count_of(1 + objects.count()),
            first.id,
            first.area_px2
        ),
    })
}

/// Clean and cracked are of the same frames, and what a reader must know of both.
///
/// # Errors
/// [`EvalError::Rule`] where they are not.
pub(super) fn check_pair(
    truth: &GroundTruth,
    clean: &SaidDetections,
    cracked: Option<&SaidDetections>,
) -> Result<Vec<Warning>, EvalError> {
    let mut warnings = Vec::new();
    let frames = |said: &SaidDetections| {
        said.kitti
            .as_ref()
            .map(|k: &KittiDetections| k.images.clone())
    };
    if let Some(cracked) = cracked
        && frames(clean) != frames(cracked)
    {
        return Err(EvalError::Rule(
            "clean and cracked results are not of the same frames; a pair has a result file for each frame on both sides, empty where nothing was found".to_owned(),
        ));
    }
    let n_frames = frames(clean).map_or(truth.labels.images.len(), |images| images.len());
    if n_frames < truth.labels.images.len() {
        warnings.push(Warning {
            kind: WarningKind::Protocol,
            text: format!(
                "{n_frames} of {} labeled frames have a result file; as in KITTI's own program the others are not evaluated",
                truth.labels.images.len()
            ),
        });
    }
    warnings.extend(areas_below_0(&truth.labels));
    for (side, said) in [("clean", Some(clean)), ("cracked", cracked)] {
        let Some(unused) = said.and_then(|said| said.unused.as_ref()) else {
            continue;
        };
        let n_known = said.map_or(0, |said| said.detections.items.len());
        if n_known == 0 {
            return Err(EvalError::Rule(format!(
                "all {} {side} detections are of categories that the labels lack, the first of {:?}; give \
                 the numbers of the labels' categories",
                unused.n_detections, unused.first
            )));
        }
        let n_all = count_of(unused.n_detections + said.map_or(0, |s| s.detections.items.len()));
        let share = exact(count_of(unused.n_detections)) / exact(n_all.max(1)) * 100.0;
        warnings.push(Warning {
            kind: WarningKind::LabelMap,
            text: format!(
                "{} {side} detections ({share:.0} %) are of categories that the labels lack, the first of {:?}; they count for nothing",
                unused.n_detections, unused.first
            ),
        });
    }
    if let Some(cracked) = cracked {
        warnings.extend(one_sided(truth, clean, cracked));
    }
    Ok(warnings)
}

/// Images with detections on one side only, where they are so many that a results file may be of
/// other images than it should.
fn one_sided(
    truth: &GroundTruth,
    clean: &SaidDetections,
    cracked: &SaidDetections,
) -> Option<Warning> {
    let n_images = truth.labels.images.len();
    let seen = |said: &SaidDetections| {
        let mut seen = vec![false; n_images];
        for detection in &said.detections.items {
            if let Some(image) = seen.get_mut(detection.image as usize) {
                *image = true;
            }
        }
        seen
    };
    let (clean, cracked) = (seen(clean), seen(cracked));
    let count = |only: bool| {
        let pairs = clean.iter().zip(&cracked);
        pairs
            .filter(|&(clean, cracked)| *clean == only && *cracked != only)
            .count()
    };
    let (n_clean, n_cracked) = (count(true), count(false));
    ((n_clean + n_cracked) * 5 > n_images).then(|| Warning {
        kind: WarningKind::Missing,
        text: format!(
            "{n_clean} of {n_images} images have clean detections only and {n_cracked} cracked ones only; \
             if a results file is not of all images, every difference is wrong: detect in all of them"
        ),
    })
}

fn count_of(n: usize) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}
