//! The paper's model against its closed forms and against what a precise reading predicts.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use starbreak_fracture::paper::{
    Direction, Fracture, Neighborhood, PaperImpact, PaperParams, Position, Rule,
    euclidean_spanning_tree, simulate,
};
use starbreak_glass::{Pane, SegmentKind};
use starbreak_seed::Seed;

fn pane() -> Pane {
    Pane::from_frame_px(1242, 375)
}

/// An impact in the middle of the pane, at a direction that differs from seed to seed.
fn middle(force: f64, seed: u64) -> PaperImpact {
    let rad = f64::from(u32::try_from(seed).unwrap()) * 2.399_963;
    let pane = pane();
    PaperImpact {
        position: Position::At {
            x: pane.width * 0.5,
            y: pane.height * 0.5,
        },
        force,
        direction: Direction::Angle { rad },
    }
}

fn broken(impact: PaperImpact, params: &PaperParams, seed: u64) -> Fracture {
    simulate(&pane(), &[impact], params, Seed(seed), |_| ()).unwrap()
}

/// Ends of propagated segments, relative to the impact: distance and angle to its direction.
fn propagated(fracture: &Fracture) -> Vec<(f64, f64)> {
    let data = fracture.network.data();
    let impact = &data.impacts[0];
    let direction = impact.direction_deg.unwrap().to_radians();
    let ends = data.segments.to.iter().zip(&data.segments.kind);
    ends.filter(|(_, kind)| **kind == SegmentKind::Propagated)
        .map(|(&node, _)| {
            let (dx, dy) = (
                data.nodes.x[node as usize] - impact.x,
                data.nodes.y[node as usize] - impact.y,
            );
            let off = dy.atan2(dx) - direction;
            (dx.hypot(dy), off.sin().atan2(off.cos()).abs())
        })
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    f64::midpoint(values[(values.len() - 1) / 2], values[values.len() / 2])
}

/// Largest angle to the impact's direction beyond two radii, in degrees less arccos(T/F).
///
/// Within a radius of the rim a crack has no neighbors ahead and turns along the rim, so with a
/// `margin` such ends are left out.
fn excess_half_angle_deg(force: f64, particles: u32, margin: f64) -> f64 {
    let params = PaperParams {
        particles,
        ..PaperParams::default()
    };
    let pane = Pane::from_frame_px(1242, 1242);
    let expected = (params.threshold() / force).acos();
    let per_seed = (0..20).map(|seed| {
        let impact = PaperImpact {
            position: Position::At {
                x: pane.width * 0.5,
                y: pane.height * 0.5,
            },
            ..middle(force, seed)
        };
        let fracture = simulate(&pane, &[impact], &params, Seed(seed), |_| ()).unwrap();
        let far = propagated(&fracture)
            .into_iter()
            .filter(|(r, _)| (130.0..621.0 - margin).contains(r));
        let largest = far.map(|(_, angle)| angle).fold(0.0, f64::max);
        (largest - expected).to_degrees()
    });
    median(per_seed.collect())
}

/// As above on the frame of the paper, where the fan is cut by the rim.
fn excess_half_angle_on_frame_deg(force: f64, particles: u32) -> f64 {
    let params = PaperParams {
        particles,
        ..PaperParams::default()
    };
    let expected = (params.threshold() / force).acos();
    let per_seed = (0..20).map(|seed| {
        let far = propagated(&broken(middle(force, seed), &params, seed));
        let largest = far
            .iter()
            .filter(|(r, _)| *r > 130.0)
            .map(|(_, angle)| *angle)
            .fold(0.0, f64::max);
        (largest - expected).to_degrees()
    });
    median(per_seed.collect())
}

#[test]
fn the_fan_opens_to_arccos_of_threshold_over_force() {
    for (force, particles, low, high) in [
        (500.0, 10_000, -3.0, 5.0),
        (310.0, 10_000, -3.0, 5.0),
        (500.0, 30_000, -2.0, 2.0),
    ] {
        let excess = excess_half_angle_on_frame_deg(force, particles);
        assert!(
            (low..=high).contains(&excess),
            "F = {force}, N = {particles}: {excess:+.2}°"
        );
    }
    // As dense on the larger pane as 10^4 particles on the frame of the paper.
    for force in [310.0, 500.0, 1000.0, 3000.0] {
        let excess = excess_half_angle_deg(force, 33_000, 130.0);
        assert!(
            (-3.0..=5.0).contains(&excess),
            "F = {force} away from the rim: {excess:+.2}°"
        );
    }
}

#[test]
fn no_force_above_the_threshold_no_fracture() {
    for (force, critical_stress, safety_factor) in [
        (300.0, 300.0, 1.0),
        (250.0, 300.0, 1.0),
        (500.0, 300.0, 0.5),
    ] {
        let params = PaperParams {
            particles: 500,
            critical_stress,
            safety_factor,
            ..PaperParams::default()
        };
        let fracture = broken(middle(force, 1), &params, 1);
        assert!(
            fracture.is_intact(),
            "F = {force} against σ_C/S = {}",
            params.threshold()
        );
        assert_eq!(
            fracture.convergence.impacts_without_fracture, 1,
            "and it is counted"
        );
    }
}

#[test]
fn the_spanning_tree_weighs_what_prims_weighs() {
    for (n, seed) in [(1_u32, 1), (2, 2), (3, 3), (40, 4), (500, 5), (2000, 6)] {
        // Nodes of a network of the model itself, so that the points are of its kind.
        let params = PaperParams {
            particles: 4 * n + 50,
            ..PaperParams::default()
        };
        let fracture = broken(middle(900.0, seed), &params, seed);
        let nodes = &fracture.network.data().nodes;
        let points: Vec<[f64; 2]> = nodes
            .x
            .iter()
            .zip(&nodes.y)
            .take(n as usize)
            .map(|(x, y)| [*x, *y])
            .collect();
        let tree = euclidean_spanning_tree(&points).unwrap();
        assert_eq!(
            tree.len(),
            points.len().saturating_sub(1),
            "a tree over {} points",
            points.len()
        );
        let weight: f64 = tree.iter().map(|edge| edge.length).sum();
        let expected = prim_weight(&points);
        assert!(
            (weight - expected).abs() <= 1e-12 * expected.max(1.0),
            "n = {n}: {weight} against {expected}"
        );
    }
}

#[test]
fn a_grid_of_equal_distances_and_a_line_have_their_trees() {
    let grid: Vec<[f64; 2]> = (0..400)
        .map(|k| [f64::from(k % 20), f64::from(k / 20)])
        .collect();
    let weight: f64 = euclidean_spanning_tree(&grid)
        .unwrap()
        .iter()
        .map(|edge| edge.length)
        .sum();
    assert!((weight - 399.0).abs() < 1e-9, "unit grid: {weight}");
    let line: Vec<[f64; 2]> = (0..50)
        .map(|k| [f64::from(k) * f64::from(k), 3.0])
        .collect();
    let weight: f64 = euclidean_spanning_tree(&line)
        .unwrap()
        .iter()
        .map(|edge| edge.length)
        .sum();
    assert!(
        (weight - 49.0 * 49.0).abs() < 1e-9,
        "points on a line: {weight}"
    );
}

/// Prim's algorithm over all pairs.
fn prim_weight(points: &[[f64; 2]]) -> f64 {
    let mut nearest = vec![f64::INFINITY; points.len()];
    let mut done = vec![false; points.len()];
    let (mut at, mut weight) = (0, 0.0);
    for _ in 1..points.len() {
        done[at] = true;
        let mut next = at;
        for k in 0..points.len() {
            if done[k] {
                continue;
            }
            let distance = (points[k][0] - points[at][0]).hypot(points[k][1] - points[at][1]);
            nearest[k] = nearest[k].min(distance);
            if next == at || nearest[k] < nearest[next] {
                next = k;
            }
        }
        weight += nearest[next];
        at = next;
    }
    weight
}

#[test]
fn the_literal_rule_dies_early() {
    let params = PaperParams {
        rule: Rule::Literal,
        ..PaperParams::default()
    };
    let per_seed = (0..20).map(|seed| {
        let fracture = broken(middle(500.0, seed), &params, seed);
        let report = &fracture.convergence;
        // Every front but the impact is one hop; every stopped front ends one arm.
        #[expect(clippy::cast_precision_loss, reason = "counts")]
        let hops_per_arm = (report.n_fronts - 1) as f64
            / (report.stopped_below_threshold + report.stopped_at_crack) as f64;
        hops_per_arm
    });
    let mean = per_seed.sum::<f64>() / 20.0;
    assert!(mean < 2.0, "hops per arm: {mean}");
}

#[test]
fn along_mesh_edges_cracks_reach_some_sixty_pixels() {
    let params = PaperParams {
        neighborhood: Neighborhood::MeshEdges,
        ..PaperParams::default()
    };
    let reach = |seed| {
        let ends = propagated(&broken(middle(500.0, seed), &params, seed));
        ends.iter().map(|(r, _)| *r).fold(0.0, f64::max)
    };
    let mean = (0..60).map(reach).sum::<f64>() / 60.0;
    assert!((45.0..=75.0).contains(&mean), "mean reach {mean} px");
}

#[test]
fn both_ways_is_twice_the_fan() {
    let one = PaperParams::default();
    let both = PaperParams {
        two_sided: true,
        ..one
    };
    let backward = |params: &PaperParams| {
        propagated(&broken(middle(500.0, 3), params, 3))
            .iter()
            .filter(|(_, angle)| *angle > 2.0)
            .count()
    };
    assert_eq!(backward(&one), 0, "nothing behind a one-sided impact");
    assert!(backward(&both) > 20, "a second fan behind a two-sided one");
}

#[test]
fn branches_fork_and_impacts_add_up() {
    let one = PaperParams {
        neighborhood: Neighborhood::MeshEdges,
        ..PaperParams::default()
    };
    let three = PaperParams { branches: 3, ..one };
    let length = |params: &PaperParams| {
        broken(middle(500.0, 5), params, 5)
            .network
            .summary()
            .total_length
    };
    assert!(
        length(&three) > 1.5 * length(&one),
        "three branches make more crack than one"
    );

    let corner = PaperImpact {
        position: Position::At { x: 0.0, y: 0.0 },
        ..middle(500.0, 0)
    };
    let fracture = simulate(
        &pane(),
        &[middle(500.0, 1), corner],
        &PaperParams::default(),
        Seed(2),
        |_| (),
    )
    .unwrap();
    fracture.network.check_invariants().unwrap();
    let data = fracture.network.data();
    for impact in &data.impacts {
        let starts = (0..fracture.network.n_segments()).filter(|&idx| {
            let [x, y, ..] = fracture.network.ends(idx);
            (x - impact.x).hypot(y - impact.y) < 1e-9
        });
        assert!(
            starts.count() > 0,
            "cracks leave the impact at ({}, {})",
            impact.x,
            impact.y
        );
    }
}

#[test]
fn snapped_cracks_run_along_mesh_edges() {
    let jumping = PaperParams {
        particles: 3000,
        ..PaperParams::default()
    };
    let snapped = PaperParams {
        snap_to_mesh: true,
        ..jumping
    };
    let longest = |params: &PaperParams| {
        let fracture = broken(middle(500.0, 4), params, 4);
        fracture.network.check_invariants().unwrap();
        let kinds = &fracture.network.data().segments.kind;
        let lengths = kinds
            .iter()
            .enumerate()
            .filter(|(_, kind)| **kind == SegmentKind::Propagated)
            .map(|(idx, _)| {
                let [x0, y0, x1, y1] = fracture.network.ends(idx);
                (x1 - x0).hypot(y1 - y0)
            });
        median(lengths.collect())
    };
    // Mean spacing of 3000 particles is 12.5 px; mesh edges are of that length.
    assert!(longest(&snapped) < 20.0, "mesh edges are short");
    broken(middle(500.0, 4), &jumping, 4)
        .network
        .check_invariants()
        .unwrap();
}

#[test]
fn arrival_steps_count_from_the_impact() {
    let fracture = broken(middle(500.0, 6), &PaperParams::default(), 6);
    let data = fracture.network.data();
    let times = data.segments.arrival_step.as_ref().unwrap();
    assert!(
        times.windows(2).all(|pair| pair[0] <= pair[1]),
        "segments stand in order of arrival"
    );
    assert!(times[0] > 0.0, "nothing arrives before the impact");
    let mut lengths = [0.0_f64; 3];
    for (slot, share) in lengths.iter_mut().zip([0.25, 0.5, 1.0]) {
        let grown = fracture
            .network
            .grown_at(fracture.network.last_arrival() * share);
        *slot = grown
            .map(|(_, [x0, y0, x1, y1])| (x1 - x0).hypot(y1 - y0))
            .sum();
    }
    assert!(
        lengths[0] < lengths[1] && lengths[1] < lengths[2],
        "the crack grows: {lengths:?}"
    );
    assert!(
        (lengths[2] - fracture.network.summary().total_length).abs() < 1e-6,
        "and is whole in the end"
    );
}

#[test]
fn a_radius_that_spans_too_many_particles_is_refused_with_a_better_one() {
    let params = PaperParams {
        particles: 100_000,
        ..PaperParams::default()
    };
    let small = Pane::from_frame_px(100, 100);
    let message = simulate(&small, &[PaperImpact::default()], &params, Seed(1), |_| ())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("radius 65 spans") && message.contains("about 3.0"),
        "{message}"
    );
}

#[test]
fn a_radius_beyond_the_pane_takes_every_particle() {
    // On a tiny pane every particle is a neighbor of every other.
    let tiny = Pane::from_frame_px(1, 1);
    let params = PaperParams {
        particles: 400,
        ..PaperParams::default()
    };
    let fracture = simulate(&tiny, &[PaperImpact::default()], &params, Seed(1), |_| ()).unwrap();
    fracture.network.check_invariants().unwrap();
}
