//! Dynamic crack branching: a notched sheet of glass under a sudden traction.

use crate::body::Body;
use crate::lattice::{Lattice, as_f64};
use crate::material::Material;
use crate::random::Random;

/// The benchmark's glass [CabanaPD2022, crack_branching.json].
pub const GLASS: Material = Material {
    young_pa: 72e9,
    density_kg_m3: 2440.0,
    fracture_energy_j_m2: 3.8,
};

/// Traction on both long edges, Pa.
const TRACTION_PA: f64 = 2e6;
/// Nodes along the plate of 0.1 m × 0.04 m.
const N_X: usize = 400;
/// Nodes across.
const N_Y: usize = 160;
/// Node spacing, m.
const SPACING_M: f64 = 0.25e-3;
/// Horizon, m.
const HORIZON_M: f64 = 1e-3;
/// Step, s.
const STEP_S: f64 = 4.5e-8;
/// Number of steps: 43 µs.
const N_STEPS: usize = 956;
/// Steps between two looks at the tip.
const LOOK_STEPS: usize = 10;
/// A node is cracked when more than this part of its bonds is broken. A straight crack between two
/// rows of nodes breaks 0.38 of the bonds of the nodes beside it.
const CRACKED: f64 = 0.3;
/// Window of the largest tip speed, s: some ten node spacings of way.
const WINDOW_S: f64 = 2e-6;

/// What was measured.
#[derive(Clone, Debug)]
pub struct Branching {
    /// Where one crack has become two, m from the notched edge.
    pub fork_x_m: Option<f64>,
    /// Largest number of cracks side by side.
    pub n_branches: usize,
    /// Largest |y of the upper branch + y of the lower|, m; 0 when the branches mirror each other.
    pub asymmetry_m: f64,
    /// Way of the foremost tip over time, from its start to the end, m/s.
    pub mean_speed_m_s: f64,
    /// Largest speed over a window of 2 µs, m/s.
    pub peak_speed_m_s: f64,
    /// Times and places of the foremost tip: s, m from the notched edge, m from the middle.
    pub tips: Vec<[f64; 3]>,
    /// Damage of the nodes, row by row.
    pub damage: Vec<f64>,
    /// Nodes in a row of `damage`.
    pub n_x: usize,
}

/// Rayleigh wave speed for ν = 1/3, m/s: c_R = 0.919 c_s, the root of Rayleigh's equation
/// [Freund1990, eq. 2.5.2], in plane stress with c_l = √(E/(ρ(1−ν²))).
#[must_use]
pub fn rayleigh_speed_m_s(material: &Material) -> f64 {
    let shear = libm::sqrt(0.375 * material.young_pa / material.density_kg_m3);
    let long = libm::sqrt(1.125 * material.young_pa / material.density_kg_m3);
    // 4 α_l α_s − (1 + α_s²)² is positive below the root and negative above.
    let (mut low, mut high) = (0.5 * shear, 0.999_999 * shear);
    for _ in 0..60 {
        let speed = 0.5 * (low + high);
        let alpha_s2 = 1.0 - (speed / shear) * (speed / shear);
        let alpha_l2 = 1.0 - (speed / long) * (speed / long);
        let balance = 4.0 * libm::sqrt(alpha_s2 * alpha_l2) - (1.0 + alpha_s2) * (1.0 + alpha_s2);
        if balance > 0.0 {
            low = speed
        } else {
            high = speed
        }
    }
    0.5 * (low + high)
}

/// The sheet with its notch and loads, before the first step.
#[must_use]
pub fn notched_sheet() -> (Lattice, Body) {
    let lattice = Lattice::new(N_X, N_Y, SPACING_M, 0.0, &mut Random::new(0));
    let mut body = Body::default();
    // Plane stress: the thickness cancels.
    let thickness_m = 1.0;
    body.add_sheet(&lattice, 0.0, thickness_m, HORIZON_M, &GLASS);
    body.cut(|i, j| is_across_notch(&lattice, i, j));
    let half_m = 0.5 * SPACING_M * as_f64(N_Y);
    // The loaded edges cannot fail, as in the published input.
    body.protect(|i| lattice.y_m[i].abs() > half_m - HORIZON_M);
    let load_n = TRACTION_PA * SPACING_M * thickness_m;
    for column in 0..N_X {
        body.load_n[1][column] = -load_n;
        body.load_n[1][lattice.len() - N_X + column] = load_n;
    }
    (lattice, body)
}

/// Whether the line between two nodes crosses the notch: y = 0, x < 0 (the middle is the origin).
fn is_across_notch(lattice: &Lattice, i: usize, j: usize) -> bool {
    let (y_i, y_j) = (lattice.y_m[i], lattice.y_m[j]);
    if y_i * y_j >= 0.0 {
        return false;
    }
    let at = y_i / (y_i - y_j);
    lattice.x_m[i] + at * (lattice.x_m[j] - lattice.x_m[i]) < 0.0
}

/// Runs the benchmark and measures its crack.
#[must_use]
pub fn run() -> Branching {
    let (lattice, mut body) = notched_sheet();
    let left_m = 0.5 * SPACING_M * as_f64(N_X);
    let mut tips = Vec::new();
    for step in 0..N_STEPS {
        body.step(STEP_S);
        if (step + 1) % LOOK_STEPS == 0 {
            let tip = foremost(&lattice, &body);
            tips.push([as_f64(step + 1) * STEP_S, tip.0 + left_m, tip.1]);
        }
    }
    let damage: Vec<f64> = (0..body.len()).map(|i| body.damage(i)).collect();
    let (mean_speed_m_s, peak_speed_m_s) = speeds(&tips);
    let tip_column = damage
        .iter()
        .enumerate()
        .filter(|(_, damage)| **damage > CRACKED)
        .map(|(i, _)| i % N_X)
        .max()
        .unwrap_or(0);
    let fork = fork(&damage, N_X, tip_column);
    Branching {
        fork_x_m: fork.column.map(|column| (as_f64(column) + 0.5) * SPACING_M),
        n_branches: fork.n_branches,
        asymmetry_m: fork.asymmetry_rows * SPACING_M,
        mean_speed_m_s,
        peak_speed_m_s,
        tips,
        damage,
        n_x: N_X,
    }
}

/// The cracked node farthest from the notched edge: x, |y|, m.
fn foremost(lattice: &Lattice, body: &Body) -> (f64, f64) {
    let mut tip = (0.0, 0.0);
    for i in 0..body.len() {
        if lattice.x_m[i] > tip.0 && body.damage(i) > CRACKED {
            tip = (lattice.x_m[i], lattice.y_m[i].abs());
        }
    }
    tip
}

/// Mean speed from the first advance to the end, and the largest over a window, m/s. The way is
/// that of the chord over a window, so that steps between rows do not lengthen it.
fn speeds(tips: &[[f64; 3]]) -> (f64, f64) {
    let chord = |a: &[f64; 3], b: &[f64; 3]| libm::hypot(b[1] - a[1], b[2] - a[2]);
    let Some(start) = tips.windows(2).position(|pair| pair[1][1] > pair[0][1]) else {
        return (0.0, 0.0);
    };
    let running = &tips[start..];
    let look_s = as_f64(LOOK_STEPS) * STEP_S;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few looks"
    )]
    let window = (WINDOW_S / look_s).ceil() as usize;
    let peak = running
        .windows(window + 1)
        .map(|span| chord(&span[0], &span[window]) / (span[window][0] - span[0][0]))
        .fold(0.0, f64::max);
    let mut way = 0.0;
    let mut from = running[0];
    for tip in running.iter().skip(window).step_by(window) {
        way += chord(&from, tip);
        from = *tip;
    }
    (way / (from[0] - running[0][0]), peak)
}

/// What a damage field says about its fork.
struct Fork {
    column: Option<usize>,
    n_branches: usize,
    asymmetry_rows: f64,
}

/// The first column from which on, up to the tip, the cracked rows form at least two groups with
/// intact rows between them. The last three columns before the tip are left out: there one branch may
/// be a node ahead.
fn fork(damage: &[f64], n_x: usize, tip_column: usize) -> Fork {
    let n_y = damage.len() / n_x;
    let mut fork = Fork {
        column: None,
        n_branches: 0,
        asymmetry_rows: 0.0,
    };
    for column in 0..tip_column.saturating_sub(3) {
        let groups = groups(damage, n_x, column);
        fork.n_branches = fork.n_branches.max(groups.len());
        if groups.len() < 2 {
            fork.column = None;
            fork.asymmetry_rows = 0.0;
            continue;
        }
        fork.column.get_or_insert(column);
        let (low, high) = (groups[0], groups[groups.len() - 1]);
        let middles = 0.5 * as_f64(low.0 + low.1 + high.0 + high.1);
        fork.asymmetry_rows = fork.asymmetry_rows.max((middles - as_f64(n_y - 1)).abs());
    }
    fork
}

/// Runs of cracked rows of a column: first and last row of each.
fn groups(damage: &[f64], n_x: usize, column: usize) -> Vec<(usize, usize)> {
    let mut groups: Vec<(usize, usize)> = Vec::new();
    for row in (0..damage.len() / n_x).filter(|row| damage[row * n_x + column] > CRACKED) {
        match groups.last_mut() {
            Some(last) if last.1 + 1 == row => last.1 = row,
            _ => groups.push((row, row)),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rayleigh_speed_of_a_third() {
        // Viktorov's approximation (0.87 + 1.12ν)/(1 + ν) with the ν* of plane strain that has the
        // same ratio c_l/c_s: ν* = ν/(1 + ν) = 1/4.
        let shear = libm::sqrt(0.375 * GLASS.young_pa / GLASS.density_kg_m3);
        let ratio = rayleigh_speed_m_s(&GLASS) / shear;
        assert!(
            (ratio - 0.9194).abs() < 1e-3,
            "c_R/c_s for c_l²/c_s² = 3 is 0.9194, got {ratio}"
        );
    }

    #[test]
    fn the_fork_of_a_drawn_y() {
        let (n_x, n_y) = (40, 21);
        let mut damage = vec![0.0; n_x * n_y];
        for column in 0..38_usize {
            let off = column.saturating_sub(20) / 2;
            damage[(10 + off) * n_x + column] = 0.5;
            damage[(10 - off) * n_x + column] = 0.5;
        }
        let fork = fork(&damage, n_x, 37);
        assert_eq!(fork.column, Some(22), "off by one row at 22");
        assert_eq!(fork.n_branches, 2, "two");
        assert!(fork.asymmetry_rows < 1e-12, "a mirror image");
    }

    #[test]
    fn the_speed_of_a_steady_tip() {
        let tips: Vec<_> = (0..100_u32)
            .map(|look| {
                let t = f64::from(look) * as_f64(LOOK_STEPS) * STEP_S;
                [t, 0.05 + 1400.0 * (t - 1e-5).max(0.0), 0.0]
            })
            .collect();
        let (mean, peak) = speeds(&tips);
        assert!((mean - 1400.0).abs() < 20.0, "{mean}");
        assert!((peak - 1400.0).abs() < 1e-6, "{peak}");
    }
}
