//! What a detector said is in the images.

use crate::BoxPx;

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
