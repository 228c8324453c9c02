//! What is counted in an image or in a crack pattern.

mod counts;
mod crack_geometry;
mod frame;
mod gradient;
mod spectrum;

use serde::Serialize;

pub(super) use counts::Counts;
pub use crack_geometry::CrackGeometry;
pub(super) use frame::Frame;
pub use frame::{AnalysisSize, Background};

/// A property whose histogram is compared: of pixels, or of crack patterns.
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
    /// Share of a frame that a crack mask covers, one number per mask, 40 bins in equal steps of its
    /// logarithm from 10⁻⁴ to 1.
    MaskArea,
}

/// How the bins of a feature lie to each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BinAxis {
    /// In a row.
    Line {
        /// Width of a bin.
        bin_width: f64,
        /// Unit of that width.
        unit: &'static str,
    },
    /// Around a circle.
    Circle {
        /// Width of a bin.
        bin_width: f64,
        /// Unit of that width.
        unit: &'static str,
    },
    /// In a cube: there is no W1.
    Unordered,
}

impl BinAxis {
    /// Unit of the width of a bin; of bins without an order `bins`.
    #[must_use]
    pub const fn unit(&self) -> &'static str {
        match self {
            Self::Line { unit, .. } | Self::Circle { unit, .. } => unit,
            Self::Unordered => "bins",
        }
    }
}

impl Feature {
    /// Those of pixels.
    pub const OF_IMAGES: [Self; 5] = [
        Self::Luma256,
        Self::Rgb16,
        Self::LogGradient64,
        Self::Orientation36,
        Self::Spectrum64,
    ];

    /// Those of crack patterns.
    pub const OF_CRACKS: [Self; 4] = [
        Self::SegmentLength,
        Self::NodeDegree,
        Self::BranchAngle,
        Self::MaskArea,
    ];

    /// Its word, such as `luma256`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Luma256 => "luma256",
            Self::Rgb16 => "rgb16",
            Self::LogGradient64 => "log-gradient64",
            Self::Orientation36 => "orientation36",
            Self::Spectrum64 => "spectrum64",
            Self::SegmentLength => "segment-length",
            Self::NodeDegree => "node-degree",
            Self::BranchAngle => "branch-angle",
            Self::MaskArea => "mask-area",
        }
    }

    /// How many bins it has.
    #[must_use]
    pub const fn n_bins(self) -> usize {
        match self {
            Self::Luma256 => 256,
            Self::Rgb16 => 16 * 16 * 16,
            Self::LogGradient64 => gradient::N_MAGNITUDE_BINS,
            Self::Orientation36 => gradient::N_ORIENTATION_BINS,
            Self::Spectrum64 => spectrum::N_BINS,
            Self::SegmentLength => crack_geometry::N_LENGTH_BINS,
            Self::NodeDegree => crack_geometry::N_DEGREE_BINS,
            Self::BranchAngle => crack_geometry::N_ANGLE_BINS,
            Self::MaskArea => crack_geometry::N_AREA_BINS,
        }
    }

    /// How its bins lie to each other.
    #[must_use]
    pub fn axis(self) -> BinAxis {
        let line = |bin_width, unit| BinAxis::Line { bin_width, unit };
        let circle = |bin_width, unit| BinAxis::Circle { bin_width, unit };
        match self {
            Self::Luma256 => line(1.0, "codes"),
            Self::Rgb16 => BinAxis::Unordered,
            Self::LogGradient64 => line(gradient::magnitude_bin_width(), "ln(1 + codes/px)"),
            Self::Orientation36 => circle(5.0, "degrees"),
            Self::Spectrum64 => line(spectrum::BIN_WIDTH, "cycles/px"),
            Self::SegmentLength => line(crack_geometry::LENGTH_BIN_WIDTH, "decades"),
            Self::NodeDegree => line(1.0, "branches"),
            Self::BranchAngle => line(10.0, "degrees"),
            Self::MaskArea => line(crack_geometry::AREA_BIN_WIDTH, "decades"),
        }
    }

    /// Its place among all features, which keeps them in one order.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        let mut all = Self::OF_IMAGES.into_iter().chain(Self::OF_CRACKS);
        all.find(|feature| feature.name() == name)
    }
}

/// The histograms of pixels of one image, in the order of [`Feature::OF_IMAGES`].
pub(super) fn image_counts(frame: &Frame) -> Vec<Counts> {
    let [magnitude, orientation] = gradient::histograms(&frame.analysis);
    vec![
        frame.luma_counts(),
        frame.rgb_counts(),
        magnitude,
        orientation,
        spectrum::histogram(&frame.analysis),
    ]
}
