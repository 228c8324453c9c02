//! The physical optics: mirrors, glints and crushed glass through a real lens, in linear light.

mod params;

pub use params::{PhysicalOptics, SensorNoise, SurfaceParams};
