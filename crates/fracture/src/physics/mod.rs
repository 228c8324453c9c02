//! The physics tier: contact, plate stress, and crack tips traced through it.

mod params;

pub use params::{
    Dicing, GlassBuild, GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad,
    MeshResolution, PhysicsParams, StoneImpact, Support,
};
