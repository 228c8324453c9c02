//! Segments of a network as chains: cracks whose surface goes on from one segment to the next.

use starbreak_glass::{CrackNetwork, Face, Fragment, LengthUnit, SegmentKind, Zone};

use super::SheetView;
use super::relief::{FRONT, Relief, THROUGH};
use crate::surface::SurfaceParams;
use crate::vector::Vector;

/// A crack from where it begins to where it ends, or to where others meet it.
#[derive(Debug)]
pub(super) struct Chain {
    pub(super) pieces: Vec<Piece>,
    /// Depths of the faces of its ply, mm, the one towards the camera first.
    pub(super) ply_mm: [f64; 2],
    /// Face of the ply that it begins at.
    pub(super) face: Face,
    /// Middle of the cone that it is a part of, mm on the sheet.
    pub(super) cone_about: Option<[f64; 2]>,
    /// Whether it is a cone through the ply, whose wall comes from the face at a flat angle and ends upright.
    pub(super) is_flared: bool,
    /// Whether depths follow the front of the crack, so that its opening closes there.
    pub(super) has_front: bool,
    /// How the surface leans between its edges, where that changes.
    pub(super) relief: Option<Relief>,
}

impl Chain {
    pub(super) fn thickness_mm(&self) -> f64 {
        self.ply_mm[1] - self.ply_mm[0]
    }

    /// Upper and lower edge of the crack at one of its places, mm.
    fn edges(&self, end: &End) -> [Vector; 2] {
        let [low, high] = self.ply_mm;
        let deep = self.thickness_mm() * end.depth;
        let lean = deep * end.lean;
        let [x, y] = end.at;
        let moved = |by: f64, z: f64| [x + by * end.left[0], y + by * end.left[1], z];
        match self.face {
            Face::Outer => [[x, y, high], moved(lean, high - deep)],
            Face::Inner => [moved(-lean, low + deep), [x, y, low]],
        }
    }

    /// A place of the surface, by the part of the depth that it is from the face it begins at, mm.
    pub(super) fn place(&self, end: &End, part: f64) -> Vector {
        if let Some(middle) = self.cone_about {
            return self.on_cone(middle, end, part);
        }
        let [upper, lower] = self.edges(end);
        let (face, deepest) = match self.face {
            Face::Outer => (upper, lower),
            Face::Inner => (lower, upper),
        };
        let mut place = std::array::from_fn(|k| face[k] + (deepest[k] - face[k]) * part);
        if let Some(relief) = &self.relief {
            let lean = relief.mean_lean(end.along_mm, end.depth, part) - end.lean;
            let by = part * self.thickness_mm() * end.depth * lean;
            let side = match self.face {
                Face::Outer => by,
                Face::Inner => -by,
            };
            place[0] += side * end.left[0];
            place[1] += side * end.left[1];
        }
        place
    }

    /// Corners of a band of the surface between two of its places: along the upper edge and back along the
    /// lower one.
    pub(super) fn corners(&self, [a, b]: [&End; 2], [from, to]: [f64; 2]) -> [Vector; 4] {
        if let Some(middle) = self.cone_about {
            return [(a, from), (b, from), (b, to), (a, to)]
                .map(|(end, part)| self.on_cone(middle, end, part));
        }
        let ([upper_a, lower_a], [upper_b, lower_b]) = (self.edges(a), self.edges(b));
        [upper_a, upper_b, lower_b, lower_a]
    }

    /// What the opening at a depth is over the widest: a part of the crack's depth from the face it begins at. A crack is
    /// shut at its front.
    ///
    /// A cone that is through is shut where it begins, and as far open as the square of the part. FIT: in photographs
    /// bullseyes are clear within, and dark along their outer edge.
    pub(super) fn closes(&self, part: f64) -> f64 {
        if self.is_flared {
            part * part
        } else if self.has_front {
            (1.0 - part * part).max(0.0).sqrt()
        } else {
            1.0
        }
    }
}

/// A straight piece of crack.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) ends: [End; 2],
    pub(super) alpha: f64,
    /// Opening at the face, µm.
    pub(super) gap_um: f64,
}

/// One end of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// mm on the sheet.
    pub(super) at: [f64; 2],
    /// Across the crack, to the left of the walk, of length 1.
    pub(super) left: [f64; 2],
    /// Over the thickness of the ply.
    pub(super) depth: f64,
    /// Tangent of the tilt, the mean over the depth: to the left of the walk, going from the outer
    /// face inward; of a cone away from its middle.
    pub(super) lean: f64,
    /// Way along the crack, mm.
    pub(super) along_mm: f64,
}

impl End {
    /// The place a part of the way to another end.
    pub(super) fn to(&self, other: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        let pair = |a: [f64; 2], b: [f64; 2]| [mix(a[0], b[0]), mix(a[1], b[1])];
        Self {
            at: pair(self.at, other.at),
            left: unit(pair(self.left, other.left)).unwrap_or(self.left),
            depth: mix(self.depth, other.depth),
            lean: mix(self.lean, other.lean),
            along_mm: mix(self.along_mm, other.along_mm),
        }
    }
}

/// The chains of a network as far as it has grown.
pub(super) fn chains(
    sheet: &SheetView,
    network: &CrackNetwork,
    time: f64,
    params: &SurfaceParams,
) -> Vec<Chain> {
    let segments = &network.data().segments;
    let grown = Grown::of(sheet, network, time);
    // Chains begin where no segment goes on into another; what is left after them are rings.
    let mut is_next = vec![false; segments.from.len()];
    for &idx in &grown.order {
        if let Some(next) = grown.next_of(network, idx) {
            is_next[next] = true;
        }
    }
    let mut is_done = vec![false; segments.from.len()];
    let mut chains = Vec::new();
    let heads = grown.order.iter().copied().filter(|idx| !is_next[*idx]);
    for head in heads.chain(grown.order.iter().copied()) {
        let mut at = Some(head);
        let mut pieces = Vec::new();
        let mut is_growing = false;
        while let Some(idx) = at.filter(|idx| !is_done[*idx]) {
            is_done[idx] = true;
            if let Some((ends, part)) = grown.ends[idx] {
                pieces.extend(piece_of(network, idx, (ends, part), params));
                is_growing = part < 1.0;
            }
            at = grown.next_of(network, idx);
        }
        if pieces.is_empty() {
            continue;
        }
        let has_front = segments.depth_ends.is_some();
        let ply_mm = sheet.ply_mm(segments.ply.as_ref().map_or(0, |plies| plies[head]));
        let thickness_mm = ply_mm[1] - ply_mm[0];
        mitre(&mut pieces);
        if has_front && is_growing {
            round_front(&mut pieces, FRONT * thickness_mm);
        }
        let is_cone = segments.kind[head] == SegmentKind::Cone;
        let ends = || pieces.iter().flat_map(|piece| &piece.ends);
        let is_flared = is_cone && ends().all(|end| end.depth >= THROUGH);
        chains.push(Chain {
            is_flared,
            relief: (has_front && !is_cone)
                .then(|| left_by_front(&mut pieces, thickness_mm))
                .flatten(),
            pieces,
            ply_mm,
            face: segments
                .face
                .as_ref()
                .map_or(Face::Outer, |faces| faces[head]),
            cone_about: is_cone.then(|| nearest_impact(network, head)).flatten(),
            has_front,
        });
    }
    chains
}

/// Segments as far as they have grown, and which of them go on from which.
struct Grown {
    /// Ends on the sheet, mm, and which part of the segment is there.
    ends: Vec<Option<([[f64; 2]; 2], f64)>>,
    order: Vec<usize>,
    /// Of each segment the first that grew out of it, of the same crack; without parents, of each
    /// node the one segment that leaves it.
    child: Vec<Option<usize>>,
    leaving: Vec<Option<usize>>,
    n_at: Vec<u32>,
}

impl Grown {
    fn of(sheet: &SheetView, network: &CrackNetwork, time: f64) -> Self {
        let data = network.data();
        let pane = [data.pane.width, data.pane.height];
        let segments = &data.segments;
        let (n_segments, n_nodes) = (segments.from.len(), data.nodes.x.len());
        let mut grown = Self {
            ends: vec![None; n_segments],
            order: Vec::with_capacity(n_segments),
            child: vec![None; n_segments],
            leaving: vec![None; n_nodes],
            n_at: vec![0; n_nodes],
        };
        let fallen = Fallen::of(network, time);
        for (idx, [x0, y0, x1, y1]) in network.grown_at(time) {
            let a = sheet.on_sheet([x0, y0], data.unit, pane);
            let b = sheet.on_sheet([x1, y1], data.unit, pane);
            let (Some(a), Some(b)) = (a, b) else {
                continue;
            };
            let [_, _, x, y] = network.ends(idx);
            let whole = sheet.on_sheet([x, y], data.unit, pane).unwrap_or(b);
            let part = (distance(a, b) / distance(a, whole).max(f64::MIN_POSITIVE)).min(1.0);
            if fallen.has_both_sides([x0, y0, x1, y1]) {
                continue;
            }
            let (from, to) = (segments.from[idx] as usize, segments.to[idx] as usize);
            grown.leaving[from] = Some(idx);
            grown.n_at[from] += 1;
            grown.n_at[to] += 1;
            grown.ends[idx] = Some(([a, b], part));
            grown.order.push(idx);
            if let Some(parent) = segments.parent.as_ref().and_then(|parents| parents[idx]) {
                let child = &mut grown.child[parent as usize];
                if child.is_none() && is_same(network, parent as usize, idx) {
                    *child = Some(idx);
                }
            }
        }
        grown
    }

    /// The segment that goes on from one.
    fn next_of(&self, network: &CrackNetwork, idx: usize) -> Option<usize> {
        let segments = &network.data().segments;
        if segments.parent.is_some() && self.child[idx].is_some() {
            return self.child[idx];
        }
        let node = segments.to[idx] as usize;
        let next = self.leaving[node].filter(|_| self.n_at[node] == 2)?;
        let begins_there = self.ends[idx].is_some_and(|(_, part)| part >= 1.0);
        (begins_there && is_same(network, idx, next)).then_some(next)
    }
}

/// Where pieces of glass are gone.
pub(super) struct Fallen(Vec<Fragment>);

impl Fallen {
    /// Of a network when all its cracks have come.
    pub(super) fn of(network: &CrackNetwork, time: f64) -> Self {
        Self(if time >= network.last_arrival() {
            network.fallen_fragments()
        } else {
            Vec::new()
        })
    }

    pub(super) fn is_at(&self, point: [f64; 2]) -> bool {
        self.0.iter().any(|fragment| fragment.contains(point))
    }

    /// Whether there is no glass on either side of a segment.
    fn has_both_sides(&self, [x0, y0, x1, y1]: [f64; 4]) -> bool {
        if self.0.is_empty() {
            return false;
        }
        let (dx, dy) = (1e-4 * (x1 - x0), 1e-4 * (y1 - y0));
        let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
        self.is_at([x - dy, y + dx]) && self.is_at([x + dy, y - dx])
    }
}

/// Whether two segments are of one surface.
fn is_same(network: &CrackNetwork, a: usize, b: usize) -> bool {
    let segments = &network.data().segments;
    let ply = |idx: usize| segments.ply.as_ref().map(|plies| plies[idx]);
    let face = |idx: usize| segments.face.as_ref().map(|faces| faces[idx]);
    segments.kind[a] == segments.kind[b] && ply(a) == ply(b) && face(a) == face(b)
}

/// The piece that a segment is, as far as it has grown.
fn piece_of(
    network: &CrackNetwork,
    idx: usize,
    ([a, b], part): ([[f64; 2]; 2], f64),
    params: &SurfaceParams,
) -> Option<Piece> {
    let segments = &network.data().segments;
    let along = unit([b[0] - a[0], b[1] - a[1]])?;
    // With y down the left of a walk along +x is −y.
    let left = [along[1], -along[0]];
    let of = |column: &Option<Vec<f64>>| column.as_ref().map(|values| values[idx]);
    let ends_of = |ends: &Option<Vec<[f64; 2]>>, mean: f64| {
        let [from, to] = ends.as_ref().map_or([mean; 2], |values| values[idx]);
        [from, from + (to - from) * part]
    };
    let depths = ends_of(
        &segments.depth_ends,
        of(&segments.depth_fraction).unwrap_or(1.0),
    );
    let tilts = ends_of(
        &segments.tilt_ends_deg,
        of(&segments.tilt_deg).unwrap_or(0.0),
    );
    let leans = tilts.map(|degrees| libm::tan(degrees.to_radians()));
    let end = |k: usize| End {
        at: [a, b][k],
        left,
        depth: depths[k],
        lean: leans[k],
        along_mm: 0.0,
    };
    Some(Piece {
        ends: [end(0), end(1)],
        alpha: alpha_of(network, idx, params),
        gap_um: of(&segments.opening_um).unwrap_or(params.opening_um),
    })
}

/// GGX α of a surface by its roughness: 0.13 R^0.55 of the RMS roughness R in µm, between 0.02 and
/// 0.3. FIT. By its zone where the network says no roughness, or where α is given.
fn alpha_of(network: &CrackNetwork, idx: usize, params: &SurfaceParams) -> f64 {
    let segments = &network.data().segments;
    let zone = segments
        .zone
        .as_ref()
        .map_or(Zone::Mirror, |zones| zones[idx]);
    let (given, by_zone) = match zone {
        Zone::Mirror => (params.mirror_alpha, 0.02),
        Zone::Mist => (params.mist_alpha, 0.08),
        Zone::Hackle => (params.hackle_alpha, 0.3),
    };
    let rough = segments.roughness_um.as_ref().map(|values| values[idx]);
    let by_roughness = rough.map(|um| (0.13 * libm::pow(um, 0.55)).clamp(0.02, 0.3));
    given.or(by_roughness).unwrap_or(by_zone)
}

/// Pieces that follow each other share their edges: across the mean of both at their common end.
fn mitre(pieces: &mut [Piece]) {
    for k in 1..pieces.len() {
        let (before, after) = pieces.split_at_mut(k);
        let (Some(last), Some(first)) = (before.last_mut(), after.first_mut()) else {
            continue;
        };
        let (a, b) = (&mut last.ends[1], &mut first.ends[0]);
        if distance(a.at, b.at) > 0.0 {
            continue;
        }
        if let Some(left) = unit([a.left[0] + b.left[0], a.left[1] + b.left[1]]) {
            (a.left, b.left) = (left, left);
        }
    }
}

/// The front of a crack that is growing: a quarter of an ellipse behind its tip.
fn round_front(pieces: &mut [Piece], reach_mm: f64) {
    let mut behind = 0.0;
    for piece in pieces.iter_mut().rev() {
        let length = distance(piece.ends[0].at, piece.ends[1].at);
        for (end, way) in piece.ends.iter_mut().zip([behind + length, behind]) {
            let left = (1.0 - way / reach_mm).max(0.0);
            end.depth *= (1.0 - left * left).max(0.0).sqrt();
        }
        behind += length;
        if behind > reach_mm {
            break;
        }
    }
}

/// Measures pieces along their crack, whose leans are those at its face, and makes of these what its
/// front left.
fn left_by_front(pieces: &mut [Piece], thickness_mm: f64) -> Option<Relief> {
    let mut at_face = Vec::with_capacity(pieces.len() + 1);
    let mut along_mm = 0.0;
    for piece in &mut *pieces {
        let length_mm = distance(piece.ends[0].at, piece.ends[1].at);
        for (end, way_mm) in piece.ends.iter_mut().zip([0.0, length_mm]) {
            end.along_mm = along_mm + way_mm;
            at_face.push([end.along_mm, end.lean]);
        }
        along_mm += length_mm;
    }
    let depth = pieces.get(pieces.len() / 2)?.ends[0].depth;
    let relief = Relief::new(at_face, depth, thickness_mm)?;
    for end in pieces.iter_mut().flat_map(|piece| &mut piece.ends) {
        end.lean = relief.mean_lean(end.along_mm, end.depth, 1.0);
    }
    Some(relief)
}

/// The place of the hit nearest to a segment, of a network in mm.
fn nearest_impact(network: &CrackNetwork, idx: usize) -> Option<[f64; 2]> {
    let data = network.data();
    let [x, y, ..] = network.ends(idx);
    let places = data.impacts.iter().map(|impact| [impact.x, impact.y]);
    places
        .filter(|_| data.unit == LengthUnit::Mm)
        .min_by(|a, b| distance(*a, [x, y]).total_cmp(&distance(*b, [x, y])))
}

pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}

fn unit([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let length = (x * x + y * y).sqrt();
    (length > 0.0).then(|| [x / length, y / length])
}
