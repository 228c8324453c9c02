//! Settings of the faults of the lens, in SI units.

use starbreak_optics::lens_faults::{
    Defocus, Distortion, Fringes, Ghosts, Glare, LensFace, LensFault, LensFaults, Projection,
    Shading, Shake, Star,
};

use super::super::error::{Place, RecipeError};
use super::super::tables::{
    DefocusTable, DistortionTable, FringesTable, GhostsTable, GlareTable, LensTables,
    ProjectionWord, ShadingTable, ShakeTable, StarTable,
};
use super::{OpticsSettings, out_of_range};

/// The lens with its faults.
pub(super) fn settings(
    place: &Place,
    given: &LensTables,
    optics: &OpticsSettings,
) -> Result<LensFaults, RecipeError> {
    if let Some(it) = &given.distortion
        && it.projection == ProjectionWord::Fisheye
    {
        for (key, value) in [
            ("distortion.corner_percent", it.corner_percent),
            ("distortion.p1", it.p1),
            ("distortion.p2", it.p2),
        ] {
            if value != 0.0 {
                let expected = "0 with distortion.projection = \"fisheye\"";
                return Err(out_of_range(place, key, value, expected));
            }
        }
    }
    if let Some(it) = &given.ghosts {
        let n = it.radius.len();
        if !(2..=40).contains(&n) || it.gap.len() != n || it.index.len() != n {
            let expected = "2 to 40 numbers, as many as in ghosts.gap and ghosts.index";
            let found = format!("{n}, {} and {} numbers", it.gap.len(), it.index.len());
            return Err(out_of_range(place, "ghosts.radius", found, expected));
        }
        if it.radius.iter().filter(|radius| **radius == 0.0).count() != 1 {
            let expected = "one 0, which is the stop";
            return Err(out_of_range(
                place,
                "ghosts.radius",
                "another number of stops",
                expected,
            ));
        }
    }
    if let Some(it) = &given.star
        && (1..3).contains(&it.blades)
    {
        let expected = "0 (no star), or 3 to 24";
        return Err(out_of_range(place, "star.blades", it.blades, expected));
    }
    // A table and the fault that it is.
    macro_rules! faults {
        ($($table:ident: $of:ident),*) => {
            [$((
                stringify!($table),
                given.$table.clone().map(|it| (it.onset_s, LensFault::from($of(it)))),
            )),*]
        };
    }
    let mut lens = LensFaults::with_headroom(given.lens.map_or(1.0, |it| it.headroom));
    for (table, fault) in faults!(
        distortion: distortion, fringes: fringes, defocus: defocus, shake: shake, ghosts: ghosts, star: star,
        glare: glare, shading: shading
    ) {
        if let Some((onset_s, fault)) = fault {
            if let OpticsSettings::Paper(_) = optics {
                return Err(RecipeError::Type {
                    place: place.clone(),
                    key: table.to_owned(),
                    what: "the paper's optics know no lens; set optics.model = \"physical\""
                        .to_owned(),
                });
            }
            lens.push(onset_s, fault);
        }
    }
    Ok(lens)
}

fn distortion(it: DistortionTable) -> Distortion {
    let (projection, k4) = match it.projection {
        ProjectionWord::Brown => (Projection::Brown, 0.0),
        ProjectionWord::Fisheye => (Projection::Fisheye, it.k4),
    };
    Distortion {
        projection,
        k: [it.k1, it.k2, it.k3, k4],
        p: [it.p1, it.p2],
        corner: it.corner_percent / 100.0,
        shift_px: it.shift_px,
    }
}

fn fringes(it: FringesTable) -> Fringes {
    Fringes {
        lateral_px: it.lateral_px,
        axial_m: it.axial_um * 1e-6,
    }
}

fn defocus(it: DefocusTable) -> Defocus {
    Defocus {
        sensor_shift_m: (it.sensor_shift_um + it.warmer_k * it.um_per_k) * 1e-6,
    }
}

fn shake(it: ShakeTable) -> Shake {
    Shake {
        rate_rad_s: it.rate_deg_s.to_radians(),
        direction_rad: it.direction_deg.to_radians(),
        frequency_hz: it.frequency_hz,
        exposure_s: it.exposure_ms * 1e-3,
    }
}

fn ghosts(it: GhostsTable) -> Ghosts {
    let faces = it.radius.iter().zip(&it.gap).zip(&it.index);
    Ghosts {
        reflectance: it.reflectance_percent / 100.0,
        faces: faces
            .map(|((radius, gap), index)| LensFace {
                radius: *radius,
                gap: *gap,
                index: *index,
            })
            .collect(),
    }
}

fn star(it: StarTable) -> Star {
    Star {
        blades: it.blades,
        angle_rad: it.angle_deg.to_radians(),
    }
}

fn glare(it: GlareTable) -> Glare {
    Glare {
        veil: it.veil_percent / 100.0,
    }
}

fn shading(it: ShadingTable) -> Shading {
    Shading {
        corner_loss: it.corner_loss_percent / 100.0,
    }
}
