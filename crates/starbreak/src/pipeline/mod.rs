//! Settings and seed in, cracked images out: one image in memory, or many files.

mod files;
mod growth;
mod provenance;
mod timings;

use image::DynamicImage;
use starbreak_fracture::paper::{Fracture, Stage, simulate as simulate_paper};
use starbreak_glass::{Pane, Seed};
use starbreak_optics::View;
use starbreak_optics::paper::{Masks, composite, draw};

use crate::{Error, Settings};

pub use files::{
    Failure, ImageJob, JobResult, Written, crack_file, crack_files, plan_images, stage_cracked,
    with_threads,
};
pub use growth::{growth_drawing, growth_over, growth_times};
pub use provenance::{PROVENANCE_SCHEMA, RunContext, convergence_json};
pub use timings::{Stopwatch, Timings};

/// A simulated crack network and how long each stage took.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// The cracks and how they came to rest.
    pub fracture: Fracture,
    /// Wall-clock time per stage.
    pub timings: Timings,
}

/// What [`crack_image`] leaves beside the image.
#[derive(Debug, Clone)]
pub struct Cracked {
    /// The cracks and how they came to rest.
    pub fracture: Fracture,
    /// Where the image changed, and where the cracks are.
    pub masks: Masks,
    /// Wall-clock time per stage.
    pub timings: Timings,
}

/// Breaks the glass before a frame of `width_px × height_px`.
///
/// # Errors
/// [`Error::Fracture`] for parameters that do not fit the frame.
pub fn simulate(
    settings: &Settings,
    width_px: u32,
    height_px: u32,
    seed: Seed,
) -> Result<Simulated, Error> {
    let mut watch = Stopwatch::start();
    let pane = Pane::from_frame_px(width_px, height_px);
    let impacts = settings.impacts_on(&pane);
    let fracture = simulate_paper(&pane, &impacts, &settings.fracture, seed, |stage| {
        watch.lap(match stage {
            Stage::Mesh => "mesh",
            Stage::Propagation => "propagation",
            Stage::SpanningTree => "mst",
            Stage::Network => "network",
        });
    })?;
    Ok(Simulated {
        fracture,
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
    let Simulated {
        fracture,
        mut timings,
    } = simulate(settings, image.width(), image.height(), seed)?;
    let mut watch = Stopwatch::start();
    let view = View::stretched(
        &fracture.network.data().pane,
        (image.width(), image.height()),
    );
    let drawn = draw(&fracture.network, &view, f64::INFINITY, &settings.optics);
    watch.lap("draw");
    let masks = composite(image, &drawn, &settings.optics)?;
    watch.lap("render");
    timings.append(watch.stop());
    Ok(Cracked {
        fracture,
        masks,
        timings,
    })
}
