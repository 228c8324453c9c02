//! Samples of an image to linear light and back, by the transfer function of sRGB.
//!
//! With s the sample over the greatest code and x the light over white \[IEC1999\]:
//!
//! x = s/12.92 up to s = 0.04045, else ((s + 0.055)/1.055)^2.4
//!
//! Encoding gives the code whose light is nearest in s: code k from the light of (k − ½) up to
//! that of (k + ½). It looks up, then compares with that limit, so it is the rounded inverse
//! itself rather than an approximation of it: every code comes back as it was, and more light
//! never gives a lower code. Light below 0 and NaN give 0, light above 1 gives the greatest code.
//!
//! What it assumes: that the image was encoded for display by this function and nothing else.
//! Cameras also apply a tone curve; light is then linear on the display, not in the scene, and
//! what was clipped is gone.

mod transfer;

use std::sync::LazyLock;

use transfer::linear;

use crate::pyramid::vectorized;

/// Light of each 8-bit code, in units of white.
pub static DECODE8: [f32; 256] = decode8_table();

/// Light of an 8-bit code, in units of white.
#[inline]
#[must_use]
pub fn decode8(code: u8) -> f32 {
    DECODE8[usize::from(code)]
}

/// Light of a 16-bit code, in units of white. The first call fills a table of 256 KiB.
#[inline]
#[must_use]
pub fn decode16(code: u16) -> f32 {
    TABLES16.light[usize::from(code)]
}

/// The 8-bit code of light in units of white.
#[inline]
#[must_use]
pub fn encode8(light: f32) -> u8 {
    encode8_in(bin8(light), light)
}

/// [`encode8`] of many.
pub fn encode8_all(lights: &[f32], codes: &mut [u8]) {
    /// Whose bins are found together.
    const TOGETHER: usize = 32;
    vectorized(
        #[inline(always)]
        || {
            let (lights, last_lights) = lights.as_chunks::<TOGETHER>();
            let (codes, last_codes) = codes.as_chunks_mut::<TOGETHER>();
            for (lights, codes) in lights.iter().zip(codes) {
                let bins = lights.map(bin8);
                for k in 0..TOGETHER {
                    codes[k] = encode8_in(bins[k], lights[k]);
                }
            }
            for (light, code) in last_lights.iter().zip(last_codes) {
                *code = encode8(*light);
            }
        },
    );
}

/// [`encode8`] of light that is in a [`bin8`].
#[inline(always)]
pub(crate) fn encode8_in(bin: u32, light: f32) -> u8 {
    let code = FIRST8[bin as usize % BINS];
    // At most one limit lies in a bin.
    code + u8::from(light >= LIMITS8[usize::from(code)])
}

/// As [`decode16`], by itself: tables do not pay for a few codes.
pub(crate) fn light_of_code16(code: u16) -> f32 {
    light16(f64::from(code))
}

/// The 16-bit code of light in units of white. The first call fills a table of 256 KiB.
#[must_use]
pub fn encode16(light: f32) -> u16 {
    code16(light, |code| TABLES16.limit[usize::from(code)])
}

/// As [`encode16`], by itself: tables do not pay for a few codes.
pub(crate) fn code16_of_light(light: f32) -> u16 {
    code16(light, limit16)
}

/// The 16-bit code of light, given the least light of the code after each but the last.
fn code16(light: f32, limit: impl Fn(u16) -> f32) -> u16 {
    if light.is_nan() || light <= 0.0 {
        return 0;
    }
    if light >= 1.0 {
        return u16::MAX;
    }
    // Between two 8-bit codes the curve is straight within two 16-bit codes, and lies above its
    // chord: the code is found from below.
    let mut below = usize::from(encode8(light));
    if light < DECODE8[below] {
        below -= 1;
    }
    let below = below.min(254);
    let (low, high) = (DECODE8[below], DECODE8[below + 1]);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a code within the 257 of an 8-bit step"
    )]
    let within = ((light - low) / (high - low) * 257.0) as usize;
    let mut code = u16::try_from(below * 257 + within).unwrap_or(u16::MAX);
    while code < u16::MAX && light >= limit(code) {
        code += 1;
    }
    code
}

/// Light of a 16-bit code, or of what lies between two.
#[expect(clippy::cast_possible_truncation, reason = "rounded once, to f32")]
fn light16(code: f64) -> f32 {
    linear(code / 65535.0) as f32
}

/// Least light of the code after this one.
fn limit16(code: u16) -> f32 {
    light16(f64::from(code) + 0.5)
}

/// Bins of light between 0 and 1, narrower than the narrowest 8-bit step, 1/(255 · 12.92).
const BINS: usize = 4096;

/// The bin whose middle light is nearest to, also outside 0 to 1.
#[inline(always)]
pub(crate) fn bin8(light: f32) -> u32 {
    #[expect(clippy::cast_precision_loss, reason = "the number of bins is exact")]
    let [bins, last] = [BINS as f32, (BINS - 1) as f32];
    let at = light * bins;
    // Comparisons that are false for NaN, which gets bin 0.
    let at = if at > 0.0 { at } else { 0.0 };
    let at = if at < last { at } else { last };
    // Whole numbers are the lowest bits of a single from 2^23 on: faster than a conversion, which
    // asks for what no whole number can be.
    (at + 8_388_608.0).to_bits() % (1 << BINS.ilog2())
}

/// Least light of the code after each; NaN, which nothing reaches, after the last.
static LIMITS8: [f32; 256] = limits8();

/// Code of the darkest light of each bin, half a bin below its middle.
static FIRST8: [u8; BINS] = first8();

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "rounded once, to f32"
)]
const fn decode8_table() -> [f32; 256] {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = linear(code as f64 / 255.0) as f32;
        code += 1;
    }
    table
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "rounded once, to f32"
)]
const fn limits8() -> [f32; 256] {
    let mut table = [f32::NAN; 256];
    let mut code = 0;
    while code < 255 {
        table[code] = linear((code as f64 + 0.5) / 255.0) as f32;
        code += 1;
    }
    table
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a code is below 256, and the edge of a bin is exact"
)]
const fn first8() -> [u8; BINS] {
    let limits = limits8();
    let mut table = [0; BINS];
    let (mut bin, mut code) = (0, 0);
    while bin < BINS {
        while (bin as f32 - 0.5) / BINS as f32 >= limits[code] {
            code += 1;
        }
        table[bin] = code as u8;
        bin += 1;
    }
    table
}

struct Tables16 {
    /// Light of each code.
    light: Vec<f32>,
    /// Least light of the code after each but the last.
    limit: Vec<f32>,
}

static TABLES16: LazyLock<Tables16> = LazyLock::new(|| Tables16 {
    light: (0..=u16::MAX).map(light_of_code16).collect(),
    limit: (0..u16::MAX).map(limit16).collect(),
});

#[cfg(test)]
mod tests;
