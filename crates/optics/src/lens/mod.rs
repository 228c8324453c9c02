//! The thin lens: how large a point off the focal plane becomes, and in what shape.

use std::f64::consts::TAU;

use crate::OpticsError;

/// A thin lens behind the glass.
///
/// Distances are along the optical axis from the lens, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Focal length, m, 0.1 mm to 1 m.
    pub focal_length_m: f64,
    /// Focal length over the diameter of the entrance pupil, 0.5 to 128.
    pub f_number: f64,
    /// Distance that is sharp, m, 1 mm to infinity.
    pub focus_m: f64,
    /// Distance of the scene, m, 1 mm to infinity.
    pub scene_m: f64,
    /// Blades of the diaphragm: 0 for a round pupil, or 3 to 24 for a regular polygon.
    pub blades: u32,
    /// Turn of the polygon: direction of its first corner from +x towards +y (down), rad.
    pub blade_angle_rad: f64,
}

impl Default for Lens {
    /// f = 4 mm at f/2, focused on a scene at 20 m through a round pupil.
    fn default() -> Self {
        Self {
            focal_length_m: 4e-3,
            f_number: 2.0,
            focus_m: 20.0,
            scene_m: 20.0,
            blades: 0,
            blade_angle_rad: 0.0,
        }
    }
}

impl Lens {
    /// Diameter of the entrance pupil, m: A = f/N.
    #[must_use]
    pub fn aperture_m(&self) -> f64 {
        self.focal_length_m / self.f_number
    }

    /// Signed diameter of the disc that a point at a distance becomes, px:
    /// c = A f_px (1/s − 1/s₁), positive nearer than the focus. `f_px` is the distance of the
    /// image plane over the pixel pitch.
    #[must_use]
    pub fn circle_of_confusion_px(&self, f_px: f64, distance_m: f64) -> f64 {
        self.aperture_m() * f_px * (1.0 / distance_m - 1.0 / self.focus_m)
    }

    /// Every measure is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        OpticsError::check_ranges(&[
            ("focal_length_m", self.focal_length_m, 1e-4, 1.0),
            ("f_number", self.f_number, 0.5, 128.0),
            ("focus_m", self.focus_m, 1e-3, f64::INFINITY),
            ("scene_m", self.scene_m, 1e-3, f64::INFINITY),
            ("blade_angle_rad", self.blade_angle_rad, -TAU, TAU),
        ])?;
        if self.blades != 0 && !(3..=24).contains(&self.blades) {
            return Err(OpticsError::Parameter {
                name: "blades",
                value: f64::from(self.blades),
                expected: "0 (round), or 3 to 24".into(),
            });
        }
        Ok(())
    }
}
