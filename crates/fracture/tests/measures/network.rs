//! What can be measured on a finished network, without a look at how it came about.

use std::collections::BTreeMap;

use starbreak_fracture::physics::{GlassBuild, GlassPane};
use starbreak_glass::{CrackNetwork, Pane, SegmentKind};

/// Whether a point is on the rim.
fn is_on_rim(pane: &Pane, [x, y]: [f64; 2]) -> bool {
    let tolerance = pane.rim_tolerance();
    if pane.is_disc() {
        let radius = 0.5 * pane.width;
        return radius - libm::hypot(x - radius, y - radius) <= tolerance;
    }
    x.min(pane.width - x).min(y).min(pane.height - y) <= tolerance
}

fn point(network: &CrackNetwork, node: u32) -> [f64; 2] {
    let nodes = &network.data().nodes;
    [nodes.x[node as usize], nodes.y[node as usize]]
}

/// The representative of a node's component.
fn root(of: &mut [u32], node: u32) -> u32 {
    let mut at = node;
    while of[at as usize] != at {
        of[at as usize] = of[of[at as usize] as usize];
        at = of[at as usize];
    }
    at
}

/// V − E + F − (1 + C) of the graph of cracks and rim: 0 by Euler's formula. V, E and C are
/// counted here; F is what the network says of its fragments, and the outside.
pub(crate) fn euler_defect(network: &CrackNetwork) -> i64 {
    let data = network.data();
    let n = data.nodes.x.len();
    // The rim is one node more: as a cycle it has as many edges as nodes, its corners included.
    let rim = u32::try_from(n).unwrap_or(u32::MAX);
    let mut component: Vec<u32> = (0..=rim).collect();
    let mut is_used = vec![false; n];
    // Pieces are those of the ply that was hit.
    let segments = &data.segments;
    let edges: Vec<[u32; 2]> = (segments.from.iter().zip(&segments.to))
        .enumerate()
        .filter(|(idx, _)| segments.ply.as_ref().is_none_or(|plies| plies[*idx] == 0))
        .map(|(_, (&a, &b))| [a, b])
        .collect();
    for &[a, b] in &edges {
        let (a, b) = (root(&mut component, a), root(&mut component, b));
        component[a as usize] = b;
    }
    for &node in edges.iter().flatten() {
        is_used[node as usize] = true;
    }
    let (mut n_nodes, mut n_rim) = (0_i64, 0_i64);
    for node in (0..rim).filter(|&node| is_used[node as usize]) {
        n_nodes += 1;
        if is_on_rim(&data.pane, point(network, node)) {
            n_rim += 1;
            let at = root(&mut component, node);
            let rim = root(&mut component, rim);
            component[at as usize] = rim;
        }
    }
    let rim_root = root(&mut component, rim);
    let mut roots: Vec<u32> = (0..rim)
        .filter(|&node| is_used[node as usize])
        .map(|node| root(&mut component, node))
        .chain([rim_root])
        .collect();
    roots.sort_unstable();
    roots.dedup();
    let count = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let n_edges = count(edges.len());
    let n_faces = count(network.fragments().len()) + 1;
    n_nodes - n_edges - n_rim + n_faces - (1 + count(roots.len()))
}

/// Where a ring crack meets a radial or one of its forks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Joint {
    /// How long after the radial was there the ring started to run there, µs.
    pub(crate) delay_us: f64,
    /// Angle between ring and radial, degrees, 0 to 90.
    pub(crate) angle_deg: f64,
}

/// All places where rings meet the cracks that came before them.
pub(crate) fn ring_joints(network: &CrackNetwork) -> Vec<Joint> {
    let segments = &network.data().segments;
    let (Some(arrival), Some(departure)) = (&segments.arrival_us, &segments.departure_us) else {
        return Vec::new();
    };
    let is_leg = |kind: SegmentKind| matches!(kind, SegmentKind::Radial | SegmentKind::Fork);
    // Legs at each node: which, and when the crack was there.
    let mut legs: BTreeMap<u32, Vec<(usize, f64)>> = BTreeMap::new();
    for idx in (0..segments.kind.len()).filter(|&idx| is_leg(segments.kind[idx])) {
        let at_start = legs.entry(segments.from[idx]).or_default();
        at_start.push((idx, departure[idx]));
        legs.entry(segments.to[idx])
            .or_default()
            .push((idx, arrival[idx]));
    }
    let direction = |idx: usize| {
        let [x0, y0, x1, y1] = network.ends(idx);
        let length = libm::hypot(x1 - x0, y1 - y0);
        [(x1 - x0) / length, (y1 - y0) / length]
    };
    let mut joints = Vec::new();
    let is_ring = |&idx: &usize| segments.kind[idx] == SegmentKind::Ring;
    for ring in (0..segments.kind.len()).filter(is_ring) {
        for node in [segments.from[ring], segments.to[ring]] {
            // The first crack that was there.
            let first = legs.get(&node).and_then(|legs| {
                let earlier = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
                legs.iter().min_by(earlier)
            });
            let Some(&(leg, there_us)) = first else {
                continue;
            };
            let (p, q) = (direction(ring), direction(leg));
            let cosine = (p[0] * q[0] + p[1] * q[1]).abs().min(1.0);
            joints.push(Joint {
                delay_us: departure[ring] - there_us,
                angle_deg: libm::acos(cosine).to_degrees(),
            });
        }
    }
    joints
}

/// Distances of the ends of radials and forks from the first impact, m, where no other goes on;
/// none without an impact.
fn leg_ends_m(network: &CrackNetwork) -> Vec<f64> {
    let data = network.data();
    let segments = &data.segments;
    let Some(center) = data.impacts.first() else {
        return Vec::new();
    };
    let is_leg =
        |&idx: &usize| matches!(segments.kind[idx], SegmentKind::Radial | SegmentKind::Fork);
    let legs: Vec<usize> = (0..segments.kind.len()).filter(is_leg).collect();
    let goes_on = |node: u32| legs.iter().any(|&idx| segments.from[idx] == node);
    legs.iter()
        .map(|&idx| segments.to[idx])
        .filter(|&node| !goes_on(node))
        .map(|node| {
            let [x, y] = point(network, node);
            1e-3 * libm::hypot(x - center.x, y - center.y)
        })
        .collect()
}

/// Mean of the legs, those of [`leg_ends_m`] that come to 0.3 of the farthest, and the farthest, m.
pub(crate) fn leg_reach_m(network: &CrackNetwork) -> Option<[f64; 2]> {
    let ends = leg_ends_m(network);
    let farthest = ends.iter().copied().fold(0.0, f64::max);
    let is_leg = |end: &f64| *end >= 0.3 * farthest;
    (!ends.is_empty()).then(|| [mean(ends.into_iter().filter(is_leg)), farthest])
}

/// Highest speed of a crack tip, m/s, of which the network's rounding of positions (to 2⁻²⁶ of the
/// next power of two of the longer side, at both ends) is taken off. Cones and dice, whose times
/// are not those of a traced tip, are left out.
pub(crate) fn fastest_tip_m_s(network: &CrackNetwork) -> f64 {
    let data = network.data();
    let segments = &data.segments;
    let (Some(arrival), Some(departure)) = (&segments.arrival_us, &segments.departure_us) else {
        return 0.0;
    };
    let longer = data.pane.width.max(data.pane.height);
    let step_mm = libm::exp2(libm::ceil(libm::log2(longer)) - 26.0);
    (0..segments.kind.len())
        .filter(|&idx| !matches!(segments.kind[idx], SegmentKind::Cone | SegmentKind::Dice))
        .map(|idx| {
            let [x0, y0, x1, y1] = network.ends(idx);
            let length_mm = libm::hypot(x1 - x0, y1 - y0) - 2.0 * step_mm;
            let time_us = arrival[idx] - departure[idx];
            // NaN, where nothing is left of a length, is passed over.
            1e3 * length_mm.max(0.0) / time_us
        })
        .fold(0.0, f64::max)
}

/// Γ h times the length of all cracks that run through the sheet (cones left out), J: what the
/// network's own lines cost.
pub(crate) fn surface_j(network: &CrackNetwork, pane: &GlassPane) -> f64 {
    let segments = &network.data().segments;
    let kinds = &segments.kind;
    let inner_m = match pane.build {
        GlassBuild::Laminated {
            inner_thickness_m, ..
        } => inner_thickness_m,
        GlassBuild::Annealed | GlassBuild::Tempered { .. } => pane.thickness_m,
    };
    let thickness_m = |idx: usize| match &segments.ply {
        Some(plies) if plies[idx] > 0 => inner_m,
        _ => pane.thickness_m,
    };
    let area_mm_m: f64 = (0..kinds.len())
        .filter(|&idx| kinds[idx] != SegmentKind::Cone)
        .map(|idx| {
            let [x0, y0, x1, y1] = network.ends(idx);
            libm::hypot(x1 - x0, y1 - y0) * thickness_m(idx)
        })
        .sum();
    pane.material.fracture_energy_j_m2() * area_mm_m * 1e-3
}

/// Energy of a parabola of residual stress, (1/5)(1 − ν) σ²/E per volume, J; 0 without tempering.
pub(crate) fn stored_j(pane: &GlassPane) -> f64 {
    let GlassBuild::Tempered {
        surface_compression_pa,
    } = pane.build
    else {
        return 0.0;
    };
    let material = &pane.material;
    let stress_squared = surface_compression_pa * surface_compression_pa;
    0.2 * (1.0 - material.poisson_ratio.value) * stress_squared / material.young_modulus_pa.value
        * pane.outline.area_m2()
        * pane.thickness_m
}

pub(crate) fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values
        .into_iter()
        .fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    sum / n
}
