//! Parameters of the paper's visualization.

use crate::OpticsError;

/// What is sharp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Focus {
    /// The scene; the crack is blurred over it.
    Far,
    /// The crack; the scene is blurred behind it.
    Short,
}

/// What far focus blurs. The paper overlays fractures that it blurs, with the scene in the focal
/// plane; its implementation blurs the two together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FarFocusBlur {
    /// The crack alone; the scene stays sharp under it.
    Crack,
    /// Scene and crack together, wherever the crack reaches.
    CrackAndScene,
}

/// The "mean intensity of the light source" (I_r, I_g, I_b), which the paper does not define.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// The mean of each channel over the frame.
    ImageMean,
    /// These code values, 0 to 255 per channel (scaled for 16-bit images).
    Rgb([f64; 3]),
}

/// What Σ L_r in the denominator of I_c runs over, which the paper does not define.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Normalization {
    /// The sum of E over all segments, to the letter: cracks become nearly black.
    Sum,
    /// The largest E of all segments: the brightest crack shows the light's intensity.
    Max,
    /// The mean E of all segments.
    Mean,
    /// Nothing: I_c = I·E.
    One,
}

/// Parameters of the paper's visualization.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperOptics {
    /// What is sharp. **Default**: far.
    pub focus: Focus,
    /// What far focus blurs. **Default**: the crack.
    pub far_focus_blur: FarFocusBlur,
    /// Sun azimuth α, rad. **Default**: 35°.
    pub sun_azimuth_rad: f64,
    /// Sun zenith angle θ, rad (90° − elevation). **Default**: 45°.
    pub sun_zenith_rad: f64,
    /// Intensity of the light source per channel.
    pub light: Light,
    /// Meaning of Σ L_r. **Default**: max.
    pub normalization: Normalization,
    /// Width of a drawn crack, px, 0.05 to 64. **Default**: 1. **Source**: the paper's
    /// implementation draws lines of one pixel.
    pub line_width_px: f64,
    /// Taps of the square blur kernel, odd, 1 to 255. **Default**: 15. **Source**: the paper's
    /// implementation.
    pub blur_kernel_px: u32,
    /// Standard deviation of the Gaussian blur, px, 0.01 to 128. **Default**: 2.6, which is what
    /// OpenCV takes for 15 taps.
    pub blur_sigma_px: f64,
}

impl Default for PaperOptics {
    fn default() -> Self {
        Self {
            focus: Focus::Far,
            far_focus_blur: FarFocusBlur::Crack,
            sun_azimuth_rad: 35_f64.to_radians(),
            sun_zenith_rad: 45_f64.to_radians(),
            light: Light::Rgb([200.0; 3]),
            normalization: Normalization::Max,
            line_width_px: 1.0,
            blur_kernel_px: 15,
            blur_sigma_px: 2.6,
        }
    }
}

impl PaperOptics {
    /// How far a crack reaches into its surroundings: half the kernel, px.
    #[must_use]
    pub fn blur_radius_px(&self) -> u32 {
        self.blur_kernel_px / 2
    }

    /// How far beyond the frame a crack may lie and still be seen in it: half its width and the
    /// blur, and a pixel for their edges, px.
    pub(super) fn reach_px(&self) -> f64 {
        0.5 * self.line_width_px + f64::from(self.blur_radius_px()) + 1.0
    }

    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        let taps = f64::from(self.blur_kernel_px);
        OpticsError::check_ranges(&[
            ("line_width_px", self.line_width_px, 0.05, 64.0),
            ("blur_sigma_px", self.blur_sigma_px, 0.01, 128.0),
            ("blur_kernel_px", taps, 1.0, 255.0),
        ])?;
        if self.blur_kernel_px.is_multiple_of(2) {
            return Err(OpticsError::Parameter {
                name: "blur_kernel_px",
                value: taps,
                expected: "an odd number, 1 to 255 px".into(),
            });
        }
        for (name, value) in [
            ("sun_azimuth_rad", self.sun_azimuth_rad),
            ("sun_zenith_rad", self.sun_zenith_rad),
        ] {
            if !value.is_finite() {
                return Err(OpticsError::Parameter {
                    name,
                    value,
                    expected: "a finite angle".into(),
                });
            }
        }
        if let Light::Rgb(levels) = self.light {
            OpticsError::check_ranges(&levels.map(|level| ("light", level, 0.0, 255.0)))?;
        }
        Ok(())
    }
}
