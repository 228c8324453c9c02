//! Prints the calibration of the tip's K: stars of n arms in a plate, as a table in CSV.
//!
//! K = √(E G) with G = (1/n h) dU/dr at constant load, from energies U of plates that are hinged
//! along n straight arms of length r. Beside it what the tip law is made of: hoop tension of the
//! intact plate's back face at the tip and its mean along the arm.
#![expect(clippy::print_stdout, reason = "a table is what it is for")]

use std::f64::consts::PI;

use starbreak_fracture::FractureError;
use starbreak_fracture::mesh::{Outline, PlateMesh};
use starbreak_fracture::physics::Support;
use starbreak_fracture::stress::{Face, PatchLoad, PlateField, PlateProperties, PlateSolver};

const H_M: f64 = 3e-3;
const E_PA: f64 = 70e9;
const FORCE_N: f64 = 100.0;
const N_NODES: u32 = 12_000;

/// Where the star grows, in units of 1 m: a clamped disc of radius 1, or a foundation of length
/// ℓ = 1 under a disc of radius 8.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    name: &'static str,
    radius_m: f64,
    has_foundation: bool,
    patch_m: f64,
    arms_m: [f64; 2],
}

const PLACES: [Place; 2] = [
    Place {
        name: "clamped",
        radius_m: 1.0,
        has_foundation: false,
        patch_m: 0.01,
        arms_m: [0.1, 0.6],
    },
    Place {
        name: "foundation",
        radius_m: 8.0,
        has_foundation: true,
        patch_m: 0.02,
        arms_m: [0.25, 3.0],
    },
];

fn main() -> Result<(), FractureError> {
    println!("place,nu,n,r,k_fem,sigma_tip,sigma_mean,sigma_half,k_law,ratio");
    for place in PLACES {
        for poisson_ratio in [0.22, 0.0] {
            for n in [2, 3, 4, 6, 8, 12] {
                table(place, poisson_ratio, n)?;
            }
        }
    }
    Ok(())
}

fn solve(
    place: Place,
    poisson_ratio: f64,
    cracks: &[Vec<[f64; 2]>],
) -> Result<(PlateMesh, PlateField), FractureError> {
    let mut plate = PlateProperties {
        thickness_m: H_M,
        young_modulus_pa: E_PA,
        poisson_ratio,
        foundation_pa_m: 0.0,
    };
    if place.has_foundation {
        plate.foundation_pa_m = plate.rigidity_n_m();
    }
    let radius = place.radius_m;
    let mesh = PlateMesh::graded_around_cracks(
        &Outline::Disc {
            diameter_m: 2.0 * radius,
        },
        [radius; 2],
        0.5 * place.patch_m,
        None,
        N_NODES,
        cracks,
    )?;
    let solver = PlateSolver::new(mesh, plate, Support::Clamped)?;
    let field = solver.solve(&PatchLoad {
        center_m: [radius; 2],
        radius_m: place.patch_m,
        force_n: FORCE_N,
    })?;
    Ok((solver.mesh().clone(), field))
}

fn table(place: Place, poisson_ratio: f64, n: u32) -> Result<(), FractureError> {
    let (mesh, intact) = solve(place, poisson_ratio, &[])?;
    let hoop = |r: f64| {
        let sum: f64 = (0..24)
            .map(|k| {
                let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k) / 24.0);
                let point = [place.radius_m + r * cos, place.radius_m + r * sin];
                intact
                    .surface_stress_at(&mesh, point, Face::Back, &mut 0)
                    .map_or(0.0, |stress| stress.normal_pa([-sin, cos]))
            })
            .sum();
        sum / 24.0
    };
    let mean = |from: f64, to: f64| {
        let sum: f64 = (0..200)
            .map(|k| hoop(from + (to - from) * (f64::from(k) + 0.5) / 200.0))
            .sum();
        sum / 200.0
    };
    let [least, most] = place.arms_m;
    let n_arms = 24_u32;
    let arm = |k: u32| least * (most / least).powf(f64::from(k) / f64::from(n_arms - 1));
    let mut energies = Vec::new();
    for k in 0..n_arms {
        let cracks: Vec<Vec<[f64; 2]>> = (0..n)
            .map(|j| {
                let (sin, cos) = libm::sincos(0.1 + 2.0 * PI * f64::from(j) / f64::from(n));
                let center = [place.radius_m; 2];
                vec![center, [center[0] + arm(k) * cos, center[1] + arm(k) * sin]]
            })
            .collect();
        energies.push(solve(place, poisson_ratio, &cracks)?.1.energy_j);
    }
    let factor = (1.0 + poisson_ratio) / (3.0 * (3.0 + poisson_ratio));
    for k in 3..n_arms - 3 {
        let places: Vec<(f64, f64)> = (k - 3..=k + 3)
            .map(|j| (arm(j) - arm(k), energies[j as usize]))
            .collect();
        let r = arm(k);
        let rate = slope(&places) / (f64::from(n) * H_M);
        let k_fem = (E_PA * rate.max(0.0)).sqrt();
        let tip = hoop(r);
        let gap = 2.0 * PI * r / f64::from(n);
        let k_law = tip.max(0.0) * (factor * PI * r.min(gap / (2.0 * PI))).sqrt();
        println!(
            "{},{poisson_ratio},{n},{r:.4},{k_fem:.5e},{tip:.5e},{:.5e},{:.5e},{k_law:.5e},{:.3}",
            place.name,
            mean(0.0, r),
            mean(0.5 * r, r),
            k_fem / k_law
        );
    }
    Ok(())
}

/// Slope at 0 of the parabola that fits best.
fn slope(places: &[(f64, f64)]) -> f64 {
    let scale = places.iter().map(|(x, _)| x.abs()).fold(0.0, f64::max);
    let mut matrix = [[0.0; 4]; 3];
    for &(x, y) in places {
        let powers = [1.0, x / scale, (x / scale).powi(2)];
        for row in 0..3 {
            for column in 0..3 {
                matrix[row][column] += powers[row] * powers[column];
            }
            matrix[row][3] += powers[row] * y;
        }
    }
    for pivot in 0..3 {
        for row in 0..3 {
            if row != pivot {
                let part = matrix[row][pivot] / matrix[pivot][pivot];
                for column in 0..4 {
                    matrix[row][column] -= part * matrix[pivot][column];
                }
            }
        }
    }
    matrix[1][3] / matrix[1][1] / scale
}
