//! Shapes of SVG to polylines.
//!
//! A curve p(t) over a step h lies within h²/8·max|p″| of its chord; steps are chosen by that, on
//! the page, after the transform.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use svgtypes::{PathParser, PathSegment};

use super::transform::Affine;

/// How far a chord may be from its curve, in the page's unit.
pub(super) const FLATNESS: f64 = 0.02;

/// Most points of a drawing, in all.
pub(super) const MAX_POINTS: usize = 1 << 20;

/// The points ran out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OutOfPoints;

/// Polylines on the page; a closed one ends where it starts.
#[derive(Debug)]
pub(super) struct Outline<'a> {
    to_page: &'a Affine,
    points_left: &'a mut usize,
    pub(super) lines: Vec<Vec<[f64; 2]>>,
    start: [f64; 2],
    at: [f64; 2],
    /// Whether the next segment begins a new polyline.
    is_up: bool,
}

impl<'a> Outline<'a> {
    pub(super) fn new(to_page: &'a Affine, points_left: &'a mut usize) -> Self {
        Self {
            to_page,
            points_left,
            lines: Vec::new(),
            start: [0.0; 2],
            at: [0.0; 2],
            is_up: true,
        }
    }

    pub(super) fn move_to(&mut self, point: [f64; 2]) {
        (self.start, self.at, self.is_up) = (point, point, true);
    }

    pub(super) fn line_to(&mut self, point: [f64; 2]) -> Result<(), OutOfPoints> {
        self.begin()?;
        self.push(self.to_page.point(point))?;
        self.at = point;
        Ok(())
    }

    pub(super) fn close(&mut self) -> Result<(), OutOfPoints> {
        if !self.is_up {
            self.line_to(self.start)?;
        }
        self.move_to(self.start);
        Ok(())
    }

    /// Through `c` to `p`.
    fn quadratic(&mut self, c: [f64; 2], p: [f64; 2]) -> Result<(), OutOfPoints> {
        self.begin()?;
        let [p0, p1, p2] = [self.at, c, p].map(|point| self.to_page.point(point));
        // p″ = 2(p0 − 2p1 + p2).
        let n = steps(2.0 * bend(p0, p1, p2))?;
        self.curve(n, p2, |t| {
            let s = 1.0 - t;
            [0, 1].map(|k| s * s * p0[k] + 2.0 * s * t * p1[k] + t * t * p2[k])
        })?;
        self.at = p;
        Ok(())
    }

    fn cubic(&mut self, c: [f64; 2], d: [f64; 2], p: [f64; 2]) -> Result<(), OutOfPoints> {
        self.begin()?;
        let [p0, p1, p2, p3] = [self.at, c, d, p].map(|point| self.to_page.point(point));
        // p″ runs straight from 6(p0 − 2p1 + p2) to 6(p1 − 2p2 + p3).
        let n = steps(6.0 * bend(p0, p1, p2).max(bend(p1, p2, p3)))?;
        self.curve(n, p3, |t| {
            let s = 1.0 - t;
            [0, 1].map(|k| {
                s * s * s * p0[k]
                    + 3.0 * s * s * t * p1[k]
                    + 3.0 * s * t * t * p2[k]
                    + t * t * t * p3[k]
            })
        })?;
        self.at = p;
        Ok(())
    }

    /// The ellipse m + u cos φ + v sin φ from φ = `from` over `sweep`; ends at `end`.
    fn arc(
        &mut self,
        [m, u, v]: [[f64; 2]; 3],
        [from, sweep]: [f64; 2],
        end: [f64; 2],
    ) -> Result<(), OutOfPoints> {
        self.begin()?;
        let m = self.to_page.point(m);
        let [u, v] = [u, v].map(|axis| self.to_page.direction(axis));
        let end_on_page = self.to_page.point(end);
        let square = |p: [f64; 2]| p[0] * p[0] + p[1] * p[1];
        let n = steps(sweep * sweep * (square(u) + square(v)).sqrt())?;
        self.curve(n, end_on_page, |t| {
            let (sin, cos) = libm::sincos(from + sweep * t);
            [0, 1].map(|k| m[k] + u[k] * cos + v[k] * sin)
        })?;
        self.at = end;
        Ok(())
    }

    /// The whole ellipse.
    pub(super) fn ellipse(
        &mut self,
        [cx, cy]: [f64; 2],
        [rx, ry]: [f64; 2],
    ) -> Result<(), OutOfPoints> {
        let start = [cx + rx, cy];
        self.move_to(start);
        self.arc([[cx, cy], [rx, 0.0], [0.0, ry]], [0.0, TAU], start)
    }

    /// A path's arc, by its end points (SVG 2, implementation notes B.2).
    fn svg_arc(
        &mut self,
        [rx, ry]: [f64; 2],
        turn_deg: f64,
        [is_large, is_sweep]: [bool; 2],
        end: [f64; 2],
    ) -> Result<(), OutOfPoints> {
        let [x1, y1] = self.at;
        let [x2, y2] = end;
        let (mut rx, mut ry) = (rx.abs(), ry.abs());
        let (sin, cos) = libm::sincos(turn_deg.to_radians());
        let (hx, hy) = (0.5 * (x1 - x2), 0.5 * (y1 - y2));
        let (x, y) = (cos * hx + sin * hy, cos * hy - sin * hx);
        let is_straight = !(rx > 0.0 && ry > 0.0) || (x == 0.0 && y == 0.0);
        if is_straight {
            return self.line_to(end);
        }
        // Radii too small to reach are stretched.
        let stretch = (x / rx) * (x / rx) + (y / ry) * (y / ry);
        if stretch > 1.0 {
            rx *= stretch.sqrt();
            ry *= stretch.sqrt();
        }
        let away = (x / rx) * (x / rx) + (y / ry) * (y / ry);
        let factor = ((1.0 - away) / away).max(0.0).sqrt();
        let factor = if is_large == is_sweep {
            -factor
        } else {
            factor
        };
        let (mx, my) = (factor * rx * y / ry, -factor * ry * x / rx);
        let from = libm::atan2((y - my) / ry, (x - mx) / rx);
        let to = libm::atan2((-y - my) / ry, (-x - mx) / rx);
        let mut sweep = to - from;
        if is_sweep && sweep < 0.0 {
            sweep += TAU;
        } else if !is_sweep && sweep > 0.0 {
            sweep -= TAU;
        }
        let center = [
            cos * mx - sin * my + 0.5 * (x1 + x2),
            sin * mx + cos * my + 0.5 * (y1 + y2),
        ];
        let axes = [center, [rx * cos, rx * sin], [-ry * sin, ry * cos]];
        self.arc(axes, [from, sweep], end)
    }

    /// The path of a `d` attribute.
    pub(super) fn path(&mut self, text: &str) -> Result<Result<(), svgtypes::Error>, OutOfPoints> {
        // The last control point, where a smooth curve goes on from it.
        let (mut cubic, mut quadratic) = (None, None);
        for segment in PathParser::from(text) {
            let segment = match segment {
                Ok(segment) => segment,
                Err(error) => return Ok(Err(error)),
            };
            let [ox, oy] = if segment.is_abs() { [0.0; 2] } else { self.at };
            let [ax, ay] = self.at;
            let mirrored = |control: Option<[f64; 2]>| {
                control.map_or([ax, ay], |[x, y]| [2.0 * ax - x, 2.0 * ay - y])
            };
            let (mut next_cubic, mut next_quadratic) = (None, None);
            match segment {
                PathSegment::MoveTo { x, y, .. } => self.move_to([ox + x, oy + y]),
                PathSegment::LineTo { x, y, .. } => self.line_to([ox + x, oy + y])?,
                PathSegment::HorizontalLineTo { x, .. } => self.line_to([ox + x, ay])?,
                PathSegment::VerticalLineTo { y, .. } => self.line_to([ax, oy + y])?,
                PathSegment::CurveTo {
                    x1,
                    y1,
                    x2,
                    y2,
                    x,
                    y,
                    ..
                } => {
                    let control = [ox + x2, oy + y2];
                    self.cubic([ox + x1, oy + y1], control, [ox + x, oy + y])?;
                    next_cubic = Some(control);
                }
                PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                    let control = [ox + x2, oy + y2];
                    self.cubic(mirrored(cubic), control, [ox + x, oy + y])?;
                    next_cubic = Some(control);
                }
                PathSegment::Quadratic { x1, y1, x, y, .. } => {
                    let control = [ox + x1, oy + y1];
                    self.quadratic(control, [ox + x, oy + y])?;
                    next_quadratic = Some(control);
                }
                PathSegment::SmoothQuadratic { x, y, .. } => {
                    let control = mirrored(quadratic);
                    self.quadratic(control, [ox + x, oy + y])?;
                    next_quadratic = Some(control);
                }
                PathSegment::EllipticalArc {
                    rx,
                    ry,
                    x_axis_rotation,
                    large_arc,
                    sweep,
                    x,
                    y,
                    ..
                } => {
                    let end = [ox + x, oy + y];
                    self.svg_arc([rx, ry], x_axis_rotation, [large_arc, sweep], end)?;
                }
                PathSegment::ClosePath { .. } => self.close()?,
            }
            (cubic, quadratic) = (next_cubic, next_quadratic);
        }
        Ok(Ok(()))
    }

    /// A rectangle with rounded corners of radii `[rx, ry]`, which fit into it.
    pub(super) fn rectangle(
        &mut self,
        [x, y]: [f64; 2],
        [width, height]: [f64; 2],
        [rx, ry]: [f64; 2],
    ) -> Result<(), OutOfPoints> {
        let (right, bottom) = (x + width, y + height);
        self.move_to([x + rx, y]);
        let sides = [
            ([right - rx, y], [right - rx, y + ry], [right, y + ry]),
            (
                [right, bottom - ry],
                [right - rx, bottom - ry],
                [right - rx, bottom],
            ),
            ([x + rx, bottom], [x + rx, bottom - ry], [x, bottom - ry]),
            ([x, y + ry], [x + rx, y + ry], [x + rx, y]),
        ];
        let mut from = -FRAC_PI_2;
        for (straight, middle, round) in sides {
            self.line_to(straight)?;
            if rx > 0.0 && ry > 0.0 {
                self.arc([middle, [rx, 0.0], [0.0, ry]], [from, 0.5 * PI], round)?;
            }
            from += FRAC_PI_2;
        }
        self.close()
    }

    fn begin(&mut self) -> Result<(), OutOfPoints> {
        if std::mem::replace(&mut self.is_up, false) {
            self.lines.push(Vec::new());
            self.push(self.to_page.point(self.at))?;
        }
        Ok(())
    }

    fn curve(
        &mut self,
        n: u32,
        end: [f64; 2],
        at: impl Fn(f64) -> [f64; 2],
    ) -> Result<(), OutOfPoints> {
        for k in 1..n {
            self.push(at(f64::from(k) / f64::from(n)))?;
        }
        self.push(end)
    }

    fn push(&mut self, point: [f64; 2]) -> Result<(), OutOfPoints> {
        *self.points_left = self.points_left.checked_sub(1).ok_or(OutOfPoints)?;
        if let Some(line) = self.lines.last_mut() {
            line.push(point);
        }
        Ok(())
    }
}

/// |p0 − 2p1 + p2|
fn bend(p0: [f64; 2], p1: [f64; 2], p2: [f64; 2]) -> f64 {
    let [x, y] = [0, 1].map(|k| p0[k] - 2.0 * p1[k] + p2[k]);
    (x * x + y * y).sqrt()
}

/// Steps for a curve over t = 0 to 1 with this greatest |p″|. Numbers that are not finite are
/// found where points are checked.
fn steps(second_derivative: f64) -> Result<u32, OutOfPoints> {
    let n = (second_derivative / (8.0 * FLATNESS))
        .sqrt()
        .ceil()
        .max(1.0);
    #[expect(clippy::cast_precision_loss, reason = "2^20")]
    let most = MAX_POINTS as f64;
    if n > most {
        return Err(OutOfPoints);
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and the most points; of NaN it is 0, which makes a straight line"
    )]
    let n = n as u32;
    Ok(n)
}
