//! Recipes and overrides that are wrong: one line that names the key, code 2, nothing
//! left behind.

use std::collections::BTreeSet;
use std::fs;

use crate::program::{all_refused, folder, snapshot, starbreak, succeed};
use serde_json::Value;

/// Every numeric key with a preset that has it, and values that it must refuse. Angles may be
/// negative.
const NUMERIC: [(&str, &str, &[&str]); 202] = [
    (
        "paper",
        "camera.f_px",
        &["-1", "0", "nan", "inf", "1000001"],
    ),
    (
        STAR,
        "camera.focal_length_mm",
        &["-1", "0", "nan", "inf", "1001"],
    ),
    (STAR, "camera.f_number", &["-1", "0", "nan", "inf", "129"]),
    (
        STAR,
        "camera.focus_distance_m",
        &["-1", "0", "nan", "0.003"],
    ),
    (STAR, "camera.scene_distance_m", &["-1", "0", "nan"]),
    (
        STAR,
        "camera.pixel_pitch_um",
        &["-1", "0", "nan", "inf", "1001"],
    ),
    (STAR, "camera.blades", &["-1", "1", "2", "1.5", "25"]),
    (
        STAR,
        "camera.blade_angle_deg",
        &["-361", "361", "nan", "inf"],
    ),
    (
        STAR,
        "optics.sun_irradiance",
        &["-1", "nan", "inf", "1000001"],
    ),
    (
        STAR,
        "optics.sky_horizon",
        &[
            "[-1,0,0]",
            "[0,0,2000000]",
            "[nan,0,0]",
            "[0,inf,0]",
            "[1,2]",
        ],
    ),
    (
        STAR,
        "optics.sky_zenith",
        &[
            "[-1,0,0]",
            "[0,0,2000000]",
            "[nan,0,0]",
            "[0,inf,0]",
            "[1,2]",
        ],
    ),
    (
        STAR,
        "optics.ground",
        &[
            "[-1,0,0]",
            "[0,0,2000000]",
            "[nan,0,0]",
            "[0,inf,0]",
            "[1,2]",
        ],
    ),
    (
        STAR,
        "optics.cabin",
        &[
            "[-1,0,0]",
            "[0,0,2000000]",
            "[nan,0,0]",
            "[0,inf,0]",
            "[1,2]",
            "[[0,0,0],[0,0,-1]]",
            "[[0,0,0]]",
        ],
    ),
    (
        STAR,
        "optics.rim_reflectance",
        &["-0.1", "1.1", "nan", "inf"],
    ),
    (
        STAR,
        "optics.sun_turns_deg_s",
        &["-361", "361", "nan", "inf"],
    ),
    (STAR, "optics.horizon_row", &["-101", "101", "nan", "inf"]),
    (
        STAR,
        "optics.dashboard_rows",
        &["[1.1]", "[0.9,-0.1]", "[nan]", "[0.9,inf]", "0.9"],
    ),
    (
        STAR,
        "optics.refractive_index",
        &["-1", "1.2", "2.1", "nan", "inf"],
    ),
    (STAR, "optics.mirror_alpha", &["-0.1", "1.1", "nan", "inf"]),
    (STAR, "optics.mist_alpha", &["-0.1", "1.1", "nan", "inf"]),
    (STAR, "optics.hackle_alpha", &["-0.1", "1.1", "nan", "inf"]),
    (STAR, "optics.opening_um", &["-1", "nan", "inf", "1001"]),
    (STAR, "optics.crushed_zone", &["-1", "nan", "inf", "11"]),
    (STAR, "optics.chip", &["-1", "nan", "inf", "11"]),
    (STAR, "optics.chip_slope_deg", &["-1", "nan", "inf", "61"]),
    (STAR, "optics.film", &["-1", "nan", "inf", "11"]),
    (STAR, "optics.film_um", &["-1", "nan", "inf", "101"]),
    (
        STAR,
        "optics.fragment_wedge_deg",
        &["-1", "nan", "inf", "11"],
    ),
    (STAR, "optics.veiling_glare", &["-0.1", "0.6", "nan", "inf"]),
    (STAR, "optics.noise_read", &["-0.1", "1.1", "nan", "inf"]),
    (STAR, "optics.noise_shot", &["-0.1", "1.1", "nan", "inf"]),
    (
        STAR,
        "optics.region_threshold",
        &["-1", "0", "nan", "inf", "1.1"],
    ),
    ("paper", "impact.force", &["-1", "0", "nan", "inf", "-inf"]),
    ("paper", "impact.direction_deg", &["nan", "inf", "-inf"]),
    (
        "paper",
        "impact.position",
        &[
            "[-0.1,0.5]",
            "[0.5,1.001]",
            "[nan,0.5]",
            "[0.5,inf]",
            "[0.5]",
            "[0.5,0.5,0.5]",
        ],
    ),
    (
        "paper",
        "fracture.particles",
        &["-1", "0", "nan", "inf", "1.5", "10000001", "99999999999"],
    ),
    ("paper", "fracture.neighbour_radius_px", NOT_POSITIVE),
    ("paper", "fracture.critical_stress", NOT_POSITIVE),
    ("paper", "fracture.safety_factor", NOT_POSITIVE),
    (
        "paper",
        "fracture.branches",
        &["-1", "0", "nan", "inf", "65"],
    ),
    ("paper", "optics.sun_azimuth_deg", NOT_FINITE),
    ("paper", "optics.sun_elevation_deg", NOT_FINITE),
    (
        "paper",
        "optics.light_intensity",
        &["[-1,0,0]", "[256,0,0]", "[nan,0,0]", "[0,0,inf]", "[1,2]"],
    ),
    (
        "paper",
        "optics.line_width_px",
        &["-1", "0", "nan", "inf", "65"],
    ),
    (
        "paper",
        "optics.blur_kernel_px",
        &["-1", "0", "nan", "inf", "2", "257"],
    ),
    (
        "paper",
        "optics.blur_sigma_px",
        &["-1", "0", "nan", "inf", "129"],
    ),
    (
        "paper",
        "output.quality",
        &["-1", "0", "nan", "inf", "101", "256"],
    ),
    (
        STAR,
        "glass.width_mm",
        &["-1", "0", "nan", "inf", "1.9", "10001"],
    ),
    (
        STAR,
        "glass.height_mm",
        &["-1", "0", "nan", "inf", "1.9", "10001"],
    ),
    (
        STAR,
        "glass.thickness_mm",
        &["-1", "0", "nan", "inf", "0.09", "31"],
    ),
    (
        STAR,
        "glass.interlayer_thickness_mm",
        &["-1", "0", "nan", "inf", "21"],
    ),
    (
        STAR,
        "glass.inner_thickness_mm",
        &["-1", "0", "nan", "inf", "0.09", "31"],
    ),
    (
        STAR,
        "glass.interlayer_modulus_mpa",
        &["-1", "0", "nan", "inf", "10001"],
    ),
    (
        "tempered-cover",
        "glass.surface_compression_mpa",
        &["-1", "0", "nan", "inf", "1001"],
    ),
    (STAR, "glass.distance_m", &["-1", "0", "nan", "inf", "10.1"]),
    (STAR, "glass.rake_deg", &["-81", "81", "nan", "inf"]),
    (
        STAR,
        "glass.axis_at",
        &["[-0.1,0.5]", "[0.5,1.1]", "[nan,0]", "[0.5]"],
    ),
    (STAR, "impact.speed_m_s", &["-1", "0", "nan", "inf", "1001"]),
    (STAR, "impact.radius_mm", &["-1", "0", "nan", "inf", "201"]),
    (
        STAR,
        "impact.tip_radius_mm",
        &["-1", "0", "nan", "inf", "201"],
    ),
    (STAR, "impact.angle_deg", &["-1", "86", "nan", "inf"]),
    (STAR, "impact.azimuth_deg", NOT_FINITE),
    (
        STAR,
        "impact.density_kg_m3",
        &["-1", "0", "nan", "inf", "99", "25001"],
    ),
    (STAR, "impact.count", &["-1", "0", "nan", "1.5", "1001"]),
    (STAR, "impact.radius_spread", &["-0.1", "nan", "inf", "2.1"]),
    (
        STAR,
        "fracture.fallen_pieces",
        &["-1", "nan", "1.5", "1001"],
    ),
    (STAR, "fracture.epochs", &["-1", "0", "nan", "1.5", "7"]),
    (
        STAR,
        "fracture.radial_count_factor",
        &["-1", "0", "nan", "inf", "101"],
    ),
    (
        STAR,
        "fracture.until_reach_mm",
        &["-1", "0", "nan", "inf", "20001"],
    ),
    (
        STAR,
        "fracture.strength_mpa",
        &["-1", "0", "nan", "inf", "10001"],
    ),
    (
        STAR,
        "fracture.weibull_modulus",
        &["-1", "0", "nan", "inf", "101"],
    ),
    (
        LONG,
        "long_crack.temperature_difference_k",
        &["-301", "301", "nan", "inf"],
    ),
    (
        LONG,
        "long_crack.spot",
        &["[-0.1,0.5]", "[0.5,1.1]", "[nan,0]", "[0.5]"],
    ),
    (
        LONG,
        "long_crack.spot_size",
        &["-1", "0", "nan", "inf", "6"],
    ),
    (
        LONG,
        "long_crack.frame_tension_mpa",
        &["-1", "nan", "inf", "101"],
    ),
    (LONG, "long_crack.frame_direction_deg", NOT_FINITE),
    (
        LONG,
        "long_crack.flaw_mm",
        &["-1", "0", "nan", "inf", "101"],
    ),
    (
        LONG,
        "long_crack.period_s",
        &["-1", "0", "nan", "inf", "1e7"],
    ),
    ("overexposed", "exposure.ev", &["-11", "10.1", "nan", "inf"]),
    (
        "overexposed",
        "exposure.white_e",
        &["0", "nan", "inf", "1e7"],
    ),
    (
        "overexposed",
        "exposure.read_e",
        &["-1", "nan", "inf", "1001"],
    ),
    ("banding", "banding.depth", &["-0.1", "nan", "1.1"]),
    ("banding", "banding.mains_hz", &["0", "nan", "inf", "1001"]),
    ("banding", "banding.row_us", &["0", "nan", "inf", "1001"]),
    (
        "banding",
        "banding.exposure_ms",
        &["0", "nan", "inf", "1001"],
    ),
    ("noise", "noise.white_e", &["0", "-1", "nan"]),
    ("noise", "noise.read_e", &["-1", "nan", "inf", "1001"]),
    ("noise", "noise.row_e", &["-1", "nan", "inf", "1001"]),
    ("noise", "noise.prnu_percent", &["-1", "nan", "inf", "51"]),
    ("noise", "noise.dsnu_e", &["-1", "nan", "inf", "10001"]),
    ("noise", "noise.dark_e_s", &["-1", "nan", "inf", "1e7"]),
    (
        "noise",
        "noise.temperature_c",
        &["-61", "nan", "inf", "151"],
    ),
    ("noise", "noise.doubling_k", &["0", "nan", "inf", "51"]),
    ("noise", "noise.exposure_ms", &["0", "nan", "inf", "1e6"]),
    (
        "pixels",
        "pixels.dead_per_mpx",
        &["-1", "nan", "inf", "1e7"],
    ),
    ("pixels", "pixels.hot_per_mpx", &["-1", "nan", "inf", "1e7"]),
    (
        "pixels",
        "pixels.stuck_per_mpx",
        &["-1", "nan", "inf", "1e7"],
    ),
    ("pixels", "pixels.hot_level", &["-0.1", "nan", "1.1"]),
    ("lines", "lines.rows", &["-1", "1001"]),
    ("lines", "lines.columns", &["-1", "1001"]),
    ("lines", "lines.level", &["-0.1", "nan", "1.1"]),
    ("lines", "sensor.number", &["-1", "1000001"]),
    (
        "led-banding",
        "banding.led_duty",
        &["-0.1", "nan", "1.1", "1e-9"],
    ),
    ("led-banding", "banding.led_hz", &["0", "nan", "inf", "1e6"]),
    ("distortion", "distortion.k1", &["-11", "nan", "inf", "11"]),
    ("distortion", "distortion.k2", &["-11", "nan", "inf", "11"]),
    ("distortion", "distortion.k3", &["-11", "nan", "inf", "11"]),
    ("distortion", "distortion.k4", &["-11", "nan", "inf", "11"]),
    ("distortion", "distortion.p1", &["-1.1", "nan", "1.1"]),
    ("distortion", "distortion.p2", &["-1.1", "nan", "1.1"]),
    (
        "distortion",
        "distortion.shift_px",
        &["[1001, 0]", "[0, -1001]", "[0, nan]", "[inf, 0]"],
    ),
    (
        "distortion",
        "distortion.corner_percent",
        &["-51", "nan", "inf", "51"],
    ),
    (
        "fringes",
        "fringes.lateral_px",
        &["-51", "nan", "inf", "51"],
    ),
    (
        "fringes",
        "fringes.axial_um",
        &["-201", "nan", "inf", "201"],
    ),
    (
        "defocus",
        "defocus.sensor_shift_um",
        &["-501", "nan", "inf", "501"],
    ),
    (
        "defocus",
        "defocus.warmer_k",
        &["-151", "nan", "inf", "151"],
    ),
    ("defocus", "defocus.um_per_k", &["-11", "nan", "inf", "11"]),
    ("shake", "shake.rate_deg_s", &["-1", "nan", "inf", "501"]),
    (
        "shake",
        "shake.direction_deg",
        &["-181", "nan", "inf", "181"],
    ),
    ("shake", "shake.frequency_hz", &["-1", "nan", "inf", "2001"]),
    ("shake", "shake.exposure_ms", &["0", "nan", "inf", "1001"]),
    ("glare", "glare.veil_percent", &["-1", "nan", "inf", "51"]),
    (
        "shading",
        "shading.corner_loss_percent",
        &["-1", "nan", "inf", "96"],
    ),
    ("glare", "lens.headroom", &["0.9", "nan", "inf", "1001"]),
    (
        "distortion",
        "distortion.onset_s",
        &["-1", "nan", "inf", "1e7"],
    ),
    ("fringes", "fringes.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("defocus", "defocus.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("shake", "shake.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("glare", "glare.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("shading", "shading.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("fogged", "condensation.age_s", &["-1", "nan", "inf", "1e6"]),
    ("fogged", "condensation.clears_from_s", &["-1", "nan"]),
    (
        "fogged",
        "condensation.clearing_um_s",
        &["-1", "nan", "inf", "11"],
    ),
    (
        "fogged",
        "condensation.growth_um_s",
        &["-1", "nan", "inf", "11"],
    ),
    (
        "fogged",
        "condensation.nuclei_per_mm2",
        &["9", "nan", "inf", "1e5"],
    ),
    (
        "fogged",
        "condensation.contact_deg",
        &["19", "nan", "inf", "91"],
    ),
    ("fogged", "condensation.unevenness", &["-0.1", "nan", "1.1"]),
    (
        "fogged",
        "condensation.scale_mm",
        &["4", "nan", "inf", "1001"],
    ),
    ("muddy", "mud.coverage_percent", &["-1", "nan", "inf", "81"]),
    ("muddy", "mud.splat_mm", &["1.9", "nan", "inf", "41"]),
    ("muddy", "mud.thickness_um", &["9", "nan", "inf", "2001"]),
    (
        "muddy",
        "mud.absorption_per_mm",
        &["[-1, 1, 1]", "[1, nan, 1]", "[1, 1, 201]"],
    ),
    (
        "muddy",
        "mud.scattering_per_mm",
        &["0", "nan", "inf", "201"],
    ),
    (
        "dusty",
        "dust.coverage_percent",
        &["-1", "nan", "inf", "31"],
    ),
    ("dusty", "dust.albedo", &["-0.1", "nan", "1.1"]),
    ("dusty", "dust.unevenness", &["-0.1", "nan", "1.1"]),
    ("dusty", "dust.scale_mm", &["4", "nan", "inf", "1001"]),
    ("greasy", "film.ripple_um", &["-1", "nan", "inf", "201"]),
    ("greasy", "film.scale_mm", &["0.9", "nan", "inf", "51"]),
    ("greasy", "film.haze_percent", &["-1", "nan", "51"]),
    ("frosted", "frost.age_s", &["-1", "nan", "inf", "1e6"]),
    ("frosted", "frost.melts_from_s", &["-1", "nan"]),
    ("frosted", "frost.rime_percent", &["-1", "56", "nan", "inf"]),
    (
        "frosted",
        "frost.melting_um_s",
        &["-1", "nan", "inf", "1001"],
    ),
    ("frosted", "frost.front_um_s", &["-1", "nan", "inf", "1001"]),
    ("frosted", "frost.seeds_per_cm2", &["0", "nan", "inf", "21"]),
    ("scratched", "scratches.haze_percent", &["-1", "nan", "21"]),
    (
        "scratched",
        "scratches.wiper_percent",
        &["-1", "nan", "101"],
    ),
    (
        "scratched",
        "scratches.pivot_mm",
        &["[-2001, 0]", "[nan, 0]", "[0, 2001]"],
    ),
    ("rain", "drops.wiper_period_s", &["-1", "nan", "inf", "601"]),
    (
        "ghosts",
        "ghosts.reflectance_percent",
        &["-1", "nan", "8.1"],
    ),
    (
        "ghosts",
        "ghosts.faces",
        &[
            "[[nan, 1, 1.5], [0, 1, 1]]",
            "[[1, -1, 1.5], [0, 1, 1]]",
            "[[1, 1, 0.9], [0, 1, 1]]",
            "[[1, 1, 1.5], [2, 1, 1]]",
        ],
    ),
    ("ghosts", "ghosts.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("star-burst", "star.blades", &["1", "2", "25", "-1"]),
    ("star-burst", "star.angle_deg", &["-181", "nan", "181"]),
    ("star-burst", "star.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("rain", "drops.rain_mm_h", &["-1", "nan", "inf", "151"]),
    ("rain", "drops.speed_m_s", &["-1", "nan", "inf", "61"]),
    ("rain", "drops.age_s", &["-1", "nan", "inf", "601"]),
    ("rain", "drops.contact_deg", &["9", "nan", "inf", "111"]),
    ("rain", "drops.hysteresis_deg", &["0.9", "nan", "inf", "61"]),
    ("spots", "spots.count", &["-1", "1001"]),
    ("spots", "spots.size_um", &["0", "nan", "inf", "1001"]),
    ("spots", "spots.height_mm", &["0", "nan", "inf", "11"]),
    ("spots", "spots.f_number", &["0", "nan", "inf", "33"]),
    ("spots", "spots.pitch_um", &["0", "nan", "inf", "51"]),
    ("no-filters", "cfa.loss", &["-0.1", "nan", "1.1"]),
    ("no-demosaicing", "mosaic.share", &["-0.1", "nan", "1.1"]),
    (
        "no-sharpening",
        "isp.black_level_percent",
        &["-1", "nan", "26"],
    ),
    (
        "no-sharpening",
        "isp.white_balance",
        &["-0.1", "nan", "1.1"],
    ),
    ("no-sharpening", "isp.color_matrix", &["-0.1", "nan", "1.1"]),
    ("no-sharpening", "isp.tone", &["-0.1", "nan", "1.1"]),
    ("no-sharpening", "isp.unsharp", &["-1", "nan", "5.1"]),
    ("bit-errors", "link.bit_error_rate", &["-1", "nan", "0.011"]),
    ("bit-errors", "link.jpeg_quality", &["-1", "101"]),
    ("bit-errors", "link.row_bits", &["0", "17"]),
    ("blank-frames", "frames.black", &["-0.1", "nan", "1.1"]),
    ("blank-frames", "frames.white", &["-0.1", "nan", "1.1"]),
    ("blank-frames", "frames.frozen", &["-0.1", "nan", "1.1"]),
    ("blank-frames", "frames.dropped", &["-0.1", "nan", "1.1"]),
    (
        "blank-frames",
        "frames.burst_frames",
        &["0", "nan", "inf", "1e6"],
    ),
    (
        "overexposed",
        "exposure.onset_s",
        &["-1", "nan", "inf", "1e7"],
    ),
    ("banding", "banding.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("spots", "spots.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("no-filters", "cfa.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("noise", "noise.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("pixels", "pixels.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("lines", "lines.onset_s", &["-1", "nan", "inf", "1e7"]),
    (
        "no-demosaicing",
        "mosaic.onset_s",
        &["-1", "nan", "inf", "1e7"],
    ),
    ("no-sharpening", "isp.onset_s", &["-1", "nan", "inf", "1e7"]),
    ("bit-errors", "link.onset_s", &["-1", "nan", "inf", "1e7"]),
    (
        "blank-frames",
        "frames.onset_s",
        &["-1", "nan", "inf", "1e7"],
    ),
];

const STAR: &str = "windshield-star";
const LONG: &str = "windshield-long-crack";
const NOT_FINITE: &[&str] = &["nan", "inf", "-inf"];
const NOT_POSITIVE: &[&str] = &["-1", "0", "nan", "inf"];

/// How a message names the key: that of an impact with its number.
fn named(key: &str) -> String {
    key.replace("impact.", "impact.0.")
}

#[test]
fn wrong_numbers_are_refused_as_overrides() {
    let dir = folder();
    let mut complaints = Vec::new();
    for (preset, key, values) in NUMERIC {
        for value in values {
            let set = format!("{key}={value}");
            let args = ["recipe", "--preset", preset, "--set", &set];
            let outcome = starbreak(dir.path(), &args);
            complaints.extend(outcome.complaint(&format!("--set {set}: {}", named(key))));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    let args = [
        "simulate",
        "-o",
        "out/n",
        "--set",
        "optics.blur_sigma_px=-1",
    ];
    let outcome = starbreak(dir.path(), &args);
    assert_eq!(
        outcome.complaint("optics.blur_sigma_px"),
        None,
        "by a verb that writes"
    );
    assert!(snapshot(dir.path()).is_empty(), "something was left behind");
}

#[test]
fn wrong_numbers_are_refused_in_a_recipe() {
    let dir = folder();
    let mut complaints = Vec::new();
    for (preset, key, values) in NUMERIC {
        let (table, key_in_table) = key.split_once('.').unwrap();
        let header = if table == "impact" {
            "[[impact]]".to_owned()
        } else {
            format!("[{table}]")
        };
        let model = match (preset, table) {
            ("paper", "fracture") => "model = \"paper\"\n",
            ("tempered-cover", "glass") => "kind = \"tempered\"\n",
            _ => "",
        };
        let first = if preset == "paper" && table != "fracture" {
            "fracture.model = \"paper\"\n"
        } else {
            ""
        };
        for value in values {
            let text = format!("schema = 1\n{first}{header}\n{model}{key_in_table} = {value}\n");
            fs::write(dir.path().join("r.toml"), text).unwrap();
            let args = ["simulate", "-o", "out/n", "--recipe", "r.toml"];
            let outcome = starbreak(dir.path(), &args);
            complaints.extend(outcome.complaint(&format!("r.toml: {}", named(key))));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert_eq!(
        crate::program::names(dir.path()),
        ["r.toml"],
        "nothing left behind"
    );
}

/// A key that is added to the recipe must be added to [`NUMERIC`].
#[test]
fn every_numeric_key_was_tried() {
    let dir = folder();
    let schema: Value =
        serde_json::from_str(&succeed(dir.path(), &["recipe", "--schema"]).stdout).unwrap();
    let presets = [STAR, LONG, "tempered-cover", "paper"];
    let faults = [
        "muddy",
        "dusty",
        "greasy",
        "frosted",
        "scratched",
        "ghosts",
        "star-burst",
        "rain",
        "fogged",
        "distortion",
        "fringes",
        "defocus",
        "shake",
        "glare",
        "shading",
        "overexposed",
        "banding",
        "spots",
        "no-filters",
        "noise",
        "pixels",
        "lines",
        "no-demosaicing",
        "no-sharpening",
        "bit-errors",
        "blank-frames",
    ];
    let printed: Vec<String> = (presets.iter().chain(&faults))
        .map(|preset| succeed(dir.path(), &["recipe", "--preset", preset]).stdout)
        .collect();
    let sensor = [
        "recipe",
        "--set",
        "sensor.number=1",
        "--set",
        "lens.headroom=2",
    ];
    let printed = printed.concat() + &succeed(dir.path(), &sensor).stdout;
    let mut numeric = BTreeSet::new();
    for (table, property) in schema["properties"].as_object().unwrap() {
        let items = &property["items"];
        let owner = if items.is_object() { items } else { property };
        let Some(keys) = owner["properties"].as_object() else {
            continue;
        };
        for (key, property) in keys {
            assert!(printed.contains(&format!("\n{key} = ")), "{key} is printed");
            let text = property.to_string();
            if text.contains("\"number\"") || text.contains("\"integer\"") {
                numeric.insert(format!("{table}.{key}"));
            }
        }
    }
    let tried = NUMERIC
        .iter()
        .map(|(_, key, _)| (*key).to_owned())
        .collect();
    assert_eq!(numeric, tried, "numeric keys of the schema and those tried");
}

#[test]
fn the_message_repeats_the_value_given() {
    let dir = folder();
    let set = "optics.sun_elevation_deg=inf";
    let args = vec!["simulate", "-o", "out/n", "--set", set];
    all_refused(dir.path(), &[(args, "optics.sun_elevation_deg = inf")]);
}

#[test]
fn no_message_has_hundreds_of_digits() {
    let dir = folder();
    let cases = [
        "camera.f_px=1e300",
        "optics.sun_irradiance=1e308",
        "glass.thickness_mm=1e-300",
    ];
    let cases = cases.map(|set| {
        let args = vec!["crack", "photo.png", "-o", "out", "--set", set];
        let (_, value) = set.split_once('=').unwrap();
        (args, value)
    });
    all_refused(dir.path(), &cases);
    for (args, _) in cases {
        let said = starbreak(dir.path(), &args).stderr;
        assert!(said.len() < 200, "{said}");
    }
}

#[test]
fn wrong_overrides_are_refused() {
    let dir = folder();
    let set = |assignment, named| (vec!["simulate", "-o", "out/n", "--set", assignment], named);
    let paper = |assignment, named| {
        let args = [
            "simulate", "-o", "out/n", "--preset", "paper", "--set", assignment,
        ];
        (args.to_vec(), named)
    };
    all_refused(
        dir.path(),
        &[
            set("fracture.particles", "--set fracture.particles"),
            set("", "--set"),
            set("=", "--set ="),
            set("fracture=5", "fracture"),
            set("a.b.c.d=5", "a.b.c.d"),
            paper("impact.7.force=1", "impact `7`"),
            paper("impact.-1.force=1", "impact `-1`"),
            set("impact.0.farce=1", "did you mean `impact.0.force`?"),
            set("fracture.partikles=1", "did you mean `fracture.particles`?"),
            set("fractures.particles=1", "did you mean `fracture`?"),
            set("zebra.particles=1", "known tables: "),
            set("fracture.zzzzzz=1", "known keys: "),
            paper("fracture.rule=anything", "fracture.rule"),
            paper("fracture.particles=many", "fracture.particles"),
            set("output.masks=1", "output.masks"),
            set("fracture.particles=5", "is a key of model \"paper\", but"),
            paper("glass.kind=cover", "is a table of model \"physics\", but"),
            set("impact.sped_m_s=5", "did you mean `impact.0.speed_m_s`?"),
            set(
                "long_crack.spot_sise=5",
                "did you mean `long_crack.spot_size`?",
            ),
            set(
                "glass.surface_compression_mpa=5",
                "glass.surface_compression_mpa: ",
            ),
            set("glass.kind=cover", "a cover is a disc"),
            set(
                "fracture.model=papper",
                "expected one of `physics`, `paper`, `none`",
            ),
            paper("camera.focus_distance_m=7", "camera.focus_distance_m"),
            set("optics.model=pbr", "expected `physical` or `paper`"),
            set(
                "camera.focus_distance_m=near",
                "\"far\", \"short\", \"infinity\" or a distance",
            ),
        ],
    );
}

#[test]
fn text_that_breaks_the_line_stays_on_one() {
    let dir = folder();
    let set = |assignment, named| (vec!["simulate", "-o", "out/n", "--set", assignment], named);
    fs::write(dir.path().join("lines.toml"), r#"schema = "a\nb""#).unwrap();
    let recipe = vec!["simulate", "--recipe", "lines.toml", "-o", "out/n"];
    let preset = vec!["simulate", "--preset", "a\nb", "-o", "out/n"];
    all_refused(
        dir.path(),
        &[
            set("impact.a\nb.force=1", "impact"),
            set("fracture.a\nb=1", "fracture.a\\nb"),
            set(r#"fracture.mesh="a\u001b[31m""#, "fracture.mesh"),
            set("fracture.mesh=a\nb", "fracture.mesh"),
            set("impact.position=a\nb", "impact.0.position"),
            (preset, "a\\nb"),
            (recipe, "schema"),
        ],
    );
}

#[test]
fn wrong_recipe_files_are_refused() {
    let dir = folder();
    let files: [(&str, &[u8], &str); 12] = [
        ("latin.toml", b"schema = 1 # \xe9t\xe9", "latin.toml"),
        (
            "syntax.toml",
            b"schema = 1\n[fracture]\nparticles = = 5\n",
            "syntax.toml:3:13: ",
        ),
        (
            "twice.toml",
            b"schema = 1\nschema = 1\n",
            "twice.toml:2:1: ",
        ),
        ("open.toml", b"schema = 1\n[fracture\n", "open.toml:2:"),
        ("v2.toml", b"schema = 2\n", "v2.toml: schema = 2"),
        ("text.toml", b"schema = \"1\"\n", "text.toml: schema"),
        (
            "none.toml",
            b"[fracture]\nparticles = 5\n",
            "none.toml: the key `schema`",
        ),
        ("empty.toml", b"", "empty.toml: the key `schema`"),
        (
            "key.toml",
            b"schema = 1\n[optics]\nsun_azimut_deg = 5\n",
            "key.toml: unknown key `optics.sun_azimut_deg`; did you mean `optics.sun_azimuth_deg`?",
        ),
        (
            "table.toml",
            b"schema = 1\n[outptu]\nmasks = true\n",
            "did you mean `output`?",
        ),
        (
            "single.toml",
            b"schema = 1\n[impact]\nforce = 5.0\n",
            "impact",
        ),
        ("no_hits.toml", b"schema = 1\nimpact = []\n", "impact"),
    ];
    for (name, bytes, _) in files {
        fs::write(dir.path().join(name), bytes).unwrap();
    }
    fs::create_dir(dir.path().join("folder.toml")).unwrap();
    let named = files.iter().map(|(name, _, named)| (*name, *named));
    let unreadable = ["missing.toml", "folder.toml"].map(|name| (name, name));
    let cases: Vec<_> = named
        .chain(unreadable)
        .map(|(name, named)| (vec!["simulate", "--recipe", name, "-o", "out/n"], named))
        .collect();
    all_refused(dir.path(), &cases);
}

#[test]
fn unknown_presets_are_refused() {
    let dir = folder();
    let preset = |name, named| (vec!["simulate", "--preset", name, "-o", "out/n"], named);
    all_refused(
        dir.path(),
        &[
            preset("papper", "`papper`; did you mean `paper`?"),
            preset("zebra", "`zebra`; known presets: windshield-star, "),
            preset("", "``"),
        ],
    );
}

#[test]
fn severity_goes_with_a_preset_and_not_with_a_recipe() {
    let dir = folder();
    let printed = |args: &[&str]| succeed(dir.path(), &[&["recipe"], args].concat()).stdout;
    assert_eq!(
        printed(&["--severity", "3"]),
        printed(&[]),
        "3 is the preset"
    );
    let reach_mm = |severity: &str| -> f64 {
        let recipe = printed(&["--severity", severity]);
        let line = recipe
            .lines()
            .find_map(|line| line.strip_prefix("until_reach_mm = "));
        let value = line.unwrap();
        if value == "\"end\"" {
            f64::INFINITY
        } else {
            value.parse().unwrap()
        }
    };
    assert!(
        reach_mm("1") < reach_mm("3") && reach_mm("3") < reach_mm("5"),
        "the default's cracks get farther"
    );
    let paper = printed(&[
        "--preset",
        "paper",
        "--severity",
        "1",
        "--set",
        "impact.direction_deg=5",
    ]);
    assert!(
        paper.contains("\nforce = 350.0\n") && paper.contains("\ndirection_deg = 5\n"),
        "{paper}"
    );
    let set = printed(&["--severity", "5", "--set", "impact.speed_m_s=7.5"]);
    assert!(
        set.contains("\nspeed_m_s = 7.5\n"),
        "--set has the last word"
    );

    fs::write(dir.path().join("r.toml"), "schema = 1\n").unwrap();
    all_refused(
        dir.path(),
        &[
            (
                vec!["recipe", "--recipe", "r.toml", "--severity", "2"],
                "--severity scales a preset, but the recipe \"r.toml\" says its values itself",
            ),
            (vec!["recipe", "--severity", "0"], "--severity"),
            (vec!["recipe", "--severity", "6"], "--severity"),
            (vec!["recipe", "--severity", "1.5"], "--severity"),
        ],
    );
}
