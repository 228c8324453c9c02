//! The two optics models in a recipe, with either fracture model: which keys each has, in which
//! units, and what the camera is then.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use starbreak::optics::lens::Lens;
use starbreak::optics::physical::{Glass, PhysicalOptics};
use starbreak::{
    DEFAULT_PRESET, FocalLength, FractureSettings, OpticsSettings, PRESETS, Recipe, Settings,
};

fn parse(text: &str) -> Recipe {
    Recipe::parse("r.toml", &format!("schema = 1\n{text}"))
        .unwrap_or_else(|error| panic!("{text:?}: {error}"))
}

fn refusal(text: &str) -> String {
    let message = Recipe::parse("r.toml", &format!("schema = 1\n{text}"))
        .unwrap_err()
        .to_string();
    assert!(!message.contains('\n'), "one line: {message:?}");
    message
}

fn physical(settings: &Settings) -> &PhysicalOptics {
    match &settings.optics {
        OpticsSettings::Physical(optics) => optics,
        OpticsSettings::Paper(_) => panic!("the paper's optics"),
    }
}

fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-12 * expected.abs()
}

#[test]
fn every_preset_but_that_of_the_paper_is_shown_by_the_physical_optics() {
    for (name, _) in PRESETS {
        let settings = Recipe::preset(name).unwrap().settings().unwrap();
        let is_physical = matches!(settings.optics, OpticsSettings::Physical(_));
        assert_eq!(is_physical, name != "paper", "{name}");
    }
    // The presets say what the library's own defaults are.
    let settings = Recipe::preset(DEFAULT_PRESET).unwrap().settings().unwrap();
    let windscreen = PhysicalOptics {
        glass: Glass {
            interlayer_mm: 0.76,
            inner_ply_mm: 2.1,
            ..Glass::default()
        },
        lens: Lens {
            focal_length_m: 3e-3,
            f_number: 2.8,
            ..Lens::default()
        },
        ..PhysicalOptics::default()
    };
    assert_eq!(
        physical(&settings),
        &windscreen,
        "a windscreen behind a small lens"
    );
}

#[test]
fn optics_come_out_in_si_units() {
    let recipe = parse(
        "[glass]\ndistance_m = 0.31\nthickness_mm = 2.3\n\
        [camera]\nfocal_length_mm = 6.5\nf_number = 1.6\nfocus_distance_m = 0.7\nscene_distance_m = 33\n\
        blades = 7\nblade_angle_deg = 45\n\
        [optics]\nsun_azimuth_deg = -90\nsun_elevation_deg = 30\nsun_irradiance = 5.5\n\
        sky_horizon = [0.125, 0.25, 0.5]\nsky_zenith = [1, 2, 4]\nground = [0.0625, 0, 3]\ncabin = [8, 16, 32]\n\
        horizon_row = 0.4\nrefractive_index = 1.5\nrim_reflectance = 0.25\nmirror_alpha = 0.01\nmist_alpha = 0.06\nhackle_alpha = 0.4\n\
        opening_um = 12\ncrushed_zone = 1.5\nchip = 3\nchip_slope_deg = 10\nfilm = 4\nfilm_um = 2\nfragment_wedge_deg = 0.2\n\
        veiling_glare = 0.03\nnoise_read = 0.002\nnoise_shot = 0.0004\nregion_threshold = 0.02",
    );
    let settings = recipe.settings().unwrap();
    let optics = physical(&settings);
    let (lens, light, surface) = (&optics.lens, &optics.environment, &optics.surface);
    let noise = optics.noise.unwrap();
    let pi = std::f64::consts::PI;
    for (what, value, expected) in [
        ("focal length", lens.focal_length_m, 0.0065),
        ("f-number", lens.f_number, 1.6),
        ("focus", lens.focus_m, 0.7),
        ("scene", lens.scene_m, 33.0),
        ("blades", f64::from(lens.blades), 7.0),
        ("blade angle", lens.blade_angle_rad, pi / 4.0),
        ("azimuth", light.sun_azimuth_rad, -pi / 2.0),
        ("elevation", light.sun_elevation_rad, pi / 6.0),
        ("irradiance", light.sun_irradiance.unwrap(), 5.5),
        ("horizon", light.horizon_row, 0.4),
        ("thickness", optics.glass.thickness_mm, 2.3),
        ("index", optics.glass.refractive_index, 1.5),
        ("rim", optics.glass.rim_reflectance, 0.25),
        ("mirror", surface.mirror_alpha.unwrap(), 0.01),
        ("mist", surface.mist_alpha.unwrap(), 0.06),
        ("hackle", surface.hackle_alpha.unwrap(), 0.4),
        ("opening", surface.opening_um, 12.0),
        ("crushed", surface.crushed_zone, 1.5),
        ("chip", surface.chip, 3.0),
        ("slope", surface.chip_slope_deg, 10.0),
        ("film", surface.film, 4.0),
        ("film's thickness", surface.film_um, 2.0),
        ("wedge", surface.fragment_wedge_deg, 0.2),
        ("glare", optics.veiling_glare, 0.03),
        ("read noise", noise.read, 0.002),
        ("shot noise", noise.shot, 0.0004),
        ("threshold", optics.region_threshold, 0.02),
    ] {
        assert!(near(value, expected), "{what}: {value} for {expected}");
    }
    assert_eq!(light.horizon_rgb, Some([0.125, 0.25, 0.5]), "horizon");
    assert_eq!(light.zenith_rgb, Some([1.0, 2.0, 4.0]), "zenith");
    assert_eq!(light.ground_rgb, Some([0.0625, 0.0, 3.0]), "ground");
    assert_eq!(light.cabin_rgb, Some([[8.0, 16.0, 32.0]; 2]), "cabin");
}

#[test]
fn a_distance_is_a_number_or_what_it_names() {
    let lens = |text: &str| physical(&parse(text).settings().unwrap()).lens;
    for (text, focus_m) in [
        ("camera.focus_distance_m = 2", 2.0),
        ("camera.focus_distance_m = \"far\"", 20.0),
        (
            "camera.focus_distance_m = \"far\"\ncamera.scene_distance_m = 7.5",
            7.5,
        ),
        (
            "camera.focus_distance_m = \"short\"\nglass.distance_m = 0.3",
            0.3,
        ),
        (
            "fracture.model = \"paper\"\noptics.model = \"physical\"\ncamera.focus_distance_m = \"short\"\n\
             glass.distance_m = 0.3",
            0.3,
        ),
        ("camera.focus_distance_m = \"infinity\"", f64::INFINITY),
        ("camera.focus_distance_m = inf", f64::INFINITY),
        ("camera.scene_distance_m = \"infinity\"", f64::INFINITY),
        ("camera.scene_distance_m = inf", f64::INFINITY),
    ] {
        let focused_m = lens(text).focus_m;
        let is_it = near(focused_m, focus_m) || (focused_m.is_infinite() && focus_m.is_infinite());
        assert!(is_it, "{text:?}: {focused_m}");
    }
}

#[test]
fn a_pixel_pitch_gives_the_focal_length_in_px_or_agrees_with_it() {
    let f_px = |text: &str| match parse(text).settings().unwrap().camera.f_px {
        FocalLength::Px(f_px) => f_px,
        FocalLength::Auto => panic!("{text:?} leaves it open"),
    };
    // v = f s1/(s1 - f), by hand: 4 mm at 20 m is 4.00080016 mm, at 0.15 m 4.10958904 mm.
    for (text, expected) in [
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4",
            1_000.200_040_008,
        ),
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4\ncamera.focus_distance_m = \"short\"",
            1_027.397_260_274,
        ),
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4\ncamera.focus_distance_m = \"infinity\"",
            1000.0,
        ),
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4\ncamera.f_px = 1009",
            1009.0,
        ),
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4\ncamera.f_px = 991",
            991.0,
        ),
    ] {
        let f_px = f_px(text);
        assert!((f_px - expected).abs() < 1e-6, "{text:?}: {f_px} px");
    }
    for (text, expected) in [
        (
            "camera.focal_length_mm = 4\ncamera.pixel_pitch_um = 4\ncamera.f_px = 1020",
            "r.toml: camera.pixel_pitch_um = 4; expected 3.9224 within 1 %, as camera.f_px = 1020 and \
             camera.focal_length_mm = 4 make it; set one of the two to \"auto\"",
        ),
        (
            "camera.pixel_pitch_um = 0.1\ncamera.focal_length_mm = 1000",
            "camera.pixel_pitch_um = 0.1; expected a pitch that makes the focal length 1 to 1000000 px; it would be \
             10526315",
        ),
        (
            "camera.pixel_pitch_um = 0.01",
            "camera.pixel_pitch_um = 0.01; expected \"auto\", or 0.1 to 1000 um",
        ),
        (
            "camera.pixel_pitch_um = \"small\"",
            "camera.pixel_pitch_um: expected \"auto\" or a number",
        ),
        (
            "camera.focus_distance_m = 0.003",
            "camera.focus_distance_m = 0.003; expected more than camera.focal_length_mm (3 mm)",
        ),
        (
            "camera.focus_distance_m = \"short\"\nglass.distance_m = 0.003",
            "camera.focus_distance_m = \"short\" = 0.003; expected more than camera.focal_length_mm (3 mm)",
        ),
    ] {
        let message = refusal(text);
        assert!(message.contains(expected), "{message:?} for {expected:?}");
    }
}

/// Every bound that a message names is itself accepted; what lies beyond it is refused by a message
/// that names the key as it is written.
#[test]
fn the_bounds_of_each_key_are_possible_and_nothing_beyond_them() {
    for (key, good, bad) in [
        (
            "camera.focal_length_mm",
            &["0.1", "1000"][..],
            &["0.09", "1001", "nan", "-4"][..],
        ),
        ("camera.f_number", &["0.5", "128"], &["0.49", "129", "inf"]),
        (
            "camera.focus_distance_m",
            &["0.0041", "inf"],
            &["0.0009", "nan", "-1"],
        ),
        (
            "camera.scene_distance_m",
            &["0.001", "inf"],
            &["0.0009", "nan"],
        ),
        ("camera.blades", &["0", "3", "24"], &["1", "2", "25"]),
        ("camera.blade_angle_deg", &["-360", "360"], &["-361", "361"]),
        ("glass.thickness_mm", &["0.1", "30"], &["0.09", "31", "nan"]),
        ("glass.distance_m", &["0.001", "10"], &["0.0009", "11"]),
        ("glass.rake_deg", &["-80", "80"], &["-81", "81"]),
        ("optics.sun_azimuth_deg", &["-360", "360"], &["nan", "inf"]),
        ("optics.sun_elevation_deg", &["-90", "90"], &["-91", "91"]),
        (
            "optics.sun_irradiance",
            &["0", "1e6"],
            &["-1", "2e6", "nan"],
        ),
        (
            "optics.sky_horizon",
            &["[0,0,0]", "[1e6,1,1]"],
            &["[0,-0.1,0]", "[0,0,nan]"],
        ),
        ("optics.sky_zenith", &["[0,0,0]"], &["[0,0,2000000]"]),
        ("optics.ground", &["[0,0,0]"], &["[-1,0,0]"]),
        ("optics.cabin", &["[0,0,0]"], &["[inf,0,0]"]),
        ("optics.horizon_row", &["-100", "100"], &["-101", "101"]),
        (
            "optics.dashboard_rows",
            &["[]", "[0]", "[0.9,1,0.9]", "[1,1,1,1,1,1,1,1,1]"],
            &["[1.1]", "[0.9,-0.1]", "[nan]", "[1,1,1,1,1,1,1,1,1,1]"],
        ),
        ("optics.refractive_index", &["1.3", "2"], &["1.2", "2.1"]),
        ("optics.mirror_alpha", &["0", "1"], &["-0.1", "1.1"]),
        ("optics.mist_alpha", &["0", "1"], &["-0.1", "1.1"]),
        ("optics.hackle_alpha", &["0", "1"], &["-0.1", "1.1"]),
        ("optics.opening_um", &["0", "1000"], &["-1", "1001"]),
        ("optics.crushed_zone", &["0", "10"], &["-1", "11"]),
        ("optics.chip", &["0", "10"], &["-1", "11"]),
        ("optics.chip_slope_deg", &["0", "60"], &["-1", "61"]),
        ("optics.film", &["0", "10"], &["-1", "11"]),
        ("optics.film_um", &["0", "100"], &["-1", "101"]),
        ("optics.fragment_wedge_deg", &["0", "10"], &["-1", "11"]),
        ("optics.veiling_glare", &["0", "0.5"], &["-1", "0.6"]),
        ("optics.noise_read", &["0", "1"], &["-0.1", "1.1"]),
        ("optics.noise_shot", &["0", "1"], &["-0.1", "1.1"]),
        ("optics.region_threshold", &["0.0001", "1"], &["0", "1.1"]),
    ] {
        for fracture in ["physics", "paper"] {
            let with = |value: &str| {
                let mut recipe = Recipe::preset(DEFAULT_PRESET).unwrap();
                recipe.set(&format!("fracture.model={fracture}")).unwrap();
                // Beyond any focal length.
                recipe.set("camera.focus_distance_m=2").unwrap();
                recipe.set(&format!("{key}={value}"))
            };
            for good in good {
                let result = with(good);
                assert!(result.is_ok(), "{fracture}, {key} = {good}: {result:?}");
            }
            for bad in bad {
                let message = with(bad).unwrap_err().to_string();
                let named = format!("--set {key}={bad}: {key} = ");
                assert!(message.starts_with(&named), "{fracture}: {message}");
                let value = message[named.len()..].split(';').next().unwrap();
                let is_given = bad.eq_ignore_ascii_case(&value.replace(' ', ""))
                    || bad.parse::<f64>().is_ok_and(|bad| value.parse() == Ok(bad));
                assert!(is_given, "{message} repeats {bad}");
            }
        }
    }
}

#[test]
fn keys_of_the_other_optics_are_named_with_the_way_out() {
    assert_eq!(
        refusal("[optics]\nline_width_px = 5"),
        "r.toml: optics.line_width_px is a key of model \"paper\", but this recipe's model is \"physical\"; remove it \
         or set optics.model = \"paper\""
    );
    for (sets, way_out) in [
        (
            &["optics.mirror_alpha=0.1"][..],
            "optics.model = \"physical\"",
        ),
        (&["camera.f_number=2"], "optics.model = \"physical\""),
        (&["camera.blades=5"], "optics.model = \"physical\""),
        (&["glass.distance_m=0.2"], "fracture.model = \"physics\""),
        (
            &["optics.model=physical", "glass.kind=cover"],
            "fracture.model = \"physics\"",
        ),
        (
            &["optics.model=physical", "optics.blur_sigma_px=2"],
            "optics.model = \"paper\"",
        ),
        (
            &["fracture.model=physics", "camera.f_number=2"],
            "optics.model = \"physical\"",
        ),
        (
            &["fracture.model=physics", "impact.force=2"],
            "fracture.model = \"paper\"",
        ),
    ] {
        let mut recipe = Recipe::preset("paper").unwrap();
        let (last, first) = sets.split_last().unwrap();
        for set in first {
            recipe.set(set).unwrap();
        }
        let message = recipe.set(last).unwrap_err().to_string();
        assert!(message.ends_with(way_out), "{sets:?}: {message}");
    }
}

#[test]
fn an_override_of_the_optics_changes_camera_and_optics_alone() {
    let mut recipe = Recipe::preset("lens-cover-star").unwrap();
    recipe.set("camera.f_px=900").unwrap();
    recipe.set("optics.sun_azimuth_deg=12").unwrap();
    let physical_one = recipe.clone();
    recipe.set("optics.model=paper").unwrap();
    let OpticsSettings::Paper(paper) = recipe.settings().unwrap().optics else {
        panic!("still physical");
    };
    let OpticsSettings::Paper(preset) = Recipe::preset("paper").unwrap().settings().unwrap().optics
    else {
        panic!("the paper's preset");
    };
    assert!(near(paper.sun_azimuth_rad, 12_f64.to_radians()), "kept");
    assert_eq!(
        starbreak::optics::paper::PaperOptics {
            sun_azimuth_rad: preset.sun_azimuth_rad,
            ..paper
        },
        preset,
        "the rest is that of the paper's preset"
    );
    let text = recipe.to_toml();
    assert!(
        !text.contains("f_number") && !text.contains("mirror_alpha"),
        "{text}"
    );
    assert!(text.contains("kind = \"cover\""), "the glass stays: {text}");
    recipe.set("optics.model=physical").unwrap();
    let mut expected = physical_one;
    for key in ["camera.focal_length_mm=3.0", "camera.f_number=2.8"] {
        expected.set(key).unwrap();
    }
    assert_eq!(
        recipe, expected,
        "and back, with the lens of windshield-star"
    );

    recipe.set("camera.focus_distance_m=1.5").unwrap();
    let message = recipe.set("optics.model=paper").unwrap_err().to_string();
    assert!(
        message.contains("camera.focus_distance_m: expected \"far\" or \"short\""),
        "a distance that the paper does not know is not dropped: {message}"
    );
}

#[test]
fn the_papers_cracks_are_shown_through_a_pane_of_which_only_the_place_counts() {
    let text = "fracture.model = \"paper\"\n[optics]\nmodel = \"physical\"\n[glass]\nthickness_mm = 4\nrake_deg = 30";
    let recipe = parse(text);
    let settings = recipe.settings().unwrap();
    let FractureSettings::Paper(paper) = &settings.fracture else {
        panic!("the physics");
    };
    let mount = paper.mount.unwrap();
    assert_eq!(
        settings.fracture.mount(),
        Some(mount),
        "that of the fracture"
    );
    assert!(near(mount.rake_rad, std::f64::consts::PI / 6.0), "rake");
    assert!(near(mount.distance_m, 0.15), "that of windshield-star");
    assert!(
        near(physical(&settings).glass.thickness_mm, 4.0),
        "thickness"
    );
    let glass: Vec<String> = recipe
        .to_toml()
        .split("[glass]\n")
        .nth(1)
        .unwrap()
        .lines()
        .take_while(|line| !line.is_empty())
        .map(|line| line.split(" = ").next().unwrap().to_owned())
        .collect();
    assert_eq!(glass.len(), 3, "{glass:?}");

    let paper = Recipe::preset("paper").unwrap().settings().unwrap();
    assert_eq!(paper.fracture.mount(), None, "the paper has no glass");
}

#[test]
fn only_the_physical_optics_have_maps() {
    assert!(
        parse("output.maps = true").settings().unwrap().output.maps,
        "asked for"
    );
    let message = refusal("optics.model = \"paper\"\noutput.maps = true");
    assert!(
        message.ends_with("output.maps: the paper's optics have no maps; leave it false or set optics.model = \"physical\""),
        "{message}"
    );
}

#[test]
fn every_camera_suits_every_preset_and_sets_what_it_says() {
    let cameras = starbreak::cameras().unwrap();
    assert!(!cameras.is_empty(), "there are some");
    for (camera, purpose) in cameras {
        assert!(!purpose.is_empty(), "{camera} says what it is");
        for (preset, _) in PRESETS {
            for optics in ["physical", "paper"] {
                let mut recipe = Recipe::preset(preset).unwrap();
                recipe.set(&format!("optics.model={optics}")).unwrap();
                if optics == "physical" {
                    recipe.set("camera.focal_length_mm=9.5").unwrap();
                }
                let before = recipe.clone();
                recipe
                    .set_camera(&camera)
                    .unwrap_or_else(|error| panic!("{camera} on {preset}, {optics}: {error}"));
                recipe.settings().unwrap();
                if optics == "physical" {
                    assert_ne!(recipe, before, "{camera} on {preset}");
                }
            }
        }
    }
}

#[test]
fn a_camera_leaves_out_what_the_models_do_not_have() {
    let mut paper = Recipe::preset("paper").unwrap();
    paper.set_camera("adas-1080p").unwrap();
    let mut expected = Recipe::preset("paper").unwrap();
    let f_px = match paper.settings().unwrap().camera.f_px {
        FocalLength::Px(f_px) => f_px,
        FocalLength::Auto => panic!("a camera of 1080p has its focal length"),
    };
    expected.set(&format!("camera.f_px={f_px:?}")).unwrap();
    assert_eq!(paper, expected, "of the paper's keys only f_px");

    let mut recipe = Recipe::preset(DEFAULT_PRESET).unwrap();
    let before = recipe.clone();
    let message = recipe.set_camera("kity").unwrap_err().to_string();
    assert_eq!(message, "unknown camera `kity`; did you mean `kitti`?");
    assert_eq!(recipe, before, "unchanged");
}
