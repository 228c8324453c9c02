//! Tracks, and what becomes of each.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Frame, TimelineSettings};
use crate::EvalError;
use crate::labels::LabelSet;
use crate::matching::{ImageMatches, Outcome};

/// An object through the frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Its number; each track has its own.
    pub track: u64,
    /// Place of its category in [`LabelSet::categories`].
    pub category: u32,
    /// The frames in which it is there to be found, by rising frame.
    pub sightings: Vec<Sighting>,
}

/// An object in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// Place of the frame, which is the place of the image in [`LabelSet::images`].
    pub frame: u32,
    /// Score of the detection that found it; `None` where it is missed.
    pub score: Option<f64>,
}

impl Sighting {
    /// Whether it is found.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.score.is_some()
    }
}

/// What becomes of a track.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackRow {
    /// Its number.
    pub track: u64,
    /// Place of its category in [`LabelSet::categories`].
    pub category: u32,
    /// Number of its first frame.
    pub first_frame_idx: Option<u64>,
    /// Number of its last frame.
    pub last_frame_idx: Option<u64>,
    /// Frames in which it is there.
    pub n_frames: u64,
    /// Those in which it is found.
    pub n_found: u64,
    /// How often found turns to missed or back.
    pub n_changes: u64,
    /// Lengths of the gaps between frames in which it is found, in frames of the track.
    pub gaps_frames: Vec<u32>,
    /// What becomes of it after the onset of the damage.
    pub fate: TrackFate,
}

/// What becomes of a track after the onset of the damage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum TrackFate {
    /// It is lost.
    Lost {
        /// Number of the first frame of the gap.
        frame_idx: u64,
        /// Time from the onset to it, s.
        after_s: f64,
    },
    /// It is not lost as long as it can be told.
    Kept {
        /// Time from the onset on for which that is known, s.
        for_s: f64,
    },
    /// It has no say in how long objects stay found.
    NotAtRisk {
        /// Why.
        reason: String,
    },
}

/// Tracks from matches of frames: the objects that count and have a track number, found by
/// detections of at least `score_threshold`. By number.
///
/// # Errors
/// If `track_of_object` has not one entry per object, or one track is twice in a frame or of two
/// categories.
pub fn tracks_of(
    matches: &[ImageMatches],
    labels: &LabelSet,
    track_of_object: &[Option<u64>],
    score_threshold: f64,
) -> Result<Vec<Track>, EvalError> {
    if track_of_object.len() != labels.objects.len() {
        return Err(EvalError::StatisticLength {
            what: "track numbers",
            found: track_of_object.len(),
            expected: labels.objects.len(),
            of: "objects",
        });
    }
    let mut tracks = BTreeMap::<u64, (u32, BTreeMap<u32, Option<f64>>)>::new();
    for item in matches {
        let mut scores = BTreeMap::new();
        for detection in &item.detections {
            if let Outcome::TruePositive { object, .. } = detection.outcome
                && detection.score >= score_threshold
            {
                scores.insert(object, detection.score);
            }
        }
        for object in item.objects.iter().filter(|it| !it.is_ignored) {
            let Some(Some(track)) = track_of_object.get(object.object as usize) else {
                continue;
            };
            let entry = tracks.entry(*track);
            let (category, frames) = entry.or_insert_with(|| (item.category, BTreeMap::new()));
            let score = scores.get(&object.object).copied();
            if *category != item.category || frames.insert(item.image, score).is_some() {
                return Err(EvalError::Track { track: *track });
            }
        }
    }
    let track = |(track, (category, frames)): (u64, (u32, BTreeMap<u32, Option<f64>>))| Track {
        track,
        category,
        sightings: frames
            .into_iter()
            .map(|(frame, score)| Sighting { frame, score })
            .collect(),
    };
    Ok(tracks.into_iter().map(track).collect())
}

/// What becomes of a track; `reference` is the same object in the clean video, where there is one.
pub(super) fn row(
    track: &Track,
    frames: &[Frame],
    onset: Option<u32>,
    reference: Option<Option<&Track>>,
    settings: TimelineSettings,
) -> TrackRow {
    let seen = &track.sightings;
    let idx = |it: &Sighting| frames.get(it.frame as usize).map(|it| it.frame_idx);
    let runs: Vec<&[Sighting]> = seen.chunk_by(|a, b| a.is_found() == b.is_found()).collect();
    let gaps = runs
        .iter()
        .enumerate()
        .filter(|(place, run)| *place > 0 && place + 1 < runs.len() && !run[0].is_found());
    TrackRow {
        track: track.track,
        category: track.category,
        first_frame_idx: seen.first().and_then(idx),
        last_frame_idx: seen.last().and_then(idx),
        n_frames: seen.len() as u64,
        n_found: seen.iter().filter(|it| it.is_found()).count() as u64,
        n_changes: runs.len().saturating_sub(1) as u64,
        gaps_frames: gaps
            .map(|(_, run)| u32::try_from(run.len()).unwrap_or(u32::MAX))
            .collect(),
        fate: fate(seen, frames, onset, reference, settings),
    }
}

fn fate(
    seen: &[Sighting],
    frames: &[Frame],
    onset: Option<u32>,
    reference: Option<Option<&Track>>,
    settings: TimelineSettings,
) -> TrackFate {
    let not_at_risk = |reason: &str| TrackFate::NotAtRisk {
        reason: reason.to_owned(),
    };
    let Some((onset, start)) = onset.and_then(|it| Some((it, frames.get(it as usize)?))) else {
        return not_at_risk("there is no damage");
    };
    let n = settings.lost_for_frames as usize;
    let (before, after) = seen.split_at(seen.partition_point(|it| it.frame < onset));
    if after.is_empty() {
        return not_at_risk("it ends before the onset of damage");
    }
    let was_found = match reference {
        None if before.is_empty() => return not_at_risk("it begins after the onset of damage"),
        None => before.iter().rev().take(n).any(Sighting::is_found),
        Some(None) => return not_at_risk("it is not in the clean video"),
        Some(Some(clean)) => {
            let clean = clean.sightings.iter().filter(|it| it.frame >= onset);
            clean.take(n).any(Sighting::is_found)
        }
    };
    if !was_found {
        return not_at_risk("it is not found without damage either");
    }
    let since = |it: &Sighting| {
        let frame = frames.get(it.frame as usize);
        frame.map_or((0, 0.0), |it| (it.frame_idx, it.time_s - start.time_s))
    };
    for run in after.chunk_by(|a, b| a.is_found() == b.is_found()) {
        if run.len() >= n && !run[0].is_found() {
            let (frame_idx, after_s) = since(&run[0]);
            return TrackFate::Lost { frame_idx, after_s };
        }
    }
    // A gap at the end that is too short to tell is not known to be none.
    let n_open = after.iter().rev().take_while(|it| !it.is_found()).count();
    let last = after.get(after.len() - n_open).or(after.last());
    TrackFate::Kept {
        for_s: last.map_or(0.0, |it| since(it).1),
    }
}
