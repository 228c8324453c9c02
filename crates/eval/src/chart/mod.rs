//! Charts as lines, areas and words, and these as SVG: for the page of a report, or as files of their own.

mod axis;
mod drawing;
mod plot;

pub use axis::Axis;
pub(crate) use drawing::escaped;
pub use drawing::{Anchor, Color, Drawing, Shape};
pub use plot::{Colors, Marker, PAPER, Plot};
