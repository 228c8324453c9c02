//! A network from a file in the place of a simulated one.

use image::DynamicImage;
use starbreak_fracture::physics::network_pane;
use starbreak_fracture::traced::{self, Trace};
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_optics::View;

use super::broken_pane::{own_view, view_of};
use super::{Cracked, Details, ImportedDetails, Simulated, Stopwatch, show};
use crate::import::ImportedNetwork;
use crate::{Error, FractureSettings, Settings};

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
/// `glass.rake_deg` and `glass.axis_at`, parts of that pane).
///
/// # Errors
/// [`Error::NoMount`] for a network in mm and a recipe of the paper's model, [`Error::Optics`]
/// for a camera that sees nothing.
pub fn view_of_network(
    settings: &Settings,
    network: &CrackNetwork,
    size: (u32, u32),
) -> Result<View, Error> {
    let pane = &network.data().pane;
    match (network.data().unit, &settings.fracture) {
        (LengthUnit::Px, _) => Ok(View::stretched(pane, size)),
        (LengthUnit::Mm, FractureSettings::Physics(physics)) => view_of(
            &physics.mount,
            [pane.width, pane.height],
            &settings.camera,
            size,
        ),
        (LengthUnit::Mm, FractureSettings::Paper(_)) => Err(Error::NoMount),
    }
}

/// A network in px, drawn over a frame, as cracks in mm on the recipe's pane before the camera:
/// each crack where it must be to appear where it was drawn. For optics that need lengths; a
/// network in mm is returned as it is. Straight lines stay straight; kinds stay, other columns
/// of the segments do not.
///
/// # Errors
/// [`Error::NoMount`] for a recipe of the paper's model, [`Error::CracksOffGlass`] where the
/// frame shows no glass behind a crack, [`Error::Optics`] for a camera that sees nothing.
pub fn onto_pane(
    settings: &Settings,
    network: &CrackNetwork,
    size: (u32, u32),
) -> Result<CrackNetwork, Error> {
    let data = network.data();
    if data.unit == LengthUnit::Mm {
        return Ok(network.clone());
    }
    let FractureSettings::Physics(physics) = &settings.fracture else {
        return Err(Error::NoMount);
    };
    let frame = View::stretched(&data.pane, size);
    let camera = own_view(physics, &settings.camera, size)?;
    let pane = network_pane(&physics.pane);
    let on_pane = |[x, y]: [f64; 2]| -> Result<[f64; 2], Error> {
        let seen = frame.project([x, y]);
        seen.and_then(|place| camera.unproject(place))
            .filter(|[x, y]| pane.contains(*x, *y))
            .ok_or(Error::CracksOffGlass { x, y })
    };
    let traces = data
        .segments
        .kind
        .iter()
        .enumerate()
        .map(|(idx, kind)| {
            let [x0, y0, x1, y1] = network.ends(idx);
            Ok(Trace {
                points: vec![on_pane([x0, y0])?, on_pane([x1, y1])?],
                kind: *kind,
            })
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let impacts = data
        .impacts
        .iter()
        .map(|impact| on_pane([impact.x, impact.y]))
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(traced::network(&pane, LengthUnit::Mm, &impacts, &traces)?)
}

/// Shows the network of a file in an image, in place; as [`crack_image`](super::crack_image).
///
/// # Errors
/// As for [`view_of_network`], and [`Error::Optics`]; the image may then be half changed.
pub fn crack_image_with(
    settings: &Settings,
    image: &mut DynamicImage,
    imported: &ImportedNetwork,
) -> Result<Cracked, Error> {
    let size = (image.width(), image.height());
    let view = view_of_network(settings, &imported.network, size)?;
    show(settings, image, use_network(imported), &view)
}
