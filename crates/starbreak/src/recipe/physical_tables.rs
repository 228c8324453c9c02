//! The tables of a recipe that only the physical optics have.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tables::{AutoWord, FocalEntry, OpticsWord};

/// What the physical optics read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct PhysicalOpticsTables {
    /// The camera behind the glass.
    pub(super) camera: PhysicalCameraTable,
    /// How the crack looks.
    pub(super) optics: PhysicalOpticsTable,
}

/// What the physical optics read of a pane that the paper's model breaks: its cracks are measured
/// in px of the frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct GlassMountTables {
    /// The pane, and how it stands before the camera.
    pub(super) glass: MountTable,
}

/// The pane, and how it stands before the camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MountTable {
    /// Thickness of the sheet that is hit (laminated: of the outer ply), mm, 0.1 to 30.
    #[schemars(range(min = 0.1, max = 30.0))]
    pub(super) thickness_mm: f64,
    /// Distance from the camera to the pane along the optical axis, m, 0.001 to 10.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub(super) distance_m: f64,
    /// Tilt of the pane about its horizontal axis, degrees from facing the camera (0), -80 to 80;
    /// positive: the upper edge leans towards the camera.
    #[schemars(range(min = -80.0, max = 80.0))]
    pub(super) rake_deg: f64,
}

/// The camera behind the glass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PhysicalCameraTable {
    /// Focal length, px, above 0 and up to 1000000, or "auto": from pixel_pitch_um if that is given, else 0.5809 times
    /// the width of the frame, KITTI's field of view at any resolution. Lays the frame over the
    /// pane.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1e6))]
    pub(super) f_px: FocalEntry,
    /// Focal length of the lens, mm, 0.1 to 1000. With f_number it gives the entrance pupil.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub(super) focal_length_mm: f64,
    /// Focal length over the diameter of the entrance pupil, 0.5 to 128.
    #[schemars(range(min = 0.5, max = 128.0))]
    pub(super) f_number: f64,
    /// What is sharp: a distance, m, 0.001 or more and beyond the focal length; "far" (scene_distance_m), "short"
    /// (glass.distance_m) or "infinity".
    #[schemars(extend("minimum" = 0.001))]
    pub(super) focus_distance_m: DistanceEntry,
    /// Distance of the scene, m, 0.001 or more, or "infinity".
    #[schemars(extend("minimum" = 0.001))]
    pub(super) scene_distance_m: SceneEntry,
    /// Pixel pitch of the sensor, um, 0.1 to 1000, or "auto": whatever f_px makes it. If f_px is
    /// given as well, the two must agree within 1 %.
    #[schemars(extend("minimum" = 0.1, "maximum" = 1000.0))]
    pub(super) pixel_pitch_um: AutoNumber,
    /// Blades of the diaphragm: 0 (a round pupil) or 3 to 24.
    #[schemars(range(min = 0, max = 24))]
    pub(super) blades: u32,
    /// Turn of the blades: direction of the first corner, degrees from +x towards +y (down),
    /// -360 to 360.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub(super) blade_angle_deg: f64,
}

/// Where the camera is focused.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"far\", \"short\", \"infinity\" or a distance in m"
)]
pub(super) enum DistanceEntry {
    /// At this distance, m.
    Meters(f64),
    /// At what a word names.
    Word(DistanceWord),
}

/// What a camera can be focused on by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum DistanceWord {
    /// The scene.
    Far,
    /// The glass.
    Short,
    /// Infinity.
    Infinity,
}

/// How far the scene is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"infinity\" or a distance in m")]
pub(super) enum SceneEntry {
    /// This far, m.
    Meters(f64),
    /// As far as anything.
    Word(InfinityWord),
}

/// `"infinity"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum InfinityWord {
    /// Without end.
    Infinity,
}

/// A number, or what something else makes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"auto\" or a number")]
pub(super) enum AutoNumber {
    /// This one.
    Number(f64),
    /// What something else makes it.
    Auto(AutoWord),
}

impl AutoNumber {
    pub(super) fn given(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Auto(_) => None,
        }
    }
}

/// A color, or what the image makes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"auto\" or [r, g, b] in linear light")]
pub(super) enum AutoRgb {
    /// This one.
    Rgb([f64; 3]),
    /// What the image makes it.
    Auto(AutoWord),
}

/// The light of the camera's side of the glass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"auto\", [r, g, b] in linear light, or two of them: straight down and straight up"
)]
pub(super) enum CabinEntry {
    /// The same everywhere.
    Even([f64; 3]),
    /// Straight down and straight up.
    Ends([[f64; 3]; 2]),
    /// What the image makes it.
    Auto(AutoWord),
}

/// How the crack looks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PhysicalOpticsTable {
    /// Optics model: "physical" or "paper"; decides which keys [optics] and [camera] have.
    pub(super) model: OpticsWord,
    /// Azimuth of the sun, degrees, from the optical axis to the right, -3600 to 3600.
    #[schemars(range(min = -3600.0, max = 3600.0))]
    pub(super) sun_azimuth_deg: f64,
    /// How fast that grows in a clip, degrees per second, -360 to 360: above 0 where the camera turns to the left.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub(super) sun_turns_deg_s: f64,
    /// Elevation of the sun above the horizon, degrees, -90 to 90.
    #[schemars(range(min = -90.0, max = 90.0))]
    pub(super) sun_elevation_deg: f64,
    /// Irradiance of the sun on a plane that faces it, 0 to 1000000 in linear light of the image
    /// (pi makes a white sheet show 1), or "auto": estimated from the image.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6))]
    pub(super) sun_irradiance: AutoNumber,
    /// Radiance of the sky at the horizon: [r, g, b] in linear light of the image (1 is white), 0 to
    /// 1000000, or "auto": estimated from the image.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6))]
    pub(super) sky_horizon: AutoRgb,
    /// Radiance of the sky at the zenith, as sky_horizon.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6))]
    pub(super) sky_zenith: AutoRgb,
    /// Radiance of the ground, as sky_horizon.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6))]
    pub(super) ground: AutoRgb,
    /// Radiance of what lies on the camera's side of the glass, as sky_horizon; or two colors,
    /// straight down and straight up.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6))]
    pub(super) cabin: CabinEntry,
    /// Row of the horizon as a fraction of the height of the frame, from the top, -100 to 100.
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(super) horizon_row: f64,
    /// Rows below which the frame shows the dashboard before the glass, not the glass, as fractions of its height from the
    /// top, 0 to 1: one, or up to 9 of columns evenly from the left to the right. [] shows glass all over.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "maxItems" = 9))]
    pub(super) dashboard_rows: Vec<f64>,
    /// Refractive index of the glass, 1.3 to 2 (soda-lime: 1.52).
    #[schemars(range(min = 1.3, max = 2.0))]
    pub(super) refractive_index: f64,
    /// Share of the light that the rim of the pane sends back into the glass, 0 (black, as the
    /// frit around a windscreen) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) rim_reflectance: f64,
    /// Roughness (GGX alpha) of the mirror zone of a crack surface, 0 to 1, or "auto": that of the
    /// network's roughness.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) mirror_alpha: AutoNumber,
    /// Roughness of the mist zone, as mirror_alpha.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) mist_alpha: AutoNumber,
    /// Roughness of the hackle zone, as mirror_alpha.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) hackle_alpha: AutoNumber,
    /// Opening of cracks whose network does not say it, um, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) opening_um: f64,
    /// Radius of the pit of crushed glass as a multiple of what the hit gave, 0 (none) to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) crushed_zone: f64,
    /// Radius of the shell that chips off around the pit as a multiple of that of the pit that the
    /// hit gave, 0 to 10; none up to 1.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) chip: f64,
    /// Mean slope of the flakes of the chipped surface, degrees, 0 to 60.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub(super) chip_slope_deg: f64,
    /// Radius of the film of air that runs sideways under the pit, as a multiple of that of the pit
    /// that the hit gave, 0 to 10; none up to 1.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) film: f64,
    /// Greatest thickness of that film, um, 0 to 100.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub(super) film_um: f64,
    /// Standard deviation of the wedge angle between the faces of a fragment, degrees, 0 to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) fragment_wedge_deg: f64,
    /// Share of the light that the lens spreads over the whole frame on top of what the image
    /// already has, 0 to 0.5.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub(super) veiling_glare: f64,
    /// Noise that is put back where light was added or taken away: standard deviation in the dark,
    /// 0 to 1 in linear light of the image. 0 for this and noise_shot: none.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) noise_read: f64,
    /// Variance of that noise over the signal, 0 to 1 in linear light of the image.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) noise_shot: f64,
    /// Influence from which a pixel belongs to the region mask, 0.0001 to 1.
    #[schemars(range(min = 0.0001, max = 1.0))]
    pub(super) region_threshold: f64,
}
