//! A drop at rest on glass: the cap of a sphere, or nearly so.

use std::f64::consts::PI;

use crate::Outline;

/// A drop on the outer face of a pane: a cap of a sphere that meets the glass at its contact angle, but for what its
/// [`Outline`] changes.
///
/// So lies a drop that surface tension holds together, up to some 2 mm of radius on level glass; heavier ones are
/// flatter, which is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cap {
    /// Middle of its footprint, mm.
    pub at_mm: [f64; 2],
    /// Radius of its footprint, mm: of a round drop of its water.
    pub radius_mm: f64,
    /// Contact angle, rad.
    pub contact_rad: f64,
    /// How far it is from round.
    pub outline: Outline,
}

impl Cap {
    /// A round cap of a volume, mm³.
    #[must_use]
    pub fn of_volume(at_mm: [f64; 2], volume_mm3: f64, contact_rad: f64) -> Self {
        Self {
            at_mm,
            radius_mm: libm::cbrt(volume_mm3 / volume_per_cubed_radius(contact_rad)),
            contact_rad,
            outline: Outline::default(),
        }
    }

    /// Its volume, mm³: π r³ (2 − 3 cos θ + cos³ θ)/(3 sin³ θ).
    #[must_use]
    pub fn volume_mm3(&self) -> f64 {
        volume_per_cubed_radius(self.contact_rad)
            * (self.radius_mm * self.radius_mm * self.radius_mm)
    }

    /// Area of the glass under it, mm².
    #[must_use]
    pub fn footprint_mm2(&self) -> f64 {
        PI * self.radius_mm * self.radius_mm
    }

    /// Radius of its sphere, mm.
    #[must_use]
    pub fn sphere_mm(&self) -> f64 {
        self.radius_mm / libm::sin(self.contact_rad)
    }

    /// How high it is, mm: r tan(θ/2).
    #[must_use]
    pub fn height_mm(&self) -> f64 {
        self.radius_mm * libm::tan(0.5 * self.contact_rad)
    }
}

/// Volume of a cap over the cube of the radius of its footprint.
pub(crate) fn volume_per_cubed_radius(contact_rad: f64) -> f64 {
    let (sin, cos) = libm::sincos(contact_rad);
    PI * (2.0 - 3.0 * cos + cos * cos * cos) / (3.0 * sin * sin * sin)
}
