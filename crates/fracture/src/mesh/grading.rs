//! Where the nodes of a plate's mesh lie: rings around a center that grow with their radius.

use std::f64::consts::PI;

use super::Outline;

/// The part of the pane that is meshed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Domain {
    pub(super) outline: Outline,
    pub(super) center_m: [f64; 2],
    /// Radius of the artificial circle around the center; infinite where the whole pane is meshed.
    pub(super) radius_m: f64,
}

impl Domain {
    pub(super) fn new(outline: Outline, center_m: [f64; 2], radius_m: Option<f64>) -> Self {
        let mut domain = Self {
            outline,
            center_m,
            radius_m: f64::INFINITY,
        };
        if let Some(radius_m) = radius_m
            && radius_m < domain.reach_m()
        {
            domain.radius_m = radius_m;
        }
        domain
    }

    /// Distance from the center to the point of the domain that is farthest from it, m.
    pub(super) fn reach_m(&self) -> f64 {
        let [x, y] = self.center_m;
        let pane = match self.outline {
            Outline::Rectangle { width_m, height_m } => {
                libm::hypot(x.max(width_m - x), y.max(height_m - y))
            }
            Outline::Disc { diameter_m } => {
                let r = 0.5 * diameter_m;
                r + libm::hypot(x - r, y - r)
            }
        };
        pane.min(self.radius_m)
    }

    /// Distance to the border of the domain, m: positive inside.
    pub(super) fn depth_m(&self, point: [f64; 2]) -> f64 {
        self.outline
            .depth_m(point)
            .min(self.radius_m - self.distance_m(point))
    }

    /// Distance to the center, m.
    pub(super) fn distance_m(&self, [x, y]: [f64; 2]) -> f64 {
        libm::hypot(x - self.center_m[0], y - self.center_m[1])
    }
}

/// How far nodes are apart, as a function of the distance to the center.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grading {
    pub(super) domain: Domain,
    /// Number of nodes of a ring, from where rings grow.
    n_around: u32,
    /// Distance between nodes at the center, m.
    inner_m: f64,
    /// Greatest distance between nodes of the border, m: half the width of a narrow pane.
    cap_m: f64,
}

impl Grading {
    /// Rings of `n_around` nodes. A center that is too coarse for them, as in a small pane, is
    /// made finer than `inner_m`, so that more around is always more in all.
    pub(super) fn new(domain: Domain, n_around: u32, inner_m: f64, target: u32) -> Self {
        let [width, height] = domain.outline.size_m();
        let cap_m = (0.5 * width.min(height)).max(8.0 * (width + height) / f64::from(target));
        let finest = 0.25 * domain.reach_m() * 2.0 * PI / f64::from(n_around);
        Self {
            domain,
            n_around,
            inner_m: inner_m.min(finest),
            cap_m,
        }
    }

    /// Distance between nodes at a point, m: constant near the center, then in proportion to r.
    pub(super) fn size_at_m(&self, point: [f64; 2]) -> f64 {
        let growth = 2.0 * PI / f64::from(self.n_around);
        (growth * self.domain.distance_m(point))
            .max(self.inner_m)
            .min(self.cap_m)
    }

    /// The nodes inside the domain, from the center outwards. Rings of 6, 12, 18, … nodes, then
    /// staggered rings of one count whose radii grow so that their triangles are equilateral:
    /// r ← r exp(√3 π / n).
    pub(super) fn interior(&self) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        self.keep(self.domain.center_m, &mut points);
        let reach = self.domain.reach_m();
        let mut radius = self.inner_m;
        let mut n = 6;
        while n < self.n_around && radius < reach {
            let step = 2.0 * PI / f64::from(n);
            for k in 0..n {
                let (sin, cos) = libm::sincos(step * f64::from(k));
                self.keep_at(radius, [cos, sin], &mut points);
            }
            n += 6;
            radius += self.inner_m;
        }
        let n = self.n_around;
        let half = PI / f64::from(n);
        let directions: Vec<[f64; 2]> = (0..2 * n)
            .map(|k| {
                let (sin, cos) = libm::sincos(half * f64::from(k));
                [cos, sin]
            })
            .collect();
        let factor = libm::exp(3.0_f64.sqrt() * half);
        let mut phase = 0;
        while radius < reach {
            for direction in directions.iter().skip(phase).step_by(2) {
                self.keep_at(radius, *direction, &mut points);
            }
            phase = 1 - phase;
            radius *= factor;
        }
        points
    }

    fn keep_at(&self, radius_m: f64, [cos, sin]: [f64; 2], points: &mut Vec<[f64; 2]>) {
        let [x, y] = self.domain.center_m;
        self.keep([x + radius_m * cos, y + radius_m * sin], points);
    }

    /// Keeps a point that is not so near to the border that it makes a flat triangle with it.
    fn keep(&self, point: [f64; 2], points: &mut Vec<[f64; 2]>) {
        if self.domain.depth_m(point) >= 0.55 * self.size_at_m(point) {
            points.push(point);
        }
    }
}
