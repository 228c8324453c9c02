//! The two fracture models in a recipe: which keys each has, in which units, and what severity
//! makes of them.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use starbreak::fracture::physics::GlassBuild;
use starbreak::{DEFAULT_PRESET, FractureSettings, PRESETS, PhysicsSettings, Recipe};

fn refusal(text: &str) -> String {
    let message = Recipe::parse("r.toml", text).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one line: {message:?}");
    message
}

fn physics(recipe: &Recipe) -> PhysicsSettings {
    match recipe.settings().unwrap().fracture {
        FractureSettings::Physics(physics) => *physics,
        _ => panic!("not the physics"),
    }
}

#[test]
fn a_pane_of_another_kind_is_filled_in_from_the_preset_that_has_one() {
    let of =
        |text: &str| physics(&Recipe::parse("r.toml", &format!("schema = 1\n{text}")).unwrap());
    let tempered = of("[glass]\nkind = \"tempered\"\nwidth_mm = 900");
    let preset = physics(&Recipe::preset("tempered-cover").unwrap());
    assert_eq!(tempered.pane.build, preset.pane.build, "its compression");
    let [width_m, height_m] = tempered.pane.outline.size_m();
    assert!(
        (width_m - 0.9).abs() < 1e-12 && (height_m - 0.1).abs() < 1e-12,
        "its size"
    );
    let cover = of("[glass]\nkind = \"cover\"");
    assert_eq!(
        cover.pane.build,
        GlassBuild::Annealed,
        "a cover is annealed"
    );
    let cover = of("[glass]\nkind = \"cover\"\nsurface_compression_mpa = 80");
    let tempered = GlassBuild::Tempered {
        surface_compression_pa: 80e6,
    };
    assert_eq!(
        cover.pane.build, tempered,
        "unless its compression is given"
    );
    let annealed = of("[glass]\nkind = \"annealed\"");
    assert_eq!(annealed.pane.build, GlassBuild::Annealed, "no interlayer");

    let mut recipe = Recipe::preset(DEFAULT_PRESET).unwrap();
    recipe.set("glass.width_mm=900").unwrap();
    recipe.set("glass.kind=tempered").unwrap();
    let pane = physics(&recipe).pane;
    assert_eq!(pane.build, preset.pane.build, "by an override");
    assert!(
        (pane.outline.size_m()[0] - 0.9).abs() < 1e-12,
        "which keeps the rest"
    );
    let message = recipe.set("glass.kind=cover").unwrap_err().to_string();
    assert!(message.contains("a cover is a disc"), "{message}");
}

#[test]
fn an_override_of_the_model_changes_the_base() {
    let mut recipe = Recipe::preset("windshield-long-crack").unwrap();
    recipe.set("impact.position=[0.25, 0.75]").unwrap();
    recipe.set("output.quality=77").unwrap();
    recipe.set("fracture.model=paper").unwrap();
    let mut expected = Recipe::preset("paper").unwrap();
    expected.set("optics.model=physical").unwrap();
    expected.set("glass.distance_m=0.3").unwrap();
    expected.set("impact.position=[0.25, 0.75]").unwrap();
    expected.set("output.quality=77").unwrap();
    assert_eq!(recipe, expected, "what both models have stays");
    recipe.set("fracture.model=physics").unwrap();
    let mut expected = Recipe::parse("r.toml", "schema = 1").unwrap();
    expected.set("glass.distance_m=0.3").unwrap();
    expected.set("impact.position=[0.25, 0.75]").unwrap();
    expected.set("output.quality=77").unwrap();
    assert_eq!(recipe, expected, "and back");
}

#[test]
fn a_long_crack_begins_with_its_first_key() {
    let mut recipe = Recipe::preset(DEFAULT_PRESET).unwrap();
    assert_eq!(physics(&recipe).long_crack, None, "a star has none");
    recipe.set("long_crack.origin=rim").unwrap();
    let mut expected = Recipe::preset("windshield-long-crack").unwrap();
    expected.set("long_crack.origin=rim").unwrap();
    let expected = physics(&expected).long_crack;
    assert_eq!(
        physics(&recipe).long_crack,
        expected,
        "the rest is the preset's"
    );
    let message = refusal("schema = 1\n[long_crack]\nperiod = 5");
    assert!(
        message.contains("did you mean `long_crack.period_s`?"),
        "{message}"
    );
}

/// The value of a key in a printed recipe.
fn printed(recipe: &Recipe, table: &str, key: &str) -> f64 {
    let text = recipe.to_toml();
    let (_, after) = text.split_once(&format!("[{table}]")).unwrap();
    let (_, value) = after.split_once(&format!("\n{key} = ")).unwrap();
    let value = value.lines().next().unwrap();
    if value == "\"end\"" {
        f64::INFINITY
    } else {
        value.parse().unwrap()
    }
}

#[test]
fn severity_grows_and_three_is_the_preset() {
    for (name, _) in PRESETS {
        let preset = Recipe::preset(name).unwrap();
        let at = [1, 2, 3, 4, 5].map(|severity| Recipe::preset_at(name, severity).unwrap());
        assert_eq!(at[2], preset, "{name} at severity 3");
        let (mild, severe) = (at[0].to_toml(), at[4].to_toml());
        let mut table = "";
        let mut n_scaled = 0;
        for ((line, mild), severe) in preset
            .to_toml()
            .lines()
            .zip(mild.lines())
            .zip(severe.lines())
        {
            if line.starts_with('[') {
                table = line.trim_matches(['[', ']']);
            }
            if mild == severe {
                assert_eq!(line, mild, "{name}: goes and comes back");
                continue;
            }
            n_scaled += 1;
            let key = line.split(" = ").next().unwrap();
            let header = if table == "impact" { "[impact]" } else { table };
            let values = at.each_ref().map(|recipe| printed(recipe, header, key));
            assert!(
                values.windows(2).all(|pair| pair[0].abs() <= pair[1].abs()),
                "{name}: {table}.{key} = {values:?}"
            );
        }
        assert!(n_scaled > 0, "{name}: severity does nothing");
        for recipe in &at {
            let again = Recipe::parse("again", &recipe.to_toml()).unwrap();
            assert_eq!(&again, recipe, "{name}");
        }
    }
    for found in [0, 6, 255] {
        let message = Recipe::preset_at("paper", found).unwrap_err().to_string();
        assert!(
            message.starts_with(&format!("severity {found}; expected 1 ")),
            "{message}"
        );
    }
    assert!(Recipe::preset_at("papre", 3).is_err(), "no such preset");
    let text = refusal("schema = 1\n[severity]\n\"impact.speed_m_s\" = [1, 2, 3, 4, 5]");
    assert!(
        text.contains("unknown key `severity`"),
        "of presets only: {text}"
    );
}

/// Every bound that a message names is itself accepted, and comes out in SI units.
#[test]
fn the_bounds_of_each_key_are_possible() {
    for (preset, key, bounds) in [
        ("paper", "camera.f_px", &[1e6][..]),
        ("windshield-star", "glass.width_mm", &[2.0, 1e4]),
        ("windshield-star", "glass.height_mm", &[2.0, 1e4]),
        ("windshield-star", "glass.thickness_mm", &[0.1, 30.0]),
        (
            "windshield-star",
            "glass.interlayer_thickness_mm",
            &[0.05, 20.0],
        ),
        (
            "windshield-star",
            "glass.interlayer_modulus_mpa",
            &[0.1, 1e4],
        ),
        (
            "tempered-cover",
            "glass.surface_compression_mpa",
            &[0.1, 1000.0],
        ),
        (
            "lens-cover-star",
            "glass.surface_compression_mpa",
            &[0.1, 1000.0],
        ),
        ("windshield-star", "glass.distance_m", &[0.001, 10.0]),
        ("windshield-star", "glass.rake_deg", &[-80.0, 80.0]),
        ("windshield-star", "impact.speed_m_s", &[0.01, 1000.0]),
        ("windshield-star", "impact.radius_mm", &[1.0, 200.0]),
        ("windshield-star", "impact.tip_radius_mm", &[0.01, 3.0]),
        ("windshield-star", "impact.angle_deg", &[0.0, 85.0]),
        (
            "windshield-star",
            "impact.density_kg_m3",
            &[100.0, 25_000.0],
        ),
        ("windshield-star", "fracture.epochs", &[1.0, 6.0]),
        (
            "windshield-star",
            "fracture.radial_count_factor",
            &[0.1, 100.0],
        ),
        ("windshield-star", "fracture.strength_mpa", &[1.0, 1e4]),
        ("windshield-star", "fracture.weibull_modulus", &[1.0, 100.0]),
        (
            "windshield-long-crack",
            "long_crack.temperature_difference_k",
            &[-300.0, 300.0],
        ),
        (
            "windshield-long-crack",
            "long_crack.spot_size",
            &[0.05, 5.0],
        ),
        (
            "windshield-long-crack",
            "long_crack.frame_tension_mpa",
            &[0.0, 100.0],
        ),
        (
            "windshield-long-crack",
            "long_crack.flaw_mm",
            &[0.01, 100.0],
        ),
        ("windshield-long-crack", "long_crack.period_s", &[1e-3, 1e6]),
    ] {
        for bound in bounds {
            let mut recipe = Recipe::preset(preset).unwrap();
            // A tip that suits every stone.
            if preset != "paper" {
                recipe.set("impact.tip_radius_mm=0.01").unwrap();
            }
            let result = recipe.set(&format!("{key}={bound}"));
            assert!(result.is_ok(), "{preset}: {key} = {bound}: {result:?}");
        }
    }
}

#[test]
fn physics_come_out_in_si_units() {
    let text = "schema = 1\n[camera]\nf_px = 1900.5\n\
        [glass]\nwidth_mm = 1234.5\nheight_mm = 678.9\nthickness_mm = 2.3\n\
        interlayer_thickness_mm = 1.14\ninterlayer_modulus_mpa = 456\n\
        inner_thickness_mm = 1.6\nsupport = \"clamped\"\n\
        distance_m = 0.31\nrake_deg = -45\naxis_at = [0.25, 0.75]\n\
        [[impact]]\nposition = [0.125, 0.5]\nspeed_m_s = 27.5\nradius_mm = 4.4\ntip_radius_mm = 0.6\n\
        angle_deg = 30\nazimuth_deg = 90\ndensity_kg_m3 = 7800\n\
        [fracture]\nstrength_mpa = 55\nweibull_modulus = 5.5\nradial_count_factor = 3.3\nepochs = 2\n\
        [long_crack]\ntemperature_difference_k = -20\nframe_tension_mpa = 2.5\nflaw_mm = 0.4\n\
        frame_direction_deg = 180\nspot_size = 0.7\nspot = [0.2, 0.9]\ngrowth = \"slow\"\nperiod_s = 33";
    let recipe = Recipe::parse("r.toml", text).unwrap();
    let camera = recipe.settings().unwrap().camera;
    let auto = Recipe::preset(DEFAULT_PRESET)
        .unwrap()
        .settings()
        .unwrap()
        .camera;
    let physics = physics(&recipe);
    let stone = physics.stones[0].at([0.1, 0.2], 1.5, 0.0);
    let crack = physics.long_crack.unwrap();
    let GlassBuild::Laminated {
        interlayer_thickness_m,
        interlayer_modulus_pa,
        inner_thickness_m,
    } = physics.pane.build
    else {
        panic!("{:?}", physics.pane.build);
    };
    let pi = std::f64::consts::PI;
    for (what, value, expected) in [
        ("f_px", camera.f_px.of_frame(1920), 1900.5),
        // KITTI's calibration file says 721.5377 px for its frames of 1242 px.
        ("auto f_px", auto.f_px.of_frame(1242), 721.5377),
        ("twice the frame", auto.f_px.of_frame(2484), 2.0 * 721.5377),
        ("width", physics.pane.outline.size_m()[0], 1.2345),
        ("height", physics.pane.outline.size_m()[1], 0.6789),
        ("thickness", physics.pane.thickness_m, 0.0023),
        ("interlayer", interlayer_thickness_m, 0.00114),
        ("modulus", interlayer_modulus_pa, 456e6),
        ("inner ply", inner_thickness_m, 0.0016),
        ("distance", physics.mount.distance_m, 0.31),
        ("rake", physics.mount.rake_rad, -pi / 4.0),
        ("axis x", physics.mount.axis_at[0], 0.25),
        ("axis y", physics.mount.axis_at[1], 0.75),
        ("stone x", stone.position_m[0], 0.1),
        ("azimuth", stone.azimuth_rad, 1.5),
        ("speed", stone.speed_m_s, 27.5),
        ("radius", stone.radius_m, 0.0044),
        ("tip", stone.tip_radius_m, 0.0006),
        ("angle", stone.obliquity_rad, pi / 6.0),
        ("density", stone.density_kg_m3, 7800.0),
        ("strength", physics.params.strength_pa, 55e6),
        ("modulus", physics.params.weibull_modulus, 5.5),
        ("factor", physics.params.radial_count_factor, 3.3),
        ("warmth", crack.load.temperature_difference_k, -20.0),
        ("spot", crack.load.spot[1], 0.9),
        ("spot size", crack.load.spot_size, 0.7),
        ("tension", crack.load.frame_tension_pa, 2.5e6),
        ("tension's direction", crack.load.frame_direction_rad, pi),
        ("flaw", crack.flaw_m, 0.0004),
    ] {
        assert!(
            (value / expected - 1.0).abs() < 1e-12,
            "{what}: {value} for {expected}"
        );
    }
    assert_eq!(physics.params.epochs, 2, "epochs");
    let slow = starbreak::fracture::physics::LongCrackGrowth::Slow { period_s: 33.0 };
    assert_eq!(crack.growth, slow, "growth");
}

#[test]
fn keys_of_the_other_model_are_named_with_the_way_out() {
    assert_eq!(
        refusal("schema = 1\n[fracture]\nparticles = 5"),
        "r.toml: fracture.particles is a key of model \"paper\", but this recipe's model is \"physics\"; remove it \
         or set fracture.model = \"paper\""
    );
    assert_eq!(
        refusal("schema = 1\n[fracture]\nmodel = \"paper\"\n[glass]\nkind = \"tempered\""),
        "r.toml: glass is a table of model \"physics\", but this recipe's model is \"paper\"; remove it or set \
         fracture.model = \"physics\""
    );
    for (preset, set, key) in [
        ("windshield-star", "impact.force=5", "impact.0.force"),
        (
            "windshield-star",
            "impact.0.direction_deg=5",
            "impact.0.direction_deg",
        ),
        ("tempered-cover", "fracture.rule=caption", "fracture.rule"),
        ("paper", "impact.speed_m_s=5", "impact.0.speed_m_s"),
        ("paper", "fracture.epochs=5", "fracture.epochs"),
        ("paper", "glass.kind=tempered", "glass"),
        ("paper", "long_crack.flaw_mm=1", "long_crack"),
    ] {
        let mut recipe = Recipe::preset(preset).unwrap();
        let message = recipe.set(set).unwrap_err().to_string();
        assert!(
            message.starts_with(&format!("--set {set}: {key} is a ")),
            "{message}"
        );
    }
}

#[test]
fn one_override_changes_the_diameter_of_a_cover() {
    let mut recipe = Recipe::preset("lens-cover-star").unwrap();
    recipe.set("glass.width_mm=24").unwrap();
    let text = recipe.to_toml();
    assert!(text.contains("width_mm = 24"), "{text}");
    assert!(text.contains("height_mm = 24"), "{text}");
}
