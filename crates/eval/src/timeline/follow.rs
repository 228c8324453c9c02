//! Tracks from detections alone.

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::detections::{Detection, Detections};
use crate::labels::{Object, ObjectKind};

/// How detections are followed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FollowSettings {
    /// Score from which a detection is followed. **Default** 0.5.
    pub score_threshold: f64,
    /// Overlap with the place before from which it is the same object. **Default** 0.5.
    pub iou: f64,
    /// Frames for which an object may be missing. **Default** 2.
    pub max_gap_frames: u32,
    /// Frames in which an object must be there to be kept. **Default** 5.
    pub min_frames: u32,
}

impl Default for FollowSettings {
    fn default() -> Self {
        Self {
            score_threshold: 0.5,
            iou: 0.5,
            max_gap_frames: 2,
            min_frames: 5,
        }
    }
}

/// Objects made of detections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Followed {
    /// By frame, to be the objects of a label set with one image per frame.
    pub objects: Vec<Object>,
    /// Track of each object.
    pub tracks: Vec<Option<u64>>,
}

/// Takes the detections of the clean video as objects and follows them from frame to frame: what a
/// detector finds in the cracked video can then be held against what it finds in the clean one,
/// without labels.
///
/// Frame by frame the pairs of an open track and a detection of its class, by falling overlap with
/// the track's last place, go together; what is left opens a track. In a frame in which a track has
/// no detection there is no object.
///
/// # Errors
/// If a detection is of a frame beyond `n_frames`.
pub fn track_detections(
    detections: &Detections,
    n_frames: u32,
    settings: FollowSettings,
) -> Result<Followed, EvalError> {
    let mut by_frame: Vec<Vec<&Detection>> = vec![Vec::new(); n_frames as usize];
    for detection in &detections.items {
        let Some(list) = by_frame.get_mut(detection.image as usize) else {
            return Err(EvalError::StatisticLength {
                what: "frame of a detection",
                found: detection.image as usize,
                expected: n_frames as usize,
                of: "are in the video",
            });
        };
        if detection.score >= settings.score_threshold {
            list.push(detection);
        }
    }
    let mut tracks: Vec<Vec<&Detection>> = Vec::new();
    for (frame, list) in (0_u32..).zip(&by_frame) {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (place, track) in tracks.iter().enumerate() {
            let open = track
                .last()
                .filter(|last| frame - last.image <= settings.max_gap_frames + 1);
            let Some(last) = open else {
                continue;
            };
            for (item, detection) in list.iter().enumerate() {
                let iou = last.box_px.iou(&detection.box_px);
                if detection.category == last.category && iou >= settings.iou {
                    pairs.push((iou, place, item));
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut is_taken = vec![false; list.len()];
        let mut has_next = vec![false; tracks.len()];
        for (_, place, item) in pairs {
            if !is_taken[item] && !has_next[place] {
                (is_taken[item], has_next[place]) = (true, true);
                tracks[place].push(list[item]);
            }
        }
        for (detection, is_taken) in list.iter().zip(is_taken) {
            if !is_taken {
                tracks.push(vec![detection]);
            }
        }
    }
    tracks.retain(|track| track.len() >= settings.min_frames as usize);
    let mut all: Vec<(u64, &Detection)> = (1..)
        .zip(&tracks)
        .flat_map(|(number, track)| track.iter().map(move |it| (number, *it)))
        .collect();
    all.sort_by_key(|(number, detection)| (detection.image, *number));
    let object = |(id, (_, detection)): (i64, &(u64, &Detection))| Object {
        id,
        image: detection.image,
        category: detection.category,
        box_px: detection.box_px,
        area_px2: detection.box_px.area_px2(),
        kind: ObjectKind::Regular,
    };
    Ok(Followed {
        objects: (1..).zip(&all).map(object).collect(),
        tracks: all.iter().map(|(number, _)| Some(*number)).collect(),
    })
}
