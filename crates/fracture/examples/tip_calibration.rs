//! Prints the calibration of the tip's K: stars of n arms in a plate, as a table in CSV.
//!
//! K = √(E G) with G = (1/n h) dU/dr at constant load, from energies U of plates that are hinged
//! along n straight arms of length r; slopes are those of parabolas through seven lengths. Beside
//! it two laws, from the hoop tension σ of the intact plate's back face and the distance
//! s = 2πr/n of neighboring arms, with f = (1+ν)/(3(3+ν)):
//!
//! - `k_tip` = σ(r) √(π min(f r, f s/2π)), of the tension at the tip;
//! - `k_fit` = σ(q r) √(π min(1.5 f r, 1.9 s/2π)), q = min(1, 0.64 + 0.035 n): tension is taken at
//!   a place behind the tip, for a crack is driven by what acts on all of it.
//!
//! Run with `cargo run --release -p starbreak-fracture --example tip_calibration`, five minutes;
//! with a number for that many nodes per mesh instead of 12 000.
#![expect(clippy::print_stdout, reason = "a table is what it is for")]

use std::f64::consts::PI;

use starbreak_fracture::FractureError;
use starbreak_fracture::mesh::{Outline, PlateMesh};
use starbreak_fracture::physics::Support;
use starbreak_fracture::stress::{Face, PatchLoad, PlateField, PlateProperties, PlateSolver};

const H_M: f64 = 3e-3;
const E_PA: f64 = 70e9;
const FORCE_N: f64 = 100.0;

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
    let asked = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let n_nodes = asked.unwrap_or(12_000);
    println!(
        "place,nu,n,r_m,sigma_tip_pa,sigma_mean_pa,k_fem,k_tip,fem_over_tip,k_fit,fem_over_fit"
    );
    for place in PLACES {
        for poisson_ratio in [0.22, 0.0] {
            let plate = Plate {
                place,
                poisson_ratio,
                n_nodes,
            };
            for n in [2, 3, 4, 6, 8, 12, 20] {
                table(plate, n)?;
            }
        }
    }
    Ok(())
}

/// A plate and its mesh.
#[derive(Debug, Clone, Copy)]
struct Plate {
    place: Place,
    poisson_ratio: f64,
    n_nodes: u32,
}

fn solve(
    Plate {
        place,
        poisson_ratio,
        n_nodes,
    }: Plate,
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
        n_nodes,
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

fn table(plate: Plate, n: u32) -> Result<(), FractureError> {
    let Plate {
        place,
        poisson_ratio,
        ..
    } = plate;
    let (mesh, intact) = solve(plate, &[])?;
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
        energies.push(solve(plate, &cracks)?.1.energy_j);
    }
    let factor = (1.0 + poisson_ratio) / (3.0 * (3.0 + poisson_ratio));
    for k in 3..n_arms - 3 {
        let places: Vec<(f64, f64)> = (k - 3..=k + 3)
            .map(|j| (arm(j) - arm(k), energies[j as usize]))
            .collect();
        let r = arm(k);
        let rate = slope(&places) / (f64::from(n) * H_M);
        let k_fem = (E_PA * rate.max(0.0)).sqrt();
        let n_gaps = f64::from(n);
        let tip = hoop(r);
        let at_tip = tip.max(0.0) * (factor * PI * r.min(r / n_gaps)).sqrt();
        let behind = hoop((0.64 + 0.035 * n_gaps).min(1.0) * r);
        let fit = behind.max(0.0) * (PI * r * (1.5 * factor).min(1.9 / n_gaps)).sqrt();
        println!(
            "{},{poisson_ratio},{n},{r:.4},{tip:.4e},{:.4e},{k_fem:.4e},{at_tip:.4e},{:.3},{fit:.4e},{:.3}",
            place.name,
            mean(0.0, r),
            k_fem / at_tip,
            k_fem / fit,
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
                let taken = matrix[pivot].map(|entry| part * entry);
                for (entry, taken) in matrix[row].iter_mut().zip(taken) {
                    *entry -= taken;
                }
            }
        }
    }
    matrix[1][3] / matrix[1][1] / scale
}
