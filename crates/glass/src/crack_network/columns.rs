//! The columns of a network: nodes and segments.

use serde::{Deserialize, Serialize};

/// What a segment is a part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SegmentKind {
    /// Hop of the paper's stress propagation.
    Propagated,
    /// Edge of the paper's minimum spanning tree.
    Mst,
    /// Radial crack.
    Radial,
    /// Branch of a forked crack.
    Fork,
    /// Ring crack between two radials.
    Ring,
    /// Trace of a Hertzian cone.
    Cone,
    /// Crack from the rim of the pane.
    Edge,
    /// Side of a dice of tempered glass.
    Dice,
}

impl SegmentKind {
    /// All kinds, in their order.
    pub const ALL: [Self; 8] = [
        Self::Propagated,
        Self::Mst,
        Self::Radial,
        Self::Fork,
        Self::Ring,
        Self::Cone,
        Self::Edge,
        Self::Dice,
    ];

    /// The word that stands in the file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Propagated => "propagated",
            Self::Mst => "mst",
            Self::Radial => "radial",
            Self::Fork => "fork",
            Self::Ring => "ring",
            Self::Cone => "cone",
            Self::Edge => "edge",
            Self::Dice => "dice",
        }
    }
}

/// What the surface of a crack looks like, by how hard its tip was driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Zone {
    /// Smooth.
    Mirror,
    /// Dull.
    Mist,
    /// Rough and streaky.
    Hackle,
}

impl Zone {
    /// The word that stands in the file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mirror => "mirror",
            Self::Mist => "mist",
            Self::Hackle => "hackle",
        }
    }
}

/// A face of a ply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Face {
    /// The one towards the side of the pane that was hit.
    Outer,
    /// The other one.
    Inner,
}

impl Face {
    /// The word that stands in the file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Outer => "outer",
            Self::Inner => "inner",
        }
    }
}

/// Columns of the nodes, all of one length.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Nodes {
    /// x in the network's length unit.
    pub x: Vec<f64>,
    /// y in the network's length unit, down.
    pub y: Vec<f64>,
}

/// Columns of the segments, all of one length. A column that a model does not produce is absent.
///
/// The names carry the file's units; this is an interchange type.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Segments {
    /// Node that the crack came from.
    pub from: Vec<u32>,
    /// Node that it reached.
    pub to: Vec<u32>,
    /// What the segment is a part of.
    pub kind: Vec<SegmentKind>,
    /// Segment that this one grew out of; `null` where it starts a crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<Vec<Option<u32>>>,
    /// Time at which the tip reaches `to`, in the paper's steps δt since the impact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrival_step: Option<Vec<f64>>,
    /// Time at which the tip reaches `to`, µs since the impact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrival_us: Option<Vec<f64>>,
    /// Time at which the tip leaves `from`, µs since the impact: no later than its arrival and
    /// no earlier than its parent's. Beside `arrival_us` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure_us: Option<Vec<f64>>,
    /// The paper's "stress", in units of its force F: for `propagated` what the hop handed on to
    /// `to`, for `mst` the sum σ that `to` accumulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_paper_units: Option<Vec<f64>>,
    /// Stress that drove the tip, MPa.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_mpa: Option<Vec<f64>>,
    /// Crack opening displacement at the face that the crack begins at, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_um: Option<Vec<f64>>,
    /// Depth of the crack over the thickness of its ply, 0 to 1: the mean over the segment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_fraction: Option<Vec<f64>>,
    /// The same at `from` and at `to`: points of the crack's front.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_ends: Option<Vec<[f64; 2]>>,
    /// Face of its ply that the crack begins at; the outer one where the column is absent. The
    /// segment is its trace there, but for `cone`, whose trace is its lower edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<Vec<Face>>,
    /// Zone of the crack's surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<Vec<Zone>>,
    /// RMS roughness of the crack's surface, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roughness_um: Option<Vec<f64>>,
    /// Angle between the crack's surface and the normal of the pane, degrees, between -90 and
    /// 90. Positive: going from the face that was hit into the glass, the surface leans to the
    /// left of a walk from `from` to `to`, as seen in the network's plane (x to the right, y
    /// down).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_deg: Option<Vec<f64>>,
    /// The same at `from` and at `to`, at the face that the crack begins at; what lies deeper leans
    /// as the tip did when the front passed there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_ends_deg: Option<Vec<[f64; 2]>>,
    /// Which ply of a laminate; 0 is the one that was hit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ply: Option<Vec<u8>>,
    /// Stress intensity over fracture toughness, `K/K_IC`, when the tip passed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k_ratio: Option<Vec<f64>>,
}

impl Segments {
    /// The column of arrival times, in whichever unit the model keeps them.
    #[must_use]
    pub fn arrival(&self) -> Option<&[f64]> {
        self.arrival_step.as_deref().or(self.arrival_us.as_deref())
    }

    /// Departure times in the unit of [`Segments::arrival`], where they are kept.
    #[must_use]
    pub fn departure(&self) -> Option<&[f64]> {
        match self.arrival_step {
            Some(_) => None,
            None => self.departure_us.as_deref(),
        }
    }
}
