//! Transforms of SVG.

use svgtypes::{Align, AspectRatio, TransformListParser, TransformListToken, ViewBox};

/// x′ = a·x + c·y + e, y′ = b·x + d·y + f.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affine {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    pub(super) d: f64,
    pub(super) e: f64,
    pub(super) f: f64,
}

impl Affine {
    pub(super) const IDENTITY: Self = Self::of([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    pub(super) const fn of([a, b, c, d, e, f]: [f64; 6]) -> Self {
        Self { a, b, c, d, e, f }
    }

    pub(super) fn scale(sx: f64, sy: f64) -> Self {
        Self::of([sx, 0.0, 0.0, sy, 0.0, 0.0])
    }

    pub(super) fn translate(tx: f64, ty: f64) -> Self {
        Self::of([1.0, 0.0, 0.0, 1.0, tx, ty])
    }

    /// First `inner`, then this one.
    pub(super) fn after(&self, inner: &Self) -> Self {
        let [a, b] = self.direction([inner.a, inner.b]);
        let [c, d] = self.direction([inner.c, inner.d]);
        let [e, f] = self.point([inner.e, inner.f]);
        Self::of([a, b, c, d, e, f])
    }

    pub(super) fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = self.direction([x, y]);
        [dx + self.e, dy + self.f]
    }

    /// Of a difference of two points.
    pub(super) fn direction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.a * x + self.c * y, self.b * x + self.d * y]
    }

    /// The transform of a `transform` attribute.
    pub(super) fn parse(text: &str) -> Result<Self, svgtypes::Error> {
        let mut all = Self::IDENTITY;
        for token in TransformListParser::from(text) {
            let one = match token? {
                TransformListToken::Matrix { a, b, c, d, e, f } => Self::of([a, b, c, d, e, f]),
                TransformListToken::Translate { tx, ty } => Self::translate(tx, ty),
                TransformListToken::Scale { sx, sy } => Self::scale(sx, sy),
                TransformListToken::Rotate { angle } => {
                    let (sin, cos) = libm::sincos(angle.to_radians());
                    Self::of([cos, sin, -sin, cos, 0.0, 0.0])
                }
                TransformListToken::SkewX { angle } => {
                    Self::of([1.0, 0.0, libm::tan(angle.to_radians()), 1.0, 0.0, 0.0])
                }
                TransformListToken::SkewY { angle } => {
                    Self::of([1.0, libm::tan(angle.to_radians()), 0.0, 1.0, 0.0, 0.0])
                }
            };
            all = all.after(&one);
        }
        Ok(all)
    }

    /// How a view box fills a viewport of this width and height at the origin.
    pub(super) fn of_view_box(view: &ViewBox, [width, height]: [f64; 2], fit: AspectRatio) -> Self {
        let (mut sx, mut sy) = (width / view.w, height / view.h);
        if fit.align != Align::None {
            let scale = if fit.slice { sx.max(sy) } else { sx.min(sy) };
            (sx, sy) = (scale, scale);
        }
        let (free_x, free_y) = (width - view.w * sx, height - view.h * sy);
        let (part_x, part_y) = match fit.align {
            Align::None | Align::XMinYMin => (0.0, 0.0),
            Align::XMidYMin => (0.5, 0.0),
            Align::XMaxYMin => (1.0, 0.0),
            Align::XMinYMid => (0.0, 0.5),
            Align::XMidYMid => (0.5, 0.5),
            Align::XMaxYMid => (1.0, 0.5),
            Align::XMinYMax => (0.0, 1.0),
            Align::XMidYMax => (0.5, 1.0),
            Align::XMaxYMax => (1.0, 1.0),
        };
        Self::of([
            sx,
            0.0,
            0.0,
            sy,
            part_x * free_x - view.x * sx,
            part_y * free_y - view.y * sy,
        ])
    }
}
