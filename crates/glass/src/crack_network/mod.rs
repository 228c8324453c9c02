//! The crack network: a planar straight-line graph with a history. The contract between
//! whoever breaks glass and whoever looks at it.

mod columns;
mod contact;
mod error;
mod fragments;
mod graph;
mod growth;
mod invariants;
mod rim;
mod strips;
mod summary;
mod svg;

use serde::{Deserialize, Serialize};
use starbreak_seed::Seed;

use crate::{Impact, LengthUnit, Pane};

pub use columns::{Face, Nodes, SegmentKind, Segments, Zone};
pub use contact::{Contact, ContactKind, find_contacts, find_contacts_of, find_contacts_up_to};
pub use error::NetworkError;
pub use fragments::Fragment;
pub use summary::Summary;

/// Name and version of the file format, the value of its `schema` key.
pub const NETWORK_SCHEMA: &str = "starbreak.crack-network/1";

/// Most nodes that a network may have: node ids fit in 32 bits with room for splitting.
pub const MAX_NODES: usize = 1 << 30;

/// Most impacts that a network may have: the glass around each is drawn by itself.
pub const MAX_IMPACTS: usize = 1000;

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
    /// A point in each fragment that fell out of the pane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallen: Vec<[f64; 2]>,
    /// Key figures; recomputed from the rest, save for the energies, which are taken from here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub summary: Option<Summary>,
}

/// A crack network that holds what [`CrackNetwork::check_invariants`] says.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackNetwork {
    data: NetworkData,
    summary: Summary,
}

impl CrackNetwork {
    /// A network from its parts, checked in full.
    ///
    /// # Errors
    /// [`NetworkError`] naming the first invariant that does not hold and where.
    pub fn new(data: NetworkData) -> Result<Self, NetworkError> {
        invariants::check_columns(&data)?;
        check_planar(&data)?;
        Ok(Self::summed_up(data))
    }

    /// A network whose segments the caller has already made to meet only at nodes.
    ///
    /// Everything but planarity is checked, in linear time (but for the count of fragments,
    /// which is not of the paper's model); use [`CrackNetwork::new`] for what
    /// comes from outside.
    ///
    /// # Errors
    /// [`NetworkError`] as for [`CrackNetwork::new`], except `NotPlanar`.
    pub fn from_planar(data: NetworkData) -> Result<Self, NetworkError> {
        invariants::check_columns(&data)?;
        Ok(Self::summed_up(data))
    }

    /// No cracks in a frame of `width_px × height_px` pixels: what stands for cracks that are known
    /// by their looks alone.
    #[must_use]
    pub fn without_cracks(width_px: u32, height_px: u32) -> Self {
        Self::summed_up(NetworkData {
            schema: NETWORK_SCHEMA.to_owned(),
            generator: Generator {
                name: "starbreak".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            },
            model: Model::Imported,
            seed: None,
            unit: LengthUnit::Px,
            pane: Pane::from_frame_px(width_px, height_px),
            damage_class: None,
            impacts: Vec::new(),
            nodes: Nodes::default(),
            segments: Segments::default(),
            fallen: Vec::new(),
            summary: None,
        })
    }

    fn summed_up(mut data: NetworkData) -> Self {
        let summary = summary::summarize(&data);
        data.summary = Some(summary);
        Self { data, summary }
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
        check_planar(&self.data)
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
}

/// Contacts up to which the first one is named.
const MAX_CONTACTS: usize = 1 << 22;

fn check_planar(data: &NetworkData) -> Result<(), NetworkError> {
    let Segments { from, to, .. } = &data.segments;
    let contacts = find_contacts_up_to(&data.nodes, from, to, MAX_CONTACTS);
    match contacts.as_deref().map(<[Contact]>::first) {
        None => Err(NetworkError::Crowded {
            n_segments: from.len(),
        }),
        Some(None) => Ok(()),
        Some(Some(contact)) => Err(NetworkError::NotPlanar {
            first: contact.first,
            second: contact.second,
            how: contact.kind.description(),
        }),
    }
}
