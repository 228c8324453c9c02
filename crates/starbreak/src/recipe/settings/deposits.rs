//! Settings of what lies on the pane, in SI units.

use std::f64::consts::FRAC_PI_2;

use starbreak_deposit::Rain;

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
        return Err(RecipeError::Type {
            place: place.clone(),
            key: "drops".to_owned(),
            what: "the paper's optics know no pane; set optics.model = \"physical\"".to_owned(),
        });
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
