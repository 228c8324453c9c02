//! Settings of what lies on the pane, in SI units.

use std::f64::consts::FRAC_PI_2;

use starbreak_deposit::{
    Coat, Condensation, Dust, Film, Fog, Frost, Heating, Mud, Rain, Scratches,
};

use super::super::deposit_tables::{
    CondensationTable, DustTable, FilmTable, FrostTable, HeatingWord, MudTable, ScratchesTable,
};
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
    Ok((it.rain_mm_h > 0.0).then(|| Rain {
        rate_m_s: it.rain_mm_h * 1e-3 / 3600.0,
        speed_m_s: it.speed_m_s,
        age_s: it.age_s,
        wiper_period_s: it.wiper_period_s,
        contact_rad: it.contact_deg.to_radians(),
        hysteresis_rad: it.hysteresis_deg.to_radians(),
        slope_rad: FRAC_PI_2 - mount.rake_rad,
    }))
}

/// The coats on the pane, outer ones first.
pub(super) fn coats(
    place: &Place,
    given: &DepositTables,
    fracture: &FractureSettings,
    optics: &OpticsSettings,
) -> Result<Vec<Coat>, RecipeError> {
    let coats = [
        ("mud", given.mud.map(mud)),
        ("dust", given.dust.map(dust)),
        ("film", given.film.map(film)),
        ("frost", given.frost.map(frost)),
        ("scratches", given.scratches.map(scratches)),
        ("condensation", given.condensation.map(fog)),
    ];
    let mut on_pane = Vec::new();
    for (table, coat) in coats {
        let Some(coat) = coat else { continue };
        let (OpticsSettings::Physical(_), Some(_)) = (optics, fracture.mount()) else {
            return Err(without_pane(place, table));
        };
        on_pane.extend(coat);
    }
    Ok(on_pane)
}

fn mud(it: MudTable) -> Option<Coat> {
    (it.coverage_percent > 0.0).then_some(Coat::Mud(Mud {
        coverage: 0.01 * it.coverage_percent,
        splat_mm: it.splat_mm,
        thickness_mm: 1e-3 * it.thickness_um,
        absorbs_per_mm: it.absorption_per_mm,
        scatters_per_mm: it.scattering_per_mm,
    }))
}

fn dust(it: DustTable) -> Option<Coat> {
    (it.coverage_percent > 0.0).then_some(Coat::Dust(Dust {
        coverage: 0.01 * it.coverage_percent,
        albedo: it.albedo,
        unevenness: it.unevenness,
        scale_mm: it.scale_mm,
    }))
}

fn film(it: FilmTable) -> Option<Coat> {
    (it.ripple_um > 0.0 || it.haze_percent > 0.0).then_some(Coat::Film(Film {
        ripple_m: 1e-6 * it.ripple_um,
        scale_mm: it.scale_mm,
        haze: 0.01 * it.haze_percent,
    }))
}

fn frost(it: FrostTable) -> Option<Coat> {
    (it.front_um_s > 0.0).then_some(Coat::Frost(Frost {
        age_s: it.age_s,
        melts_from_s: it.melts_from_s,
        melts_mm_s: 1e-3 * it.melting_um_s,
        heated_by: heating(it.heated_by),
        front_mm_s: 1e-3 * it.front_um_s,
        nuclei_per_mm2: 0.01 * it.seeds_per_cm2,
        rime: 0.01 * it.rime_percent,
    }))
}

fn scratches(it: ScratchesTable) -> Option<Coat> {
    (it.haze_percent > 0.0).then_some(Coat::Scratches(Scratches {
        haze: 0.01 * it.haze_percent,
        wiped: 0.01 * it.wiper_percent,
        pivot_mm: it.pivot_mm,
    }))
}

fn fog(it: CondensationTable) -> Option<Coat> {
    (it.growth_um_s > 0.0).then_some(Coat::Fog(Fog {
        mean: Condensation {
            growth_m_s: it.growth_um_s * 1e-6,
            age_s: it.age_s,
            clears_from_s: it.clears_from_s,
            clears_m_s: it.clearing_um_s * 1e-6,
            nuclei_per_m2: it.nuclei_per_mm2 * 1e6,
            contact_rad: it.contact_deg.to_radians(),
        },
        unevenness: it.unevenness,
        scale_mm: it.scale_mm,
        heated_by: heating(it.heated_by),
    }))
}

fn heating(word: HeatingWord) -> Heating {
    match word {
        HeatingWord::Pane => Heating::Pane,
        HeatingWord::Vents => Heating::Vents {
            edge_mm: f64::INFINITY,
        },
    }
}

fn without_pane(place: &Place, table: &str) -> RecipeError {
    RecipeError::Type {
        place: place.clone(),
        key: table.to_owned(),
        what: "the paper's optics know no pane; set optics.model = \"physical\"".to_owned(),
    }
}
