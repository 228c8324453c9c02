//! Where a point of the pane appears in the frame.

use starbreak_glass::Pane;

use crate::OpticsError;
use crate::environment::Dashboard;
use crate::number::Number;

/// A pinhole camera behind a plane pane.
///
/// The optical axis meets the pane at `axis_at_mm`; the pane is turned there about a horizontal
/// axis. Camera coordinates are x to the right, y down, z along the optical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Focal length, px of the frame, 1 to 10⁶.
    pub f_px: f64,
    /// Distance from the pinhole to the pane along the optical axis, m, 1 mm to 100 m.
    pub distance_m: f64,
    /// Angle between the pane's normal and the optical axis, rad, -85° to 85°. Positive: the top
    /// of the pane leans towards the camera, as a windscreen does that is seen from inside.
    pub rake_rad: f64,
    /// Where the optical axis meets the pane, mm from its top left corner.
    pub axis_at_mm: [f64; 2],
}

impl Camera {
    /// Every measure is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        let [x, y] = self.axis_at_mm;
        let steepest_rad = 85_f64.to_radians();
        OpticsError::check_ranges(&[
            ("f_px", self.f_px, 1.0, 1e6),
            ("distance_m", self.distance_m, 1e-3, 100.0),
            ("rake_rad", self.rake_rad, -steepest_rad, steepest_rad),
            ("axis_at_mm.x", x, -1e6, 1e6),
            ("axis_at_mm.y", y, -1e6, 1e6),
        ])
    }
}

/// How the plane of a pane is mapped onto a frame.
///
/// # Units
/// Points of the pane are in its length unit: px for [`View::stretched`], mm for
/// [`View::through`]. Points of the frame are px, the first pixel's centre at (0.5, 0.5), y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    width: u32,
    height: u32,
    mapping: Mapping,
    dashboard: Dashboard,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mapping {
    /// The pane fills the frame.
    Stretch { scale: [f64; 2] },
    /// u = cx + f x/z, v = cy + f y/z, with the pane at x = X, y = Y cos ρ, z = d + Y sin ρ.
    Pinhole {
        f_px: f64,
        distance_mm: f64,
        sin: f64,
        cos: f64,
        axis_at_mm: [f64; 2],
    },
}

/// A pinhole camera and the pane before it, measured in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pinhole {
    pub(crate) f_px: f64,
    pub(crate) center_px: [f64; 2],
    pub(crate) distance_mm: f64,
    /// Sine and cosine of the rake.
    pub(crate) sin: f64,
    pub(crate) cos: f64,
    pub(crate) axis_at_mm: [f64; 2],
}

impl Pinhole {
    /// Where the pane is seen at one point of the frame or several, px: from the axis, mm, and a number that is above 0 where
    /// the pane is before the camera.
    ///
    /// Y = v′d/(cos ρ − v′ sin ρ) with v′ = (v − cy)/f, and X = u′z.
    #[inline(always)]
    pub(crate) fn on_pane<N: Number>(&self, px: [N; 2]) -> ([N; 2], N) {
        let [u, v] = [0, 1].map(|k| (px[k] - px[k].all(self.center_px[k])) / px[k].all(self.f_px));
        let fall = v.times(self.sin).less_from(self.cos);
        let z = v.all(self.distance_mm * self.cos) / fall;
        ([u * z, v.times(self.distance_mm) / fall], fall)
    }
}

impl View {
    /// The pane stretched to a frame of `width × height` pixels.
    #[must_use]
    pub fn stretched(pane: &Pane, (width, height): (u32, u32)) -> Self {
        let scale = [
            f64::from(width) / pane.width,
            f64::from(height) / pane.height,
        ];
        Self {
            width,
            height,
            mapping: Mapping::Stretch { scale },
            dashboard: Dashboard::default(),
        }
    }

    /// A pane measured in mm, seen by a camera whose optical axis meets the middle of a frame of
    /// `width × height` pixels.
    ///
    /// # Errors
    /// As for [`Camera::check`].
    pub fn through(camera: &Camera, (width, height): (u32, u32)) -> Result<Self, OpticsError> {
        camera.check()?;
        let (sin, cos) = libm::sincos(camera.rake_rad);
        Ok(Self {
            width,
            height,
            mapping: Mapping::Pinhole {
                f_px: camera.f_px,
                distance_mm: camera.distance_m * 1e3,
                sin,
                cos,
                axis_at_mm: camera.axis_at_mm,
            },
            dashboard: Dashboard::default(),
        })
    }

    /// The same with a dashboard before the pane: what is on the pane is not seen there.
    #[must_use]
    pub fn over(self, dashboard: Dashboard) -> Self {
        Self { dashboard, ..self }
    }

    /// What stands before the pane at the bottom of the frame.
    #[must_use]
    pub fn dashboard(&self) -> &Dashboard {
        &self.dashboard
    }

    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Where a point of the pane's plane appears; nowhere if it is not before the camera.
    #[must_use]
    pub fn project(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        self.dehomogenize(self.homogeneous(point))
    }

    /// The point of the pane's plane that appears at a point of the frame; none where the line
    /// of sight misses the plane.
    ///
    /// Y = v′d/(cos ρ − v′ sin ρ) with v′ = (v − cy)/f, and X = u′z.
    #[must_use]
    pub fn unproject(&self, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        match self.mapping {
            Mapping::Stretch { scale } => Some([u / scale[0], v / scale[1]]),
            Mapping::Pinhole { axis_at_mm, .. } => {
                let ([x, y], fall) = self.pinhole()?.on_pane([u, v]);
                (fall > 0.0).then_some([axis_at_mm[0] + x, axis_at_mm[1] + y])
            }
        }
    }

    /// Pixels per unit of the pane at one of its points, `[[∂u/∂x, ∂u/∂y], [∂v/∂x, ∂v/∂y]]`;
    /// none if it is not before the camera.
    #[must_use]
    pub fn jacobian(&self, point: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        match self.mapping {
            Mapping::Stretch { scale } => Some([[scale[0], 0.0], [0.0, scale[1]]]),
            Mapping::Pinhole { f_px, sin, cos, .. } => {
                let [x, y, z] = self.homogeneous(point);
                (z > self.nearest()).then(|| {
                    let per_z = f_px / z;
                    [
                        [per_z, -per_z * x / z * sin],
                        [0.0, per_z * (cos - y / z * sin)],
                    ]
                })
            }
        }
    }

    /// Pixels per unit of the pane at one of its points, the geometric mean over directions: the
    /// root of what a small area is magnified by.
    #[must_use]
    pub fn px_per_unit(&self, point: [f64; 2]) -> Option<f64> {
        let [[a, b], [c, d]] = self.jacobian(point)?;
        Some((a * d - b * c).abs().sqrt())
    }

    /// The part of a straight line on the pane that appears in the frame or within `margin_px`
    /// of it, as ends in px; none if no part does.
    ///
    /// A stretched pane is not clipped: it lies in its frame as a whole.
    #[must_use]
    pub fn visible(&self, [x0, y0, x1, y1]: [f64; 4], margin_px: f64) -> Option<[f64; 4]> {
        let Mapping::Pinhole { f_px, .. } = self.mapping else {
            let ([u0, v0], [u1, v1]) = (self.project([x0, y0])?, self.project([x1, y1])?);
            return Some([u0, v0, u1, v1]);
        };
        let (a, b) = (self.homogeneous([x0, y0]), self.homogeneous([x1, y1]));
        let [cx, cy] = self.center();
        // Each is ≥ 0 on the inner side of a plane through the pinhole and a side of the frame,
        // the last before the camera; all are linear along the line.
        let inside = |[x, y, z]: [f64; 3]| {
            [
                f_px * x + (cx + margin_px) * z,
                (cx + margin_px) * z - f_px * x,
                f_px * y + (cy + margin_px) * z,
                (cy + margin_px) * z - f_px * y,
                z - 2.0 * self.nearest(),
            ]
        };
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        for (at_a, at_b) in inside(a).into_iter().zip(inside(b)) {
            if at_a < 0.0 && at_b < 0.0 {
                return None;
            }
            if at_a < 0.0 {
                start = start.max(at_a / (at_a - at_b));
            } else if at_b < 0.0 {
                end = end.min(at_a / (at_a - at_b));
            }
        }
        if start > end {
            return None;
        }
        let at = |t: f64| -> [f64; 3] { std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t) };
        let [u0, v0] = self.dehomogenize(at(start))?;
        let [u1, v1] = self.dehomogenize(at(end))?;
        Some([u0, v0, u1, v1])
    }

    /// Direction in the frame of the part of a line that is visible, of any length.
    pub(crate) fn direction(&self, ends: [f64; 4], margin_px: f64) -> Option<[f64; 2]> {
        let [x0, y0, x1, y1] = ends;
        match self.mapping {
            Mapping::Stretch { scale } => Some([(x1 - x0) * scale[0], (y1 - y0) * scale[1]]),
            Mapping::Pinhole { .. } => {
                let [u0, v0, u1, v1] = self.visible(ends, margin_px)?;
                Some([u1 - u0, v1 - v0])
            }
        }
    }

    /// The camera of a view through one; none of a stretched pane.
    pub(crate) fn pinhole(&self) -> Option<Pinhole> {
        match self.mapping {
            Mapping::Stretch { .. } => None,
            Mapping::Pinhole {
                f_px,
                distance_mm,
                sin,
                cos,
                axis_at_mm,
            } => Some(Pinhole {
                f_px,
                center_px: self.center(),
                distance_mm,
                sin,
                cos,
                axis_at_mm,
            }),
        }
    }

    /// Depth along the optical axis, mm, at which a row of the frame shows the pane; none where it does not, and of a
    /// stretched pane.
    pub(crate) fn depth_mm(&self, row_px: f64) -> Option<f64> {
        let Mapping::Pinhole { .. } = self.mapping else {
            return None;
        };
        let at = self.unproject([self.center()[0], row_px])?;
        Some(self.homogeneous(at)[2])
    }

    /// The pane's normal on the side of the scene, in camera coordinates.
    pub(crate) fn outer_normal(&self) -> [f64; 3] {
        match self.mapping {
            Mapping::Stretch { .. } => [0.0, 0.0, 1.0],
            Mapping::Pinhole { sin, cos, .. } => [0.0, -sin, cos],
        }
    }

    fn center(&self) -> [f64; 2] {
        [f64::from(self.width) * 0.5, f64::from(self.height) * 0.5]
    }

    /// Depth, mm, up to which nothing is seen; it only keeps a division from overflowing.
    fn nearest(&self) -> f64 {
        match self.mapping {
            Mapping::Stretch { .. } => 0.0,
            Mapping::Pinhole { distance_mm, .. } => 1e-9 * distance_mm,
        }
    }

    /// A point of the pane in camera coordinates, mm.
    fn homogeneous(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        match self.mapping {
            Mapping::Stretch { scale } => [x * scale[0], y * scale[1], 1.0],
            Mapping::Pinhole {
                distance_mm,
                sin,
                cos,
                axis_at_mm,
                ..
            } => {
                let (x, y) = (x - axis_at_mm[0], y - axis_at_mm[1]);
                [x, y * cos, distance_mm + y * sin]
            }
        }
    }

    fn dehomogenize(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        match self.mapping {
            Mapping::Stretch { .. } => Some([x, y]),
            Mapping::Pinhole { f_px, .. } => {
                let [cx, cy] = self.center();
                (z > self.nearest()).then(|| [cx + f_px * x / z, cy + f_px * y / z])
            }
        }
    }
}
