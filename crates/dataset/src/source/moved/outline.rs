//! Outlines of objects, moved and cut to the frame.

use super::{MovedFrame, between, hundredth};

/// A moved line this near to a straight one is taken for it, px. FIT
const STRAIGHT_PX: f64 = 0.05;

/// Shorter lines stay straight, px.
const SHORT_PX: f64 = 1.0;

impl MovedFrame {
    /// The outline of what lies in an outline, with more corners where its lines are bent; without any where nothing of it
    /// is left in the frame.
    pub(in crate::source) fn outline(&self, corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let corners = self.cut_outline(corners.to_vec());
        let mut moved = Vec::with_capacity(corners.len());
        for (k, from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            let ends = [*from, to].map(|at| (at, self.point_anywhere(at)));
            moved.push(ends[0].1);
            self.bend(ends, &mut moved);
        }
        let mut moved = self.cut_outline(moved);
        for at in &mut moved {
            *at = at.map(hundredth);
        }
        moved.dedup();
        while moved.len() > 1 && moved.first() == moved.last() {
            moved.pop();
        }
        // Half of a pixel's hundredth is what rounding leaves of nothing.
        match moved.len() > 2 && area_px2(&moved) >= 0.005 {
            true => moved,
            false => Vec::new(),
        }
    }

    /// Adds corners between two places, each with where it is seen.
    fn bend(&self, [from, to]: [([f64; 2], [f64; 2]); 2], moved: &mut Vec<[f64; 2]>) {
        let length_px = distance(from.0, to.0);
        let is_straight = [0.25, 0.5, 0.75].into_iter().all(|share| {
            let seen = self.point_anywhere(between(from.0, to.0, share));
            distance(seen, nearest(from.1, to.1, seen)) <= STRAIGHT_PX
        });
        if is_straight || length_px < SHORT_PX {
            return;
        }
        let half = between(from.0, to.0, 0.5);
        let half = (half, self.point_anywhere(half));
        self.bend([from, half], moved);
        moved.push(half.1);
        self.bend([half, to], moved);
    }

    /// The part of an outline in the frame [SutherlandHodgman1974].
    fn cut_outline(&self, mut corners: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        for (axis, sign, limit) in [
            (0, -1.0, 0.0),
            (0, 1.0, self.size[0]),
            (1, -1.0, 0.0),
            (1, 1.0, self.size[1]),
        ] {
            let beyond = |at: &[f64; 2]| sign * (at[axis] - limit);
            if corners.iter().all(|at| beyond(at) <= 0.0) {
                continue;
            }
            let mut cut = Vec::with_capacity(corners.len() + 4);
            for (k, from) in corners.iter().enumerate() {
                let to = corners[(k + 1) % corners.len()];
                let [a, b] = [beyond(from), beyond(&to)];
                if a <= 0.0 {
                    cut.push(*from);
                }
                if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                    let mut at = between(*from, to, a / (a - b));
                    at[axis] = limit;
                    cut.push(at);
                }
            }
            corners = cut;
        }
        corners
    }
}

/// The area within an outline, px².
pub(in crate::source) fn area_px2(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let twice: f64 = corners
        .iter()
        .zip(next)
        .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
        .sum();
    0.5 * twice.abs()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// The place of a straight way that is nearest to a point.
fn nearest(from: [f64; 2], to: [f64; 2], point: [f64; 2]) -> [f64; 2] {
    let along = [to[0] - from[0], to[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let dot = along[0] * (point[0] - from[0]) + along[1] * (point[1] - from[1]);
    match square > 0.0 {
        true => between(from, to, (dot / square).clamp(0.0, 1.0)),
        false => from,
    }
}
