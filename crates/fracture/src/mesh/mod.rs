//! Pane to mesh: particles, outline, and their constrained Delaunay triangulation.

mod outline;
mod particles;
mod triangulation;

pub use outline::Outline;
pub use particles::Particles;
pub(crate) use particles::{to_u32, uniform};
pub(crate) use triangulation::Indexed;
pub use triangulation::{PaneMesh, mesh_pane};
