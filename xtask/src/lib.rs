//! The chores of the project, one module each. Their pure parts take text and return findings,
//! so that each can be seen to fail in a unit test.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a report is what a chore is for"
)]

pub mod advisories;
pub mod command;
pub mod deps;
pub mod docs;
pub mod failure;
pub mod gallery;
pub mod licences;
pub mod links;
pub mod lint;
pub mod metadata;
pub mod notices;
pub mod refs;
pub mod rust_source;
pub mod test;
pub mod web;

use std::path::Path;

pub use failure::Failure;

/// The folder of the workspace.
#[must_use]
pub fn root() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}
