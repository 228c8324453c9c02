//! A network from a file in the place of a simulated one.

use image::DynamicImage;
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_optics::View;
use starbreak_seed::Seed;

use super::broken_pane::view_of;
use super::{Cracked, Details, ImportedDetails, Simulated, Stopwatch, sheet_view, show_cracks};
use crate::import::ImportedNetwork;
use crate::{Error, OpticsSettings, Settings};

/// The network of a file as if it had been simulated; the fracture part of a recipe, its impacts
/// and the seed have no say in it.
#[must_use]
pub fn use_network(imported: &ImportedNetwork) -> Simulated {
    Simulated {
        network: imported.network.clone(),
        details: Details::Imported(ImportedDetails {
            name: imported.name.clone(),
            sha256: imported.sha256.clone(),
            model: imported.network.data().model,
        }),
        timings: Stopwatch::start().stop(),
    }
}

/// How a frame shows a network that a file holds: one in px is stretched over the frame, one in
/// mm lies on the pane that it states, which stands where the recipe says (`glass.distance_m`,
/// `glass.rake_deg` and `glass.axis_at`, parts of that pane). The physical optics put one in px
/// on the sheet of the recipe, each point where its line of sight meets it.
///
/// # Errors
/// [`Error::NoMount`] for a network in mm and a recipe without a mount, [`Error::Optics`] for a
/// camera that sees nothing.
pub fn view_of_network(
    settings: &Settings,
    network: &CrackNetwork,
    size: (u32, u32),
) -> Result<View, Error> {
    let pane = &network.data().pane;
    match (network.data().unit, &settings.optics) {
        (LengthUnit::Px, OpticsSettings::Paper(_)) => Ok(View::stretched(pane, size)),
        (LengthUnit::Px, OpticsSettings::Physical(_)) => sheet_view(settings, size.0, size.1),
        (LengthUnit::Mm, _) => {
            let mount = settings.fracture.mount().ok_or(Error::NoMount)?;
            view_of(&mount, [pane.width, pane.height], &settings.camera, size)
        }
    }
}

/// Shows the network of a file in an image, in place; as [`crack_image`](super::crack_image).
///
/// # Errors
/// As for [`view_of_network`], and [`Error::Optics`]; the image may then be half changed.
pub fn crack_image_with(
    settings: &Settings,
    image: &mut DynamicImage,
    imported: &ImportedNetwork,
    seed: Seed,
) -> Result<Cracked, Error> {
    show_cracks(settings, image, use_network(imported), seed)
}
