use serde::{Deserialize, Serialize};

use crate::BoxPx;

/// An image in which much was lost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstFailure {
    /// The image's path inside the dataset.
    pub image: String,
    /// Width that the boxes refer to, px.
    pub width_px: u32,
    /// Height that the boxes refer to, px.
    pub height_px: u32,
    /// Found clean.
    pub n_found_clean: u64,
    /// Lost of those.
    pub n_lost: u64,
    /// Detections that the cracks brought.
    pub n_new: u64,
    /// What is drawn over it.
    pub boxes: Vec<RoledBox>,
    /// Both pictures, for a report with pictures; not part of the numbers.
    #[serde(skip)]
    pub pictures: Option<PicturePair>,
}

/// A box with what it means.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoledBox {
    /// What it means.
    pub role: BoxRole,
    /// Name of its class.
    pub class: String,
    /// The box, px of the image.
    pub box_px: BoxPx,
    /// The detection's score, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// Share of the object's box that the region covers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
}

/// What a box means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoxRole {
    /// An object that is found neither clean nor cracked.
    Missed,
    /// An object that is found in both.
    Found,
    /// An object that is found clean, not cracked.
    Lost,
    /// A detection that only the cracked image has, where no object is.
    New,
}

/// The same image clean and cracked, as JPEG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PicturePair {
    /// Clean.
    pub clean_jpeg: Vec<u8>,
    /// Cracked.
    pub cracked_jpeg: Vec<u8>,
}

/// An object that only one of both images shows to the detector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChangedObject {
    /// The image's path inside the dataset.
    pub image: String,
    /// The label's number in the source.
    pub object_id: i64,
    /// Name of its class.
    pub class: String,
    /// Its box.
    pub box_px: BoxPx,
    /// What became of it.
    pub change: Change,
    /// Share of its box that the region covers.
    pub coverage: f64,
    /// Score of the detection that found it.
    pub score: f64,
    /// Overlap of that detection.
    pub iou: f64,
}

/// What became of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Found clean, not cracked.
    Lost,
    /// Found cracked, not clean.
    Recovered,
}
