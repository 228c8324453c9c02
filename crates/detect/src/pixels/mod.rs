//! Images to the numbers that a model takes.

mod antialiased;
mod area;
mod linear;
mod placement;
mod tensor;

pub use placement::Placement;
pub(crate) use placement::place;
pub(crate) use tensor::{ImageTensor, image_tensor};

use image::RgbImage;

use crate::contract::Interpolation;

/// The image in another size, to the bit as the named function makes it of 8-bit images:
/// `cv2.resize` of OpenCV 5.0 on x86-64, or `Image.resize` of Pillow 11.
///
/// `INTER_LINEAR` is fixed-point bilinear interpolation of 11-bit weights without antialiasing;
/// halved on both sides it is the mean of 2 × 2 pixels. `INTER_AREA` is the mean over the area of
/// the new pixel in 32-bit floating point, rounded half to even; enlarged along a side it is
/// bilinear interpolation of its own weights. Pillow's `BILINEAR` is a triangle as wide as two new
/// pixels where a side shrinks, in fixed point of 22 bits, columns before rows (Pillow 13 takes rows
/// first of some sizes, and differs by a level there).
///
/// # Limits
///
/// An image or a size without pixels gives an image without pixels.
#[must_use]
pub fn resize(source: &RgbImage, width_px: u32, height_px: u32, how: Interpolation) -> RgbImage {
    let (w, h) = source.dimensions();
    if (w, h) == (width_px, height_px) {
        return source.clone();
    }
    if w == 0 || h == 0 || width_px == 0 || height_px == 0 {
        return RgbImage::new(width_px, height_px);
    }
    let x = Side::new(w, width_px);
    let y = Side::new(h, height_px);
    let pixels = match how {
        Interpolation::Linear if x.is_halved() && y.is_halved() => area::whole(source, x, y),
        Interpolation::Linear => linear::resize(source, x, y, linear::Weights::Centers),
        Interpolation::Area if x.scale >= 1.0 && y.scale >= 1.0 => {
            if x.whole_factor().is_some() && y.whole_factor().is_some() {
                area::whole(source, x, y)
            } else {
                area::fractional(source, x, y)
            }
        }
        Interpolation::Area => linear::resize(source, x, y, linear::Weights::Edges),
        Interpolation::Antialiased => antialiased::resize(source, x, y),
    };
    RgbImage::from_raw(width_px, height_px, pixels)
        .unwrap_or_else(|| RgbImage::new(width_px, height_px))
}

/// One side of an image, before and after.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: u32,
    to: u32,
    /// New pixels per old one.
    inverse: f64,
    /// Old pixels per new one, by OpenCV's way of two divisions.
    scale: f64,
}

impl Side {
    fn new(from: u32, to: u32) -> Self {
        let inverse = f64::from(to) / f64::from(from);
        Self {
            from,
            to,
            inverse,
            scale: 1.0 / inverse,
        }
    }

    /// How many old pixels a new one has, where that is a whole number.
    fn whole_factor(self) -> Option<u32> {
        let rounded = self.scale.round_ties_even();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number up to the side of an image"
        )]
        ((self.scale - rounded).abs() < f64::EPSILON).then_some(rounded as u32)
    }

    fn is_halved(self) -> bool {
        self.whole_factor() == Some(2)
    }
}
