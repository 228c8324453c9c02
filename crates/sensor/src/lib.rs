//! Light to electrons to light to codes: what a sensor with a fault, and what comes after it, make of a frame.
//!
//! It is: pure functions of linear light, and of codes on their way to the computer, each law with a closed form beside
//! it, drawn from named streams of a seed.
//! It is not: a recipe, or anything of the pane and the lens; it knows no files.

mod codes;
mod defects;
mod draw;
mod error;
mod exposure;
mod fault;
mod filters;
mod frames;
mod isp;
mod lamps;
mod light;
mod link;
mod mosaic;
mod noise;
mod sensor;
mod spots;

pub use codes::{Code, Codes};
pub use defects::{Defect, Lines, Pixels};
pub use error::SensorError;
pub use exposure::Exposure;
pub use fault::Fault;
pub use filters::Filters;
pub use frames::{FrameState, Frames};
pub use isp::{Isp, RawRows};
pub use lamps::{Lamps, Pulse};
pub use light::Light;
pub use link::Link;
pub use mosaic::demosaic;
pub use noise::Noise;
pub use sensor::{Moment, Sensor};
pub use spots::Spots;
