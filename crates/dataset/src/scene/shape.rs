//! Outlines in whatever flat units a drawing uses (mostly metres).
//!
//! What comes out is a list of closed contours made of short straight pieces,
//! so that any mapping (perspective, a bent car panel, a shadow on the ground)
//! can be applied point by point before the outline is filled.

use std::f32::consts::TAU;

use tiny_skia::{Path, PathBuilder};

/// One or more closed contours that are filled together.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    contours: Vec<Vec<[f32; 2]>>,
}

const CORNER_PIECES: u8 = 5;
const SMOOTH_PIECES: u8 = 4;
const ROUND_PIECES: u8 = 36;

impl Shape {
    /// A straight-edged outline.
    pub(super) fn polygon(points: &[[f32; 2]]) -> Self {
        Self {
            contours: vec![points.to_vec()],
        }
    }

    /// An upright rectangle between two corners.
    pub(super) fn rect(x0: f32, y0: f32, x1: f32, y1: f32) -> Self {
        Self::polygon(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    }

    /// An upright rectangle with rounded corners.
    pub(super) fn round_rect(x0: f32, y0: f32, x1: f32, y1: f32, radius: f32) -> Self {
        Self::soft(&[
            [x0, y0, radius],
            [x1, y0, radius],
            [x1, y1, radius],
            [x0, y1, radius],
        ])
    }

    /// A polygon of (x, y, rounding) whose corners are cut back by their
    /// rounding and bridged with a curve.
    pub(super) fn soft(corners: &[[f32; 3]]) -> Self {
        let count = corners.len();
        let mut contour = Vec::with_capacity(count * usize::from(CORNER_PIECES));
        for (index, corner) in corners.iter().enumerate() {
            let here = [corner[0], corner[1]];
            if corner[2] <= 0.0 {
                contour.push(here);
                continue;
            }
            let before = corners[(index + count - 1) % count];
            let after = corners[(index + 1) % count];
            let enter = toward(here, [before[0], before[1]], corner[2]);
            let leave = toward(here, [after[0], after[1]], corner[2]);
            for piece in 0..=CORNER_PIECES {
                let t = f32::from(piece) / f32::from(CORNER_PIECES);
                contour.push(quad_at(enter, here, leave, t));
            }
        }
        Self {
            contours: vec![contour],
        }
    }

    /// A closed smooth outline through the points (Catmull-Rom).
    pub(super) fn smooth(points: &[[f32; 2]]) -> Self {
        let count = points.len();
        let mut contour = Vec::with_capacity(count * usize::from(SMOOTH_PIECES));
        for index in 0..count {
            let p0 = points[(index + count - 1) % count];
            let p1 = points[index];
            let p2 = points[(index + 1) % count];
            let p3 = points[(index + 2) % count];
            for piece in 0..SMOOTH_PIECES {
                let t = f32::from(piece) / f32::from(SMOOTH_PIECES);
                contour.push([0, 1].map(|axis| {
                    let (a, b, c, d) = (p0[axis], p1[axis], p2[axis], p3[axis]);
                    0.5 * (2.0 * b
                        + (c - a) * t
                        + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
                        + (3.0 * b - a - 3.0 * c + d) * t * t * t)
                }));
            }
        }
        Self {
            contours: vec![contour],
        }
    }

    /// An upright ellipse.
    pub(super) fn ellipse(center: [f32; 2], radius_x: f32, radius_y: f32) -> Self {
        let contour = (0..ROUND_PIECES)
            .map(|piece| {
                let angle_rad = TAU * f32::from(piece) / f32::from(ROUND_PIECES);
                [
                    center[0] + radius_x * libm::cosf(angle_rad),
                    center[1] + radius_y * libm::sinf(angle_rad),
                ]
            })
            .collect();
        Self {
            contours: vec![contour],
        }
    }

    /// A circle.
    pub(super) fn disc(center: [f32; 2], radius: f32) -> Self {
        Self::ellipse(center, radius, radius)
    }

    /// A circle with a round hole.
    pub(super) fn ring(center: [f32; 2], outer_radius: f32, inner_radius: f32) -> Self {
        let mut hole = Self::disc(center, inner_radius);
        for contour in &mut hole.contours {
            contour.reverse();
        }
        Self::disc(center, outer_radius).and(hole)
    }

    /// A limb: a bar with round ends that may taper.
    pub(super) fn limb(from: [f32; 2], to: [f32; 2], from_radius: f32, to_radius: f32) -> Self {
        let heading_rad = libm::atan2f(to[1] - from[1], to[0] - from[0]);
        let mut contour = Vec::with_capacity(14);
        for (center, radius, start_rad) in [
            (from, from_radius, heading_rad + TAU / 4.0),
            (to, to_radius, heading_rad - TAU / 4.0),
        ] {
            for piece in 0..=6_u8 {
                let angle_rad = start_rad + TAU / 12.0 * f32::from(piece);
                contour.push([
                    center[0] + radius * libm::cosf(angle_rad),
                    center[1] + radius * libm::sinf(angle_rad),
                ]);
            }
        }
        Self {
            contours: vec![contour],
        }
    }

    /// A line of even thickness through the points.
    pub(super) fn line(points: &[[f32; 2]], thickness: f32) -> Self {
        let mut shape = Self::default();
        for pair in points.windows(2) {
            shape = shape.and(Self::limb(
                pair[0],
                pair[1],
                thickness / 2.0,
                thickness / 2.0,
            ));
        }
        shape
    }

    /// Both outlines as one.
    pub(super) fn and(mut self, other: Self) -> Self {
        self.contours.extend(other.contours);
        self
    }

    /// The same outline with every edge cut into pieces no longer than
    /// `longest`, for mappings that bend straight lines.
    pub(super) fn cut(&self, longest: f32) -> Self {
        let contours = self
            .contours
            .iter()
            .map(|contour| {
                let mut fine = Vec::with_capacity(contour.len() * 2);
                for (index, &from) in contour.iter().enumerate() {
                    let to = contour[(index + 1) % contour.len()];
                    let length = libm::hypotf(to[0] - from[0], to[1] - from[1]);
                    let mut done = 0.0;
                    while done < length {
                        fine.push(toward(from, to, done));
                        done += longest;
                    }
                }
                fine
            })
            .collect();
        Self { contours }
    }

    /// The outline under a mapping to pixels, ready to be filled; nothing for
    /// an empty shape.
    pub(super) fn path(&self, to_px: &dyn Fn([f32; 2]) -> [f32; 2]) -> Option<Path> {
        let mut builder = PathBuilder::new();
        for contour in &self.contours {
            for (index, &point) in contour.iter().enumerate() {
                let [x_px, y_px] = to_px(point);
                if index == 0 {
                    builder.move_to(x_px, y_px);
                } else {
                    builder.line_to(x_px, y_px);
                }
            }
            builder.close();
        }
        builder.finish()
    }
}

fn toward(from: [f32; 2], to: [f32; 2], distance: f32) -> [f32; 2] {
    let length = libm::hypotf(to[0] - from[0], to[1] - from[1]).max(1e-6);
    let share = distance / length;
    [
        from[0] + (to[0] - from[0]) * share,
        from[1] + (to[1] - from[1]) * share,
    ]
}

fn quad_at(a: [f32; 2], b: [f32; 2], c: [f32; 2], t: f32) -> [f32; 2] {
    [0, 1].map(|axis| {
        let ab = a[axis] + (b[axis] - a[axis]) * t;
        let bc = b[axis] + (c[axis] - b[axis]) * t;
        ab + (bc - ab) * t
    })
}
