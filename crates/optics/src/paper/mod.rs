//! The paper's visualization: E(L_r), I_c, far focus and short focus.
//!
//! It works on the image's own code values, as the paper does; the `physical` tier is the one
//! that knows linear light.

mod canvas;
mod params;
mod render;
mod shading;

pub use params::{FarFocusBlur, Focus, Light, Normalization, PaperOptics};
pub use render::{composite, draw, render, render_at};
pub use shading::crack_energies;
