//! A photograph of broken glass in the place of a simulated crack.
//!
//! A [`Photo`] says of each of its pixels how much of the light behind it the glass takes away,
//! the *opacity* a, and which light it sends instead, c, both per color and linear. Over a scene
//! I₀, glass that is lit by white light W shows
//!
//! I = I₀ (1 − a) + W c
//!
//! What a and c are depends on the [`Background`] before which the glass was photographed. A
//! [`Placement`] says which part of the photograph fills the frame. Then, as for any other crack:
//!
//! - [`draw`] makes of it the [`Coverage`](crate::Coverage) that the paper's
//!   [`composite`](crate::paper::composite) takes;
//! - [`bake`] spreads it by the disc that the lens makes of the glass, and the [`PhotoPattern`]
//!   gets the light of an environment and becomes an [`Overlay`](crate::physical::Overlay).
//!
//! # Limits
//! One photograph tells neither where the light in it came from nor what it would show before
//! another scene: it does not mirror, and it does not bend the scene behind it. Opacity and light
//! are those of the camera that took it, so a photograph with a blur of its own is blurred twice.

mod background;
mod baked;
mod picture;
mod placement;
mod raster;

pub use background::Background;
pub use baked::{PhotoPattern, bake, check_gain, covered_share, draw};
pub use picture::{Photo, PhotoParams};
pub use placement::{Placement, PlacementRange};
