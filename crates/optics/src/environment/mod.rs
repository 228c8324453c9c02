//! The light around the camera, estimated from one image and from where the sun stands.
//!
//! Directions are in camera coordinates: x to the right, y down, z along the optical axis. All
//! light is linear, in units of the image: 1 is what white shows.

/// Light of one color, linear, in units of the image's white.
pub type Rgb = [f32; 3];

/// What is said of the environment; what is not said is estimated from the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentParams {
    /// Azimuth of the sun, rad, from the optical axis towards the right.
    pub sun_azimuth_rad: f64,
    /// Elevation of the sun above the horizon, rad.
    pub sun_elevation_rad: f64,
    /// Irradiance of the sun on a plane that faces it, in units of the image: π is what makes a
    /// white sheet show 1.
    pub sun_irradiance: Option<f64>,
    /// Radiance of the sky at the horizon.
    pub horizon_rgb: Option<Rgb>,
    /// Radiance of the sky at the zenith.
    pub zenith_rgb: Option<Rgb>,
    /// Radiance of the ground.
    pub ground_rgb: Option<Rgb>,
    /// Radiance of what is behind the camera's side of the glass.
    pub cabin_rgb: Option<Rgb>,
    /// Row of the horizon over the height of the frame, from the top.
    pub horizon_row: f64,
}

impl Default for EnvironmentParams {
    /// Sun 35° to the right and 45° high; all else from the image, by a level camera.
    fn default() -> Self {
        Self {
            sun_azimuth_rad: 35_f64.to_radians(),
            sun_elevation_rad: 45_f64.to_radians(),
            sun_irradiance: None,
            horizon_rgb: None,
            zenith_rgb: None,
            ground_rgb: None,
            cabin_rgb: None,
            horizon_row: 0.5,
        }
    }
}

/// The light around the camera.
///
/// The sky's radiance runs from the horizon's to the zenith's with the sine of the elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Environment {
    /// Radiance of the sky at the horizon.
    pub horizon_rgb: Rgb,
    /// Radiance of the sky at the zenith.
    pub zenith_rgb: Rgb,
    /// Radiance of the ground.
    pub ground_rgb: Rgb,
    /// Radiance of what is on the camera's side of the glass.
    pub cabin_rgb: Rgb,
    /// Irradiance of the sun on a plane that faces it.
    pub sun_rgb: Rgb,
}
