//! What kinds of errors cost how much AP: TIDE \[Bolya2020\].
//!
//! Detections of an image are looked at across classes. One that found nothing is, in this order:
//! `Loc`, right class, overlap between t_b and t_f; `Cls`, wrong class, overlap of at least t_f;
//! `Dupe`, right class on an object already found; `Bkg`, overlap of at most t_b with anything;
//! else `Both`, wrong class and badly placed. An object that is not found, nor would be if a `Loc`
//! or `Cls` error were right, is `Miss`. What a kind costs is how much AP rises when an oracle puts
//! its errors right. The numbers are those of `tidecv` 1.0.1, its habits included.

mod classify;
mod curves;

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::detections::Detections;
use crate::labels::LabelSet;
use curves::{Fix, Points};

/// What TIDE goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TideSettings {
    /// Overlap from which a detection finds an object. **Default** 0.5. **Source** \[Bolya2020\].
    pub found_iou: f64,
    /// Overlap up to which a detection lies on background. **Default** 0.1. **Source** \[Bolya2020\].
    pub background_iou: f64,
    /// Detections per image, over all classes, the best ones. **Default** 100. **Source** tidecv.
    pub max_detections: u32,
}

impl Default for TideSettings {
    fn default() -> Self {
        Self {
            found_iou: 0.5,
            background_iou: 0.1,
            max_detections: 100,
        }
    }
}

/// Kinds of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ErrorKind {
    /// Wrong class, well placed.
    Cls,
    /// Right class, badly placed.
    Loc,
    /// Wrong class and badly placed.
    Both,
    /// An object found once more.
    Dupe,
    /// Background taken for an object.
    Bkg,
    /// An object that nothing comes near.
    Miss,
}

/// All kinds, in the order of the paper.
pub(crate) const ERROR_KINDS: [ErrorKind; 6] = [
    ErrorKind::Cls,
    ErrorKind::Loc,
    ErrorKind::Both,
    ErrorKind::Dupe,
    ErrorKind::Bkg,
    ErrorKind::Miss,
];

/// What each kind of error costs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tide {
    /// What it goes by.
    pub settings: TideSettings,
    /// Objects to be found.
    pub n_objects: u64,
    /// Detections that count: not ignored, within the best of their image.
    pub n_detections: u64,
    /// Mean over classes of AP at the overlap `found_iou`, 0 to 100; a class that is only detected
    /// counts as 0. `None` without any object or detection.
    pub ap: Option<f64>,
    /// One per kind.
    pub errors: Vec<ErrorCost>,
    /// AP gained if all false positives had score 0.
    pub false_positive_d_ap: Option<f64>,
    /// AP gained if missed objects did not count.
    pub false_negative_d_ap: Option<f64>,
}

/// What one kind of error costs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorCost {
    /// Which.
    pub kind: ErrorKind,
    /// How many; ignored detections that would be errors are among them, as in tidecv.
    pub n: u64,
    /// AP gained, 0 to 100, if these alone were put right; a loss, which the steps of the curve can
    /// make, is given as 0.
    pub d_ap: Option<f64>,
}

/// The kinds of errors of detections and what they cost.
///
/// Objects that are crowds or ignored are regions in which detections of their class are not
/// counted, when more than `found_iou` of their own area lies inside.
///
/// # Errors
/// If overlaps are not 0 ≤ background ≤ found ≤ 1, or an object or detection is of an image or
/// category that is not there.
pub fn tide(
    labels: &LabelSet,
    detections: &Detections,
    settings: TideSettings,
) -> Result<Tide, EvalError> {
    check(labels, detections, settings)?;
    let found = classify::classify(labels, detections, settings);
    let n_categories = labels.categories.len();
    let base = Points::new(&found, n_categories);
    let ap = base.mean_ap(Fix::Nothing);
    let gain = |fix: Fix| base.mean_ap(fix).zip(ap).map(|(fixed, ap)| fixed - ap);
    let errors = ERROR_KINDS
        .iter()
        .map(|kind| ErrorCost {
            kind: *kind,
            n: found.errors.iter().filter(|it| it.kind == *kind).count() as u64,
            d_ap: gain(Fix::Kind(*kind)).map(|it| it.max(0.0)),
        })
        .collect();
    Ok(Tide {
        settings,
        n_objects: found.n_objects.iter().sum(),
        n_detections: found.points.len() as u64,
        ap,
        errors,
        false_positive_d_ap: gain(Fix::FalsePositives),
        false_negative_d_ap: gain(Fix::FalseNegatives),
    })
}

fn check(
    labels: &LabelSet,
    detections: &Detections,
    settings: TideSettings,
) -> Result<(), EvalError> {
    let TideSettings {
        found_iou,
        background_iou,
        ..
    } = settings;
    if !(0.0 <= background_iou && background_iou <= found_iou && found_iou <= 1.0) {
        return Err(EvalError::StatisticSetting {
            what: "overlap of background",
            value: background_iou,
            range: "from 0 to that of a found object, which is at most 1",
        });
    }
    let places = labels.objects.iter().map(|it| (it.image, it.category));
    let places = places.chain(detections.items.iter().map(|it| (it.image, it.category)));
    for (image, category) in places {
        let of_image = (
            "image of an object or detection",
            image,
            labels.images.len(),
        );
        let of_category = (
            "category of an object or detection",
            category,
            labels.categories.len(),
        );
        for (what, place, n) in [of_image, of_category] {
            if place as usize >= n {
                return Err(EvalError::StatisticLength {
                    what,
                    found: place as usize,
                    expected: n,
                    of: "are in the labels",
                });
            }
        }
    }
    Ok(())
}
