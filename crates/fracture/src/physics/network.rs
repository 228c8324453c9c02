//! Pieces of crack to a network: planar, in order of time, with the surface of each.

use starbreak_glass::{
    CrackNetwork, Generator, GlassKind, Impact, LengthUnit, Model, NETWORK_SCHEMA, NetworkData,
    Nodes, Pane, Seed, SegmentKind, Segments, Summary, Zone,
};

use super::outcome::{ImpactReport, LongCrackReport};
use super::params::{GlassBuild, GlassPane, StoneImpact};
use super::surface::{bending_depth, opening_um, relief};
use crate::FractureError;
use crate::arrangement::{Stroke, arrange};
use crate::lattice::Lattice;
use crate::mesh::{Outline, to_u32};
use crate::tips::{Piece, TipLaw, Web};

const MM_PER_M: f64 = 1e3;
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

/// The network of a web of cracks.
pub(super) fn network(
    pane: &GlassPane,
    web: &Web,
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
    let arranged =
        arrange(&sheet, places, strokes).map_err(|limit| FractureError::TooManyCracks { limit })?;
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
        .or_else(|| worst(history.reports));
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
        summary: Some(summary),
    })?)
}

/// The class of the hit that did most.
fn worst(reports: &[ImpactReport]) -> Option<&'static str> {
    let rank = |report: &&ImpactReport| (report.damage.rank(), report.reach_m.to_bits());
    reports
        .iter()
        .max_by_key(rank)
        .map(|report| report.damage.name())
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
fn segments(pane: &GlassPane, web: &Web, nodes: &Nodes, mut strokes: Vec<Stroke>) -> Segments {
    strokes.sort_by(|a, b| a.arrival[1].total_cmp(&b.arrival[1]));
    let law = TipLaw::new(&pane.material, pane.thickness_m, true);
    let lengths = crack_lengths(web);
    let n = strokes.len();
    let mut columns = Columns::with_capacity(n);
    let parents = parents(web, nodes.x.len(), &strokes);
    let mut segments = Segments::default();
    for stroke in &strokes {
        let piece = &web.pieces[stroke.source as usize];
        let is_leg = matches!(
            piece.kind,
            SegmentKind::Radial | SegmentKind::Fork | SegmentKind::Ring
        );
        let depth = match piece.kind {
            SegmentKind::Cone => (piece.along_m[1] / pane.thickness_m).clamp(0.02, 1.0),
            _ if is_leg => bending_depth(&law, piece.stress_pa, piece.effective_m),
            _ => 1.0,
        };
        let (zone, roughness_um) = relief(&law, piece.intensity_pa_sqrt_m);
        segments.from.push(stroke.a);
        segments.to.push(stroke.b);
        segments.kind.push(stroke.kind);
        columns.arrival_us.push(stroke.arrival[1]);
        columns.departure_us.push(stroke.arrival[0]);
        columns.stress_mpa.push(piece.stress_pa * 1e-6);
        columns.opening_um.push(opening_um(
            &pane.material,
            piece,
            lengths[piece.crack as usize],
        ));
        columns.depth_fraction.push(depth);
        columns.zone.push(zone);
        columns.roughness_um.push(roughness_um);
        columns.tilt_deg.push(piece.tilt_rad.to_degrees());
        columns
            .k_ratio
            .push(piece.intensity_pa_sqrt_m / law.toughness_pa_sqrt_m);
    }
    segments.parent = Some(parents);
    segments.arrival_us = Some(columns.arrival_us);
    segments.departure_us = Some(columns.departure_us);
    segments.stress_mpa = Some(columns.stress_mpa);
    segments.opening_um = Some(columns.opening_um);
    segments.depth_fraction = Some(columns.depth_fraction);
    segments.zone = Some(columns.zone);
    segments.roughness_um = Some(columns.roughness_um);
    segments.tilt_deg = Some(columns.tilt_deg);
    segments.ply = Some(vec![0; n]);
    segments.k_ratio = Some(columns.k_ratio);
    segments
}

/// Columns while they are being filled.
struct Columns {
    arrival_us: Vec<f64>,
    departure_us: Vec<f64>,
    stress_mpa: Vec<f64>,
    opening_um: Vec<f64>,
    depth_fraction: Vec<f64>,
    zone: Vec<Zone>,
    roughness_um: Vec<f64>,
    tilt_deg: Vec<f64>,
    k_ratio: Vec<f64>,
}

impl Columns {
    fn with_capacity(n: usize) -> Self {
        Self {
            arrival_us: Vec::with_capacity(n),
            departure_us: Vec::with_capacity(n),
            stress_mpa: Vec::with_capacity(n),
            opening_um: Vec::with_capacity(n),
            depth_fraction: Vec::with_capacity(n),
            zone: Vec::with_capacity(n),
            roughness_um: Vec::with_capacity(n),
            tilt_deg: Vec::with_capacity(n),
            k_ratio: Vec::with_capacity(n),
        }
    }
}

/// Length of each crack, forks counted from where the first began, m.
fn crack_lengths(web: &Web) -> Vec<f64> {
    let mut lengths = Vec::new();
    for Piece { crack, along_m, .. } in &web.pieces {
        let crack = *crack as usize;
        if lengths.len() <= crack {
            lengths.resize(crack + 1, 0.0_f64);
        }
        lengths[crack] = lengths[crack].max(along_m[1]);
    }
    lengths
}

/// For each stroke the one that its tip came from: of its own crack, or, for the branch of a fork
/// and a crack that goes on from another, the one that had arrived where it starts.
fn parents(web: &Web, n_nodes: usize, strokes: &[Stroke]) -> Vec<Option<u32>> {
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
