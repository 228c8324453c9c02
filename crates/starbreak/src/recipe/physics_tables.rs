//! The tables of a recipe that only the `physics` model has.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tables::{DirectionEntry, ModelWord, PositionEntry};

/// What the physics reads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct PhysicsFractureTables {
    /// The pane, and how it stands before the camera.
    pub(super) glass: GlassTable,
    /// The hits, one table each, in the order in which they happen.
    pub(super) impact: Vec<StoneTable>,
    /// How the glass breaks.
    pub(super) fracture: PhysicsFractureTable,
    /// A long crack under heat or the pull of the frame, after the hits. Without this table there
    /// is none.
    #[schemars(with = "LongCrackTable")]
    pub(super) long_crack: Option<LongCrackTable>,
}

/// The pane, and how it stands before the camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GlassTable {
    /// How the pane was made: "annealed" (one sheet), "laminated" (windscreen), "tempered" or
    /// "cover" (a disc over a lens, annealed unless surface_compression_mpa is given).
    pub(super) kind: KindWord,
    /// Width, mm, 2 to 10000.
    #[schemars(range(min = 2.0, max = 1e4))]
    pub(super) width_mm: f64,
    /// Height, mm, 2 to 10000; that of a cover is its width, and an override of either sets both.
    #[schemars(range(min = 2.0, max = 1e4))]
    pub(super) height_mm: f64,
    /// Thickness of the sheet that is hit (laminated: of the outer ply), mm, 0.1 to 30.
    #[schemars(range(min = 0.1, max = 30.0))]
    pub(super) thickness_mm: f64,
    /// Laminated only: thickness of the interlayer, mm, 0.05 to 20.
    #[schemars(with = "f64", range(min = 0.05, max = 20.0))]
    pub(super) interlayer_thickness_mm: Option<f64>,
    /// Laminated only: Young's modulus of the interlayer over the time of the hit, MPa, 0.1 to
    /// 10000 (PVB: 30 at 0.1 s to 1000 at microseconds).
    #[schemars(with = "f64", range(min = 0.1, max = 1e4))]
    pub(super) interlayer_modulus_mpa: Option<f64>,
    /// Laminated only: thickness of the inner ply, mm, 0.1 to 30.
    #[schemars(with = "f64", range(min = 0.1, max = 30.0))]
    pub(super) inner_thickness_mm: Option<f64>,
    /// Tempered or cover only: compression of the surfaces, MPa, 0.1 to 1000; up to 48 the pane cracks
    /// without going to pieces, as heat-strengthened glass does.
    #[schemars(with = "f64", range(min = 0.1, max = 1000.0))]
    pub(super) surface_compression_mpa: Option<f64>,
    /// How the rim is held: "simply-supported" (gasket) or "clamped" (stiff ring).
    pub(super) support: SupportWord,
    /// Distance from the camera to the pane along the optical axis, m, 0.001 to 10.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub(super) distance_m: f64,
    /// Tilt of the pane about its horizontal axis, degrees from facing the camera (0), -80 to 80;
    /// positive: the upper edge leans towards the camera.
    #[schemars(range(min = -80.0, max = 80.0))]
    pub(super) rake_deg: f64,
    /// Where the optical axis meets the pane: [x, y] as fractions of its width and height.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) axis_at: [f64; 2],
}

/// How a pane was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum KindWord {
    /// One sheet, free of stress.
    Annealed,
    /// Two plies with a polymer between them.
    Laminated,
    /// Surfaces in compression.
    Tempered,
    /// A disc over a lens.
    Cover,
}

/// How the rim of a pane is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SupportWord {
    /// It cannot move, but turn.
    SimplySupported,
    /// It can neither move nor turn.
    Clamped,
}

/// What a stone is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum StoneWord {
    /// Granite.
    Granite,
    /// Ice.
    Ice,
    /// Skin and flesh over bone, or what tests put in their place.
    Head,
}

/// Hits by stones of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StoneTable {
    /// Where: [x, y] as fractions of the frame, from the top left corner; "random", in the
    /// inner 80 % of the frame; "anywhere"; or "object", before a labeled object of the image
    /// (`generate` and `study` of a labeled dataset).
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) position: PositionEntry,
    /// Speed of the stone, m/s, 0.01 to 1000.
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub(super) speed_m_s: f64,
    /// Radius of the sphere of the stone's mass, mm, 0.05 to 200.
    #[schemars(range(min = 0.05, max = 200.0))]
    pub(super) radius_mm: f64,
    /// Radius of curvature where the stone touches, mm, 0.01 to 200 and no more than radius_mm: small for a sharp stone.
    #[schemars(range(min = 0.01, max = 200.0))]
    pub(super) tip_radius_mm: f64,
    /// Angle between the path and the normal of the pane, degrees, 0 (head-on) to 85.
    #[schemars(range(min = 0.0, max = 85.0))]
    pub(super) angle_deg: f64,
    /// Direction of the path in the plane of the pane, degrees from +x towards +y (down), -1000000
    /// to 1000000, or "random".
    #[schemars(extend("minimum" = -1e6, "maximum" = 1e6))]
    pub(super) azimuth_deg: DirectionEntry,
    /// Density of the stone, kg/m3, 100 to 25000 (granite: 2650).
    #[schemars(range(min = 100.0, max = 25000.0))]
    pub(super) density_kg_m3: f64,
    /// How stiff and how hard it is: "granite", "ice" or "head".
    pub(super) material: StoneWord,
    /// How many such stones hit, one after the other, 1 to 600 in all on laminated glass, to 120 on
    /// other kinds; each has its own place, direction and size where those are random. More of them
    /// add to the same ones.
    #[schemars(range(min = 1, max = 600))]
    pub(super) count: u32,
    /// Standard deviation of the logarithm of their radius and tip radius, 0 to 2.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub(super) radius_spread: f64,
}

/// How the glass breaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PhysicsFractureTable {
    /// Fracture model: "physics" or "paper"; decides which keys [fracture] and [[impact]] have.
    pub(super) model: ModelWord,
    /// How fine the mesh of the plate is: "default" or "fast".
    pub(super) mesh: MeshWord,
    /// How often the stress is solved anew as cracks grow, 1 to 6.
    #[schemars(range(min = 1, max = 6))]
    pub(super) epochs: u32,
    /// How tempered glass goes to pieces: "cells" (as many as stress and thickness give) or
    /// "cascade" (cracks that branch under the tension of the core).
    pub(super) dicing: DicingWord,
    /// Prefactor of the number of radial cracks, 0.1 to 100.
    #[schemars(range(min = 0.1, max = 100.0))]
    pub(super) radial_count_factor: f64,
    /// Characteristic tensile strength of the surface under a hit, MPa, 1 to 10000.
    #[schemars(range(min = 1.0, max = 1e4))]
    pub(super) strength_mpa: f64,
    /// Weibull modulus of that strength, 1 to 100: how little it scatters.
    #[schemars(range(min = 1.0, max = 100.0))]
    pub(super) weibull_modulus: f64,
    /// Everything stops at the moment at which a crack gets this far from the first hit, 0.1 to
    /// 20000 mm; "end": nothing is stopped. A smaller reach gives an earlier state of the same event.
    #[schemars(extend("minimum" = 0.1, "maximum" = 2e4))]
    pub(super) until_reach_mm: ReachEntry,
    /// How many pieces have fallen out in the end, 0 to 1000: first those that do not touch the
    /// rim, the largest first, then those of which the rim holds the smallest part.
    #[schemars(range(min = 0, max = 1000))]
    pub(super) fallen_pieces: u32,
}

/// How far cracks may get.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"end\" or a distance in mm")]
pub(super) enum ReachEntry {
    /// This far from the first hit, mm.
    Mm(f64),
    /// As far as they get.
    Word(EndWord),
}

/// `"end"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum EndWord {
    /// The end of the event.
    End,
}

/// How fine the mesh is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum MeshWord {
    /// About 1500 nodes, or 500 where only what is smooth is left to the mesh.
    Fast,
    /// About 6000 nodes, or 1500 where only what is smooth is left to the mesh.
    Default,
}

/// How tempered glass goes to pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DicingWord {
    /// Cells around random points.
    Cells,
    /// Branching cracks.
    Cascade,
}

/// A crack under heat or the pull of the frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LongCrackTable {
    /// Where it begins: "rim" (at the most stressed place of the rim), "impact" (at the tip of
    /// the longest crack of the first hit) or "legs" (at the tips of all cracks of each hit, before the next).
    pub(super) origin: OriginWord,
    /// Temperature of the warm spot over that of the rest, K, -300 to 300 (negative: a cold spot).
    #[schemars(range(min = -300.0, max = 300.0))]
    pub(super) temperature_difference_k: f64,
    /// Centre of the warm spot: [x, y] as fractions of the pane's width and height.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0))]
    pub(super) spot: [f64; 2],
    /// Standard deviation of the spot, as a fraction of the pane's shorter side, 0.05 to 5.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub(super) spot_size: f64,
    /// Uniform tension from the frame, MPa, 0 to 100.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub(super) frame_tension_mpa: f64,
    /// Direction of that tension, degrees from +x towards +y (down), -1000000 to 1000000.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub(super) frame_direction_deg: f64,
    /// Length of the flaw that the crack begins at, mm, 0.01 to 100.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub(super) flaw_mm: f64,
    /// How fast it grows: "sudden" (a running crack) or "slow" (stress corrosion under repeated
    /// load).
    pub(super) growth: GrowthWord,
    /// For slow growth: time between two loads, s, 0.001 to 1000000.
    #[schemars(range(min = 0.001, max = 1e6))]
    pub(super) period_s: f64,
}

/// Where a long crack begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OriginWord {
    /// At the rim.
    Rim,
    /// At the longest crack of the first hit.
    Impact,
    /// At all cracks of the first hit.
    Legs,
}

/// How fast a long crack grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum GrowthWord {
    /// As a running crack.
    Sudden,
    /// By stress corrosion.
    Slow,
}
