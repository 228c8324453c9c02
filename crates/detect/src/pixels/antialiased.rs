//! Pillow's bilinear filter of 8-bit images, which grows with the reduction.

use image::RgbImage;

use super::Side;

/// Channels of a pixel.
const N: usize = 3;

/// Bits of a weight behind the point.
const PRECISION: i32 = 22;

/// The bytes of the image in its new size: columns first, rounded to bytes, rows then.
pub(super) fn resize(source: &RgbImage, x: Side, y: Side) -> Vec<u8> {
    let narrowed = columns(source.as_raw(), x);
    if y.from == y.to {
        return narrowed;
    }
    let stride = x.to as usize * N;
    let mut bytes = Vec::with_capacity(stride * y.to as usize);
    let mut sums = vec![0_i32; stride];
    for (first, weights) in taps(y) {
        sums.fill(1 << (PRECISION - 1));
        for (row, weight) in narrowed.chunks_exact(stride).skip(first).zip(weights) {
            for (sum, &value) in sums.iter_mut().zip(row) {
                *sum += i32::from(value) * weight;
            }
        }
        bytes.extend(sums.iter().map(|&sum| to_byte(sum)));
    }
    bytes
}

fn columns(raw: &[u8], x: Side) -> Vec<u8> {
    if x.from == x.to {
        return raw.to_vec();
    }
    let taps = taps(x);
    let mut bytes = Vec::new();
    for row in raw.chunks_exact(x.from as usize * N) {
        for (first, weights) in &taps {
            let mut sums = [1_i32 << (PRECISION - 1); N];
            for (pixel, weight) in row.chunks_exact(N).skip(*first).zip(weights) {
                for (sum, &value) in sums.iter_mut().zip(pixel) {
                    *sum += i32::from(value) * weight;
                }
            }
            bytes.extend(sums.map(to_byte));
        }
    }
    bytes
}

fn to_byte(sum: i32) -> u8 {
    u8::try_from((sum >> PRECISION).clamp(0, 255)).unwrap_or(u8::MAX)
}

/// Of each new pixel the first old one, and the weights from there on.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "Pillow's own steps: whole numbers up to the side of an image, weights to 22 bits"
)]
fn taps(side: Side) -> Vec<(usize, Vec<i32>)> {
    let scale = f64::from(side.from) / f64::from(side.to);
    // The reach of the triangle, in old pixels.
    let reach = scale.max(1.0);
    let tap = |to: u32| {
        let center = (f64::from(to) + 0.5) * scale;
        let first = (center - reach + 0.5).max(0.0) as u32;
        let end = ((center + reach + 0.5) as u32).min(side.from);
        let weights: Vec<f64> = (first..end)
            .map(|old| {
                let off = (f64::from(old) - center + 0.5) / reach;
                (1.0 - off.abs()).max(0.0)
            })
            .collect();
        let sum: f64 = weights.iter().sum();
        let fixed = weights.iter().map(|weight| {
            let share = if sum > 0.0 { weight / sum } else { *weight };
            (0.5 + share * f64::from(1 << PRECISION)) as i32
        });
        (first as usize, fixed.collect())
    };
    (0..side.to).map(tap).collect()
}
