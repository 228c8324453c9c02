//! Pane to mesh: particles, outline, and their constrained Delaunay triangulation; and the graded
//! mesh of a plate.

mod cracks;
mod grading;
mod outline;
mod particles;
mod plate_mesh;
mod rim;
mod sides;
mod triangulation;
mod walk;

pub use outline::Outline;
pub use particles::Particles;
pub(crate) use particles::to_u32;
pub use plate_mesh::{MeshResolution, PlateMesh};
pub(crate) use triangulation::Indexed;
pub use triangulation::{MeshEdges, PaneMesh, mesh_pane};
