//! Pieces of crack to a network: planar, in order of time, with the surface of each.

use starbreak_glass::{
    CrackNetwork, Generator, GlassKind, Impact, LengthUnit, Model, NETWORK_SCHEMA, NetworkData,
    Nodes, Pane, SegmentKind, Segments, Summary, Zone,
};
use starbreak_seed::Seed;

use super::outcome::{ImpactReport, LongCrackReport};
use super::surface::{Surface, relief, surfaces};
use crate::FractureError;
use crate::arrangement::{Stroke, arrange};
use crate::lattice::Lattice;
use crate::mesh::{Outline, to_u32};
use crate::params::{GlassBuild, GlassPane, StoneImpact};
use crate::tips::{Piece, TipLaw, Web};

pub(super) const MM_PER_M: f64 = 1e3;
const US_PER_S: f64 = 1e6;

/// The pane in mm, as a network has it.
#[must_use]
pub fn network_pane(pane: &GlassPane) -> Pane {
    let [width_m, height_m] = pane.outline.size_m();
    let kind = match (pane.outline, pane.build) {
        (Outline::Disc { .. }, _) => GlassKind::Cover,
        (_, GlassBuild::Annealed) => GlassKind::Annealed,
        (_, GlassBuild::Laminated { .. }) => GlassKind::Laminated,
        (_, GlassBuild::Tempered { .. }) => GlassKind::Tempered,
    };
    Pane {
        width: width_m * MM_PER_M,
        height: height_m * MM_PER_M,
        thickness_mm: Some(pane.thickness_m * MM_PER_M),
        kind: Some(kind),
    }
}

/// Everything that a network says of the hits.
pub(super) struct History<'a> {
    pub(super) stones: &'a [StoneImpact],
    pub(super) reports: &'a [ImpactReport],
    pub(super) long_crack: Option<&'a LongCrackReport>,
}

/// The pieces of crack of all plies, with nodes and numbers of cracks of their own.
pub(super) struct AllCracks {
    nodes: Vec<[f64; 2]>,
    pieces: Vec<Piece>,
    surfaces: Vec<Surface>,
    plies: Vec<u8>,
}

impl AllCracks {
    /// The webs of the plies, the one that was hit first.
    pub(super) fn of<'a>(pane: &GlassPane, webs: impl Iterator<Item = &'a Web>) -> Self {
        let mut all = Self {
            nodes: Vec::new(),
            pieces: Vec::new(),
            surfaces: Vec::new(),
            plies: Vec::new(),
        };
        let mut n_cracks = 0;
        for (ply, web) in (0_u8..).zip(webs) {
            let n_nodes = to_u32(all.nodes.len());
            all.nodes.extend_from_slice(&web.nodes);
            all.pieces.extend(web.pieces.iter().map(|piece| Piece {
                a: n_nodes + piece.a,
                b: n_nodes + piece.b,
                crack: n_cracks + piece.crack,
                ..*piece
            }));
            let pane = match pane.build {
                GlassBuild::Laminated {
                    inner_thickness_m, ..
                } if ply > 0 => GlassPane {
                    thickness_m: inner_thickness_m,
                    ..pane.clone()
                },
                _ => pane.clone(),
            };
            all.surfaces.extend(surfaces(&pane, web));
            all.plies.resize(all.pieces.len(), ply);
            n_cracks += web.n_cracks();
        }
        all
    }
}

/// The network of all cracks.
pub(super) fn network(
    pane: &GlassPane,
    web: &AllCracks,
    history: &History<'_>,
    seed: Seed,
) -> Result<CrackNetwork, FractureError> {
    let sheet = network_pane(pane);
    let lattice = Lattice::of_pane(&sheet);
    let place = |node: [f64; 2]| {
        let [x, y] = node;
        // The lattice would put a node of a round rim off the rim.
        let is_on_circle = sheet.is_disc()
            && pane.outline.depth_m(node) * MM_PER_M <= Lattice::of_pane(&sheet).step();
        if is_on_circle {
            return [x * MM_PER_M, y * MM_PER_M];
        }
        [
            lattice.round(x * MM_PER_M).clamp(0.0, sheet.width),
            lattice.round(y * MM_PER_M).clamp(0.0, sheet.height),
        ]
    };
    // Nodes at one lattice place are one node.
    let mut order: Vec<u32> = (0..to_u32(web.nodes.len())).collect();
    let places: Vec<[f64; 2]> = web.nodes.iter().map(|&node| place(node)).collect();
    let key = |node: u32| places[node as usize].map(f64::to_bits);
    order.sort_unstable_by_key(|&node| (key(node), node));
    let mut same = vec![0_u32; places.len()];
    for pair in 0..order.len() {
        let node = order[pair];
        same[node as usize] = match pair.checked_sub(1).map(|before| order[before]) {
            Some(before) if key(before) == key(node) => same[before as usize],
            _ => node,
        };
    }
    let strokes: Vec<Stroke> = (0_u32..)
        .zip(&web.pieces)
        .map(|(source, piece)| Stroke {
            a: same[piece.a as usize],
            b: same[piece.b as usize],
            kind: piece.kind,
            arrival: piece.time_s.map(|time| time * US_PER_S),
            stress: [piece.stress_pa; 2],
            is_suspect: true,
            source,
        })
        .filter(|stroke| stroke.a != stroke.b)
        .collect();
    let arranged = arrange(&sheet, places.len(), |node| places[node as usize], strokes)
        .map_err(|limit| FractureError::TooManyCracks { limit })?;
    let segments = segments(pane, web, &arranged.nodes, arranged.strokes);
    let impacts = history
        .stones
        .iter()
        .zip(history.reports)
        .map(|(stone, report)| impact(stone, report, place(stone.position_m)))
        .collect();
    let sum = |of: fn(&ImpactReport) -> f64| history.reports.iter().map(of).sum::<f64>();
    let long = history.long_crack;
    let summary = Summary {
        available_j: Some(sum(|r| r.available_j) + long.map_or(0.0, |l| l.available_j)),
        dissipated_j: Some(sum(|r| r.dissipated_j) + long.map_or(0.0, |l| l.dissipated_j)),
        ..Summary::default()
    };
    let damage_class = long
        .filter(|report| report.length_m > 0.0)
        .map(|report| report.class)
        .or_else(|| ImpactReport::worst(history.reports));
    Ok(CrackNetwork::from_planar(NetworkData {
        schema: NETWORK_SCHEMA.to_owned(),
        generator: Generator {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        model: Model::Physics,
        seed: Some(seed),
        unit: LengthUnit::Mm,
        pane: sheet,
        damage_class: damage_class.map(str::to_owned),
        impacts,
        nodes: arranged.nodes,
        segments,
        fallen: Vec::new(),
        summary: Some(summary),
    })?)
}

fn impact(stone: &StoneImpact, report: &ImpactReport, [x, y]: [f64; 2]) -> Impact {
    Impact {
        x,
        y,
        speed_m_s: Some(stone.speed_m_s),
        radius_mm: Some(stone.radius_m * MM_PER_M),
        tip_radius_mm: Some(stone.tip_radius_m * MM_PER_M),
        angle_deg: Some(stone.obliquity_rad.to_degrees()),
        azimuth_deg: Some(stone.azimuth_rad.to_degrees()),
        mass_g: Some(stone.mass_kg() * 1e3),
        energy_j: Some(report.kinetic_energy_j),
        peak_force_n: Some(report.peak_force_n),
        contact_time_us: Some(report.contact_time_s * US_PER_S),
        contact_radius_mm: Some(report.contact_radius_m * MM_PER_M),
        crushed_radius_mm: Some(report.crushed_radius_m * MM_PER_M),
        damage_class: Some(report.damage.name().to_owned()),
        ..Impact::default()
    }
}

/// Columns in order of arrival.
fn segments(
    pane: &GlassPane,
    web: &AllCracks,
    nodes: &Nodes,
    mut strokes: Vec<Stroke>,
) -> Segments {
    strokes.sort_by(|a, b| a.arrival[1].total_cmp(&b.arrival[1]));
    let law = TipLaw::new(&pane.material, pane.thickness_m, true);
    let column = |value: &dyn Fn(&Stroke, &Piece) -> f64| -> Option<Vec<f64>> {
        let piece = |stroke: &Stroke| &web.pieces[stroke.source as usize];
        Some(
            strokes
                .iter()
                .map(|stroke| value(stroke, piece(stroke)))
                .collect(),
        )
    };
    // A stroke may be a part of the piece that it was cut from.
    let part = |stroke: &Stroke| {
        let piece = &web.pieces[stroke.source as usize];
        let [[x0, y0], [x1, y1]] = [piece.a, piece.b].map(|node| web.nodes[node as usize]);
        let (dx, dy) = (x1 - x0, y1 - y0);
        let square = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        [stroke.a, stroke.b].map(|node| {
            let (x, y) = (nodes.x[node as usize], nodes.y[node as usize]);
            let (x, y) = (x / MM_PER_M - x0, y / MM_PER_M - y0);
            ((x * dx + y * dy) / square).clamp(0.0, 1.0)
        })
    };
    let ends = |of: &dyn Fn(&Stroke) -> [f64; 2]| -> Vec<[f64; 2]> {
        let mix = |stroke: &Stroke| {
            let [from, to] = of(stroke);
            part(stroke).map(|part| from + (to - from) * part)
        };
        strokes.iter().map(mix).collect()
    };
    let middle = |ends: &[[f64; 2]]| -> Vec<f64> {
        ends.iter().map(|[from, to]| 0.5 * (from + to)).collect()
    };
    let surface = |stroke: &Stroke| &web.surfaces[stroke.source as usize];
    let depth_ends = ends(&|stroke| surface(stroke).depths);
    let openings_um = ends(&|stroke| surface(stroke).openings_um);
    let tilt_ends_deg = ends(&|stroke| {
        web.pieces[stroke.source as usize]
            .tilt_rad
            .map(f64::to_degrees)
    });
    let reliefs: Vec<(Zone, f64)> = strokes
        .iter()
        .map(|stroke| relief(&law, web.pieces[stroke.source as usize].intensity_pa_sqrt_m))
        .collect();
    Segments {
        from: strokes.iter().map(|stroke| stroke.a).collect(),
        to: strokes.iter().map(|stroke| stroke.b).collect(),
        kind: strokes.iter().map(|stroke| stroke.kind).collect(),
        parent: Some(parents(web, nodes.x.len(), &strokes)),
        arrival_us: column(&|stroke, _| stroke.arrival[1]),
        departure_us: column(&|stroke, _| stroke.arrival[0]),
        stress_mpa: column(&|_, piece| piece.stress_pa * 1e-6),
        opening_um: Some(middle(&openings_um)),
        depth_fraction: Some(middle(&depth_ends)),
        depth_ends: Some(depth_ends),
        face: Some(strokes.iter().map(|stroke| surface(stroke).face).collect()),
        zone: Some(reliefs.iter().map(|(zone, _)| *zone).collect()),
        roughness_um: Some(reliefs.iter().map(|(_, um)| *um).collect()),
        tilt_deg: Some(middle(&tilt_ends_deg)),
        tilt_ends_deg: Some(tilt_ends_deg),
        ply: Some(
            strokes
                .iter()
                .map(|stroke| web.plies[stroke.source as usize])
                .collect(),
        ),
        k_ratio: column(&|_, piece| piece.intensity_pa_sqrt_m / law.toughness_pa_sqrt_m),
        ..Segments::default()
    }
}

/// For each stroke the one that its tip came from: of its own crack, or, for the branch of a fork
/// and a crack that goes on from another, the one that had arrived where it starts.
fn parents(web: &AllCracks, n_nodes: usize, strokes: &[Stroke]) -> Vec<Option<u32>> {
    // Strokes by the node where they end, in order of arrival.
    let mut ending = vec![Vec::new(); n_nodes];
    for (idx, stroke) in (0_u32..).zip(strokes) {
        ending[stroke.b as usize].push(idx);
    }
    let crack = |stroke: &Stroke| web.pieces[stroke.source as usize].crack;
    strokes
        .iter()
        .map(|stroke| {
            let before = |&&idx: &&u32| strokes[idx as usize].arrival[1] <= stroke.arrival[0];
            let candidates = || ending[stroke.a as usize].iter().filter(before);
            let own = candidates().find(|&&idx| crack(&strokes[idx as usize]) == crack(stroke));
            let goes_on = matches!(stroke.kind, SegmentKind::Fork | SegmentKind::Edge);
            own.or_else(|| candidates().next_back().filter(|_| goes_on))
                .copied()
        })
        .collect()
}
