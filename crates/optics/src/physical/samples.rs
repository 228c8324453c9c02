//! Samples of an image as light, whatever their depth.

use crate::environment::luminance;
use crate::srgb::{bin8, decode8, decode16, encode8_in, encode16};

/// A sample of an image.
pub(super) trait Sample: Copy {
    /// Its light, linear, in units of white.
    fn light(self) -> f32;
    /// Where in its table [`Sample::code_in`] finds the code of light, which is found for many at
    /// once.
    fn bin(light: f32) -> u32;
    /// The nearest code of light of a bin; beyond black and white it is clipped.
    fn code_in(bin: u32, light: f32) -> Self;
    /// The nearest code of light.
    fn code(light: f32) -> Self {
        Self::code_in(Self::bin(light), light)
    }
}

impl Sample for u8 {
    #[inline(always)]
    fn light(self) -> f32 {
        decode8(self)
    }

    #[inline(always)]
    fn bin(light: f32) -> u32 {
        bin8(light)
    }

    #[inline(always)]
    fn code_in(bin: u32, light: f32) -> Self {
        encode8_in(bin, light)
    }
}

impl Sample for u16 {
    #[inline]
    fn light(self) -> f32 {
        decode16(self)
    }

    #[inline(always)]
    fn bin(_: f32) -> u32 {
        0
    }

    #[inline]
    fn code_in(_: u32, light: f32) -> Self {
        encode16(light)
    }
}

/// Linear light itself, which may be brighter than white.
impl Sample for f32 {
    #[inline(always)]
    fn light(self) -> f32 {
        self
    }

    #[inline(always)]
    fn bin(_: f32) -> u32 {
        0
    }

    #[inline(always)]
    fn code_in(_: u32, light: f32) -> Self {
        light
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
