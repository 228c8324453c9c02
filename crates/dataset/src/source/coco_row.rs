//! The records of MS-COCO, `instances_*.json`.
//!
//! Who reads them says what an id may be, and what is made of that which not everybody asks for:
//! `serde::de::IgnoredAny` where nobody does, so that a fault there costs nobody a record.

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use super::index::sound_corners;
use super::{ObjectKind, SourceFormat, index_error};
use crate::error::DatasetError;
use crate::json_records::{JsonRecord, read_json_records};

/// The lists that an index has.
const LISTS: [&str; 3] = ["images", "annotations", "categories"];

/// An image.
#[derive(Debug, Clone, Deserialize)]
#[serde(expecting = "an image")]
pub struct CocoImage<Id, Side> {
    /// Its number.
    pub id: Id,
    /// Its name in the folder of its images.
    pub file_name: Option<String>,
    /// Width, px.
    pub width: Option<Side>,
    /// Height, px.
    pub height: Option<Side>,
}

/// A class.
#[derive(Debug, Clone, Deserialize)]
#[serde(expecting = "a category")]
pub struct CocoCategory<Id, Group> {
    /// Its number.
    pub id: Id,
    /// Its name.
    pub name: Option<String>,
    /// The name of the group that it belongs to.
    pub supercategory: Option<Group>,
}

/// An annotation.
#[derive(Debug, Clone, Deserialize)]
#[serde(expecting = "an annotation")]
pub struct CocoAnnotation<Id, Area> {
    /// Its number.
    pub id: Option<Id>,
    /// The number of its image.
    pub image_id: Option<Id>,
    category_id: Option<Id>,
    bbox: Option<[f64; 4]>,
    /// The area of its outline, px².
    pub area: Option<Area>,
    #[serde(default = "not_set")]
    iscrowd: Value,
}

/// An annotation that says all that it must.
#[derive(Debug, Clone, PartialEq)]
pub struct CocoObject<Id> {
    /// Its number.
    pub id: Id,
    /// The number of its image.
    pub image_id: Id,
    /// The number of its category.
    pub category_id: Id,
    /// Left side, upper side, width and height, px, all within 1e9 and the last two not below 0.
    pub bbox_px: [f64; 4],
    /// Whether it is one object or a crowd.
    pub kind: ObjectKind,
}

fn not_set() -> Value {
    Value::Bool(false)
}

impl<Id, Area> CocoAnnotation<Id, Area> {
    /// What every annotation must say.
    ///
    /// # Errors
    /// What is missing or wrong.
    pub fn object(self) -> Result<CocoObject<Id>, String> {
        Ok(CocoObject {
            id: self.id.ok_or("it has no id")?,
            image_id: self.image_id.ok_or("it has no image_id")?,
            category_id: self.category_id.ok_or("it has no category_id")?,
            bbox_px: sound_bbox(self.bbox.ok_or("it has no bbox")?)?,
            kind: match (self.iscrowd.as_bool(), self.iscrowd.as_f64()) {
                (Some(false), _) | (_, Some(0.0)) => ObjectKind::Regular,
                (Some(true), _) | (_, Some(1.0)) => ObjectKind::Crowd,
                _ => return Err(format!("iscrowd = {} is neither 0 nor 1", self.iscrowd)),
            },
        })
    }
}

/// Gives `take` the records of the three lists of an index of MS-COCO: `images`, `annotations` and
/// `categories`, in the order of the file. No more is held than one record.
///
/// # Errors
/// As [`read_json_records`]; [`DatasetError::SourceIndex`] where one of the lists is missing.
pub fn read_coco_records<E: From<DatasetError>>(
    path: &Path,
    mut take: impl FnMut(JsonRecord<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let found = read_json_records(path, |record| {
        if LISTS.contains(&record.key) && record.idx.is_some() {
            return take(record);
        }
        Ok(record.check(path)?)
    })?;
    let Some(missing) = LISTS.iter().find(|key| !found.has(key)) else {
        return Ok(());
    };
    let reason = match found.is_one_list {
        true => "it is one list, as results are; ground truth is an object with the lists images, annotations and categories".to_owned(),
        false => format!("it has no list {missing:?}; ground truth of MS-COCO has images, annotations and categories"),
    };
    Err(index_error(path, SourceFormat::Coco, reason).into())
}

/// The same box, of an annotation or a result, if it is one.
///
/// # Errors
/// Where a side is negative, or a number is beyond 1e9.
pub fn sound_bbox(bbox_px: [f64; 4]) -> Result<[f64; 4], String> {
    let [x, y, width, height] = bbox_px;
    let is_sound = width >= 0.0 && height >= 0.0 && sound_corners([x, y, x + width, y + height]);
    match is_sound {
        true => Ok(bbox_px),
        false => Err(format!(
            "the bbox {bbox_px:?} px has a negative side, or reaches beyond 1e9 px"
        )),
    }
}
