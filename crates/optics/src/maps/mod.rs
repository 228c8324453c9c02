//! Facets to per-pixel maps: exact coverage, spread by the pupil of the lens.
//!
//! A [`Facet`] is a polygon of the frame with what it sends along each of a few *lanes*: shares
//! of the light of the sky, of the ground and so on. [`spread`] covers the frame with them and
//! blurs each by the disc that its own depth has. What shows much in few pixels is [`Drawn`], cell by
//! cell.

mod active;
mod cells;
mod drawn;
mod emit;
mod kernel;
mod lane_runs;
mod layer;
mod level;
mod placed;
mod raster;
mod sharp;

pub(crate) use drawn::{Drawn, Reaches, Reaching, cells_per_px};
pub(crate) use kernel::{Kernel, Pupil};
pub(crate) use lane_runs::{CHUNK, LaneRun, LaneRuns};
pub(crate) use layer::{Facet, add_arrays, spread};
pub(crate) use sharp::cover;
