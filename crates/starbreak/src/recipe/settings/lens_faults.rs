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
        check_faces(place, &it.faces)?;
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
    Ghosts {
        reflectance: it.reflectance_percent / 100.0,
        faces: (it.faces.iter())
            .map(|[radius, gap, index]| LensFace {
                radius: *radius,
                gap: *gap,
                index: *index,
            })
            .collect(),
    }
}

/// A lens that could be.
fn check_faces(place: &Place, faces: &[[f64; 3]]) -> Result<(), RecipeError> {
    let refused =
        |found: String, expected: &str| Err(out_of_range(place, "ghosts.faces", found, expected));
    if !(2..=40).contains(&faces.len()) {
        return refused(format!("{} faces", faces.len()), "2 to 40");
    }
    for face in faces {
        let [radius, gap, index] = *face;
        let is_good =
            radius.abs() <= 1e6 && (0.0..=1e6).contains(&gap) && (1.0..=4.0).contains(&index);
        if !is_good {
            let expected = "[radius up to 1000000, gap from 0 to 1000000, index from 1 to 4]";
            return refused(format!("{face:?}"), expected);
        }
    }
    for (k, face) in faces.iter().enumerate() {
        let before = if k == 0 { 1.0 } else { faces[k - 1][2] };
        if face[0].abs() <= 0.0 && (face[2] - before).abs() > 0.0 {
            let found = format!("a stop of index {} behind {before}", face[2]);
            return refused(found, "a stop in one medium");
        }
    }
    let n_stops = faces.iter().filter(|face| face[0].abs() <= 0.0).count();
    if n_stops != 1 {
        return refused(
            format!("{n_stops} faces of radius 0"),
            "one, which is the stop",
        );
    }
    Ok(())
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
