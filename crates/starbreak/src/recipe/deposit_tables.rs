//! The tables of a recipe that put something on the pane.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What lies on the pane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct DepositTables {
    /// Grooves in the outer face. Without this table there are none.
    #[schemars(with = "ScratchesTable")]
    pub(super) scratches: Option<ScratchesTable>,
    /// Mud on the outer face. Without this table there is none.
    #[schemars(with = "MudTable")]
    pub(super) mud: Option<MudTable>,
    /// Dust on the glass. Without this table there is none.
    #[schemars(with = "DustTable")]
    pub(super) dust: Option<DustTable>,
    /// A film of grease. Without this table there is none.
    #[schemars(with = "FilmTable")]
    pub(super) film: Option<FilmTable>,
    /// Frost. Without this table there is none.
    #[schemars(with = "FrostTable")]
    pub(super) frost: Option<FrostTable>,
    /// Drops of rain on the outer face. Without this table there are none.
    #[schemars(with = "DropsTable")]
    pub(super) drops: Option<DropsTable>,
    /// Dew on the inner face. Without this table there is none.
    #[schemars(with = "CondensationTable")]
    pub(super) condensation: Option<CondensationTable>,
}

/// Scratches of sand and wipers, too fine to be seen one by one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ScratchesTable {
    /// Haze: the share of a beam that they turn by more than 2.5 degrees, percent, 0 (none) to 20.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub(super) haze_percent: f64,
    /// How much of it is of scratches along the wiper's way, percent, 0 (sand alone) to 100: they draw streaks through lamps.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub(super) wiper_percent: f64,
    /// Where the wiper turns, mm on the glass right and down of where the optical axis meets it, -2000 to 2000 each.
    #[schemars(extend("minimum" = -2000.0, "maximum" = 2000.0))]
    pub(super) pivot_mm: [f64; 2],
}

/// Splats of mud that have dried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MudTable {
    /// How much of the glass it covers, percent, 0 (none) to 80.
    #[schemars(range(min = 0.0, max = 80.0))]
    pub(super) coverage_percent: f64,
    /// Median diameter of a splat, mm, 2 to 40.
    #[schemars(range(min = 2.0, max = 40.0))]
    pub(super) splat_mm: f64,
    /// How thick splats of that diameter hit the glass, um, 10 to 2000; larger ones are thicker. Thin mud is brown
    /// glass, thick mud lets nothing through, and what is thicker than 250 um runs down.
    #[schemars(range(min = 10.0, max = 2000.0))]
    pub(super) thickness_um: f64,
    /// What it absorbs of red, green and blue per mm, 0 to 200.
    #[schemars(extend("minimum" = 0.0, "maximum" = 200.0))]
    pub(super) absorption_per_mm: [f64; 3],
    /// What it scatters per mm, 0.1 to 200.
    #[schemars(range(min = 0.1, max = 200.0))]
    pub(super) scattering_per_mm: f64,
}

/// Grains of dust of all sizes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DustTable {
    /// How much of the glass it covers, percent, 0 (none) to 30.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub(super) coverage_percent: f64,
    /// How much of the light that meets a grain is not absorbed, 0 (soot) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) albedo: f64,
    /// How much more dust lies in some places than in the mean, and less in others, a share of it, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) unevenness: f64,
    /// How large such places are, mm, 5 to 1000.
    #[schemars(range(min = 5.0, max = 1000.0))]
    pub(super) scale_mm: f64,
}

/// A film of grease or water whose thickness varies: it bends what is seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FilmTable {
    /// Standard deviation of its thickness, um, 0 to 200.
    #[schemars(range(min = 0.0, max = 200.0))]
    pub(super) ripple_um: f64,
    /// From one thick place to the next, mm, 1 to 50.
    #[schemars(range(min = 1.0, max = 50.0))]
    pub(super) scale_mm: f64,
    /// How much of the light it scatters, percent, 0 to 50.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub(super) haze_percent: f64,
}

/// Crystals of ice that grow from nuclei.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrostTable {
    /// How long it has been there, s, 0 (none) to 100000; in a clip at its first frame.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub(super) age_s: f64,
    /// Age from which it grows no more and melts, s, 0 or more; inf: never.
    #[schemars(range(min = 0.0))]
    pub(super) melts_from_s: f64,
    /// How fast it becomes thinner then, um/s, 0 to 1000: 1 takes 306 W/m2, as a heated pane has them.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) melting_um_s: f64,
    /// What heats the pane then: "vents" along its lower edge, so that it clears from there, or the "pane" itself, all alike.
    pub(super) heated_by: HeatingWord,
    /// Speed of the tips of crystals, um/s, 0 to 1000: the colder and moister, the faster.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) front_um_s: f64,
    /// Nuclei per cm2, 0.001 to 20: few on clean glass, many on dusty.
    #[schemars(range(min = 0.001, max = 20.0))]
    pub(super) seeds_per_cm2: f64,
    /// How much of the glass between crystals is covered by dew that froze, in the end, percent, 0 to 55.
    #[schemars(range(min = 0.0, max = 55.0))]
    pub(super) rime_percent: f64,
}

/// Drops of rain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DropsTable {
    /// Rate of the rain, mm/h, 0 (none) to 150: light up to 2.5, moderate up to 7.6, heavy above.
    #[schemars(range(min = 0.0, max = 150.0))]
    pub(super) rain_mm_h: f64,
    /// Speed of the camera, m/s, 0 to 60: a fast one meets more rain, and wind drives large drops upwards.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub(super) speed_m_s: f64,
    /// How long it has rained since the pane was wiped, s, 0 to 600; in a clip at its first frame.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub(super) age_s: f64,
    /// From one stroke of the wiper to the next in a clip, s, 0 (no wiper) to 600: it goes there and back and leaves a pane
    /// without drops. It starts when it has rained for a whole number of periods; an image by itself is not wiped.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub(super) wiper_period_s: f64,
    /// Contact angle of water on the glass, degrees, 10 to 110: clean glass some 10 to 30, a used windscreen 40 to 60, a
    /// repellent coating 100.
    #[schemars(range(min = 10.0, max = 110.0))]
    pub(super) contact_deg: f64,
    /// How much greater that angle is before a drop moves at its front than at its back, degrees, 1 to 60: the more, the
    /// larger the drops that stay.
    #[schemars(range(min = 1.0, max = 60.0))]
    pub(super) hysteresis_deg: f64,
}

/// Dew, as where breath and wet clothes meet a cold windscreen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CondensationTable {
    /// How long water has been there, s, 0 (none) to 100000; in a clip at its first frame.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub(super) age_s: f64,
    /// How fast, as the film that it would be, um/s, 0 to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) growth_um_s: f64,
    /// Age from which no more condenses and what is there evaporates, s, 0 or more; inf: never.
    #[schemars(range(min = 0.0))]
    pub(super) clears_from_s: f64,
    /// How fast it does then, as the film that it would be, um/s, 0 to 10: 0.1 takes 245 W/m2, as a heated pane has them.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) clearing_um_s: f64,
    /// What heats the pane then, as for frost: "vents" along its lower edge, or the "pane" itself.
    pub(super) heated_by: HeatingWord,
    /// Places per mm2 at which drops begin, 10 to 10000: the more, the finer the dew.
    #[schemars(range(min = 10.0, max = 1e4))]
    pub(super) nuclei_per_mm2: f64,
    /// Contact angle of water on the glass, degrees, 20 to 90.
    #[schemars(range(min = 20.0, max = 90.0))]
    pub(super) contact_deg: f64,
    /// How much more water condenses in some places than in the mean, and less in others, a share of it, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) unevenness: f64,
    /// How large such places are, mm, 5 to 1000.
    #[schemars(range(min = 5.0, max = 1000.0))]
    pub(super) scale_mm: f64,
}

/// What heats a pane that clears.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum HeatingWord {
    /// The pane itself.
    Pane,
    /// Warm air along its lower edge.
    Vents,
}
