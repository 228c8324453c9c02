//! The nouns of starbreak: [`Material`], [`Pane`], [`Impact`] and, above all, the
//! [`CrackNetwork`], the one thing that the physics hands to the optics.
//!
//! What it is not: it solves nothing, draws no random number, touches no file and no pixel.
//! A crack network that was traced by hand, imported from JSON or made by another solver
//! is as good as one of ours, once it passes [`CrackNetwork::new`].
//!
//! # Example
//! ```
//! use starbreak_glass::{CrackNetwork, NetworkData};
//!
//! let json = r#"{"schema":"starbreak.crack-network/1",
//!   "generator":{"name":"by hand","version":"1"}, "model":"imported", "unit":"px",
//!   "pane":{"width":100.0,"height":50.0}, "impacts":[{"x":50.0,"y":25.0}],
//!   "nodes":{"x":[50.0,90.0],"y":[25.0,30.0]},
//!   "segments":{"from":[0],"to":[1],"kind":["radial"]}}"#;
//! let network = CrackNetwork::from_json(json)?;
//! assert_eq!(network.summary().n_segments, 1);
//! # Ok::<(), starbreak_glass::NetworkError>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod crack_network;
mod impact;
mod material;
mod pane;

pub use crack_network::{
    Contact, ContactKind, CrackNetwork, Face, Fragment, Generator, MAX_IMPACTS, MAX_NODES, Model,
    NETWORK_SCHEMA, NetworkData, NetworkError, Nodes, SegmentKind, Segments, Summary, Zone,
    find_contacts, find_contacts_of, find_contacts_up_to,
};
pub use impact::Impact;
pub use material::{Material, MaterialError, Property};
pub use pane::{GlassKind, LengthUnit, Pane, PaneError};
