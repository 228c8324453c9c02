//! The crack as it grows, frame by frame.

use image::{DynamicImage, GrayImage};
use starbreak_glass::CrackNetwork;
use starbreak_optics::Coverage;
use starbreak_optics::Line;
use starbreak_optics::paper::{PaperOptics, render_at};

use crate::Error;

/// The times of `n_frames` growth frames, even steps from shortly after the impact to the last
/// arrival; in the unit of the network's arrivals.
pub fn growth_times(network: &CrackNetwork, n_frames: u32) -> impl Iterator<Item = f64> + use<> {
    let last = network.last_arrival();
    (1..=n_frames).map(move |k| last * f64::from(k) / f64::from(n_frames))
}

/// The cracks at a time, white on black, on a frame of the pane's own size in whole pixels.
#[must_use]
pub fn growth_drawing(
    network: &CrackNetwork,
    (width, height): (u32, u32),
    time: f64,
    line_width_px: f64,
) -> GrayImage {
    let pane = &network.data().pane;
    let (scale_x, scale_y) = (
        f64::from(width) / pane.width,
        f64::from(height) / pane.height,
    );
    let lines = network.grown_at(time).map(|(_, [x0, y0, x1, y1])| Line {
        ends: [x0 * scale_x, y0 * scale_y, x1 * scale_x, y1 * scale_y],
        weight: 1.0,
    });
    Coverage::of_lines(width, height, line_width_px, lines).to_mask()
}

/// The cracks at a time over a scene.
///
/// # Errors
/// [`Error::Optics`] as for the full-grown crack.
pub fn growth_over(
    scene: &DynamicImage,
    network: &CrackNetwork,
    time: f64,
    optics: &PaperOptics,
) -> Result<DynamicImage, Error> {
    let mut frame = scene.clone();
    render_at(&mut frame, network, time, optics)?;
    Ok(frame)
}
