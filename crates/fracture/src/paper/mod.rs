//! The fracture model of the paper, read precisely: particles, constrained Delaunay mesh,
//! stress propagation (eqs. 1-5 and Algorithm 1), minimum spanning tree of the stressed nodes.
//!
//! docs/theory/paper-fracture.md names every ambiguity of the text and the choice made here.

mod params;
mod propagation;
mod simulate;
mod spanning_tree;

pub use params::{Direction, Neighborhood, PaperImpact, PaperParams, Position, Rule};
pub use propagation::{ConvergenceReport, Hop, Propagation, ResolvedImpact, StopReason, propagate};
pub use simulate::{Fracture, Stage, simulate};
pub use spanning_tree::{TreeEdge, euclidean_spanning_tree};
