//! Seeded randomness for clouds, leaves and sensor grain.
//!
//! What comes out depends on the seed only, so two drawings are equal.

use image::RgbImage;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

/// A value between two bounds, evenly spread.
pub(super) fn between(rng: &mut ChaCha8Rng, low: f32, high: f32) -> f32 {
    // 24 bits fit a single-precision value exactly.
    let [a, b, c, _] = rng.next_u32().to_le_bytes();
    let steps = f32::from(a) + 256.0 * (f32::from(b) + 256.0 * f32::from(c));
    low + (high - low) * steps / 16_777_216.0
}

/// Standard deviation of the grain, in gray levels of 255.
const GRAIN_SIGMA: f32 = 2.0;
/// Standard deviation of the sum of four bytes: sqrt(4 * (256^2 - 1) / 12).
const BYTE_SUM_SIGMA: f32 = 147.8;

/// Adds the fine grain of a camera sensor to every pixel, mostly in
/// brightness and a little in color.
pub(super) fn add_grain(image: &mut RgbImage, rng: &mut ChaCha8Rng) {
    for pixel in image.pixels_mut() {
        // The sum of four bytes is close to a bell curve and cheap.
        let bytes = rng.next_u32().to_le_bytes().map(f32::from);
        let brightness = (bytes.iter().sum::<f32>() - 510.0) / BYTE_SUM_SIGMA * GRAIN_SIGMA;
        for (value, tilt) in pixel.0.iter_mut().zip(bytes) {
            *value = to_byte(f32::from(*value) + brightness + (tilt - 127.5) / 160.0);
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value is clamped to a byte's range first"
)]
fn to_byte(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}
