//! The tables of a recipe that put something on the pane.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What lies on the pane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct DepositTables {
    /// Drops of rain on the outer face. Without this table there are none.
    #[schemars(with = "DropsTable")]
    pub(super) drops: Option<DropsTable>,
    /// Dew on the inner face. Without this table there is none.
    #[schemars(with = "CondensationTable")]
    pub(super) condensation: Option<CondensationTable>,
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
    /// How long it has rained since the pane was wiped, s, 0 to 600.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub(super) age_s: f64,
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
    /// How long water has condensed, s, 0 (none) to 100000.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub(super) age_s: f64,
    /// How fast, as the film that it would be, um/s, 0 to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub(super) growth_um_s: f64,
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
