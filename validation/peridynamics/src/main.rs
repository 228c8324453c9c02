//! Prints the checks of the oracle; exit code 1 if one fails.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use starbreak_peridynamics::branching;
use starbreak_peridynamics::lattice::as_f64;
use starbreak_peridynamics::material::Material;
use starbreak_peridynamics::picture::write_damage;
use starbreak_peridynamics::plate::{self, Impact};
use starbreak_peridynamics::star::n_arms;
use starbreak_peridynamics::table::{Check, Table, exponent};

const USAGE: &str = "usage: starbreak-peridynamics [in-plane|bilayer|all] [--pictures FOLDER]";

/// Speeds on acrylic glass, m/s.
const PMMA_SPEEDS_M_S: [f64; 5] = [15.0, 22.0, 32.0, 45.0, 57.0];
/// Speeds on glass, m/s.
const GLASS_SPEEDS_M_S: [f64; 2] = [1.5, 3.0];
/// Seeds per speed on acrylic glass.
const PMMA_SEEDS: u64 = 4;
/// Seeds per speed on glass.
const GLASS_SEEDS: u64 = 2;
/// An arm is counted as one however it forks outside this radius: five thicknesses.
const OUTER_M: f64 = 5.0 * plate::THICKNESS_M;
/// An arm stands out by at least a thickness.
const PROMINENCE_M: f64 = plate::THICKNESS_M;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (what, folder) = match words[..] {
        [what] => (what, None),
        [what, "--pictures", folder] => (what, Some(PathBuf::from(folder))),
        _ => ("", None),
    };
    let run = |what: &str| match what {
        "in-plane" => in_plane(folder.as_deref()),
        "bilayer" => bilayer(folder.as_deref()),
        "all" => {
            let mut table = in_plane(folder.as_deref())?;
            table.checks.extend(bilayer(folder.as_deref())?.checks);
            Ok(table)
        }
        _ => Err(io::Error::other(USAGE)),
    };
    let done = run(what).and_then(|table| {
        write!(io::stdout(), "{table}")?;
        Ok(table.holds())
    });
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            // Nothing is left to do if even this cannot be written.
            let _ = writeln!(io::stderr(), "{error}");
            ExitCode::from(2)
        }
    }
}

/// Dynamic crack branching.
fn in_plane(folder: Option<&Path>) -> io::Result<Table> {
    let crack = branching::run();
    if let Some(folder) = folder {
        save(folder, "in-plane.png", &crack.damage, crack.n_x)?;
    }
    let benchmark = "earlier run, inputs of CabanaPD2022";
    let fork_mm = crack.fork_x_m.map(|x_m| 1e3 * x_m);
    let rayleigh_m_s = branching::rayleigh_speed_m_s(&branching::GLASS);
    let checks = vec![
        Check::new(
            "in-plane: cracks side by side",
            "2",
            crack.n_branches.to_string(),
            "exact",
            benchmark,
        )
        .judged(crack.n_branches == 2),
        Check::new(
            "in-plane: place of the fork",
            "69 mm",
            fork_mm.map_or_else(|| "none".to_owned(), |x| format!("{x:.1} mm")),
            "± 3 mm",
            benchmark,
        )
        .judged(fork_mm.is_some_and(|x| (66.0..=72.0).contains(&x))),
        Check::new(
            "in-plane: branches mirror each other",
            "0 mm",
            format!("{:.2} mm", 1e3 * crack.asymmetry_m),
            "1 mm (horizon)",
            "symmetry",
        )
        .judged(crack.asymmetry_m <= 1e-3),
        Check::new(
            "in-plane: mean tip speed",
            "1350 m/s",
            format!("{:.0} m/s", crack.mean_speed_m_s),
            "± 150 m/s",
            benchmark,
        )
        .judged((1200.0..=1500.0).contains(&crack.mean_speed_m_s)),
        Check::new(
            "in-plane: peak tip speed over 2 us",
            &format!("< {rayleigh_m_s:.0} m/s (Rayleigh)"),
            format!("{:.0} m/s", crack.peak_speed_m_s),
            "bound",
            "Freund1990",
        )
        .judged(crack.peak_speed_m_s < rayleigh_m_s),
    ];
    Ok(Table { checks })
}

/// Number of radial cracks against impact speed.
fn bilayer(folder: Option<&Path>) -> io::Result<Table> {
    let source = "Vandenberghe2013";
    let mut table = Table::default();
    let mut points = Vec::new();
    for speed_m_s in PMMA_SPEEDS_M_S {
        let counts = stars(folder, "pmma", plate::PMMA, speed_m_s, PMMA_SEEDS)?;
        points.extend(counts.iter().map(|&n| (speed_m_s, as_f64(n.max(1)))));
        let measured = match speed_m_s {
            22.0 => "4 measured at 22.2 m/s",
            57.0 => "8 measured at 56.7 m/s",
            _ => "reported",
        };
        table.checks.push(count_row(
            "PMMA",
            &plate::PMMA,
            speed_m_s,
            &counts,
            measured,
            source,
        ));
    }
    let (slope, error) = exponent(&points);
    table.checks.push(
        Check::new(
            "bilayer: exponent of n over V, PMMA",
            "0.5",
            format!("{slope:.2} (standard error {error:.2})"),
            "± 0.1",
            source,
        )
        .judged((slope - 0.5).abs() <= 0.1),
    );
    for speed_m_s in GLASS_SPEEDS_M_S {
        let counts = stars(folder, "glass", plate::GLASS, speed_m_s, GLASS_SEEDS)?;
        table.checks.push(count_row(
            "glass",
            &plate::GLASS,
            speed_m_s,
            &counts,
            "reported",
            "-",
        ));
    }
    Ok(table)
}

/// The numbers of arms for the seeds 1, 2, …
fn stars(
    folder: Option<&Path>,
    name: &str,
    material: Material,
    speed_m_s: f64,
    n_seeds: u64,
) -> io::Result<Vec<usize>> {
    (1..=n_seeds)
        .map(|seed| {
            let plate = plate::strike(&Impact {
                material,
                speed_m_s,
                seed,
            });
            let damage = plate.damage();
            if let Some(folder) = folder {
                let (below, above) = ("below", "above");
                for (face, damage) in [(below, &damage), (above, &plate.damage_above())] {
                    let file = format!("{name}-{speed_m_s}-{seed}-{face}.png");
                    save(folder, &file, damage, plate.lattice.n_x)?;
                }
            }
            Ok(n_arms(&plate.lattice, &damage, OUTER_M, PROMINENCE_M))
        })
        .collect()
}

/// The mean number of arms, and C of n = C (V/c)^½ (Eh/Γ)^¼.
fn count_row(
    name: &str,
    material: &Material,
    speed_m_s: f64,
    counts: &[usize],
    expected: &str,
    source: &str,
) -> Check {
    let mean = as_f64(counts.iter().sum()) / as_f64(counts.len());
    let group = material.young_pa * plate::THICKNESS_M / material.fracture_energy_j_m2;
    let scale = libm::sqrt(speed_m_s / material.bar_speed_m_s() * libm::sqrt(group));
    let each: Vec<String> = counts.iter().map(usize::to_string).collect();
    Check::new(
        &format!("bilayer: radial cracks, {name}, {speed_m_s} m/s"),
        expected,
        format!("{mean:.1} ({}), C = {:.1}", each.join(" "), mean / scale),
        "-",
        source,
    )
}

fn save(folder: &Path, file: &str, damage: &[f64], n_x: usize) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    write_damage(&folder.join(file), damage, n_x, 3)
}
