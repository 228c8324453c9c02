//! Impact and pane in, crack network out.
//!
//! [`paper::simulate`] is the model of "Fractured Glass, Failing Cameras": particles, a
//! constrained Delaunay mesh, stress handed from node to node, and a minimum spanning tree.
//! docs/theory/paper-fracture.md gives its equations and what the paper leaves open.
//!
//! What it is not: it knows no pixels, no image and no file; it draws every random number from
//! the [`starbreak_seed::Seed`] that it is given; it keeps no clock.
//!
//! # Example
//! ```
//! use starbreak_fracture::paper::{PaperImpact, PaperParams, simulate};
//! use starbreak_glass::Pane;
//! use starbreak_seed::Seed;
//!
//! let pane = Pane::from_frame_px(1242, 375);
//! let params = PaperParams { particles: 2000, ..PaperParams::default() };
//! let broken = simulate(&pane, &[PaperImpact::default()], &params, Seed(7), |_| ())?;
//! assert!(broken.network.n_segments() > 0);
//! broken.network.check_invariants()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arrangement;
pub mod contact;
pub mod dice;
mod draw;
mod error;
mod growth;
mod lattice;
pub mod mesh;
pub mod paper;
mod params;
pub mod physics;
pub mod stress;
mod tips;
pub mod traced;

pub use error::FractureError;
