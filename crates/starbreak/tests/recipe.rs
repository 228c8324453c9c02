//! What a recipe may say, and what is said back.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use proptest::prelude::*;
use starbreak::fracture::paper::PaperImpact;
use starbreak::{
    FractureSettings, PRESETS, PaperSettings, Recipe, RecipeError, Settings, json_schema,
};

fn refusal(text: &str) -> String {
    let message = Recipe::parse("r.toml", text).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one line: {message:?}");
    message
}

fn paper(settings: &Settings) -> &PaperSettings {
    match &settings.fracture {
        FractureSettings::Paper(paper) => paper,
        _ => panic!("no model of the paper"),
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
    assert!(glass.starts_with("(physics or physical) "), "{glass}");
    for (table, key, start) in [
        ("glass", "kind", "(physics) "),
        ("glass", "distance_m", "Distance"),
        ("camera", "f_number", "(physical) "),
        ("optics", "line_width_px", "(paper) "),
        ("optics", "mirror_alpha", "(physical) "),
        ("optics", "model", "Optics model"),
    ] {
        let description = description(table, key);
        assert!(
            description.starts_with(start),
            "{table}.{key}: {description}"
        );
    }
    let focus = &schema["properties"]["camera"]["properties"]["focus_distance_m"];
    assert_eq!(
        focus["anyOf"].as_array().map(Vec::len),
        Some(2),
        "that of each optics model: {focus}"
    );
}

#[test]
fn what_a_recipe_leaves_out_comes_from_the_preset_of_its_model() {
    let empty = Recipe::parse("r.toml", "schema = 1").unwrap();
    let [empty, star] = [empty, Recipe::preset("windshield-star").unwrap()].map(|recipe| {
        match recipe.settings().unwrap().fracture {
            FractureSettings::Physics(physics) => physics,
            _ => panic!("not the physics"),
        }
    });
    assert_eq!(empty.pane, star.pane, "physics");
    assert_eq!(empty.stones, star.stones, "physics");
    assert_eq!(empty.long_crack, None, "nothing goes on unless asked for");
    assert_eq!(
        empty.params.until_reach_m, None,
        "nothing stops unless asked for"
    );
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
            "fracture.model: unknown word `physic`, expected one of `physics`, `paper`, `none`",
        ),
        ("schema = 1\nfracture = 5", "fracture: expected a table"),
        (
            "schema = 1\nglass.kind = \"plastic\"",
            "glass.kind: unknown word `plastic`",
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
            "schema = 1\n[[impact]]\ntip_radius_mm = 9",
            "impact.0.tip_radius_mm = 9",
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
            "\"random\", \"anywhere\", \"object\" or [x, y]",
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
            "schema = 1\n[optics]\nmodel = \"paper\"\nblur_kernel_px = 14",
            "optics.blur_kernel_px = 14",
        ),
        (
            "schema = 1\n[optics]\nmodel = \"paper\"\nline_width_px = 1e9",
            "optics.line_width_px = 1000000000",
        ),
        (
            "schema = 1\n[optics]\nmodel = \"paper\"\nlight_intensity = [1, 2]",
            "optics.light_intensity",
        ),
        (
            "schema = 1\n[optics]\nmodel = \"paper\"\nlight_intensity = [1, 2, 300]",
            "light_intensity = [1, 2, 300]; expected \"image-mean\", or 0 to 255 each",
        ),
        ("schema = 1\n[output]\nquality = 0", "output.quality = 0"),
        ("schema = 1\n[output]\nmasks = \"yes\"", "output.masks"),
        (
            "schema = 1\noptics.model = \"paper\"\n[camera]\nfocus_distance_m = 3.0",
            "camera.focus_distance_m: expected \"far\" or \"short\" (the paper's optics know no distance",
        ),
        (
            "schema = 1\n[optics]\nmodel = \"pbr\"",
            "optics.model: unknown word `pbr`, expected `physical` or `paper`",
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

/// Keys of tables of a schema with what it says of each, as overrides name them.
fn keys_of(schema: &serde_json::Value) -> Vec<(String, &serde_json::Value)> {
    let tables = schema["properties"].as_object().unwrap();
    let tables = tables.iter().flat_map(|(table, of_table)| {
        let items = &of_table["items"];
        let owner = if items.is_object() { items } else { of_table };
        let keys = owner["properties"].as_object().into_iter().flatten();
        keys.map(move |(key, of_key)| (format!("{table}.{key}"), of_key))
    });
    tables.collect()
}

#[test]
fn the_comment_of_a_key_says_its_range_and_the_models_take_both_ends_of_it() {
    let schema = json_schema();
    let mut n_ends = 0;
    for (key, of_key) in keys_of(&schema) {
        let comment = of_key["description"].as_str().unwrap();
        for end in ["minimum", "maximum"] {
            let Some(value) = of_key[end].as_f64() else {
                continue;
            };
            let written = [format!("{value}"), format!("{value:e}")];
            let is_said = comment.split_whitespace().any(|word| {
                let word = word.trim_matches(['(', ')', ',', ';', ':', '.']);
                written.iter().any(|value| value == word)
            });
            let is_of_another = comment.contains(", as ") || comment.contains("fractions of");
            assert!(
                is_said || is_of_another,
                "{key}: {end} {value} is not in {comment:?}"
            );
            n_ends += 1;
            for (preset, _) in PRESETS {
                let mut recipe = Recipe::preset(preset).unwrap();
                let set = format!("{key}={value:?}").replace(
                    ".0",
                    if of_key["type"] == "integer" {
                        ""
                    } else {
                        ".0"
                    },
                );
                if let Err(error) = recipe.set(&set) {
                    let error = error.to_string();
                    let own = format!("{key} = ").replace("impact.", "impact.0.");
                    assert!(
                        !error.contains(&own) || error.contains("radius_mm"),
                        "{preset}: {error}"
                    );
                }
            }
        }
    }
    assert!(n_ends > 100, "{n_ends} ends of ranges");
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
            "\"physical\"",
            "\"short\"",
            "\"infinity\"",
            "\"auto\"",
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
            "camera.focus_distance_m", "camera.pixel_pitch_um", "camera.scene_distance_m", "camera.focal_length_mm",
            "camera.blades", "optics.model", "optics.sky_zenith", "optics.sun_irradiance", "optics.noise_shot",
            "output.maps", "impact.position", "impact.0.force", "impact.direction_deg", "fracture.model",
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
