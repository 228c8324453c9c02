//! The rim of a pane: which points lie on it, in which order, and what its arcs enclose.

use std::f64::consts::TAU;

use crate::Pane;

/// The rim of a pane.
///
/// It is walked from +x towards +y, starting at the corner (0, 0) of a rectangle and at the top
/// of a disc, so that the pane lies on the left in coordinates whose y is up.
pub(super) struct Rim {
    width: f64,
    height: f64,
    tolerance: f64,
    is_disc: bool,
}

/// A point on the rim.
#[derive(Debug, Clone, Copy)]
pub(super) struct RimPoint {
    /// Grows along the rim.
    pub(super) place: f64,
    /// The nearest point that lies on the rim to the last bit.
    pub(super) at: [f64; 2],
    /// Direction out of the pane, as long as the pane is large.
    pub(super) outward: [f64; 2],
    /// Sides of the rectangle that it lies on, one bit each: top, right, bottom, left.
    sides: u8,
}

/// Length, area and area times centroid of what lies between a piece of rim and its chord.
pub(super) struct Bulge {
    pub(super) length: f64,
    pub(super) area: f64,
    pub(super) moment: [f64; 2],
}

const TOP: u8 = 1;
const RIGHT: u8 = 2;
const BOTTOM: u8 = 4;
const LEFT: u8 = 8;

impl RimPoint {
    /// Whether both lie on one side of a rectangle, so that what joins them is the rim itself.
    pub(super) fn shares_side(&self, other: &Self) -> bool {
        self.sides & other.sides != 0
    }
}

impl Rim {
    pub(super) fn of(pane: &Pane) -> Self {
        Self {
            width: pane.width,
            height: pane.height,
            tolerance: pane.rim_tolerance(),
            is_disc: pane.is_disc(),
        }
    }

    /// Points that the rim has without any crack: the corners, or one point of a circle, which
    /// is needed only where there is no other.
    pub(super) fn own_points(&self) -> Vec<[f64; 2]> {
        let (w, h) = (self.width, self.height);
        if self.is_disc {
            vec![[0.5 * w, 0.0]]
        } else {
            vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]
        }
    }

    /// Whether own points are needed beside others.
    pub(super) fn has_corners(&self) -> bool {
        !self.is_disc
    }

    /// Where on the rim a point lies, if it does.
    pub(super) fn find(&self, [x, y]: [f64; 2]) -> Option<RimPoint> {
        if self.is_disc {
            return self.find_on_circle([x, y]);
        }
        let (w, h) = (self.width, self.height);
        let sides = [y, w - x, h - y, x]
            .iter()
            .zip([TOP, RIGHT, BOTTOM, LEFT])
            .filter(|(distance, _)| **distance <= self.tolerance)
            .fold(0, |sides, (_, side)| sides | side);
        let on = |side: u8| sides & side != 0;
        let snap = |value: f64, low: bool, high: bool, size: f64| match (low, high) {
            (true, _) => 0.0,
            (_, true) => size,
            _ => value,
        };
        let at = [
            snap(x, on(LEFT), on(RIGHT), w),
            snap(y, on(TOP), on(BOTTOM), h),
        ];
        let place = match () {
            () if on(TOP) => at[0],
            () if on(RIGHT) => w + at[1],
            () if on(BOTTOM) => 2.0 * w + h - at[0],
            () if on(LEFT) => 2.0 * (w + h) - at[1],
            () => return None,
        };
        let step = |low: u8, high: u8, size: f64| match (on(low), on(high)) {
            (true, _) => -size,
            (_, true) => size,
            _ => 0.0,
        };
        Some(RimPoint {
            place,
            at,
            outward: [step(LEFT, RIGHT, w), step(TOP, BOTTOM, h)],
            sides,
        })
    }

    fn find_on_circle(&self, [x, y]: [f64; 2]) -> Option<RimPoint> {
        let radius = 0.5 * self.width;
        let (dx, dy) = (x - radius, y - radius);
        let distance = (dx * dx + dy * dy).sqrt();
        if (distance - radius).abs() > self.tolerance {
            return None;
        }
        let (u, v) = (dx / distance, dy / distance);
        // Grows with the angle from the top and needs no angle.
        let slope = v / (u.abs() + v.abs());
        Some(RimPoint {
            place: if u >= 0.0 { 1.0 + slope } else { 3.0 - slope },
            at: [radius + radius * u, radius + radius * v],
            outward: [dx, dy],
            sides: 0,
        })
    }

    /// Whether a point of the rim comes before the place where a ray from `y` in the pane
    /// towards +x leaves it; a point at the very height counts as before.
    pub(super) fn is_before_exit(&self, point: &RimPoint, point_y: f64, y: f64) -> bool {
        if self.is_disc {
            point.place < 2.0 && point_y <= y
        } else {
            point.sides & TOP != 0 || (point.sides & RIGHT != 0 && point_y <= y)
        }
    }

    /// What the rim from one of its points to the next encloses with the chord between them.
    pub(super) fn bulge(&self, from: &RimPoint, to: &RimPoint) -> Bulge {
        let (dx, dy) = (to.at[0] - from.at[0], to.at[1] - from.at[1]);
        if !self.is_disc {
            return Bulge {
                length: (dx * dx + dy * dy).sqrt(),
                area: 0.0,
                moment: [0.0; 2],
            };
        }
        let radius = 0.5 * self.width;
        let angle = |point: &RimPoint| libm::atan2(point.outward[1], point.outward[0]);
        let start = angle(from);
        let turn = angle(to) - start;
        let turn = if turn > 0.0 { turn } else { turn + TAU };
        let (sin, _) = libm::sincos(0.5 * turn);
        let (sin_middle, cos_middle) = libm::sincos(start + 0.5 * turn);
        // Circular segment: area r²(θ − sin θ)/2, centroid 4r sin³(θ/2)/3(θ − sin θ) from the
        // centre, so that their product needs no division.
        let area = 0.5 * radius * radius * (turn - libm::sin(turn));
        let arm = 2.0 / 3.0 * radius * radius * radius * sin * sin * sin;
        Bulge {
            length: radius * turn,
            area,
            moment: [
                area * radius + arm * cos_middle,
                area * radius + arm * sin_middle,
            ],
        }
    }
}
