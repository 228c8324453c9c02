use serde::{Deserialize, Serialize};

use super::{Estimate, Group};

/// What a protocol says about one set of detections, on whole images.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ProtocolResults {
    /// The twelve numbers of MS-COCO in their order: AP, AP50, AP75, AP of small, medium and large
    /// objects, AR of 1, 10 and 100 detections per image, AR of small, medium and large objects.
    /// None where there is no such object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coco_stats: Option<[Option<f64>; 12]>,
    /// AP per group.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupAp>,
    /// KITTI's AP per class and difficulty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kitti: Vec<KittiAp>,
    /// Detections that were read.
    pub n_detections: u64,
}

/// AP of one group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupAp {
    /// Of which objects.
    pub group: Group,
    /// Objects to be found.
    pub n_objects: u64,
    /// AP averaged over the overlaps 0.5 to 0.95.
    pub ap: Estimate,
    /// AP at an overlap of 0.5.
    pub ap50: Estimate,
    /// AP at an overlap of 0.75.
    pub ap75: Estimate,
}

/// AP of one class and difficulty by KITTI's rules.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KittiAp {
    /// The class.
    pub class: String,
    /// `easy`, `moderate` or `hard`.
    pub difficulty: String,
    /// Overlap above which an object counts as found.
    pub min_overlap: f64,
    /// Objects to be found.
    pub n_objects: u64,
    /// AP over 11 recalls.
    pub ap11: Estimate,
    /// AP over 40 recalls.
    pub ap40: Estimate,
    /// What a perfect detector would reach over 11 recalls with so few objects.
    pub ceiling_ap11: f64,
    /// What a perfect detector would reach over 40 recalls with so few objects.
    pub ceiling_ap40: f64,
}

/// Whether the detector's classes are the labels' classes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LabelAudit {
    /// Objects that some detection of any class covers well.
    pub n_pairs: u64,
    /// Share of them whose detection has the object's class.
    pub agreement: Estimate,
    /// What to think of it.
    pub verdict: LabelVerdict,
    /// What to do, where there is something to do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<String>,
    /// The commonest disagreements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disagreements: Vec<ShiftedLabel>,
}

/// What to think of the classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LabelVerdict {
    /// No other map of classes explains the pairs clearly better.
    Fits,
    /// Another map does.
    Wrong,
    /// Few pairs agree, and no other map explains them.
    Unexplained,
    /// There are too few pairs to tell.
    TooFew,
}

/// Objects of one class that are found as another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShiftedLabel {
    /// What the labels say.
    pub truth: String,
    /// What the detector says.
    pub detected: String,
    /// How often.
    pub n: u64,
}

/// AP that each kind of error costs, after TIDE: what AP50 would gain if it were mended.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TideErrors {
    /// AP50 as it is.
    pub ap50: f64,
    /// Right place, wrong class.
    pub classification: f64,
    /// Right class, poor overlap.
    pub localization: f64,
    /// Wrong class and poor overlap.
    pub both: f64,
    /// A second detection of a found object.
    pub duplicate: f64,
    /// Nothing there.
    pub background: f64,
    /// Not found at all.
    pub missed: f64,
    /// All false positives.
    pub false_positive: f64,
    /// All false negatives.
    pub false_negative: f64,
}
