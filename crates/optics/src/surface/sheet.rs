//! The broken sheet before the lens: where a point inside it appears, and along which ray.

use starbreak_glass::LengthUnit;

use crate::camera::Pinhole;
use crate::lens::Lens;
use crate::number::Number;
use crate::surface::Glass;
use crate::{OpticsError, View};

/// A sheet of glass before a camera with a lens.
///
/// Coordinates of the sheet are its in-plane x and y, mm, and the outward normal, away from the
/// camera. Depth is measured from the face towards the camera, mm; that face lies at the
/// distance of the view's pane.
///
/// The sheet is one piece of glass: the ply that was hit and, of a laminate, what is bonded to it
/// on the camera's side, interlayer and inner ply, whose index is taken to be the same. Places in
/// the plane are those of the ply that was hit as the view has them: what is bonded moves no
/// place that lies on the optical axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SheetView {
    view: View,
    pinhole: Pinhole,
    /// The ply that was hit, and that on the camera's side of a laminate: depths of their faces
    /// towards the camera and away from it, mm.
    plies_mm: [[f64; 2]; 2],
    /// What is bonded to the ply that was hit moves it by this much down the sheet, mm.
    moved_mm: f64,
    /// Refractive index.
    pub(crate) index: f64,
    /// Distance that is sharp, mm.
    focus_mm: f64,
    /// Radius of the entrance pupil, mm.
    pupil_mm: f64,
}

/// Most rounds of the search for the place where a refracted ray enters; each is better by about
/// the ratio of thickness to distance, or, where that is large, by less.
const ROUNDS: u32 = 12;
const CLOSE_ROUNDS: u32 = 64;

/// Ratio of depth over index to distance above which a whole step of the search may go too far.
const FAR_STEP: f64 = 0.5;

/// Sine of the angle to the plane of the pupil up to which a direction is not before the camera.
const NEAREST: f64 = 1e-6;

/// A place is found when the round after would move it by less than this share of the thickness.
const CLOSE: f64 = 1e-4;

impl SheetView {
    /// # Errors
    /// [`OpticsError::NoCamera`] for a view without a camera.
    pub(crate) fn new(view: &View, lens: &Lens, glass: &Glass) -> Result<Self, OpticsError> {
        let pinhole = view.pinhole().ok_or(OpticsError::NoCamera)?;
        let index = glass.refractive_index;
        let bonded_mm = glass.interlayer_mm + glass.inner_ply_mm;
        let slope = pinhole.sin / (index * index - pinhole.sin * pinhole.sin).sqrt();
        Ok(Self {
            view: *view,
            pinhole,
            plies_mm: [
                [bonded_mm, bonded_mm + glass.thickness_mm],
                [0.0, glass.inner_ply_mm],
            ],
            moved_mm: bonded_mm * slope,
            index,
            focus_mm: lens.focus_m * 1e3,
            pupil_mm: lens.aperture_m() * 0.5e3,
        })
    }

    pub(crate) fn f_px(&self) -> f64 {
        self.pinhole.f_px
    }

    /// Depths of the faces of a ply, mm, the one towards the camera first; ply 0 is the one that
    /// was hit.
    pub(crate) fn ply_mm(&self, ply: u8) -> [f64; 2] {
        self.plies_mm[usize::from(ply > 0)]
    }

    /// Depth of the outer face, mm: thickness of the whole sheet.
    pub(crate) fn outer_mm(&self) -> f64 {
        self.plies_mm[0][1]
    }

    pub(crate) fn pupil_mm(&self) -> f64 {
        self.pupil_mm
    }

    pub(crate) fn view(&self) -> &View {
        &self.view
    }

    /// A point of a network on the sheet, mm: networks in mm lie on it, those in px lie over the
    /// frame, each point where the line of sight comes to the ply that was hit. None where it misses it.
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
                let px = [
                    point[0] / pane[0] * f64::from(width),
                    point[1] / pane[1] * f64::from(height),
                ];
                Some(self.behind(px, self.ply_mm(0)[0])?.0)
            }
        }
    }

    /// The point at a depth that is seen at a point of the frame, px, and the direction of sight to it before the glass.
    pub(crate) fn behind(&self, px: [f64; 2], depth_mm: f64) -> Option<([f64; 2], [f64; 3])> {
        let (at_mm, sight, is_seen) = self.behind_each(px, depth_mm);
        (is_seen > 0.0).then_some((at_mm, sight))
    }

    /// The same of one ray or several: 1 where there is such a point, else 0.
    #[inline(always)]
    pub(crate) fn behind_each<N: Number>(&self, px: [N; 2], depth_mm: f64) -> ([N; 2], [N; 3], N) {
        let p = &self.pinhole;
        // Where the pane is not before the camera, there is no sight of it either.
        let ([x, y], _) = p.on_pane(px);
        let (sight, is_seen) = self.sight_each([x, y], [0.0; 2]);
        let [dx, dy] = self.sideways_mm(sight, depth_mm);
        let [entry_x, entry_y] = [x + x.all(p.axis_at_mm[0]), y + y.all(p.axis_at_mm[1])];
        let at_mm = [entry_x + dx, entry_y + dy - y.all(self.moved_mm)];
        (at_mm, sight, is_seen)
    }

    /// A point of the face towards the camera, from the axis, in camera coordinates, mm.
    #[inline(always)]
    fn in_camera<N: Number>(&self, [x, y]: [N; 2]) -> [N; 3] {
        let p = &self.pinhole;
        [x, y.times(p.cos), y.times(p.sin) + y.all(p.distance_mm)]
    }

    /// From the axis to a point of the face, mm.
    fn off_axis_mm(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [axis_x, axis_y] = self.pinhole.axis_at_mm;
        [x - axis_x, y - axis_y]
    }

    /// A direction of the camera's coordinates in those of the sheet.
    #[inline(always)]
    pub(crate) fn sheet_from_camera<N: Number>(&self, [x, y, z]: [N; 3]) -> [N; 3] {
        let p = &self.pinhole;
        let (down, out) = (
            y.times(p.cos) + z.times(p.sin),
            z.times(p.cos) - y.times(p.sin),
        );
        [x, down, out]
    }

    /// A direction of the sheet's coordinates in those of the camera.
    #[inline(always)]
    pub(crate) fn camera_from_sheet<N: Number>(&self, [x, y, n]: [N; 3]) -> [N; 3] {
        let p = &self.pinhole;
        let (down, ahead) = (
            y.times(p.cos) - n.times(p.sin),
            y.times(p.sin) + n.times(p.cos),
        );
        [x, down, ahead]
    }

    /// Direction of sight through a point of the face towards the camera, from a point of the
    /// pupil, of length 1, in the sheet's coordinates. None where the face is not before the
    /// camera or is seen from behind.
    pub(crate) fn sight(&self, point: [f64; 2], pupil: [f64; 2]) -> Option<[f64; 3]> {
        let (sight, is_seen) = self.sight_each(self.off_axis_mm(point), pupil);
        (is_seen > 0.0).then_some(sight)
    }

    /// The same of one point or several, from the axis: 1 where there is such a direction, else 0.
    #[inline(always)]
    fn sight_each<N: Number>(&self, point: [N; 2], pupil: [f64; 2]) -> ([N; 3], N) {
        let [x, y, z] = self.in_camera(point);
        let (x, y) = (x - x.all(pupil[0]), y - y.all(pupil[1]));
        let length = (x * x + y * y + z * z).sqrt();
        let sight = self.sheet_from_camera([x / length, y / length, z / length]);
        let [none, one] = [0.0, 1.0].map(|value| x.all(value));
        let is_ahead = z.all(1e-3 * self.pinhole.distance_mm).below(z, [one, none]);
        let is_seen = z.all(1e-3).below(sight[2], [is_ahead, none]);
        (sight, is_seen)
    }

    /// Where the ray from a point of the pupil to a point at a depth in the sheet crosses the
    /// face towards the camera: within the glass it runs at sin θ′ = sin θ/n.
    pub(crate) fn entry(
        &self,
        point: [f64; 2],
        depth_mm: f64,
        pupil: [f64; 2],
    ) -> Option<[f64; 2]> {
        let point = [point[0], point[1] + self.moved_mm];
        let mut entry = point;
        if depth_mm <= 0.0 {
            return Some(entry);
        }
        // How fast the way sideways grows with the place, at most: where that is more than 1 whole steps run away.
        let slope = depth_mm / (self.index * self.pinhole.distance_mm * self.pinhole.cos);
        let (rounds, part) = match slope > FAR_STEP {
            true => (CLOSE_ROUNDS, 1.0 / (1.0 + 0.5 * slope)),
            false => (ROUNDS, 1.0),
        };
        for _ in 0..rounds {
            let [dx, dy] = self.sideways_mm(self.sight(entry, pupil)?, depth_mm);
            let next = [point[0] - dx, point[1] - dy];
            let next = match part < 1.0 {
                true => [0, 1].map(|k| entry[k] + part * (next[k] - entry[k])),
                false => next,
            };
            let moved = (next[0] - entry[0]).abs() + (next[1] - entry[1]).abs();
            entry = next;
            // The next round would move it by the ratio of thickness to distance less.
            if moved < CLOSE * self.pinhole.distance_mm {
                break;
            }
        }
        Some(entry)
    }

    /// How far a line of sight moves in the plane on its way to a depth: z tan θ′.
    #[inline(always)]
    fn sideways_mm<N: Number>(&self, [x, y, _]: [N; 3], depth_mm: f64) -> [N; 2] {
        let square = (x * x).less_from(self.index * self.index) - y * y;
        let per_sine = x.all(depth_mm) / square.sqrt();
        [per_sine * x, per_sine * y]
    }

    /// Where a point at a depth in the sheet appears in the frame, px, through one point of the
    /// pupil, mm: u = c + f (a/s₁ + (X − a)/Z).
    pub(crate) fn project(
        &self,
        point: [f64; 2],
        depth_mm: f64,
        pupil: [f64; 2],
    ) -> Option<[f64; 2]> {
        self.appears(self.entry(point, depth_mm, pupil)?, pupil)
    }

    /// Where a point of the face towards the camera appears in the frame, px, through one point of the pupil, mm.
    pub(crate) fn appears(&self, entry: [f64; 2], pupil: [f64; 2]) -> Option<[f64; 2]> {
        let at = self.in_camera(self.off_axis_mm(entry));
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

    /// The point of the frame nearest to where a direction in camera coordinates is seen, above a dashboard in the same
    /// column, and how far away that is, px; infinitely far of a direction that is not before the camera.
    #[inline(always)]
    pub(crate) fn nearest_in_frame<N: Number>(&self, [x, y, z]: [N; 3]) -> ([N; 2], N) {
        let (p, nearest) = (&self.pinhole, z.all(NEAREST));
        // Of what is not before the camera any finite number does.
        let ahead = nearest.below(z, [z, nearest]);
        let [u, v] = p.center_px;
        let seen = [
            x.times(p.f_px) / ahead + z.all(u),
            y.times(p.f_px) / ahead + z.all(v),
        ];
        let (size, dashboard) = (self.view.size(), self.view.dashboard());
        let column_px = seen[0].at_least(0.0).at_most(f64::from(size.0));
        let row_px = seen[1].at_least(0.0);
        let row_px = match dashboard.is_none() {
            true => row_px.at_most(f64::from(size.1)),
            false => row_px.with(column_px, |row_px, column_px| {
                row_px.min(dashboard.row_px(column_px, size))
            }),
        };
        let inside = [column_px, row_px];
        let [x, y] = [seen[0] - inside[0], seen[1] - inside[1]];
        let away_px = (x * x + y * y).sqrt();
        let away_px = nearest.below(z, [away_px, z.all(f64::INFINITY)]);
        (inside, away_px)
    }

    /// Signed radius, px, of the disc that a point of the sheet becomes.
    pub(crate) fn blur_radius_px(&self, point: [f64; 2], depth_mm: f64) -> Option<f64> {
        // Across the rake's axis, where refraction does not bend the pupil's image.
        let edge = self.project(point, depth_mm, [self.pupil_mm, 0.0])?;
        let middle = self.project(point, depth_mm, [0.0, 0.0])?;
        Some(middle[0] - edge[0])
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::SheetView;
    use crate::lens::Lens;
    use crate::surface::Glass;
    use crate::{Camera, View};

    /// The place where a ray enters, from that which it comes to, also where the pane is thicker than it is far away.
    #[test]
    fn where_a_ray_enters_is_found_from_where_it_ends() {
        for (distance_m, rake_deg) in [(0.3, 60.0), (0.015, 0.0), (0.002, 0.0), (0.004, 50.0)] {
            let camera = Camera {
                f_px: 300.0,
                distance_m,
                rake_rad: f64::to_radians(rake_deg),
                axis_at_mm: [0.0; 2],
            };
            let view = View::through(&camera, (400, 300)).unwrap();
            let glass = Glass {
                thickness_mm: 5.0,
                ..Glass::default()
            };
            let sheet = SheetView::new(&view, &Lens::default(), &glass).unwrap();
            for (x, y) in (0..5).flat_map(|x| (0..5).map(move |y| (f64::from(x), f64::from(y)))) {
                let px = [100.0 * x, 75.0 * y];
                let (point, _) = sheet.behind(px, sheet.outer_mm()).unwrap();
                let found = sheet.project(point, sheet.outer_mm(), [0.0; 2]).unwrap();
                let off = libm::hypot(found[0] - px[0], found[1] - px[1]);
                assert!(off < 0.02, "{distance_m} m, {rake_deg}°, {px:?}: {off} px");
            }
        }
    }
}
