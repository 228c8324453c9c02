//! Parameters of the physical optics.

use crate::OpticsError;
use crate::environment::EnvironmentParams;
use crate::lens::Lens;
use crate::surface::{Glass, SurfaceParams};

/// Parameters of the physical optics: lens, glass, surfaces of the cracks, light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalOptics {
    /// The lens.
    pub lens: Lens,
    /// The light around the camera.
    pub environment: EnvironmentParams,
    /// The glass before the lens.
    pub glass: Glass,
    /// Surfaces of the cracks.
    pub surface: SurfaceParams,
    /// Share of the light that the lens spreads over the whole frame on top of what the image
    /// already has, 0 to 0.5. **Default**: 0.
    pub veiling_glare: f64,
    /// Noise that is put back where light was added or taken away. **Default**: none.
    pub noise: Option<SensorNoise>,
    /// Influence from which a pixel belongs to the region mask, see
    /// [`Overlay::region`](super::Overlay::region), 10⁻⁴ to 1. **Default**: 0.01.
    pub region_threshold: f64,
}

/// Noise of the sensor, as it is left in the 8-bit image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Standard deviation in the dark, linear, in units of white, 0 to 1.
    pub read: f64,
    /// Variance over signal, both linear in units of white, 0 to 1.
    pub shot: f64,
}

impl Default for PhysicalOptics {
    fn default() -> Self {
        Self {
            lens: Lens::default(),
            environment: EnvironmentParams::default(),
            glass: Glass::default(),
            surface: SurfaceParams::default(),
            veiling_glare: 0.0,
            noise: None,
            region_threshold: 0.01,
        }
    }
}

impl PhysicalOptics {
    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        self.lens.check()?;
        let (glass, surface) = (&self.glass, &self.surface);
        let noise = self.noise.unwrap_or(SensorNoise {
            read: 0.0,
            shot: 0.0,
        });
        OpticsError::check_ranges(&[
            ("thickness_mm", glass.thickness_mm, 0.05, 100.0),
            ("interlayer_mm", glass.interlayer_mm, 0.0, 100.0),
            ("inner_ply_mm", glass.inner_ply_mm, 0.0, 100.0),
            ("refractive_index", glass.refractive_index, 1.3, 2.0),
            ("rim_reflectance", glass.rim_reflectance, 0.0, 1.0),
            ("rim_way_mm", glass.rim_way_mm, 0.0, 1e5),
            (
                "mirror_alpha",
                surface.mirror_alpha.unwrap_or(0.0),
                0.0,
                1.0,
            ),
            ("mist_alpha", surface.mist_alpha.unwrap_or(0.0), 0.0, 1.0),
            (
                "hackle_alpha",
                surface.hackle_alpha.unwrap_or(0.0),
                0.0,
                1.0,
            ),
            ("opening_um", surface.opening_um, 0.0, 1000.0),
            ("crushed_zone", surface.crushed_zone, 0.0, 10.0),
            ("chip", surface.chip, 0.0, 10.0),
            ("chip_slope_deg", surface.chip_slope_deg, 0.0, 60.0),
            ("film", surface.film, 0.0, 10.0),
            ("film_um", surface.film_um, 0.0, 100.0),
            ("fragment_wedge_deg", surface.fragment_wedge_deg, 0.0, 10.0),
            ("veiling_glare", self.veiling_glare, 0.0, 0.5),
            ("noise.read", noise.read, 0.0, 1.0),
            ("noise.shot", noise.shot, 0.0, 1.0),
            ("region_threshold", self.region_threshold, 1e-4, 1.0),
        ])?;
        self.environment.check()
    }
}
