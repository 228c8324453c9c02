//! The tables of a recipe that only the paper's models have.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tables::{DirectionEntry, FocalEntry, ModelWord, OpticsWord, PositionEntry};

/// What the paper's fracture model reads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct PaperFractureTables {
    /// The hits, one table each, in the order in which they happen.
    pub(super) impact: Vec<PaperImpactTable>,
    /// How the glass breaks.
    pub(super) fracture: PaperFractureTable,
}

/// What the paper's optics read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct PaperOpticsTables {
    /// The camera behind the glass.
    pub(super) camera: PaperCameraTable,
    /// How the crack looks.
    pub(super) optics: PaperOpticsTable,
}

/// The camera behind the glass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PaperCameraTable {
    /// Focal length, px, above 0 and up to 1000000, or "auto": 0.5809 times the width of the frame, KITTI's field of
    /// view at any resolution. Lays the frame over a pane that is measured in mm.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1e6))]
    pub(super) f_px: FocalEntry,
    /// What is sharp: "far" (the scene, the crack blurred over it) or "short" (the crack, the
    /// scene blurred behind it).
    pub(super) focus_distance_m: FocusEntry,
}

/// Where the camera is focused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"far\" or \"short\" (the paper's optics know no distance in between)"
)]
pub(super) enum FocusEntry {
    /// One of the paper's two.
    Word(FocusWord),
}

/// The two focus settings of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum FocusWord {
    /// The scene is sharp.
    Far,
    /// The crack is sharp.
    Short,
}

/// One hit of the paper's model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PaperImpactTable {
    /// Where: [x, y] as fractions of the frame, from the top left corner; "random", in the
    /// inner 80 % of the frame; "anywhere"; or "object", before a labeled object of the image
    /// (`generate` and `study` of a labeled dataset).
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) position: PositionEntry,
    /// Impact force F of the paper, in its own unit, 1e-12 to 1e12. Nothing breaks unless it exceeds
    /// fracture.critical_stress / fracture.safety_factor.
    #[schemars(range(min = 1e-12, max = 1e12))]
    pub(super) force: f64,
    /// Direction of the impact in the plane of the glass, degrees from +x towards +y (down), or
    /// "random".
    pub(super) direction_deg: DirectionEntry,
}

/// How the glass breaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PaperFractureTable {
    /// Fracture model: "physics" or "paper"; decides which keys [fracture] and [[impact]] have.
    pub(super) model: ModelWord,
    /// Number of particles, 1 to 10000000.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub(super) particles: u32,
    /// Radius of the neighborhood of a particle, px, 1e-12 to 1e12.
    #[schemars(range(min = 1e-12, max = 1e12))]
    pub(super) neighbour_radius_px: f64,
    /// Which particles are neighbors: "radius" (all within it) or "mesh-edges" (those that also
    /// share a mesh edge).
    pub(super) neighbourhood: NeighborhoodWord,
    /// Critical stress of the glass, in units of the force, 1e-12 to 1e12.
    #[schemars(range(min = 1e-12, max = 1e12))]
    pub(super) critical_stress: f64,
    /// Safety factor, 1e-12 to 1e12: a particle breaks above critical_stress / safety_factor.
    #[schemars(range(min = 1e-12, max = 1e12))]
    pub(super) safety_factor: f64,
    /// How a crack chooses its next particle: "algorithm-1", "caption" or "literal" (eqs. 3-5 to
    /// the letter; dies at once).
    pub(super) rule: RuleWord,
    /// Number of branches that leave a particle, 1 to 64.
    #[schemars(range(min = 1, max = 64))]
    pub(super) branches: u32,
    /// Whether the fan of cracks opens both along the impact and against it.
    pub(super) two_sided: bool,
    /// Whether cracks walk along mesh edges instead of jumping from particle to particle.
    pub(super) snap_to_mesh: bool,
}

/// Which particles are neighbors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum NeighborhoodWord {
    /// All within the radius.
    Radius,
    /// Those that also share a mesh edge.
    MeshEdges,
}

/// How a crack chooses its next particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RuleWord {
    /// Highest stress.
    #[serde(rename = "algorithm-1")]
    Algorithm1,
    /// Highest stress on the more stressed side of the line of travel.
    Caption,
    /// Eqs. 3-5 to the letter.
    Literal,
}

/// How the crack looks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PaperOpticsTable {
    /// Optics model: "physical" or "paper"; decides which keys [optics] and [camera] have.
    pub(super) model: OpticsWord,
    /// What far focus blurs: "crack" (over the sharp scene) or "crack-and-scene" (as the paper's
    /// implementation has it).
    pub(super) far_focus_blur: FarFocusBlurWord,
    /// Azimuth of the sun, degrees, in the plane of the frame.
    pub(super) sun_azimuth_deg: f64,
    /// Elevation of the sun above the horizon, degrees (the paper's zenith angle is 90 minus it).
    pub(super) sun_elevation_deg: f64,
    /// Intensity of the light source: [r, g, b] as code values 0 to 255, or "image-mean".
    #[schemars(extend("minimum" = 0.0, "maximum" = 255.0))]
    pub(super) light_intensity: LightEntry,
    /// What the brightness of a crack is divided by: "max" (brightest crack), "mean", "sum" (the
    /// paper to the letter; nearly black) or "one".
    pub(super) normalization: NormalizationWord,
    /// Width of a drawn crack, px, 0.05 to 64.
    #[schemars(range(min = 0.05, max = 64.0))]
    pub(super) line_width_px: f64,
    /// Width of the blur kernel, px, odd, 1 to 255. Half of it is how far a crack reaches.
    #[schemars(range(min = 1, max = 255))]
    pub(super) blur_kernel_px: u32,
    /// Standard deviation of the Gaussian blur, px, 0.01 to 128.
    #[schemars(range(min = 0.01, max = 128.0))]
    pub(super) blur_sigma_px: f64,
}

/// What far focus blurs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FarFocusBlurWord {
    /// The crack alone.
    Crack,
    /// Scene and crack together.
    CrackAndScene,
}

/// Intensity of the light source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"image-mean\" or [r, g, b] as code values 0 to 255"
)]
pub(super) enum LightEntry {
    /// Code values per channel.
    Rgb([f64; 3]),
    /// The mean of each channel of the image.
    ImageMean(ImageMeanWord),
}

/// `"image-mean"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ImageMeanWord {
    /// The mean of each channel of the image.
    ImageMean,
}

/// What the brightness of a crack is divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum NormalizationWord {
    /// The sum over all segments.
    Sum,
    /// The brightest segment.
    Max,
    /// The mean segment.
    Mean,
    /// Nothing.
    One,
}
