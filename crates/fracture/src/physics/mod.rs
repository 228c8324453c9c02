//! The physics tier: contact, plate stress, and crack tips traced through it.

mod chords;
mod cone_trace;
mod fallen;
mod front;
mod heavy;
mod impact;
mod kept;
mod legs;
mod long_crack;
mod network;
mod outcome;
mod plate;
mod radials;
mod rings;
mod sectors;
mod shadow;
mod simulate;
mod surface;
mod windows;

pub use crate::mesh::MeshResolution;
pub use crate::params::{
    Dicing, GlassBuild, GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad,
    PhysicsParams, StoneImpact, Support,
};
pub use network::network_pane;
pub use outcome::{Broken, DamageClass, ImpactReport, LongCrackReport, Stage};
pub use radials::mean_radial_count;
pub use simulate::{MAX_IMPACTS, simulate};
