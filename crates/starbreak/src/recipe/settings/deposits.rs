//! Settings of what lies on the pane, in SI units.

use std::f64::consts::FRAC_PI_2;

use starbreak_deposit::{Condensation, Rain};

use super::super::error::{Place, RecipeError};
use super::super::tables::DepositTables;
use super::{FractureSettings, OpticsSettings};

/// Rain on the pane; none where it does not rain.
pub(super) fn drops(
    place: &Place,
    given: &DepositTables,
    fracture: &FractureSettings,
    optics: &OpticsSettings,
) -> Result<Option<Rain>, RecipeError> {
    let Some(it) = &given.drops else {
        return Ok(None);
    };
    let (OpticsSettings::Physical(_), Some(mount)) = (optics, fracture.mount()) else {
        return Err(without_pane(place, "drops"));
    };
    let is_wet = it.rain_mm_h > 0.0 && it.age_s > 0.0;
    Ok(is_wet.then(|| Rain {
        rate_m_s: it.rain_mm_h * 1e-3 / 3600.0,
        speed_m_s: it.speed_m_s,
        age_s: it.age_s,
        contact_rad: it.contact_deg.to_radians(),
        hysteresis_rad: it.hysteresis_deg.to_radians(),
        slope_rad: FRAC_PI_2 - mount.rake_rad,
    }))
}

/// Dew on a pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DewSettings {
    /// In the mean over the pane.
    pub mean: Condensation,
    /// How much more or less there is in places, a share of the mean.
    pub unevenness: f64,
    /// How large such places are, mm.
    pub scale_mm: f64,
}

/// Dew on the pane; none where nothing condenses.
pub(super) fn dew(
    place: &Place,
    given: &DepositTables,
    fracture: &FractureSettings,
    optics: &OpticsSettings,
) -> Result<Option<DewSettings>, RecipeError> {
    let Some(it) = &given.condensation else {
        return Ok(None);
    };
    let (OpticsSettings::Physical(_), Some(_)) = (optics, fracture.mount()) else {
        return Err(without_pane(place, "condensation"));
    };
    let is_wet = it.age_s > 0.0 && it.growth_um_s > 0.0;
    Ok(is_wet.then(|| DewSettings {
        mean: Condensation {
            growth_m_s: it.growth_um_s * 1e-6,
            age_s: it.age_s,
            nuclei_per_m2: it.nuclei_per_mm2 * 1e6,
            contact_rad: it.contact_deg.to_radians(),
        },
        unevenness: it.unevenness,
        scale_mm: it.scale_mm,
    }))
}

fn without_pane(place: &Place, table: &str) -> RecipeError {
    RecipeError::Type {
        place: place.clone(),
        key: table.to_owned(),
        what: "the paper's optics know no pane; set optics.model = \"physical\"".to_owned(),
    }
}
