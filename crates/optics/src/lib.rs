//! Crack network and frame in, image out: what the camera sees of a crack.
//!
//! [`paper::render`] is the visualization of "Fractured Glass, Failing Cameras": grey lines lit
//! by the sun's azimuth and zenith, blurred into the scene (far focus) or sharp before a blurred
//! scene (short focus). docs/theory/paper-optics.md gives its equations and its open points.
//!
//! [`View`] says where a point of the pane appears: stretched to the frame, or through a
//! [`Camera`].
//!
//! [`photo`] puts a photograph of broken glass in the place of a network.
//!
//! What it is not: it knows no solver and opens no file; it takes any network that keeps the
//! promises of [`starbreak_glass::CrackNetwork`], and any 8-bit or 16-bit image.
//!
//! # Example
//! ```
//! use image::{DynamicImage, RgbImage};
//! use starbreak_glass::CrackNetwork;
//! use starbreak_optics::View;
//! use starbreak_optics::paper::{PaperOptics, render};
//!
//! let network = CrackNetwork::from_json(
//!     r#"{"schema":"starbreak.crack-network/1", "generator":{"name":"by hand","version":"1"},
//!         "model":"imported", "unit":"px", "pane":{"width":64.0,"height":48.0}, "impacts":[],
//!         "nodes":{"x":[8.0,40.0],"y":[24.0,30.0]},
//!         "segments":{"from":[0],"to":[1],"kind":["radial"]}}"#,
//! )?;
//! let mut image = DynamicImage::ImageRgb8(RgbImage::from_pixel(64, 48, image::Rgb([90, 100, 110])));
//! let view = View::stretched(&network.data().pane, (64, 48));
//! let masks = render(&mut image, &network, &view, &PaperOptics::default())?;
//! assert_eq!(masks.region.get_pixel(0, 0).0, [0], "far from the crack nothing changes");
//! assert_eq!(masks.region.get_pixel(24, 27).0, [255]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod before;
mod bit_rows;
mod blur;
mod camera;
mod contrast;
mod coverage;
mod damage;
pub mod environment;
mod error;
mod frame;
pub mod interface;
pub mod lens;
pub mod lens_faults;
mod lit_runs;
mod maps;
mod masks;
mod number;
pub mod paper;
pub mod photo;
pub mod physical;
mod pyramid;
pub mod screens;
pub mod srgb;
mod surface;
mod vector;

pub use before::Before;
pub use camera::{Camera, View};
pub use contrast::Contrast;
pub use coverage::{Coverage, Line};
pub use damage::{Damage, DamageReader};
pub use error::OpticsError;
pub use frame::{Channels, FrameMut};
pub use masks::Masks;
