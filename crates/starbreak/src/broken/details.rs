//! What each fracture model says about the cracks beside the cracks themselves.

use serde_json::{Map, Value, json};
use starbreak_fracture::paper::ConvergenceReport;
use starbreak_fracture::physics::{ImpactReport, LongCrackReport};
use starbreak_glass::{CrackNetwork, Model};

/// What a fracture model says about its cracks.
#[derive(Debug, Clone, PartialEq)]
pub enum Details {
    /// From the paper's model.
    Paper(PaperDetails),
    /// From the physics.
    Physics(PhysicsDetails),
    /// From a file.
    Imported(ImportedDetails),
    /// Nothing broke.
    None,
}

/// Which file a network comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedDetails {
    /// Name of the file, without its folder.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// The model that the file names.
    pub model: Model,
}

/// What the physics says of hits and loads.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicsDetails {
    /// The hits, in their order.
    pub impacts: Vec<ImpactReport>,
    /// The long crack, if one was asked for.
    pub long_crack: Option<LongCrackReport>,
    /// How often the plate's stress was asked for.
    pub n_solutions: usize,
    /// Nodes of the largest mesh.
    pub n_mesh_nodes: usize,
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
            Self::Physics(physics) => {
                let hits: Vec<Value> = physics.impacts.iter().map(hit).collect();
                named.insert("hits".to_owned(), Value::Array(hits));
                if let Some(report) = &physics.long_crack {
                    named.insert("long_crack".to_owned(), long_crack(report));
                }
                let plate = json!({
                    "n_mesh_nodes": physics.n_mesh_nodes,
                    "n_solutions": physics.n_solutions,
                });
                named.insert("plate".to_owned(), plate);
            }
            Self::Imported(imported) => {
                let file = json!({
                    "name": imported.name,
                    "sha256": imported.sha256,
                    "model": imported.model,
                });
                named.insert("file".to_owned(), file);
            }
            Self::None => {}
        }
        named
    }
}

impl Details {
    /// What a record says of the cracks, but for their network's own columns.
    pub(crate) fn facts_of(&self, network: &CrackNetwork) -> Value {
        let data = network.data();
        let model = match self {
            Self::Imported(_) => Model::Imported,
            _ => data.model,
        };
        let mut facts = Map::from_iter([
            ("model".to_owned(), json!(model)),
            ("impacts".to_owned(), json!(data.impacts)),
            ("summary".to_owned(), json!(network.summary())),
        ]);
        facts.extend(self.to_json());
        Value::Object(facts)
    }
}

fn hit(report: &ImpactReport) -> Value {
    json!({
        "damage_class": report.damage.name(),
        "time_us": report.time_s * 1e6,
        "kinetic_energy_j": report.kinetic_energy_j,
        "peak_force_n": report.peak_force_n,
        "contact_time_us": report.contact_time_s * 1e6,
        "contact_radius_mm": report.contact_radius_m * 1e3,
        "crushed_radius_mm": report.crushed_radius_m * 1e3,
        "n_arms": report.n_arms,
        "n_legs": report.n_legs,
        "reach_mm": report.reach_m * 1e3,
        "available_j": report.available_j,
        "dissipated_j": report.dissipated_j,
    })
}

fn long_crack(report: &LongCrackReport) -> Value {
    json!({
        "class": report.class,
        "length_mm": report.length_m * 1e3,
        "flaw_k_ratio": report.flaw_k_ratio,
        "available_j": report.available_j,
        "dissipated_j": report.dissipated_j,
    })
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
