//! What is counted in an image or in a crack network.

mod frame;
mod gradient;
mod network;
mod resample;
mod spectrum;

use serde::Serialize;

pub(super) use frame::image_counts;
pub use frame::{Background, ReadSettings};
pub(super) use network::network_counts;

/// A property whose histogram is compared: of pixels, or of crack networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// Luma of each pixel, a bin for each of the 256 codes: `(19595 R + 38470 G + 7471 B + 2¹⁵) / 2¹⁶`
    /// of the 8-bit sRGB codes (BT.601, as Pillow's mode `L`), at the image's own size.
    Luma256,
    /// Color of each pixel, 16 bins per channel, red outermost, at the image's own size.
    Rgb16,
    /// `ln(1 + g)` of each inner pixel of the analysis image, g the length of the gradient of luma
    /// by central differences, codes per px; 64 bins up to the largest that can be.
    LogGradient64,
    /// Direction of that gradient, 0° to 180°, 36 bins; each pixel counts as much as its g.
    Orientation36,
    /// Power of the analysis image over radial frequency, 64 bins from 0 to 0.5 cycles per px;
    /// without its mean, under a Hann window, corners beyond 0.5 left out. The shares of power of an
    /// image count as many as it has pixels.
    Spectrum64,
    /// Length of each branch of a crack network, from an end or a junction to the next, in diagonals of
    /// its pane; 48 bins in equal steps of the logarithm from 10⁻⁴ to 1, what is beyond in the last.
    SegmentLength,
    /// Number of branches at each end and junction of a crack network: 1 to 11, 12 and more.
    NodeDegree,
    /// Angle between neighboring branches at each node where three or more meet, 36 bins of 10°.
    BranchAngle,
}

impl Feature {
    /// Those of pixels.
    pub(crate) const OF_IMAGES: [Self; 5] = [
        Self::Luma256,
        Self::Rgb16,
        Self::LogGradient64,
        Self::Orientation36,
        Self::Spectrum64,
    ];

    /// Those of crack networks.
    pub(super) const OF_NETWORKS: [Self; 3] =
        [Self::SegmentLength, Self::NodeDegree, Self::BranchAngle];

    /// Its word, its number of bins, and where they lie in a row, the width of one and its unit. Colors
    /// have no order, and directions lie around a circle.
    const fn about(self) -> (&'static str, usize, Option<(f64, &'static str)>) {
        match self {
            Self::Luma256 => ("luma256", 256, Some((1.0, "codes"))),
            Self::Rgb16 => ("rgb16", 16 * 16 * 16, None),
            Self::LogGradient64 => (
                "log-gradient64",
                64,
                Some((gradient::LARGEST_LOG / 64.0, "ln(1 + codes/px)")),
            ),
            Self::Orientation36 => ("orientation36", 36, None),
            Self::Spectrum64 => ("spectrum64", 64, Some((0.5 / 64.0, "cycles/px"))),
            Self::SegmentLength => (
                "segment-length",
                48,
                Some((network::DECADES / 48.0, "decades")),
            ),
            Self::NodeDegree => ("node-degree", 12, Some((1.0, "branches"))),
            Self::BranchAngle => ("branch-angle", 36, Some((10.0, "degrees"))),
        }
    }

    /// Its word, such as `luma256`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.about().0
    }

    /// How many bins it has.
    pub(super) const fn n_bins(self) -> usize {
        self.about().1
    }

    /// Width and unit of a bin; none where bins are in no row, so that there is no W1.
    pub(crate) const fn bin_width(self) -> Option<(f64, &'static str)> {
        self.about().2
    }
}

/// The bins of one item that are not empty, in their order, and how often each is met.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Counts {
    bins: Vec<u16>,
    times: Vec<f64>,
}

impl Counts {
    /// The bins of a full histogram of at most 65536.
    fn of(histogram: &[f64]) -> Self {
        let bins = (0..=u16::MAX).zip(histogram.iter().copied());
        let (mut bins, mut times): (Vec<u16>, Vec<f64>) =
            bins.filter(|(_, count)| *count > 0.0).unzip();
        bins.shrink_to_fit();
        times.shrink_to_fit();
        Self { bins, times }
    }

    /// Adds them to a full histogram, `times` times.
    pub(super) fn add_to(&self, histogram: &mut [f64], times: f64) {
        for (bin, count) in self.bins.iter().zip(&self.times) {
            if let Some(slot) = histogram.get_mut(usize::from(*bin)) {
                *slot += count * times;
            }
        }
    }
}

/// Counts in the bin of a share of the axis, 0 to 1; the end belongs to the last bin.
fn count(histogram: &mut [f64], share: f64, weight: f64) {
    let n = histogram.len();
    #[expect(clippy::cast_precision_loss, reason = "a number of bins")]
    let at = share.clamp(0.0, 1.0) * n as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to the number of bins"
    )]
    let bin = (at as usize).min(n.saturating_sub(1));
    if let Some(slot) = histogram.get_mut(bin) {
        *slot += weight;
    }
}
