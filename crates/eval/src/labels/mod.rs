//! What is really in the images: images, categories and labeled objects.

use crate::BoxPx;

/// The labels of a dataset, in the order in which its protocol evaluates them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LabelSet {
    /// Images; everything refers to them by their place in here.
    pub images: Vec<LabeledImage>,
    /// Categories; everything refers to them by their place in here.
    pub categories: Vec<Category>,
    /// Objects, in the order of the source.
    pub objects: Vec<Object>,
}

/// An image that has been looked through for objects.
#[derive(Debug, Clone, PartialEq, Eq)]
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
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Category {
    /// Its number in the source.
    pub id: i64,
    /// Its name.
    pub name: String,
    /// The name of the group that it belongs to, where there are groups.
    pub supercategory: Option<String>,
}

/// A labeled object.
#[derive(Debug, Clone, PartialEq)]
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

/// How evaluation treats an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ObjectKind {
    /// To be found.
    Regular,
    /// A group under one box: any number of detections may lie in it without being errors.
    Crowd,
    /// Neither to be found nor an error when found once.
    Ignored,
}
