//! A plane of numbers at another size.

use super::frame::LumaPlane;

/// The plane at another size, by a triangle filter as wide as the step between its pixels: down the columns, then along
/// the rows.
///
/// **Source**: `image::imageops::resize` with `FilterType::Triangle`, which gives the same bits, and sums four channels
/// pixel by pixel where this sums whole rows.
pub(super) fn resampled(plane: &LumaPlane, to_width: u32, to_height: u32) -> LumaPlane {
    let (width, height) = plane.dimensions();
    let row_length = usize::try_from(width.max(1)).unwrap_or(1);
    let rows: Vec<&[f32]> = plane.as_raw().chunks_exact(row_length).collect();
    let (across, down) = (taps(width, to_width), taps(height, to_height));
    let mut values = Vec::with_capacity(across.len() * down.len());
    let mut sums = vec![0.0_f32; row_length];
    for tap in &down {
        sums.fill(0.0);
        for (row, weight) in rows.iter().skip(tap.first).zip(&tap.weights) {
            for (sum, value) in sums.iter_mut().zip(*row) {
                *sum += value * weight;
            }
        }
        for tap in &across {
            let under = sums.iter().skip(tap.first).zip(&tap.weights);
            let sum = under.fold(0.0, |sum, (value, weight)| sum + value * weight);
            values.push(sum.clamp(0.0, 1.0));
        }
    }
    LumaPlane::from_raw(to_width, to_height, values).unwrap_or_default()
}

/// What a pixel is a mean of.
struct Tap {
    first: usize,
    /// Their sum is 1.
    weights: Vec<f32>,
}

/// Of each of `n_to` pixels in a row, over a row of `n_from`.
fn taps(n_from: u32, n_to: u32) -> Vec<Tap> {
    #[expect(clippy::cast_precision_loss, reason = "sides of images")]
    let of_n = |n: u32| n as f32;
    let step = of_n(n_from) / of_n(n_to);
    let reach = step.max(1.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most the side"
    )]
    let whole = |place: f32| (place.clamp(0.0, of_n(n_from)) as u32).min(n_from);
    let tap = |at: u32| {
        let center = (of_n(at) + 0.5) * step;
        let first = whole(libm::floorf(center - reach)).min(n_from.saturating_sub(1));
        let end = whole(libm::ceilf(center + reach)).max(first + 1);
        let center = center - 0.5;
        let triangle = |place: u32| (1.0 - ((of_n(place) - center) / reach).abs()).max(0.0);
        let mut weights: Vec<f32> = (first..end).map(triangle).collect();
        let sum: f32 = weights.iter().fold(0.0, |sum, weight| sum + weight);
        for weight in &mut weights {
            *weight /= sum;
        }
        Tap {
            first: usize::try_from(first).unwrap_or_default(),
            weights,
        }
    };
    (0..n_to).map(tap).collect()
}

#[cfg(test)]
mod tests {
    use image::imageops::{FilterType, resize};

    use super::*;

    #[test]
    fn planes_are_those_of_the_library_to_the_bit() {
        let sizes = [
            [640, 427, 384, 256],
            [100, 200, 256, 512],
            [7, 5, 3, 11],
            [2049, 3, 2048, 3],
            [1, 1, 256, 256],
            [300, 2, 2048, 14],
        ];
        for [width, height, to_width, to_height] in sizes {
            let mut state = width * 7919 + height;
            let plane = LumaPlane::from_fn(width, height, |_, _| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                image::Luma([f32::from(u8::try_from(state >> 24).unwrap_or(0)) / 255.0])
            });
            let library = resize(&plane, to_width, to_height, FilterType::Triangle);
            let ours = resampled(&plane, to_width, to_height);
            assert_eq!(ours.dimensions(), library.dimensions(), "size");
            let bits = |plane: &LumaPlane| plane.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(
                bits(&ours) == bits(&library),
                "{width} x {height} to {to_width} x {to_height}"
            );
        }
    }
}
