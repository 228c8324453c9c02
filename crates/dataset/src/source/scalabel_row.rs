//! Frames in the form of Scalabel, as of BDD100K `det_20`, with labels or detections.

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;
use serde_json::value::RawValue;

use super::index::sound_corners;
use super::{ObjectKind, SourceFormat, WholeId, index_error};
use crate::error::DatasetError;
use crate::json_records::{JsonRecord, read_json_records, reason_of};

/// Older or finer names of classes, and those that evaluation uses [BDD100K, `det.toml`].
const SAME_CLASS: [(&str, &str); 5] = [
    ("bike", "bicycle"),
    ("caravan", "car"),
    ("motor", "motorcycle"),
    ("person", "pedestrian"),
    ("van", "car"),
];

/// Classes that are ignored as a class of evaluation [BDD100K, `det.toml`].
const IGNORED_CLASS: [(&str, &str); 3] = [
    ("other person", "pedestrian"),
    ("other vehicle", "car"),
    ("trailer", "truck"),
];

/// A frame. What only some ask for is looked at when they do.
#[derive(Debug, Clone, Deserialize)]
#[serde(expecting = "a frame")]
pub struct ScalabelFrame<'a> {
    /// The name of its image.
    pub name: String,
    /// The clip that it belongs to.
    #[serde(rename = "videoName")]
    pub video: Option<String>,
    #[serde(rename = "frameIndex", borrow)]
    frame_idx: Option<&'a RawValue>,
    #[serde(borrow)]
    size: Option<&'a RawValue>,
    #[serde(borrow)]
    labels: Option<&'a RawValue>,
}

/// Width and height of a frame, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(expecting = "a size")]
pub struct FrameSize {
    /// Width, px.
    #[serde(rename = "width")]
    pub width_px: u32,
    /// Height, px.
    #[serde(rename = "height")]
    pub height_px: u32,
}

/// What is in a frame.
#[derive(Debug, Clone, Deserialize)]
#[serde(expecting = "a label")]
pub struct ScalabelLabel {
    /// A number or a text; in clips that of the object through all frames.
    #[serde(default)]
    pub id: Value,
    /// The name of its class, as it is written.
    pub category: Option<String>,
    attributes: Option<Attributes>,
    box2d: Option<Box2d>,
    #[serde(default)]
    score: Value,
}

/// A label with a box, in the terms of evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalabelObject<'l> {
    /// The class that evaluation uses.
    pub class: &'l str,
    /// Its box `x0, y0, x1, y1`, px.
    pub corners_px: [f64; 4],
    /// How evaluation treats it.
    pub kind: ObjectKind,
}

#[derive(Debug, Clone, Deserialize, Default)]
#[serde(default)]
struct Attributes {
    crowd: Value,
    ignored: Value,
}

#[derive(Debug, Clone, Copy, Deserialize)]
struct Box2d {
    x1: f64,
    y1: f64,
    x2: f64,
    y2: f64,
}

impl<'a> ScalabelFrame<'a> {
    /// Its labels, each as it could be read.
    ///
    /// # Errors
    /// Where they are no list.
    pub fn labels(
        &self,
    ) -> Result<impl Iterator<Item = Result<ScalabelLabel, String>> + use<'a>, String> {
        let labels: Vec<&RawValue> = of_raw(self.labels)?.unwrap_or_default();
        Ok(labels
            .into_iter()
            .map(|label| serde_json::from_str(label.get()).map_err(|error| reason_of(&error))))
    }

    /// Its number in its clip.
    ///
    /// # Errors
    /// Where it is no whole number.
    pub fn frame_idx(&self) -> Result<Option<i64>, String> {
        Ok(of_raw::<WholeId>(self.frame_idx)?.map(|idx| idx.0))
    }

    /// Its size, where it is said.
    ///
    /// # Errors
    /// Where it is none.
    pub fn size(&self) -> Result<Option<FrameSize>, String> {
        of_raw(self.size)
    }
}

fn of_raw<'a, T: Deserialize<'a>>(raw: Option<&'a RawValue>) -> Result<Option<T>, String> {
    let value = raw.map(|raw| serde_json::from_str(raw.get()));
    value.transpose().map_err(|error| reason_of(&error))
}

impl ScalabelLabel {
    /// The class of evaluation that its category stands for.
    #[must_use]
    pub fn class(&self) -> Option<&str> {
        self.category.as_deref().map(|name| class_of(name).0)
    }

    /// How sure a detector was of it.
    ///
    /// # Errors
    /// Where it is none, as for a label.
    pub fn score(&self) -> Result<f64, String> {
        match (&self.score, self.score.as_f64()) {
            (_, Some(score)) => Ok(score),
            (Value::Null, None) => Err("it has no score; detections have one".to_owned()),
            (other, None) => Err(format!("its score {other} is no number")),
        }
    }

    /// Its box in the terms of evaluation; nothing where it has no box, such as the outline of a lane.
    ///
    /// # Errors
    /// Where it has a box that is none, or a box but no category.
    pub fn object(&self) -> Result<Option<ScalabelObject<'_>>, String> {
        let Some(Box2d { x1, y1, x2, y2 }) = self.box2d else {
            return Ok(None);
        };
        let corners_px = [x1, y1, x2, y2];
        if !sound_corners(corners_px) {
            return Err(format!(
                "the box2d {corners_px:?} px ends before it begins, or reaches beyond 1e9 px"
            ));
        }
        let name = self.category.as_deref();
        let (class, is_ignored) = class_of(name.ok_or("it has a box but no category")?);
        let is_set = |attribute: fn(&Attributes) -> &Value| {
            let attributes = self.attributes.as_ref();
            attributes.is_some_and(|it| is_set_in_python(attribute(it)))
        };
        let kind = if is_ignored {
            ObjectKind::Ignored
        } else if is_set(|it| &it.crowd) {
            ObjectKind::Crowd
        } else if is_set(|it| &it.ignored) {
            ObjectKind::Ignored
        } else {
            ObjectKind::Regular
        };
        Ok(Some(ScalabelObject {
            class,
            corners_px,
            kind,
        }))
    }
}

/// Gives `take` the frames of a file, which is a list of them or an object with the list `frames`. No
/// more is held than one frame.
///
/// # Errors
/// As [`read_json_records`]; [`DatasetError::SourceIndex`] where it has no frames.
pub fn read_scalabel_frames<E: From<DatasetError>>(
    path: &Path,
    mut take: impl FnMut(JsonRecord<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let found = read_json_records(path, |record| {
        if matches!(record.key, "" | "frames") && record.idx.is_some() {
            return take(record);
        }
        Ok(record.check(path)?)
    })?;
    if found.is_one_list || found.has("frames") {
        return Ok(());
    }
    let reason = "it has no list \"frames\", and is none";
    Err(index_error(path, SourceFormat::Bdd, reason).into())
}

/// The class of evaluation that a name of BDD100K stands for, and whether its objects are ignored.
fn class_of(name: &str) -> (&str, bool) {
    let find = |map: &[(&str, &'static str)]| {
        let pair = map.iter().find(|(from, _)| *from == name);
        pair.map(|(_, to)| *to)
    };
    match (find(&IGNORED_CLASS), find(&SAME_CLASS)) {
        (Some(class), _) => (class, true),
        (None, Some(class)) => (class, false),
        (None, None) => (name, false),
    }
}

/// Whether an attribute is set, in the sense of Python, in which the public tools are written.
fn is_set_in_python(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Bool(value) => *value,
        Value::Number(value) => value.as_f64() != Some(0.0),
        Value::String(value) => !value.is_empty(),
        Value::Array(value) => !value.is_empty(),
        Value::Object(value) => !value.is_empty(),
    }
}
