//! Annotations of MS-COCO whose images are moved.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use crate::error::DatasetError;
use crate::json_records::{JsonMembers, JsonRecord};
use crate::source::coco_row::CocoAnnotation;
use crate::source::id::Id;
use crate::source::index::IndexFile;
use crate::source::moved::{Frames, Mask, MovedBox, MovedFrame, area_px2, hundredth};

/// The members with places, which are moved.
const PLACES: [&str; 3] = ["bbox", "segmentation", "keypoints"];

/// What an annotation outlines.
enum Segmentation {
    Outlines(Vec<Vec<[f64; 2]>>),
    Mask(Mask),
}

/// An annotation, of which all that has places is understood.
struct Places<'a> {
    members: JsonMembers<'a>,
    bbox_px: [f64; 4],
    segmentation: Option<Segmentation>,
    key_points: Option<Vec<[f64; 3]>>,
}

impl<'a> Places<'a> {
    /// The places of a record whose box was read; what of it cannot be moved where there is such.
    fn of(text: &'a str) -> Result<Self, String> {
        let members: JsonMembers<'a> =
            serde_json::from_str(text).map_err(|error| error.to_string())?;
        if let Some(key) = members.other_with_numbers(&PLACES) {
            return Err(format!("its {key}, whose numbers may be places,"));
        }
        let [x, y, width, height]: [f64; 4] =
            read(members.get("bbox"), "bbox")?.unwrap_or_default();
        let segmentation = members
            .get("segmentation")
            .map(segmentation_of)
            .transpose()?;
        let numbers: Option<Vec<f64>> = read(members.get("keypoints"), "keypoints")?;
        let key_points = numbers.map(|numbers| match numbers.as_chunks::<3>() {
            (points, []) => Ok(points.to_vec()),
            _ => Err(format!(
                "its keypoints of {} numbers, which are no threes,",
                numbers.len()
            )),
        });
        Ok(Self {
            bbox_px: [x, y, x + width, y + height],
            segmentation,
            key_points: key_points.transpose()?,
            members,
        })
    }

    /// The annotation with its places moved; none where nothing of its box is left, or of its outlines or mask.
    fn moved(&self, frame: &MovedFrame) -> Result<Option<String>, String> {
        let Some(MovedBox { corners_px, .. }) = frame.box_px(self.bbox_px) else {
            return Ok(None);
        };
        let [x0, y0, x1, y1] = corners_px;
        let sides = [x1 - x0, y1 - y0].map(hundredth);
        let mut replaced = vec![("bbox", json!([x0, y0, sides[0], sides[1]]))];
        let mut area = sides[0] * sides[1];
        match &self.segmentation {
            None => {}
            Some(Segmentation::Outlines(outlines)) => {
                let moved = outlines.iter().map(|outline| frame.outline(outline));
                let moved: Vec<_> = moved.filter(|outline| !outline.is_empty()).collect();
                if moved.is_empty() && outlines.iter().any(|outline| area_px2(outline) > 0.0) {
                    return Ok(None);
                }
                if !outlines.is_empty() {
                    area = moved.iter().map(|outline| area_px2(outline)).sum();
                }
                let flat: Vec<Vec<f64>> = moved.iter().map(|outline| outline.concat()).collect();
                replaced.push(("segmentation", json!(flat)));
            }
            Some(Segmentation::Mask(mask)) => {
                let [width, height] = mask.size();
                let [w, h] = frame.size_px();
                if [width, height] != [w, h].map(u64::from) {
                    return Err(format!(
                        "its mask of {width} x {height} px in an image of {w} x {h} px"
                    ));
                }
                let moved = frame.mask(mask);
                if moved.area_px2() == 0 && mask.area_px2() > 0 {
                    return Ok(None);
                }
                #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                {
                    area = moved.area_px2() as f64;
                }
                let mask = json!({ "size": [height, width], "counts": moved.counts() });
                replaced.push(("segmentation", mask));
            }
        }
        replaced.push(("area", json!(hundredth(area))));
        if let Some(points) = &self.key_points {
            let moved: Vec<[f64; 3]> = points
                .iter()
                .map(|point| key_point(frame, *point))
                .collect();
            let n_seen = moved.iter().filter(|point| point[2] > 0.0).count();
            let numbers: Vec<Value> = moved.concat().into_iter().map(short).collect();
            replaced.push(("keypoints", json!(numbers)));
            replaced.push(("num_keypoints", json!(n_seen)));
        }
        let replaced: Vec<_> = replaced
            .iter()
            .map(|(key, value)| (*key, value.to_string()))
            .collect();
        Ok(Some(self.members.with(&replaced)))
    }
}

/// A point and how well it is seen, 0 where nobody knows where it is.
fn key_point(frame: &MovedFrame, [x, y, seen]: [f64; 3]) -> [f64; 3] {
    if seen <= 0.0 {
        return [x, y, seen];
    }
    let moved = frame.point([x, y]);
    moved.map_or([0.0; 3], |[x, y]| [x, y, seen])
}

/// A number without a fraction as tools write it.
fn short(value: f64) -> Value {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a whole number within px of a frame"
    )]
    match value.fract().abs() <= 0.0 && value.abs() < 1e9 {
        true => json!(value as i64),
        false => json!(value),
    }
}

fn read<'a, T: Deserialize<'a>>(
    value: Option<&'a RawValue>,
    key: &str,
) -> Result<Option<T>, String> {
    let value = value.map(|value| serde_json::from_str(value.get()));
    value
        .transpose()
        .map_err(|_| format!("its {key}, which is none,"))
}

/// Outlines, or a mask of runs.
fn segmentation_of(value: &RawValue) -> Result<Segmentation, String> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Form {
        Outlines(Vec<Vec<f64>>),
        Mask { size: [u64; 2], counts: Counts },
    }
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Counts {
        Numbers(Vec<u64>),
        Text(String),
    }
    let of_mask = |reason: String| format!("its segmentation ({reason})");
    match serde_json::from_str(value.get()) {
        Ok(Form::Outlines(outlines)) => {
            let corners = |numbers: Vec<f64>| match numbers.as_chunks::<2>() {
                (corners, []) if numbers.iter().all(|at| at.abs() <= 1e9) => Ok(corners.to_vec()),
                _ => Err("its segmentation, an outline of which is none,".to_owned()),
            };
            let outlines: Result<_, _> = outlines.into_iter().map(corners).collect();
            outlines.map(Segmentation::Outlines)
        }
        Ok(Form::Mask {
            size: [height, width],
            counts,
        }) => {
            let counts = match counts {
                Counts::Numbers(counts) => counts,
                Counts::Text(text) => Mask::counts_of_text(&text).map_err(of_mask)?,
            };
            let mask = Mask::of_counts([width, height], counts).map_err(of_mask)?;
            Ok(Segmentation::Mask(mask))
        }
        Err(_) => Err("its segmentation, which is neither outlines nor a mask of runs,".to_owned()),
    }
}

/// The annotations of an index that belong to kept images, once each.
pub(super) struct Annotations<'i> {
    path: &'i Path,
    /// By their ids, with the row of the image.
    rows: BTreeMap<&'i Id, usize>,
}

impl<'i> Annotations<'i> {
    /// Those of these rows of an index that could be read.
    pub(super) fn of(index: &'i IndexFile, rows: impl Iterator<Item = usize>) -> Self {
        let of_row = |row: usize| {
            index
                .labels_of(row)
                .iter()
                .map(move |label| (&label.id, row))
        };
        Self {
            path: &index.path,
            rows: rows.flat_map(of_row).collect(),
        }
    }

    /// The row of a record's image, the first time that it is asked for.
    fn take(&mut self, record: &JsonRecord<'_>) -> Option<(Id, usize)> {
        let annotation: CocoAnnotation<Id, IgnoredAny> = record.parse().ok()?;
        let id = annotation.object().ok()?.id;
        let row = self.rows.remove(&id)?;
        Some((id, row))
    }

    /// Refuses a record of these that cannot be moved.
    pub(super) fn check(&mut self, record: &JsonRecord<'_>) -> Result<(), DatasetError> {
        match self.take(record) {
            Some((id, _)) => self.named(&id, Places::of(record.text).map(drop)),
            None => Ok(()),
        }
    }

    /// A record with its places moved in the frame of its row; nothing where none of it is left, or where it is none of
    /// these.
    pub(super) fn moved(
        &mut self,
        record: &JsonRecord<'_>,
        frames: &mut Frames<'_>,
    ) -> Result<Option<Cow<'static, str>>, DatasetError> {
        let Some((id, row)) = self.take(record) else {
            return Ok(None);
        };
        let Some(frame) = frames.of_row(row) else {
            return Ok(None);
        };
        let moved = Places::of(record.text).and_then(|places| places.moved(frame));
        Ok(self.named(&id, moved)?.map(Cow::Owned))
    }

    fn named<T>(&self, id: &Id, result: Result<T, String>) -> Result<T, DatasetError> {
        result.map_err(|what| DatasetError::Unmovable {
            path: self.path.to_owned(),
            place: format!("annotation {id}"),
            what,
        })
    }
}
