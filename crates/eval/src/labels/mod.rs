//! What is really in the images: images, categories and labeled objects.

mod clusters;
pub(crate) mod coco;
mod extent;
pub(crate) mod kitti;
pub(crate) mod scalabel;

use std::path::Path;

use serde::Serialize;

pub use kitti::{KittiFacts, KittiLabels};

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
    /// The names of its categories, in their order.
    #[must_use]
    pub fn category_names(&self) -> Vec<&str> {
        let names = self.categories.iter();
        names.map(|category| category.name.as_str()).collect()
    }

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
    pub(crate) fn image_of_id(&self, id: i64) -> Option<u32> {
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

    /// Adds an image of a format without numbers and sizes, and says its place.
    pub(crate) fn add_image(&mut self, name: String, cluster: Option<String>) -> u32 {
        let place = place(self.images.len());
        self.images.push(LabeledImage {
            id: i64::from(place) + 1,
            name,
            width_px: None,
            height_px: None,
            cluster,
        });
        place
    }

    /// Adds a category without a group, and says its place.
    pub(crate) fn add_category(&mut self, name: String) -> u32 {
        let place = place(self.categories.len());
        self.categories.push(Category {
            id: i64::from(place) + 1,
            name,
            supercategory: None,
        });
        place
    }

    /// Adds an object of a format without numbers and areas.
    pub(crate) fn add_object(
        &mut self,
        image: u32,
        category: u32,
        box_px: BoxPx,
        kind: ObjectKind,
    ) {
        self.objects.push(Object {
            id: i64::from(place(self.objects.len())) + 1,
            image,
            category,
            box_px,
            area_px2: box_px.area_px2(),
            kind,
        });
    }

    /// Place of the category of this name.
    #[must_use]
    pub(crate) fn category_of_name(&self, name: &str) -> Option<u32> {
        let found = self.categories.iter().position(|c| c.name == name);
        found.map(place)
    }

    /// Place of the category with this number, in sets whose categories stand in the order of
    /// numbers.
    #[must_use]
    pub(crate) fn category_of_id(&self, id: i64) -> Option<u32> {
        index_of(&self.categories, id, |category| category.id)
    }
}

/// The place of the item of this number among items in the order of numbers.
pub(crate) fn index_of<T>(items: &[T], id: i64, id_of: impl Fn(&T) -> i64) -> Option<u32> {
    items.binary_search_by_key(&id, id_of).ok().map(place)
}

/// A place in a list of labels; none of so many fits into memory that a number of 32 bits would not do.
pub(crate) fn place(idx: usize) -> u32 {
    u32::try_from(idx).unwrap_or(u32::MAX)
}

/// Names that are those in the dataset already.
pub(crate) fn as_they_are(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}
