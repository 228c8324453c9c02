//! Whether the detections of a clip can be what they are said to be.

use std::path::Path;

use super::Warning;
use crate::json_record::refuse_file;
use crate::timeline::Frame;
use crate::{Detections, EvalError, Unused};

/// The detections of one side of a clip, and what was read with them.
#[derive(Debug, Clone, Copy)]
pub struct ClipSide<'a> {
    /// `clean` or `damaged`.
    pub name: &'a str,
    /// The file or folder that they are from.
    pub path: &'a Path,
    /// Those in the clip, by its labeled frames.
    pub detections: &'a Detections,
    /// All that were read, of categories that there are.
    pub n_read: usize,
    /// Those of other categories.
    pub unused: Option<&'a Unused>,
    /// Whether they name the images of all labels, not the frames of this clip.
    pub is_of_all_images: bool,
}

/// Refuses detections that are not of a clip, and tells of those that may be of a part of it.
///
/// `frames` are the labeled frames. A side that begins or ends more than `stretch_frames` frames of
/// the video inside of the other one may be of a detector that was stopped; objects would count as
/// lost that it never looked for. Detections of any score count here.
///
/// # Errors
/// [`EvalError::File`] where all detections are of unknown categories, or none is in the clip while
/// others are in other images.
pub fn check_sides(
    clip: &str,
    frames: &[Frame],
    sides: &[ClipSide<'_>; 2],
    stretch_frames: u32,
) -> Result<Vec<Warning>, EvalError> {
    let mut warnings = Vec::new();
    for side in sides {
        warnings.extend(categories(side)?);
        if side.detections.items.is_empty() && side.is_of_all_images && side.n_read > 0 {
            let reason = format!(
                "none of its {} detections is in clip {clip:?}, all are in other images of the labels; if they number \
                 the frames of this clip from 1, add --by-frame; otherwise give the detections of this clip",
                side.n_read
            );
            return Err(refuse_file(side.path, reason));
        }
    }
    let spans = [&sides[0], &sides[1]].map(|side| span(side.detections, frames));
    for (side, span) in sides.iter().zip(spans) {
        if span.is_none() {
            warnings.push(Warning::NoDetections {
                clip: clip.to_owned(),
                side: side.name.to_owned(),
                n_frames: frames.len().into(),
            });
        }
    }
    let [Some(a), Some(b)] = spans else {
        return Ok(warnings);
    };
    let stretch = u64::from(stretch_frames);
    let last = frames.last().map_or(0, |frame| frame.frame_idx);
    for (side, [own, other]) in sides.iter().zip([[a, b], [b, a]]) {
        let other_name = sides.iter().find(|it| it.name != side.name);
        let other_name = other_name.map_or("other", |it| it.name);
        if other[1] > own[1].saturating_add(stretch) {
            warnings.push(Warning::DetectionsEndEarly {
                clip: clip.to_owned(),
                side: side.name.to_owned(),
                end: own[1].into(),
                other: other_name.to_owned(),
                other_end: other[1].into(),
                last: last.into(),
            });
        }
        if own[0] > other[0].saturating_add(stretch) {
            warnings.push(Warning::DetectionsBeginLate {
                clip: clip.to_owned(),
                side: side.name.to_owned(),
                begin: own[0].into(),
                other: other_name.to_owned(),
                other_begin: other[0].into(),
            });
        }
    }
    Ok(warnings)
}

/// Tells of labels that end before their clip does: `frames` are the labeled ones, `n_frames` all.
///
/// Labels may leave out frames, also the last ones: those of every tenth frame end up to nine before the
/// end. Where there is room behind the last one for one more, in steps as large as the largest between
/// them, the track may be that of a longer clip.
#[must_use]
pub fn check_end(clip: &str, frames: &[Frame], n_frames: u64) -> Option<Warning> {
    let last = frames.last()?.frame_idx;
    let steps = frames
        .windows(2)
        .map(|pair| pair[1].frame_idx.saturating_sub(pair[0].frame_idx));
    let step = steps.max().unwrap_or(1);
    (last.saturating_add(step) < n_frames).then(|| Warning::LabelsEndEarly {
        clip: clip.to_owned(),
        last: last.into(),
        n_frames: n_frames.into(),
    })
}

fn categories(side: &ClipSide<'_>) -> Result<Option<Warning>, EvalError> {
    let Some(unused) = side.unused else {
        return Ok(None);
    };
    if side.n_read == 0 {
        let reason = format!(
            "all {} detections on the {} side have categories that the labels lack (first: {:?}); use the names \
             or ids of the labels' categories",
            unused.n_detections, side.name, unused.first
        );
        return Err(refuse_file(side.path, reason));
    }
    Ok(Some(Warning::UnknownCategories {
        side: side.name.to_owned(),
        n: unused.n_detections.into(),
        n_all: (unused.n_detections + side.n_read).into(),
        first: unused.first.clone(),
    }))
}

/// Numbers of the first and the last frame with a detection.
fn span(detections: &Detections, frames: &[Frame]) -> Option<[u64; 2]> {
    let places = || detections.items.iter().map(|it| it.image);
    let number = |place: u32| frames.get(place as usize).map(|frame| frame.frame_idx);
    Some([number(places().min()?)?, number(places().max()?)?])
}

#[cfg(test)]
mod tests {
    use super::{Frame, check_end};

    #[test]
    fn labels_that_end_early_are_told_of_unless_they_are_sparse() {
        let ends = |idx: &[u64], n_frames| {
            let frames: Vec<Frame> = idx
                .iter()
                .map(|frame_idx| Frame {
                    frame_idx: *frame_idx,
                    time_s: 0.0,
                    state: None,
                })
                .collect();
            check_end("a", &frames, n_frames).map(|warning| warning.to_string())
        };
        let all: Vec<u64> = (0..30).collect();
        assert_eq!(ends(&all, 30), None, "all frames");
        let said = ends(&all, 31).unwrap_or_default();
        for word in ["clip a", "frame 29", "31 frames"] {
            assert!(said.contains(word), "{word}: {said}");
        }
        let tenth = [0, 10, 20];
        assert_eq!(ends(&tenth, 30), None, "the next would be 30");
        assert!(ends(&tenth, 31).is_some(), "there is a frame 30");
        assert_eq!(ends(&[], 30), None, "no labels");
    }
}
