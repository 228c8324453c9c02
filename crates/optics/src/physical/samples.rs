//! Samples of an image as light, whatever their depth.

use crate::environment::luminance;
use crate::srgb::{decode8, decode16, encode8, encode16};

/// A sample of an image.
pub(super) trait Sample: Copy {
    /// Its light, linear, in units of white.
    fn light(self) -> f32;
    /// The nearest code of light; beyond black and white it is clipped.
    fn code(light: f32) -> Self;
}

impl Sample for u8 {
    #[inline]
    fn light(self) -> f32 {
        decode8(self)
    }

    #[inline]
    fn code(light: f32) -> Self {
        encode8(light)
    }
}

impl Sample for u16 {
    #[inline]
    fn light(self) -> f32 {
        decode16(self)
    }

    #[inline]
    fn code(light: f32) -> Self {
        encode16(light)
    }
}

/// How samples lie in a buffer: `COLORS` of them per pixel, then `EXTRA` that are left alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout<const COLORS: usize, const EXTRA: usize>;

impl<const COLORS: usize, const EXTRA: usize> Layout<COLORS, EXTRA> {
    pub(super) const STRIDE: usize = COLORS + EXTRA;
}

/// One value per color of an image from red, green and blue: themselves, or their luminance.
#[inline]
pub(super) fn per_color<const COLORS: usize>(rgb: [f32; 3]) -> [f32; COLORS] {
    std::array::from_fn(|c| if COLORS == 3 { rgb[c] } else { luminance(rgb) })
}
