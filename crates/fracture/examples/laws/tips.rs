//! V4 to V8: how many radials, how fast, where they fork, how straight; on finished networks.

use std::error::Error;

use starbreak_fracture::mesh::Outline;
use starbreak_fracture::physics::{
    Broken, GlassBuild, GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad,
    MeshResolution, PhysicsParams, StoneImpact, Support, mean_radial_count, simulate,
};
use starbreak_glass::{Material, SegmentKind};
use starbreak_seed::Seed;

use crate::measures::network::{fastest_tip_m_s, mean};
use crate::measures::panes::{pane, rectangle};
use crate::table::{Row, Rows, exponent};

/// Seeds of V4.
const N_SEEDS: u64 = 200;

/// Acrylic glass; handbook values, Γ = 500 J/m².
const PMMA: &str = r#"{
    "name": "acrylic glass",
    "young_modulus_pa": {"value": 4.5e9, "source": "-", "note": ""},
    "poisson_ratio": {"value": 0.35, "source": "-", "note": ""},
    "density_kg_m3": {"value": 1190.0, "source": "-", "note": ""},
    "fracture_toughness_pa_sqrt_m": {"value": 1.5e6, "source": "-", "note": ""},
    "ior": {"value": 1.49, "source": "-", "note": ""}
}"#;

pub(crate) fn rows() -> Rows {
    let mut rows = counts()?;
    rows.extend(acrylic()?);
    rows.push(Row::elsewhere(
        "V5 where a star comes to rest",
        "root of K(r) = K_IC to 2 %",
        "unit test a_star_arrests",
    ));
    rows.extend(long_cracks()?);
    for (law, expected, test) in [
        (
            "V8 crack under shear",
            "45° ± 1°",
            "unit test a_crack_under_shear",
        ),
        (
            "V8 crack past a hole",
            "principal trajectory to an edge",
            "unit test a_crack_past_a_hole",
        ),
    ] {
        rows.push(Row::elsewhere(law, expected, test));
    }
    Ok(rows)
}

/// The hit and its first solution alone, which is when radials are drawn.
fn params() -> PhysicsParams {
    PhysicsParams {
        mesh: MeshResolution::Fast,
        epochs: 1,
        ..PhysicsParams::default()
    }
}

/// V4: a thin free pane of glass, 10 to 80 m/s.
fn counts() -> Rows {
    let glass = pane(rectangle(1.4, 0.8), 1e-3, GlassBuild::Annealed)?;
    let (mut drawn, mut kept) = (Vec::new(), Vec::new());
    let mut text = String::new();
    for speed_m_s in [10.0, 14.0, 20.0, 28.0, 40.0, 57.0, 80.0] {
        let factor = params().radial_count_factor;
        let law = mean_radial_count(&glass.material, glass.thickness_m, speed_m_s, factor);
        drawn.push((speed_m_s, law));
        let stone = StoneImpact::granite([0.7, 0.4], speed_m_s, 3e-3);
        let mut arms = Vec::new();
        for seed in 0..N_SEEDS {
            let broken = simulate(&glass, &[stone], None, &params(), Seed(seed), |_| ())?;
            arms.push(broken.impacts[0].n_arms);
        }
        let n = mean(arms.iter().map(|&n| count(n)));
        kept.extend(arms.into_iter().map(|n| (speed_m_s, n)));
        text.push_str(&format!(" {n:.1}/{law:.1}"));
    }
    let n_whole = kept.iter().filter(|&&(_, n)| n == 0).count();
    let points: Vec<(f64, f64)> = kept
        .iter()
        .filter(|&&(_, n)| n > 0)
        .map(|&(speed, n)| (speed, count(n)))
        .collect();
    let slopes = [exponent(&drawn), exponent(&points)];
    Ok(vec![
        Row::judged(
            "V4 exponent of n over V, 10-80 m/s: mean before culling",
            "0.50",
            format!("{:.4}", slopes[0]),
            "± 0.05",
            "Vandenberghe2013",
            (slopes[0] - 0.5).abs() <= 0.05,
        ),
        Row::report(
            "V4 exponent of n over V, 10-80 m/s, 200 seeds: arms after culling",
            "-",
            format!(
                "{:.3}; {n_whole} of {} hits made none",
                slopes[1],
                kept.len()
            ),
            "Vandenberghe2013",
        ),
        Row::report(
            "V4 arms of networks / mean of the law at 10 14 20 28 40 57 80 m/s",
            "no more than the law",
            text.trim().to_owned(),
            "-",
        ),
        Row::elsewhere(
            "V4 exponent with a peridynamic plate",
            "0.5 ± 0.1",
            "peridynamics.txt",
        ),
    ])
}

#[expect(clippy::cast_precision_loss, reason = "a small count")]
fn count(n: usize) -> f64 {
    n as f64
}

/// V4: 1 mm of acrylic glass under a steel ball of 4 mm.
fn acrylic() -> Rows {
    let material = Material::from_json(PMMA)?;
    let plate = GlassPane {
        outline: rectangle(0.15, 0.15),
        thickness_m: 1e-3,
        build: GlassBuild::Annealed,
        support: Support::SimplySupported,
        material,
    };
    // Handbook values: a tensile strength of 75 MPa that scatters by a few percent.
    let acrylic_params = PhysicsParams {
        strength_pa: 75e6,
        weibull_modulus: 20.0,
        ..params()
    };
    let mut rows = Vec::new();
    for (speed_m_s, expected, tolerance) in [(22.2, 4.0, 1.0), (56.7, 7.0, 1.5)] {
        let stone = StoneImpact {
            density_kg_m3: 7850.0,
            young_modulus_pa: 210e9,
            poisson_ratio: 0.3,
            ..StoneImpact::granite([0.075; 2], speed_m_s, 2e-3)
        };
        let mut arms = Vec::new();
        for seed in 0..N_SEEDS {
            let broken = simulate(&plate, &[stone], None, &acrylic_params, Seed(seed), |_| ())?;
            arms.push(count(broken.impacts[0].n_arms));
        }
        let factor = params().radial_count_factor;
        let law = mean_radial_count(&plate.material, 1e-3, speed_m_s, factor);
        let n_whole = arms.iter().filter(|&&n| n < 1.0).count();
        let kept = mean(arms.iter().copied().filter(|&n| n > 0.0));
        rows.push(Row::judged(
            &format!("V4 acrylic glass, 1 mm, {speed_m_s} m/s: mean before culling"),
            &format!("{expected}"),
            format!("{law:.2}"),
            &format!("± {tolerance}"),
            "Vandenberghe2013",
            (law - expected).abs() <= tolerance,
        ));
        rows.push(Row::report(
            &format!("V4 acrylic glass, 1 mm, {speed_m_s} m/s: arms after culling"),
            &format!("{expected}"),
            format!("{kept:.2}; {n_whole} of {N_SEEDS} hits made none"),
            "Vandenberghe2013",
        ));
    }
    Ok(rows)
}

/// A disc pulled along x that cracks from its rim, where that lies along x.
fn pulled(diameter_m: f64, tension_pa: f64, seed: u64) -> Result<Broken, Box<dyn Error>> {
    let disc = pane(Outline::Disc { diameter_m }, 4e-3, GlassBuild::Annealed)?;
    let crack = LongCrack {
        load: MembraneLoad {
            temperature_difference_k: 0.0,
            spot: [0.5; 2],
            spot_size: 1.0,
            frame_tension_pa: tension_pa,
            frame_direction_rad: 0.0,
        },
        origin: LongCrackOrigin::Rim,
        // Just more than what opens.
        flaw_m: 1.05
            * (disc.material.fracture_toughness_pa_sqrt_m.value / (1.12 * tension_pa)).powi(2)
            / std::f64::consts::PI,
        growth: LongCrackGrowth::Sudden,
    };
    Ok(simulate(
        &disc,
        &[],
        Some(&crack),
        &params(),
        Seed(seed),
        |_| (),
    )?)
}

/// V6, V7 and the straight crack of V8, in a disc under uniform tension.
fn long_cracks() -> Rows {
    let mut points = Vec::new();
    let mut ratios = Vec::new();
    let mut n_cracks = 0;
    let mut fastest: f64 = 0.0;
    for k in 0..6 {
        let tension_pa = 10e6 * 1.2_f64.powi(k);
        for seed in 0..40 {
            let broken = pulled(3.0, tension_pa, seed)?;
            n_cracks += 1;
            let network = &broken.network;
            fastest = fastest.max(fastest_tip_m_s(network));
            let segments = &network.data().segments;
            let fork = (0..segments.kind.len()).find(|&i| segments.kind[i] == SegmentKind::Fork);
            let Some(fork) = fork else { continue };
            // The way from the rim, and the flaw that was there before with its edge factor.
            let [x, y, ..] = network.ends(fork);
            let [x0, y0, ..] = network.ends(0);
            let way_m = 1e-3 * libm::hypot(x - x0, y - y0);
            let flaw_m =
                1.05 * (soda_lime_toughness()? / tension_pa).powi(2) / std::f64::consts::PI;
            points.push((tension_pa, way_m + flaw_m));
            ratios.push((way_m + flaw_m) * tension_pa * tension_pa);
        }
    }
    let slope = exponent(&points);
    let middle = mean(ratios.iter().copied());
    let scatter = mean(ratios.iter().map(|r| (r / middle - 1.0).powi(2))).sqrt();
    let constant = middle.sqrt() * 1e-6;
    let (mut n_long, mut worst_angle) = (0, 0.0_f64);
    for seed in 0..20 {
        let broken = pulled(3.0, 2.2e6, seed)?;
        let segments = &broken.network.data().segments;
        let is_fork = |&idx: &usize| segments.kind[idx] == SegmentKind::Fork;
        let n_before = (0..segments.kind.len())
            .find(is_fork)
            .unwrap_or(segments.kind.len());
        if n_before == 0 {
            continue;
        }
        // Segments come in the order of time, so this is the last of the crack before it forks.
        let [.., x, y] = broken.network.ends(n_before - 1);
        let [x0, y0, ..] = broken.network.ends(0);
        let way_mm = libm::hypot(x - x0, y - y0);
        if way_mm > 500.0 {
            n_long += 1;
            worst_angle = worst_angle.max(libm::asin((x - x0).abs() / way_mm).to_degrees());
        }
    }
    let (mut way, mut time) = (0.0, 0.0);
    for seed in 0..5 {
        let broken = pulled(0.6, 60e6, seed)?;
        fastest = fastest.max(fastest_tip_m_s(&broken.network));
        let segments = &broken.network.data().segments;
        let (Some(arrival), Some(departure)) = (&segments.arrival_us, &segments.departure_us)
        else {
            continue;
        };
        for idx in 0..segments.kind.len() {
            let [x0, y0, x1, y1] = broken.network.ends(idx);
            way += 1e-3 * libm::hypot(x1 - x0, y1 - y0);
            time += 1e-6 * (arrival[idx] - departure[idx]);
        }
    }
    let speed = way / time;
    Ok(vec![
        Row::judged(
            "V6 exponent of the way to a fork over stress, 10-25 MPa",
            "-2",
            format!("{slope:.3}; {} of {n_cracks} cracks forked", points.len()),
            "± 0.05",
            "mirror law σ√r = A, Quinn2020",
            (slope + 2.0).abs() <= 0.05 && 2 * points.len() > n_cracks,
        ),
        Row::judged(
            "V6 scatter of that way",
            "12 %",
            format!("{:.1} %; A_b = {constant:.2} MPa √m", 100.0 * scatter),
            "± 3 %",
            "twice that of A",
            (scatter - 0.12).abs() <= 0.03,
        ),
        Row::judged(
            "V7 fastest tip of these cracks",
            "≤ 1500 m/s",
            format!("{fastest:.1} m/s"),
            "rounding of nodes taken off",
            "Schardin1959",
            fastest <= 1500.001,
        ),
        Row::judged(
            "V7 mean speed at 60 MPa",
            "1300-1500 m/s (1458 seen)",
            format!("{speed:.0} m/s"),
            "bounds",
            "high-speed film of tempered glass",
            (1300.0..=1500.0).contains(&speed),
        ),
        Row::judged(
            "V8 crack under uniform tension of 2.2 MPa, worst of its way to the fork",
            "straight across",
            format!("{worst_angle:.2}° off, {n_long} cracks over 500 mm"),
            "0.5°",
            "maximum principal stress",
            worst_angle <= 0.5 && n_long > 10,
        ),
    ])
}

fn soda_lime_toughness() -> Result<f64, Box<dyn Error>> {
    Ok(Material::soda_lime()?.fracture_toughness_pa_sqrt_m.value)
}
