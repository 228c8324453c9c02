//! Settings of the physical optics: lens, light and the surfaces of cracks in SI units.

use starbreak_fracture::physics::GlassBuild;
use starbreak_optics::environment::{Dashboard, EnvironmentParams, Rgb};
use starbreak_optics::lens::Lens;
use starbreak_optics::physical::{Glass, PhysicalOptics, SensorNoise, SurfaceParams};
use toml::Table;

use super::super::error::{Place, RecipeError};
use super::super::tables::{
    AutoRgb, CabinEntry, DistanceEntry, DistanceWord, GlassMountTables, MountTable,
    PhysicalCameraTable, PhysicalOpticsTable, PhysicalOpticsTables, SceneEntry, from_table,
};
use super::{
    CameraSettings, FocalLength, Mount, OpticsSettings, PhysicsSettings, focal_length,
    out_of_range, physics,
};

/// How far the focal length in px may be from what lens and pixel pitch make it.
const F_PX_TOLERANCE: f64 = 0.01;

/// Mean way to the rim of a windscreen, mm: of a pane that has no size.
const RIM_WAY_MM: f64 = 550.0;

/// The glass before the camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheet {
    pub(super) mount: Mount,
    thickness_mm: f64,
    interlayer_mm: f64,
    inner_ply_mm: f64,
    rim_way_mm: f64,
}

impl Sheet {
    /// No glass at all; what the optics ask of it does not matter.
    pub(super) const NONE: Self = Self {
        mount: Mount::NOWHERE,
        thickness_mm: 1.0,
        interlayer_mm: 0.0,
        inner_ply_mm: 0.0,
        rim_way_mm: RIM_WAY_MM,
    };

    /// A pane without a size. The optical axis meets it in the middle of the frame.
    pub(super) fn mounted(glass: &MountTable) -> Self {
        Self {
            mount: physics::mount(glass.distance_m, glass.rake_deg, [0.5; 2]),
            thickness_mm: glass.thickness_mm,
            interlayer_mm: 0.0,
            inner_ply_mm: 0.0,
            rim_way_mm: RIM_WAY_MM,
        }
    }

    /// The pane of the physics.
    pub(super) fn of(physics: &PhysicsSettings) -> Self {
        let [width_m, height_m] = physics.pane.outline.size_m();
        let (interlayer_m, inner_ply_m) = match physics.pane.build {
            GlassBuild::Laminated {
                interlayer_thickness_m,
                inner_thickness_m,
                ..
            } => (interlayer_thickness_m, inner_thickness_m),
            GlassBuild::Annealed | GlassBuild::Tempered { .. } => (0.0, 0.0),
        };
        Self {
            mount: physics.mount,
            thickness_mm: physics.pane.thickness_m * 1e3,
            interlayer_mm: interlayer_m * 1e3,
            inner_ply_mm: inner_ply_m * 1e3,
            rim_way_mm: (width_m + height_m) / 4.0 * 1e3,
        }
    }
}

/// The pane that the paper's cracks lie in.
pub(super) fn mount(place: &Place, recipe: &Table) -> Result<Sheet, RecipeError> {
    let GlassMountTables { glass } = from_table(place, recipe)?;
    Ok(Sheet::mounted(&glass))
}

/// Camera and optics before a sheet of glass.
pub(super) fn settings(
    place: &Place,
    recipe: &PhysicalOpticsTables,
    sheet: Sheet,
) -> Result<(CameraSettings, OpticsSettings), RecipeError> {
    let camera = &recipe.camera;
    let given = &recipe.optics;
    let noise = SensorNoise {
        read: given.noise_read,
        shot: given.noise_shot,
    };
    let is_quiet = noise.read == 0.0 && noise.shot == 0.0;
    let lens = lens(camera, sheet.mount.distance_m);
    lens.check()
        .map_err(|error| RecipeError::of_model(place, "camera", error))?;
    let optics = PhysicalOptics {
        lens,
        environment: environment(place, given)?,
        glass: Glass {
            thickness_mm: sheet.thickness_mm,
            interlayer_mm: sheet.interlayer_mm,
            inner_ply_mm: sheet.inner_ply_mm,
            refractive_index: given.refractive_index,
            rim_reflectance: given.rim_reflectance,
            rim_way_mm: sheet.rim_way_mm,
        },
        surface: SurfaceParams {
            mirror_alpha: given.mirror_alpha.given(),
            mist_alpha: given.mist_alpha.given(),
            hackle_alpha: given.hackle_alpha.given(),
            opening_um: given.opening_um,
            crushed_zone: given.crushed_zone,
            chip: given.chip,
            chip_slope_deg: given.chip_slope_deg,
            film: given.film,
            film_um: given.film_um,
            fragment_wedge_deg: given.fragment_wedge_deg,
        },
        veiling_glare: given.veiling_glare,
        noise: (!is_quiet).then_some(noise),
        region_threshold: given.region_threshold,
    };
    optics
        .check()
        .map_err(|error| RecipeError::of_model(place, "optics", error))?;
    let f_px = f_px(place, camera, &optics.lens)?;
    Ok((
        CameraSettings { f_px },
        OpticsSettings::Physical(Box::new(optics)),
    ))
}

fn lens(given: &PhysicalCameraTable, glass_m: f64) -> Lens {
    let scene_m = match given.scene_distance_m {
        SceneEntry::Meters(scene_m) => scene_m,
        SceneEntry::Word(_) => f64::INFINITY,
    };
    Lens {
        focal_length_m: given.focal_length_mm / 1e3,
        f_number: given.f_number,
        focus_m: match given.focus_distance_m {
            DistanceEntry::Meters(focus_m) => focus_m,
            DistanceEntry::Word(DistanceWord::Far) => scene_m,
            DistanceEntry::Word(DistanceWord::Short) => glass_m,
            DistanceEntry::Word(DistanceWord::Infinity) => f64::INFINITY,
        },
        scene_m,
        blades: given.blades,
        blade_angle_rad: given.blade_angle_deg.to_radians(),
    }
}

/// The focal length in px, from the pixel pitch where that is given: f_px = v/pitch with
/// v = f s₁/(s₁ − f), the distance of the image plane from the lens.
fn f_px(
    place: &Place,
    given: &PhysicalCameraTable,
    lens: &Lens,
) -> Result<FocalLength, RecipeError> {
    let f_m = lens.focal_length_m;
    if lens.focus_m <= f_m {
        let expected = format!(
            "more than camera.focal_length_mm ({} mm): nothing nearer can be sharp",
            given.focal_length_mm
        );
        let focus = match given.focus_distance_m {
            DistanceEntry::Word(DistanceWord::Far) => "\"far\" = ",
            DistanceEntry::Word(DistanceWord::Short) => "\"short\" = ",
            _ => "",
        };
        return Err(out_of_range(
            place,
            "camera.focus_distance_m",
            format!("{focus}{}", lens.focus_m),
            &expected,
        ));
    }
    let f_px = focal_length(given.f_px);
    let Some(pitch_um) = given.pixel_pitch_um.given() else {
        return Ok(f_px);
    };
    let key = "camera.pixel_pitch_um";
    // 1 − f/s₁ is 1 at infinity, where f s₁/(s₁ − f) is not a number.
    let image_plane_um = f_m / (1.0 - f_m / lens.focus_m) * 1e6;
    let by_pitch = image_plane_um / pitch_um;
    match f_px {
        FocalLength::Auto if (1.0..=1e6).contains(&by_pitch) => Ok(FocalLength::Px(by_pitch)),
        FocalLength::Auto => {
            let expected = format!(
                "a pitch that makes the focal length 1 to 1000000 px; it would be {by_pitch:.4}"
            );
            Err(out_of_range(place, key, pitch_um, &expected))
        }
        FocalLength::Px(f_px) if (by_pitch / f_px - 1.0).abs() <= F_PX_TOLERANCE => {
            Ok(FocalLength::Px(f_px))
        }
        FocalLength::Px(f_px) => {
            let expected = format!(
                "{:.4} within 1 %, as camera.f_px = {f_px} and camera.focal_length_mm = {} make it; set one of the \
                 two to \"auto\"",
                image_plane_um / f_px,
                given.focal_length_mm
            );
            Err(out_of_range(place, key, pitch_um, &expected))
        }
    }
}

fn environment(
    place: &Place,
    given: &PhysicalOpticsTable,
) -> Result<EnvironmentParams, RecipeError> {
    let rows = &given.dashboard_rows;
    let dashboard = Dashboard::below(rows).map_err(|_| {
        let rows: Vec<String> = rows.iter().map(f64::to_string).collect();
        let found = format!("[{}]", rows.join(", "));
        out_of_range(
            place,
            "optics.dashboard_rows",
            found,
            "up to 9 rows, each 0 to 1",
        )
    })?;
    Ok(EnvironmentParams {
        sun_azimuth_rad: given.sun_azimuth_deg.to_radians(),
        sun_turns_rad_s: given.sun_turns_deg_s.to_radians(),
        sun_elevation_rad: given.sun_elevation_deg.to_radians(),
        sun_irradiance: given.sun_irradiance.given(),
        horizon_rgb: rgb(given.sky_horizon),
        zenith_rgb: rgb(given.sky_zenith),
        ground_rgb: rgb(given.ground),
        cabin_rgb: match given.cabin {
            CabinEntry::Even(rgb) => Some([single(rgb); 2]),
            CabinEntry::Ends(ends) => Some(ends.map(single)),
            CabinEntry::Auto(_) => None,
        },
        horizon_row: given.horizon_row,
        dashboard,
    })
}

fn rgb(given: AutoRgb) -> Option<Rgb> {
    match given {
        AutoRgb::Rgb(rgb) => Some(single(rgb)),
        AutoRgb::Auto(_) => None,
    }
}

fn single(rgb: [f64; 3]) -> Rgb {
    #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
    let rgb = rgb.map(|channel| channel as f32);
    rgb
}
