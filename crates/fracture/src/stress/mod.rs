//! Load to stress: plates and membranes by finite elements.

mod cholesky;
mod dkt;
mod elimination;
mod load;
mod membrane;
mod near_load;
mod plate;
mod recovery;
mod sparse;
mod tensor;

pub use membrane::{EXPANSION_PER_K, MembraneField, membrane_stress};
pub use plate::{Face, PatchLoad, PlateField, PlateProperties, PlateSolver};
pub use tensor::{PlaneStress, StressField};
