//! A network as it grows, without optics.

use image::GrayImage;
use starbreak_glass::CrackNetwork;
use starbreak_optics::{Coverage, Line, View};

/// When damage comes about, as clips of its growth ask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrivals {
    /// Of times: "us", or "step", which is no time.
    pub unit: &'static str,
    /// The first of all.
    pub first: f64,
    /// The last of all.
    pub last: f64,
}

impl Arrivals {
    /// Those of a network; none where it keeps none.
    pub(crate) fn of(network: &CrackNetwork) -> Option<Self> {
        let segments = &network.data().segments;
        let times = segments.arrival()?;
        let is_step = segments.arrival_step.is_some();
        Some(Self {
            unit: if is_step { "step" } else { "us" },
            first: times.iter().copied().reduce(f64::min).unwrap_or(0.0),
            last: network.last_arrival(),
        })
    }
}

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
