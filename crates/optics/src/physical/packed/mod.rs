//! Baked cracks as bytes: small enough for banks of thousands, and read in a fraction of a
//! millisecond.
//!
//! Values are whole numbers of a step that no 8-bit picture shows, in blocks of 32 pixels of a
//! row. A block is predicted from its left neighbors or from the row above; what is left is
//! written in as many bits as it needs.

mod block;
#[cfg(target_arch = "x86_64")]
mod block_avx2;
mod bytes;
mod coverage;
mod pattern;
mod runs;
mod values;

pub use pattern::PackedPattern;

/// What [`PackedPattern::new`] and [`crate::Coverage::from_packed`] refuse
/// larger frames than, px per side: the largest image that can be read.
const MAX_SIDE_PX: usize = 32_768;

/// Pixels of such a frame at most.
const MAX_PIXELS: usize = 1 << 27;
