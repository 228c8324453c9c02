//! The broken sheet before the lens: where a point inside it appears, and along which ray.

use starbreak_glass::LengthUnit;

use crate::camera::Pinhole;
use crate::lens::Lens;
use crate::{OpticsError, View};

/// A sheet of glass before a camera with a lens.
///
/// Coordinates of the sheet are its in-plane x and y, mm, and the outward normal, away from the
/// camera. Depth is measured from the face towards the camera, mm; that face lies at the
/// distance of the view's pane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SheetView {
    view: View,
    pinhole: Pinhole,
    /// Thickness, mm.
    pub(crate) thickness_mm: f64,
    /// Refractive index.
    pub(crate) index: f64,
    /// Distance that is sharp, mm.
    focus_mm: f64,
    /// Radius of the entrance pupil, mm.
    pupil_mm: f64,
}

/// Most rounds of the search for the place where a refracted ray enters; each is better by about
/// the ratio of thickness to distance.
const ROUNDS: u32 = 12;

/// A place is found when the round after would move it by less than this share of the thickness.
const CLOSE: f64 = 1e-4;

impl SheetView {
    /// # Errors
    /// [`OpticsError::NoCamera`] for a view without a camera.
    pub(crate) fn new(
        view: &View,
        lens: &Lens,
        thickness_mm: f64,
        index: f64,
    ) -> Result<Self, OpticsError> {
        let pinhole = view.pinhole().ok_or(OpticsError::NoCamera)?;
        Ok(Self {
            view: *view,
            pinhole,
            thickness_mm,
            index,
            focus_mm: lens.focus_m * 1e3,
            pupil_mm: lens.aperture_m() * 0.5e3,
        })
    }

    pub(crate) fn f_px(&self) -> f64 {
        self.pinhole.f_px
    }

    pub(crate) fn pupil_mm(&self) -> f64 {
        self.pupil_mm
    }

    pub(crate) fn view(&self) -> &View {
        &self.view
    }

    /// A point of a network on the sheet, mm: networks in mm lie on it, those in px lie over the
    /// frame, each point where the line of sight meets the sheet. None where it misses it.
    pub(crate) fn on_sheet(
        &self,
        point: [f64; 2],
        unit: LengthUnit,
        pane: [f64; 2],
    ) -> Option<[f64; 2]> {
        match unit {
            LengthUnit::Mm => Some(point),
            LengthUnit::Px => {
                let (width, height) = self.view.size();
                self.view.unproject([
                    point[0] / pane[0] * f64::from(width),
                    point[1] / pane[1] * f64::from(height),
                ])
            }
        }
    }

    /// A point of the face towards the camera, in camera coordinates, mm.
    fn in_camera(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let p = &self.pinhole;
        let (x, y) = (x - p.axis_at_mm[0], y - p.axis_at_mm[1]);
        [x, y * p.cos, p.distance_mm + y * p.sin]
    }

    /// A direction of the camera's coordinates in those of the sheet.
    pub(crate) fn sheet_from_camera(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let p = &self.pinhole;
        [x, y * p.cos + z * p.sin, -y * p.sin + z * p.cos]
    }

    /// A direction of the sheet's coordinates in those of the camera.
    pub(crate) fn camera_from_sheet(&self, [x, y, n]: [f64; 3]) -> [f64; 3] {
        let p = &self.pinhole;
        [x, y * p.cos - n * p.sin, y * p.sin + n * p.cos]
    }

    /// Direction of sight through a point of the face towards the camera, from a point of the
    /// pupil, of length 1, in the sheet's coordinates. None where the face is not before the
    /// camera or is seen from behind.
    pub(crate) fn sight(&self, point: [f64; 2], pupil: [f64; 2]) -> Option<[f64; 3]> {
        let [x, y, z] = self.in_camera(point);
        if z <= 1e-3 * self.pinhole.distance_mm {
            return None;
        }
        let (x, y) = (x - pupil[0], y - pupil[1]);
        let length = (x * x + y * y + z * z).sqrt();
        let sight = self.sheet_from_camera([x / length, y / length, z / length]);
        (sight[2] > 1e-3).then_some(sight)
    }

    /// Where the ray from a point of the pupil to a point at a depth in the sheet crosses the
    /// face towards the camera: within the glass it runs at sin θ′ = sin θ/n.
    pub(crate) fn entry(
        &self,
        point: [f64; 2],
        depth_mm: f64,
        pupil: [f64; 2],
    ) -> Option<[f64; 2]> {
        let mut entry = point;
        if depth_mm <= 0.0 {
            return Some(entry);
        }
        for _ in 0..ROUNDS {
            let [x, y, _] = self.sight(entry, pupil)?;
            // z tan θ′ along the ray's direction in the plane.
            let per_sine = depth_mm / (self.index * self.index - x * x - y * y).sqrt();
            let next = [point[0] - per_sine * x, point[1] - per_sine * y];
            let moved = (next[0] - entry[0]).abs() + (next[1] - entry[1]).abs();
            entry = next;
            // The next round would move it by the ratio of thickness to distance less.
            if moved < CLOSE * self.pinhole.distance_mm {
                break;
            }
        }
        Some(entry)
    }

    /// Where a point at a depth in the sheet appears in the frame, px, through one point of the
    /// pupil, mm: u = c + f (a/s₁ + (X − a)/Z).
    pub(crate) fn project(
        &self,
        point: [f64; 2],
        depth_mm: f64,
        pupil: [f64; 2],
    ) -> Option<[f64; 2]> {
        let entry = self.entry(point, depth_mm, pupil)?;
        let at = self.in_camera(entry);
        if at[2] <= 1e-3 * self.pinhole.distance_mm {
            return None;
        }
        Some(std::array::from_fn(|axis| {
            self.pinhole.center_px[axis]
                + self.pinhole.f_px
                    * (pupil[axis] / self.focus_mm + (at[axis] - pupil[axis]) / at[2])
        }))
    }

    /// The direction, in camera coordinates, that a point of the frame looks along, of length 1.
    pub(crate) fn ray(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let p = &self.pinhole;
        let (x, y) = ((u - p.center_px[0]) / p.f_px, (v - p.center_px[1]) / p.f_px);
        let length = (x * x + y * y + 1.0).sqrt();
        [x / length, y / length, 1.0 / length]
    }

    /// The point of the frame at which a direction in camera coordinates is seen; none if it is
    /// not within the frame.
    pub(crate) fn in_frame(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        if z <= 1e-6 {
            return None;
        }
        let p = &self.pinhole;
        let (u, v) = (
            p.center_px[0] + p.f_px * x / z,
            p.center_px[1] + p.f_px * y / z,
        );
        let (width, height) = self.view.size();
        ((0.0..f64::from(width)).contains(&u) && (0.0..f64::from(height)).contains(&v))
            .then_some([u, v])
    }

    /// Signed radius, px, of the disc that a point of the sheet becomes.
    pub(crate) fn blur_radius_px(&self, point: [f64; 2], depth_mm: f64) -> Option<f64> {
        // Across the rake's axis, where refraction does not bend the pupil's image.
        let edge = self.project(point, depth_mm, [self.pupil_mm, 0.0])?;
        let middle = self.project(point, depth_mm, [0.0, 0.0])?;
        Some(middle[0] - edge[0])
    }
}
