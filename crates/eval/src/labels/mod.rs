//! What is really in the images: images, categories and labeled objects.

mod clusters;
mod coco;
mod extent;
mod kept;
pub(crate) mod kitti;
mod open;
mod pooled;
pub(crate) mod scalabel;
mod tracked;

use std::path::Path;

use serde::Serialize;

pub use kitti::{KittiFacts, KittiLabels};
pub use open::{GroundTruth, Protocol, SaidDetections};
pub use pooled::Pooling;
pub use tracked::{ClipLabels, LabeledClip, TrackName, TrackedLabels, frames_of, said_categories};

pub use starbreak_dataset::ObjectKind;

use crate::{BoxPx, EvalError};

/// The labels of a dataset, in the order in which its protocol evaluates them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LabelSet {
    /// Images; everything refers to them by their place in here.
    pub images: Vec<LabeledImage>,
    /// Categories; everything refers to them by their place in here.
    pub categories: Vec<Category>,
    /// Objects, in the order of the source.
    pub objects: Vec<Object>,
}

/// An image that has been looked through for objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LabeledImage {
    /// Its number in the source; of formats without numbers the place of its name, from 1.
    pub id: i64,
    /// Its path inside the dataset, with `/` between the parts: the key that joins it to masks,
    /// detections and the cracked image.
    pub name: String,
    /// Width, px, where the labels say it.
    pub width_px: Option<u32>,
    /// Height, px, where the labels say it.
    pub height_px: Option<u32>,
    /// What it shares with images that are not independent of it: a drive, a clip.
    pub cluster: Option<String>,
}

/// A class of objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Category {
    /// Its number in the source.
    pub id: i64,
    /// Its name.
    pub name: String,
    /// The name of the group that it belongs to, where there are groups.
    pub supercategory: Option<String>,
}

/// A labeled object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Object {
    /// Its number in the source; of formats without numbers its place, from 1.
    pub id: i64,
    /// Place of its image in [`LabelSet::images`].
    pub image: u32,
    /// Place of its category in [`LabelSet::categories`].
    pub category: u32,
    /// Its box.
    pub box_px: BoxPx,
    /// Its area, px²: in MS-COCO that of its outline, else that of its box.
    pub area_px2: f64,
    /// How evaluation treats it.
    pub kind: ObjectKind,
}

impl Object {
    /// Whether it is to be found: one with an area below 0 is in no range of areas, and ignored by the rules
    /// of MS-COCO.
    pub(crate) fn is_to_be_found(&self) -> bool {
        self.kind == ObjectKind::Regular && self.area_px2 >= 0.0
    }
}

impl LabelSet {
    /// The ground truth in a file of MS-COCO, `instances_*.json`: images and categories in the
    /// order of their numbers, objects in that of the file.
    ///
    /// What pycocotools takes is taken, such as boxes without area, boxes that begin before the
    /// frame, the number 0, and numbers with gaps. The area is that of the outline, as the file
    /// says it, and below 0 in no range of sizes; outlines are not kept.
    ///
    /// # Errors
    /// [`EvalError::Record`] for what makes no sense: numbers that are not finite, negative sides,
    /// texts for numbers, missing keys, a number that occurs twice, objects of images or categories
    /// that the file lacks. [`EvalError::File`] where a list is missing, [`EvalError::Dataset`].
    pub fn read_coco(path: &Path) -> Result<Self, EvalError> {
        let mut reader = coco::Reader::default();
        reader.read(path, as_they_are)?;
        reader.finish(path)
    }

    /// Place of the image with this number, in sets whose images stand in the order of numbers.
    #[must_use]
    pub fn image_of_id(&self, id: i64) -> Option<u32> {
        index_of(&self.images, id, |image| image.id)
    }

    /// The ground truth in a file of frames in the form of Scalabel, such as `det_val.json` of
    /// BDD100K: frames in the order of their names, numbered from 1; the ten classes of BDD100K
    /// with older and finer names mapped to them, or, where none of them occurs, the names that do.
    ///
    /// # Errors
    /// [`EvalError::Record`] for what makes no sense, [`EvalError::File`] where there are no frames,
    /// [`EvalError::Dataset`].
    pub fn read_scalabel(path: &Path) -> Result<Self, EvalError> {
        let mut reader = scalabel::Reader::default();
        reader.read(path, as_they_are)?;
        reader.finish(path)
    }

    /// Place of the category of this name.
    #[must_use]
    pub fn category_of_name(&self, name: &str) -> Option<u32> {
        let place = self.categories.iter().position(|c| c.name == name)?;
        u32::try_from(place).ok()
    }

    /// Place of the category with this number, in sets whose categories stand in the order of
    /// numbers.
    #[must_use]
    pub fn category_of_id(&self, id: i64) -> Option<u32> {
        index_of(&self.categories, id, |category| category.id)
    }
}

/// The place of the item of this number among items in the order of numbers.
pub(crate) fn index_of<T>(items: &[T], id: i64, id_of: impl Fn(&T) -> i64) -> Option<u32> {
    let idx = items.binary_search_by_key(&id, id_of).ok()?;
    u32::try_from(idx).ok()
}

/// Names that are those in the dataset already.
fn as_they_are(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}
