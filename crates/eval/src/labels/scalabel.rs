//! Frames in the form of Scalabel, as of BDD100K `det_20`: labels and detections.

use std::collections::BTreeSet;
use std::path::Path;

use starbreak_dataset::{ScalabelFrame, ScalabelLabel, read_scalabel_frames};

use super::{Category, LabelSet, LabeledImage, ObjectKind};
use crate::json_record::{parse, refuse, refuse_file};
use crate::{BoxPx, EvalError};

/// The classes of BDD100K in the order of its numbers, with their groups [BDD100K, `det.toml`].
const CLASSES: [(&str, Option<&str>); 10] = [
    ("pedestrian", Some("human")),
    ("rider", Some("human")),
    ("car", Some("vehicle")),
    ("truck", Some("vehicle")),
    ("bus", Some("vehicle")),
    ("train", Some("vehicle")),
    ("motorcycle", Some("bike")),
    ("bicycle", Some("bike")),
    ("traffic light", Some("traffic light")),
    ("traffic sign", Some("traffic sign")),
];

/// Each frame of a file, with its place.
pub(crate) fn for_each_frame(
    path: &Path,
    mut take: impl FnMut(&ScalabelFrame<'_>, &str) -> Result<(), EvalError>,
) -> Result<(), EvalError> {
    read_scalabel_frames(path, |record| {
        let frame: ScalabelFrame<'_> = parse(path, &record)?;
        let at = format!("{}, frame {:?}", record.place(), frame.name);
        take(&frame, &at)
    })
}

/// Each label of a frame.
pub(crate) fn for_each_label(
    path: &Path,
    frame: &ScalabelFrame<'_>,
    at: &str,
    mut take: impl FnMut(&ScalabelLabel) -> Result<(), String>,
) -> Result<(), EvalError> {
    let labels = frame.labels().map_err(|reason| refuse(path, at, reason))?;
    for (idx, label) in labels.enumerate() {
        label
            .and_then(|label| take(&label))
            .map_err(|reason| refuse(path, format!("{at}, label [{idx}]"), reason))?;
    }
    Ok(())
}

/// An object before its category has a place.
struct NamedObject {
    class: String,
    box_px: BoxPx,
    kind: ObjectKind,
    /// The name of its track, in clips.
    track: Option<String>,
}

/// A frame as it was read.
struct ReadFrame {
    image: LabeledImage,
    frame_idx: Option<i64>,
    objects: Vec<NamedObject>,
}

/// Labels, and what they say of clips.
pub(crate) struct Tracked {
    pub(crate) labels: LabelSet,
    /// Of each object the name of its track.
    pub(crate) tracks: Vec<Option<String>>,
    /// Of each image its number in its clip.
    pub(crate) frame_idx: Vec<Option<i64>>,
}

/// Takes the frames of one file or several.
#[derive(Default)]
pub(crate) struct Reader {
    frames: Vec<ReadFrame>,
    /// Frames go by their clip and name; the names of tracks are kept.
    of_clips: bool,
}

impl Reader {
    /// A reader of labels that follow objects through clips.
    pub(crate) fn of_clips() -> Self {
        Self {
            of_clips: true,
            ..Self::default()
        }
    }

    /// Reads a file; `names` makes the names of images in the dataset of what the file calls them.
    pub(crate) fn read(
        &mut self,
        path: &Path,
        names: impl Fn(&[&str]) -> Vec<String>,
    ) -> Result<(), EvalError> {
        let n_before = self.frames.len();
        let of_clips = self.of_clips;
        for_each_frame(path, |frame, at| {
            let mut objects = Vec::new();
            for_each_label(path, frame, at, |label| {
                let object = label.object()?;
                objects.extend(object.map(|object| NamedObject {
                    class: object.class.to_owned(),
                    box_px: BoxPx::from_corners(object.corners_px),
                    kind: object.kind,
                    track: of_clips.then(|| track_name(&label.id)).flatten(),
                }));
                Ok(())
            })?;
            let name = match &frame.video {
                Some(video) if of_clips => format!("{video}/{}", frame.name),
                _ => frame.name.clone(),
            };
            let wrong = |reason: String| refuse(path, at, reason);
            let size = frame.size().map_err(wrong)?;
            let image = LabeledImage {
                id: 0,
                name,
                width_px: size.map(|size| size.width_px),
                height_px: size.map(|size| size.height_px),
                cluster: frame.video.clone(),
            };
            self.frames.push(ReadFrame {
                image,
                frame_idx: frame.frame_idx().map_err(wrong)?,
                objects,
            });
            Ok(())
        })?;
        let frames = self.frames.get_mut(n_before..).unwrap_or(&mut []);
        let said: Vec<&str> = frames
            .iter()
            .map(|frame| frame.image.name.as_str())
            .collect();
        let named = names(&said);
        for (frame, name) in frames.iter_mut().zip(named) {
            frame.image.name = name;
        }
        Ok(())
    }

    /// All that was read: frames in the order of their names, numbered from 1, the classes of
    /// BDD100K where all are of them, those that occur where none is.
    ///
    /// Boxes of both kinds are refused: which classes the benchmark leaves out must not be guessed.
    pub(crate) fn finish(self, path: &Path) -> Result<LabelSet, EvalError> {
        let objects = || self.frames.iter().flat_map(|frame| &frame.objects);
        let n_all = objects().count();
        let others: Vec<&str> = objects()
            .map(|object| object.class.as_str())
            .filter(|name| !is_of_bdd(name))
            .collect();
        if !others.is_empty() && others.len() < n_all {
            let distinct: BTreeSet<&str> = others.iter().copied().collect();
            let shown: Vec<String> = distinct
                .iter()
                .take(8)
                .map(|it| format!("{it:?}"))
                .collect();
            let more = match distinct.len().saturating_sub(8) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let reason = format!(
                "{} of {n_all} boxes are of categories that BDD100K lacks: {}{more}; take them out, or write the \
                 labels in the form of MS-COCO, which has categories of its own",
                others.len(),
                shown.join(", ")
            );
            return Err(refuse_file(path, reason));
        }
        Ok(self.finish_tracked(path)?.labels)
    }

    /// The same with what is said of clips; categories that BDD100K lacks stand behind its own.
    pub(crate) fn finish_tracked(mut self, path: &Path) -> Result<Tracked, EvalError> {
        self.frames.sort_by(|a, b| a.image.name.cmp(&b.image.name));
        let twice = self.frames.windows(2).find_map(|pair| match pair {
            [a, b] if a.image.name == b.image.name => Some(a.image.name.clone()),
            _ => None,
        });
        if let Some(name) = twice {
            return Err(refuse(
                path,
                format!("frame {name:?}"),
                "the name occurs twice",
            ));
        }
        let mut names: Vec<&str> = Vec::new();
        for frame in &self.frames {
            names.extend(frame.objects.iter().map(|object| object.class.as_str()));
        }
        names.sort_unstable();
        names.dedup();
        let mut classes: Vec<(String, Option<String>)> = Vec::new();
        if names.is_empty() || names.iter().any(|name| is_of_bdd(name)) {
            let own = CLASSES.map(|(name, group)| (name.to_owned(), group.map(str::to_owned)));
            classes.extend(own);
        }
        let others = names.iter().filter(|name| !is_of_bdd(name));
        classes.extend(others.map(|name| ((*name).to_owned(), None)));
        let mut labels = LabelSet::default();
        for (id, (name, supercategory)) in (1..).zip(classes) {
            labels.categories.push(Category {
                id,
                name,
                supercategory,
            });
        }
        let (mut tracks, mut frame_idx) = (Vec::new(), Vec::new());
        for ((id, place), frame) in (1..).zip(0..).zip(self.frames) {
            frame_idx.push(frame.frame_idx);
            labels.images.push(LabeledImage { id, ..frame.image });
            for object in frame.objects {
                let Some(category) = labels.category_of_name(&object.class) else {
                    continue;
                };
                labels.add_object(place, category, object.box_px, object.kind);
                tracks.push(object.track);
            }
        }
        Ok(Tracked {
            labels: labels.within_limits(path)?,
            tracks,
            frame_idx,
        })
    }
}

/// Whether a class is one of BDD100K's.
fn is_of_bdd(name: &str) -> bool {
    CLASSES.iter().any(|(known, _)| *known == name)
}

/// The name of a track; nothing for what is no name.
fn track_name(id: &serde_json::Value) -> Option<String> {
    match id {
        serde_json::Value::String(name) if !name.is_empty() => Some(name.clone()),
        serde_json::Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}
