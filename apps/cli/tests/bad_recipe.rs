//! Recipes and overrides that are wrong: one line that names the key, code 2, nothing
//! left behind.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeSet;
use std::fs;

use common::{all_refused, folder, snapshot, starbreak, succeed};
use serde_json::Value;

/// Every numeric key, with values that it must refuse. Angles may be negative.
const NUMERIC: [(&str, &[&str]); 15] = [
    ("impact.force", &["-1", "0", "nan", "inf", "-inf"]),
    ("impact.direction_deg", &["nan", "inf", "-inf"]),
    (
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
        "fracture.particles",
        &["-1", "0", "nan", "inf", "1.5", "10000001", "99999999999"],
    ),
    ("fracture.neighbour_radius_px", &["-1", "0", "nan", "inf"]),
    ("fracture.critical_stress", &["-1", "0", "nan", "inf"]),
    ("fracture.safety_factor", &["-1", "0", "nan", "inf"]),
    ("fracture.branches", &["-1", "0", "nan", "inf", "65"]),
    ("optics.sun_azimuth_deg", &["nan", "inf", "-inf"]),
    ("optics.sun_elevation_deg", &["nan", "inf", "-inf"]),
    (
        "optics.light_intensity",
        &["[-1,0,0]", "[256,0,0]", "[nan,0,0]", "[0,0,inf]", "[1,2]"],
    ),
    ("optics.line_width_px", &["-1", "0", "nan", "inf", "65"]),
    (
        "optics.blur_kernel_px",
        &["-1", "0", "nan", "inf", "2", "257"],
    ),
    ("optics.blur_sigma_px", &["-1", "0", "nan", "inf", "129"]),
    ("output.quality", &["-1", "0", "nan", "inf", "101", "256"]),
];

/// How a message names the key: that of an impact with its number.
fn named(key: &str) -> String {
    key.replace("impact.", "impact.0.")
}

#[test]
fn wrong_numbers_are_refused_as_overrides() {
    let dir = folder();
    let mut complaints = Vec::new();
    for (key, values) in NUMERIC {
        for value in values {
            let set = format!("{key}={value}");
            let outcome = starbreak(dir.path(), &["simulate", "-o", "out/n", "--set", &set]);
            complaints.extend(outcome.complaint(&format!("--set {set}: {}", named(key))));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(snapshot(dir.path()).is_empty(), "something was left behind");
}

#[test]
fn wrong_numbers_are_refused_in_a_recipe() {
    let dir = folder();
    let mut complaints = Vec::new();
    for (key, values) in NUMERIC {
        let (table, key_in_table) = key.split_once('.').unwrap();
        let header = if table == "impact" {
            "[[impact]]".to_owned()
        } else {
            format!("[{table}]")
        };
        for value in values {
            let text = format!("schema = 1\n{header}\n{key_in_table} = {value}\n");
            fs::write(dir.path().join("r.toml"), text).unwrap();
            let args = ["simulate", "-o", "out/n", "--recipe", "r.toml"];
            let outcome = starbreak(dir.path(), &args);
            complaints.extend(outcome.complaint(&format!("r.toml: {}", named(key))));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert_eq!(common::names(dir.path()), ["r.toml"], "nothing left behind");
}

/// A key that is added to the recipe must be added to [`NUMERIC`].
#[test]
fn every_numeric_key_was_tried() {
    let dir = folder();
    let schema: Value =
        serde_json::from_str(&succeed(dir.path(), &["recipe", "--schema"]).stdout).unwrap();
    let recipe = succeed(dir.path(), &["recipe"]).stdout;
    let mut numeric = BTreeSet::new();
    for (table, property) in schema["properties"].as_object().unwrap() {
        let reference = property["items"]["$ref"]
            .as_str()
            .or(property["$ref"].as_str());
        let Some(name) = reference.and_then(|path| path.strip_prefix("#/$defs/")) else {
            continue;
        };
        for (key, property) in schema["$defs"][name]["properties"].as_object().unwrap() {
            assert!(recipe.contains(&format!("\n{key} = ")), "{key} is printed");
            let definition = match property["$ref"].as_str() {
                Some(path) => &schema["$defs"][path.strip_prefix("#/$defs/").unwrap()],
                None => property,
            };
            let text = definition.to_string();
            if text.contains("\"number\"") || text.contains("\"integer\"") {
                numeric.insert(format!("{table}.{key}"));
            }
        }
    }
    let tried = NUMERIC.iter().map(|(key, _)| (*key).to_owned()).collect();
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
fn wrong_overrides_are_refused() {
    let dir = folder();
    let set = |assignment, named| (vec!["simulate", "-o", "out/n", "--set", assignment], named);
    all_refused(
        dir.path(),
        &[
            set("fracture.particles", "--set fracture.particles"),
            set("", "--set"),
            set("=", "--set ="),
            set("fracture=5", "fracture"),
            set("a.b.c.d=5", "a.b.c.d"),
            set("impact.7.force=1", "impact `7`"),
            set("impact.-1.force=1", "impact `-1`"),
            set("impact.0.farce=1", "did you mean `impact.0.force`?"),
            set("fracture.partikles=1", "did you mean `fracture.particles`?"),
            set("fractures.particles=1", "did you mean `fracture`?"),
            set("zebra.particles=1", "known tables: "),
            set("fracture.zzzzzz=1", "known keys: "),
            set("fracture.rule=anything", "fracture.rule"),
            set("fracture.particles=many", "fracture.particles"),
            set("output.masks=1", "output.masks"),
            set("camera.focus_distance_m=7", "camera.focus_distance_m"),
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
            set(r#"fracture.rule="a\u001b[31m""#, "fracture.rule"),
            set("fracture.rule=a\nb", "fracture.rule"),
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
            preset("zebra", "`zebra`; known presets: paper"),
            preset("", "``"),
        ],
    );
}
