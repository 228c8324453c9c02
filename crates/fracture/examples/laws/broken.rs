//! V9, V12 to V15: broken panes as a whole.

use std::error::Error;
use std::thread;

use starbreak_fracture::physics::{
    DamageClass, GlassPane, ImpactReport, MeshResolution, PhysicsParams, simulate,
};
use starbreak_glass::{CrackNetwork, SegmentKind};
use starbreak_seed::Seed;

use crate::measures::network::{
    Joint, euler_defect, fastest_tip_m_s, mean, ring_joints, stored_j, surface_j,
};
use crate::measures::panes::{any_hit, between, case, road_stone, windscreen};
use crate::table::{Row, Rows};

/// Stones of V12.
const N_STONES: u64 = 1000;

/// Hits of V15.
const N_HITS: u64 = 300;

fn fast() -> PhysicsParams {
    PhysicsParams {
        mesh: MeshResolution::Fast,
        ..PhysicsParams::default()
    }
}

pub(crate) fn rows() -> Rows {
    let mut rows = Vec::new();
    let mut seen = Seen::default();
    rows.extend(road(&mut seen)?);
    rows.extend(hits(&mut seen)?);
    rows.extend(seen.rows());
    rows.push(repeats()?);
    rows.push(Row::elsewhere(
        "V14 arms and lengths at 621, 1242 and 2484 px",
        "equal, ± 1 %",
        "test resolution of starbreak",
    ));
    rows.push(Row::elsewhere(
        "V16 branching of a peridynamic plate",
        "one fork",
        "peridynamics.txt",
    ));
    Ok(rows)
}

/// What every network is looked at for.
#[derive(Default)]
struct Seen {
    n_networks: u32,
    n_faulty: u32,
    n_off_euler: u32,
    joints: Vec<Joint>,
    fastest_m_s: f64,
}

impl Seen {
    fn look(&mut self, network: &CrackNetwork) {
        self.n_networks += 1;
        self.n_faulty += u32::from(network.check_invariants().is_err());
        self.n_off_euler += u32::from(euler_defect(network) != 0);
        self.joints.extend(ring_joints(network));
        self.fastest_m_s = self.fastest_m_s.max(fastest_tip_m_s(network));
    }

    fn rows(&self) -> Vec<Row> {
        let n = self.n_networks;
        let n_joints = self.joints.len();
        let n_early = self
            .joints
            .iter()
            .filter(|joint| joint.delay_us < 0.0)
            .count();
        let angle = mean(self.joints.iter().map(|joint| joint.angle_deg));
        vec![
            Row::judged(
                "V7 fastest tip of all networks",
                "≤ 1500 m/s",
                format!("{:.1} m/s", self.fastest_m_s),
                "rounding of nodes taken off",
                "Schardin1959",
                self.fastest_m_s <= 1500.001,
            ),
            Row::judged(
                "V9 rings that start before the radials they touch are there",
                "none",
                format!("{n_early} of {n_joints}"),
                "exact",
                "Chen2014",
                n_early == 0 && n_joints > 0,
            ),
            Row::judged(
                "V13 networks with a crossing without a node, or another fault",
                "none",
                format!("{} of {n}", self.n_faulty),
                "exact",
                "geometry",
                self.n_faulty == 0,
            ),
            Row::judged(
                "V13 networks with V − E + F ≠ 1 + C",
                "none",
                format!("{} of {n}", self.n_off_euler),
                "exact",
                "Euler",
                self.n_off_euler == 0,
            ),
            Row::judged(
                "V13 mean angle of rings onto radials, folded to 0-90°",
                "90°",
                format!("{angle:.1}°, {n_joints} joints"),
                "± 15°",
                "a free crack face has no stress across it",
                (angle - 90.0).abs() <= 15.0,
            ),
        ]
    }
}

/// Diameter of a cone on the far face, m, where it goes through the sheet.
fn cone(network: &CrackNetwork) -> Option<f64> {
    let data = network.data();
    let impact = data.impacts.first()?;
    let depth = data.segments.depth_fraction.as_deref().unwrap_or_default();
    let is_base = |&idx: &usize| data.segments.kind[idx] == SegmentKind::Cone && depth[idx] > 0.99;
    let sides: Vec<usize> = (0..depth.len()).filter(is_base).collect();
    let radius_mm = mean(sides.iter().map(|&idx| {
        let [x, y, ..] = network.ends(idx);
        libm::hypot(x - impact.x, y - impact.y)
    }));
    (!sides.is_empty()).then_some(2e-3 * radius_mm)
}

/// Share of those within a bound, and how many there are.
fn within(sizes: &[f64], low: f64, high: f64) -> (f64, String) {
    let n_in = sizes
        .iter()
        .filter(|size| (low..=high).contains(*size))
        .count();
    let share = mean(
        sizes
            .iter()
            .map(|size| f64::from(u8::from((low..=high).contains(size)))),
    );
    let (least, most) = sizes
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(a, b), &s| (a.min(s), b.max(s)));
    let text = format!(
        "{:.1} % ({n_in} of {}), {:.1} to {:.1} mm",
        100.0 * share,
        sizes.len(),
        1e3 * least,
        1e3 * most
    );
    (share, text)
}

/// V12: stones of the road on windscreens in summer and winter.
fn road(seen: &mut Seen) -> Rows {
    let (mut bullseyes, mut stars, mut combinations) = (Vec::new(), Vec::new(), Vec::new());
    let mut classes = std::collections::BTreeMap::new();
    for k in 0..N_STONES {
        let mut rng = case(12, k);
        let modulus_pa = 30e6 * libm::pow(1000.0 / 30.0, between(&mut rng, 0.0, 1.0));
        let screen = windscreen(modulus_pa)?;
        let place = [between(&mut rng, 0.2, 1.2), between(&mut rng, 0.1, 0.7)];
        let stone = road_stone(place, &mut rng);
        let broken = simulate(&screen, &[stone], None, &fast(), Seed(k), |_| ())?;
        seen.look(&broken.network);
        let hit = &broken.impacts[0];
        *classes.entry(hit.damage.name()).or_insert(0_u32) += 1;
        match hit.damage {
            DamageClass::Star => stars.push(2.0 * hit.reach_m),
            DamageClass::Combination => combinations.push(2.0 * hit.reach_m),
            _ => {}
        }
        if let Some(diameter_m) = cone(&broken.network) {
            bullseyes.push(diameter_m);
        }
    }
    let mut rows = Vec::new();
    for (what, sizes, low_mm, high_mm) in [
        ("cones through the ply", &bullseyes, 10.0, 25.0),
        ("stars", &stars, 0.0, 76.0),
        ("combinations", &combinations, 0.0, 51.0),
    ] {
        let (share, text) = within(sizes, low_mm * 1e-3, high_mm * 1e-3);
        rows.push(Row::judged(
            &format!("V12 width of {what}, {low_mm} to {high_mm} mm, 1000 stones"),
            "at least 95 %",
            if sizes.is_empty() {
                "none among them".to_owned()
            } else {
                text
            },
            "bound",
            "ROLAGS, limits of repair",
            share >= 0.95,
        ));
    }
    let list: Vec<String> = classes
        .iter()
        .map(|(name, n)| format!("{name} {n}"))
        .collect();
    rows.push(Row::report(
        "V12 classes of the 1000 stones",
        "-",
        list.join(", "),
        "-",
    ));
    Ok(rows)
}

/// V15: any pane, any stone.
fn hits(seen: &mut Seen) -> Rows {
    let (mut n_over, mut n_more, mut n_other, mut n_broken) = (0, 0, 0, 0);
    let mut spent: f64 = 0.0;
    for k in 0..N_HITS {
        let (pane, stone) = any_hit(k)?;
        let broken = simulate(&pane, &[stone], None, &fast(), Seed(k), |_| ())?;
        seen.look(&broken.network);
        let hit = &broken.impacts[0];
        let given_j = hit.kinetic_energy_j + stored_of(hit, &pane);
        n_over += u32::from(hit.dissipated_j > hit.available_j);
        n_more += u32::from(hit.available_j > given_j * (1.0 + 1e-12));
        if hit.dissipated_j > 0.0 {
            n_broken += 1;
            spent = spent.max(hit.dissipated_j / hit.available_j);
            // The bill against the lines that are there: joints move by less than a step.
            let lines_j = surface_j(&broken.network, &pane);
            n_other += u32::from((lines_j / hit.dissipated_j - 1.0).abs() > 0.01);
        }
    }
    Ok(vec![
        Row::judged(
            "V15 hits that spend more than there is, 300 panes of all kinds",
            "none",
            format!(
                "{n_over}; {n_broken} broke, at most {:.0} % spent",
                100.0 * spent
            ),
            "exact",
            "conservation",
            n_over == 0 && n_broken > 50,
        ),
        Row::judged(
            "V15 hits with more to spend than ½mV² (and the energy of tempering)",
            "none",
            format!("{n_more}"),
            "exact",
            "conservation",
            n_more == 0,
        ),
        Row::judged(
            "V15 networks whose lines cost other than what was spent",
            "none",
            format!("{n_other} of {n_broken}"),
            "1 %",
            "Γ h length",
            n_other == 0,
        ),
    ])
}

fn stored_of(hit: &ImpactReport, pane: &GlassPane) -> f64 {
    if hit.damage == DamageClass::Diced {
        stored_j(pane)
    } else {
        0.0
    }
}

/// V14: the same bytes, again and in four threads at once.
fn repeats() -> Result<Row, Box<dyn Error>> {
    let run = |k: u64| -> Result<String, String> {
        let (pane, stone) = any_hit(k).map_err(|error| error.to_string())?;
        simulate(&pane, &[stone], None, &fast(), Seed(k), |_| ())
            .map(|broken| broken.network.to_json())
            .map_err(|error| error.to_string())
    };
    let n = 40;
    let alone: Vec<_> = (0..n).map(run).collect();
    let mut n_other = 0;
    let together = thread::scope(|scope| {
        let workers: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| (0..n).map(run).collect::<Vec<_>>()))
            .collect();
        workers
            .into_iter()
            .map(thread::ScopedJoinHandle::join)
            .collect::<Vec<_>>()
    });
    for worker in together {
        match worker {
            Ok(texts) => {
                n_other += texts.iter().zip(&alone).filter(|(a, b)| a != b).count();
            }
            Err(_) => n_other += 1,
        }
    }
    Ok(Row::judged(
        "V14 networks that differ when made again, in four threads",
        "none",
        format!("{n_other} of {}", 4 * n),
        "same bytes",
        "-",
        n_other == 0,
    ))
}
