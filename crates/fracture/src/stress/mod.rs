//! Load to stress: plates and membranes by finite elements.

mod tensor;

pub use tensor::{PlaneStress, StressField};
