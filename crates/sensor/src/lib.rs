//! Light to electrons to light: what a sensor with a fault makes of a frame.
//!
//! It is: pure functions of linear light, each law with a closed form beside it, drawn from named streams of a seed.
//! It is not: a codec, a recipe, or anything of the pane and the lens; it knows no files and no codes of pixels.

mod defects;
mod draw;
mod error;
mod exposure;
mod lamps;
mod light;
mod mosaic;
mod noise;
mod sensor;

pub use defects::{Defect, Lines, Pixels};
pub use error::SensorError;
pub use exposure::Exposure;
pub use lamps::Lamps;
pub use light::Light;
pub use mosaic::demosaic;
pub use noise::Noise;
pub use sensor::{Moment, Sensor};
