//! The tip law in fields that are known in closed form.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;

use starbreak_glass::{Material, SegmentKind};
use starbreak_seed::Seed;

use super::*;
use crate::mesh::Outline;
use crate::stress::{PlaneStress, StressField};

/// A field given by a formula.
struct Formula<F>(F);

impl<F: Fn([f64; 2]) -> PlaneStress> StressField for Formula<F> {
    fn stress_at(&self, point_m: [f64; 2], _: &mut u32) -> Option<PlaneStress> {
        Some((self.0)(point_m))
    }
}

fn uniform_stress(xx: f64, yy: f64, xy: f64) -> PlaneStress {
    PlaneStress {
        xx_pa: xx,
        yy_pa: yy,
        xy_pa: xy,
    }
}

const SIDE_M: f64 = 1.0;

fn web() -> Web {
    Web::new(Outline::Rectangle {
        width_m: SIDE_M,
        height_m: SIDE_M,
    })
}

fn tracing(law: TipLaw, forks: bool) -> Tracing {
    Tracing {
        law,
        motion: Motion::Dynamic,
        step_m: [1e-4, 5e-4],
        forks,
        competition: COMPETITION,
        rim_shields: false,
    }
}

fn law(thickness_m: f64, is_bent: bool) -> TipLaw {
    TipLaw::new(&Material::soda_lime().unwrap(), thickness_m, is_bent)
}

fn endless() -> Ledger {
    Ledger {
        available_j: 1e9,
        dissipated_j: 0.0,
        steps_left: MAX_STEPS,
    }
}

/// Runs one tip from a point and gives its path.
fn path(
    field: &dyn StressField,
    start: [f64; 2],
    direction: [f64; 2],
    length_m: f64,
    tracing: &Tracing,
    seed: u64,
) -> (Web, Vec<Tip>) {
    let mut web = web();
    let node = web.add_node(start);
    let tip = Tip::new(
        &mut web,
        Seed(seed),
        (SegmentKind::Radial, None),
        node,
        direction,
        length_m,
        0.0,
    );
    let mut tips = vec![tip];
    trace(
        &mut web,
        &mut tips,
        field,
        tracing,
        &mut endless(),
        Seed(seed),
        f64::INFINITY,
    );
    (web, tips)
}

#[test]
fn a_crack_runs_straight_across_uniform_tension() {
    let field = Formula(|_| uniform_stress(10e6, 0.0, 0.0));
    for seed in 0..20 {
        let (web, tips) = path(
            &field,
            [0.5, 0.1],
            [0.0, 1.0],
            0.02,
            &tracing(law(4e-3, false), false),
            seed,
        );
        let [x, y] = tips[0].at_m;
        assert!(y > 0.999, "it reaches the rim, not only {y}");
        let angle = libm::atan2(x - 0.5, y - 0.1).to_degrees();
        assert!(angle.abs() < 0.5, "seed {seed}: {angle} degrees off");
        assert!(web.pieces.len() > 1000, "in small steps");
    }
}

#[test]
fn a_crack_under_shear_runs_at_45_degrees() {
    // σ_I = τ at 45° from x, so the crack runs at 135°.
    let field = Formula(|_| uniform_stress(0.0, 0.0, 20e6));
    for seed in 0..20 {
        let (_, tips) = path(
            &field,
            [0.5, 0.5],
            unit(PI - 0.3),
            0.02,
            &tracing(law(4e-3, false), false),
            seed,
        );
        let [x, y] = tips[0].at_m;
        // The first bend takes a way of a thickness; after it the direction counts.
        let angle = libm::atan2(y - 0.5, 0.5 - x).to_degrees();
        assert!((angle - 45.0).abs() < 1.0, "seed {seed}: {angle} degrees");
    }
}

/// Stress around a hole of radius a in a plate under uniform tension S along x \[Kirsch1898\].
fn kirsch([x, y]: [f64; 2], a: f64, s: f64) -> PlaneStress {
    let (r, theta) = (libm::hypot(x, y), libm::atan2(y, x));
    let (q, cos2, sin2) = (
        (a / r).powi(2),
        libm::cos(2.0 * theta),
        libm::sin(2.0 * theta),
    );
    let rr = 0.5 * s * (1.0 - q) + 0.5 * s * (1.0 - 4.0 * q + 3.0 * q * q) * cos2;
    let tt = 0.5 * s * (1.0 + q) - 0.5 * s * (1.0 + 3.0 * q * q) * cos2;
    let rt = -0.5 * s * (1.0 + 2.0 * q - 3.0 * q * q) * sin2;
    let (sin, cos) = libm::sincos(theta);
    uniform_stress(
        rr * cos * cos + tt * sin * sin - 2.0 * rt * sin * cos,
        rr * sin * sin + tt * cos * cos + 2.0 * rt * sin * cos,
        (rr - tt) * sin * cos + rt * (cos * cos - sin * sin),
    )
}

#[test]
fn a_crack_past_a_hole_follows_the_principal_trajectory() {
    let (a, s, h) = (0.1, 10e6, 2e-3);
    let hole = [0.5, 0.5];
    let stress = |[x, y]: [f64; 2]| kirsch([x - hole[0], y - hole[1]], a, s);
    // Trajectory across σ_I by classical Runge-Kutta in the closed form, in steps of 10 µm.
    let start = [0.5 - 0.11, 0.15];
    let slope = |p: [f64; 2]| crack_direction(&stress(p), [0.0, 1.0]);
    let mut trajectory = vec![start];
    let step = 1e-5;
    while trajectory[trajectory.len() - 1][1] < 0.9 {
        let p = trajectory[trajectory.len() - 1];
        let at = |k: [f64; 2], part: f64| [p[0] + k[0] * part * step, p[1] + k[1] * part * step];
        let k1 = slope(p);
        let k2 = slope(at(k1, 0.5));
        let k3 = slope(at(k2, 0.5));
        let k4 = slope(at(k3, 1.0));
        trajectory.push([
            p[0] + step / 6.0 * (k1[0] + 2.0 * k2[0] + 2.0 * k3[0] + k4[0]),
            p[1] + step / 6.0 * (k1[1] + 2.0 * k2[1] + 2.0 * k3[1] + k4[1]),
        ]);
    }
    let bend = trajectory
        .iter()
        .map(|p| (p[0] - start[0]).abs())
        .fold(0.0, f64::max);
    assert!(bend > 0.01, "the hole bends the way, by {bend} m");
    let field = Formula(stress);
    let (web, _) = path(
        &field,
        start,
        slope(start),
        0.01,
        &tracing(law(h, false), false),
        3,
    );
    let mut worst: f64 = 0.0;
    for &[x, y] in web.nodes.iter().filter(|[_, y]| *y < 0.9) {
        let nearest = trajectory
            .iter()
            .filter(|p| (p[1] - y).abs() < 5e-3)
            .map(|p| libm::hypot(p[0] - x, p[1] - y))
            .fold(f64::INFINITY, f64::min);
        worst = worst.max(nearest);
    }
    // One edge of the default mesh at this distance (0.05 r).
    assert!(worst < 5e-3, "{worst} m off");
}

/// A star of n equal arms in a hoop stress S (r₀/r).
fn star(n: u32, s: f64, r0: f64, h: f64) -> (Vec<f64>, TipLaw) {
    let law = law(h, true);
    let center = [0.5, 0.5];
    let field = Formula(move |[x, y]: [f64; 2]| {
        let (dx, dy) = (x - center[0], y - center[1]);
        let r = libm::hypot(dx, dy);
        let hoop = s * r0 / r;
        let (ex, ey) = (-dy / r, dx / r);
        uniform_stress(hoop * ex * ex, hoop * ey * ey, hoop * ex * ey)
    });
    let mut web = web();
    let start_m = 2e-3;
    let mut tips = Vec::new();
    for k in 0..n {
        let direction = unit(2.0 * PI * f64::from(k) / f64::from(n));
        let node = web.add_node([
            center[0] + direction[0] * start_m,
            center[1] + direction[1] * start_m,
        ]);
        let kind = SegmentKind::Radial;
        let mut tip = Tip::new(
            &mut web,
            Seed(1),
            (kind, None),
            node,
            direction,
            start_m,
            0.0,
        );
        tip.origin_m = center;
        tips.push(tip);
    }
    let mut tracing = tracing(law, false);
    tracing.step_m = [2e-5, 5e-5];
    tracing.competition = 0.0;
    trace(
        &mut web,
        &mut tips,
        &field,
        &tracing,
        &mut endless(),
        Seed(1),
        f64::INFINITY,
    );
    let radii = tips
        .iter()
        .map(|tip| libm::hypot(tip.at_m[0] - center[0], tip.at_m[1] - center[1]))
        .collect();
    (radii, law)
}

#[test]
fn a_star_arrests_where_k_falls_to_toughness() {
    for (n, s) in [(4, 60e6), (6, 100e6), (12, 200e6), (16, 250e6)] {
        let (r0, h) = (2e-3, 2e-3);
        let (radii, law) = star(n, s, r0, h);
        // K = S r0/(q r) √(min(1.5 f π r, 0.95 · 2πr/n)) is K_IC at one r.
        let n = f64::from(n);
        let q = (0.64 + 0.035 * n).min(1.0);
        let per_r = (1.5 * law.shape_factor * PI).min(0.95 * 2.0 * PI / n);
        let expected = per_r * (s * r0 / (q * law.toughness_pa_sqrt_m)).powi(2);
        let mean = radii.iter().sum::<f64>() / n;
        assert!(
            (mean / expected - 1.0).abs() < 0.02,
            "n = {n}: {mean} m instead of {expected} m"
        );
    }
}

#[test]
fn the_way_to_a_fork_falls_with_the_square_of_stress() {
    let mut points = Vec::new();
    let mut ratios = Vec::new();
    for k in 0..6 {
        let s = 10e6 * 1.4_f64.powi(k);
        for seed in 0..40 {
            let field = Formula(move |_| uniform_stress(s, 0.0, 0.0));
            let law = law(1e-3, false);
            let mut tracing = tracing(law, true);
            tracing.step_m = [2e-6, 1e-4];
            let start_m = 1e-4_f64.max(1.2 * (law.toughness_pa_sqrt_m / s).powi(2) / PI);
            let (web, _) = path(&field, [0.5, 0.2], [0.0, 1.0], start_m, &tracing, seed);
            let first = web
                .pieces
                .iter()
                .find(|piece| piece.kind == SegmentKind::Fork);
            let Some(first) = first else { continue };
            let distance = first.along_m[0] + start_m;
            points.push((s.ln(), distance.ln()));
            ratios.push(distance * s * s);
        }
    }
    assert!(points.len() > 200, "they fork");
    let n = f64::from(u32::try_from(points.len()).unwrap());
    let (mx, my) = points
        .iter()
        .fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let cov: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let var: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let slope = cov / var;
    assert!((slope + 2.0).abs() < 0.05, "slope {slope}");
    let mean = ratios.iter().sum::<f64>() / n;
    let scatter = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt() / mean;
    assert!((0.09..0.15).contains(&scatter), "scatter {scatter}");
    // r_b = (A_b/σ)² with A_b = 2.0 MPa √m.
    let constant = mean.sqrt() * 1e-6;
    assert!((constant - 2.03).abs() < 0.1, "A_b = {constant} MPa √m");
}

#[test]
fn tips_are_never_faster_than_glass_allows_and_seldom_slower_under_strong_stress() {
    let field = Formula(|_| uniform_stress(60e6, 60e6, 0.0));
    let law = law(4e-3, false);
    let (web, _) = path(&field, [0.5, 0.5], [0.0, 1.0], 1e-3, &tracing(law, true), 5);
    let (mut way, mut time) = (0.0, 0.0);
    for piece in &web.pieces {
        let (dx, dt) = (
            piece.along_m[1] - piece.along_m[0],
            piece.time_s[1] - piece.time_s[0],
        );
        assert!(dx <= 1500.0 * dt * (1.0 + 1e-9) + 1e-12, "{} m/s", dx / dt);
        way += dx;
        time += dt;
    }
    let mean = way / time;
    assert!((1300.0..1500.001).contains(&mean), "mean {mean} m/s");
}

#[test]
fn the_ledger_is_never_overdrawn() {
    let field = Formula(|_| uniform_stress(60e6, 60e6, 0.0));
    let law = law(4e-3, false);
    let mut web = web();
    let node = web.add_node([0.5, 0.5]);
    let kind = SegmentKind::Radial;
    let mut tips = vec![Tip::new(
        &mut web,
        Seed(1),
        (kind, None),
        node,
        [1.0, 0.0],
        1e-3,
        0.0,
    )];
    let mut ledger = Ledger {
        available_j: 1e-2,
        dissipated_j: 0.0,
        steps_left: MAX_STEPS,
    };
    trace(
        &mut web,
        &mut tips,
        &field,
        &tracing(law, true),
        &mut ledger,
        Seed(1),
        f64::INFINITY,
    );
    let length: f64 = web.pieces.iter().map(|p| p.along_m[1] - p.along_m[0]).sum();
    let cost = length * law.fracture_energy_j_m2 * law.thickness_m;
    assert!(
        (cost - ledger.dissipated_j).abs() < 1e-9,
        "what was paid was made"
    );
    assert!(ledger.dissipated_j <= ledger.available_j, "not overdrawn");
    assert!(
        ledger.dissipated_j > 0.99 * ledger.available_j,
        "spent, in this strong field"
    );
}

#[test]
fn tips_end_at_cracks_and_share_a_node_with_them() {
    let field = Formula(|_| uniform_stress(10e6, 0.0, 0.0));
    let mut web = web();
    let wall: Vec<u32> = [[0.1, 0.6], [0.9, 0.6]]
        .iter()
        .map(|&p| web.add_node(p))
        .collect();
    let crack = web.new_crack(None);
    web.add_piece(Piece {
        a: wall[0],
        b: wall[1],
        crack,
        kind: SegmentKind::Edge,
        time_s: [0.0, 0.0],
        along_m: [0.0, 0.8],
        stress_pa: 0.0,
        intensity_pa_sqrt_m: 0.0,
        effective_m: 0.0,
        tilt_rad: [0.0; 2],
    });
    let node = web.add_node([0.5, 0.3]);
    let mut tips = vec![Tip::new(
        &mut web,
        Seed(2),
        (SegmentKind::Radial, None),
        node,
        [0.0, 1.0],
        0.02,
        0.0,
    )];
    let plan = tracing(law(4e-3, false), false);
    trace(
        &mut web,
        &mut tips,
        &field,
        &plan,
        &mut endless(),
        Seed(2),
        f64::INFINITY,
    );
    assert_eq!(tips[0].state, TipState::Ended, "it is over");
    assert!((tips[0].at_m[1] - 0.6).abs() < 1e-9, "at the wall");
    let shared = web
        .pieces
        .iter()
        .filter(|piece| {
            piece.crack == crack && (piece.a == tips[0].node || piece.b == tips[0].node)
        })
        .count();
    assert_eq!(shared, 2, "the wall is divided at the node of the tip");
}

#[test]
fn corrosion_runs_only_under_load() {
    let field = Formula(|_| uniform_stress(5e6, 0.0, 0.0));
    let mut plan = tracing(law(4e-3, false), false);
    plan.motion = Motion::Corrosion { period_s: 10.0 };
    plan.step_m = [1e-4, 1e-3];
    // K = 0.4 MPa √m at the start: slow, then faster and faster.
    let (web, _) = path(&field, [0.5, 0.2], [0.0, 1.0], 2e-3, &plan, 1);
    assert!(web.pieces.len() > 10, "it grows");
    let speeds: Vec<f64> = web
        .pieces
        .iter()
        .map(|p| (p.along_m[1] - p.along_m[0]) / (p.time_s[1] - p.time_s[0]))
        .collect();
    assert!(
        speeds[0] < 1e-3,
        "below toughness it creeps, {} m/s",
        speeds[0]
    );
    assert!(web.pieces[0].time_s[1] > 1.0, "which takes seconds");
}
