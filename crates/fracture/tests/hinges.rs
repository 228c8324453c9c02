//! Cracks as hinge lines of the plate against closed forms.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;

use starbreak_fracture::mesh::{Outline, PlateMesh};
use starbreak_fracture::physics::Support;
use starbreak_fracture::stress::{Face, PatchLoad, PlateField, PlateProperties, PlateSolver};

const PLATE: PlateProperties = PlateProperties {
    thickness_m: 3e-3,
    young_modulus_pa: 70e9,
    poisson_ratio: 0.22,
    foundation_pa_m: 0.0,
};
const FORCE_N: f64 = 100.0;

fn solve(
    outline: Outline,
    plate: PlateProperties,
    support: Support,
    load: PatchLoad,
    n_nodes: u32,
    cracks: &[Vec<[f64; 2]>],
) -> (PlateSolver, PlateField) {
    let inner_m = (0.35 * load.radius_m).max(1e-3);
    let mesh =
        PlateMesh::graded_around_cracks(&outline, load.center_m, inner_m, None, n_nodes, cracks)
            .unwrap();
    let solver = PlateSolver::new(mesh, plate, support).unwrap();
    let field = solver.solve(&load).unwrap();
    (solver, field)
}

fn patch(center_m: [f64; 2], radius_m: f64) -> PatchLoad {
    PatchLoad {
        center_m,
        radius_m,
        force_n: FORCE_N,
    }
}

/// ∫ over the height of a strip of what `value` gives at x, by the trapezoidal rule.
fn across(height_m: f64, value: impl Fn(f64) -> f64) -> f64 {
    let n = 800;
    let step = height_m / f64::from(n);
    (1..n).map(|k| value(step * f64::from(k)) * step).sum()
}

#[test]
fn a_hinged_strip_is_two_cantilevers() {
    // Clamped at x = 0 and 2 l, hinge at l. The deflection of a point load, integrated along a
    // long strip, is that of a line load on a beam.
    let (l, height) = (0.1, 1.6);
    let outline = Outline::Rectangle {
        width_m: 2.0 * l,
        height_m: height,
    };
    let plate = PlateProperties {
        poisson_ratio: 0.0,
        ..PLATE
    };
    let d = plate.rigidity_n_m();
    let section = plate.thickness_m.powi(2) / 6.0;
    let crack = vec![vec![[l, 0.0], [l, height]]];
    for a in [0.6 * l, l] {
        let load = patch([a, 0.5 * height], 0.0);
        let (solver, field) = solve(outline, plate, Support::Clamped, load, 20_000, &crack);
        let mesh = solver.mesh();
        // What the far half holds of the load, from equal deflections at the hinge.
        let shear = FORCE_N * a * a * (3.0 * l - a) / (4.0 * l.powi(3));
        let closed = shear * l.powi(3) / (3.0 * d);
        let at_hinge = |y: f64| field.deflection_at_m(mesh, [l, y], &mut 0).unwrap();
        let got = across(height, at_hinge);
        assert!((got / closed - 1.0).abs() < 5e-3, "a = {a}: {got} {closed}");
        for (x, closed) in [(0.0, FORCE_N * a - shear * l), (2.0 * l, shear * l)] {
            let moment = |y: f64| {
                let stress = field.surface_stress_at(mesh, [x, y], Face::Front, &mut 0);
                stress.unwrap().xx_pa * section
            };
            let got = across(height, moment);
            assert!((got / closed - 1.0).abs() < 0.03, "x = {x}: {got} {closed}");
        }
    }
}

#[test]
fn moment_across_a_hinge_vanishes_with_the_mesh() {
    let (l, height) = (0.1, 0.8);
    let outline = Outline::Rectangle {
        width_m: 2.0 * l,
        height_m: height,
    };
    let crack = vec![vec![[l, 0.0], [l, height]]];
    let load = patch([0.6 * l, 0.5 * height], 5e-3);
    let rest = |n_nodes: u32, cracks: &[Vec<[f64; 2]>]| {
        let (solver, field) = solve(outline, PLATE, Support::Clamped, load, n_nodes, cracks);
        across(height, |y| {
            let side = |x: f64| {
                let stress = field.surface_stress_at(solver.mesh(), [x, y], Face::Back, &mut 0);
                stress.unwrap().xx_pa.abs()
            };
            0.5 * (side(l - 1e-9) + side(l + 1e-9))
        })
    };
    let whole = rest(20_000, &[]);
    let parts = [1500, 6000, 24_000].map(|n| rest(n, &crack) / whole);
    assert!(parts[0] < 0.1, "{parts:?}");
    assert!(
        parts[1] < 0.6 * parts[0] && parts[2] < 0.6 * parts[1],
        "{parts:?}"
    );
}

/// Deflection under a force in the middle of a simply supported square of side 1 m, which has a
/// hinge along its middle line, m: each half is a plate with one free edge that bears one half of
/// the force there; Lévy's series.
fn levy_m(plate: &PlateProperties) -> f64 {
    let (d, nu) = (plate.rigidity_n_m(), plate.poisson_ratio);
    (0..100)
        .map(|k| {
            let alpha = f64::from(2 * k + 1) * PI;
            let t = 0.5 * alpha;
            let (sinh, cosh) = (libm::sinh(t), libm::cosh(t));
            // w = A sinh αx + B αx cosh αx; no moment at the free edge gives A of B, then its
            // shear force is that of the load.
            let a = -(2.0 * sinh + (1.0 - nu) * t * cosh) / ((1.0 - nu) * sinh);
            let shear = -(1.0 - nu) * a * cosh + (1.0 + nu) * cosh - (1.0 - nu) * t * sinh;
            let b = -FORCE_N / (d * alpha.powi(3) * shear);
            b * (a * sinh + t * cosh)
        })
        .sum()
}

#[test]
fn a_square_with_a_hinge_is_two_plates_with_a_free_edge() {
    let square = Outline::Rectangle {
        width_m: 1.0,
        height_m: 1.0,
    };
    let crack = vec![vec![[0.5, 0.0], [0.5, 1.0]]];
    let closed = levy_m(&PLATE);
    let load = patch([0.5; 2], 0.0);
    let (_, field) = solve(
        square,
        PLATE,
        Support::SimplySupported,
        load,
        10_000,
        &crack,
    );
    let got = 2.0 * field.energy_j / FORCE_N;
    assert!((got / closed - 1.0).abs() < 5e-3, "{got} {closed}");
}

/// A star of `n` arms in the middle of a disc of radius 1 m.
fn star(n: u32, arm_m: f64, phase: f64) -> Vec<Vec<[f64; 2]>> {
    (0..n)
        .map(|k| {
            let angle = phase + 2.0 * PI * f64::from(k) / f64::from(n);
            let (sin, cos) = libm::sincos(angle);
            vec![[1.0; 2], [1.0 + arm_m * cos, 1.0 + arm_m * sin]]
        })
        .collect()
}

/// Energy of a clamped disc of radius 1 m with a star of so many arms that its sectors bear no
/// hoop moment, under a force in the middle: that of the intact disc, and what has been released
/// at the front, ∫ M²/2D(1−ν²) dA, where M is the hoop moment just ahead of the star. Inside the
/// star M_r = −P/2π; outside Lamé's fields are added to those of the intact disc.
fn dense_star_energy_j(arm_m: f64) -> f64 {
    let (d, nu) = (PLATE.rigidity_n_m(), PLATE.poisson_ratio);
    let p = FORCE_N / (4.0 * PI);
    let front = |r: f64| {
        let log = -(1.0 + nu) * libm::log(r);
        let (even, odd) = (1.0 + nu, (1.0 - nu) / (r * r));
        p * (log - nu + (log + 1.0) * (odd - even) / (odd + even))
    };
    let steps = 4000;
    let step = arm_m / f64::from(steps);
    let released: f64 = (0..steps)
        .map(|k| {
            let r = step * (f64::from(k) + 0.5);
            step * 2.0 * PI * r * front(r).powi(2) / (2.0 * d * (1.0 - nu * nu))
        })
        .sum();
    FORCE_N * FORCE_N / (32.0 * PI * d) + released
}

#[test]
fn stars_bend_as_cantilevers() {
    let disc = Outline::Disc { diameter_m: 2.0 };
    let load = patch([1.0; 2], 0.01);
    let energy = |n: u32, arm_m: f64| {
        let cracks = star(n, arm_m, 0.1);
        let (solver, field) = solve(disc, PLATE, Support::Clamped, load, 12_000, &cracks);
        // All sectors alike, and their sides, too.
        let r = 0.6 * arm_m;
        let stress = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            let point = [1.0 + r * cos, 1.0 + r * sin];
            let stress = field.surface_stress_at(solver.mesh(), point, Face::Front, &mut 0);
            let stress = stress.unwrap();
            [stress.normal_pa([cos, sin]), stress.normal_pa([-sin, cos])]
        };
        let axes = (0..n).map(|k| 0.1 + 2.0 * PI * (f64::from(k) + 0.5) / f64::from(n));
        let found: Vec<[f64; 2]> = axes.map(stress).collect();
        let mean = [0, 1].map(|c| found.iter().map(|s| s[c]).sum::<f64>() / f64::from(n));
        for [radial, hoop] in &found {
            let off = (radial - mean[0]).abs().max((hoop - mean[1]).abs());
            assert!(off < 0.05 * mean[0].abs(), "n = {n}: {found:?}");
        }
        assert!(mean[0] > 0.0, "the hit face is under radial tension");
        (field.energy_j, mean)
    };
    for n in [3, 6, 12] {
        let energies = [0.1, 0.2, 0.3, 0.4].map(|arm| energy(n, arm).0);
        assert!(
            energies.windows(2).all(|pair| pair[1] > pair[0]),
            "{energies:?}"
        );
    }
    // Many arms: a cantilever bears M_r = −P/2π all along, and nothing across.
    let (got, [radial, hoop]) = energy(24, 0.3);
    let closed = FORCE_N / (2.0 * PI) * 6.0 / PLATE.thickness_m.powi(2);
    assert!((radial / closed - 1.0).abs() < 0.1, "{radial} {closed}");
    assert!(hoop.abs() < 0.1 * closed, "{hoop} {closed}");
    let dense = dense_star_energy_j(0.3);
    assert!((got / dense - 1.0).abs() < 0.1, "{got} {dense}");
}

/// Energy of a disc of radius 1 m under a force in its middle with a star of `n` arms, J.
fn star_energy_j(plate: PlateProperties, n: u32, arm_m: f64) -> f64 {
    let disc = Outline::Disc { diameter_m: 2.0 };
    let load = patch([1.0; 2], 0.01);
    let cracks = star(n, arm_m, 0.1);
    let (_, field) = solve(disc, plate, Support::Clamped, load, 12_000, &cracks);
    field.energy_j
}

#[test]
fn energy_release_of_stars_is_that_of_the_tip_formula() {
    let (h, e, nu) = (
        PLATE.thickness_m,
        PLATE.young_modulus_pa,
        PLATE.poisson_ratio,
    );
    let f = (1.0 + nu) / (3.0 * (3.0 + nu));
    // Hoop tension of the intact disc's back face, less its rim's part for a crack: −ν.
    let tension = |log: f64| FORCE_N / (4.0 * PI) * ((1.0 + nu) * log - nu) * 6.0 / (h * h);
    for (n, arm_m) in [
        (2, 0.2),
        (3, 0.2),
        (3, 0.4),
        (6, 0.2),
        (6, 0.4),
        (12, 0.2),
        (12, 0.4),
    ] {
        let [low, high] = [0.85, 1.15].map(|part| part * arm_m);
        let released = star_energy_j(PLATE, n, high) - star_energy_j(PLATE, n, low);
        let rate = released / ((high - low) * f64::from(n) * h);
        let got = (e * rate).sqrt();
        let n = f64::from(n);
        let at = (0.64 + 0.035 * n).min(1.0) * arm_m;
        let weight = (1.5 * f).min(1.9 / n);
        let fitted = tension(-libm::log(at)) * (weight * PI * arm_m).sqrt();
        assert!(
            (got / fitted - 1.0).abs() < 0.15,
            "n = {n}, {arm_m}: {got} {fitted}"
        );
        if n < 3.0 {
            // One crack, closed form: mean of the tension with the weight 1/√(r² − x²), by which
            // a logarithm is that at half of the way.
            let closed = tension(-libm::log(0.5 * arm_m)) * (f * PI * arm_m).sqrt();
            assert!((got / closed - 1.0).abs() < 0.06, "{got} {closed}");
        }
    }
}

#[test]
fn cracks_of_any_kind_are_meshed_and_solved() {
    let pane = Outline::Rectangle {
        width_m: 1.0,
        height_m: 0.6,
    };
    let center = [0.4, 0.3];
    let arms = |n: u32, from: f64, to: f64| -> Vec<Vec<[f64; 2]>> {
        (0..n)
            .map(|k| {
                let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k) / f64::from(n) + 0.3);
                [from, to].map(|r| [0.4 + r * cos, 0.3 + r * sin]).to_vec()
            })
            .collect()
    };
    let spiral: Vec<[f64; 2]> = (0..20_000)
        .map(|k| {
            let angle = 0.002 * f64::from(k);
            let (sin, cos) = libm::sincos(angle);
            [0.4 + 0.005 * angle * cos, 0.3 + 0.005 * angle * sin]
        })
        .collect();
    let wild: Vec<Vec<[f64; 2]>> = (0..60)
        .map(|k| {
            (0..5)
                .map(|j| {
                    let x = f64::from(5 * k + j);
                    [
                        (x * 0.754_877_666).fract(),
                        0.6 * (x * 0.569_840_291).fract(),
                    ]
                })
                .collect()
        })
        .collect();
    let fork = vec![
        vec![center, [0.5, 0.3]],
        vec![[0.5, 0.3], [0.6, 0.301]],
        vec![[0.5, 0.3], [0.6, 0.299]],
        vec![[0.55, 0.2], [0.5, 0.3]],
    ];
    let rims = vec![
        vec![[0.0, 0.0], [1.0, 0.6]],
        vec![[-1.0, 0.1], [2.0, 0.1]],
        vec![[0.0, 0.0], [1.0, 0.0]],
        vec![[0.3, 0.6], [0.3, 0.599_999]],
        vec![[0.7, 0.0], [0.7, 1e-5]],
        vec![[5.0, 5.0], [6.0, 6.0]],
    ];
    let none = vec![
        vec![],
        vec![[0.1, 0.1]],
        vec![[0.1, 0.1]; 3],
        vec![[f64::NAN, 0.1], [0.2, 0.2]],
        vec![[f64::INFINITY, 0.1], [0.2, 0.2]],
        vec![[0.2, 0.2], [0.2 + 1e-12, 0.2]],
    ];
    for (name, cracks) in [
        ("a star to the rim", arms(7, 0.0, 2.0)),
        ("a star of 200 arms", arms(200, 0.0, 0.1)),
        ("arms without a middle", arms(12, 0.01, 0.1)),
        ("a spiral", vec![spiral]),
        ("all across each other", wild),
        ("a narrow fork", fork),
        ("on the rim", rims),
        ("none at all", none),
    ] {
        for radius_m in [None, Some(0.15), Some(0.35)] {
            let energy = || {
                let mesh =
                    PlateMesh::graded_around_cracks(&pane, center, 1e-3, radius_m, 2500, &cracks)
                        .unwrap();
                let n = mesh.nodes().len();
                assert!((1500..5000).contains(&n), "{name}: {n} nodes");
                let solver = PlateSolver::new(mesh, PLATE, Support::SimplySupported)
                    .unwrap_or_else(|e| panic!("{name}, {radius_m:?}: {e}"));
                let field = solver
                    .solve(&patch(center, 3e-3))
                    .unwrap_or_else(|e| panic!("{name}, {radius_m:?}: {e}"));
                let n_sides = u32::try_from(solver.mesh().nodes_of_sides().len()).unwrap();
                for side in 0..n_sides {
                    let stress = field.surface_stress(solver.mesh(), side, Face::Back);
                    assert!(stress.xx_pa.is_finite(), "{name}: {side}");
                }
                field.energy_j
            };
            let mesh = PlateMesh::graded_to(&pane, center, 1e-3, radius_m, 2500).unwrap();
            let solver = PlateSolver::new(mesh, PLATE, Support::SimplySupported).unwrap();
            let whole = solver.solve(&patch(center, 3e-3)).unwrap().energy_j;
            let cracked = energy();
            assert!(
                cracked > 0.999 * whole,
                "{name}, {radius_m:?}: {cracked} {whole}"
            );
            assert_eq!(cracked.to_bits(), energy().to_bits(), "{name}: again");
        }
    }
}
