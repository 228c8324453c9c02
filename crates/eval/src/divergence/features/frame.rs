//! An image as the features see it: opaque 8-bit RGB, and luma at the size of the analysis.

use image::{DynamicImage, ImageBuffer, Luma, RgbImage};
use serde::Serialize;

use super::resample::resampled;
use super::{Counts, Feature, gradient, spectrum};

/// The longer side of an analysis image gets no longer than this, px; the shape stays.
const LONGER_SIDE_MAX_PX: u32 = 2048;

/// What shows through where an image is transparent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// Code 0: crack patterns are drawn on black.
    Black,
    /// Code 128.
    Gray,
    /// Code 255.
    White,
}

impl Background {
    /// Their words.
    pub const NAMES: [&str; 3] = ["black", "gray", "white"];

    /// The one of this word.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        let all = [Self::Black, Self::Gray, Self::White];
        let mut named = Self::NAMES.into_iter().zip(all);
        named.find(|(known, _)| *known == name).map(|found| found.1)
    }
}

/// How images are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReadSettings {
    /// What shows through where an image is transparent. **Default** black.
    pub background: Background,
    /// Length of the shorter side of the image that gradients and spectra are taken of, px; 0 keeps the
    /// image's own size. Its longer side is 2048 px at most. **Default** 256.
    pub shorter_side_px: u32,
}

impl Default for ReadSettings {
    fn default() -> Self {
        Self {
            background: Background::Black,
            shorter_side_px: 256,
        }
    }
}

impl ReadSettings {
    /// The image over the background. Codes of 16 bits become the nearest of 8. Transparent pixels are
    /// mixed in sRGB codes: `round((c a + background (255 − a)) / 255)`.
    #[must_use]
    pub fn opaque(&self, pixels: &DynamicImage) -> RgbImage {
        if !pixels.color().has_alpha() {
            return pixels.to_rgb8();
        }
        let behind = match self.background {
            Background::Black => 0,
            Background::Gray => 128,
            Background::White => 255,
        };
        let rgba = pixels.to_rgba8();
        let (width, height) = rgba.dimensions();
        RgbImage::from_fn(width, height, |x, y| {
            let [r, g, b, alpha] = rgba.get_pixel(x, y).0;
            let alpha = u32::from(alpha);
            image::Rgb([r, g, b].map(|code| {
                let mixed = u32::from(code) * alpha + behind * (255 - alpha);
                u8::try_from((mixed + 127) / 255).unwrap_or(u8::MAX)
            }))
        })
    }

    /// Width and height of the analysis image of an image, px, at least 1.
    fn analysis_size(&self, width_px: u32, height_px: u32) -> (u32, u32) {
        if self.shorter_side_px == 0 || width_px == 0 || height_px == 0 {
            return (width_px.max(1), height_px.max(1));
        }
        let (short, long) = (width_px.min(height_px), width_px.max(height_px));
        let by_short = f64::from(self.shorter_side_px) / f64::from(short);
        let by_long = f64::from(LONGER_SIDE_MAX_PX) / f64::from(long);
        let scale = by_short.min(by_long);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and the longest side"
        )]
        let scaled = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
        (scaled(width_px), scaled(height_px))
    }

    /// Luma in codes at the size of the analysis, and whether that is larger than the image: by a
    /// triangle filter as wide as the step between its pixels (antialiased; Pillow's `BILINEAR`), from
    /// the 8-bit luma.
    fn analysis(&self, luma: &[u8], (width, height): (u32, u32)) -> (LumaPlane, bool) {
        let values = luma.iter().map(|code| f32::from(*code) / 255.0).collect();
        let (to_width, to_height) = self.analysis_size(width, height);
        let own = LumaPlane::from_raw(width, height, values).unwrap_or_default();
        let mut plane = match (to_width, to_height) == (width, height) {
            true => own,
            false => resampled(&own, to_width, to_height),
        };
        for value in plane.iter_mut() {
            *value *= 255.0;
        }
        (plane, to_width > width || to_height > height)
    }
}

/// Luma in codes 0 to 255.
pub(super) type LumaPlane = ImageBuffer<Luma<f32>, Vec<f32>>;

/// The histograms of an opaque image in the order of `Feature::OF_IMAGES`, and
/// whether it was enlarged for gradients and spectra.
pub(in crate::divergence) fn image_counts(
    rgb: &RgbImage,
    settings: &ReadSettings,
) -> (Vec<Counts>, bool) {
    let luma: Vec<u8> = rgb.pixels().map(|pixel| luma(pixel.0)).collect();
    let (plane, is_enlarged) = settings.analysis(&luma, rgb.dimensions());
    let [magnitude, orientation] = gradient::histograms(&plane);
    let color = rgb.pixels().map(|pixel| {
        let [r, g, b] = pixel.0;
        usize::from(r >> 4) * 256 + usize::from(g >> 4) * 16 + usize::from(b >> 4)
    });
    let luma = counted(Feature::Luma256, luma.iter().map(|code| usize::from(*code)));
    let color = counted(Feature::Rgb16, color);
    let spectrum = spectrum::histogram(&plane);
    (
        vec![luma, color, magnitude, orientation, spectrum],
        is_enlarged,
    )
}

/// How often each bin is met.
fn counted(feature: Feature, bins: impl Iterator<Item = usize>) -> Counts {
    let mut histogram = vec![0_u32; feature.n_bins()];
    for bin in bins {
        if let Some(slot) = histogram.get_mut(bin) {
            *slot += 1;
        }
    }
    let histogram: Vec<f64> = histogram.into_iter().map(f64::from).collect();
    Counts::of(&histogram)
}

/// Luma of BT.601 in 16-bit fixed point.
fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19_595 * u32::from(r) + 38_470 * u32::from(g) + 7_471 * u32::from(b) + 0x8000;
    u8::try_from(sum >> 16).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use image::Rgba;

    use super::*;

    #[test]
    fn white_stays_white_and_what_is_clear_shows_the_background() {
        assert_eq!((luma([255; 3]), luma([0; 3])), (255, 0), "both ends");
        let code = |alpha, name| {
            let image = ImageBuffer::from_pixel(2, 2, Rgba([200, 200, 200, alpha]));
            let settings = ReadSettings {
                background: Background::of_name(name).unwrap(),
                ..ReadSettings::default()
            };
            settings.opaque(&DynamicImage::ImageRgba8(image))[(0, 0)].0[0]
        };
        assert_eq!(code(0, "black"), 0, "clear over black");
        assert_eq!(code(0, "gray"), 128, "clear over the middle");
        assert_eq!(code(0, "white"), 255, "clear over white");
        assert_eq!(code(128, "black"), 100, "200 · 128 / 255");
    }

    #[test]
    fn sixteen_bits_and_gray_give_the_histogram_of_their_eight_bit_like() {
        let settings = ReadSettings::default();
        let of = |image: DynamicImage| image_counts(&settings.opaque(&image), &settings);
        let gray = |level: u8| of(ImageBuffer::from_pixel(3, 3, Luma([level])).into());
        let deep = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(3, 3, Luma([77 * 257_u16])));
        let deep = of(deep);
        assert_eq!(deep, gray(77), "77 of 255");
        assert_ne!(deep, gray(78), "and not its neighbor");
    }

    #[test]
    fn the_analysis_image_keeps_the_shape_and_its_limit() {
        let settings = ReadSettings::default();
        assert_eq!(
            settings.analysis_size(1242, 375),
            (848, 256),
            "a KITTI frame"
        );
        assert_eq!(settings.analysis_size(100, 200), (256, 512), "enlarged");
        assert_eq!(settings.analysis_size(100_000, 10), (2048, 1), "a thread");
        let own = ReadSettings {
            shorter_side_px: 0,
            ..settings
        };
        assert_eq!(own.analysis_size(1242, 375), (1242, 375), "its own");
    }

    #[test]
    fn a_small_image_is_said_to_be_enlarged() {
        let (plane, is_enlarged) = ReadSettings::default().analysis(&[9; 64], (8, 8));
        assert!(is_enlarged, "from 8 to 256");
        let mean = plane.iter().sum::<f32>() / 65_536.0;
        assert!(
            (mean - 9.0).abs() < 1e-3,
            "an even image stays even: {mean}"
        );
        let first = plane[(0, 0)].0[0];
        assert!((first - 9.0).abs() < 1e-3, "up to its rim: {first}");
    }
}
