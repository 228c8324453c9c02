//! The camera against closed forms, its own inverse, and lines cut by brute force.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;
use starbreak_glass::{CrackNetwork, Pane};
use starbreak_optics::paper::{Normalization, PaperOptics, crack_energies, draw};
use starbreak_optics::{Camera, OpticsError, View};

const SIZE: (u32, u32) = (1242, 375);

fn camera(rake_deg: f64) -> Camera {
    Camera {
        f_px: 721.5,
        distance_m: 0.3,
        rake_rad: rake_deg.to_radians(),
        axis_at_mm: [700.0, 400.0],
    }
}

fn view(rake_deg: f64) -> View {
    View::through(&camera(rake_deg), SIZE).unwrap()
}

fn close(a: [f64; 2], b: [f64; 2], tolerance: f64) -> bool {
    (a[0] - b[0]).abs() <= tolerance && (a[1] - b[1]).abs() <= tolerance
}

#[test]
fn an_upright_pane_is_scaled_by_focal_length_over_distance() {
    let (view, scale) = (view(0.0), 721.5 / 300.0);
    let seen = view.project([760.0, 350.0]).unwrap();
    let expected = [621.0 + 60.0 * scale, 187.5 - 50.0 * scale];
    assert!(close(seen, expected, 1e-9), "{seen:?} against {expected:?}");
    assert!(
        (view.px_per_unit([10.0, 20.0]).unwrap() - scale).abs() < 1e-12,
        "everywhere"
    );
    assert_eq!(
        view.project([700.0, 400.0]),
        Some([621.0, 187.5]),
        "the axis in the middle"
    );
}

#[test]
fn the_top_of_a_raked_pane_is_nearer() {
    // 60°: a point 100 mm up the pane is 50 mm up and 100 sin 60° mm nearer.
    let (view, near) = (view(60.0), 300.0 - 100.0 * 0.75_f64.sqrt());
    let seen = view.project([740.0, 300.0]).unwrap();
    let expected = [621.0 + 721.5 * 40.0 / near, 187.5 - 721.5 * 50.0 / near];
    assert!(close(seen, expected, 1e-9), "{seen:?} against {expected:?}");
    let (top, bottom) = ([700.0, 300.0], [700.0, 500.0]);
    assert!(
        view.px_per_unit(top).unwrap() > view.px_per_unit(bottom).unwrap(),
        "what is nearer is larger"
    );
    // Area scale of a tilted plane: f² d cos ρ/z³.
    let expected = (721.5_f64 * 721.5 * 300.0 * 0.5 / near.powi(3)).sqrt();
    assert!(
        (view.px_per_unit(top).unwrap() - expected).abs() < 1e-9,
        "at the top"
    );
    // The pane reaches the depth of the pinhole at 300/sin 60° = 346.4 mm up.
    assert!(view.project([700.0, 54.0]).is_some() && view.project([700.0, 53.0]).is_none());
    assert_eq!(view.px_per_unit([700.0, 53.0]), None, "behind");
    // Its plane is seen up to v′ = cot ρ below the middle and no further.
    let horizon = 187.5 + 721.5 / 3.0_f64.sqrt();
    assert!(view.unproject([621.0, horizon - 0.1]).is_some());
    assert_eq!(
        view.unproject([621.0, horizon + 0.1]),
        None,
        "the sky, as it were"
    );
}

#[test]
fn leaning_back_is_leaning_forward_upside_down() {
    for [x, y] in [[30.0, 20.0], [-120.0, 90.0], [55.0, -140.0]] {
        let [u, v] = view(40.0).project([700.0 + x, 400.0 + y]).unwrap();
        let mirrored = view(-40.0).project([700.0 + x, 400.0 - y]).unwrap();
        assert!(close([u, 375.0 - v], mirrored, 1e-9), "({x}, {y})");
    }
}

fn star() -> CrackNetwork {
    CrackNetwork::from_json(
        r#"{"schema":"starbreak.crack-network/1","generator":{"name":"test","version":"1"},"model":"imported",
        "unit":"mm","pane":{"width":1400.0,"height":800.0},"impacts":[],
        "nodes":{"x":[700.0,760.0,690.0,720.0,10.0,20.0],"y":[400.0,390.0,330.0,440.0,20.0,10.0]},
        "segments":{"from":[0,0,0,4],"to":[1,2,3,5],"kind":["radial","radial","radial","edge"]}}"#,
    )
    .unwrap()
}

#[test]
fn a_frame_of_twice_the_pixels_shows_the_same() {
    let (small, large) = (
        view(35.0),
        View::through(
            &Camera {
                f_px: 2.0 * 721.5,
                ..camera(35.0)
            },
            (2 * SIZE.0, 2 * SIZE.1),
        )
        .unwrap(),
    );
    for point in [[760.0, 390.0], [10.0, 20.0], [690.0, 330.5]] {
        let (one, two) = (small.project(point), large.project(point));
        assert!(
            close(one.unwrap().map(|u| 2.0 * u), two.unwrap(), 1e-9),
            "{point:?}"
        );
    }
    let optics = |line_width_px| PaperOptics {
        line_width_px,
        ..PaperOptics::default()
    };
    let (one, two) = (
        draw(&star(), &small, f64::INFINITY, &optics(2.0)),
        draw(&star(), &large, f64::INFINITY, &optics(4.0)),
    );
    let (one, two) = (one.area_px2(), two.area_px2());
    assert!(
        one > 500.0 && (two / one / 4.0 - 1.0).abs() < 0.01,
        "{one} and {two} px²"
    );
}

#[test]
fn a_crack_out_of_sight_counts_for_nothing() {
    let optics = PaperOptics {
        normalization: Normalization::Mean,
        ..PaperOptics::default()
    };
    let energies = crack_energies(&star(), &view(0.0), &optics);
    assert_eq!(
        energies[3].to_bits(),
        0,
        "the crack in the corner is not seen"
    );
    let mean = energies[..3].iter().sum::<f32>() / 3.0;
    assert!(
        (mean - 1.0).abs() < 1e-6,
        "the mean is over what is seen: {energies:?}"
    );
    assert!(
        energies[..3].iter().all(|energy| *energy > 0.0),
        "{energies:?}"
    );
}

#[test]
fn cameras_out_of_range_are_named() {
    type Change = fn(&mut Camera);
    let cases: [(Change, &str); 5] = [
        (|c| c.f_px = 0.0, "f_px"),
        (|c| c.distance_m = f64::NAN, "distance_m"),
        (|c| c.rake_rad = 1.55, "rake_rad"),
        (|c| c.axis_at_mm[0] = f64::INFINITY, "axis_at_mm.x"),
        (|c| c.axis_at_mm[1] = f64::NAN, "axis_at_mm.y"),
    ];
    for (change, expected) in cases {
        let mut bad = camera(0.0);
        change(&mut bad);
        match View::through(&bad, SIZE) {
            Err(OpticsError::Parameter { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
}

fn any_camera() -> impl Strategy<Value = View> {
    (
        100.0_f64..3000.0,
        0.02_f64..2.0,
        -85.0_f64..85.0,
        -500.0_f64..500.0,
        -500.0_f64..500.0,
    )
        .prop_map(|(f_px, distance_m, rake_deg, x, y)| {
            let camera = Camera {
                f_px,
                distance_m,
                rake_rad: rake_deg.to_radians(),
                axis_at_mm: [x, y],
            };
            View::through(&camera, SIZE).unwrap()
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_is_seen_at_a_pixel_appears_there(
        view in any_camera(), u in 0.0_f64..1242.0, v in 0.0_f64..375.0,
    ) {
        if let Some(point) = view.unproject([u, v]) {
            // A grazing line of sight meets the pane far away, where a pixel is metres of it.
            prop_assume!(view.px_per_unit(point).unwrap() > 1e-3);
            let again = view.project(point).unwrap();
            prop_assert!(close(again, [u, v], 1e-9 * 1242.0), "{again:?} is not {:?}", [u, v]);
            let back = view.unproject(again).unwrap();
            let size = 1.0 + point[0].abs() + point[1].abs();
            prop_assert!(close(back, point, 1e-9 * size), "{back:?} is not {point:?}");
        }
    }

    #[test]
    fn the_jacobian_is_the_slope_of_the_projection(
        view in any_camera(), u in 0.0_f64..1242.0, v in 0.0_f64..375.0,
    ) {
        let Some([x, y]) = view.unproject([u, v]) else { return Ok(()) };
        prop_assume!(view.px_per_unit([x, y]).unwrap() > 0.05);
        let slopes = view.jacobian([x, y]).unwrap();
        let h = 1e-3;
        for (column, [dx, dy]) in [[h, 0.0], [0.0, h]].into_iter().enumerate() {
            let ahead = view.project([x + dx, y + dy]).unwrap();
            let behind = view.project([x - dx, y - dy]).unwrap();
            for row in 0..2 {
                let slope = (ahead[row] - behind[row]) / (2.0 * h);
                prop_assert!((slope - slopes[row][column]).abs() < 1e-4 * (1.0 + slope.abs()));
            }
        }
    }

    /// Points along the line, one by one: those that fall into the frame lie on the visible
    /// part, and its ends are such points.
    #[test]
    fn the_visible_part_is_that_of_a_point_by_point_search(
        view in any_camera(),
        ends in prop::array::uniform4(-1500.0_f64..1500.0),
        margin in 0.0_f64..20.0,
    ) {
        let n = 4000;
        let is_in = |[u, v]: [f64; 2], slack: f64| {
            u >= -margin - slack && u <= 1242.0 + margin + slack
                && v >= -margin - slack && v <= 375.0 + margin + slack
        };
        let [x0, y0, x1, y1] = ends;
        let seen: Vec<[f64; 2]> = (0..=n)
            .map(|k| f64::from(k) / f64::from(n))
            .filter_map(|t| view.project([x0 + (x1 - x0) * t, y0 + (y1 - y0) * t]))
            .filter(|point| is_in(*point, -1e-6))
            .collect();
        match view.visible(ends, margin) {
            None => prop_assert!(seen.is_empty(), "left out {seen:?}"),
            Some([u0, v0, u1, v1]) => {
                prop_assert!(is_in([u0, v0], 1e-6) && is_in([u1, v1], 1e-6), "an end outside");
                let (du, dv) = (u1 - u0, v1 - v0);
                let length = du.hypot(dv).max(1e-12);
                for [u, v] in &seen {
                    let along = ((u - u0) * du + (v - v0) * dv) / length;
                    let across = ((u - u0) * dv - (v - v0) * du) / length;
                    prop_assert!(along > -1e-6 && along < length + 1e-6, "{along} of {length}");
                    prop_assert!(length < 1e-3 || across.abs() < 1e-5, "{across} off the line");
                }
                // Each end is an end of the line or lies on the border of the frame.
                let on_border = |point: [f64; 2]| !is_in(point, -1e-6);
                for (end, [x, y]) in [([u0, v0], [x0, y0]), ([u1, v1], [x1, y1])] {
                    let is_end = view.project([x, y]).is_some_and(|p| close(p, end, 1e-6));
                    prop_assert!(is_end || on_border(end), "{end:?} is cut short");
                }
            }
        }
    }

    #[test]
    fn a_stretched_pane_fills_its_frame(x in 0.0_f64..60.0, y in 0.0_f64..40.0) {
        let view = View::stretched(&Pane::from_frame_px(60, 40), (120, 120));
        prop_assert_eq!(view.project([x, y]), Some([2.0 * x, 3.0 * y]));
        prop_assert_eq!(view.visible([x, y, 1e3, 1e3], 0.0), Some([2.0 * x, 3.0 * y, 2e3, 3e3]));
        prop_assert!(close(view.unproject([2.0 * x, 3.0 * y]).unwrap(), [x, y], 1e-12));
    }
}
