//! The elastic body, against closed forms.
#![expect(
    clippy::print_stdout,
    reason = "the measured figures, with --nocapture"
)]

use starbreak_peridynamics::body::Body;
use starbreak_peridynamics::lattice::{Lattice, as_f64};
use starbreak_peridynamics::material::Material;
use starbreak_peridynamics::plate::{GLASS, PMMA, Plate, THICKNESS_M};
use starbreak_peridynamics::random::Random;
use std::f64::consts::PI;

/// Energies of the nodes away from the edges, J, summed, and the area that they stand for, m².
fn inside(lattice: &Lattice, energies: &[f64], margin: usize) -> (f64, f64) {
    let (mut energy_j, mut count) = (0.0, 0);
    for i in 0..lattice.len() {
        let (row, column) = (i / lattice.n_x, i % lattice.n_x);
        if row >= margin
            && row + margin < lattice.n_y
            && column >= margin
            && column + margin < lattice.n_x
        {
            energy_j += energies.iter().skip(i).step_by(lattice.len()).sum::<f64>();
            count += 1;
        }
    }
    (
        energy_j,
        as_f64(count) * lattice.spacing_m * lattice.spacing_m,
    )
}

/// Modulus of a regular sheet that is stretched along x by ε and along y by −ε/3, from its energy
/// ½Eε² in the interior.
fn modulus_pa(horizon: f64, jitter: f64, material: &Material) -> f64 {
    let spacing_m = 0.25e-3;
    let lattice = Lattice::new(60, 60, spacing_m, jitter, &mut Random::new(2));
    let mut body = Body::default();
    body.add_sheet(&lattice, 0.0, 1.0, horizon * spacing_m, material);
    let strain = 1e-6;
    for i in 0..body.len() {
        body.position_m[0][i] *= 1.0 + strain;
        body.position_m[1][i] *= 1.0 - strain / 3.0;
    }
    let (energy_j, area_m2) = inside(&lattice, &body.elastic_of_nodes_j(), 8);
    energy_j / area_m2 * 2.0 / (strain * strain)
}

#[test]
fn uniaxial_stretch_gives_youngs_modulus() {
    // Exact on the regular lattice; jitter moves neighbors over the horizon.
    for (horizon, jitter, tolerance) in [(4.0, 0.0, 1e-6), (3.0, 0.0, 1e-6), (3.0, 0.35, 0.01)] {
        let ratio = modulus_pa(horizon, jitter, &GLASS) / GLASS.young_pa;
        println!("horizon {horizon} spacings, jitter {jitter}: E {ratio:.4} of the material's");
        assert!(
            (ratio - 1.0).abs() < tolerance,
            "{horizon} {jitter}: {ratio}"
        );
    }
}

#[test]
fn a_strip_rings_with_the_bar_speed() {
    // First longitudinal mode of a free strip of length L: half a period is L/c, c = √(E/ρ). The
    // nodes at the long edges have fewer bonds, so a strip of 30 spacings is a little soft.
    let (n_x, n_y, spacing_m) = (200, 30, 1e-3);
    let lattice = Lattice::new(n_x, n_y, spacing_m, 0.0, &mut Random::new(0));
    let mut body = Body::default();
    body.add_sheet(&lattice, 0.0, 1.0, 3.0 * spacing_m, &GLASS);
    let length_m = as_f64(n_x) * spacing_m;
    let shape: Vec<f64> = lattice
        .x_m
        .iter()
        .map(|x| libm::sin(PI * x / length_m))
        .collect();
    for (velocity, shape) in body.velocity_m_s[0].iter_mut().zip(&shape) {
        *velocity = 1e-3 * shape;
    }
    let step_s = 0.4 * spacing_m / GLASS.bar_speed_m_s();
    let mut n_steps = 0;
    loop {
        body.step(step_s);
        n_steps += 1;
        let moved: f64 = (0..body.len())
            .map(|i| shape[i] * (body.position_m[0][i] - body.rest_m[0][i]))
            .sum();
        if moved < 0.0 {
            break;
        }
    }
    let speed_m_s = length_m / (f64::from(n_steps) * step_s);
    let ratio = speed_m_s / GLASS.bar_speed_m_s();
    println!("bar speed: {ratio:.4} of √(E/ρ)");
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}

#[test]
fn cylindrical_bending_gives_the_plate_stiffness() {
    // w = −½κx² and u = −z w′: energy ½Dκ² per area, D = Eh³/(12(1−ν²)), ν = 1/3.
    let mut plate = Plate::new(60, 60, 0.35, THICKNESS_M, &PMMA, &mut Random::new(4));
    let curvature_per_m = 1e-4;
    for i in 0..plate.body.len() {
        let (x, z) = (plate.body.rest_m[0][i], plate.body.rest_m[2][i]);
        plate.body.position_m[0][i] += z * curvature_per_m * x;
        plate.body.position_m[2][i] -= 0.5 * curvature_per_m * x * x;
    }
    let (energy_j, area_m2) = inside(&plate.lattice, &plate.body.elastic_of_nodes_j(), 8);
    let stiffness_n_m = energy_j / area_m2 * 2.0 / (curvature_per_m * curvature_per_m);
    let expected_n_m = PMMA.young_pa * THICKNESS_M.powi(3) / (12.0 * (1.0 - 1.0 / 9.0));
    let ratio = stiffness_n_m / expected_n_m;
    println!("bending: D {ratio:.4} of the plate's");
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}

#[test]
fn transverse_shear_gives_five_sixths() {
    // The sheets slide over each other by γ times their distance: energy ½·5/6·G·h·γ² per area.
    let mut plate = Plate::new(60, 60, 0.35, THICKNESS_M, &PMMA, &mut Random::new(4));
    let (shear, n) = (1e-6, plate.lattice.len());
    let gap_m = plate.body.rest_m[2][0] - plate.body.rest_m[2][n];
    for i in 0..n {
        plate.body.position_m[0][i] += shear * gap_m;
    }
    let (energy_j, area_m2) = inside(&plate.lattice, &plate.body.elastic_of_nodes_j(), 3);
    let expected_j_m2 = 0.5 * 5.0 / 6.0 * 0.375 * PMMA.young_pa * THICKNESS_M * shear * shear;
    let ratio = energy_j / area_m2 / expected_j_m2;
    println!("shear: {ratio:.4} of 5/6·G·h");
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}

#[test]
fn a_free_strip_rings_like_a_beam() {
    // First mode of a free-free Euler-Bernoulli beam: ω = 22.373/L²·√(EI/(ρA)), I/A = h²/12, mode
    // shape by cosines; L = 60 h keeps shear and rotary inertia below 0.3 %.
    let (n_x, n_y) = (240, 30);
    let thickness_m = 0.64 * THICKNESS_M;
    let mut plate = Plate::new(n_x, n_y, 0.0, thickness_m, &PMMA, &mut Random::new(0));
    let length_m = as_f64(n_x) * plate.lattice.spacing_m;
    let beta = 4.730_041;
    let shape = |x_m: f64| {
        let s = beta * (x_m / length_m + 0.5);
        let ratio = (libm::cosh(beta) - libm::cos(beta)) / (libm::sinh(beta) - libm::sin(beta));
        libm::cosh(s) + libm::cos(s) - ratio * (libm::sinh(s) + libm::sin(s))
    };
    let shapes: Vec<f64> = plate.body.rest_m[0].iter().map(|x| shape(*x)).collect();
    for (velocity, shape) in plate.body.velocity_m_s[2].iter_mut().zip(&shapes) {
        *velocity = 1e-4 * shape;
    }
    let mut n_steps = 0;
    loop {
        plate.body.step(plate.step_s);
        n_steps += 1;
        let body = &plate.body;
        let moved: f64 = (0..body.len())
            .map(|i| shapes[i] * (body.position_m[2][i] - body.rest_m[2][i]))
            .sum();
        if moved < 0.0 {
            break;
        }
    }
    let omega_per_s = PI / (f64::from(n_steps) * plate.step_s);
    let expected_per_s =
        beta * beta / (length_m * length_m) * PMMA.bar_speed_m_s() * thickness_m / libm::sqrt(12.0);
    let ratio = omega_per_s / expected_per_s;
    println!("beam: ω {ratio:.4} of Euler and Bernoulli's");
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}

#[test]
fn energy_is_kept() {
    let mut plate = Plate::new(40, 40, 0.35, THICKNESS_M, &PMMA, &mut Random::new(8));
    // A wave over the plate in each direction: twice the plate is its length.
    for axis in 0..3 {
        for i in 0..plate.body.len() {
            let (x, y) = (plate.body.rest_m[0][i], plate.body.rest_m[1][i]);
            let wave_m = 0.16e-3 * 80.0;
            plate.body.velocity_m_s[axis][i] = libm::cos((x + 0.5 * y) / wave_m * 2.0 * PI);
        }
    }
    let total = |plate: &mut Plate| {
        let energy = plate.body.energy(plate.step_s);
        energy.kinetic_j + energy.elastic_j
    };
    plate.body.step(plate.step_s);
    let start_j = total(&mut plate);
    let mut worst = 0.0_f64;
    for _ in 0..20 {
        for _ in 0..100 {
            plate.body.step(plate.step_s);
        }
        worst = worst.max((total(&mut plate) / start_j - 1.0).abs());
    }
    assert_eq!(plate.body.n_broken.iter().sum::<u32>(), 0, "nothing breaks");
    println!("energy: off by {worst:.1e} at most in 2000 steps");
    assert!(worst < 1e-3, "{worst}");
}
