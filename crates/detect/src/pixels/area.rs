//! OpenCV's means over areas of 8-bit images.

use image::RgbImage;

use super::Side;

/// Channels of a pixel.
const N: usize = 3;

/// A new pixel is a whole number of old ones along both sides.
pub(super) fn whole(source: &RgbImage, x: Side, y: Side) -> Vec<u8> {
    let (kx, ky) = (x.whole_factor().unwrap_or(1), y.whole_factor().unwrap_or(1));
    let n_old = kx * ky;
    #[expect(
        clippy::cast_precision_loss,
        reason = "OpenCV's own: the share of a pixel as f32"
    )]
    let share = 1.0 / n_old as f32;
    let is_quarter = kx == 2 && ky == 2;
    let stride = source.width() as usize * N;
    let raw = source.as_raw();
    let mut bytes = Vec::with_capacity(x.to as usize * y.to as usize * N);
    for row in 0..y.to {
        for column in 0..x.to {
            let mut sums = [0_u32; N];
            for dy in 0..ky {
                let start = (row * ky + dy) as usize * stride + (column * kx) as usize * N;
                let old = raw.get(start..start + kx as usize * N).unwrap_or_default();
                for pixel in old.chunks_exact(N) {
                    for (sum, &value) in sums.iter_mut().zip(pixel) {
                        *sum += u32::from(value);
                    }
                }
            }
            bytes.extend(sums.map(|sum| {
                if is_quarter {
                    u8::try_from((sum + 2) >> 2).unwrap_or(u8::MAX)
                } else {
                    #[expect(clippy::cast_precision_loss, reason = "OpenCV's own: a sum as f32")]
                    to_byte(sum as f32 * share)
                }
            }));
        }
    }
    bytes
}

/// A new pixel has parts of old ones at its rim.
pub(super) fn fractional(source: &RgbImage, x: Side, y: Side) -> Vec<u8> {
    let columns = shares(x);
    let stride = source.width() as usize * N;
    let raw = source.as_raw();
    let mut bytes = Vec::with_capacity(columns.len() * y.to as usize * N);
    let mut narrowed = vec![0.0_f32; columns.len() * N];
    let mut sums = narrowed.clone();
    for row in shares(y) {
        sums.fill(0.0);
        for (old_row, weight) in row {
            let old = raw
                .get(old_row * stride..(old_row + 1) * stride)
                .unwrap_or_default();
            for (out, column) in narrowed.chunks_exact_mut(N).zip(&columns) {
                out.fill(0.0);
                for &(old_column, share) in column {
                    let pixel = old.get(old_column * N..(old_column + 1) * N);
                    for (value, &byte) in out.iter_mut().zip(pixel.unwrap_or_default()) {
                        *value += f32::from(byte) * share;
                    }
                }
            }
            for (sum, value) in sums.iter_mut().zip(&narrowed) {
                *sum += weight * value;
            }
        }
        bytes.extend(sums.iter().map(|&sum| to_byte(sum)));
    }
    bytes
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to a byte"
)]
fn to_byte(value: f32) -> u8 {
    value.round_ties_even().clamp(0.0, 255.0) as u8
}

/// Of each new pixel, the old ones with their shares: OpenCV's `computeResizeAreaTab`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "OpenCV's own steps: whole numbers up to the side of an image, shares to f32"
)]
fn shares(side: Side) -> Vec<Vec<(usize, f32)>> {
    let shares_of = |to: u32| {
        let begin = f64::from(to) * side.scale;
        let end = begin + side.scale;
        let cell = side.scale.min(f64::from(side.from) - begin);
        let last_whole = (end.floor() as u32).min(side.from - 1);
        let first_whole = (begin.ceil() as u32).min(last_whole);
        let mut shares = Vec::new();
        let before = f64::from(first_whole) - begin;
        if before > 1e-3 {
            shares.push((
                first_whole.saturating_sub(1) as usize,
                (before / cell) as f32,
            ));
        }
        for old in first_whole..last_whole {
            shares.push((old as usize, (1.0 / cell) as f32));
        }
        let after = end - f64::from(last_whole);
        if after > 1e-3 {
            shares.push((
                last_whole as usize,
                (after.min(1.0).min(cell) / cell) as f32,
            ));
        }
        shares
    };
    (0..side.to).map(shares_of).collect()
}
