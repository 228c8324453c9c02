//! Cracks into pixels, by either optics model.

use image::DynamicImage;
use starbreak_glass::CrackNetwork;
use starbreak_optics::View;
use starbreak_optics::paper::{Masks, composite, draw};

use super::Stopwatch;
use crate::{Error, OpticsSettings};

/// Shows the cracks in the image, in place.
pub(super) fn show(
    optics: &OpticsSettings,
    image: &mut DynamicImage,
    network: &CrackNetwork,
    view: &View,
    watch: &mut Stopwatch,
) -> Result<Masks, Error> {
    match optics {
        OpticsSettings::Paper(optics) => {
            let drawn = draw(network, view, f64::INFINITY, optics);
            watch.lap("draw");
            let masks = composite(image, &drawn, optics)?;
            watch.lap("render");
            Ok(masks)
        }
        OpticsSettings::Physical(_) => Err(Error::NotRendered),
    }
}
