//! The tables of a recipe that turn a fault of the lens on: one that is there is a fault that is there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The faults of the lens, in the order in which light meets them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct LensTables {
    /// Lines that bend, and a picture that is moved, and labels with it. Without this table there are none.
    #[schemars(with = "DistortionTable")]
    pub(super) distortion: Option<DistortionTable>,
    /// Colored fringes along edges. Without this table there are none.
    #[schemars(with = "FringesTable")]
    pub(super) fringes: Option<FringesTable>,
    /// A sensor out of the focal plane. Without this table it is where it belongs.
    #[schemars(with = "DefocusTable")]
    pub(super) defocus: Option<DefocusTable>,
    /// A camera that turns or trembles while it exposes. Without this table it is still.
    #[schemars(with = "ShakeTable")]
    pub(super) shake: Option<ShakeTable>,
    /// Ghosts of lamps and of the sun. Without this table there are none.
    #[schemars(with = "GhostsTable")]
    pub(super) ghosts: Option<GhostsTable>,
    /// Stars through lamps. Without this table there are none.
    #[schemars(with = "StarTable")]
    pub(super) star: Option<StarTable>,
    /// Light that the lens scatters. Without this table there is none.
    #[schemars(with = "GlareTable")]
    pub(super) glare: Option<GlareTable>,
    /// Corners that get less light. Without this table they get as much as the middle.
    #[schemars(with = "ShadingTable")]
    pub(super) shading: Option<ShadingTable>,
    /// What the image does not tell the lens. Without this table nothing was brighter than white.
    #[schemars(with = "LensTable")]
    pub(super) lens: Option<LensTable>,
}

/// Lines that bend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DistortionTable {
    /// "brown" (k1, k2, k3, p1, p2 as of OpenCV), or "fisheye" (k1 to k4 as of its fisheye module).
    pub(super) projection: ProjectionWord,
    /// How much farther out a corner is moved, percent of half the diagonal, -50 to 50; below 0 the picture shrinks to a
    /// barrel, and what the image does not show is black. It is added to k1 of "brown", and must be 0 with "fisheye".
    #[schemars(range(min = -50.0, max = 50.0))]
    pub(super) corner_percent: f64,
    /// First radial coefficient, -10 to 10.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) k1: f64,
    /// Second radial coefficient, -10 to 10.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) k2: f64,
    /// Third radial coefficient, -10 to 10.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) k3: f64,
    /// Fourth radial coefficient, -10 to 10; "brown" has none and does not read it.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) k4: f64,
    /// First tangential coefficient, -1 to 1; of "brown" alone.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub(super) p1: f64,
    /// Second tangential coefficient, -1 to 1; of "brown" alone.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub(super) p2: f64,
    /// How far the picture is moved to the right and down, px, each -1000 to 1000, as by a knock on the camera.
    #[schemars(extend("minimum" = -1000.0, "maximum" = 1000.0))]
    pub(super) shift_px: [f64; 2],
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// How a lens projects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ProjectionWord {
    /// By Brown and Conrady's law.
    Brown,
    /// By Kannala and Brandt's, of fisheyes.
    Fisheye,
}

/// Colored fringes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FringesTable {
    /// How much farther from the middle red is than blue in a corner, px, -50 to 50. 0: none.
    #[schemars(range(min = -50.0, max = 50.0))]
    pub(super) lateral_px: f64,
    /// How far behind the sensor red is sharp, and blue before it, um, -200 to 200. 0: none.
    #[schemars(range(min = -200.0, max = 200.0))]
    pub(super) axial_um: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// A sensor out of the focal plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DefocusTable {
    /// Way of the sensor from where the picture is sharp, um, -500 to 500; above 0 away from the lens. 0: none.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub(super) sensor_shift_um: f64,
    /// How much warmer than where it was focused, K, -150 to 150.
    #[schemars(range(min = -150.0, max = 150.0))]
    pub(super) warmer_k: f64,
    /// Way of the sensor for each kelvin, um, -10 to 10: that of mount and lens together. No value fits all lenses.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) um_per_k: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// A camera that turns while it exposes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ShakeTable {
    /// Fastest turn, degrees per second, 0 to 500. 0: none.
    #[schemars(range(min = 0.0, max = 500.0))]
    pub(super) rate_deg_s: f64,
    /// Direction in which the picture moves, degrees from right towards down, -180 to 180.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub(super) direction_deg: f64,
    /// How often it goes to and fro, Hz, 0 to 2000; 0: it turns evenly.
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub(super) frequency_hz: f64,
    /// How long a frame is exposed, ms, 0.01 to 1000.
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub(super) exposure_ms: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Light that two faces of the lens mirror, one after the other: images of the aperture thrown by lamps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GhostsTable {
    /// Green light that each face mirrors, percent, 0 (none) to 8: coated glass 0.2 to 1, bare glass 4.
    #[schemars(range(min = 0.0, max = 8.0))]
    pub(super) reflectance_percent: f64,
    /// The faces of the lens from the front on, 2 to 40: each [radius, way to the next face, refractive index behind it],
    /// in any unit of length. A radius is above 0 where its center is behind the face, and 1000000 where it is flat; one is
    /// 0, which is the stop.
    pub(super) faces: Vec<[f64; 3]>,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Light that the edges of the aperture diffract: a star through each lamp that is brighter than white, as bright as
/// `lens.headroom` says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StarTable {
    /// Blades of the aperture: 0 (no star), or 3 to 24. An even number has as many spikes, an odd one twice as many.
    #[schemars(range(min = 0, max = 24))]
    pub(super) blades: u32,
    /// Direction of its first corner, degrees from right towards down, -180 to 180.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub(super) angle_deg: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Light that the lens scatters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GlareTable {
    /// Veiling glare, percent of white in a black patch before a white scene (ISO 9358), 0 (none) to 50. The
    /// patch is a tenth as wide as the shorter side of the frame. The sun of [optics] is scattered, too.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub(super) veil_percent: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Corners that get less light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ShadingTable {
    /// Light that a corner loses, percent, 0 (none) to 95.
    #[schemars(range(min = 0.0, max = 95.0))]
    pub(super) corner_loss_percent: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// What an image does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LensTable {
    /// How many times as bright as white lamps were that are clipped in the image, 1 to 1000, before their light meets
    /// glass and lens: spots of up to a ten-thousandth of the frame; larger ones less, a sky next to nothing.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub(super) headroom: f64,
}
