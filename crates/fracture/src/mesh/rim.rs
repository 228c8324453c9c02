//! Nodes on the border of a plate's mesh: the pane's rim and the circle that cuts it.

use std::f64::consts::PI;

use super::Outline;
use super::grading::{Domain, Grading};

/// A node on the border of the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct BorderNode {
    pub(super) position_m: [f64; 2],
    pub(super) is_on_rim: bool,
    pub(super) is_on_cut: bool,
    is_corner: bool,
}

/// A piece of the border, from its start in the order of increasing angle.
#[derive(Debug, Clone, Copy)]
enum Piece {
    /// Part of a side of a rectangle.
    Side { from: [f64; 2], to: [f64; 2] },
    /// Arc of a circle.
    Arc {
        around: [f64; 2],
        radius: f64,
        start: f64,
        sweep: f64,
        is_cut: bool,
    },
}

impl Piece {
    fn length(&self) -> f64 {
        match *self {
            Self::Side { from, to } => libm::hypot(to[0] - from[0], to[1] - from[1]),
            Self::Arc { radius, sweep, .. } => radius * sweep,
        }
    }

    fn at(&self, along: f64) -> [f64; 2] {
        match *self {
            Self::Side { from, to } => {
                // Sides are parallel to an axis, so that one coordinate stays exactly what it is.
                let t = along / self.length();
                [
                    from[0] + t * (to[0] - from[0]),
                    from[1] + t * (to[1] - from[1]),
                ]
            }
            Self::Arc {
                around,
                radius,
                start,
                ..
            } => {
                let (sin, cos) = libm::sincos(start + along / radius);
                [around[0] + radius * cos, around[1] + radius * sin]
            }
        }
    }

    /// Distances along the piece at which its nodes lie: its start, and in between so many that
    /// each gap is what the grading says.
    fn divisions(&self, grading: &Grading) -> Vec<f64> {
        let length = self.length();
        // Number of gaps up to each place: ∫ ds / size.
        let mut table = vec![(0.0, 0.0)];
        let (mut at, mut gaps) = (0.0_f64, 0.0);
        while at < length {
            let size = grading.size_at_m(self.at(at));
            let next = (at + 0.2 * size).min(length);
            let middle = grading.size_at_m(self.at(0.5 * (at + next)));
            gaps += (next - at) / middle;
            at = next;
            table.push((at, gaps));
        }
        let least = match self {
            Self::Arc { sweep, .. } if *sweep > PI => 8.0,
            _ => 1.0,
        };
        let n = gaps.round().max(least);
        let mut places = Vec::new();
        let mut k = 0.0;
        for pair in table.windows(2) {
            let [(from, low), (to, high)] = [pair[0], pair[1]];
            while k < n && k * gaps / n < high {
                let t = ((k * gaps / n - low) / (high - low)).max(0.0);
                places.push(from + t * (to - from));
                k += 1.0;
            }
        }
        places
    }
}

/// The nodes of the border, in order around it, none too near to the next.
pub(super) fn border(grading: &Grading) -> Vec<BorderNode> {
    let domain = &grading.domain;
    let pieces = match domain.outline {
        Outline::Rectangle { width_m, height_m } => around_rectangle(domain, width_m, height_m),
        Outline::Disc { diameter_m } => around_disc(domain, 0.5 * diameter_m),
    };
    let mut nodes: Vec<BorderNode> = Vec::new();
    let is_cut = |piece: &Piece| matches!(piece, Piece::Arc { is_cut: true, .. });
    for (idx, piece) in pieces.iter().enumerate() {
        let before = &pieces[(idx + pieces.len() - 1) % pieces.len()];
        for (k, along) in piece.divisions(grading).into_iter().enumerate() {
            let mut node = BorderNode {
                position_m: piece.at(along),
                is_on_rim: !is_cut(piece),
                is_on_cut: is_cut(piece),
                is_corner: false,
            };
            if k == 0 {
                node.is_on_rim |= !is_cut(before);
                node.is_on_cut |= is_cut(before);
                if let (Piece::Side { to, .. }, Piece::Arc { .. }) = (before, piece) {
                    node.position_m = *to;
                }
                let is_side = |piece: &Piece| matches!(piece, Piece::Side { .. });
                node.is_corner = is_side(before) && is_side(piece);
            }
            if let Outline::Rectangle { width_m, height_m } = domain.outline {
                let [x, y] = node.position_m;
                node.position_m = [x.clamp(0.0, width_m), y.clamp(0.0, height_m)];
            }
            nodes.push(node);
        }
    }
    thin_out(&nodes, grading)
}

/// Drops nodes that are nearly the same as the one before, corners of the pane last.
fn thin_out(nodes: &[BorderNode], grading: &Grading) -> Vec<BorderNode> {
    let is_near = |a: &BorderNode, b: &BorderNode| {
        let [dx, dy] = [0, 1].map(|k| a.position_m[k] - b.position_m[k]);
        libm::hypot(dx, dy) < 0.5 * grading.size_at_m(a.position_m)
    };
    // Two corners both stay.
    let mergeable = |a: &BorderNode, b: &BorderNode| !(a.is_corner && b.is_corner) && is_near(a, b);
    let merge = |a: &BorderNode, b: &BorderNode| {
        let stays = if b.is_corner { b } else { a };
        BorderNode {
            is_on_rim: a.is_on_rim || b.is_on_rim,
            is_on_cut: a.is_on_cut || b.is_on_cut,
            ..*stays
        }
    };
    let mut kept: Vec<BorderNode> = Vec::with_capacity(nodes.len());
    for node in nodes {
        match kept.last_mut() {
            Some(last) if mergeable(last, node) => *last = merge(last, node),
            _ => kept.push(*node),
        }
    }
    while kept.len() > 3 && mergeable(&kept[kept.len() - 1], &kept[0]) {
        if let Some(last) = kept.pop() {
            kept[0] = merge(&last, &kept[0]);
        }
    }
    kept
}

/// Moves the node of the border that is nearest to `point`, a place on the border, to it and gives
/// its number. Corners stay where they are, and so does what has been moved before.
pub(super) fn move_nearest(
    border: &mut [BorderNode],
    is_taken: &mut [bool],
    domain: &Domain,
    point: [f64; 2],
) -> Option<usize> {
    let away = |node: &BorderNode| {
        let [x, y] = node.position_m;
        libm::hypot(x - point[0], y - point[1])
    };
    let (idx, _) = border
        .iter()
        .map(away)
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let node = &mut border[idx];
    let stays = node.is_corner || (node.is_on_rim && node.is_on_cut);
    if !std::mem::replace(&mut is_taken[idx], true) && !stays {
        let on_circle = |around: [f64; 2], radius: f64| {
            let offset = [point[0] - around[0], point[1] - around[1]];
            let factor = radius / libm::hypot(offset[0], offset[1]);
            [
                around[0] + factor * offset[0],
                around[1] + factor * offset[1],
            ]
        };
        let old = node.position_m;
        #[expect(clippy::float_cmp, reason = "on a side means exactly on it")]
        let new = match domain.outline {
            _ if node.is_on_cut => on_circle(domain.center_m, domain.radius_m),
            Outline::Rectangle { width_m, .. } if old[0] == 0.0 || old[0] == width_m => {
                [old[0], point[1]]
            }
            Outline::Rectangle { .. } => [point[0], old[1]],
            Outline::Disc { diameter_m } => on_circle([0.5 * diameter_m; 2], 0.5 * diameter_m),
        };
        if new.iter().all(|x| x.is_finite()) {
            node.position_m = new;
        }
    }
    Some(idx)
}

fn around_rectangle(domain: &Domain, width: f64, height: f64) -> Vec<Piece> {
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    let (center, radius) = (domain.center_m, domain.radius_m);
    let mut sides = Vec::new();
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let axis = k % 2;
        let distance = (center[1 - axis] - a[1 - axis]).abs();
        if distance >= radius {
            continue;
        }
        let half = (radius * radius - distance * distance).sqrt();
        let (low, high) = (center[axis] - half, center[axis] + half);
        let clip = |mut p: [f64; 2]| {
            p[axis] = p[axis].clamp(low, high);
            p
        };
        let (from, to) = (clip(a), clip(b));
        // A side that the circle does not reach is clipped to one point.
        if (to[axis] - from[axis]) * (b[axis] - a[axis]) > 0.0 {
            sides.push((from, to));
        }
    }
    let angle = |p: [f64; 2]| libm::atan2(p[1] - center[1], p[0] - center[0]);
    let cut = |start: f64, sweep: f64| Piece::Arc {
        around: center,
        radius,
        start,
        sweep,
        is_cut: true,
    };
    if sides.is_empty() {
        return vec![cut(0.0, 2.0 * PI)];
    }
    let mut pieces = Vec::new();
    for (k, &(from, to)) in sides.iter().enumerate() {
        pieces.push(Piece::Side { from, to });
        let next = sides[(k + 1) % sides.len()].0;
        #[expect(
            clippy::float_cmp,
            reason = "sides that the circle leaves whole share a corner"
        )]
        let is_cut = to != next;
        if is_cut {
            let start = angle(to);
            let mut sweep = angle(next) - start;
            if sweep <= 0.0 {
                sweep += 2.0 * PI;
            }
            pieces.push(cut(start, sweep));
        }
    }
    pieces
}

fn around_disc(domain: &Domain, disc_radius: f64) -> Vec<Piece> {
    let (center, radius) = (domain.center_m, domain.radius_m);
    let [dx, dy] = [center[0] - disc_radius, center[1] - disc_radius];
    let offset = libm::hypot(dx, dy);
    // Towards the center of the rings; where they have the disc's, any direction does.
    let towards = libm::atan2(dy, dx);
    let rim = |start: f64, sweep: f64| Piece::Arc {
        around: [disc_radius; 2],
        radius: disc_radius,
        start,
        sweep,
        is_cut: false,
    };
    let cut = |start: f64, sweep: f64| Piece::Arc {
        around: center,
        radius,
        start,
        sweep,
        is_cut: true,
    };
    if radius >= disc_radius + offset {
        return vec![rim(towards, 2.0 * PI)];
    }
    if radius <= disc_radius - offset {
        return vec![cut(0.0, 2.0 * PI)];
    }
    // Angles of the triangle of both centers and a point where the circles cross.
    let angle = |near: f64, far: f64| {
        libm::acos(
            ((near * near + offset * offset - far * far) / (2.0 * near * offset)).clamp(-1.0, 1.0),
        )
    };
    let (alpha, beta) = (angle(disc_radius, radius), angle(radius, disc_radius));
    vec![
        rim(towards - alpha, 2.0 * alpha),
        cut(towards + PI - beta, 2.0 * beta),
    ]
}
