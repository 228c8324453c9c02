//! What comes out of a dataset: images with their labels, other files, bad records.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

/// An image of a dataset with its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceImage {
    /// Its path inside the root of the dataset, with `/` between the parts; no two images of a
    /// dataset have the same name, nor names that differ only in case. Seeds are keyed by it.
    pub name: String,
    /// Where it can be read.
    pub path: PathBuf,
    /// Its labels, in the order of the source.
    pub objects: Vec<LabeledObject>,
    /// Labels which could not be read, or the lack of any where the format demands some.
    ///
    /// The image itself stands; whether it can be used is for the caller to say.
    pub problems: Vec<BadRecord>,
}

/// A box with a class.
#[derive(Debug, Clone, PartialEq)]
pub struct LabeledObject {
    /// Where the label stands: `label_2/000001.txt:3`, `annotation 4711`, `label 00109430`.
    pub record: String,
    /// Its class, by the name that evaluation uses.
    pub category: String,
    /// `x0, y0, x1, y1` in pixels: finite, `x0 <= x1` and `y0 <= y1`, possibly beyond the frame.
    ///
    /// The numbers of the source, unrounded; COCO's width and height are added to its corner,
    /// YOLO's shares are multiplied by the size of the upright image.
    pub box_px: [f64; 4],
    /// How evaluation treats it.
    pub kind: ObjectKind,
}

/// How evaluation treats an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectKind {
    /// An object to be found.
    Regular,
    /// A group of objects under one box: COCO `iscrowd`, the BDD attribute `crowd`.
    Crowd,
    /// Neither to be found nor an error when found once: KITTI `DontCare`, BDD's ignored classes.
    Ignored,
}

impl ObjectKind {
    /// Its name in records: `regular`, `crowd` or `ignored`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Regular => "regular",
            Self::Crowd => "crowd",
            Self::Ignored => "ignored",
        }
    }
}

/// A file of a dataset that is not one of its images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// Its path inside the root of the dataset, with `/` between the parts.
    pub name: String,
    /// Where it can be read.
    pub path: PathBuf,
    /// What it is to the dataset.
    pub role: FileRole,
}

/// What a file that is not an image is to its dataset.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileRole {
    /// It belongs to the one image of this name and has no meaning without it.
    LabelOf(String),
    /// It names many images; [`super::Source::subset`] writes it for some of them.
    Index,
    /// Everything else: calibration, splits, captions, point clouds, texts.
    Other,
}

/// A record that breaks the rules of its format, and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadRecord {
    /// The file, with the line or the record where there is one.
    pub place: String,
    /// What is wrong, with the value.
    pub reason: String,
    /// The name of the image which is concerned, if it is one.
    pub image: Option<String>,
}

impl BadRecord {
    /// The record of no image.
    pub(super) fn new(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            place: place.into(),
            reason: reason.into(),
            image: None,
        }
    }

    /// The same of this image.
    pub(super) fn of_image(mut self, name: &str) -> Self {
        self.image = Some(name.to_owned());
        self
    }
}

impl fmt::Display for BadRecord {
    /// Writes `place: reason` on one line; what would break the line or hide is escaped.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self
            .place
            .chars()
            .chain([':', ' '])
            .chain(self.reason.chars())
        {
            match c {
                '"' | '\'' | '\\' => write!(f, "{c}")?,
                _ => write!(f, "{}", c.escape_debug())?,
            }
        }
        Ok(())
    }
}

impl std::error::Error for BadRecord {}
