//! What a protocol decides about each detection and each object: the currency of all statistics.

/// What became of the detections and objects of one category in one image, at one threshold of
/// overlap and under one rule of what is ignored.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageMatches {
    /// Place of the image in [`LabelSet::images`](crate::LabelSet::images).
    pub image: u32,
    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories).
    pub category: u32,
    /// The detections by falling score, equal ones in their order; cut to the protocol's number.
    pub detections: Vec<MatchedDetection>,
    /// The objects, ignored ones last.
    pub objects: Vec<MatchedObject>,
}

/// What became of a detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchedDetection {
    /// Its place in [`Detections::items`](crate::Detections::items).
    pub detection: u32,
    /// Its score.
    pub score: f64,
    /// What it counts as.
    pub outcome: Outcome,
}

/// What a detection counts as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// It found an object that was to be found.
    TruePositive {
        /// The object's place in [`LabelSet::objects`](crate::LabelSet::objects).
        object: u32,
        /// How much they overlap, 0 to 1.
        iou: f64,
    },
    /// It found nothing.
    FalsePositive,
    /// It counts for nothing: it found an ignored object, or lies where nothing is counted.
    Ignored,
}

/// What became of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MatchedObject {
    /// Its place in [`LabelSet::objects`](crate::LabelSet::objects).
    pub object: u32,
    /// Whether it counts for nothing.
    pub is_ignored: bool,
    /// Place in [`Detections::items`](crate::Detections::items) of the detection that found it; of a
    /// crowd, of the last one.
    pub detection: Option<u32>,
}
