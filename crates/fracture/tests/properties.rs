//! What holds for any parameters.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use starbreak_fracture::paper::{
    Direction, Neighborhood, PaperImpact, PaperParams, Position, Rule, simulate,
};
use starbreak_glass::{CrackNetwork, Pane};
use starbreak_seed::Seed;

fn impacts() -> impl Strategy<Value = Vec<(Option<[f64; 2]>, f64, f64)>> {
    let position = prop_oneof![
        Just(None),
        [0.0..=1.0_f64, 0.0..=1.0_f64].prop_map(Some),
        // Corners and rims, where the outline of the mesh passes through the impact.
        prop::sample::select(vec![
            [0.0, 0.0],
            [1.0, 1.0],
            [0.5, 0.0],
            [0.0, 0.25],
            [1.0, 0.5]
        ])
        .prop_map(Some),
    ];
    prop::collection::vec((position, 1.0..2000.0_f64, -400.0..400.0_f64), 1..4)
}

fn params() -> impl Strategy<Value = PaperParams> {
    let rule = prop::sample::select(vec![Rule::Algorithm1, Rule::Caption, Rule::Literal]);
    let neighborhood = prop::sample::select(vec![Neighborhood::Radius, Neighborhood::MeshEdges]);
    let numbers = (
        1_u32..600,
        0.01..90.0_f64,
        1.0..600.0_f64,
        0.2..3.0_f64,
        1_u32..4,
    );
    (numbers, rule, neighborhood, any::<bool>(), any::<bool>()).prop_map(
        |(
            (particles, neighbor_radius, critical_stress, safety_factor, branches),
            rule,
            neighborhood,
            two_sided,
            snap_to_mesh,
        )| {
            PaperParams {
                particles,
                neighbor_radius,
                neighborhood,
                critical_stress,
                safety_factor,
                rule,
                branches,
                two_sided,
                snap_to_mesh,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_network_keeps_its_promises(
        width in 1_u32..400,
        height in 1_u32..400,
        impacts in impacts(),
        params in params(),
        seed in any::<u64>(),
    ) {
        let pane = Pane::from_frame_px(width, height);
        let impacts: Vec<PaperImpact> = impacts
            .into_iter()
            .map(|(position, force, degrees)| PaperImpact {
                position: position.map_or(Position::Random { share: 1.0 }, |[x, y]| Position::At { x: x * pane.width, y: y * pane.height }),
                force,
                direction: Direction::Angle { rad: degrees.to_radians() },
            })
            .collect();
        let fracture = simulate(&pane, &impacts, &params, Seed(seed), |_| ()).unwrap();
        prop_assert!(fracture.network.check_invariants().is_ok(), "{:?}", fracture.network.check_invariants());
        prop_assert!(fracture.convergence.converged(), "the propagation ends");
        let unbroken = impacts.iter().all(|impact| impact.force <= params.threshold());
        prop_assert!(!unbroken || fracture.is_intact(), "nothing breaks below the threshold");

        let again = simulate(&pane, &impacts, &params, Seed(seed), |_| ()).unwrap();
        let text = fracture.network.to_json();
        prop_assert_eq!(&text, &again.network.to_json(), "the same seed gives the same bytes");
        let read = CrackNetwork::from_json(&text).unwrap();
        prop_assert_eq!(&read.to_json(), &text, "a network survives its file");
    }
}
