//! What came of a hit, by construction and not by a look at the picture.

use starbreak_glass::CrackNetwork;

use crate::params::StoneImpact;

/// Damage class of one hit, after the windscreen repair trade \[ROLAGS\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DamageClass {
    /// Nothing is left of the hit.
    Intact,
    /// Crushed glass, with or without a shallow ring around it.
    Pit,
    /// A cone that closes around the contact, no legs.
    Bullseye,
    /// A cone on one side of the contact, no legs.
    HalfMoon,
    /// Legs that end in the glass, no cone.
    Star,
    /// Cone and legs.
    Combination,
    /// A leg longer than 152 mm that ends in the glass.
    LongCrack,
    /// Legs that reach the rim.
    RimToImpact,
    /// The whole pane is in pieces.
    Diced,
    /// The pane was in pieces before.
    AlreadyDiced,
}

impl DamageClass {
    /// Its place in the order of harm, from none to all.
    #[must_use]
    pub fn rank(self) -> u8 {
        match self {
            Self::Intact | Self::AlreadyDiced => 0,
            Self::Pit => 1,
            Self::HalfMoon => 2,
            Self::Bullseye => 3,
            Self::Star => 4,
            Self::Combination => 5,
            Self::LongCrack => 6,
            Self::RimToImpact => 7,
            Self::Diced => 8,
        }
    }

    /// The word that stands in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Intact => "intact",
            Self::Pit => "pit",
            Self::Bullseye => "bullseye",
            Self::HalfMoon => "half-moon",
            Self::Star => "star",
            Self::Combination => "combination",
            Self::LongCrack => "long-crack",
            Self::RimToImpact => "rim-to-impact",
            Self::Diced => "diced",
            Self::AlreadyDiced => "already-diced",
        }
    }
}

/// What one hit did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpactReport {
    /// Where, m.
    pub position_m: [f64; 2],
    /// When, s after the first hit.
    pub time_s: f64,
    /// Damage class.
    pub damage: DamageClass,
    /// Kinetic energy of the stone, J.
    pub kinetic_energy_j: f64,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Duration of the contact, s.
    pub contact_time_s: f64,
    /// Radius of the contact at the largest force, m.
    pub contact_radius_m: f64,
    /// Radius of the crushed zone, m.
    pub crushed_radius_m: f64,
    /// Radial cracks that this hit made.
    pub n_arms: usize,
    /// Those of them that reach at least 0.3 of the farthest, or fork.
    pub n_legs: usize,
    /// Distance of the farthest crack tip from the hit, m.
    pub reach_m: f64,
    /// Elastic energy that cracks could use, J.
    pub available_j: f64,
    /// Energy that went into new surface, J.
    pub dissipated_j: f64,
}

impl ImpactReport {
    /// That of a stone that meets no glass.
    pub(super) fn of_nothing(stone: &StoneImpact, time_s: f64) -> Self {
        Self {
            position_m: stone.position_m,
            time_s,
            damage: DamageClass::Intact,
            kinetic_energy_j: stone.kinetic_energy_j(),
            peak_force_n: 0.0,
            contact_time_s: 0.0,
            contact_radius_m: 0.0,
            crushed_radius_m: 0.0,
            n_arms: 0,
            n_legs: 0,
            reach_m: 0.0,
            available_j: 0.0,
            dissipated_j: 0.0,
        }
    }

    /// The class of the hit that did most.
    pub(super) fn worst(reports: &[Self]) -> Option<&'static str> {
        let rank = |report: &&Self| (report.damage.rank(), report.reach_m.to_bits());
        let worst = reports.iter().max_by_key(rank);
        worst.map(|report| report.damage.name())
    }
}

/// What became of the cracks that stress in the plane drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongCrackReport {
    /// Name of the class: `long-crack`, `edge-crack`, `floater-crack` or `stress-crack`; where the
    /// cracks of all hits went on that of the worst hit; `intact` where the load opens no flaw.
    pub class: &'static str,
    /// Length of the path, forks included, m.
    pub length_m: f64,
    /// K of the flaw over `K_IC`.
    pub flaw_k_ratio: f64,
    /// Elastic energy of the load, J.
    pub available_j: f64,
    /// Energy that went into new surface, J.
    pub dissipated_j: f64,
}

/// A broken pane.
#[derive(Debug, Clone)]
pub struct Broken {
    /// The cracks, in mm.
    pub network: CrackNetwork,
    /// The hits, in their order.
    pub impacts: Vec<ImpactReport>,
    /// The long crack, if one was asked for.
    pub long_crack: Option<LongCrackReport>,
    /// How often the plate's stress was needed under a load; it may be known from a pane before.
    pub n_solutions: usize,
    /// Nodes of the largest mesh.
    pub n_mesh_nodes: usize,
}

impl Broken {
    /// Whether nothing broke.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.network.n_segments() == 0
    }
}

/// Stages of the simulation, for whoever keeps the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Contact of stone and glass.
    Contact,
    /// Mesh, factorization and solution of the plate.
    Stress,
    /// Crack tips.
    Tips,
    /// Rings between radials, their stress included.
    Rings,
    /// Dice of tempered glass.
    Dice,
    /// Cracks under stress in the plane.
    LongCrack,
    /// Planar network, its order in time and its surfaces.
    Network,
}
