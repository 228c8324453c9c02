//! The paper's experiment on K-L divergences, with sets that the user supplies.

use serde::Serialize;

use super::compare::{OrderingClaim, compare_sets};
use super::report::{CompareSettings, DivergenceReport};
use super::sets::{ImageSet, ReadSettings};
use crate::EvalError;

/// What a set is in the paper's experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PaperRole {
    /// Simulated crack patterns on black.
    Simulated,
    /// Real crack patterns collected online.
    RealOverlays,
    /// Simulated patterns over KITTI.
    SimulatedKitti,
    /// Real patterns over KITTI.
    OverlaysKitti,
    /// The road through broken glass.
    RoadBroken,
    /// The road through whole glass.
    RoadClean,
    /// KITTI.
    Kitti,
    /// BDD100K, which the paper does not have here: a second driving set.
    Bdd,
    /// Cats, the control.
    Cats,
}

impl PaperRole {
    /// All of them, in the order of the comparisons.
    pub const ALL: [Self; 9] = [
        Self::Simulated,
        Self::RealOverlays,
        Self::SimulatedKitti,
        Self::OverlaysKitti,
        Self::RoadBroken,
        Self::RoadClean,
        Self::Kitti,
        Self::Bdd,
        Self::Cats,
    ];

    /// What the paper's figure calls it.
    #[must_use]
    pub const fn paper_name(self) -> &'static str {
        match self {
            Self::Simulated => "Sim",
            Self::RealOverlays => "RO",
            Self::SimulatedKitti => "Sim x KITTI",
            Self::OverlaysKitti => "RO x KITTI",
            Self::RoadBroken => "broken RC",
            Self::RoadClean => "clean RC",
            Self::Kitti => "KITTI",
            Self::Bdd => "BDD100K",
            Self::Cats => "cats",
        }
    }

    /// The flag that names it.
    #[must_use]
    pub const fn flag(self) -> &'static str {
        match self {
            Self::Simulated => "--simulated",
            Self::RealOverlays => "--real-overlays",
            Self::SimulatedKitti => "--simulated-kitti",
            Self::OverlaysKitti => "--overlays-kitti",
            Self::RoadBroken => "--road-broken",
            Self::RoadClean => "--road-clean",
            Self::Kitti => "--kitti",
            Self::Bdd => "--bdd",
            Self::Cats => "--cats",
        }
    }
}

/// Letter, sets and published value of each comparison of the paper's figure, and of one more.
/// Sets of different kinds of the same role are compared by halves.
const COMPARISONS: [(&str, PaperRole, PaperRole, Option<f64>); 7] = [
    (
        "A",
        PaperRole::SimulatedKitti,
        PaperRole::SimulatedKitti,
        None,
    ),
    (
        "B",
        PaperRole::Simulated,
        PaperRole::RealOverlays,
        Some(0.36),
    ),
    ("C", PaperRole::RoadClean, PaperRole::Kitti, None),
    ("D", PaperRole::OverlaysKitti, PaperRole::RoadBroken, None),
    ("E", PaperRole::SimulatedKitti, PaperRole::RoadBroken, None),
    ("F", PaperRole::Kitti, PaperRole::Cats, Some(2.434)),
    ("KITTI vs BDD100K", PaperRole::Kitti, PaperRole::Bdd, None),
];

/// Comparisons that are claimed to be closer than F.
const CLOSER_THAN_F: [&str; 3] = ["B", "D", "E"];

/// One comparison of the paper's figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperComparison {
    /// Its letter in the paper's figure, or its name where the figure has it not.
    pub letter: &'static str,
    /// What the paper calls the first set.
    pub a: &'static str,
    /// What the paper calls the second set.
    pub b: &'static str,
    /// The paper's number, where its text gives one: of unknown feature, bins and estimator.
    pub published: Option<f64>,
    /// Place of the pair in [`DivergenceReport::pairs`].
    pub pair: Option<usize>,
    /// Place of the set in [`DivergenceReport::floors`], where a set is compared with itself by halves.
    pub floor: Option<usize>,
    /// Flags of the sets that are missing for it.
    pub missing: Vec<&'static str>,
}

/// The paper's experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperExperiment {
    /// Its comparisons.
    pub comparisons: Vec<PaperComparison>,
    /// Flags of the sets that were not given.
    pub missing: Vec<&'static str>,
    /// The numbers.
    pub report: DivergenceReport,
}

/// The paper's comparisons of those sets that are there, and whether simulated and real patterns are
/// closer to each other than KITTI is to cats ([`DivergenceReport::orderings`]).
///
/// **Source**: \[Prabhakar2025\], figure of K-L divergences. Its numbers cannot be made again: it names
/// neither feature nor bins nor estimator.
///
/// # Errors
/// As for [`compare_sets`].
pub fn paper_experiment(
    given: &[(PaperRole, ImageSet)],
    reading: &ReadSettings,
    settings: &CompareSettings,
) -> Result<PaperExperiment, EvalError> {
    let mut given = given.to_vec();
    given.sort_by_key(|(role, _)| *role);
    given.dedup_by_key(|(role, _)| *role);
    let (roles, sets): (Vec<PaperRole>, Vec<ImageSet>) = given.into_iter().unzip();
    let place = |role: PaperRole| roles.iter().position(|known| *known == role);
    let sets_of = |letter: &str| -> Option<[usize; 2]> {
        let (_, a, b, _) = COMPARISONS.into_iter().find(|known| known.0 == letter)?;
        Some([place(a)?, place(b)?])
    };
    let claims: Vec<OrderingClaim> = CLOSER_THAN_F
        .iter()
        .filter_map(|letter| {
            let (closer, farther) = sets_of(letter).zip(sets_of("F"))?;
            Some(OrderingClaim { closer, farther })
        })
        .collect();
    let report = compare_sets(&sets, reading, settings, &claims)?;
    let comparisons = COMPARISONS
        .into_iter()
        .map(|(letter, a, b, published)| {
            let name = |role| place(role).and_then(|at| sets.get(at)).map(ImageSet::name);
            let names = name(a).zip(name(b));
            let mut missing = Vec::new();
            for role in [a, b] {
                if place(role).is_none() && !missing.contains(&role.flag()) {
                    missing.push(role.flag());
                }
            }
            PaperComparison {
                letter,
                a: a.paper_name(),
                b: b.paper_name(),
                published,
                pair: names.and_then(|(a, b)| {
                    report
                        .pairs
                        .iter()
                        .position(|pair| pair.a == a && pair.b == b)
                }),
                floor: names
                    .filter(|_| a == b)
                    .and_then(|(a, _)| report.floors.iter().position(|floor| floor.set == a)),
                missing,
            }
        })
        .collect();
    let missing = PaperRole::ALL
        .into_iter()
        .filter(|role| place(*role).is_none());
    Ok(PaperExperiment {
        comparisons,
        missing: missing.map(PaperRole::flag).collect(),
        report,
    })
}
