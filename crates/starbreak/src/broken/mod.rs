//! Settings and seed in, broken glass out, by either model of fracture.

mod details;
mod physics;

use starbreak_fracture::paper::{Stage, simulate as simulate_paper};
use starbreak_glass::{CrackNetwork, Pane};
use starbreak_seed::Seed;

use crate::import::ImportedNetwork;
use crate::{Error, FractureSettings, PaperSettings, Scene, Settings, Stopwatch, Timings};

pub use details::{Details, ImportedDetails, PaperDetails, PhysicsDetails};

/// A crack network and how long each stage of its making took.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// The cracks.
    pub network: CrackNetwork,
    /// What the model says about them.
    pub details: Details,
    /// Wall-clock time per stage.
    pub timings: Timings,
}

impl From<&ImportedNetwork> for Simulated {
    /// The network of a file as if it had been simulated; the fracture part of a recipe, its impacts
    /// and the seed have no say in it.
    fn from(imported: &ImportedNetwork) -> Self {
        Self {
            network: imported.network.clone(),
            details: Details::Imported(ImportedDetails {
                name: imported.name.clone(),
                sha256: imported.sha256.clone(),
                model: imported.network.data().model,
            }),
            timings: Timings::default(),
        }
    }
}

/// Breaks the glass before a frame of a width and height, px.
///
/// # Errors
/// [`Error::Fracture`] for parameters that do not fit the frame; [`Error::OffGlass`] for a stone that
/// misses the pane, [`Error::Optics`] for a camera that sees none of it; [`Error::NoObjects`] for hits that are
/// to be before objects ([`FractureSettings::aimed_at`]); [`Error::TooCostly`].
pub fn simulate(settings: &Settings, size_px: (u32, u32), seed: Seed) -> Result<Simulated, Error> {
    if settings.fracture.is_aimed() {
        return Err(Error::NoObjects);
    }
    settings.may_break(size_px)?;
    match &settings.fracture {
        FractureSettings::Paper(paper) => paper_network(paper, size_px, seed),
        FractureSettings::Physics(physics) => {
            physics::network(physics, &Scene::of(settings, size_px).pane()?, seed)
        }
        FractureSettings::None(_) => Ok(Simulated {
            network: CrackNetwork::without_cracks(size_px.0, size_px.1),
            details: Details::None,
            timings: Timings::default(),
        }),
    }
}

fn paper_network(
    settings: &PaperSettings,
    (width_px, height_px): (u32, u32),
    seed: Seed,
) -> Result<Simulated, Error> {
    let mut watch = Stopwatch::start();
    let pane = Pane::from_frame_px(width_px, height_px);
    let impacts = settings.impacts_on(&pane);
    let fracture = simulate_paper(&pane, &impacts, &settings.params, seed, |stage| {
        watch.lap(match stage {
            Stage::Mesh => "mesh",
            Stage::Propagation => "propagation",
            Stage::SpanningTree => "mst",
            Stage::Network => "network",
        });
    })?;
    Ok(Simulated {
        details: Details::Paper(PaperDetails {
            convergence: fracture.convergence,
            n_mesh_nodes: fracture.n_mesh_nodes,
            n_triangles: fracture.n_triangles,
            n_stressed_nodes: fracture.n_stressed_nodes,
        }),
        network: fracture.network,
        timings: watch.stop(),
    })
}
