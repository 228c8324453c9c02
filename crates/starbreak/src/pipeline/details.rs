//! What each fracture model says about the cracks beside the cracks themselves.

use serde_json::{Map, Value, json};
use starbreak_fracture::paper::ConvergenceReport;

/// What a fracture model says about its cracks.
#[derive(Debug, Clone, PartialEq)]
pub enum Details {
    /// From the paper's model.
    Paper(PaperDetails),
}

/// How the paper's model came to rest.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperDetails {
    /// How the propagation came to rest.
    pub convergence: ConvergenceReport,
    /// Number of nodes of the mesh.
    pub n_mesh_nodes: usize,
    /// Number of triangles of the mesh.
    pub n_triangles: usize,
    /// Number of nodes that the spanning tree joined.
    pub n_stressed_nodes: usize,
}

impl Details {
    /// The details by their names, which differ from model to model.
    #[must_use]
    pub fn to_json(&self) -> Map<String, Value> {
        let mut named = Map::new();
        match self {
            Self::Paper(paper) => {
                named.insert("convergence".to_owned(), convergence(&paper.convergence));
                let mesh = json!({
                    "n_nodes": paper.n_mesh_nodes,
                    "n_triangles": paper.n_triangles,
                    "n_stressed_nodes": paper.n_stressed_nodes,
                });
                named.insert("mesh".to_owned(), mesh);
            }
        }
        named
    }
}

fn convergence(report: &ConvergenceReport) -> Value {
    json!({
        "converged": report.converged(),
        "n_steps": report.n_steps(),
        "n_fronts": report.n_fronts,
        "stopped_below_threshold": report.stopped_below_threshold,
        "stopped_at_crack": report.stopped_at_crack,
        "stopped_without_neighbor": report.stopped_without_neighbor,
        "impacts_without_fracture": report.impacts_without_fracture,
        "max_stress_change": report.max_stress_change,
    })
}
