//! Segments of a network as straight lines on the sheet, as few as can be told apart.
//!
//! Simulated cracks bend a little from one short segment to the next. Through a lens that blurs
//! them, runs of such segments look like one line.

use starbreak_glass::{CrackNetwork, LengthUnit, SegmentKind, Zone};

use super::SheetView;
use crate::physical::SurfaceParams;

/// A run may lie off its line by this share of the radius of its blur, and by these px at least
/// and at most.
const OFF_LINE: f64 = 0.04;
const OFF_LINE_PX: [f64; 2] = [0.02, 0.4];

/// Longest run, px.
const LONGEST_RUN_PX: f64 = 24.0;

/// Least cosine of the angle between a segment of a run and the first one: 6°.
const LEAST_COSINE: f64 = 0.9945;

/// Surfaces of one run differ by at most this in depth over thickness and in the tangent of their
/// tilt, and in their gaps by this ratio unless both are wide.
const ALIKE_DEPTH: f64 = 0.03;
const ALIKE_LEAN: f64 = 0.03;
const ALIKE_GAPS: f64 = 1.2;

/// From here on a gap is wide: it reflects in full beyond the critical angle, and without colors
/// short of it.
const WIDE_GAP_UM: f64 = 6.0;

/// A straight piece of crack on the sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Ends, mm on the sheet.
    pub(super) ends: [[f64; 2]; 2],
    pub(super) surface: CrackSurface,
}

/// What the surface of a crack is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CrackSurface {
    pub(super) alpha: f64,
    pub(super) gap_um: f64,
    pub(super) depth_fraction: f64,
    /// Tangent of the tilt: to the left of the walk, of a cone away from its middle.
    pub(super) lean: f64,
    /// Middle of the cone that it is a part of, mm on the sheet.
    pub(super) cone_about: Option<[f64; 2]>,
}

impl CrackSurface {
    /// Whether two surfaces may be seen as one: of one depth and tilt, and with gaps that are
    /// wide for light or alike.
    fn looks_like(&self, other: &Self) -> bool {
        let (narrow, wide) = if self.gap_um < other.gap_um {
            (self.gap_um, other.gap_um)
        } else {
            (other.gap_um, self.gap_um)
        };
        (self.depth_fraction - other.depth_fraction).abs() <= ALIKE_DEPTH
            && (self.lean - other.lean).abs() <= ALIKE_LEAN
            && (narrow >= WIDE_GAP_UM || wide <= ALIKE_GAPS * narrow)
    }
}

/// The lines of a network as far as it has grown.
pub(super) fn lines(
    sheet: &SheetView,
    network: &CrackNetwork,
    time: f64,
    params: &SurfaceParams,
) -> Vec<Line> {
    let data = network.data();
    let pane = [data.pane.width, data.pane.height];
    let segments = &data.segments;
    let n_nodes = data.nodes.x.len();
    // Of each node the one segment that arrives there whole and the one that leaves it, and how
    // many there are of any kind.
    let mut leaving = vec![None; n_nodes];
    let mut n_at = vec![0_u32; n_nodes];
    let mut grown: Vec<Option<[[f64; 2]; 2]>> = vec![None; segments.from.len()];
    let mut order = Vec::with_capacity(segments.from.len());
    for (idx, [x0, y0, x1, y1]) in network.grown_at(time) {
        let a = sheet.on_sheet([x0, y0], data.unit, pane);
        let b = sheet.on_sheet([x1, y1], data.unit, pane);
        let (Some(a), Some(b)) = (a, b) else {
            continue;
        };
        let (from, to) = (segments.from[idx] as usize, segments.to[idx] as usize);
        leaving[from] = Some(idx);
        n_at[from] += 1;
        n_at[to] += 1;
        grown[idx] = Some([a, b]);
        order.push(idx);
    }
    let next_of = |idx: usize, end: [f64; 2]| -> Option<usize> {
        let node = segments.to[idx] as usize;
        let next: Option<usize> = leaving[node];
        let next = next.filter(|_| n_at[node] == 2)?;
        let is_same = segments.kind[idx] == segments.kind[next]
            && zone(network, idx) == zone(network, next)
            && grown[next].is_some_and(|[start, _]| distance(start, end) <= 0.0);
        is_same.then_some(next)
    };
    // Runs begin where no segment runs on into another; what is left after them are rings.
    let mut is_next = vec![false; segments.from.len()];
    for &idx in &order {
        if let Some([_, end]) = grown[idx]
            && let Some(next) = next_of(idx, end)
        {
            is_next[next] = true;
        }
    }
    let mut is_done = vec![false; segments.from.len()];
    let mut lines = Vec::with_capacity(order.len());
    let heads = order.iter().copied().filter(|idx| !is_next[*idx]);
    for head in heads.chain(order.iter().copied()) {
        let mut at = Some(head);
        let mut run: Option<Run> = None;
        while let Some(idx) = at.filter(|idx| !is_done[*idx]) {
            let Some([a, b]) = grown[idx] else {
                break;
            };
            is_done[idx] = true;
            let surface = surface_of(network, idx, params);
            match &mut run {
                Some(run) if run.takes(b, &surface) => run.add(b, surface),
                _ => {
                    lines.extend(run.take().map(Run::line));
                    run = Some(Run::new(sheet, [a, b], surface));
                }
            }
            at = next_of(idx, b);
        }
        lines.extend(run.map(Run::line));
    }
    lines
}

/// Segments that follow each other and look like one line.
struct Run {
    points: Vec<[f64; 2]>,
    first: CrackSurface,
    /// Sums weighted by length.
    sums: CrackSurface,
    length: f64,
    off_line_mm: f64,
    longest_mm: f64,
}

impl Run {
    fn new(sheet: &SheetView, [a, b]: [[f64; 2]; 2], surface: CrackSurface) -> Self {
        let px_per_mm = sheet.view().px_per_unit(a).unwrap_or(f64::INFINITY);
        let blur_px = sheet.blur_radius_px(a, 0.0).unwrap_or(0.0).abs();
        let off_line_px = (OFF_LINE * blur_px).clamp(OFF_LINE_PX[0], OFF_LINE_PX[1]);
        let mut run = Self {
            points: vec![a],
            first: surface,
            sums: CrackSurface {
                alpha: 0.0,
                gap_um: 0.0,
                depth_fraction: 0.0,
                lean: 0.0,
                cone_about: surface.cone_about,
            },
            length: 0.0,
            off_line_mm: off_line_px / px_per_mm,
            longest_mm: LONGEST_RUN_PX / px_per_mm,
        };
        run.add(b, surface);
        run
    }

    /// Whether the run may go on to a point over such a surface.
    fn takes(&self, to: [f64; 2], surface: &CrackSurface) -> bool {
        if !self.first.looks_like(surface) {
            return false;
        }
        let (Some(&start), Some(&last)) = (self.points.first(), self.points.last()) else {
            return false;
        };
        let whole = distance(start, to);
        if whole > self.longest_mm || whole <= 0.0 {
            return false;
        }
        let along = [(to[0] - start[0]) / whole, (to[1] - start[1]) / whole];
        let is_straight = self.points.iter().all(|p| {
            let off = (p[0] - start[0]) * along[1] - (p[1] - start[1]) * along[0];
            off.abs() <= self.off_line_mm
        });
        let turns = |a: [f64; 2], b: [f64; 2]| {
            let length = distance(a, b);
            let cosine = ((b[0] - a[0]) * along[0] + (b[1] - a[1]) * along[1]) / length;
            length > 0.0 && cosine < LEAST_COSINE
        };
        is_straight && !turns(start, self.points[1]) && !turns(last, to)
    }

    fn add(&mut self, to: [f64; 2], surface: CrackSurface) {
        let length = self.points.last().map_or(0.0, |last| distance(*last, to));
        self.points.push(to);
        self.length += length;
        self.sums.alpha += length * surface.alpha;
        self.sums.gap_um += length * surface.gap_um;
        self.sums.depth_fraction += length * surface.depth_fraction;
        self.sums.lean += length * surface.lean;
    }

    /// The run as one line, its surface the mean over its length.
    fn line(self) -> Line {
        let first = self.points[0];
        let last = self.points.last().copied().unwrap_or(first);
        let length = self.length.max(f64::MIN_POSITIVE);
        Line {
            ends: [first, last],
            surface: CrackSurface {
                alpha: self.sums.alpha / length,
                gap_um: self.sums.gap_um / length,
                depth_fraction: self.sums.depth_fraction / length,
                lean: self.sums.lean / length,
                cone_about: self.sums.cone_about,
            },
        }
    }
}

fn zone(network: &CrackNetwork, idx: usize) -> Zone {
    let zones = network.data().segments.zone.as_ref();
    zones.map_or(Zone::Mirror, |zones| zones[idx])
}

fn surface_of(network: &CrackNetwork, idx: usize, params: &SurfaceParams) -> CrackSurface {
    let segments = &network.data().segments;
    let of = |column: &Option<Vec<f64>>| column.as_ref().map(|values| values[idx]);
    CrackSurface {
        alpha: match zone(network, idx) {
            Zone::Mirror => params.mirror_alpha,
            Zone::Mist => params.mist_alpha,
            Zone::Hackle => params.hackle_alpha,
        },
        gap_um: of(&segments.opening_um).unwrap_or(params.opening_um),
        depth_fraction: of(&segments.depth_fraction).unwrap_or(1.0),
        lean: libm::tan(of(&segments.tilt_deg).unwrap_or(0.0).to_radians()),
        cone_about: (segments.kind[idx] == SegmentKind::Cone)
            .then(|| nearest_impact(network, idx))
            .flatten(),
    }
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

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}
