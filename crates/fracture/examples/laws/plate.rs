//! V1, V2, V3 and the field of V9: plate and contact against closed forms.

use std::error::Error;
use std::f64::consts::PI;

use starbreak_fracture::contact::contact_load;
use starbreak_fracture::mesh::{Outline, PlateMesh};
use starbreak_fracture::physics::{MeshResolution, StoneImpact, Support};
use starbreak_fracture::stress::{Face, PatchLoad, PlateProperties, PlateSolver};
use starbreak_glass::Material;

use crate::measures::panes::rectangle;
use crate::table::{Row, Rows};

const PLATE: PlateProperties = PlateProperties {
    thickness_m: 3e-3,
    young_modulus_pa: 70e9,
    poisson_ratio: 0.22,
    foundation_pa_m: 0.0,
};
const DISC: Outline = Outline::Disc { diameter_m: 1.0 };
const SQUARE: Outline = Outline::Rectangle {
    width_m: 1.0,
    height_m: 1.0,
};
const FORCE_N: f64 = 100.0;

/// Length of the foundation of V1 and V9, m.
const LENGTH_M: f64 = 5e-3;

fn load(radius_m: f64) -> PatchLoad {
    PatchLoad {
        center_m: [0.5; 2],
        radius_m,
        force_n: FORCE_N,
    }
}

/// Deflection under a force in the middle of a plate 1 m wide, m: what does the work, U = Pw/2.
fn middle_m(outline: &Outline, support: Support, n_nodes: u32) -> Result<f64, Box<dyn Error>> {
    let mesh = PlateMesh::graded_to(outline, [0.5; 2], 1e-3, None, n_nodes)?;
    let field = PlateSolver::new(mesh, PLATE, support)?.solve(&load(0.0))?;
    Ok(2.0 * field.energy_j / FORCE_N)
}

fn on_foundation() -> Result<PlateSolver, Box<dyn Error>> {
    let plate = PlateProperties {
        foundation_pa_m: PLATE.rigidity_n_m() / LENGTH_M.powi(4),
        ..PLATE
    };
    let square = rectangle(1.0, 1.0);
    let domain = Some(0.1);
    let mesh = PlateMesh::graded(&square, [0.5; 2], 2e-4, domain, MeshResolution::Default)?;
    Ok(PlateSolver::new(mesh, plate, Support::SimplySupported)?)
}

/// A row for a number over its closed form.
fn ratio(law: &str, expected: &str, error: f64, tolerance: f64, source: &'static str) -> Row {
    Row::judged(
        law,
        expected,
        format!("{:+.3} %", 100.0 * error),
        &format!("{} %", 100.0 * tolerance),
        source,
        error.abs() <= tolerance,
    )
}

pub(crate) fn rows() -> Rows {
    let mut rows = vec![Row::elsewhere(
        "V1 constant curvature",
        "exact",
        "unit test constant_curvature_is_exact",
    )];
    let d = PLATE.rigidity_n_m();
    let nu = PLATE.poisson_ratio;
    let disc = FORCE_N * 0.25 / (16.0 * PI * d);
    let held = disc * (3.0 + nu) / (1.0 + nu);
    let square = FORCE_N / d;
    let (held_by, clamped_by) = (Support::SimplySupported, Support::Clamped);
    for (law, formula, outline, support, n_nodes, closed, tolerance) in [
        (
            "V1 clamped disc",
            "Pa²/16πD",
            DISC,
            clamped_by,
            6000,
            disc,
            3e-3,
        ),
        (
            "V1 held disc",
            "(3+ν)Pa²/16π(1+ν)D",
            DISC,
            held_by,
            6000,
            held,
            3e-3,
        ),
        (
            "V1 clamped square",
            "0.005612 Pa²/D",
            SQUARE,
            clamped_by,
            10_000,
            0.005612 * square,
            1e-3,
        ),
        (
            "V1 held square",
            "0.0116008 Pa²/D",
            SQUARE,
            held_by,
            10_000,
            0.0116008 * square,
            1e-3,
        ),
    ] {
        let error = middle_m(&outline, support, n_nodes)? / closed - 1.0;
        rows.push(ratio(law, formula, error, tolerance, "Timoshenko1959"));
    }
    let solver = on_foundation()?;
    let field = solver.solve(&load(0.0))?;
    let foundation_pa_m = solver.properties().foundation_pa_m;
    let closed = FORCE_N / (8.0 * (foundation_pa_m * d).sqrt());
    let error = 2.0 * field.energy_j / FORCE_N / closed - 1.0;
    rows.push(ratio(
        "V1 plate on a foundation",
        "P/8√(kD)",
        error,
        4e-3,
        "Timoshenko1959",
    ));
    rows.push(under_the_patch()?);
    rows.extend(contact()?);
    rows.push(first_ring(&solver)?);
    Ok(rows)
}

/// V2: stress in the middle of a patch, thin and thick plate (Westergaard's radius).
fn under_the_patch() -> Result<Row, Box<dyn Error>> {
    let (a, nu, h) = (0.5, PLATE.poisson_ratio, PLATE.thickness_m);
    let mut worst: f64 = 0.0;
    for radius_m in [0.0, 0.2 * h, 0.5 * h, h, 3.0 * h, 10.0 * h] {
        let patch_m = if radius_m < 0.5 * h {
            (1.6 * radius_m * radius_m + h * h).sqrt() - 0.675 * h
        } else {
            radius_m
        };
        let mesh = PlateMesh::graded(
            &DISC,
            [0.5; 2],
            0.35 * patch_m,
            None,
            MeshResolution::Default,
        )?;
        let solver = PlateSolver::new(mesh, PLATE, Support::SimplySupported)?;
        let field = solver.solve(&load(patch_m))?;
        let stress = field
            .surface_stress_at(solver.mesh(), [0.5; 2], Face::Back, &mut 0)
            .unwrap_or_default();
        let moment = FORCE_N / (4.0 * PI) * ((1.0 + nu) * libm::log(a / patch_m) + 1.0);
        let error = stress.principal().0 / (6.0 * moment / (h * h)) - 1.0;
        worst = if error.abs() > worst.abs() {
            error
        } else {
            worst
        };
    }
    Ok(ratio(
        "V2 stress under a patch of 0 to 10 h, worst",
        "6/h² P/4π ((1+ν) ln(a/r) + 1)",
        worst,
        0.05,
        "Westergaard1926",
    ))
}

/// V3: contact on a rigid plate, and where the energy goes.
fn contact() -> Result<[Row; 2], Box<dyn Error>> {
    let glass = Material::soda_lime()?;
    let (mut worst, mut lost): (f64, f64) = (0.0, 0.0);
    for (speed, radius) in [(0.01, 0.2), (0.1, 5e-3), (1.0, 5e-5), (2.0, 5e-3)] {
        let stone = StoneImpact::granite([0.0; 2], speed, radius);
        // So thick that it does not give way.
        let load = contact_load(&stone, &glass, 1e4);
        let nu = glass.poisson_ratio.value;
        let compliance = (1.0 - stone.poisson_ratio.powi(2)) / stone.young_modulus_pa
            + (1.0 - nu * nu) / glass.young_modulus_pa.value;
        let stiffness = 4.0 / 3.0 * radius.sqrt() / compliance;
        let depth = libm::pow(1.25 * stone.mass_kg() * speed * speed / stiffness, 0.4);
        for (got, expected) in [
            (load.indentation_m, depth),
            (load.peak_force_n, stiffness * libm::pow(depth, 1.5)),
            (load.contact_time_s, 2.943_28 * depth / speed),
            (load.contact_radius_m, (radius * depth).sqrt()),
        ] {
            worst = worst.max((got / expected - 1.0).abs());
        }
    }
    for thickness_m in [0.5e-3, 2.1e-3, 6e-3, 19e-3] {
        for speed in [0.1, 1.0, 10.0, 100.0] {
            for radius in [0.5e-3, 3e-3, 20e-3] {
                let stone = StoneImpact::granite([0.0; 2], speed, radius);
                let load = contact_load(&stone, &glass, thickness_m);
                let after = load.rebound_energy_j
                    + load.plate_energy_j
                    + load.crushing_energy_j
                    + load.stored_energy_j;
                lost = lost.max((after / stone.kinetic_energy_j() - 1.0).abs());
            }
        }
    }
    Ok([
        ratio(
            "V3 contact with a rigid plate, worst of depth, force, time, radius",
            "Hertz: δ = (5mV²/4K)^0.4, …",
            worst,
            5e-3,
            "Hertz1882",
        ),
        Row::judged(
            "V3 energy of 48 hits on plates: stone, waves, crushing, contact",
            "½mV²",
            format!("off by {lost:.1e} at most"),
            "1e-6",
            "conservation",
            lost <= 1e-6,
        ),
    ])
}

/// V9: where the radial tension of the face that is hit is greatest.
fn first_ring(solver: &PlateSolver) -> Result<Row, Box<dyn Error>> {
    let field = solver.solve(&load(0.0))?;
    let mut hint = 0;
    let mut best = (0.0, 0.0);
    for k in 50..500 {
        let r = 0.01 * f64::from(k) * LENGTH_M;
        let mut mean = 0.0;
        for turn in 0..16 {
            let (sin, cos) = libm::sincos(2.0 * PI * f64::from(turn) / 16.0);
            let point = [0.5 + r * cos, 0.5 + r * sin];
            let stress = field
                .surface_stress_at(solver.mesh(), point, Face::Front, &mut hint)
                .unwrap_or_default();
            mean += stress.normal_pa([cos, sin]) / 16.0;
        }
        if mean > best.1 {
            best = (r / LENGTH_M, mean);
        }
    }
    Ok(Row::judged(
        "V9 greatest radial tension of the face that is hit",
        "2.03 ℓ",
        format!("{:.2} ℓ", best.0),
        "± 0.15 ℓ",
        "kei(r/ℓ) of a plate on a foundation",
        (best.0 - 2.03).abs() <= 0.15,
    ))
}
