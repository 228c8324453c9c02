//! The crack network: a planar straight-line graph with a history. The contract between
//! whoever breaks glass and whoever looks at it.

mod contact;
mod invariants;
mod svg;

use serde::{Deserialize, Serialize};

use crate::{Impact, LengthUnit, Pane, PaneError, Seed};

pub use contact::{Contact, ContactKind, find_contacts, find_contacts_of};

/// Name and version of the file format, the value of its `schema` key.
pub const NETWORK_SCHEMA: &str = "starbreak.crack-network/1";

/// Most nodes that a network may have: node ids fit in 32 bits with room for splitting.
pub const MAX_NODES: usize = 1 << 30;

/// Who wrote a network.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generator {
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// Which fracture model made the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// The paper's stress propagation.
    Paper,
    /// Contact, plate stress and traced crack tips.
    Physics,
    /// Traced by hand or made elsewhere.
    Imported,
}

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
    /// The paper's "stress", in units of its force F: for `propagated` what the hop handed on to
    /// `to`, for `mst` the sum σ that `to` accumulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_paper_units: Option<Vec<f64>>,
    /// Stress that drove the tip, MPa.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_mpa: Option<Vec<f64>>,
    /// Crack opening displacement, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_um: Option<Vec<f64>>,
    /// Depth of the crack over the thickness of the pane, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_fraction: Option<Vec<f64>>,
}

impl Segments {
    /// The column of arrival times, in whichever unit the model keeps them.
    #[must_use]
    pub fn arrival(&self) -> Option<&[f64]> {
        self.arrival_step.as_deref().or(self.arrival_us.as_deref())
    }
}

/// Key figures of a network, computed from it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Cracks that leave an impact: `propagated` and `radial` segments that start at one.
    pub n_radial: usize,
    /// Segments in all.
    pub n_segments: usize,
    /// Sum of the segments' lengths, in the network's length unit.
    pub total_length: f64,
}

/// Everything that a network says, before it has been checked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NetworkData {
    /// [`NETWORK_SCHEMA`].
    pub schema: String,
    /// Who wrote it.
    pub generator: Generator,
    /// Which model made it.
    pub model: Model,
    /// The seed it is reproducible from; absent for imported networks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<Seed>,
    /// Unit of every position and length here.
    pub unit: LengthUnit,
    /// The sheet of glass.
    pub pane: Pane,
    /// Name of the damage class, where the model names one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage_class: Option<String>,
    /// The hits.
    pub impacts: Vec<Impact>,
    /// Ends of segments.
    pub nodes: Nodes,
    /// Straight pieces of crack.
    pub segments: Segments,
    /// Key figures; written for the reader, recomputed when read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub summary: Option<Summary>,
}

/// A crack network that holds what [`CrackNetwork::check_invariants`] says.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackNetwork {
    data: NetworkData,
    summary: Summary,
}

/// Why something is not a crack network.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// Not JSON, or not of this shape.
    #[error("not a crack network: {0}")]
    Parse(#[from] serde_json::Error),
    /// Another format or version.
    #[error("schema = {found:?}; this version reads {NETWORK_SCHEMA:?}")]
    Schema {
        /// What the file says.
        found: String,
    },
    /// The pane has no area.
    #[error(transparent)]
    Pane(#[from] PaneError),
    /// Two columns that belong together differ in length.
    #[error("column `{column}` has {found} entries; expected {expected}")]
    ColumnLength {
        /// Name of the column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the others.
        expected: usize,
    },
    /// A number that is not finite, or not in its range.
    #[error("{column}[{index}] = {value}; expected {expected}")]
    Value {
        /// Name of the column.
        column: &'static str,
        /// Which entry.
        index: usize,
        /// What it holds.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// An index that points nowhere.
    #[error("segments.{column}[{segment}] = {index}, but there are only {count} {what}")]
    Index {
        /// Name of the column.
        column: &'static str,
        /// Which segment.
        segment: usize,
        /// What it points to.
        index: u32,
        /// How many there are.
        count: usize,
        /// Of what.
        what: &'static str,
    },
    /// A node or an impact that lies off the pane.
    #[error("{what} {index} at ({x}, {y}) lies outside the pane of {width} × {height}")]
    OffPane {
        /// `node` or `impact`.
        what: &'static str,
        /// Which one.
        index: usize,
        /// Its position.
        x: f64,
        /// Its position.
        y: f64,
        /// Width of the pane.
        width: f64,
        /// Height of the pane.
        height: f64,
    },
    /// A segment from a node to itself, or between two nodes at one place.
    #[error("segment {segment} has no length")]
    ZeroLength {
        /// Which segment.
        segment: usize,
    },
    /// Two segments between the same two nodes.
    #[error("segments {first} and {second} join the same two nodes")]
    Duplicate {
        /// The earlier one.
        first: usize,
        /// The later one.
        second: usize,
    },
    /// Two segments meet where neither has a node, or one ends in the middle of another.
    #[error("segments {first} and {second} {how}; split them at a common node")]
    NotPlanar {
        /// The earlier one.
        first: u32,
        /// The later one.
        second: u32,
        /// In which way they meet.
        how: &'static str,
    },
    /// A segment that arrives before the one it grew out of, or is its own ancestor.
    #[error(
        "segment {segment} arrives at {arrival}, before its parent {parent} at {parent_arrival}"
    )]
    ArrivalBeforeParent {
        /// Which segment.
        segment: usize,
        /// Its arrival.
        arrival: f64,
        /// Its parent.
        parent: u32,
        /// The parent's arrival.
        parent_arrival: f64,
    },
    /// A parent that does not end where the child starts, or a chain of parents without end.
    #[error("segment {segment} cannot grow out of segment {parent}: {why}")]
    Parent {
        /// Which segment.
        segment: usize,
        /// Its parent.
        parent: u32,
        /// What is wrong with it.
        why: &'static str,
    },
}

impl CrackNetwork {
    /// A network from its parts, checked in full.
    ///
    /// # Errors
    /// [`NetworkError`] naming the first invariant that does not hold and where.
    pub fn new(data: NetworkData) -> Result<Self, NetworkError> {
        let network = Self::from_planar(data)?;
        network.check_planar()?;
        Ok(network)
    }

    /// A network whose segments the caller has already made to meet only at nodes.
    ///
    /// Everything but planarity is checked, in linear time; use [`CrackNetwork::new`] for what
    /// comes from outside.
    ///
    /// # Errors
    /// [`NetworkError`] as for [`CrackNetwork::new`], except `NotPlanar`.
    pub fn from_planar(mut data: NetworkData) -> Result<Self, NetworkError> {
        invariants::check_columns(&data)?;
        let summary = invariants::summarize(&data);
        data.summary = Some(summary);
        Ok(Self { data, summary })
    }

    /// A network from the text of its JSON file, checked in full.
    ///
    /// # Errors
    /// [`NetworkError`] naming what is wrong and where.
    pub fn from_json(text: &str) -> Result<Self, NetworkError> {
        Self::new(serde_json::from_str(text)?)
    }

    /// The JSON file: one line, columnar, the same bytes for the same network.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain numbers, strings and lists, every number finite: this cannot fail.
        let mut text = serde_json::to_string(&self.data).unwrap_or_default();
        text.push('\n');
        text
    }

    /// Walks every invariant once more: columns of one length, finite numbers, nodes and
    /// impacts on the pane, no zero-length and no duplicate segment, parents that end where
    /// their child starts and arrive no later than it, and planarity: two segments meet only
    /// at a node that both have.
    ///
    /// # Errors
    /// [`NetworkError`] naming the first one that does not hold and where.
    pub fn check_invariants(&self) -> Result<(), NetworkError> {
        invariants::check_columns(&self.data)?;
        self.check_planar()
    }

    fn check_planar(&self) -> Result<(), NetworkError> {
        match find_contacts(
            &self.data.nodes,
            &self.data.segments.from,
            &self.data.segments.to,
        )
        .first()
        {
            None => Ok(()),
            Some(contact) => Err(NetworkError::NotPlanar {
                first: contact.first,
                second: contact.second,
                how: contact.kind.description(),
            }),
        }
    }

    /// Everything that the network says.
    #[must_use]
    pub fn data(&self) -> &NetworkData {
        &self.data
    }

    /// Its key figures.
    #[must_use]
    pub fn summary(&self) -> Summary {
        self.summary
    }

    /// Number of segments.
    #[must_use]
    pub fn n_segments(&self) -> usize {
        self.data.segments.from.len()
    }

    /// The ends `[x0, y0, x1, y1]` of segment `segment_idx`, from where it came to where it went.
    ///
    /// # Panics
    /// If there is no such segment.
    #[must_use]
    pub fn ends(&self, segment_idx: usize) -> [f64; 4] {
        let Segments { from, to, .. } = &self.data.segments;
        let Nodes { x, y } = &self.data.nodes;
        let (a, b) = (from[segment_idx] as usize, to[segment_idx] as usize);
        [x[a], y[a], x[b], y[b]]
    }

    /// Time of the last arrival, 0 where the network keeps no times.
    #[must_use]
    pub fn last_arrival(&self) -> f64 {
        self.data
            .segments
            .arrival()
            .map_or(0.0, |times| times.iter().copied().fold(0.0, f64::max))
    }

    /// The segments as far as they have grown at `time` (same unit as the arrival column):
    /// index and ends `[x0, y0, x1, y1]`, the last one up to the tip.
    ///
    /// A tip moves evenly from its parent's arrival to its own; from time 0 where it starts at
    /// an impact. A crack that starts elsewhere appears whole at its arrival. Networks without
    /// times are always full-grown.
    pub fn grown_at(&self, time: f64) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        let segments = &self.data.segments;
        let arrival = segments.arrival();
        let start_of = move |idx: usize, times: &[f64]| -> f64 {
            if let Some(parent) = segments.parent.as_ref().and_then(|column| column[idx]) {
                return times[parent as usize];
            }
            let [x, y, ..] = self.ends(idx);
            #[expect(
                clippy::float_cmp,
                reason = "an impact is a node when it is the very same point"
            )]
            let at_impact = self
                .data
                .impacts
                .iter()
                .any(|impact| impact.x == x && impact.y == y);
            if at_impact { 0.0 } else { times[idx] }
        };
        (0..self.n_segments()).filter_map(move |idx| {
            let [x0, y0, x1, y1] = self.ends(idx);
            let Some(times) = arrival else {
                return Some((idx, [x0, y0, x1, y1]));
            };
            if time >= times[idx] {
                return Some((idx, [x0, y0, x1, y1]));
            }
            let start = start_of(idx, times);
            if time <= start {
                return None;
            }
            let grown = (time - start) / (times[idx] - start);
            Some((
                idx,
                [x0, y0, x0 + (x1 - x0) * grown, y0 + (y1 - y0) * grown],
            ))
        })
    }
}
