//! Whether clean and cracked detections are a pair.

use crate::evaluation::Warning;
use crate::{EvalError, GroundTruth, KittiDetections, LabelSet, Object, SaidDetections};

/// Objects that no range of areas holds.
fn areas_below_0(labels: &LabelSet) -> Option<Warning> {
    let is_below = |object: &&Object| object.area_px2 < 0.0;
    let mut objects = labels.objects.iter().filter(is_below);
    let first = objects.next()?;
    Some(Warning::AreasBelowZero {
        n: (1 + objects.count()).into(),
        first_id: first.id,
        first_area_px2: first.area_px2,
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
            "clean and damaged results cover different frames; give a result file for each frame on both sides, empty where nothing was detected".to_owned(),
        ));
    }
    let n_frames = frames(clean).map_or(truth.labels.images.len(), |images| images.len());
    if n_frames < truth.labels.images.len() {
        warnings.push(Warning::FramesWithoutResults {
            n_frames: n_frames.into(),
            n_labeled: truth.labels.images.len().into(),
        });
    }
    warnings.extend(areas_below_0(&truth.labels));
    for (side, said) in [("clean", Some(clean)), ("damaged", cracked)] {
        let Some(unused) = said.and_then(|said| said.unused.as_ref()) else {
            continue;
        };
        let n_known = said.map_or(0, |said| said.detections.items.len());
        if n_known == 0 {
            return Err(EvalError::Rule(format!(
                "all {} detections on the {side} side have categories that the labels lack (first: {:?}); \
                 use the ids of the labels' categories",
                unused.n_detections, unused.first
            )));
        }
        warnings.push(Warning::UnknownCategories {
            side: side.to_owned(),
            n: unused.n_detections.into(),
            n_all: (unused.n_detections + n_known).into(),
            first: unused.first.clone(),
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
    ((n_clean + n_cracked) * 5 > n_images).then(|| Warning::OneSided {
        n_clean: n_clean.into(),
        n_cracked: n_cracked.into(),
        n_images: n_images.into(),
    })
}
