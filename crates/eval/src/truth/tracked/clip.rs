//! One clip: its labels frame by frame, and what detections of it refer to.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{LabeledClip, TrackedLabels};
use crate::timeline::{ClipTrack, Frame};
use crate::{
    Category, Detection, Detections, EvalError, GroundTruth, KittiLabels, LabelSet, LabeledImage,
    Object, Protocol,
};

/// The labels of one clip, with one image per labeled frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipLabels {
    /// Labeled frames as images, in the order of the clip, with their objects.
    pub labels: LabelSet,
    /// The same frames with their times, one per image.
    pub frames: Vec<Frame>,
    /// Of each object the number of its track.
    pub tracks: Vec<Option<u64>>,
    /// The tracks.
    pub names: Vec<TrackName>,
    /// Of each image of all labels its place in this clip.
    places: Vec<Option<u32>>,
}

/// What a track is called.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackName {
    /// Its number.
    pub track: u64,
    /// Its name in the labels.
    pub name: String,
    /// Its class.
    pub class: String,
}

impl TrackedLabels {
    /// The labels of a clip, laid over its frames.
    ///
    /// # Errors
    /// [`EvalError::Rule`] where the labels have another size of frames, frames that the clip lacks,
    /// or frames without numbers that are not as many as the clip's.
    pub fn of_clip(&self, clip: &LabeledClip, track: &ClipTrack) -> Result<ClipLabels, EvalError> {
        let all = &self.truth.labels;
        let n_frames = track.frames.len() as u64;
        let named = clip.name.as_ref();
        let what = named.map_or("the labels".to_owned(), |name| {
            format!("the labels of clip {name:?}")
        });
        let images = images_of(&what, clip, n_frames)?;
        let mut labels = LabelSet {
            categories: all.categories.clone(),
            ..LabelSet::default()
        };
        let mut frames = Vec::new();
        let mut places = vec![None; all.images.len()];
        for (place, (idx, image)) in (0_u32..).zip(&images) {
            let Some(frame) = usize::try_from(*idx)
                .ok()
                .and_then(|idx| track.frames.get(idx))
            else {
                continue;
            };
            let old = image.and_then(|image| all.images.get(image as usize));
            if let (Some(old), Some(size)) = (old, track.size_px)
                && let (Some(width), Some(height)) = (old.width_px, old.height_px)
                && (width, height) != size
            {
                return Err(EvalError::Rule(format!(
                    "{what} are of frames of {width} x {height} px, the clip's have {} x {} px; give the track file of \
                     the same clip",
                    size.0, size.1
                )));
            }
            if let Some(slot) = image.and_then(|image| places.get_mut(image as usize)) {
                *slot = Some(place);
            }
            frames.push(frame.frame);
            labels.images.push(LabeledImage {
                id: i64::from(place) + 1,
                name: match (old, named) {
                    (Some(old), _) => old.name.clone(),
                    (None, Some(clip)) => format!("{clip}/{idx:06}.png"),
                    (None, None) => idx.to_string(),
                },
                width_px: None,
                height_px: None,
                cluster: clip.name.clone(),
            });
        }
        let (tracks, names) = self.put_objects(&places, &mut labels);
        Ok(ClipLabels {
            labels,
            frames,
            tracks,
            names,
            places,
        })
    }

    /// Objects whose image has a place among the frames, into the labels of the clip; gives their tracks, numbered in
    /// the order in which they appear, and the names of those.
    fn put_objects(
        &self,
        places: &[Option<u32>],
        labels: &mut LabelSet,
    ) -> (Vec<Option<u64>>, Vec<TrackName>) {
        let mut numbers = BTreeMap::<&str, u64>::new();
        let mut names = Vec::new();
        let mut tracks = Vec::new();
        for (object, track) in self.truth.labels.objects.iter().zip(&self.tracks) {
            let Some(place) = places.get(object.image as usize).copied().flatten() else {
                continue;
            };
            let number = track.as_deref().map(|name| {
                let next = numbers.len() as u64 + 1;
                *numbers.entry(name).or_insert_with(|| {
                    let category = self.truth.labels.categories.get(object.category as usize);
                    names.push(TrackName {
                        track: next,
                        name: name.to_owned(),
                        class: category.map_or_else(String::new, |it| it.name.clone()),
                    });
                    next
                })
            });
            tracks.push(number);
            labels.objects.push(Object {
                image: place,
                ..object.clone()
            });
        }
        (tracks, names)
    }
}

/// By frame of the clip, the image of the labels that shows it, where one does.
fn images_of(
    what: &str,
    clip: &LabeledClip,
    n_frames: u64,
) -> Result<BTreeMap<u64, Option<u32>>, EvalError> {
    let is_numbered = clip.frames.iter().all(|frame| frame.number.is_some());
    if !is_numbered && clip.frames.len() as u64 != n_frames {
        return Err(EvalError::Rule(format!(
            "{what} have {} frames without numbers, the clip has {n_frames}; give the track file of the same clip, or \
                 labels that number their frames",
            clip.frames.len()
        )));
    }
    let mut images = BTreeMap::<u64, Option<u32>>::new();
    if clip.has_all_frames {
        images.extend((0..n_frames).map(|idx| (idx, None)));
    }
    for (place, frame) in (0..).zip(&clip.frames) {
        let idx = frame.number.unwrap_or(place);
        if idx >= n_frames {
            return Err(EvalError::Rule(format!(
                "{what} have a frame {idx}, but the clip has {n_frames} frames, counted from 0; give the track \
                     file of the same clip, or say with --first-frame what the labels' first number is"
            )));
        }
        images.insert(idx, Some(frame.image));
    }
    Ok(images)
}

impl ClipLabels {
    /// Detections that were read with all labels, by the frames of this clip; those of other clips
    /// are left out.
    #[must_use]
    pub fn of_images(&self, detections: &Detections) -> Detections {
        detections.keep(&self.places)
    }

    /// Detections that were read with [`frames_of`] the clip, by its labeled frames; those of frames
    /// without labels are left out.
    #[must_use]
    pub fn of_frames(&self, detections: &Detections) -> Detections {
        let place_of = |idx: u64| {
            let place = self
                .frames
                .binary_search_by_key(&idx, |frame| frame.frame_idx);
            place.ok().and_then(|place| u32::try_from(place).ok())
        };
        let kept = detections.items.iter().filter_map(|detection| {
            Some(Detection {
                image: place_of(u64::from(detection.image))?,
                ..*detection
            })
        });
        Detections {
            items: kept.collect(),
        }
    }
}

/// All frames of a clip as images without objects, for detections that call them by their place:
/// the number of frame k, from 0, is k + 1, its name that of its file, or `frame_00000k.png`, as
/// `detect` and `video` have it.
#[must_use]
pub fn frames_of(
    track: &ClipTrack,
    clip: Option<&str>,
    categories: &[Category],
    protocol: Protocol,
) -> GroundTruth {
    let image = |(id, tracked): (i64, &crate::timeline::TrackedFrame)| LabeledImage {
        id,
        name: match &tracked.file {
            Some(file) => file.clone(),
            None => format!("frame_{:06}.png", tracked.frame.frame_idx),
        },
        width_px: None,
        height_px: None,
        cluster: clip.map(str::to_owned),
    };
    let labels = LabelSet {
        images: (1..).zip(&track.frames).map(image).collect(),
        categories: categories.to_vec(),
        objects: Vec::new(),
    };
    // A type that the labels lack must not become one that they have.
    let mut of_kitti = labels.clone();
    if labels.category_of_name("Misc").is_none() {
        of_kitti.categories.push(Category {
            id: i64::MAX,
            name: "Misc".to_owned(),
            supercategory: None,
        });
    }
    GroundTruth {
        protocol,
        labels,
        kitti: Some(KittiLabels {
            set: of_kitti,
            facts: Vec::new(),
        }),
        root: None,
    }
}
