//! Settings and seed in, cracked images out: one image in memory, or many files.

mod broken_pane;
mod details;
mod files;
mod growth;
mod imported;
mod provenance;
mod ready;
mod show;
mod timings;

use image::DynamicImage;
use starbreak_fracture::paper::{Stage, simulate as simulate_paper};
use starbreak_glass::{CrackNetwork, Pane};
use starbreak_optics::physical::OpticalMaps;
use starbreak_optics::{Camera, Masks, View};
use starbreak_seed::Seed;

use broken_pane::{own_view as own_pane_view, physics_network};

use crate::{Error, FractureSettings, PaperSettings, Settings};

pub use details::{Details, ImportedDetails, PaperDetails, PhysicsDetails};

pub use files::{
    Failure, ImageJob, JobResult, Written, crack_file, crack_files, plan_images, stage_cracked,
    stage_shown, with_threads,
};
pub(crate) use files::{encoding, extension, region_fraction};
pub use growth::{growth_drawing, growth_over, growth_times};
pub use imported::{crack_image_with, use_network, view_of_network};
pub use provenance::{PROVENANCE_SCHEMA, RunContext};
pub(crate) use ready::damage_reader;
pub use ready::{FrameReport, ReadyCrack, damage_to_json};
pub use show::{Baked, OpticsReport, SceneReport, Shown, bake_network, show_cracks};
pub(crate) use show::{network_view, own_view};
pub use timings::{Stopwatch, Timings};

/// A simulated crack network and how long each stage took.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// The cracks.
    pub network: CrackNetwork,
    /// What the model says about them.
    pub details: Details,
    /// Wall-clock time per stage.
    pub timings: Timings,
}

/// What [`crack_image`] leaves beside the image.
#[derive(Debug, Clone)]
pub struct Cracked {
    /// The cracks.
    pub network: CrackNetwork,
    /// What the model says about them.
    pub details: Details,
    /// Where the image changed, and where the cracks are.
    pub masks: Masks,
    /// What the physical optics did to the light of each pixel, if asked for.
    pub maps: Option<OpticalMaps>,
    /// What the optics say about the picture.
    pub optics: OpticsReport,
    /// Wall-clock time per stage.
    pub timings: Timings,
}

impl Cracked {
    /// Whether nothing is broken: no segment in the network, or nothing of the photograph in the
    /// frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        match self.details {
            Details::Photo(_) => self.masks.crack.iter().all(|code| *code == 0),
            _ => self.network.n_segments() == 0,
        }
    }
}

/// Breaks the glass before a frame of `width_px × height_px`.
///
/// # Errors
/// [`Error::Fracture`] for parameters that do not fit the frame; [`Error::NoObjects`] for hits that are
/// to be before objects ([`FractureSettings::aimed_at`]).
pub fn simulate(
    settings: &Settings,
    width_px: u32,
    height_px: u32,
    seed: Seed,
) -> Result<Simulated, Error> {
    if settings.fracture.is_aimed() {
        return Err(Error::NoObjects);
    }
    settings.may_break((width_px, height_px))?;
    match &settings.fracture {
        FractureSettings::Paper(paper) => paper_network(paper, width_px, height_px, seed),
        FractureSettings::Physics(physics) => {
            physics_network(physics, &settings.camera, (width_px, height_px), seed)
        }
    }
}

/// How the frame shows the pane: the paper's is the frame itself, that of the physics stands
/// before the camera.
///
/// # Errors
/// [`Error::Optics`] for a camera that sees nothing.
pub fn view(settings: &Settings, width_px: u32, height_px: u32) -> Result<View, Error> {
    let size = (width_px, height_px);
    match &settings.fracture {
        FractureSettings::Paper(_) => Ok(View::stretched(
            &Pane::from_frame_px(width_px, height_px),
            size,
        )),
        FractureSettings::Physics(physics) => own_pane_view(physics, &settings.camera, size),
    }
}

/// The pane as the physical optics see it: every camera looks through glass, also where the cracks
/// are those of the paper, which lie over the frame.
pub(crate) fn sheet_view(
    settings: &Settings,
    width_px: u32,
    height_px: u32,
) -> Result<View, Error> {
    let size = (width_px, height_px);
    match (&settings.fracture, settings.fracture.mount()) {
        (FractureSettings::Paper(_), Some(mount)) => {
            let camera = Camera {
                f_px: settings.camera.f_px.of_frame(width_px),
                distance_m: mount.distance_m,
                rake_rad: mount.rake_rad,
                // The sheet goes on beyond the frame, so that any of its points will do.
                axis_at_mm: [0.0; 2],
            };
            Ok(View::through(&camera, size)?)
        }
        _ => view(settings, width_px, height_px),
    }
}

fn paper_network(
    settings: &PaperSettings,
    width_px: u32,
    height_px: u32,
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

/// Breaks the glass before an image and shows it in the image, in place.
///
/// The pixels are a function of the image, the settings and the seed alone.
///
/// # Errors
/// [`Error::Fracture`] and [`Error::Optics`]; the image may then be half changed.
pub fn crack_image(
    settings: &Settings,
    image: &mut DynamicImage,
    seed: Seed,
) -> Result<Cracked, Error> {
    let simulated = simulate(settings, image.width(), image.height(), seed)?;
    show_cracks(settings, image, simulated, seed)
}
