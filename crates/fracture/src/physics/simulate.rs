//! Pane, stones and loads to a broken pane.

use starbreak_glass::{CrackNetwork, Fragment, NetworkData, SegmentKind};
use starbreak_seed::Seed;

use super::fallen::loose_pieces;
use super::impact::Breaking;
use super::network::{AllCracks, History, MM_PER_M, network, network_pane};
use super::outcome::{Broken, DamageClass, ImpactReport, Stage};
use super::plate::Plates;
use crate::FractureError;
use crate::dice::{dice_cascade, dice_cells, fragment_density_per_m2};
use crate::mesh::to_u32;
use crate::params::{
    Dicing, GlassBuild, GlassPane, LongCrack, LongCrackOrigin, PhysicsParams, StoneImpact,
};
use crate::tips::{Piece, TipLaw, Web};

/// Most hits of one pane.
pub const MAX_IMPACTS: usize = 1000;

/// Time from the last crack of a hit to the next hit, s: long after all has come to rest.
const PAUSE_S: f64 = 1e-3;

/// Breaks a pane by stones, one after the other, and by the stress in its plane after them.
///
/// `done` is called at the end of every [`Stage`], for some of them several times.
///
/// Stress in the plane acts after the first hit, or after each, where it drives their cracks, else
/// after all of them. Pieces that fall out do so after the first hit, and what flies through their
/// holes breaks nothing more. With [`PhysicsParams::until_reach_m`] everything stops at the moment at which a crack gets
/// so far from the first hit: a smaller reach gives an earlier state of the same event.
///
/// Each hit: contact ([`crate::contact`]), plate stress ([`crate::stress`]), radial cracks traced
/// through it, rings between them. Each hit meets what is already broken: its stress is that of
/// the cracked pane, and its cracks end at the older ones. docs/theory/physics.md gives the equations, what
/// is law and what is calibration.
///
/// The result is a function of the arguments alone, to the last bit.
///
/// # Units
/// SI in, a network in mm and µs out.
///
/// # Errors
/// [`FractureError`] for parameters out of range, a hit off the pane, or a network larger than its
/// bounds.
///
/// # Limits
/// A hit costs at most 12 solutions of a plate of at most some 6000 nodes and 300 000 steps of tips; a
/// tempered pane at most 400 000 dice.
pub fn simulate(
    pane: &GlassPane,
    impacts: &[StoneImpact],
    long_crack: Option<&LongCrack>,
    params: &PhysicsParams,
    seed: Seed,
    mut done: impl FnMut(Stage),
) -> Result<Broken, FractureError> {
    check(pane, impacts, long_crack, params)?;
    let mut breaking = intact(pane, params, seed);
    let mut reports: Vec<ImpactReport> = Vec::with_capacity(impacts.len());
    let (mut time_s, mut end_s) = (0.0, f64::INFINITY);
    let mut fallen: Option<Vec<Fragment>> = None;
    // What goes on from a hit does so before the next.
    let origin = long_crack.map(|long_crack| long_crack.origin);
    let goes_on = |k| match origin {
        Some(LongCrackOrigin::Impact) => k == 0,
        Some(LongCrackOrigin::Legs) => true,
        Some(LongCrackOrigin::Rim) | None => false,
    };
    for (k, stone) in (0_u64..).zip(impacts) {
        let mut report = match breaking.heavy_plies(stone) {
            _ if fallen.iter().flatten().any(|hole| is_in(stone, hole)) => {
                ImpactReport::of_nothing(stone, time_s)
            }
            Some(plies) => breaking.heavy_hit((stone, &plies), k, time_s, &mut done),
            None => breaking.hit(stone, k, time_s, &mut done)?,
        };
        if report.damage == DamageClass::Diced {
            dice(&mut breaking, stone, &mut report)?;
            done(Stage::Dice);
        }
        reports.push(report);
        time_s = last_arrival_s(&breaking).max(time_s + report.contact_time_s) + PAUSE_S;
        if goes_on(k) {
            breaking.grow(long_crack, time_s)?;
            done(Stage::LongCrack);
            time_s = last_arrival_s(&breaking).max(time_s) + PAUSE_S;
        }
        if k == 0 && params.n_fallen > 0 {
            let history = History {
                stones: &impacts[..1],
                reports: &reports,
                long_crack: None,
            };
            fallen = Some(loose_pieces(
                &network_of(&breaking, &history)?,
                params.n_fallen,
            ));
        }
        if k == 0
            && let Some(reach_m) = params.until_reach_m
        {
            end_s = breaking.reaches_s(stone.position_m, reach_m);
        }
        if end_s < time_s {
            break;
        }
    }
    if !goes_on(0) && end_s.is_infinite() {
        let start_s = if impacts.is_empty() { 0.0 } else { time_s };
        breaking.grow(long_crack, start_s)?;
        done(Stage::LongCrack);
    }
    for web in [Some(&mut breaking.web), breaking.inner.as_mut()] {
        if let Some(web) = web.filter(|_| end_s.is_finite()) {
            web.cut(end_s);
        }
    }
    if end_s.is_finite() || origin == Some(LongCrackOrigin::Legs) {
        for (stone, report) in impacts.iter().zip(&mut reports) {
            breaking.reclassify(stone.position_m, report);
        }
    }
    let long_report = long_crack.and_then(|load| breaking.long_report(load, &reports));
    let history = History {
        stones: &impacts[..reports.len()],
        reports: &reports,
        long_crack: long_report.as_ref(),
    };
    let network = network_of(&breaking, &history)?;
    let fallen = fallen
        .filter(|_| end_s.is_infinite())
        .unwrap_or_else(|| loose_pieces(&network, params.n_fallen));
    let network = without(network, &fallen)?;
    done(Stage::Network);
    Ok(Broken {
        network,
        impacts: reports,
        long_crack: long_report,
        n_solutions: breaking.plates.n_solutions,
        n_mesh_nodes: breaking.plates.n_mesh_nodes,
    })
}

/// The pane before it is hit.
fn intact<'a>(pane: &'a GlassPane, params: &'a PhysicsParams, seed: Seed) -> Breaking<'a> {
    Breaking {
        pane,
        params,
        seed,
        web: Web::new(pane.outline),
        inner: None,
        plates: Plates::new(pane, params.mesh),
        in_plane: None,
        driven: None,
        dices: match pane.build {
            GlassBuild::Tempered {
                surface_compression_pa,
            } => fragment_density_per_m2(surface_compression_pa, pane.thickness_m).is_some(),
            GlassBuild::Annealed | GlassBuild::Laminated { .. } => false,
        },
        is_diced: false,
        n_older: 0,
    }
}

/// All cracks so far.
fn network_of(
    breaking: &Breaking<'_>,
    history: &History<'_>,
) -> Result<CrackNetwork, FractureError> {
    let cracks = AllCracks::of(breaking.pane, breaking.webs());
    network(breaking.pane, &cracks, history, breaking.seed)
}

/// A network with holes in the place of pieces that have fallen out.
fn without(network: CrackNetwork, fallen: &[Fragment]) -> Result<CrackNetwork, FractureError> {
    if fallen.is_empty() {
        return Ok(network);
    }
    Ok(CrackNetwork::from_planar(NetworkData {
        fallen: fallen.iter().filter_map(Fragment::inner_point).collect(),
        ..network.data().clone()
    })?)
}

/// Whether a stone flies through a hole.
fn is_in(stone: &StoneImpact, hole: &Fragment) -> bool {
    hole.contains(stone.position_m.map(|coordinate| coordinate * MM_PER_M))
}

fn check(
    pane: &GlassPane,
    impacts: &[StoneImpact],
    long_crack: Option<&LongCrack>,
    params: &PhysicsParams,
) -> Result<(), FractureError> {
    pane.check()?;
    params.check()?;
    if impacts.len() > MAX_IMPACTS {
        #[expect(clippy::cast_precision_loss, reason = "a count, for the message")]
        return Err(FractureError::Parameter {
            name: "number of impacts",
            value: impacts.len() as f64,
            expected: "at most 1000".into(),
        });
    }
    for stone in impacts {
        stone.check()?;
        let depth_m = pane.outline.depth_m(stone.position_m);
        if depth_m.is_nan() || depth_m < 0.0 {
            let sheet = network_pane(pane);
            return Err(FractureError::ImpactOffPane {
                x: stone.position_m[0] * 1e3,
                y: stone.position_m[1] * 1e3,
                width: sheet.width,
                height: sheet.height,
            });
        }
    }
    long_crack.map_or(Ok(()), LongCrack::check)
}

fn last_arrival_s(breaking: &Breaking<'_>) -> f64 {
    let pieces = breaking.webs().flat_map(|web| &web.pieces);
    pieces.map(|piece| piece.time_s[1]).fold(0.0, f64::max)
}

/// The whole tempered pane goes to pieces.
fn dice(
    breaking: &mut Breaking<'_>,
    stone: &StoneImpact,
    report: &mut ImpactReport,
) -> Result<(), FractureError> {
    let pane = breaking.pane;
    let GlassBuild::Tempered {
        surface_compression_pa,
    } = pane.build
    else {
        return Ok(());
    };
    let center = stone.position_m;
    let start_s = report.time_s;
    let diced = match breaking.params.dicing {
        Dicing::Cells => dice_cells(
            &pane.outline,
            pane.thickness_m,
            surface_compression_pa,
            &[center],
            breaking.seed,
        ),
        Dicing::Cascade => dice_cascade(
            &pane.outline,
            surface_compression_pa,
            &[center],
            breaking.seed,
        ),
    }?;
    let web = &mut breaking.web;
    let first_node = web.nodes.len();
    web.nodes.extend_from_slice(&diced.nodes);
    let surface_j_m2 = pane.material.fracture_energy_j_m2() * pane.thickness_m;
    let core_tension_pa = 0.5 * surface_compression_pa;
    let law = TipLaw::new(&pane.material, pane.thickness_m, false);
    let effective_m = 0.25 * pane.thickness_m;
    let intensity = law
        .intensity(core_tension_pa, effective_m)
        .max(law.toughness_pa_sqrt_m);
    let crack = web.new_crack(None);
    let mut dissipated_j = 0.0;
    let mut reach_m: f64 = 0.0;
    for (idx, edge) in diced.edges.iter().enumerate() {
        let [a, b] = edge.map(|node| node + to_u32(first_node));
        let (p, q) = (web.nodes[a as usize], web.nodes[b as usize]);
        let length = libm::hypot(q[0] - p[0], q[1] - p[1]);
        dissipated_j += surface_j_m2 * length;
        reach_m = reach_m.max(libm::hypot(q[0] - center[0], q[1] - center[1]));
        web.add_piece(Piece {
            a,
            b,
            crack,
            kind: SegmentKind::Dice,
            time_s: diced.times_s[idx].map(|time| start_s + time),
            along_m: [0.0, length],
            stress_pa: core_tension_pa,
            intensity_pa_sqrt_m: intensity,
            effective_m,
            tilt_rad: [0.0; 2],
        });
    }
    breaking.is_diced = true;
    report.available_j += stored_energy_j(pane, surface_compression_pa);
    report.dissipated_j = dissipated_j;
    report.reach_m = reach_m;
    Ok(())
}

/// Energy of the residual stress: (1/5)(1 − ν) σ_s²/E per volume \[BarsomTempered1968\], J.
fn stored_energy_j(pane: &GlassPane, surface_compression_pa: f64) -> f64 {
    let nu = pane.material.poisson_ratio.value;
    let density = 0.2 * (1.0 - nu) * surface_compression_pa * surface_compression_pa
        / pane.material.young_modulus_pa.value;
    density * pane.outline.area_m2() * pane.thickness_m
}
