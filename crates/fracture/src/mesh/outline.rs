//! The rim of a pane.

/// What a pane is bounded by, in m; its bounding box is `[0, width] × [0, height]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// A rectangle.
    Rectangle {
        /// Width, m.
        width_m: f64,
        /// Height, m.
        height_m: f64,
    },
    /// A disc around (d/2, d/2).
    Disc {
        /// Diameter d, m.
        diameter_m: f64,
    },
}

impl Outline {
    /// Width and height of the bounding box, m.
    #[must_use]
    pub fn size_m(&self) -> [f64; 2] {
        match *self {
            Self::Rectangle { width_m, height_m } => [width_m, height_m],
            Self::Disc { diameter_m } => [diameter_m, diameter_m],
        }
    }

    /// Area, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        match *self {
            Self::Rectangle { width_m, height_m } => width_m * height_m,
            Self::Disc { diameter_m } => 0.25 * std::f64::consts::PI * diameter_m * diameter_m,
        }
    }

    /// Signed distance to the rim, m: positive inside the pane.
    #[must_use]
    pub fn depth_m(&self, [x, y]: [f64; 2]) -> f64 {
        match *self {
            Self::Rectangle { width_m, height_m } => {
                let (dx, dy) = (x.min(width_m - x), y.min(height_m - y));
                if dx >= 0.0 && dy >= 0.0 {
                    dx.min(dy)
                } else {
                    -libm::hypot(dx.min(0.0), dy.min(0.0))
                }
            }
            Self::Disc { diameter_m } => {
                let r = 0.5 * diameter_m;
                r - libm::hypot(x - r, y - r)
            }
        }
    }

    /// Fraction of the way from `from` (inside) to `to` at which the straight line leaves the
    /// pane; `None` if it does not.
    #[must_use]
    pub fn exit(&self, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
        if self.depth_m(to) >= 0.0 {
            return None;
        }
        let delta = [to[0] - from[0], to[1] - from[1]];
        match *self {
            Self::Rectangle { width_m, height_m } => {
                let mut t = 1.0_f64;
                for (at, step, side) in
                    [(from[0], delta[0], width_m), (from[1], delta[1], height_m)]
                {
                    if at + step < 0.0 {
                        t = t.min(at / -step);
                    } else if at + step > side {
                        t = t.min((side - at) / step);
                    }
                }
                Some(t.clamp(0.0, 1.0))
            }
            Self::Disc { diameter_m } => {
                let r = 0.5 * diameter_m;
                let p = [from[0] - r, from[1] - r];
                let a = delta[0] * delta[0] + delta[1] * delta[1];
                let b = p[0] * delta[0] + p[1] * delta[1];
                let c = p[0] * p[0] + p[1] * p[1] - r * r;
                let root = (b * b - a * c).max(0.0).sqrt();
                Some(((-b + root) / a).clamp(0.0, 1.0))
            }
        }
    }
}
