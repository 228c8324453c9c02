//! Detection over the frames of a clip, clean and cracked.

use serde::{Deserialize, Serialize};

use super::{PooledClips, Warning};
use crate::timeline::{
    Change, FollowSettings, Frame, Timeline, TimelineSettings, change_after, timeline,
    track_detections, tracks_of,
};
use crate::{
    Category, ClipLabels, Detections, EvalError, LabelSet, LabeledImage, MatchRule, TrackName,
    match_images,
};

/// What is found in each frame of a clip, clean and cracked, and what becomes of each object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimelineResults {
    /// Name of the clip.
    pub clip: String,
    /// Frames per second, where known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_per_s: Option<f64>,
    /// Frames of the clip; those of the timelines are the labeled ones.
    pub n_frames: u64,
    /// What says which objects there are.
    pub truth: TrackSource,
    /// Detections of a lower score find nothing.
    pub score_threshold: f64,
    /// Least overlap of a detection with the object that it finds.
    pub iou_threshold: f64,
    /// The objects by the numbers of their tracks.
    pub objects: Vec<TrackName>,
    /// The clean clip, with the cracked one's onset: what is lost without damage.
    pub clean: Timeline,
    /// The cracked clip.
    pub cracked: Timeline,
    /// Cracked minus clean from the onset on; absent without an onset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
}

/// What says which objects there are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum TrackSource {
    /// Labels that follow them.
    Labels,
    /// The detections of the clean clip, followed from frame to frame: the "truth" is the detector.
    CleanDetections {
        /// How they are followed.
        follow: FollowSettings,
    },
}

/// How a clip is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipSettings {
    /// Score from which a detection counts. **Default** 0.3.
    pub score_threshold: f64,
    /// Overlap with the object that it finds. **Default** 0.5.
    pub iou_threshold: f64,
    /// When an object is lost, and how intervals are drawn.
    pub timeline: TimelineSettings,
}

impl Default for ClipSettings {
    fn default() -> Self {
        Self {
            score_threshold: 0.3,
            iou_threshold: 0.5,
            timeline: TimelineSettings::default(),
        }
    }
}

/// A clip.
#[derive(Debug, Clone, Copy)]
pub struct ClipInput<'a> {
    /// Its name.
    pub name: &'a str,
    /// Frames per second, where known.
    pub frames_per_s: Option<f64>,
    /// All of its frames.
    pub frames: &'a [Frame],
    /// Number of the first frame with damage.
    pub onset_idx: Option<u64>,
    /// Detections of the clean clip, by the frames of the labels, else by all frames.
    pub clean: &'a Detections,
    /// Detections of the cracked clip, likewise.
    pub cracked: &'a Detections,
}

impl ClipSettings {
    /// What becomes of labeled objects.
    ///
    /// Detections find objects by the rule of MS-COCO at one IoU, class by class, best scores
    /// first. The onset is the first labeled frame with damage. Both clips go by the same onset and
    /// by the same objects at risk: those found in the clean clip just after it.
    ///
    /// # Errors
    /// [`EvalError::Rule`] for settings that make no sense, and those of [`timeline`].
    pub fn of_labels(
        &self,
        clip: &ClipInput<'_>,
        labels: &ClipLabels,
    ) -> Result<TimelineResults, EvalError> {
        let followed = Followed {
            labels: &labels.labels,
            frames: &labels.frames,
            tracks: &labels.tracks,
        };
        self.results(clip, &followed, &labels.names, TrackSource::Labels)
    }

    /// The same without labels: the objects are the detections of the clean clip, followed by
    /// [`track_detections`]. By their making the clean clip finds all of them in all frames in which
    /// they are there, so that it says nothing about the detector.
    ///
    /// # Errors
    /// As [`of_labels`](Self::of_labels), and those of [`track_detections`].
    pub fn of_clean_detections(
        &self,
        clip: &ClipInput<'_>,
        categories: &[Category],
        follow: FollowSettings,
    ) -> Result<TimelineResults, EvalError> {
        let n_frames = u32::try_from(clip.frames.len()).unwrap_or(u32::MAX);
        let found = track_detections(clip.clean, n_frames, follow)?;
        let image = |frame: &Frame| LabeledImage {
            id: i64::try_from(frame.frame_idx + 1).unwrap_or(i64::MAX),
            name: frame.frame_idx.to_string(),
            width_px: None,
            height_px: None,
            cluster: None,
        };
        let labels = LabelSet {
            images: clip.frames.iter().map(image).collect(),
            categories: categories.to_vec(),
            objects: found.objects,
        };
        let mut names: Vec<TrackName> = Vec::new();
        for (object, track) in labels.objects.iter().zip(&found.tracks) {
            let Some(track) = *track else { continue };
            if names.iter().all(|known| known.track != track) {
                let category = labels.categories.get(object.category as usize);
                names.push(TrackName {
                    track,
                    name: track.to_string(),
                    class: category.map_or_else(String::new, |it| it.name.clone()),
                });
            }
        }
        names.sort_by_key(|name| name.track);
        let followed = Followed {
            labels: &labels,
            frames: clip.frames,
            tracks: &found.tracks,
        };
        self.results(
            clip,
            &followed,
            &names,
            TrackSource::CleanDetections { follow },
        )
    }

    fn results(
        &self,
        clip: &ClipInput<'_>,
        followed: &Followed<'_>,
        names: &[TrackName],
        truth: TrackSource,
    ) -> Result<TimelineResults, EvalError> {
        self.check()?;
        let frames = followed.frames;
        let onset = match clip.onset_idx {
            None => None,
            Some(onset_idx) => {
                let place = frames.partition_point(|frame| frame.frame_idx < onset_idx);
                if place == frames.len() {
                    return Err(EvalError::Rule(format!(
                        "no labeled frame of clip {:?} is at or after the onset of damage (frame {onset_idx}); nothing can be lost",
                        clip.name
                    )));
                }
                u32::try_from(place).ok()
            }
        };
        let rule = MatchRule {
            iou_threshold: self.iou_threshold,
            ..MatchRule::default()
        };
        let tracks = |detections: &Detections| {
            let matches = match_images(followed.labels, detections, &rule)?;
            tracks_of(
                &matches,
                followed.labels,
                followed.tracks,
                self.score_threshold,
            )
        };
        let (clean, cracked) = (tracks(clip.clean)?, tracks(clip.cracked)?);
        let of = |tracks| timeline(frames, onset, tracks, Some(&clean), self.timeline);
        Ok(TimelineResults {
            clip: clip.name.to_owned(),
            frames_per_s: clip.frames_per_s,
            n_frames: clip.frames.len() as u64,
            truth,
            score_threshold: self.score_threshold,
            iou_threshold: self.iou_threshold,
            objects: names.to_vec(),
            change: change_after(onset, &clean, &cracked, self.timeline)?,
            cracked: of(&cracked)?,
            clean: of(&clean)?,
        })
    }

    fn check(&self) -> Result<(), EvalError> {
        for (what, value) in [
            ("score threshold of a detection", self.score_threshold),
            ("IoU threshold of a found object", self.iou_threshold),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(EvalError::StatisticSetting {
                    what,
                    value,
                    range: "from 0 to 1",
                });
            }
        }
        Ok(())
    }
}

/// Fewer objects at risk than this make a curve of steps.
pub(super) const FEW_AT_RISK: u64 = 20;

impl TimelineResults {
    /// What a reader must know before the numbers; that there are few objects at risk is no matter of one
    /// clip where `pooled`, all of them together, have enough.
    #[must_use]
    pub fn warnings(&self, pooled: Option<&PooledClips>) -> Vec<Warning> {
        let is_enough = pooled.is_some_and(PooledClips::is_enough);
        let mut warnings = Vec::new();
        let clip = || self.clip.clone();
        if matches!(self.truth, TrackSource::CleanDetections { .. }) {
            warnings.push(Warning::NoLabels { clip: clip() });
        }
        match &self.cracked.survival {
            None => warnings.push(Warning::NoDamage { clip: clip() }),
            Some(survival) if survival.n < FEW_AT_RISK && !is_enough => {
                warnings.push(Warning::FewAtRisk {
                    clip: clip(),
                    n: survival.n.into(),
                });
            }
            Some(_) => {}
        }
        warnings
    }
}

/// Objects with their tracks, over frames.
struct Followed<'a> {
    labels: &'a LabelSet,
    frames: &'a [Frame],
    tracks: &'a [Option<u64>],
}
