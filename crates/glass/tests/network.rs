//! What a crack network promises: each promise broken once, and the file round trip.
#![expect(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test may panic; its numbers are exact"
)]

use proptest::prelude::*;
use starbreak_glass::{
    CrackNetwork, Face, Generator, GlassKind, Impact, LengthUnit, Model, NETWORK_SCHEMA,
    NetworkData, NetworkError, Nodes, Pane, SegmentKind, Segments, Summary, Zone, find_contacts,
    find_contacts_of, find_contacts_up_to,
};
use starbreak_seed::Seed;

/// A star of three arms, the last in two pieces.
fn star() -> NetworkData {
    NetworkData {
        schema: NETWORK_SCHEMA.to_owned(),
        generator: Generator {
            name: "test".to_owned(),
            version: "1".to_owned(),
        },
        model: Model::Paper,
        seed: Some(Seed(7)),
        unit: LengthUnit::Px,
        pane: Pane::from_frame_px(100, 50),
        damage_class: None,
        impacts: vec![Impact {
            x: 50.0,
            y: 25.0,
            force: Some(500.0),
            direction_deg: Some(30.0),
            ..Impact::default()
        }],
        nodes: Nodes {
            x: vec![50.0, 90.0, 10.0, 50.0, 50.5],
            y: vec![25.0, 30.0, 20.0, 5.0, 1.25],
        },
        segments: Segments {
            from: vec![0, 0, 0, 3],
            to: vec![1, 2, 3, 4],
            kind: vec![
                SegmentKind::Propagated,
                SegmentKind::Mst,
                SegmentKind::Propagated,
                SegmentKind::Propagated,
            ],
            parent: Some(vec![None, None, None, Some(2)]),
            arrival_step: Some(vec![1.0, 1.0, 1.0, 2.0]),
            ..Segments::default()
        },
        fallen: Vec::new(),
        summary: None,
    }
}

/// The error that a change to the star leads to.
fn refusal(change: impl FnOnce(&mut NetworkData)) -> NetworkError {
    let mut data = star();
    change(&mut data);
    CrackNetwork::new(data).unwrap_err()
}

#[test]
fn a_sound_network_is_accepted_and_summed_up() {
    let network = CrackNetwork::new(star()).unwrap();
    let summary = network.summary();
    assert_eq!(
        (summary.n_segments, summary.n_radial),
        (4, 2),
        "two propagated segments leave the impact"
    );
    let expected = 40.0_f64.hypot(5.0) + 40.0_f64.hypot(5.0) + 20.0 + 0.5_f64.hypot(3.75);
    assert!(
        (summary.total_length - expected).abs() < 1e-12,
        "{summary:?}"
    );
}

#[test]
fn each_broken_promise_is_named() {
    let cases: Vec<(NetworkError, &str)> = vec![
        (
            refusal(|d| d.schema = "starbreak.crack-network/9".to_owned()),
            "schema",
        ),
        (refusal(|d| d.pane.width = -1.0), "pane width = -1"),
        (refusal(|d| d.nodes.y.truncate(2)), "nodes.y"),
        (refusal(|d| d.segments.kind.truncate(1)), "segments.kind"),
        (
            refusal(|d| d.segments.arrival_step = Some(vec![1.0])),
            "segments.arrival_step",
        ),
        (refusal(|d| d.nodes.x[1] = f64::NAN), "nodes.x[1] = NaN"),
        (
            refusal(|d| d.segments.arrival_step = Some(vec![-1.0; 4])),
            "segments.arrival_step[0] = -1",
        ),
        (
            refusal(|d| d.segments.depth_fraction = Some(vec![0.5, 1.5, 0.0, 0.0])),
            "segments.depth_fraction[1]",
        ),
        (refusal(|d| d.nodes.x[1] = 101.0), "node 1 at (101, 30)"),
        (refusal(|d| d.impacts[0].y = 51.0), "impact 0"),
        (refusal(|d| d.segments.to[1] = 5), "segments.to[1] = 5"),
        (refusal(|d| d.segments.to[1] = 0), "segment 1 has no length"),
        (
            refusal(|d| (d.nodes.x[4], d.nodes.y[4]) = (50.0, 5.0)),
            "segment 3 has no length",
        ),
        (refusal(|d| d.segments.to[1] = 1), "segments 0 and 1 join"),
        (
            refusal(|d| d.segments.parent = Some(vec![None, None, None, Some(1)])),
            "segment 3 cannot grow",
        ),
        (
            refusal(|d| d.segments.parent = Some(vec![Some(9), None, None, None])),
            "parent[0] = 9",
        ),
        (
            refusal(|d| d.segments.arrival_step = Some(vec![1.0, 1.0, 3.0, 2.0])),
            "before its parent",
        ),
    ];
    for (error, expected) in cases {
        let message = error.to_string();
        assert!(
            message.contains(expected),
            "{message:?} does not name {expected:?}"
        );
        assert!(!message.contains('\n'), "one line: {message:?}");
    }
}

/// A radial from the impact in two pieces that forks, and a crack from the rim, with every
/// column that the physics has.
fn physics() -> NetworkData {
    NetworkData {
        model: Model::Physics,
        unit: LengthUnit::Mm,
        pane: Pane {
            kind: Some(GlassKind::Laminated),
            thickness_mm: Some(2.1),
            ..star().pane
        },
        impacts: vec![Impact {
            x: 50.0,
            y: 25.0,
            speed_m_s: Some(25.0),
            radius_mm: Some(3.0),
            tip_radius_mm: Some(1.0),
            angle_deg: Some(30.0),
            azimuth_deg: Some(-90.0),
            mass_g: Some(0.3),
            energy_j: Some(0.09),
            peak_force_n: Some(900.0),
            contact_time_us: Some(20.0),
            contact_radius_mm: Some(0.4),
            crushed_radius_mm: Some(0.5),
            damage_class: Some("star".to_owned()),
            ..Impact::default()
        }],
        nodes: Nodes {
            x: vec![50.0, 60.0, 63.0, 60.0, 100.0, 90.0],
            y: vec![25.0, 25.0, 29.0, 20.0, 10.0, 10.0],
        },
        segments: Segments {
            from: vec![0, 1, 1, 4],
            to: vec![1, 2, 3, 5],
            kind: vec![
                SegmentKind::Radial,
                SegmentKind::Fork,
                SegmentKind::Fork,
                SegmentKind::Edge,
            ],
            parent: Some(vec![None, Some(0), Some(0), None]),
            arrival_us: Some(vec![10.0, 14.0, 20.0, 70.0]),
            departure_us: Some(vec![2.0, 10.0, 16.0, 50.0]),
            stress_mpa: Some(vec![60.0, 50.0, -1.0, 30.0]),
            opening_um: Some(vec![4.0, 2.0, 2.0, 1.0]),
            depth_fraction: Some(vec![1.0, 0.5, 0.5, 1.0]),
            depth_ends: Some(vec![[1.0, 1.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
            face: Some(vec![Face::Inner, Face::Inner, Face::Inner, Face::Outer]),
            zone: Some(vec![Zone::Hackle, Zone::Mist, Zone::Mist, Zone::Mirror]),
            roughness_um: Some(vec![3.0, 0.5, 0.5, 0.01]),
            tilt_deg: Some(vec![0.0, -12.5, 30.0, 89.0]),
            tilt_ends_deg: Some(vec![[-2.0, 2.0], [-15.0, -10.0], [20.0, 40.0], [89.0; 2]]),
            ply: Some(vec![0, 0, 0, 1]),
            k_ratio: Some(vec![2.0, 1.25, 1.25, 0.75]),
            ..Segments::default()
        },
        fallen: vec![[99.0, 1.0]],
        summary: Some(Summary {
            n_segments: 77,
            dissipated_j: Some(0.01),
            available_j: Some(0.02),
            ..Summary::default()
        }),
        ..star()
    }
}

#[test]
fn the_columns_of_the_physics_survive_the_file() {
    let network = CrackNetwork::new(physics()).unwrap();
    let text = network.to_json();
    let again = CrackNetwork::from_json(&text).unwrap();
    assert_eq!(again, network, "read again");
    assert_eq!(again.to_json(), text, "written again");
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["segments"]["zone"][0], "hackle", "zones are words");
    assert_eq!(value["segments"]["face"][0], "inner", "and faces");
    assert_eq!(value["impacts"][0]["damage_class"], "star");
    let summary = network.summary();
    assert_eq!(summary.n_segments, 4, "counted, not taken from the data");
    assert_eq!(summary.longest_crack, Some(15.0), "10 and the arm of 5");
    assert_eq!(summary.n_fragments, Some(1), "nothing came off");
    assert_eq!(
        (summary.dissipated_j, summary.available_j),
        (Some(0.01), Some(0.02)),
        "energies are kept"
    );
    assert_eq!(value["summary"]["available_j"], 0.02);
}

#[test]
fn the_files_of_the_paper_stay_as_they_were() {
    let text = CrackNetwork::new(star()).unwrap().to_json();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let keys: Vec<_> = value["summary"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["n_radial", "n_segments", "total_length"]);
    let keys: Vec<_> = value["impacts"][0].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["x", "y", "force", "direction_deg"]);
}

#[test]
fn each_broken_promise_of_the_physics_is_named() {
    type Change = fn(&mut NetworkData);
    let cases: [(Change, &str); 21] = [
        (|d| d.segments.zone = Some(vec![]), "segments.zone"),
        (
            |d| d.segments.face = Some(vec![Face::Outer]),
            "segments.face",
        ),
        (
            |d| d.segments.depth_ends = Some(vec![[1.0, 0.5], [0.5, 1.01], [0.5; 2], [0.5; 2]]),
            "segments.depth_ends[1] = 1.01",
        ),
        (
            |d| d.segments.tilt_ends_deg = Some(vec![[90.0, 0.0]; 4]),
            "segments.tilt_ends_deg[0] = 90",
        ),
        (|d| d.fallen[0][1] = -1.0, "fallen 0 at (99, -1)"),
        (|d| d.segments.ply = Some(vec![0]), "segments.ply"),
        (
            |d| d.segments.tilt_deg = Some(vec![0.0]),
            "segments.tilt_deg",
        ),
        (
            |d| d.segments.roughness_um = Some(vec![-0.1; 4]),
            "segments.roughness_um[0]",
        ),
        (
            |d| d.segments.tilt_deg = Some(vec![0.0, -90.0, 0.0, 0.0]),
            "segments.tilt_deg[1]",
        ),
        (
            |d| d.segments.k_ratio = Some(vec![f64::INFINITY; 4]),
            "segments.k_ratio[0]",
        ),
        (|d| d.segments.arrival_us = None, "segments.arrival_us"),
        (
            |d| d.segments.departure_us = Some(vec![2.0, 10.0, 21.0, 50.0]),
            "segment 2 departs at 21 µs, after",
        ),
        (
            |d| d.segments.departure_us = Some(vec![2.0, 9.0, 16.0, 50.0]),
            "segment 1 departs at 9 µs, before its parent 0",
        ),
        (
            |d| d.impacts[0].speed_m_s = Some(-1.0),
            "impacts.speed_m_s[0] = -1",
        ),
        (
            |d| d.impacts[0].angle_deg = Some(91.0),
            "impacts.angle_deg[0] = 91",
        ),
        (
            |d| d.impacts[0].azimuth_deg = Some(f64::NAN),
            "impacts.azimuth_deg[0]",
        ),
        (|d| d.impacts[0].force = Some(f64::NAN), "impacts.force[0]"),
        (
            |d| d.impacts[0].radius_mm = Some(1e300),
            "impacts.radius_mm[0] = 1e300; expected a finite number ≥ 0, within 1e18 of 0",
        ),
        (
            |d| d.impacts[0].crushed_radius_mm = Some(-1.0),
            "impacts.crushed_radius_mm[0]",
        ),
        (
            |d| {
                d.summary = Some(Summary {
                    available_j: Some(-1.0),
                    ..Summary::default()
                })
            },
            "summary.available_j[0]",
        ),
        (
            |d| {
                d.pane = Pane {
                    width: 60.0,
                    height: 60.0,
                    kind: Some(GlassKind::Cover),
                    thickness_mm: None,
                };
                d.nodes.x[1] = 59.0;
                d.nodes.y[1] = 1.0;
            },
            "node 1 at (59, 1)",
        ),
    ];
    for (change, expected) in cases {
        let mut data = physics();
        change(&mut data);
        let message = CrackNetwork::new(data).unwrap_err().to_string();
        assert!(
            message.contains(expected) && !message.contains('\n'),
            "{message:?} does not name {expected:?}"
        );
    }
}

#[test]
fn a_round_pane_has_no_corners() {
    let disc = Pane {
        width: 60.0,
        height: 60.0,
        kind: Some(GlassKind::Cover),
        thickness_mm: None,
    };
    let step = 30.0 + 30.0 * 0.5_f64.sqrt();
    for (x, y, is_inside) in [
        (60.0, 30.0, true),
        (step, step, true),
        (step + 1e-6, step, false),
        (1.0, 1.0, false),
    ] {
        assert_eq!(disc.contains(x, y), is_inside, "({x}, {y})");
    }
}

#[test]
fn a_tip_moves_from_its_departure_to_its_arrival() {
    let network = CrackNetwork::new(physics()).unwrap();
    let at = |time: f64| network.grown_at(time).collect::<Vec<_>>();
    assert_eq!(at(2.0).len(), 0, "the first tip leaves late");
    assert_eq!(at(6.0), [(0, [50.0, 25.0, 55.0, 25.0])], "half way");
    assert_eq!(at(15.0).len(), 2, "the second arm waits after the fork");
    assert_eq!(
        at(60.0)[3],
        (3, [100.0, 10.0, 95.0, 10.0]),
        "a crack without parent grows from the rim"
    );
}

#[test]
fn a_drawing_in_mm_has_its_true_size() {
    let svg = CrackNetwork::new(physics()).unwrap().to_svg();
    assert!(
        svg.contains("viewBox=\"0 0 100 50\" width=\"100mm\" height=\"50mm\""),
        "{svg}"
    );
    assert!(svg.contains("stroke-width=\"0.05\""), "{svg}");
    let svg = CrackNetwork::new(star()).unwrap().to_svg();
    assert!(
        svg.contains("viewBox=\"0 0 100 50\" width=\"100\" height=\"50\""),
        "{svg}"
    );
    assert!(svg.contains("stroke-width=\"0.80\""), "{svg}");
}

#[test]
fn a_ring_of_parents_is_refused() {
    let error = refusal(|d| {
        d.segments.from = vec![0, 1, 2, 3];
        d.segments.to = vec![1, 2, 0, 4];
        d.segments.parent = Some(vec![Some(2), Some(0), Some(1), None]);
        d.segments.arrival_step = Some(vec![1.0; 4]);
    });
    assert!(error.to_string().contains("its own ancestor"), "{error}");
}

#[test]
fn whatever_meets_without_a_common_node_is_refused() {
    let with_segment = |ends: [f64; 4]| {
        refusal(|d| {
            d.segments.parent = None;
            d.segments.arrival_step = None;
            d.nodes.x.extend([ends[0], ends[2]]);
            d.nodes.y.extend([ends[1], ends[3]]);
            d.segments.from.push(5);
            d.segments.to.push(6);
            d.segments.kind.push(SegmentKind::Mst);
        })
        .to_string()
    };
    assert!(
        with_segment([70.0, 10.0, 70.0, 45.0]).contains("cross without a node"),
        "a crossing"
    );
    assert!(
        with_segment([70.0, 27.5, 70.0, 45.0]).contains("only one of them has a node"),
        "a touch"
    );
    assert!(
        with_segment([70.0, 27.5, 90.0, 30.0]).contains("on top of each other"),
        "an overlap"
    );
    assert!(
        with_segment([90.0, 30.0, 95.0, 45.0]).contains("two different nodes"),
        "two nodes at one place"
    );
}

#[test]
fn the_file_holds_what_the_network_holds() {
    let network = CrackNetwork::new(star()).unwrap();
    let text = network.to_json();
    assert_eq!(
        CrackNetwork::from_json(&text).unwrap().to_json(),
        text,
        "read and written again"
    );
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    for key in [
        "schema",
        "generator",
        "model",
        "seed",
        "unit",
        "pane",
        "impacts",
        "nodes",
        "segments",
        "summary",
    ] {
        assert!(value.get(key).is_some(), "the file has no {key}");
    }
    assert!(
        value["segments"].get("opening_um").is_none(),
        "a column that the model does not produce is absent"
    );
    assert_eq!(value["segments"]["kind"][1], "mst", "kinds are words");
}

#[test]
fn growth_shows_each_tip_between_its_parents_arrival_and_its_own() {
    let network = CrackNetwork::new(star()).unwrap();
    assert_eq!(network.grown_at(0.0).count(), 0, "nothing at the impact");
    let half: Vec<_> = network.grown_at(0.5).collect();
    assert_eq!(half.len(), 3, "three arms on their way");
    assert_eq!(
        half[0].1,
        [50.0, 25.0, 70.0, 27.5],
        "half way along the first"
    );
    let later: Vec<_> = network.grown_at(1.5).collect();
    assert_eq!(
        later[3].1,
        [50.0, 5.0, 50.25, 3.125],
        "the fourth grows from the third"
    );
    assert_eq!(network.grown_at(2.0).count(), 4, "all there");
}

#[test]
fn a_share_of_the_length_is_there_at_its_time() {
    let network = CrackNetwork::new(star()).unwrap();
    let length_at = |time: f64| -> f64 {
        network
            .grown_at(time)
            .map(|(_, [x0, y0, x1, y1])| (x1 - x0).hypot(y1 - y0))
            .sum()
    };
    let whole = length_at(2.0);
    for share in [0.1, 0.25, 0.5, 0.9, 0.999] {
        let time = network.time_of_length(share);
        let there = length_at(time) / whole;
        assert!((there - share).abs() < 1e-12, "{there} at {time}");
    }
    assert_eq!(
        network.time_of_length(0.0),
        0.0,
        "nothing before the impact"
    );
    assert_eq!(
        network.time_of_length(1.0),
        2.0,
        "all with the last arrival"
    );
}

/// Whether two segments share a point other than one node that both have; integers, so exact.
fn meet(p: [[i64; 2]; 2], q: [[i64; 2]; 2], same_node: bool) -> bool {
    let side = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| {
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum()
    };
    let on = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| {
        side(a, b, c) == 0 && (0..2).all(|k| c[k] >= a[k].min(b[k]) && c[k] <= a[k].max(b[k]))
    };
    let crosses = side(p[0], p[1], q[0]) * side(p[0], p[1], q[1]) < 0
        && side(q[0], q[1], p[0]) * side(q[0], q[1], p[1]) < 0;
    let touches = on(p[0], p[1], q[0])
        || on(p[0], p[1], q[1])
        || on(q[0], q[1], p[0])
        || on(q[0], q[1], p[1]);
    if !same_node {
        return crosses || touches;
    }
    // With a common node: only an overlap is a contact, that is an end inside the other.
    let inside = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| on(a, b, c) && c != a && c != b;
    inside(p[0], p[1], q[0])
        || inside(p[0], p[1], q[1])
        || inside(q[0], q[1], p[0])
        || inside(q[0], q[1], p[1])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Few places, so that touches, overlaps and common nodes are the rule.
    #[test]
    fn contacts_are_those_of_a_full_search(
        places in prop::collection::btree_set((0_i64..9, 0_i64..7), 4..14),
        pairs in prop::collection::btree_set((0_usize..14, 0_usize..14), 1..14),
        flat in any::<bool>(),
    ) {
        let places: Vec<[i64; 2]> = places.into_iter().map(|(x, y)| if flat { [x * 1000, y] } else { [x, y] }).collect();
        let mut segments: Vec<(usize, usize)> = pairs
            .into_iter()
            .map(|(a, b)| (a % places.len(), b % places.len()))
            .filter(|(a, b)| a < b)
            .collect();
        segments.sort_unstable();
        segments.dedup();
        #[expect(clippy::cast_precision_loss, reason = "small integers")]
        let nodes = Nodes {
            x: places.iter().map(|place| place[0] as f64).collect(),
            y: places.iter().map(|place| place[1] as f64).collect(),
        };
        let from: Vec<u32> = segments.iter().map(|(a, _)| u32::try_from(*a).unwrap()).collect();
        let to: Vec<u32> = segments.iter().map(|(_, b)| u32::try_from(*b).unwrap()).collect();
        let mut found: Vec<(u32, u32)> = find_contacts(&nodes, &from, &to).iter().map(|c| (c.first, c.second)).collect();
        found.dedup();
        let all: Vec<u32> = (0..u32::try_from(from.len()).unwrap()).collect();
        prop_assert_eq!(find_contacts_of(&nodes, &from, &to, &all), find_contacts(&nodes, &from, &to), "one by one as all at once");
        let mut expected = Vec::new();
        for (i, &(a, b)) in segments.iter().enumerate() {
            for (j, &(c, d)) in segments.iter().enumerate().skip(i + 1) {
                let same_node = a == c || a == d || b == c || b == d;
                if meet([places[a], places[b]], [places[c], places[d]], same_node) {
                    expected.push((u32::try_from(i).unwrap(), u32::try_from(j).unwrap()));
                }
            }
        }
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        prop_assert!(CrackNetwork::from_json(&text).is_err());
    }
}

/// `n` level lines across `n` upright ones.
fn weave(n: u32) -> NetworkData {
    let (mut nodes, mut from, mut to) = (Nodes::default(), Vec::new(), Vec::new());
    for k in 0..n {
        let at = (f64::from(k) + 0.5) / f64::from(n) * 50.0;
        for ends in [[[0.0, at], [100.0, at]], [[at, 0.0], [at, 50.0]]] {
            from.push(u32::try_from(nodes.x.len()).unwrap());
            to.push(from[from.len() - 1] + 1);
            for [x, y] in ends {
                nodes.x.push(x);
                nodes.y.push(y);
            }
        }
    }
    NetworkData {
        nodes,
        segments: Segments {
            kind: vec![SegmentKind::Radial; from.len()],
            from,
            to,
            ..Segments::default()
        },
        impacts: Vec::new(),
        ..star()
    }
}

#[test]
fn a_search_for_contacts_ends_where_there_are_too_many() {
    let data = weave(40);
    let Segments { from, to, .. } = &data.segments;
    let all = find_contacts(&data.nodes, from, to);
    assert_eq!(all.len(), 1600, "every line crosses every other");
    let within = |limit| find_contacts_up_to(&data.nodes, from, to, limit);
    assert_eq!(within(1600), Some(all), "as many as allowed");
    assert_eq!(within(1599), None, "one too many");
    // Lines from one node in one direction, of many lengths.
    let n = 200;
    let nodes = Nodes {
        x: (0..=n).map(f64::from).collect(),
        y: vec![0.0; n as usize + 1],
    };
    let (from, to) = (vec![0; n as usize], (1..=n).collect::<Vec<u32>>());
    let n_pairs = n as usize * (n as usize - 1) / 2;
    assert!(
        find_contacts_up_to(&nodes, &from, &to, n_pairs).is_some(),
        "all pairs"
    );
    assert!(
        find_contacts_up_to(&nodes, &from, &to, n_pairs - 1).is_none(),
        "one less"
    );
    let refused = CrackNetwork::new(weave(2100)).unwrap_err();
    assert!(
        matches!(refused, NetworkError::Crowded { n_segments: 4200 }),
        "{refused}"
    );
}
