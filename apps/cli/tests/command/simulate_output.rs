//! `simulate`: where its results go, and what an unbroken pane looks like.

use std::fs;

use crate::program::{SMALL_MESH, folder, json, names, raw_frames, succeed, succeed_small};
use serde_json::Value;

/// Every element is closed in order, attributes are quoted, and there is one root.
fn check_xml(text: &str) {
    let mut open = Vec::new();
    let mut n_roots = 0;
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let outside = &rest[..start];
        assert!(
            !outside.contains('>') && !outside.contains('&'),
            "{outside:?}"
        );
        assert!(!open.is_empty() || outside.trim().is_empty(), "{outside:?}");
        let length = rest[start..].find('>').unwrap();
        let tag = &rest[start + 1..start + length];
        rest = &rest[start + length + 1..];
        if tag.starts_with(['?', '!']) {
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes in <{tag}>");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "</{name}> closes another element");
            continue;
        }
        let name = tag.split([' ', '/', '\n']).next().unwrap();
        n_roots += usize::from(open.is_empty());
        if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?} are not closed");
    assert!(rest.trim().is_empty(), "after the root: {rest:?}");
    assert_eq!(n_roots, 1, "one root");
}

#[test]
fn the_drawing_is_svg_of_the_frame() {
    let dir = folder();
    for (seed, more) in [("1", &[][..]), ("2", &["--set", "impact.force=1"])] {
        let args = [
            "simulate",
            "--svg",
            "n.svg",
            "--size",
            "160x100",
            "--replace",
            "--seed",
            seed,
        ];
        succeed_small(dir.path(), &[&args[..], more].concat());
        let svg = fs::read_to_string(dir.path().join("n.svg")).unwrap();
        check_xml(&svg);
        assert!(svg.starts_with("<svg "), "{svg:.80}");
        assert!(svg.contains(r#"viewBox="0 0 160 100""#), "{svg:.200}");
        assert!(!svg.contains("NaN") && !svg.contains("inf "), "numbers");
    }
}

#[test]
fn the_title_of_the_drawing_names_the_unit_as_the_network_does() {
    let dir = folder();
    succeed_small(
        dir.path(),
        &["simulate", "--svg", "n.svg", "--size", "160x100"],
    );
    let svg = fs::read_to_string(dir.path().join("n.svg")).unwrap();
    let title = svg
        .lines()
        .find(|line| line.starts_with("<title>"))
        .unwrap();
    assert!(title.ends_with(" px</title>"), "{title}");
}

#[test]
fn the_network_goes_to_standard_output_without_a_file() {
    let dir = folder();
    let to_stdout = succeed_small(dir.path(), &["simulate", "--size", "160x100"]);
    let network: Value = serde_json::from_str(&to_stdout.stdout).unwrap();
    assert_eq!(network["schema"], "starbreak.crack-network/1", "schema");
    assert!(
        to_stdout.stderr.contains("segments"),
        "{}",
        to_stdout.stderr
    );
    assert!(names(dir.path()).is_empty(), "no file");

    let args = ["simulate", "--size", "160x100", "-o", "deep/er/n.json"];
    succeed_small(dir.path(), &args);
    let file = fs::read_to_string(dir.path().join("deep/er/n.json")).unwrap();
    assert!(file == to_stdout.stdout, "the same network");
}

#[test]
fn several_impacts_break_in_several_places() {
    let dir = folder();
    let recipe = "schema = 1\nfracture.model = \"paper\"\n\
        [[impact]]\nposition = [0.25, 0.5]\nforce = 500\n\
        [[impact]]\nposition = [0.75, 0.5]\nforce = 450.5\ndirection_deg = 90\n\
        [[impact]]\nposition = [0.5, 0.1]\nforce = 2\n";
    fs::write(dir.path().join("r.toml"), recipe).unwrap();
    let args = [
        "simulate", "-o", "n.json", "--size", "160x100", "--recipe", "r.toml",
    ];
    succeed(dir.path(), &[&args[..], &SMALL_MESH].concat());
    let network = json(&dir.path().join("n.json"));
    let impacts = network["impacts"].as_array().unwrap();
    assert_eq!(impacts.len(), 3, "{impacts:?}");
    assert_eq!(impacts[1]["force"], 450.5, "{impacts:?}");
    assert_eq!(impacts[1]["direction_deg"], 90.0, "{impacts:?}");
    let has_node = |x: f64, y: f64| {
        let axis = |axis: &str| network["nodes"][axis].as_array().unwrap().clone();
        axis("x")
            .iter()
            .zip(&axis("y"))
            .any(|(a, b)| *a == x && *b == y)
    };
    assert!(has_node(40.0, 50.0), "cracks start at the first impact");
    assert!(has_node(120.0, 50.0), "cracks start at the second impact");
    assert!(!has_node(80.0, 10.0), "the third is too weak");

    // One key in every impact, then in one.
    let sets = ["--set", "impact.force=400", "--set", "impact.2.force=600"];
    succeed(dir.path(), &[&args[..], &SMALL_MESH, &sets].concat());
    let network = json(&dir.path().join("n.json"));
    let forces = [0, 1, 2].map(|k| network["impacts"][k]["force"].as_f64().unwrap());
    assert_eq!(
        forces.map(f64::to_bits),
        [400.0, 400.0, 600.0].map(f64::to_bits),
        "forces"
    );
}

#[test]
fn an_unbroken_pane_is_an_empty_network_and_no_failure() {
    let dir = folder();
    for (k, sets) in [
        ["impact.force=300", "fracture.safety_factor=1"],
        ["impact.force=299.9", "fracture.safety_factor=1"],
        ["impact.force=500", "fracture.critical_stress=500"],
        ["impact.force=149", "fracture.safety_factor=2"],
    ]
    .iter()
    .enumerate()
    {
        let frames = ["--frames", "3", "--frames-to", "f.png"];
        let args = [
            "simulate", "-o", "n.json", "--svg", "n.svg", "--size", "160x100", "--preset", "paper",
        ];
        let sets = ["--set", sets[0], "--set", sets[1]];
        let outcome = succeed(dir.path(), &[&args[..], &frames, &sets].concat());
        for key in [
            "impact.force",
            "fracture.critical_stress",
            "fracture.safety_factor",
        ] {
            assert!(outcome.stdout.contains(key), "case {k}: {outcome:?}");
        }
        let network = json(&dir.path().join("n.json"));
        assert_eq!(network["summary"]["n_segments"], 0, "case {k}");
        assert_eq!(
            network["segments"]["from"],
            serde_json::json!([]),
            "case {k}"
        );
        let frames = raw_frames(&dir.path().join("f.png"));
        assert_eq!(frames.len(), 3, "case {k}: frames of an unbroken pane");
        let dark = frames
            .iter()
            .all(|frame| frame.data.iter().all(|level| *level == 0));
        assert!(dark, "case {k}: something is drawn");
    }
    // Half the stress is enough with a safety factor of two.
    let half = [
        "--set",
        "impact.force=250",
        "--set",
        "fracture.safety_factor=2",
    ];
    let args = ["simulate", "-o", "n.json", "--size", "160x100"];
    let outcome = succeed_small(dir.path(), &[&args[..], &half].concat());
    assert!(!outcome.stdout.contains("nothing broke"), "{outcome:?}");
}
