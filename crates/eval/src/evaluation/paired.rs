use serde::{Deserialize, Serialize};

use super::Estimate;

/// Where in the image a number counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scope {
    /// Inside the region, outside of it, or everywhere.
    pub kind: ScopeKind,
    /// Share of an object's box that the region must cover for it to be inside, 0 to 1; 0 means
    /// that it touches. Of [`ScopeKind::WholeImage`] there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<f64>,
}

impl Scope {
    /// Whether it is at this τ; so is each if one of both has none.
    pub(crate) fn is_at(&self, tau: Option<f64>) -> bool {
        let pair = self.tau.zip(tau);
        pair.is_none_or(|(one, other)| (one - other).abs() < 1e-12)
    }

    /// Everywhere.
    #[must_use]
    pub fn whole_image() -> Self {
        Self {
            kind: ScopeKind::WholeImage,
            tau: None,
        }
    }
}

/// The kinds of [`Scope`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScopeKind {
    /// Objects that the damage covers by the share `tau` or more.
    InRegion,
    /// The control: objects that it covers by less.
    OutOfRegion,
    /// All objects.
    WholeImage,
}

/// The objects that a number is about.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Group {
    /// What sort of group.
    pub kind: GroupKind,
    /// Its name in the labels; of [`GroupKind::All`] it is `all`, of
    /// [`GroupKind::MeanOfSupercategories`] `mean of supercategories`.
    pub name: String,
}

impl Group {
    /// Every class together.
    #[must_use]
    pub fn all() -> Self {
        Self {
            kind: GroupKind::All,
            name: "all".to_owned(),
        }
    }

    /// The mean over the supercategories.
    #[must_use]
    pub fn mean_of_supercategories() -> Self {
        Self {
            kind: GroupKind::MeanOfSupercategories,
            name: "mean of supercategories".to_owned(),
        }
    }
}

/// The sorts of [`Group`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupKind {
    /// All classes.
    All,
    /// The mean over the supercategories, each pooled.
    MeanOfSupercategories,
    /// The classes of one supercategory, pooled.
    Supercategory,
    /// One class.
    Class,
}

/// What is compared between the clean and the cracked images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PairedMetric {
    /// AP at an overlap of 0.5.
    Ap50,
    /// AP at an overlap of 0.75.
    Ap75,
    /// AP averaged over the overlaps 0.5 to 0.95.
    Ap,
    /// KITTI's AP over 11 recalls, moderate difficulty.
    KittiAp11,
    /// KITTI's AP over 40 recalls, moderate difficulty.
    KittiAp40,
}

/// Precision over recall at IoU 0.5, clean and cracked, of all classes: at the recalls 0, 0.01, …, 1 the mean over
/// the classes that have objects, so that the mean of each side is its AP50.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrecisionCurves {
    /// Where.
    pub scope: Scope,
    /// On the clean images.
    pub clean: Vec<f64>,
    /// On the cracked images.
    pub cracked: Vec<f64>,
}

/// One number, clean and cracked, of the same objects in the same images under the same mask.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedRow {
    /// Where.
    pub scope: Scope,
    /// Of which objects.
    pub group: Group,
    /// Which number.
    pub metric: PairedMetric,
    /// Objects to be found.
    pub n_objects: u64,
    /// Images with at least one of them.
    pub n_images: u64,
    /// On the clean images.
    pub clean: Estimate,
    /// On the cracked images.
    pub cracked: Estimate,
    /// Cracked minus clean, with the interval of the paired bootstrap.
    pub delta: Estimate,
    /// Probability of a difference as large if cracked and clean were exchangeable, by permutation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// The same, corrected by Holm's method: see [`Study::correct_for_many_tests`](super::Study::correct_for_many_tests).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_holm: Option<f64>,
    /// What a perfect detector would reach with so few objects, where that is not 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<f64>,
}
