//! `simulate`: the network file, the drawing and the growth frames.

use std::fs;
use std::path::Path;

use crate::program::{folder, json, names, raw_frames, raw_png, succeed, succeed_small};
use serde_json::Value;

const SIZE: [&str; 2] = ["--size", "160x100"];

fn simulate(dir: &Path, more: &[&str]) -> Value {
    succeed_small(
        dir,
        &[&["simulate", "-o", "n.json"], &SIZE[..], more].concat(),
    );
    json(&dir.join("n.json"))
}

fn floats(column: &Value) -> Vec<f64> {
    let values = column.as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap()).collect()
}

fn indices(column: &Value) -> Vec<Option<usize>> {
    let values = column.as_array().unwrap().iter();
    values
        .map(|value| value.as_u64().map(|idx| usize::try_from(idx).unwrap()))
        .collect()
}

#[test]
fn the_network_file_has_its_keys() {
    let dir = folder();
    let network = simulate(dir.path(), &["--seed", "3"]);
    assert_eq!(network["schema"], "starbreak.crack-network/1", "schema");
    assert_eq!(network["generator"]["name"], "starbreak", "generator");
    assert!(network["generator"]["version"].is_string(), "version");
    assert_eq!(network["model"], "paper", "model");
    assert_eq!(network["seed"], 3, "seed");
    assert_eq!(network["unit"], "px", "unit");
    assert_eq!(network["pane"]["width"], 160.0, "pane");
    assert_eq!(network["pane"]["height"], 100.0, "pane");
    assert_eq!(network["impacts"][0]["x"], 32.0, "impact");
    assert_eq!(network["impacts"][0]["y"], 40.0, "impact");
    assert!(
        network.get("timings_ms").is_none(),
        "times differ from run to run"
    );

    let nodes = network["nodes"].as_object().unwrap();
    assert_eq!(
        floats(&nodes["x"]).len(),
        floats(&nodes["y"]).len(),
        "nodes"
    );
    let segments = network["segments"].as_object().unwrap();
    for column in ["from", "to", "kind"] {
        assert!(segments.contains_key(column), "{column}");
    }
    let n_segments = segments["from"].as_array().unwrap().len();
    assert!(n_segments > 20, "{n_segments} segments");
    for (name, column) in segments {
        let length = column.as_array().map(Vec::len);
        assert_eq!(length, Some(n_segments), "column {name}");
        assert!(
            column[0] != Value::Null || name == "parent",
            "column {name}"
        );
    }
    let kinds = segments["kind"].as_array().unwrap();
    for kind in ["propagated", "mst"] {
        assert!(kinds.iter().any(|k| k == kind), "{kind} segments");
    }
    assert!(
        kinds.iter().all(|k| k == "propagated" || k == "mst"),
        "kinds"
    );
    assert_eq!(network["summary"]["n_segments"], n_segments, "summary");

    let ends = [&segments["from"], &segments["to"]].map(indices);
    let (x, y) = (floats(&nodes["x"]), floats(&nodes["y"]));
    let lengths = ends[0].iter().zip(&ends[1]).map(|(a, b)| {
        let (a, b) = (a.unwrap(), b.unwrap());
        (x[a] - x[b]).hypot(y[a] - y[b])
    });
    let total: f64 = lengths.sum();
    let stated = network["summary"]["total_length"].as_f64().unwrap();
    assert!((total - stated).abs() < 1e-6 * total, "{total} or {stated}");
    assert!(
        x.iter().all(|x| (0.0..=160.0).contains(x)),
        "inside the pane"
    );
    assert!(
        y.iter().all(|y| (0.0..=100.0).contains(y)),
        "inside the pane"
    );

    let timed = simulate(dir.path(), &["--seed", "3", "--timings"]);
    for stage in ["mesh", "propagation", "mst", "network", "total"] {
        assert!(timed["timings_ms"][stage].is_number(), "{stage}");
    }
    let mut untimed = timed;
    untimed.as_object_mut().unwrap().remove("timings_ms");
    assert_eq!(untimed, network, "the times are all that --timings adds");
}

type Point = (i128, i128);

/// Twice the signed area of a triangle.
fn turn(a: Point, b: Point, c: Point) -> i128 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// Whether two segments share a point that is not an end of both.
fn meet_without_a_node(one: [Point; 2], other: [Point; 2]) -> bool {
    let [a, b] = one;
    let [c, d] = other;
    let inside = |p: Point, [a, b]: [Point; 2]| {
        p != a
            && p != b
            && turn(a, b, p) == 0
            && (a.0.min(b.0)..=a.0.max(b.0)).contains(&p.0)
            && (a.1.min(b.1)..=a.1.max(b.1)).contains(&p.1)
    };
    let sides = |a, b, c, d| turn(a, b, c).signum() * turn(a, b, d).signum();
    let cross = sides(a, b, c, d) < 0 && sides(c, d, a, b) < 0;
    let twice = one == other || one == [d, c];
    let touch = inside(a, other) || inside(b, other) || inside(c, one) || inside(d, one);
    cross || twice || touch
}

/// The coordinate in units of 2^-n, where that is a whole number.
fn whole(value: f64, n_bits: i32) -> Option<i128> {
    let scaled = value * 2.0_f64.powi(n_bits);
    #[expect(clippy::cast_possible_truncation, reason = "below 2^60 and whole")]
    (scaled.fract() == 0.0).then_some(scaled as i128)
}

#[test]
fn the_meeting_test_knows_a_crossing_when_it_sees_one() {
    let meet = meet_without_a_node;
    assert!(meet([(0, 0), (2, 2)], [(0, 2), (2, 0)]), "a cross");
    assert!(meet([(0, 0), (4, 0)], [(2, 0), (2, 5)]), "a T");
    assert!(meet([(0, 0), (4, 0)], [(1, 0), (9, 0)]), "an overlap");
    assert!(
        meet([(0, 0), (4, 0)], [(4, 0), (0, 0)]),
        "the same, reversed"
    );
    assert!(!meet([(0, 0), (4, 0)], [(4, 0), (9, 1)]), "a common end");
    assert!(!meet([(0, 0), (4, 0)], [(4, 0), (9, 0)]), "end to end");
    assert!(!meet([(0, 0), (4, 0)], [(0, 1), (4, 1)]), "parallels");
}

#[test]
fn no_two_segments_cross_without_a_node() {
    let dir = folder();
    let two_hits = "schema = 1\nfracture.model = \"paper\"\n[[impact]]\nposition = [0.3, 0.4]\n[[impact]]\nposition = [0.7, 0.6]\n";
    fs::write(dir.path().join("two.toml"), two_hits).unwrap();
    for more in [
        &["--seed", "1"][..],
        &["--seed", "2", "--set", "fracture.branches=4"],
        &["--seed", "3", "--set", "fracture.snap_to_mesh=true"],
        &["--seed", "4", "--recipe", "two.toml"],
    ] {
        let network = if more.contains(&"two.toml") {
            // The hits of the recipe stay where they are.
            let small = &crate::program::SMALL_MESH;
            let args = ["simulate", "-o", "n.json"];
            succeed(dir.path(), &[&args, &SIZE[..], small, more].concat());
            json(&dir.path().join("n.json"))
        } else {
            simulate(dir.path(), more)
        };
        let coordinates = ["x", "y"].map(|axis| floats(&network["nodes"][axis]));
        // All coordinates are doubles below 2^8; with 2^52 they are whole, as 2^20 mostly is not.
        let n_bits = [20, 52]
            .into_iter()
            .find(|bits| {
                coordinates
                    .iter()
                    .flatten()
                    .all(|c| whole(*c, *bits).is_some())
            })
            .unwrap_or_else(|| panic!("{more:?}: a coordinate with more than 52 binary places"));
        let at = |node: &Option<usize>| {
            let [x, y] =
                [0, 1].map(|axis| whole(coordinates[axis][node.unwrap()], n_bits).unwrap());
            (x, y)
        };
        let ends = ["from", "to"].map(|column| indices(&network["segments"][column]));
        let segments: Vec<[Point; 2]> = ends[0]
            .iter()
            .zip(&ends[1])
            .map(|(a, b)| [at(a), at(b)])
            .collect();
        for (k, one) in segments.iter().enumerate() {
            assert_ne!(one[0], one[1], "{more:?}: segment {k} has no length");
            for (j, other) in segments.iter().enumerate().skip(k + 1) {
                assert!(
                    !meet_without_a_node(*one, *other),
                    "{more:?}: segments {k} and {j} meet without a node"
                );
            }
        }
    }
}

#[test]
fn no_segment_arrives_before_its_parent() {
    let dir = folder();
    for seed in ["1", "2", "3"] {
        let network = simulate(dir.path(), &["--seed", seed]);
        let segments = &network["segments"];
        let arrivals = floats(&segments["arrival_step"]);
        let [from, to, parents] = ["from", "to", "parent"].map(|name| indices(&segments[name]));
        let mut n_children = 0;
        for (k, parent) in parents.iter().enumerate() {
            let Some(parent) = *parent else { continue };
            n_children += 1;
            assert!(arrivals[parent] <= arrivals[k], "seed {seed}: segment {k}");
            assert_eq!(to[parent], from[k], "seed {seed}: {k} grows from {parent}");
        }
        assert!(n_children > 10, "seed {seed}: {n_children} children");
        assert!(parents.contains(&None), "something starts");
    }
}

fn n_lit(frame: &crate::program::RawPng) -> u64 {
    frame.data.iter().map(|level| u64::from(*level)).sum()
}

#[test]
fn growth_frames_grow_to_the_full_drawing() {
    let dir = folder();
    let frames = ["--frames", "7", "--frames-to"];
    simulate(dir.path(), &[&frames[..], &["f"]].concat());
    simulate(dir.path(), &[&frames[..], &["f.png"]].concat());
    simulate(dir.path(), &["--frames", "7"]);
    let beside = names(&dir.path().join("n-frames"));
    assert_eq!(
        beside.len(),
        8,
        "a folder beside the network by default, with its list"
    );
    let folder = dir.path().join("f");
    let expected: Vec<String> = (1..=7).map(|k| format!("frame_{k:05}.png")).collect();
    let listed = [&expected[..], &["written.json".to_owned()]].concat();
    assert_eq!(names(&folder), listed, "seven files and their list");
    let single: Vec<_> = expected
        .iter()
        .map(|name| raw_png(&folder.join(name)))
        .collect();

    // Later frames of an animated PNG are the rectangles that changed.
    let animated = raw_frames(&dir.path().join("f.png"));
    assert_eq!(animated.len(), 7, "frames of the animated PNG");
    assert_eq!(animated[0], single[0], "the first frame is whole");

    for (k, pair) in single.windows(2).enumerate() {
        assert_eq!(pair[0].size, (160, 100), "frame {k}");
        assert!(n_lit(&pair[0]) <= n_lit(&pair[1]), "frame {k} loses cracks");
        let shrunk = pair[0]
            .data
            .iter()
            .zip(&pair[1].data)
            .filter(|(a, b)| a > b);
        assert_eq!(shrunk.count(), 0, "frame {k} has pixels that go out again");
    }
    assert!(n_lit(&single[0]) * 2 < n_lit(&single[6]), "it does grow");

    let network = fs::read_to_string(dir.path().join("n.json")).unwrap();
    let network = starbreak::glass::CrackNetwork::from_json(&network).unwrap();
    let view = starbreak::optics::View::stretched(&network.data().pane, (160, 100));
    let full = starbreak::growth_drawing(&network, &view, f64::INFINITY, 1.0);
    assert!(
        single[6].data == full.into_raw(),
        "the last frame is not all"
    );
    simulate(dir.path(), &["--frames", "1", "--frames-to", "one"]);
    let one = raw_png(&dir.path().join("one/frame_00001.png"));
    assert!(one == single[6], "a single frame is the last one");
}
