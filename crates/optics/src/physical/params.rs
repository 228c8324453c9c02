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

/// What a roughness may be.
const ALPHA: &str = "\"auto\", or 0 to 1";

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
        let environment = &self.environment;
        let noise = self.noise.unwrap_or(SensorNoise {
            read: 0.0,
            shot: 0.0,
        });
        let alpha = |given: Option<f64>| given.unwrap_or(0.0);
        let ranges = [
            (
                "thickness_mm",
                glass.thickness_mm,
                0.05,
                100.0,
                "0.05 to 100 mm",
            ),
            (
                "interlayer_thickness_mm",
                glass.interlayer_mm,
                0.0,
                100.0,
                "0 to 100 mm",
            ),
            (
                "inner_thickness_mm",
                glass.inner_ply_mm,
                0.0,
                100.0,
                "0 to 100 mm",
            ),
            (
                "refractive_index",
                glass.refractive_index,
                1.3,
                2.0,
                "1.3 to 2",
            ),
            ("rim_reflectance", glass.rim_reflectance, 0.0, 1.0, "0 to 1"),
            ("rim_way_mm", glass.rim_way_mm, 0.0, 1e5, "0 to 100000 mm"),
            ("mirror_alpha", alpha(surface.mirror_alpha), 0.0, 1.0, ALPHA),
            ("mist_alpha", alpha(surface.mist_alpha), 0.0, 1.0, ALPHA),
            ("hackle_alpha", alpha(surface.hackle_alpha), 0.0, 1.0, ALPHA),
            (
                "opening_um",
                surface.opening_um,
                0.0,
                1000.0,
                "0 to 1000 µm",
            ),
            ("crushed_zone", surface.crushed_zone, 0.0, 10.0, "0 to 10"),
            ("chip", surface.chip, 0.0, 10.0, "0 to 10"),
            (
                "chip_slope_deg",
                surface.chip_slope_deg,
                0.0,
                60.0,
                "0 to 60 degrees",
            ),
            ("film", surface.film, 0.0, 10.0, "0 to 10"),
            ("film_um", surface.film_um, 0.0, 100.0, "0 to 100 µm"),
            (
                "fragment_wedge_deg",
                surface.fragment_wedge_deg,
                0.0,
                10.0,
                "0 to 10 degrees",
            ),
            ("veiling_glare", self.veiling_glare, 0.0, 0.5, "0 to 0.5"),
            ("noise_read", noise.read, 0.0, 1.0, "0 to 1"),
            ("noise_shot", noise.shot, 0.0, 1.0, "0 to 1"),
            (
                "region_threshold",
                self.region_threshold,
                1e-4,
                1.0,
                "0.0001 to 1",
            ),
            (
                "sun_azimuth_deg",
                environment.sun_azimuth_rad.to_degrees(),
                -3600.0,
                3600.0,
                "-3600 to 3600 degrees",
            ),
            (
                "sun_elevation_deg",
                environment.sun_elevation_rad.to_degrees(),
                -90.0,
                90.0,
                "-90 to 90 degrees",
            ),
            (
                "sun_irradiance",
                environment.sun_irradiance.unwrap_or(0.0),
                0.0,
                1e6,
                "\"auto\", or 0 to 1000000",
            ),
            (
                "horizon_row",
                environment.horizon_row,
                -100.0,
                100.0,
                "a fraction of the height, -100 to 100",
            ),
        ];
        for (name, value, least, most, expected) in ranges {
            OpticsError::check_range(name, value, least..=most, expected)?;
        }
        let [low, high] = match environment.cabin_rgb {
            Some(pair) => pair.map(Some),
            None => [None; 2],
        };
        for (name, rgb) in [
            ("sky_horizon", environment.horizon_rgb),
            ("sky_zenith", environment.zenith_rgb),
            ("ground", environment.ground_rgb),
            ("cabin", low),
            ("cabin", high),
        ] {
            if let Some(&value) = rgb
                .iter()
                .flatten()
                .find(|value| !(0.0..=1e6).contains(*value))
            {
                return Err(OpticsError::Parameter {
                    name,
                    value: f64::from(value),
                    expected: "\"auto\", or linear light, 0 to 1000000 per channel",
                });
            }
        }
        Ok(())
    }
}
