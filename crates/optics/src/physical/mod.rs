//! The physical optics: mirrors, glints and crushed glass through a real lens, in linear light.
//!
//! [`render`] does it all for one image. For many images before one crack, [`bake`] once, give the
//! [`Pattern`] the light of an [`Environment`](crate::environment::Environment), and
//! [apply](Overlay::apply) the [`Overlay`] to each. docs/theory/optics.md has the equations, what
//! they were checked against, and their limits.

mod defocus;
mod elsewhere;
mod frames;
mod layer;
mod light;
mod noise;
mod overlay;
mod packed;
mod params;
mod pattern;
mod render;
mod samples;

pub use crate::surface::{Glass, KeptDrops, LEAST_DROP_PX, SurfaceParams};
pub(crate) use defocus::{Beyond, defocus_rows, spread_evenly};
pub(crate) use elsewhere::{FINE_WIDTHS, exponent_up};
pub use frames::Gathered;
pub(crate) use layer::PatternLayer;
pub(crate) use light::{Colors, Lighting};
pub(crate) use overlay::{LEAST_ELSEWHERE, OverlayLayer};
pub use overlay::{OpticalMaps, Overlay};
pub use packed::PackedPattern;
pub use params::{PhysicalOptics, SensorNoise};
pub(crate) use pattern::{Outline, code_mask};
pub use pattern::{Pattern, bake};
pub use render::{Rendered, render};
