use starbreak_fracture::FractureError;
use starbreak_optics::OpticsError;
use starbreak_sensor::SensorError;

use crate::RecipeError;

/// Why glass could not be broken or shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The recipe is wrong.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// The fracture model refused.
    #[error("{0}{keys}", keys = keys_to_change(.0))]
    Fracture(#[from] FractureError),
    /// The optics refused.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A fault of the camera cannot be had of an image.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// A stone that would fly past the pane.
    #[error(
        "impact {impact}: {}; move the impact or the pane (glass.distance_m, glass.axis_at, glass.width_mm)",
        if *.is_random { "the frame shows no glass" } else { "its position in the frame shows no glass" }
    )]
    OffGlass {
        /// Which one, from 0.
        impact: u64,
        /// Whether its place was drawn.
        is_random: bool,
    },
    /// A hit that is to be before an object, where no objects are known.
    #[error(
        "impact.position = \"object\" needs labels; break a labeled dataset with generate or study, or give the place as [x, y], fractions of the frame"
    )]
    NoObjects,
    /// A picture that takes more memory than it may.
    #[error(
        "{what} may take {} of memory, more than the {} that one picture may take; {way_out}, or raise that limit \
         (--max-memory; max_memory in Python)",
        memory(*.needs_bytes), memory(*.limit_bytes)
    )]
    TooCostly {
        /// What would be done.
        what: &'static str,
        /// Memory that it takes, bytes.
        needs_bytes: f64,
        /// The limit, bytes.
        limit_bytes: f64,
        /// What to change.
        way_out: &'static str,
    },
    /// A network in mm where nothing says how far away its pane is.
    #[error(
        "the network is in mm, but the recipe has no [glass] that says where the pane stands; use a preset of the \
         physics, such as windshield-star"
    )]
    NoMount,
    /// More rain than can be followed drop by drop.
    #[error(
        "[drops]: some {n_drops:.1e} drops would land on the pane that the frame shows, more than the {most:.0e} that are \
         followed; lower {way_out}"
    )]
    TooManyDrops {
        /// How many.
        n_drops: f64,
        /// The most.
        most: f64,
        /// What to lower.
        way_out: String,
    },
    /// Drops on a photograph of broken glass.
    #[error(
        "[drops] cannot lie on photographs of broken glass; leave that table out, or break the glass instead"
    )]
    DropsOnPhoto,
    /// A baked crack under the optics of another model.
    #[error(
        "the pattern was baked for another optics.model than the recipe's; use the recipe that it was made with"
    )]
    OtherOptics,
}

/// The key of a recipe that decides what a model finds too much of.
fn keys_to_change(error: &FractureError) -> &'static str {
    match error {
        FractureError::TooManyNeighbors { .. } | FractureError::TooManyCrossings { .. } => {
            " (fracture.neighbour_radius_px)"
        }
        FractureError::TooManyDice { .. } => " (glass.surface_compression_mpa)",
        _ => "",
    }
}

/// Some memory with its unit.
fn memory(bytes: f64) -> String {
    let mib = bytes / 1_048_576.0;
    if mib < 1024.0 {
        format!("{mib:.0} MiB")
    } else {
        format!("{:.1} GiB", mib / 1024.0)
    }
}
