//! Lines cut to the page and to clip paths.

/// Most pairs of line and clip edge.
pub(super) const MAX_PAIRS: u64 = 100_000_000;

/// The inside of one or several shapes.
#[derive(Debug, Default)]
pub(super) struct Region {
    pub(super) shapes: Vec<Shape>,
}

/// The inside of closed polylines.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) rings: Vec<Vec<[f64; 2]>>,
    pub(super) is_even_odd: bool,
}

impl Region {
    fn n_edges(&self) -> usize {
        let rings = self.shapes.iter().flat_map(|shape| &shape.rings);
        rings.map(Vec::len).sum()
    }

    fn contains(&self, point: [f64; 2]) -> bool {
        self.shapes.iter().any(|shape| shape.contains(point))
    }
}

impl Shape {
    /// By the number of turns around the point.
    fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let mut turns = 0_i64;
        for [[ax, ay], [bx, by]] in self.rings.iter().flat_map(|ring| edges(ring)) {
            if (ay <= y) != (by <= y) {
                let side = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
                if by > ay && side > 0.0 {
                    turns += 1;
                } else if by < ay && side < 0.0 {
                    turns -= 1;
                }
            }
        }
        if self.is_even_odd {
            turns % 2 != 0
        } else {
            turns != 0
        }
    }
}

/// The edges of a ring, whether or not it ends where it starts.
fn edges(ring: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| [*a, *b])
}

/// Whether the point is on the page and inside all regions.
pub(super) fn is_inside<'r>(
    point: [f64; 2],
    [width, height]: [f64; 2],
    mut regions: impl Iterator<Item = &'r Region>,
) -> bool {
    let [x, y] = point;
    (0.0..=width).contains(&x)
        && (0.0..=height).contains(&y)
        && regions.all(|region| region.contains(point))
}

/// The parts of a polyline on the page and inside all regions. None once `pairs_left` ran out.
pub(super) fn clipped(
    line: &[[f64; 2]],
    [width, height]: [f64; 2],
    regions: &[&Region],
    pairs_left: &mut u64,
) -> Option<Vec<Vec<[f64; 2]>>> {
    let n_edges: usize = regions.iter().map(|region| region.n_edges()).sum();
    let n_pairs = u64::try_from(n_edges.saturating_mul(line.len())).unwrap_or(u64::MAX);
    *pairs_left = pairs_left.checked_sub(n_pairs)?;
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut is_joined = false;
    let mut stops: Vec<f64> = Vec::new();
    for ends in line.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        let Some([start, end]) = on_page(a, b, [width, height]) else {
            is_joined = false;
            continue;
        };
        stops.clear();
        stops.extend([start, end]);
        for region in regions {
            for edge in region
                .shapes
                .iter()
                .flat_map(|shape| &shape.rings)
                .flat_map(|ring| edges(ring))
            {
                stops.extend(crossing(a, b, edge).filter(|t| start < *t && *t < end));
            }
        }
        stops.sort_unstable_by(f64::total_cmp);
        let at = |t: f64| -> [f64; 2] {
            if t <= 0.0 {
                return a;
            }
            if t >= 1.0 {
                return b;
            }
            let point = [0, 1].map(|k| a[k] + (b[k] - a[k]) * t);
            // Rounding must not leave the page.
            [point[0].clamp(0.0, width), point[1].clamp(0.0, height)]
        };
        for pair in stops.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let middle = at(0.5 * (from + to));
            if from >= to || !regions.iter().all(|region| region.contains(middle)) {
                is_joined = is_joined && from >= to;
                continue;
            }
            match parts.last_mut() {
                Some(part) if is_joined => part.push(at(to)),
                _ => parts.push(vec![at(from), at(to)]),
            }
            is_joined = true;
        }
        is_joined = is_joined && end >= 1.0;
    }
    Some(parts)
}

/// Where a line is on the page, as the part of its length.
fn on_page(a: [f64; 2], b: [f64; 2], size: [f64; 2]) -> Option<[f64; 2]> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        for (at_a, at_b) in [(a[k], b[k]), (size[k] - a[k], size[k] - b[k])] {
            if at_a < 0.0 && at_b < 0.0 {
                return None;
            }
            if at_a < 0.0 {
                start = start.max(at_a / (at_a - at_b));
            } else if at_b < 0.0 {
                end = end.min(at_a / (at_a - at_b));
            }
        }
    }
    (start <= end).then_some([start, end])
}

/// Where a line crosses an edge, as the part of its length.
fn crossing(a: [f64; 2], b: [f64; 2], [c, d]: [[f64; 2]; 2]) -> Option<f64> {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let (at_a, at_b) = (side(c, d, a), side(c, d, b));
    let (at_c, at_d) = (side(a, b, c), side(a, b, d));
    let meets = (at_a > 0.0) != (at_b > 0.0) && (at_c > 0.0) != (at_d > 0.0);
    meets.then(|| at_a / (at_a - at_b))
}
