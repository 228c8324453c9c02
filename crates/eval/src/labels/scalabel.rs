//! Frames in the form of Scalabel, as of BDD100K `det_20`: labels and detections.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::{JsonRecord, bdd_class, is_set_in_python, read_json_records};

use super::{Category, LabelSet, LabeledImage, Object, ObjectKind};
use crate::json_record::{Id, parse, place, refuse, refuse_file};
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

/// A frame.
#[derive(Deserialize)]
pub(crate) struct Frame {
    pub(crate) name: String,
    #[serde(rename = "videoName", default)]
    pub(crate) video: Option<String>,
    #[serde(rename = "frameIndex", default)]
    frame_idx: Option<Id>,
    #[serde(default)]
    size: Option<FrameSize>,
    #[serde(default)]
    pub(crate) labels: Option<Vec<Label>>,
}

#[derive(Deserialize)]
struct FrameSize {
    width: u32,
    height: u32,
}

/// What is in a frame.
#[derive(Deserialize)]
pub(crate) struct Label {
    /// A number or a text; in clips that of the object through all frames.
    #[serde(default)]
    id: serde_json::Value,
    #[serde(default)]
    pub(crate) category: Option<String>,
    #[serde(default)]
    attributes: Option<Attributes>,
    #[serde(default)]
    box2d: Option<Box2d>,
    #[serde(default)]
    pub(crate) score: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Attributes {
    crowd: serde_json::Value,
    ignored: serde_json::Value,
}

#[derive(Deserialize)]
struct Box2d {
    x1: f64,
    y1: f64,
    x2: f64,
    y2: f64,
}

impl Label {
    /// The box, if it has one, or why it is none.
    pub(crate) fn box_px(&self) -> Result<Option<BoxPx>, String> {
        let Some(Box2d { x1, y1, x2, y2 }) = self.box2d else {
            return Ok(None);
        };
        let box_px = BoxPx::from_corners([x1, y1, x2, y2]);
        match box_px.is_sound() {
            true => Ok(Some(box_px)),
            false => Err(format!(
                "the box2d {:?} px ends before it begins, or reaches beyond 1e9 px",
                [x1, y1, x2, y2]
            )),
        }
    }
}

/// Each frame of a file, with its place.
pub(crate) fn for_each_frame(
    path: &Path,
    mut take: impl FnMut(Frame, String) -> Result<(), EvalError>,
) -> Result<(), EvalError> {
    let mut has_frames = false;
    let lists = read_json_records(path, |record: JsonRecord<'_>| {
        if matches!(record.key, "" | "frames") && record.idx.is_some() {
            has_frames = true;
            let frame: Frame = parse(path, &record)?;
            let at = format!("{}, frame {:?}", place(&record), frame.name);
            return take(frame, at);
        }
        parse::<serde::de::IgnoredAny>(path, &record).map(drop)
    })?;
    if !lists.is_one_list && !lists.keys.iter().any(|key| key == "frames") {
        return Err(refuse_file(path, "it has no list \"frames\", and is none"));
    }
    Ok(())
}

/// An object with the name of its category and, in clips, of its track.
type NamedObject = (String, BoxPx, ObjectKind, Option<String>);

/// A frame as it was read.
struct ReadFrame {
    image: LabeledImage,
    frame_idx: Option<i64>,
    objects: Vec<NamedObject>,
}

/// Labels, and what they say of clips.
pub(super) struct Tracked {
    pub(super) labels: LabelSet,
    /// Of each object the name of its track.
    pub(super) tracks: Vec<Option<String>>,
    /// Of each image its number in its clip.
    pub(super) frame_idx: Vec<Option<i64>>,
}

/// Takes the frames of one file or several.
#[derive(Default)]
pub(super) struct Reader {
    frames: Vec<ReadFrame>,
    /// Frames go by their clip and name; the names of tracks are kept.
    of_clips: bool,
}

impl Reader {
    /// A reader of labels that follow objects through clips.
    pub(super) fn of_clips() -> Self {
        Self {
            of_clips: true,
            ..Self::default()
        }
    }

    /// Reads a file; `names` makes the names of images in the dataset of what the file calls them.
    pub(super) fn read(
        &mut self,
        path: &Path,
        names: impl Fn(&[&str]) -> Vec<String>,
    ) -> Result<(), EvalError> {
        let n_before = self.frames.len();
        let of_clips = self.of_clips;
        for_each_frame(path, |frame, at| {
            let mut objects = Vec::new();
            for (idx, label) in frame.labels.iter().flatten().enumerate() {
                let wrong = |reason: String| refuse(path, format!("{at}, label [{idx}]"), reason);
                let Some(box_px) = label.box_px().map_err(wrong)? else {
                    continue;
                };
                let Some(name) = &label.category else {
                    return Err(wrong("it has a box but no category".to_owned()));
                };
                let (class, is_ignored) = bdd_class(name);
                let blank = Attributes::default();
                let attributes = label.attributes.as_ref().unwrap_or(&blank);
                let kind = match is_set_in_python(&attributes.crowd) {
                    true => ObjectKind::Crowd,
                    false if is_ignored || is_set_in_python(&attributes.ignored) => {
                        ObjectKind::Ignored
                    }
                    false => ObjectKind::Regular,
                };
                let track = of_clips.then(|| track_name(&label.id)).flatten();
                objects.push((class.to_owned(), box_px, kind, track));
            }
            let name = match &frame.video {
                Some(video) if of_clips => format!("{video}/{}", frame.name),
                _ => frame.name,
            };
            let image = LabeledImage {
                id: 0,
                name,
                width_px: frame.size.as_ref().map(|size| size.width),
                height_px: frame.size.as_ref().map(|size| size.height),
                cluster: frame.video,
            };
            self.frames.push(ReadFrame {
                image,
                frame_idx: frame.frame_idx.map(|idx| idx.0),
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
    pub(super) fn finish(self, path: &Path) -> Result<LabelSet, EvalError> {
        let names = || self.frames.iter().flat_map(|frame| &frame.objects);
        let n_all = names().count();
        let others: Vec<&str> = names()
            .map(|(name, ..)| name.as_str())
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
    pub(super) fn finish_tracked(mut self, path: &Path) -> Result<Tracked, EvalError> {
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
            names.extend(frame.objects.iter().map(|(name, ..)| name.as_str()));
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
        for (id, frame) in (1..).zip(self.frames) {
            let place = u32::try_from(labels.images.len()).unwrap_or(u32::MAX);
            frame_idx.push(frame.frame_idx);
            labels.images.push(LabeledImage { id, ..frame.image });
            for (name, box_px, kind, track) in frame.objects {
                let Some(category) = labels.category_of_name(&name) else {
                    continue;
                };
                let next = labels.objects.len() + 1;
                labels.objects.push(Object {
                    id: i64::try_from(next).unwrap_or(i64::MAX),
                    image: place,
                    category,
                    box_px,
                    area_px2: box_px.area_px2(),
                    kind,
                });
                tracks.push(track);
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
