//! Labels that say which object is which through the frames of clips.

mod clip;
mod coco;
mod kitti;
mod numbered;
mod said;

use std::collections::BTreeMap;
use std::path::Path;

use starbreak_dataset::files_in;

use super::open::is_scalabel;
use super::{GroundTruth, Protocol};
use crate::json_record::{refuse, refuse_file};
use crate::labels::{as_they_are, scalabel};
use crate::{EvalError, LabelSet, ObjectKind, bdd_labels};
pub use clip::{ClipLabels, TrackName, frames_of};
pub use said::said_categories;

/// Labels of clips, with a name for each object that is the same in all of its frames.
#[derive(Debug, Clone)]
pub struct TrackedLabels {
    /// The frames of all clips, categories and objects, in the convention of the protocol: BDD100K's
    /// of Scalabel, else MS-COCO's.
    pub truth: GroundTruth,
    /// Of each object the name of its track, unique in its clip; crowds have none.
    pub tracks: Vec<Option<String>>,
    /// The clips.
    pub clips: Vec<LabeledClip>,
    /// Whether the images have names or numbers by which detections call them. Those of KITTI have
    /// not: 000000 is in every clip.
    pub has_image_ids: bool,
}

/// A labeled frame of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LabeledFrame {
    /// Its place in [`LabelSet::images`].
    pub image: u32,
    /// Its number in the clip, where the labels say it.
    pub number: Option<u64>,
}

/// A clip and its labeled frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabeledClip {
    /// What the labels call it; `None` where they know of one clip only and do not name it.
    pub name: Option<String>,
    /// The labeled frames, in the order of the clip.
    pub frames: Vec<LabeledFrame>,
    /// Whether frames beyond these are labeled, too, and hold no object: so it is with KITTI.
    pub has_all_frames: bool,
}

impl TrackedLabels {
    /// The labels in a file of frames in the form of Scalabel (labels with `id`, frames with
    /// `videoName` and `frameIndex`), in a file of MS-COCO (annotations with `track_id` or
    /// `instance_id`, images with `video_id` and `frame_id` or `frame_index`), or in a file or folder
    /// of KITTI's tracking benchmark (`label_02/0000.txt`), told apart by what is in them.
    /// `first_idx` is the number that the labels give to a clip's first frame.
    ///
    /// # Errors
    /// As the readers of [`LabelSet`]; [`EvalError::Record`] for an object without a track, one that
    /// is twice in a frame, or changes its category; [`EvalError::File`] where no object is in two
    /// frames.
    pub fn read(path: &Path, first_idx: u64) -> Result<Self, EvalError> {
        let is_text = path.extension().is_some_and(|it| it == "txt");
        let tracked = if is_text || files_in(path, "txt").is_ok() {
            kitti::read(path, first_idx)?
        } else if is_scalabel(path)? {
            read_scalabel(path, first_idx)?
        } else {
            coco::read(path, first_idx)?
        };
        tracked.check(path)?;
        Ok(tracked)
    }

    /// The clip of this name, or the only one.
    ///
    /// # Errors
    /// [`EvalError::Rule`] where there is none of the name, or there are several and none was named.
    pub fn clip(&self, name: Option<&str>) -> Result<&LabeledClip, EvalError> {
        let names = || {
            let names: Vec<&str> = self
                .clips
                .iter()
                .filter_map(|c| c.name.as_deref())
                .collect();
            let shown = names.iter().take(8).copied().collect::<Vec<_>>().join(", ");
            let more = names.len().saturating_sub(8);
            match more {
                0 => shown,
                _ => format!("{shown} and {more} more"),
            }
        };
        match (name, self.clips.as_slice()) {
            (None, [only]) => Ok(only),
            (None, []) => Err(EvalError::Rule(
                "the labels are of no clip: they have no images".to_owned(),
            )),
            (None, _) => Err(EvalError::Rule(format!(
                "the labels are of {} clips; choose one with --clip: {}",
                self.clips.len(),
                names()
            ))),
            (Some(name), [only]) if only.name.is_none() || only.name.as_deref() == Some(name) => {
                Ok(only)
            }
            (Some(name), clips) => {
                let is_it = |clip: &&LabeledClip| clip.name.as_deref() == Some(name);
                clips.iter().find(is_it).ok_or_else(|| {
                    EvalError::Rule(format!(
                        "the labels have no clip {name:?}; they have {}",
                        names()
                    ))
                })
            }
        }
    }

    /// Each object to be found is followed, once in a frame and as one category, and some object is
    /// in two frames.
    fn check(&self, path: &Path) -> Result<(), EvalError> {
        let LabelSet {
            images, objects, ..
        } = &self.truth.labels;
        let mut clip_of = vec![usize::MAX; images.len()];
        for (place, clip) in self.clips.iter().enumerate() {
            for LabeledFrame { image, .. } in &clip.frames {
                if let Some(of_image) = clip_of.get_mut(*image as usize) {
                    *of_image = place;
                }
            }
        }
        let n_named = self.tracks.iter().flatten().count();
        if n_named == 0 && !objects.is_empty() {
            return Err(refuse_file(
                path,
                "its objects have no tracks (Scalabel: id, MS-COCO: track_id or instance_id, KITTI: the second \
                 column of label_02); give labels that follow objects, or leave them out to follow the clean detections",
            ));
        }
        // Category and frames of each track.
        let mut seen = BTreeMap::<(usize, &str), (u32, Vec<u32>)>::new();
        for (object, track) in objects.iter().zip(&self.tracks) {
            let image = images.get(object.image as usize);
            let at = format!(
                "object {} in {:?}",
                object.id,
                image.map_or("", |image| image.name.as_str())
            );
            let Some(track) = track else {
                if object.kind == ObjectKind::Regular {
                    let reason = "it has no track, while others have; give each object one";
                    return Err(refuse(path, at, reason));
                }
                continue;
            };
            let clip = clip_of.get(object.image as usize).copied();
            let key = (clip.unwrap_or(usize::MAX), track.as_str());
            let (category, frames) = seen
                .entry(key)
                .or_insert_with(|| (object.category, Vec::new()));
            if *category != object.category {
                let reason = format!("the track {track:?} has another category in another frame");
                return Err(refuse(path, at, reason));
            }
            frames.push(object.image);
        }
        for ((_, track), (_, frames)) in &mut seen {
            frames.sort_unstable();
            if let Some([image, _]) = frames.windows(2).find(|pair| pair[0] == pair[1]) {
                let image = images.get(*image as usize);
                let at = format!("image {:?}", image.map_or("", |image| image.name.as_str()));
                let reason = format!("the track {track:?} is in it twice");
                return Err(refuse(path, at, reason));
            }
        }
        let is_followed = seen.values().any(|(_, frames)| frames.len() > 1);
        if !is_followed && n_named > 0 && images.len() > 1 {
            return Err(refuse_file(
                path,
                "no object is in two frames, so its ids number boxes and not objects; give labels of a tracking \
                 benchmark, or leave them out to follow the clean detections",
            ));
        }
        Ok(())
    }
}

fn read_scalabel(path: &Path, first_idx: u64) -> Result<TrackedLabels, EvalError> {
    let mut reader = scalabel::Reader::of_clips();
    reader.read(path, as_they_are)?;
    let scalabel::Tracked {
        labels,
        tracks,
        frame_idx,
    } = reader.finish_tracked(path)?;
    let mut clips = BTreeMap::<Option<String>, Vec<LabeledFrame>>::new();
    for ((place, image), idx) in (0..).zip(&labels.images).zip(frame_idx) {
        let number = idx
            .map(|idx| number(path, &image.name, idx, first_idx))
            .transpose()?;
        let frames = clips.entry(image.cluster.clone()).or_default();
        frames.push(LabeledFrame {
            image: place,
            number,
        });
    }
    Ok(TrackedLabels {
        clips: in_order(path, clips)?,
        truth: GroundTruth {
            protocol: Protocol::Bdd,
            labels: bdd_labels(&labels),
            kitti: None,
            root: None,
        },
        tracks,
        has_image_ids: true,
    })
}

/// A frame's number in its clip, from 0.
fn number(path: &Path, image: &str, idx: i64, first_idx: u64) -> Result<u64, EvalError> {
    let number = u64::try_from(idx).ok();
    number
        .and_then(|idx| idx.checked_sub(first_idx))
        .ok_or_else(|| {
            let reason = format!("its frame number is {idx}; numbers count from {first_idx}");
            refuse(path, format!("image {image:?}"), reason)
        })
}

/// Clips with their frames by number, or, where they have none, as they stand.
fn in_order(
    path: &Path,
    clips: BTreeMap<Option<String>, Vec<LabeledFrame>>,
) -> Result<Vec<LabeledClip>, EvalError> {
    let mut all = Vec::new();
    for (name, mut frames) in clips {
        let n_numbered = frames.iter().filter(|frame| frame.number.is_some()).count();
        let of_clip = name
            .as_ref()
            .map_or(String::new(), |name| format!(" of clip {name:?}"));
        if n_numbered != 0 && n_numbered != frames.len() {
            let reason = format!(
                "{n_numbered} of {} frames{of_clip} have a number; give all or none one",
                frames.len()
            );
            return Err(refuse_file(path, reason));
        }
        frames.sort_by_key(|frame| (frame.number, frame.image));
        let numbers: Vec<u64> = frames.iter().filter_map(|frame| frame.number).collect();
        if let Some([number, _]) = numbers.array_windows().find(|[one, next]| one == next) {
            let reason = format!("frame {number}{of_clip} is there twice");
            return Err(refuse_file(path, reason));
        }
        all.push(LabeledClip {
            name,
            frames,
            has_all_frames: false,
        });
    }
    Ok(all)
}
