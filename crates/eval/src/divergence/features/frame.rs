//! An image as the features see it: opaque 8-bit RGB, and luma at the size of the analysis.

use image::imageops::{FilterType, resize};
use image::{DynamicImage, ImageBuffer, Luma, RgbImage};
use serde::Serialize;

use super::counts::Counts;

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
    const fn code(self) -> u32 {
        match self {
            Self::Black => 0,
            Self::Gray => 128,
            Self::White => 255,
        }
    }
}

/// The size to which an image is brought for gradients and spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct AnalysisSize {
    /// Length of its shorter side, px; 0 keeps the image's own size. **Default** 256.
    pub shorter_side_px: u32,
    /// Its longer side gets no longer than this, px; the shape stays. **Default** 2048.
    pub longer_side_max_px: u32,
}

impl Default for AnalysisSize {
    fn default() -> Self {
        Self {
            shorter_side_px: 256,
            longer_side_max_px: 2048,
        }
    }
}

impl AnalysisSize {
    /// Width and height of the analysis image of an image, px, at least 1.
    #[must_use]
    pub fn of(&self, width_px: u32, height_px: u32) -> (u32, u32) {
        if self.shorter_side_px == 0 || width_px == 0 || height_px == 0 {
            return (width_px.max(1), height_px.max(1));
        }
        let (short, long) = (width_px.min(height_px), width_px.max(height_px));
        let by_short = f64::from(self.shorter_side_px) / f64::from(short);
        let by_long = f64::from(self.longer_side_max_px) / f64::from(long);
        let scale = by_short.min(by_long);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and the longest side"
        )]
        let scaled = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
        (scaled(width_px), scaled(height_px))
    }
}

/// Luma in codes 0 to 255, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::divergence) struct LumaPlane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

/// An image as the features see it.
#[derive(Debug, Clone)]
pub(in crate::divergence) struct Frame {
    /// Opaque, at its own size.
    pub(in crate::divergence) rgb: RgbImage,
    /// Luma at the size of the analysis.
    pub(in crate::divergence) analysis: LumaPlane,
    /// Whether the analysis image is larger than the image.
    pub(in crate::divergence) is_enlarged: bool,
}

impl Frame {
    /// The image over the background.
    ///
    /// Codes of 16 bits become the nearest of 8. Transparent pixels are mixed in sRGB codes:
    /// `round((c a + background (255 − a)) / 255)`. The analysis image is made by a triangle filter as
    /// wide as the step between its pixels (antialiased; Pillow's `BILINEAR`), from the 8-bit luma.
    pub(in crate::divergence) fn of(
        pixels: &DynamicImage,
        background: Background,
        size: AnalysisSize,
    ) -> Self {
        let rgb = opaque(pixels, background);
        let luma: Vec<f32> = rgb.pixels().map(|p| f32::from(luma(p.0)) / 255.0).collect();
        let (width, height) = rgb.dimensions();
        let (to_width, to_height) = size.of(width, height);
        let plane = ImageBuffer::<Luma<f32>, _>::from_raw(width, height, luma);
        let plane = plane.unwrap_or_default();
        let plane = if (to_width, to_height) == (width, height) {
            plane
        } else {
            resize(&plane, to_width, to_height, FilterType::Triangle)
        };
        let side = |n: u32| usize::try_from(n).unwrap_or_default();
        Self {
            rgb,
            analysis: LumaPlane {
                width: side(to_width),
                height: side(to_height),
                values: plane.into_raw().iter().map(|v| v * 255.0).collect(),
            },
            is_enlarged: to_width > width || to_height > height,
        }
    }

    pub(super) fn luma_counts(&self) -> Counts {
        let mut histogram = vec![0.0; 256];
        for pixel in self.rgb.pixels() {
            if let Some(slot) = histogram.get_mut(usize::from(luma(pixel.0))) {
                *slot += 1.0;
            }
        }
        Counts::of(&histogram)
    }

    pub(super) fn rgb_counts(&self) -> Counts {
        let mut histogram = vec![0.0; 16 * 16 * 16];
        for pixel in self.rgb.pixels() {
            let [r, g, b] = pixel.0.map(|code| usize::from(code >> 4));
            if let Some(slot) = histogram.get_mut((r * 16 + g) * 16 + b) {
                *slot += 1.0;
            }
        }
        Counts::of(&histogram)
    }
}

fn opaque(pixels: &DynamicImage, background: Background) -> RgbImage {
    if !pixels.color().has_alpha() {
        return pixels.to_rgb8();
    }
    let rgba = pixels.to_rgba8();
    let (width, height) = rgba.dimensions();
    RgbImage::from_fn(width, height, |x, y| {
        let [r, g, b, alpha] = rgba.get_pixel(x, y).0;
        let alpha = u32::from(alpha);
        image::Rgb([r, g, b].map(|code| {
            let mixed = u32::from(code) * alpha + background.code() * (255 - alpha);
            u8::try_from((mixed + 127) / 255).unwrap_or(u8::MAX)
        }))
    })
}

/// Luma of BT.601 in 16-bit fixed point.
fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19_595 * u32::from(r) + 38_470 * u32::from(g) + 7_471 * u32::from(b) + 0x8000;
    u8::try_from(sum >> 16).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use image::{ImageBuffer, Rgba};

    use super::*;

    #[test]
    fn white_stays_white_and_what_is_clear_shows_the_background() {
        assert_eq!((luma([255; 3]), luma([0; 3])), (255, 0), "both ends");
        let clear =
            DynamicImage::ImageRgba8(ImageBuffer::from_pixel(2, 2, Rgba([200, 200, 200, 0])));
        let half =
            DynamicImage::ImageRgba8(ImageBuffer::from_pixel(2, 2, Rgba([200, 200, 200, 128])));
        let code = |image, background| opaque(image, background).get_pixel(0, 0).0[0];
        assert_eq!(code(&clear, Background::Black), 0, "clear over black");
        assert_eq!(code(&clear, Background::White), 255, "clear over white");
        assert_eq!(code(&half, Background::Black), 100, "200 · 128 / 255");
    }

    #[test]
    fn sixteen_bits_and_gray_give_the_histogram_of_their_eight_bit_like() {
        let gray =
            |level: u8| DynamicImage::ImageLuma8(ImageBuffer::from_pixel(3, 3, Luma([level])));
        let deep = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(3, 3, Luma([77 * 257_u16])));
        let of = |image: &DynamicImage| {
            Frame::of(image, Background::Black, AnalysisSize::default()).luma_counts()
        };
        assert_eq!(of(&deep), of(&gray(77)), "77 of 255");
        assert_ne!(of(&deep), of(&gray(78)), "and not its neighbor");
    }

    #[test]
    fn the_analysis_image_keeps_the_shape_and_its_limit() {
        let size = AnalysisSize::default();
        assert_eq!(size.of(1242, 375), (848, 256), "a KITTI frame");
        assert_eq!(size.of(100, 200), (256, 512), "enlarged");
        assert_eq!(size.of(100_000, 10), (2048, 1), "a thread of an image");
        let own = AnalysisSize {
            shorter_side_px: 0,
            ..size
        };
        assert_eq!(own.of(1242, 375), (1242, 375), "its own");
    }

    #[test]
    fn a_small_image_is_said_to_be_enlarged() {
        let image = DynamicImage::ImageLuma8(ImageBuffer::from_pixel(8, 8, Luma([9])));
        let frame = Frame::of(&image, Background::Black, AnalysisSize::default());
        assert!(frame.is_enlarged, "from 8 to 256");
        let mean = frame.analysis.values.iter().sum::<f32>() / 65_536.0;
        assert!(
            (mean - 9.0).abs() < 1e-3,
            "an even image stays even: {mean}"
        );
        assert_eq!(Background::Gray.code(), 128, "the middle");
        let first = frame.analysis.values.first().copied().unwrap();
        assert!((first - 9.0).abs() < 1e-3, "up to its rim: {first}");
    }
}
