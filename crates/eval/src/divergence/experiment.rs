//! The paper's experiment on K-L divergences, with sets that the user supplies.

use serde::Serialize;

use super::ReadSettings;
use super::compare::{Values, compare_with_replicates};
use super::estimate::share;
use super::features::Feature;
use super::report::{CompareSettings, DivergenceReport, Measure, PairComparison};
use super::set::ImageSet;
use crate::EvalError;

/// The sets of the experiment, each by the flag that names it and by what the paper's figure calls it: crack
/// patterns on black, simulated and collected online; both over KITTI; the road through broken and through
/// whole glass; KITTI; a second driving set that the paper has not; the control.
pub const PAPER_SETS: [(&str, &str); 9] = [
    ("--simulated", "Sim"),
    ("--real-overlays", "RO"),
    ("--simulated-kitti", "Sim x KITTI"),
    ("--overlays-kitti", "RO x KITTI"),
    ("--road-broken", "broken RC"),
    ("--road-clean", "clean RC"),
    ("--kitti", "KITTI"),
    ("--bdd", "BDD100K"),
    ("--cats", "cats"),
];

/// Letter, sets and published value of each comparison of the paper's figure, and of one more. A set is
/// compared with itself by halves.
const COMPARISONS: [(&str, &str, &str, Option<f64>); 7] = [
    ("A", "Sim x KITTI", "Sim x KITTI", None),
    ("B", "Sim", "RO", Some(0.36)),
    ("C", "clean RC", "KITTI", None),
    ("D", "RO x KITTI", "broken RC", None),
    ("E", "Sim x KITTI", "broken RC", None),
    ("F", "KITTI", "cats", Some(2.434)),
    ("KITTI vs BDD100K", "KITTI", "BDD100K", None),
];

/// Comparisons that are claimed to be closer than the last one.
const ORDER: ([&str; 3], &str) = (["B", "D", "E"], "F");

/// An ordering holds in a feature above this probability, and on the whole in so many features.
const SURE: (f64, usize) = (0.95, 4);

/// One comparison of the paper's figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperComparison {
    /// Its letter in the paper's figure, or its name where the figure has it not.
    pub letter: &'static str,
    /// What the paper calls the first set.
    pub a: &'static str,
    /// What the paper calls the second set; the same where halves are compared, whose numbers are among
    /// [`DivergenceReport::floors`].
    pub b: &'static str,
    /// The paper's number, where its text gives one: of unknown feature, bins and estimator.
    pub published: Option<f64>,
    /// Flags of the sets that are missing for it.
    pub missing: Vec<&'static str>,
}

/// Whether one pair of sets is closer than another, by JS.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ordering {
    /// The pair that is claimed to be closer.
    pub closer: [String; 2],
    /// The pair that is claimed to be farther.
    pub farther: [String; 2],
    /// By feature that can be compared.
    pub features: Vec<FeatureOrdering>,
    /// Features in which it holds with a probability above 0.95.
    pub n_holding: usize,
    /// Whether these are four or more.
    pub holds: bool,
}

/// An ordering in one feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureOrdering {
    /// The feature.
    pub feature: Feature,
    /// JS of the pair that is claimed to be closer.
    pub closer: f64,
    /// JS of the other pair.
    pub farther: f64,
    /// Share of bootstrap replicates in which it is; none without replicates.
    pub probability: Option<f64>,
}

/// The paper's experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperExperiment {
    /// `paper`.
    pub experiment: &'static str,
    /// Its comparisons.
    pub comparisons: Vec<PaperComparison>,
    /// Whether B, D and E are closer than F, as far as their sets are there.
    pub orderings: Vec<Ordering>,
    /// Flags of the sets that were not given.
    pub missing: Vec<&'static str>,
    /// The numbers.
    pub report: DivergenceReport,
}

/// The paper's comparisons of those sets that are there, which have the names of [`PAPER_SETS`] and come in
/// their order, and whether simulated and real patterns are closer to each other than KITTI is to cats.
///
/// **Source**: \[Prabhakar2025\], figure of K-L divergences. Its numbers cannot be made again: it names
/// neither feature nor bins nor estimator.
///
/// # Errors
/// As for [`compare_sets`](super::compare_sets).
pub fn paper_experiment(
    sets: &[ImageSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
) -> Result<PaperExperiment, EvalError> {
    let (report, replicates) = compare_with_replicates(sets, reading, settings)?;
    let flags_of = |is_wanted: &dyn Fn(&str) -> bool| -> Vec<&'static str> {
        let is_given = |name: &str| report.sets.iter().any(|set| set.name == name);
        let known = PAPER_SETS.iter();
        let missing = known.filter(|(_, name)| is_wanted(name) && !is_given(name));
        missing.map(|(flag, _)| *flag).collect()
    };
    let comparisons = COMPARISONS.map(|(letter, a, b, published)| PaperComparison {
        letter,
        a,
        b,
        published,
        missing: flags_of(&|name| name == a || name == b),
    });
    let place = |letter: &str| {
        let (_, a, b, _) = COMPARISONS.iter().find(|known| known.0 == letter)?;
        let mut pairs = report.pairs.iter();
        pairs.position(|pair| pair.a == *a && pair.b == *b)
    };
    let orderings = ORDER.0.iter().filter_map(|letter| {
        let places = [place(letter)?, place(ORDER.1)?];
        Some(ordering(&report.pairs, &replicates, places))
    });
    Ok(PaperExperiment {
        experiment: "paper",
        comparisons: comparisons.to_vec(),
        orderings: orderings.collect(),
        missing: flags_of(&|_| true),
        report,
    })
}

/// Whether the pair at the first place is closer than that at the second.
fn ordering(
    pairs: &[PairComparison],
    replicates: &[Vec<Values>],
    [near, far]: [usize; 2],
) -> Ordering {
    let of_feature = |(at, compared): (usize, &_)| {
        let js = |of: &super::FeatureComparison| Some(of.measures.get(&Measure::Js)?.value);
        let held: Vec<bool> = replicates
            .iter()
            .filter_map(|all| Some(all[near][at]?.js < all[far][at]?.js))
            .collect();
        let n_held = held.iter().filter(|held| **held).count();
        Some(FeatureOrdering {
            feature: pairs[near].features[at].feature,
            closer: js(compared)?,
            farther: js(&pairs[far].features[at])?,
            probability: (!held.is_empty()).then(|| share(n_held, held.len())),
        })
    };
    let features = pairs[near].features.iter().enumerate();
    let features: Vec<FeatureOrdering> = features.filter_map(of_feature).collect();
    let is_sure = |of: &&FeatureOrdering| of.probability.is_some_and(|p| p > SURE.0);
    let n_holding = features.iter().filter(is_sure).count();
    let names = |pair: &PairComparison| [pair.a.clone(), pair.b.clone()];
    Ordering {
        closer: names(&pairs[near]),
        farther: names(&pairs[far]),
        features,
        n_holding,
        holds: n_holding >= SURE.1,
    }
}
