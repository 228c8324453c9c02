//! Detection over the frames of a video: what is found when, how it flickers, and how long after
//! the damage an object is lost.
//!
//! Objects are followed by [`Track`]s: of labels that say which object is which
//! ([`tracks_of`]), or, without labels, of the detections of the clean video
//! ([`track_detections`]). What the glass does comes in as plain values: the times of the frames and
//! the frame of the damage's onset, as the track file of the verb `video` has them.

mod clip_track;
mod follow;
mod sightings;
mod steadiness;
mod survival;

use serde::{Deserialize, Serialize};

use crate::EvalError;
pub(crate) use clip_track::MOST_FRAMES;
pub use clip_track::{ClipTrack, TrackedFrame};
pub use follow::{FollowSettings, Followed, track_detections};
pub use sightings::{Sighting, Track, TrackFate, TrackRow, tracks_of};
use steadiness::steadiness;
pub use steadiness::{Change, Steadiness, change_after};
pub use survival::{Survival, SurvivalStep, kaplan_meier, kaplan_meier_of_clusters};

/// A frame of the video.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Its number in the video, from 0.
    pub frame_idx: u64,
    /// When it begins, s.
    pub time_s: f64,
    /// What the glass does in it, where that is known.
    pub state: Option<GlassState>,
}

/// What the glass does in a frame, in the words of the track file of `video`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GlassState {
    /// No damage yet.
    Intact,
    /// The cracks run.
    Growing,
    /// The cracks stand still.
    Still,
}

/// What a timeline goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimelineSettings {
    /// An object is lost when it is not found in this many frames in a row. **Default** 5.
    pub lost_for_frames: u32,
    /// Level of confidence of intervals. **Default** 0.95.
    pub level: f64,
    /// Draws of the bootstrap over tracks. **Default** 1000.
    pub n_replicates: u32,
    /// Seed of it. **Default** 0.
    pub seed: u64,
}

impl Default for TimelineSettings {
    fn default() -> Self {
        Self {
            lost_for_frames: 5,
            level: 0.95,
            n_replicates: 1000,
            seed: 0,
        }
    }
}

/// Detection over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// What it goes by.
    pub settings: TimelineSettings,
    /// The first frame with damage.
    pub damage_onset: Option<Frame>,
    /// Per frame.
    pub frames: Vec<FrameRow>,
    /// Per track.
    pub tracks: Vec<TrackRow>,
    /// Before the onset; all frames where there is none.
    pub before: Steadiness,
    /// From the onset on.
    pub after: Steadiness,
    /// How long objects that were found at the onset stay found; `None` without an onset.
    pub survival: Option<Survival>,
}

/// What is found in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// Its number.
    pub frame_idx: u64,
    /// When it begins, s.
    pub time_s: f64,
    /// What the glass does in it, where that is known.
    pub state: Option<GlassState>,
    /// Tracked objects that are in it.
    pub n_objects: u64,
    /// Those found.
    pub n_found: u64,
    /// Mean score of those found.
    pub mean_score: Option<f64>,
}

/// What becomes of tracked objects over the frames.
///
/// `onset` is the place in `frames` of the first frame with damage. An object can be lost if it was
/// found shortly before: in one of its last `lost_for_frames` frames before the onset or, where
/// `reference` gives the tracks of the same objects in the clean video, in one of its first so many
/// frames of that from the onset on. It is lost at the first frame from the onset on from which it
/// is not found in `lost_for_frames` of its frames in a row; its time is that frame's minus the
/// onset's, s. One that is never lost leaves the sample with its last frame or, where it ends in
/// too short a gap to tell, with the first frame of that gap. A clean video with the same onset
/// gives the curve of what is lost without damage.
///
/// # Errors
/// If times do not rise, the onset or a sighting is of a frame that is not there, the frames of a
/// track do not rise, two tracks have one number, or a setting makes no sense.
pub fn timeline(
    frames: &[Frame],
    onset: Option<u32>,
    tracks: &[Track],
    reference: Option<&[Track]>,
    settings: TimelineSettings,
) -> Result<Timeline, EvalError> {
    check(frames, onset, tracks, settings)?;
    check(frames, onset, reference.unwrap_or_default(), settings)?;
    let of_reference = |track: &Track| {
        let same = |it: &&Track| it.track == track.track;
        reference.map(|all| all.iter().find(same))
    };
    let rows: Vec<TrackRow> = tracks
        .iter()
        .map(|track| sightings::row(track, frames, onset, of_reference(track), settings))
        .collect();
    let survival = match onset {
        Some(_) => Some(survival_of(&rows, settings.level)?),
        None => None,
    };
    let is_before = |frame: u32| onset.is_none_or(|onset| frame < onset);
    Ok(Timeline {
        settings,
        damage_onset: onset.and_then(|onset| frames.get(onset as usize)).copied(),
        frames: frame_rows(frames, tracks),
        before: steadiness(tracks, is_before, settings)?,
        after: steadiness(tracks, |frame| !is_before(frame), settings)?,
        tracks: rows,
        survival,
    })
}

fn check(
    frames: &[Frame],
    onset: Option<u32>,
    tracks: &[Track],
    settings: TimelineSettings,
) -> Result<(), EvalError> {
    let mut before = f64::NEG_INFINITY;
    for frame in frames {
        if !(frame.time_s > before && frame.time_s.is_finite()) {
            return Err(EvalError::StatisticSetting {
                what: "time of a frame in s",
                value: frame.time_s,
                range: "after the one before",
            });
        }
        before = frame.time_s;
    }
    if settings.lost_for_frames == 0 {
        return Err(EvalError::StatisticSetting {
            what: "number of frames after which an object is lost",
            value: 0.0,
            range: "1 or more",
        });
    }
    let sighted = tracks.iter().flat_map(|track| &track.sightings);
    for frame in sighted.map(|it| it.frame).chain(onset) {
        if frame as usize >= frames.len() {
            return Err(EvalError::StatisticLength {
                what: "frame of an onset or a sighting",
                found: frame as usize,
                expected: frames.len(),
                of: "are in the video",
            });
        }
    }
    let mut numbers: Vec<u64> = tracks.iter().map(|it| it.track).collect();
    numbers.sort_unstable();
    let twice = numbers.windows(2).find(|pair| pair[0] == pair[1]);
    let unsorted = tracks.iter().find(|track| {
        let mut pairs = track.sightings.windows(2);
        pairs.any(|pair| pair[1].frame <= pair[0].frame)
    });
    let wrong = twice.map(|pair| pair[0]).or(unsorted.map(|it| it.track));
    match wrong {
        Some(track) => Err(EvalError::Track { track }),
        None => Ok(()),
    }
}

fn survival_of(rows: &[TrackRow], level: f64) -> Result<Survival, EvalError> {
    let (mut times, mut is_lost) = (Vec::new(), Vec::new());
    for row in rows {
        match row.fate {
            TrackFate::Lost { after_s, .. } => {
                times.push(after_s);
                is_lost.push(true);
            }
            TrackFate::Kept { for_s } => {
                times.push(for_s);
                is_lost.push(false);
            }
            TrackFate::NotAtRisk { .. } => {}
        }
    }
    kaplan_meier(&times, &is_lost, level)
}

fn frame_rows(frames: &[Frame], tracks: &[Track]) -> Vec<FrameRow> {
    let mut rows: Vec<(FrameRow, f64)> = frames
        .iter()
        .map(|frame| {
            let row = FrameRow {
                frame_idx: frame.frame_idx,
                time_s: frame.time_s,
                state: frame.state,
                n_objects: 0,
                n_found: 0,
                mean_score: None,
            };
            (row, 0.0)
        })
        .collect();
    for sighting in tracks.iter().flat_map(|track| &track.sightings) {
        if let Some((row, sum)) = rows.get_mut(sighting.frame as usize) {
            row.n_objects += 1;
            if let Some(score) = sighting.score {
                row.n_found += 1;
                *sum += score;
            }
        }
    }
    rows.into_iter()
        .map(|(row, sum)| FrameRow {
            mean_score: (row.n_found > 0).then(|| sum / row.n_found as f64),
            ..row
        })
        .collect()
}
