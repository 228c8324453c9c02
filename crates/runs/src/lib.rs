//! Whole runs: images, datasets, banks, clips, bags, studies and evaluations, from files to files.
//!
//! Here the in-memory [`Chain`](starbreak::Chain) meets samples on disk and detectors, on as many threads
//! as [`with_threads`] gives. This crate contains no formula of its own, and it never prints.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bag;
mod bag_error;
pub mod bank;
pub mod clip;
mod clip_error;
pub mod divergence;
mod error;
pub mod evaluation;
pub mod generate;
pub mod images;
mod network_file;
pub mod overlay;
mod patterns;
mod provenance;
pub mod study;
mod threads;

pub use error::Error;
pub use network_file::{MAX_NETWORK_FILE_BYTES, read_network};
pub use patterns::Patterns;
pub use provenance::{PROVENANCE_SCHEMA, RunContext};
pub use starbreak_dataset as dataset;
pub use starbreak_eval as eval;
pub use threads::with_threads;
