//! Lines that somebody drew to a crack network: no physics, only the promises of a network.

use std::collections::BTreeMap;

use starbreak_glass::{
    CrackNetwork, Generator, Impact, LengthUnit, Model, NETWORK_SCHEMA, NetworkData, Nodes, Pane,
    SegmentKind, Segments, find_contacts_up_to,
};

use crate::FractureError;
use crate::arrangement::{Stroke, arrange, cut, remove_duplicates};
use crate::lattice::Lattice;
use crate::mesh::to_u32;

/// A line that ends so close to another ends on it, and points within half of it are one; in the
/// pane's unit, px or mm. The last decimal of [`CrackNetwork::to_svg`], so that places which
/// are two in its text stay two.
pub const JOIN_TOLERANCE: f64 = 1e-3;

/// Most contacts of lines.
pub const MAX_CONTACTS: usize = 1 << 20;

/// A line that was drawn along a crack.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Its corners, on the pane, in the pane's unit; from where the crack came.
    pub points: Vec<[f64; 2]>,
    /// What it is a part of.
    pub kind: SegmentKind,
}

/// The network of drawn lines: model `imported`, no times and no stresses.
///
/// Corners are rounded to a lattice of 2⁻²⁶ of the pane. Points within half of
/// [`JOIN_TOLERANCE`] are joined at the first of them. A line whose end lies within that tolerance
/// of another line cuts it there;
/// where lines cross or lie on each other they are cut, too, and of pieces that coincide the one
/// of the lower kind stays. A line that ends, but does not start, at an impact is turned round:
/// the crack came from there. Lines of no length are left out.
///
/// # Errors
/// [`FractureError::TraceOffPane`] and [`FractureError::ImpactOffPane`] for a point off the pane
/// or not finite, [`FractureError::TooManyContacts`] above [`MAX_CONTACTS`],
/// [`FractureError::Pane`].
pub fn network(
    pane: &Pane,
    unit: LengthUnit,
    impacts: &[[f64; 2]],
    traces: &[Trace],
) -> Result<CrackNetwork, FractureError> {
    pane.check()?;
    let mut places = Places::new(pane);
    let mut paths = Vec::with_capacity(traces.len());
    for trace in traces {
        paths.push((path_of(trace, pane, &mut places)?, trace.kind));
    }
    let mut impact_nodes = Vec::with_capacity(impacts.len());
    let mut hits = Vec::with_capacity(impacts.len());
    for &[x, y] in impacts {
        if !pane.contains(x, y) {
            let (width, height) = (pane.width, pane.height);
            return Err(FractureError::ImpactOffPane {
                x,
                y,
                width,
                height,
            });
        }
        let node = places.node_at([x, y]);
        impact_nodes.push(node);
        let [x, y] = places.positions[node as usize];
        hits.push(Impact {
            x,
            y,
            ..Impact::default()
        });
    }
    for (path, _) in &mut paths {
        let is_impact = |node: Option<&u32>| node.is_some_and(|node| impact_nodes.contains(node));
        if is_impact(path.last()) && !is_impact(path.first()) {
            path.reverse();
        }
    }
    let mut strokes: Vec<Stroke> = paths
        .iter()
        .flat_map(|(path, kind)| {
            path.windows(2)
                .map(|ends| stroke([ends[0], ends[1]], *kind))
        })
        .collect();
    remove_duplicates(&mut strokes);
    let (positions, reach) = (places.positions, 2.0 * places.reach);
    let cuts = ends_on_lines(&positions, &strokes, reach)?;
    let nodes = columns(&positions);
    let strokes = cut(&nodes, &strokes, cuts)
        .into_iter()
        .map(|stroke| Stroke {
            is_suspect: true,
            ..stroke
        })
        .collect();
    let arranged = arrange(
        pane,
        positions.len(),
        |node| positions[node as usize],
        strokes,
    )
    .map_err(|limit| FractureError::TooManyContacts { limit })?;
    let data = NetworkData {
        schema: NETWORK_SCHEMA.to_owned(),
        generator: Generator {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        model: Model::Imported,
        seed: None,
        unit,
        pane: *pane,
        damage_class: None,
        impacts: hits,
        nodes: arranged.nodes,
        segments: Segments {
            from: arranged.strokes.iter().map(|stroke| stroke.a).collect(),
            to: arranged.strokes.iter().map(|stroke| stroke.b).collect(),
            kind: arranged.strokes.iter().map(|stroke| stroke.kind).collect(),
            ..Segments::default()
        },
        fallen: Vec::new(),
        summary: None,
    };
    Ok(CrackNetwork::from_planar(data)?)
}

/// The nodes that a line goes through.
fn path_of(trace: &Trace, pane: &Pane, places: &mut Places) -> Result<Vec<u32>, FractureError> {
    let mut path: Vec<u32> = Vec::with_capacity(trace.points.len());
    for &[x, y] in &trace.points {
        if !pane.contains(x, y) {
            let (width, height) = (pane.width, pane.height);
            return Err(FractureError::TraceOffPane {
                x,
                y,
                width,
                height,
            });
        }
        let node = places.node_at([x, y]);
        if path.last() != Some(&node) {
            path.push(node);
        }
    }
    Ok(path)
}

fn stroke([a, b]: [u32; 2], kind: SegmentKind) -> Stroke {
    Stroke {
        a,
        b,
        kind,
        arrival: [0.0; 2],
        stress: [0.0; 2],
        is_suspect: true,
        source: 0,
    }
}

fn columns(positions: &[[f64; 2]]) -> Nodes {
    Nodes {
        x: positions.iter().map(|[x, _]| *x).collect(),
        y: positions.iter().map(|[_, y]| *y).collect(),
    }
}

/// Finds the node of a place.
struct Places {
    pane: Pane,
    lattice: Lattice,
    reach: f64,
    positions: Vec<[f64; 2]>,
    by_cell: BTreeMap<[i64; 2], Vec<u32>>,
}

impl Places {
    fn new(pane: &Pane) -> Self {
        let lattice = Lattice::of_pane(pane);
        Self {
            pane: *pane,
            lattice,
            reach: (0.5 * JOIN_TOLERANCE).max(lattice.step()),
            positions: Vec::new(),
            by_cell: BTreeMap::new(),
        }
    }

    /// The nearest node within reach, of equals the first; a new one where there is none.
    fn node_at(&mut self, [x, y]: [f64; 2]) -> u32 {
        // `+ 0.0` makes a negative zero positive.
        let x = self.lattice.round(x).clamp(0.0, self.pane.width) + 0.0;
        let y = self.lattice.round(y).clamp(0.0, self.pane.height) + 0.0;
        let [column, row] = [x, y].map(|value| cell(value, self.reach));
        let mut nearest: Option<(f64, u32)> = None;
        for neighbor in (row - 1..=row + 1)
            .flat_map(|row| (column - 1..=column + 1).map(move |column| [column, row]))
        {
            for &node in self.by_cell.get(&neighbor).into_iter().flatten() {
                let [node_x, node_y] = self.positions[node as usize];
                let distance2 = (node_x - x) * (node_x - x) + (node_y - y) * (node_y - y);
                let is_nearer =
                    nearest.is_none_or(|(best2, best)| (distance2, node) < (best2, best));
                if distance2 <= self.reach * self.reach && is_nearer {
                    nearest = Some((distance2, node));
                }
            }
        }
        if let Some((_, node)) = nearest {
            return node;
        }
        let node = to_u32(self.positions.len());
        self.positions.push([x, y]);
        self.by_cell.entry([column, row]).or_default().push(node);
        node
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a pane is at most 10⁹ wide, so there are at most 10¹² cells"
)]
fn cell(value: f64, size: f64) -> i64 {
    libm::floor(value / size) as i64
}

/// Which strokes are to be cut at which free ends: those that pass within reach. Around each
/// free end a plus sign of arms reach·√2 is laid, which no line within reach passes untouched.
fn ends_on_lines(
    positions: &[[f64; 2]],
    strokes: &[Stroke],
    reach: f64,
) -> Result<Vec<(u32, u32)>, FractureError> {
    let mut degree = vec![0_u32; positions.len()];
    for stroke in strokes {
        degree[stroke.a as usize] += 1;
        degree[stroke.b as usize] += 1;
    }
    let free: Vec<u32> = (0..to_u32(positions.len()))
        .filter(|&node| degree[node as usize] == 1)
        .collect();
    let mut nodes = columns(positions);
    let mut from: Vec<u32> = strokes.iter().map(|stroke| stroke.a).collect();
    let mut to: Vec<u32> = strokes.iter().map(|stroke| stroke.b).collect();
    let arm = reach * std::f64::consts::SQRT_2;
    for &node in &free {
        let [x, y] = positions[node as usize];
        for [dx, dy] in [[arm, 0.0], [0.0, arm]] {
            let first = to_u32(nodes.x.len());
            nodes.x.extend([x - dx, x + dx]);
            nodes.y.extend([y - dy, y + dy]);
            from.push(first);
            to.push(first + 1);
        }
    }
    let contacts = find_contacts_up_to(&nodes, &from, &to, MAX_CONTACTS).ok_or(
        FractureError::TooManyContacts {
            limit: MAX_CONTACTS,
        },
    )?;
    let mut cuts = Vec::new();
    for contact in contacts {
        // The lower index is the stroke, the higher one the sign.
        let (idx, sign) = (contact.first as usize, contact.second as usize);
        let (Some(stroke), Some(&node)) = (
            strokes.get(idx),
            sign.checked_sub(strokes.len())
                .and_then(|sign| free.get(sign / 2)),
        ) else {
            continue;
        };
        if stroke.a == node || stroke.b == node {
            continue;
        }
        let [a, b, p] = [stroke.a, stroke.b, node].map(|node| positions[node as usize]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length2 = dx * dx + dy * dy;
        let t = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2;
        let across = (p[0] - a[0]) * dy - (p[1] - a[1]) * dx;
        if (0.0..=1.0).contains(&t) && across * across <= reach * reach * length2 {
            cuts.push((contact.first, node));
        }
    }
    Ok(cuts)
}
