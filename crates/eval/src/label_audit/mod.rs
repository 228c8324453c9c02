//! Whether the classes of detections mean what those of the labels mean.
//!
//! A detector whose class numbers are shifted by one or permuted still finds the objects; it only
//! names them wrongly, and AP falls without a sign of why. Here boxes are matched regardless of
//! class, and the names that detections and labels give the same boxes are compared: if another map
//! of classes explains them clearly better than taking them as they are, it is said.

mod confusion;
mod maps;

use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::detections::Detections;
use crate::labels::LabelSet;
use crate::statistic::{Measured, mcnemar, proportion};
pub use confusion::{Confusion, confusion};
use maps::Candidate;

/// What the audit goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AuditSettings {
    /// Score from which detections are looked at. **Default** 0.3.
    pub score_threshold: f64,
    /// Overlap from which a detection and a label are of the same object. **Default** 0.5.
    pub iou: f64,
    /// Pairs below which nothing is concluded. **Default** 30.
    pub min_pairs: u64,
    /// By how much another map must raise the share of pairs that agree, if it does not put right
    /// half of the pairs that it touches. **Default** 0.1.
    pub margin: f64,
    /// p that its exact `McNemar` test must not exceed. **Default** 0.001.
    pub max_p: f64,
}

impl Default for AuditSettings {
    fn default() -> Self {
        Self {
            score_threshold: 0.3,
            iou: 0.5,
            min_pairs: 30,
            margin: 0.1,
            max_p: 0.001,
        }
    }
}

/// What the audit says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LabelAudit {
    /// What it goes by.
    pub settings: AuditSettings,
    /// Pairs of a detection and a label on the same object.
    pub n_pairs: u64,
    /// Share of the pairs that agree as they are, with Wilson's interval (95 %).
    pub agreement: Measured,
    /// What to think of it.
    pub verdict: Verdict,
    /// Other maps, the one that agrees best first.
    pub maps: Vec<MapAgreement>,
}

/// What to think of the classes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Verdict {
    /// No other map explains the pairs clearly better.
    Fits,
    /// Another map does: the classes of the detections are wrong.
    Wrong {
        /// Which one, as in [`LabelAudit::maps`].
        map: ClassMap,
        /// What to do, in plain words.
        advice: String,
    },
    /// Fewer than half of the pairs agree, and no other map explains them.
    Unexplained {
        /// What to do, in plain words.
        advice: String,
    },
    /// There are too few pairs to tell.
    TooFew {
        /// Pairs that would be needed.
        needed: u64,
    },
}

/// A way in which classes can be wrong.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum ClassMap {
    /// Category numbers are too large by this much (the +1 of a background class, in a space of
    /// numbers with gaps such as the 91 of MS-COCO).
    IdShift {
        /// By how much, negative if they are too small.
        by: i64,
    },
    /// Places in the list of categories are too large by this much.
    PlaceShift {
        /// By how much, negative if they are too small.
        by: i64,
    },
    /// Places counted from this number are used as category numbers.
    PlaceAsId {
        /// Number of the first place.
        first: i64,
    },
    /// Category numbers are used as places counted from this number.
    IdAsPlace {
        /// Number of the first place.
        first: i64,
    },
    /// Single categories stand for others.
    Permutation {
        /// What the detections say and what the labels say, as places of categories; only those
        /// that differ.
        moves: Vec<ClassMove>,
    },
}

/// A category that stands for another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClassMove {
    /// Place of the category that the detections give.
    pub detected: u32,
    /// Place of the category that the labels give.
    pub labeled: u32,
    /// Pairs that say so.
    pub n: u64,
}

/// How well a map explains the pairs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapAgreement {
    /// The map.
    pub map: ClassMap,
    /// Share of the pairs that agree under it. A permutation is judged on the half of the images
    /// that it was not made from, each half in turn.
    pub agreement: Measured,
    /// Pairs whose detected class it changes.
    pub n_touched: u64,
    /// Pairs that agree under it and not as they are.
    pub n_gained: u64,
    /// Pairs that agree as they are and not under it.
    pub n_lost: u64,
    /// `McNemar`'s exact test of the two.
    pub p: Option<f64>,
}

/// Compares the classes of detections and labels on the same objects.
///
/// Tried are: numbers or places shifted by up to two, places from 0 or 1 used as numbers, numbers
/// used as places, and the permutation that agrees best (linear sum assignment \[Crouse2016\]). The
/// maps are tried on the detections as they were read: what a reader refused for having an unknown
/// category is not among them.
///
/// # Errors
/// If a detection or object is of an image or category that the labels do not have, or a setting
/// is not finite.
pub fn label_audit(
    labels: &LabelSet,
    detections: &Detections,
    settings: AuditSettings,
) -> Result<LabelAudit, EvalError> {
    let halves = confusion::by_halves(labels, detections, settings)?;
    let whole = Confusion::sum(&halves);
    let n_pairs = whole.n_pairs();
    let n_as_is = whole.n_agreeing(Some);
    let agreement = proportion(n_as_is, n_pairs, 0.95);
    let mut maps: Vec<MapAgreement> = maps::candidates(labels, &halves)
        .into_iter()
        .map(|candidate| judged(candidate, &halves))
        .collect();
    maps.sort_by(|a, b| {
        let value = |it: &MapAgreement| it.agreement.value.unwrap_or(0.0);
        value(b).total_cmp(&value(a))
    });
    let verdict = verdict(labels, &agreement, n_pairs, &maps, settings);
    Ok(LabelAudit {
        settings,
        n_pairs,
        agreement,
        verdict,
        maps,
    })
}

fn judged(candidate: Candidate, halves: &[Confusion; 2]) -> MapAgreement {
    let (mut n_gained, mut n_lost, mut n_agreeing, mut n_pairs) = (0, 0, 0, 0);
    let mut n_touched = 0;
    for (half, map) in halves.iter().zip(&candidate.to_labels) {
        for (detected, labeled, n) in half.cells() {
            let mapped = map.get(detected as usize).copied().flatten();
            let (is_mapped, is_as_is) = (mapped == Some(labeled), detected == labeled);
            n_pairs += n;
            n_touched += n * u64::from(mapped != Some(detected));
            n_agreeing += n * u64::from(is_mapped);
            n_gained += n * u64::from(is_mapped && !is_as_is);
            n_lost += n * u64::from(is_as_is && !is_mapped);
        }
    }
    MapAgreement {
        map: candidate.map,
        agreement: proportion(n_agreeing, n_pairs, 0.95),
        n_touched,
        n_gained,
        n_lost,
        p: mcnemar(n_gained, n_lost).exact.p,
    }
}

fn verdict(
    labels: &LabelSet,
    agreement: &Measured,
    n_pairs: u64,
    maps: &[MapAgreement],
    settings: AuditSettings,
) -> Verdict {
    let as_is = match agreement.value {
        Some(value) if n_pairs >= settings.min_pairs => value,
        _ => {
            return Verdict::TooFew {
                needed: settings.min_pairs,
            };
        }
    };
    let is_better = |map: &&MapAgreement| {
        let value = map.agreement.value;
        let is_much = value.is_some_and(|it| it >= as_is + settings.margin);
        let is_half = map.n_gained > 0 && 2 * map.n_gained >= map.n_touched;
        map.p.is_some_and(|p| p <= settings.max_p)
            && (is_much || is_half)
            && map.n_gained > map.n_lost
    };
    // Of maps that explain about as much, a rule says more than a permutation. Of rules that explain
    // the same, such as both shifts when what fell into a gap of the numbers was never read, the
    // first one tried stands.
    let mut better = maps.iter().filter(is_better);
    if let Some(best) = better.next() {
        let value = |it: &MapAgreement| it.agreement.value.unwrap_or(0.0);
        let is_rule = |it: &&MapAgreement| !matches!(it.map, ClassMap::Permutation { .. });
        let rule = maps.iter().filter(is_better).find(is_rule);
        let chosen = rule
            .filter(|it| value(it) + 0.02 >= value(best))
            .unwrap_or(best);
        return Verdict::Wrong {
            map: chosen.map.clone(),
            advice: advice(labels, &chosen.map),
        };
    }
    if as_is < 0.5 {
        return Verdict::Unexplained {
            advice:
                "check the class names: detections and labels seem to use different class lists"
                    .to_owned(),
        };
    }
    Verdict::Fits
}

fn advice(labels: &LabelSet, map: &ClassMap) -> String {
    let name = |place: u32| {
        let category = labels.categories.get(place as usize);
        category.map_or("?", |it| it.name.as_str()).to_owned()
    };
    match map {
        ClassMap::IdShift { by } => {
            format!("category ids of the detections are off by {by:+}: subtract {by} from each")
        }
        ClassMap::PlaceShift { by } => format!(
            "classes of the detections are {by:+} positions off in the category list: check whether it starts with a background class"
        ),
        ClassMap::PlaceAsId { first } => format!(
            "the detections give positions in the category list, counted from {first}, instead of category ids: map each position to the id of its category"
        ),
        ClassMap::IdAsPlace { first } => format!(
            "category ids were read as positions in the category list, counted from {first}: use them as they are"
        ),
        ClassMap::Permutation { moves } => {
            let shown: Vec<String> = moves
                .iter()
                .take(5)
                .map(|it| format!("{:?} is {:?}", name(it.detected), name(it.labeled)))
                .collect();
            format!(
                "{} classes of the detections are permuted: {}",
                moves.len(),
                shown.join(", ")
            )
        }
    }
}
