//! What a detector said is in the images.

mod coco;
mod kitti;
mod pooled;
mod scalabel;
mod write;

use std::path::Path;

pub use kitti::KittiDetections;
pub use pooled::Pooling;

use crate::{BoxPx, EvalError, LabelSet};

/// The detections of a whole dataset, in the order in which they were written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detections {
    /// One after the other.
    pub items: Vec<Detection>,
}

/// A detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Place of its image in [`LabelSet::images`](crate::LabelSet::images).
    pub image: u32,
    /// Place of its category in [`LabelSet::categories`](crate::LabelSet::categories).
    pub category: u32,
    /// Its box.
    pub box_px: BoxPx,
    /// How sure the detector is, finite; mostly 0 to 1.
    pub score: f64,
}

/// Detections from a file, and what in it was not used.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadDetections {
    /// The detections.
    pub detections: Detections,
    /// Detections of categories that the labels lack, which no protocol counts.
    pub unused: Option<Unused>,
}

/// Detections of categories that the labels lack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unused {
    /// How many there are.
    pub n_detections: usize,
    /// The first such category.
    pub first: String,
}

impl Detections {
    /// The detections in a file of results of MS-COCO: a list of `{image_id, category_id, bbox,
    /// score}`, in its order. Labels whose images and categories stand in the order of their
    /// numbers say what the numbers mean.
    ///
    /// # Errors
    /// [`EvalError::Record`] with list place and byte for what makes no sense: numbers that are not
    /// finite, negative sides, texts for numbers, missing keys. [`EvalError::UnknownImages`] for
    /// detections in images that the labels lack, [`EvalError::File`] where it is no list,
    /// [`EvalError::Dataset`].
    pub fn read_coco(path: &Path, labels: &LabelSet) -> Result<ReadDetections, EvalError> {
        coco::read(path, labels)
    }

    /// The detections in a file of frames in the form of Scalabel, `labels` with a `score` each.
    /// A frame that the file lacks has no detections.
    ///
    /// # Errors
    /// As [`read_coco`](Self::read_coco); also for a frame that occurs twice.
    pub fn read_scalabel(path: &Path, labels: &LabelSet) -> Result<ReadDetections, EvalError> {
        scalabel::read(path, labels)
    }

    /// The same, which must not be more than can be evaluated.
    pub(crate) fn within_limits(self, path: &Path, labels: &LabelSet) -> Result<Self, EvalError> {
        labels.check_images(path, "detections", self.items.iter().map(|it| it.image))?;
        Ok(self)
    }
}
