//! What the glass shows where it is broken: facets of the frame, and the light that each sends.
//!
//! A crack is a mirror within the glass. Seen from the camera it is a quadrilateral: its trace on
//! one face of the sheet, swept by the parallax of refraction to its trace at its depth. What it
//! shows is the environment mirrored in it, see [`lobe`]. Crushed glass, chips and films of air
//! are small patches of other surfaces.

mod chains;
mod cone;
mod cracks;
mod divided;
mod drawn_drop;
mod drops;
mod glimpse;
mod grains;
mod hit;
mod kept_drops;
mod lobe;
mod params;
mod rays;
mod relief;
mod roughness;
mod runs;
mod seen_at;
mod sheet;
mod small_drop;
mod strip;
mod walk;
mod walls;
mod water;
mod wedge;

pub(crate) use cracks::{Facets, crack_facets};
pub(crate) use drops::Drops;
pub use drops::LEAST_DROP_PX;
pub(crate) use hit::hit_facets;
pub use kept_drops::KeptDrops;
pub(crate) use kept_drops::SeenBy;
pub(crate) use lobe::{
    CABIN_HIGH, CABIN_LOW, FRAME, FRAME_U, FRAME_V, GROUND, HELD, HORIZON, LANES, LightFrom,
    N_SHARES, SQUARE, SUN, WIDTH, ZENITH,
};
pub use params::{Glass, SurfaceParams};
pub(crate) use sheet::SheetView;
pub(crate) use wedge::fragment_facets;
