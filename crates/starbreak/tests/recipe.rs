//! What a recipe may say, and what is said back.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use starbreak::fracture::paper::PaperImpact;
use starbreak::fracture::physics::GlassBuild;
use starbreak::{
    DEFAULT_PRESET, FractureSettings, PRESETS, PaperSettings, PhysicsSettings, Recipe, RecipeError,
    Settings, json_schema,
};

fn refusal(text: &str) -> String {
    let message = Recipe::parse("r.toml", text).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one line: {message:?}");
    message
}

fn paper(settings: &Settings) -> &PaperSettings {
    match &settings.fracture {
        FractureSettings::Paper(paper) => paper,
        FractureSettings::Physics(_) => panic!("the physics"),
    }
}

fn physics(recipe: &Recipe) -> PhysicsSettings {
    match recipe.settings().unwrap().fracture {
        FractureSettings::Physics(physics) => physics,
        FractureSettings::Paper(_) => panic!("the paper"),
    }
}

fn paper_impacts(settings: &Settings) -> Vec<PaperImpact> {
    paper(settings).impacts_on(&starbreak::glass::Pane::from_frame_px(100, 50))
}

#[test]
fn presets_are_complete_and_print_as_themselves() {
    for (name, _) in PRESETS {
        let preset = Recipe::preset(name).unwrap();
        preset.settings().unwrap();
        for text in [preset.to_toml(), preset.to_commented_toml()] {
            assert_eq!(
                Recipe::parse(name, &text).unwrap(),
                preset,
                "{name} read from its own print"
            );
        }
        let commented = preset.to_commented_toml();
        let keys = commented
            .lines()
            .filter(|line| line.contains(" = "))
            .count();
        let comments = commented
            .lines()
            .filter(|line| line.starts_with('#'))
            .count();
        assert!(
            comments >= keys,
            "each of {keys} keys has its comment, {comments} lines"
        );
    }
}

#[test]
fn the_schema_knows_every_key_of_every_preset_and_needs_none() {
    let schema = json_schema();
    assert_eq!(
        schema["required"],
        serde_json::json!(["schema"]),
        "of a recipe"
    );
    assert_eq!(
        schema.to_string().matches("\"required\"").count(),
        1,
        "tables may be left out in part"
    );
    for (name, _) in PRESETS {
        let mut table = &schema;
        for line in Recipe::preset(name).unwrap().to_toml().lines() {
            if line.starts_with('[') {
                let property = &schema["properties"][line.trim_matches(['[', ']'])];
                let items = &property["items"];
                table = if items.is_object() { items } else { property };
                assert_eq!(table["additionalProperties"], false, "{name}: {line}");
            } else if let Some((key, _)) = line.split_once(" = ") {
                let property = &table["properties"][key];
                assert!(property["description"].is_string(), "{name}: {key}");
            }
        }
    }
    let description = |table: &str, key: &str| {
        let property = &schema["properties"][table];
        let owner = if property["items"].is_object() {
            &property["items"]
        } else {
            property
        };
        owner["properties"][key]["description"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert!(
        description("fracture", "particles").starts_with("(paper) "),
        "of one model"
    );
    assert!(
        description("impact", "speed_m_s").starts_with("(physics) "),
        "of one model"
    );
    assert!(
        description("impact", "position").starts_with("Where"),
        "of both"
    );
    let glass = schema["properties"]["glass"]["description"]
        .as_str()
        .unwrap();
    assert!(glass.starts_with("(physics) "), "{glass}");
}

#[test]
fn what_a_recipe_leaves_out_comes_from_the_preset_of_its_model() {
    let empty = Recipe::parse("r.toml", "schema = 1").unwrap();
    assert_eq!(empty, Recipe::preset(DEFAULT_PRESET).unwrap(), "physics");
    let recipe = Recipe::parse(
        "r.toml",
        "schema = 1\nfracture.model = \"paper\"\n[[impact]]\nforce = 700\n[[impact]]\nposition = [0.1, 0.9]",
    )
    .unwrap();
    let settings = recipe.settings().unwrap();
    let impacts = paper_impacts(&settings);
    assert_eq!(impacts.len(), 2, "two impacts replace the preset's one");
    assert!(
        (impacts[0].force - 700.0).abs() < 1e-12 && (impacts[1].force - 500.0).abs() < 1e-12,
        "each completed"
    );
    assert_eq!(
        paper(&settings).params.particles,
        10_000,
        "and the rest is the preset's"
    );
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
    expected.set("impact.position=[0.25, 0.75]").unwrap();
    expected.set("output.quality=77").unwrap();
    assert_eq!(recipe, expected, "what both models have stays");
    recipe.set("fracture.model=physics").unwrap();
    let mut expected = Recipe::preset(DEFAULT_PRESET).unwrap();
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
    value.lines().next().unwrap().parse().unwrap()
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
                values.windows(2).all(|pair| pair[0] < pair[1]),
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
            let result = recipe.set(&format!("{key}={bound}"));
            assert!(result.is_ok(), "{preset}: {key} = {bound}: {result:?}");
        }
    }
}

#[test]
fn physics_come_out_in_si_units() {
    let text = "schema = 1\n[camera]\nf_px = 1900.5\n\
        [glass]\nwidth_mm = 1234.5\nheight_mm = 678.9\nthickness_mm = 2.3\n\
        interlayer_thickness_mm = 1.14\ninterlayer_modulus_mpa = 456\nsupport = \"clamped\"\n\
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
    let stone = physics.stones[0].at([0.1, 0.2], 1.5);
    let crack = physics.long_crack.unwrap();
    let GlassBuild::Laminated {
        interlayer_thickness_m,
        interlayer_modulus_pa,
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
fn each_mistake_is_named_with_its_place_and_a_way_out() {
    let cases = [
        (
            "schema = 1\n[fracture]\nparticels = 5",
            "`fracture.particels`; did you mean `fracture.particles`?",
        ),
        (
            "schema = 1\n[fractures]\n",
            "`fractures`; did you mean `fracture`?",
        ),
        (
            "schema = 1\n[[impact]]\nspeed_m_s = 1\n[[impact]]\nfrce = 2",
            "`impact.1.frce`; did you mean `impact.1.force`?",
        ),
        ("schema = 1\n[optics]\nzzz = 1", "known keys: model, "),
        (
            "schema = 1\n[[impact]]\nsped_m_s = 1",
            "`impact.0.sped_m_s`; did you mean `impact.0.speed_m_s`?",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"physic\"",
            "fracture.model: unknown variant `physic`, expected `physics` or `paper`",
        ),
        ("schema = 1\nfracture = 5", "fracture: expected a table"),
        (
            "schema = 1\nglass.kind = \"plastic\"",
            "glass.kind: unknown variant `plastic`",
        ),
        (
            "schema = 1\n[glass]\nkind = \"tempered\"\ninterlayer_modulus_mpa = 5",
            "glass.interlayer_modulus_mpa: glass of this glass.kind has none",
        ),
        (
            "schema = 1\nglass.surface_compression_mpa = 5",
            "glass.surface_compression_mpa: glass of this glass.kind has none",
        ),
        (
            "schema = 1\nglass.thickness_mm = 0.07",
            "glass.thickness_mm = 0.07; expected 0.1 to 30 mm",
        ),
        (
            "schema = 1\n[[impact]]\ntip_radius_mm = 5",
            "impact.0.tip_radius_mm = 5",
        ),
        (
            "schema = 1\n[[impact]]\nazimuth_deg = nan",
            "impact.0.azimuth_deg = NaN",
        ),
        (
            "schema = 1\ncamera.f_px = 0",
            "camera.f_px = 0; expected \"auto\", or above 0",
        ),
        (
            "schema = 1\ncamera.f_px = \"wide\"",
            "\"auto\" or a focal length in px",
        ),
        ("[fracture]\n", "`schema` is missing"),
        ("schema = 2", "schema = 2; this version reads schema = 1"),
        ("schema = \"1\"", "this version reads schema = 1"),
        ("schema = 1\nimpact = []", "number of [[impact]] tables = 0"),
        ("schema = 1\nimpact = 5", "impact"),
        ("schema = 1\ncamera = 5", "camera"),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nparticles = 0",
            "fracture.particles = 0; expected 1 to 10000000",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nparticles = -1",
            "fracture.particles",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nparticles = 1.5",
            "fracture.particles",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nneighbour_radius_px = 0",
            "fracture.neighbour_radius_px = 0",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\ncritical_stress = nan",
            "fracture.critical_stress = NaN",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nsafety_factor = -inf",
            "fracture.safety_factor = -inf",
        ),
        (
            "schema = 1\n[fracture]\nmodel = \"paper\"\nrule = \"algorithm\"",
            "fracture.rule",
        ),
        (
            "schema = 1\n[[impact]]\nposition = [1.5, 0.5]",
            "impact.0.position = [1.5, 0.5]",
        ),
        (
            "schema = 1\n[[impact]]\nposition = [0.5]",
            "impact.0.position",
        ),
        (
            "schema = 1\n[[impact]]\nposition = \"middle\"",
            "\"random\" or [x, y]",
        ),
        (
            "schema = 1\nfracture.model = \"paper\"\n[[impact]]\nforce = -5",
            "impact.0.force = -5",
        ),
        (
            "schema = 1\nfracture.model = \"paper\"\n[[impact]]\ndirection_deg = nan",
            "impact.0.direction_deg",
        ),
        (
            "schema = 1\n[optics]\nblur_kernel_px = 14",
            "optics.blur_kernel_px = 14",
        ),
        (
            "schema = 1\n[optics]\nline_width_px = 1e9",
            "optics.line_width_px = 1000000000",
        ),
        (
            "schema = 1\n[optics]\nlight_intensity = [1, 2]",
            "optics.light_intensity",
        ),
        (
            "schema = 1\n[optics]\nlight_intensity = [1, 2, 300]",
            "light_intensity = 300",
        ),
        ("schema = 1\n[output]\nquality = 0", "output.quality = 0"),
        ("schema = 1\n[output]\nmasks = \"yes\"", "output.masks"),
        (
            "schema = 1\n[camera]\nfocus_distance_m = 3.0",
            "camera.focus_distance_m",
        ),
        ("schema = 1\n[fracture\n", "r.toml:2:"),
        ("schema = 1\nschema = 1", "r.toml:2:"),
    ];
    for (text, expected) in cases {
        let message = refusal(text);
        assert!(
            message.starts_with("r.toml"),
            "{message:?} does not name the file"
        );
        assert!(
            message.contains(expected),
            "{message:?} does not say {expected:?}"
        );
    }
    let unknown = Recipe::preset("papre").unwrap_err().to_string();
    assert!(unknown.contains("did you mean `paper`?"), "{unknown}");
}

#[test]
fn overrides_reach_one_impact_or_all_and_fail_without_a_trace() {
    let mut recipe = Recipe::parse(
        "r.toml",
        "schema = 1\nfracture.model = \"paper\"\n[[impact]]\n[[impact]]\n",
    )
    .unwrap();
    recipe.set("impact.force=600").unwrap();
    recipe.set("impact.1.force = 700").unwrap();
    recipe.set("camera.focus_distance_m=short").unwrap();
    let forces: Vec<f64> = paper_impacts(&recipe.settings().unwrap())
        .iter()
        .map(|impact| impact.force)
        .collect();
    assert_eq!(forces, [600.0, 700.0], "all, then one");

    let before = recipe.clone();
    for bad in [
        "impact.2.force=1",
        "impact.x.force=1",
        "force=1",
        "a.b.c.d=1",
        "fracture.rule",
        "nothing.x=1",
        "fracture.particles=0",
        "fracture.x=1",
        "schema=3",
        "=",
        ".=",
        "fracture.particles=1\nx=2",
    ] {
        let message = recipe.set(bad).unwrap_err().to_string();
        assert!(
            message.starts_with("--set ") && !message.contains('\n'),
            "{bad:?}: {message:?}"
        );
        assert_eq!(recipe, before, "{bad:?} left a trace");
    }
}

fn scalar() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<i64>().prop_map(|n| n.to_string()),
        any::<f64>().prop_map(|x| if x.is_finite() {
            format!("{x:?}")
        } else {
            "nan".to_owned()
        }),
        prop::sample::select(vec![
            "true",
            "\"random\"",
            "\"far\"",
            "[0.5, 0.5]",
            "[1,2,3]",
            "\"paper\"",
            "\"physics\"",
            "\"cover\"",
            "\"tempered\"",
            "\"slow\"",
            "{a=1}",
            "inf"
        ])
        .prop_map(str::to_owned),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn any_override_is_refused_in_one_line_or_gives_valid_settings(
        key in prop::sample::select(vec![
            "camera.focus_distance_m", "impact.position", "impact.0.force", "impact.direction_deg", "fracture.model",
            "fracture.particles", "fracture.neighbour_radius_px", "fracture.critical_stress", "fracture.safety_factor",
            "fracture.branches", "optics.sun_azimuth_deg", "optics.light_intensity", "optics.line_width_px",
            "optics.blur_kernel_px", "optics.blur_sigma_px", "output.quality", "output.masks",
            "camera.f_px", "glass.kind", "glass.width_mm", "glass.surface_compression_mpa", "glass.axis_at",
            "glass.distance_m", "impact.speed_m_s", "impact.azimuth_deg", "fracture.epochs", "fracture.dicing",
            "long_crack.spot", "long_crack.growth",
        ]),
        preset in prop::sample::select(PRESETS.map(|(name, _)| name).to_vec()),
        value in scalar(),
    ) {
        let mut recipe = Recipe::preset(preset).unwrap();
        match recipe.set(&format!("{key}={value}")) {
            Ok(()) => {
                let settings = recipe.settings().unwrap();
                let again = Recipe::parse("again", &recipe.to_toml()).unwrap();
                prop_assert_eq!(again.settings().unwrap(), settings, "the print of a recipe is the recipe");
            }
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{}", error),
        }
    }

    #[test]
    fn no_text_makes_the_parser_panic(text in "[a-z\\[\\]={}\",.0-9 \n#]{0,120}") {
        let outcome = Recipe::parse("r.toml", &format!("schema = 1\n{text}"));
        if let Err(error) = outcome {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
            prop_assert!(!matches!(error, RecipeError::NoSchema { .. }), "the schema is there");
        }
    }
}
