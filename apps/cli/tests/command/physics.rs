//! The physics at the command line: the default of every verb, its figures, its files.

use std::fs;
use std::path::Path;

use crate::program::{folder, json, names, raw_frames, raw_png, starbreak, succeed, write_photo};
use serde_json::Value;
use starbreak::optics::srgb::decode8;

/// A stone that surely breaks the windscreen, on the coarse mesh.
const HARD: [&str; 10] = [
    "--preset",
    "windshield-star",
    "--set",
    "fracture.mesh=fast",
    "--set",
    "impact.speed_m_s=40",
    "--set",
    "impact.radius_mm=5",
    "--set",
    "impact.position=[0.4,0.5]",
];

/// The result line of `simulate`, which must succeed.
fn simulated(dir: &Path, more: &[&str]) -> Value {
    let args = [&["simulate", "--json", "-q", "-o", "n.json"], more].concat();
    serde_json::from_str(&succeed(dir, &args).stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn simulate_says_class_and_key_figures() {
    let dir = folder();
    let args = [&["simulate", "-o", "n.json"], &HARD[..]].concat();
    let said = succeed(dir.path(), &args).stdout;
    let result = simulated(dir.path(), &HARD);
    let hit = &result["hits"][0];
    let class = hit["damage_class"].as_str().unwrap();
    for words in [
        format!("{class}: "),
        format!("peak force {:.0} N", number(&hit["peak_force_n"])),
        format!("{} arms", hit["n_arms"]),
        format!("reach {:.1} mm", number(&hit["reach_mm"])),
        "fragment(s)".to_owned(),
        "went into cracks".to_owned(),
    ] {
        assert!(said.contains(&words), "{words:?} is not in {said:?}");
    }
}

#[test]
fn the_result_has_hits_and_energies() {
    let dir = folder();
    let result = simulated(dir.path(), &HARD);
    let hits = result["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 1, "{result}");
    for key in [
        "time_us",
        "kinetic_energy_j",
        "peak_force_n",
        "contact_time_us",
        "contact_radius_mm",
        "crushed_radius_mm",
        "n_arms",
        "reach_mm",
        "available_j",
        "dissipated_j",
    ] {
        assert!(
            hits[0][key].as_f64().is_some_and(|v| v >= 0.0),
            "{key}: {result}"
        );
    }
    assert!(number(&hits[0]["n_arms"]) >= 3.0, "a hard hit: {result}");
    // ½mV² of a granite ball: 4/3 π (5 mm)³ 2650 kg/m³ at 40 m/s.
    let kinetic_j = 0.5 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3) * 2650.0 * 1600.0;
    let said_j = number(&hits[0]["kinetic_energy_j"]);
    assert!((said_j / kinetic_j - 1.0).abs() < 1e-9, "{said_j} J");
    let summary = &result["summary"];
    let (available, dissipated) = (
        number(&summary["available_j"]),
        number(&summary["dissipated_j"]),
    );
    assert!(
        0.0 < dissipated && dissipated <= available && available <= kinetic_j,
        "{dissipated} of {available} of {kinetic_j} J"
    );
    for key in ["n_segments", "total_length", "longest_crack", "n_fragments"] {
        assert!(summary[key].is_number(), "{key}: {result}");
    }
    for key in ["n_mesh_nodes", "n_solutions"] {
        assert!(number(&result["plate"][key]) >= 1.0, "{key}: {result}");
    }
    let network = json(&dir.path().join("n.json"));
    assert_eq!(network["model"], "physics", "model");
    assert_eq!(network["unit"], "mm", "unit");
    assert_eq!(network["pane"]["kind"], "laminated", "pane");
    assert_eq!(
        network["impacts"][0]["damage_class"], hits[0]["damage_class"],
        "the file has the class, too"
    );
    for column in ["stress_mpa", "arrival_us", "opening_um"] {
        assert!(network["segments"][column].is_array(), "{column}");
    }
}

#[test]
fn the_physics_is_the_default() {
    let dir = folder();
    let file = |name: &str, more: &[&str]| {
        succeed(
            dir.path(),
            &[&["simulate", "-q", "-o", name, "--seed", "4"], more].concat(),
        );
        fs::read(dir.path().join(name)).unwrap()
    };
    let without = file("a.json", &[]);
    assert!(
        without == file("b.json", &["--preset", "windshield-spiderweb"]),
        "without flags it is windshield-spiderweb"
    );
    assert!(
        without == file("c.json", &["--severity", "3"]),
        "severity 3 is the preset itself"
    );
    assert!(
        without != file("d.json", &["--preset", "paper"]),
        "the paper's model has to be asked for"
    );
}

#[test]
fn severity_changes_what_the_preset_says_it_does() {
    let dir = folder();
    let length_mm = |severity: &str| {
        let more = ["--severity", severity, "--set", "fracture.mesh=fast"];
        number(&simulated(dir.path(), &more)["summary"]["total_length"])
    };
    let lengths = ["1", "2", "3", "4", "5"].map(length_mm);
    assert!(
        lengths.windows(2).all(|pair| pair[0] < pair[1]),
        "{lengths:?}"
    );
    let dice = |severity: &str| {
        let more = ["--preset", "tempered-cover", "--severity", severity];
        number(&simulated(dir.path(), &more)["summary"]["n_fragments"])
    };
    assert!(dice("5") > 1.5 * dice("1"), "more temper, more dice");
    let refused = starbreak(dir.path(), &["simulate", "--severity", "6"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
}

#[test]
fn crack_writes_four_files_with_the_hits_in_the_record() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let args = [&["crack", "a.png", "-o", "out", "--seed", "2"], &HARD[..]].concat();
    succeed(dir.path(), &args);
    let out = dir.path().join("out");
    assert_eq!(
        names(&out),
        ["a.crack.png", "a.json", "a.png", "a.region.png"],
        "files"
    );
    let record = json(&out.join("a.json"));
    let network = &record["network"];
    assert_eq!(network["model"], "physics", "{record}");
    let hit = &network["hits"][0];
    assert!(hit["damage_class"].is_string(), "{record}");
    assert!(number(&hit["peak_force_n"]) > 0.0, "{record}");
    assert!(
        record["recipe"]
            .as_str()
            .unwrap()
            .contains("speed_m_s = 40"),
        "{record}"
    );
    // Outside the region hardly anything differs; inside, something does.
    let (before, after) = (
        raw_png(&dir.path().join("a.png")),
        raw_png(&out.join("a.png")),
    );
    let region = raw_png(&out.join("a.region.png"));
    assert_eq!(before.size, after.size, "size");
    let pixels = || before.pixels().zip(after.pixels()).zip(&region.data);
    for ((a, b), _) in pixels().filter(|(_, region)| **region == 0) {
        for (a, b) in a.iter().zip(b).map(|(a, b)| (decode8(*a), decode8(*b))) {
            // Less than optics.region_threshold of its light taken and of white added, and half a
            // code of rounding.
            let most = 0.01 * a + 0.01 + 0.005;
            assert!((a - b).abs() <= most, "{a} to {b} outside the region");
        }
    }
    let inside = pixels().filter(|((a, b), region)| **region == 255 && a != b);
    assert!(inside.count() > 20, "hardly a crack");
    // Made again from its record.
    fs::write(
        dir.path().join("again.toml"),
        record["recipe"].as_str().unwrap(),
    )
    .unwrap();
    let again = [
        "crack",
        "a.png",
        "-o",
        "again",
        "--seed",
        "2",
        "--recipe",
        "again.toml",
    ];
    succeed(dir.path(), &again);
    assert!(
        fs::read(out.join("a.png")).unwrap() == fs::read(dir.path().join("again/a.png")).unwrap(),
        "the record makes the same image"
    );
}

#[test]
fn growth_frames_only_ever_grow() {
    let dir = folder();
    let args = [
        &[
            "simulate", "-q", "-o", "n.json", "--frames", "6", "--size", "320x200",
        ],
        &HARD[..],
    ]
    .concat();
    succeed(dir.path(), &args);
    let frames: Vec<Vec<u8>> = (1..=6)
        .map(|k| raw_png(&dir.path().join(format!("n-frames/frame_{k:05}.png"))).data)
        .collect();
    for (k, pair) in frames.windows(2).enumerate() {
        let shrinks = pair[0].iter().zip(&pair[1]).any(|(a, b)| a > b);
        assert!(!shrinks, "frame {} loses a crack", k + 2);
    }
    let ink = |frame: &[u8]| frame.iter().map(|&level| u64::from(level)).sum::<u64>();
    assert!(
        ink(&frames[5]) > ink(&frames[2]) && ink(&frames[2]) > ink(&frames[0]),
        "it grows: {:?}",
        frames.iter().map(|frame| ink(frame)).collect::<Vec<_>>()
    );
    let animated = [&args[..], &["--frames-to", "g.png"]].concat();
    succeed(dir.path(), &animated);
    assert_eq!(raw_frames(&dir.path().join("g.png")).len(), 6, "animation");
}

#[test]
fn an_impact_beside_the_glass_is_refused_with_a_way_out() {
    let dir = folder();
    // The disc of a lens cover does not fill the corners of the frame.
    let beside = [
        "simulate",
        "-o",
        "n.json",
        "--preset",
        "lens-cover-star",
        "--set",
        "glass.distance_m=0.2",
        "--set",
        "impact.position=[0.01,0.02]",
    ];
    crate::program::all_refused(
        dir.path(),
        &[(beside.to_vec(), "move the impact or the pane")],
    );
}

#[test]
fn nothing_broken_is_said_and_is_no_error() {
    let dir = folder();
    let slow = ["--set", "impact.speed_m_s=0.1"];
    let said = succeed(
        dir.path(),
        &[&["simulate", "-o", "n.json"], &slow[..]].concat(),
    );
    assert!(
        said.stdout.contains("nothing broke") && said.stdout.contains("--severity"),
        "{said:?}"
    );
    let result = simulated(dir.path(), &slow);
    assert_eq!(result["intact"], true, "{result}");
    assert_eq!(result["hits"][0]["damage_class"], "intact", "{result}");
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let dir = folder();
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&dir.path().join(name));
    }
    let crack = |out: &str, threads: &str| {
        let args = [
            "crack",
            "a.png",
            "b.png",
            "c.png",
            "-q",
            "-o",
            out,
            "--threads",
            threads,
        ];
        succeed(dir.path(), &[&args[..], &HARD[..6]].concat());
        let out = dir.path().join(out);
        let mut files = Vec::new();
        for name in names(&out) {
            let mut bytes = fs::read(out.join(&name)).unwrap();
            if name.ends_with("json") {
                let mut record = json(&out.join(&name));
                record.as_object_mut().unwrap().remove("timings_ms");
                bytes = record.to_string().into_bytes();
            }
            files.push((name, bytes));
        }
        files
    };
    let one = crack("one", "1");
    assert_eq!(one.len(), 12, "files of three images");
    assert!(one == crack("two", "2"), "two threads differ from one");
    let masks: Vec<_> = one
        .iter()
        .filter(|(name, _)| name.ends_with("crack.png"))
        .collect();
    assert!(masks[0].1 != masks[1].1, "each image has its own crack");
}

#[test]
fn the_demo_breaks_a_windscreen() {
    let dir = folder();
    let args = [&["demo", "-o", "d", "--json"], &HARD[..]].concat();
    let result: Value = serde_json::from_str(&succeed(dir.path(), &args).stdout).unwrap();
    let out = dir.path().join("d");
    let network = json(&out.join("network.json"));
    assert_eq!(network["model"], "physics", "model");
    assert_eq!(network["unit"], "mm", "unit");
    assert_eq!(
        result["images"].as_array().map(Vec::len),
        Some(2),
        "{result}"
    );
    for focus in ["far", "short"] {
        let mask = raw_png(&out.join(format!("{focus}-focus.crack.png")));
        assert!(
            mask.data.iter().any(|&level| level > 0),
            "{focus}: no crack"
        );
    }
    // Focus is no part of breaking. Short segments are joined to lines as far as the blur hides it,
    // so that edges of the masks differ a little.
    let [far, short] =
        ["far", "short"].map(|focus| raw_png(&out.join(format!("{focus}-focus.crack.png"))).data);
    let sum = |levels: &mut dyn Iterator<Item = u8>| levels.map(u64::from).sum::<u64>();
    let off = sum(&mut far.iter().zip(&short).map(|(a, b)| a.abs_diff(*b)));
    let all = sum(&mut short.iter().copied());
    assert!(off * 50 <= all, "masks differ by {off} of {all}");
    assert!(raw_frames(&out.join("growth.png")).len() > 1, "growth");
    assert!(
        fs::read_to_string(out.join("network.svg"))
            .unwrap()
            .contains("class=\"radial\""),
        "drawing"
    );
}

#[test]
fn glass_on_which_nothing_is_seen_says_why() {
    let dir = folder();
    write_photo(&dir.path().join("scene.png"));
    for (preset, set) in [
        ("frosted", "optics.dashboard_rows=[0]"),
        ("fogged", "condensation.clears_from_s=21"),
        ("rain", "drops.age_s=0"),
    ] {
        let args = [
            "crack",
            "scene.png",
            "--preset",
            preset,
            "--set",
            set,
            "--replace",
            "-o",
            "out",
        ];
        let said = starbreak(dir.path(), &args);
        assert_eq!(said.code, Some(0), "{}", said.stderr);
        let named = [
            "nothing is seen on the glass",
            "gone",
            "optics.dashboard_rows",
        ];
        for named in named {
            assert!(said.stdout.contains(named), "{preset}: {}", said.stdout);
        }
    }
}
