//! A network as it grows, without optics.

use image::GrayImage;
use starbreak_glass::CrackNetwork;
use starbreak_optics::{Coverage, Line, View};

/// The times of `n_frames` growth frames, even steps from shortly after the impact to the last
/// arrival; in the unit of the network's arrivals.
pub fn growth_times(network: &CrackNetwork, n_frames: u32) -> impl Iterator<Item = f64> + use<> {
    let last = network.last_arrival();
    (1..=n_frames).map(move |k| last * f64::from(k) / f64::from(n_frames))
}

/// The cracks at a time, white on black, on the frame of the view.
#[must_use]
pub fn growth_drawing(
    network: &CrackNetwork,
    view: &View,
    time: f64,
    line_width_px: f64,
) -> GrayImage {
    let (width, height) = view.size();
    let lines = network.grown_at(time).filter_map(|(_, ends)| {
        Some(Line {
            ends: view.visible(ends, line_width_px + 1.0)?,
            weight: 1.0,
        })
    });
    Coverage::of_lines(width, height, line_width_px, lines).to_mask()
}
