//! A frame whose pixels come from other places.

use wide::f32x4;

use crate::pyramid::vectorized;

/// Form of the light of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Channel {
    /// Values per pixel, side by side.
    pub(super) n: usize,
    /// Width and height, px.
    pub(super) size: (usize, usize),
}

/// The map is asked at the corners of squares of this side, px, and is straight between: of the strongest distortion
/// that recipes have, and in its corner, it is wrong by a hundredth of a px.
const SQUARE: usize = 8;

/// The light of each pixel as it was at another place, px, which is said of its middle; black where there is none.
/// Beyond the frame its border goes on.
///
/// Between pixels by the cubic of Keys \[Keys1981\], which keeps what is a straight line or a parabola: a frame that is
/// moved by half a pixel is not blurred as by a mean of neighbors. It gives no light below 0.
pub(super) fn resample(
    light: &[f32],
    Channel { n, size }: Channel,
    from: impl Fn(f64, f64) -> Option<[f64; 2]>,
) -> Vec<f32> {
    match n {
        1 => resample_of::<1>(light, size, from),
        _ => resample_of::<3>(light, size, from),
    }
}

fn resample_of<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    from: impl Fn(f64, f64) -> Option<[f64; 2]>,
) -> Vec<f32> {
    let light = light.as_chunks::<COLORS>().0;
    let mut out = vec![0.0; light.len() * COLORS];
    let rows = out.as_chunks_mut::<COLORS>().0;
    let corners_of = |y: usize| -> Vec<Option<[f64; 2]>> {
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let at = |x: usize| from(x as f64, y as f64);
        (0..=width.div_ceil(SQUARE))
            .map(|k| at(k * SQUARE))
            .collect()
    };
    let mut above = corners_of(0);
    for top in (0..height).step_by(SQUARE) {
        let below = corners_of(top + SQUARE);
        let bottom = (top + SQUARE).min(height);
        for (k, left) in (0..width).step_by(SQUARE).enumerate() {
            let right = (left + SQUARE).min(width);
            if let [Some(a), Some(b), Some(c), Some(d)] =
                [above[k], above[k + 1], below[k], below[k + 1]]
            {
                vectorized(
                    #[inline(always)]
                    || {
                        for y in top..bottom {
                            let t = part_of_square(y - top);
                            let [first, last] = [[a, c], [b, d]]
                                .map(|[a, c]| [0, 1].map(|k| a[k] + t * (c[k] - a[k])));
                            let row = &mut rows[y * width + left..y * width + right];
                            for (x, pixel) in row.iter_mut().enumerate() {
                                let s = part_of_square(x);
                                let place = [0, 1].map(|k| first[k] + s * (last[k] - first[k]));
                                *pixel = sample(light, (width, height), place);
                            }
                        }
                    },
                );
                continue;
            }
            for y in top..bottom {
                for x in left..right {
                    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                    let place = from(x as f64 + 0.5, y as f64 + 0.5);
                    if let Some(place) = place {
                        rows[y * width + x] = sample(light, (width, height), place);
                    }
                }
            }
        }
        above = below;
    }
    out
}

/// Where the middle of a pixel of a square is between its sides.
#[expect(clippy::cast_precision_loss, reason = "px of a square")]
#[inline(always)]
fn part_of_square(k: usize) -> f64 {
    (k as f64 + 0.5) / SQUARE as f64
}

/// The light at a place.
#[inline(always)]
fn sample<const COLORS: usize>(
    light: &[[f32; COLORS]],
    (width, height): (usize, usize),
    [u, v]: [f64; 2],
) -> [f32; COLORS] {
    let (left, across) = taps(u);
    let (top, down) = taps(v);
    let is_inside =
        left >= 0 && top >= 0 && left + 5 <= width.cast_signed() && top + 4 <= height.cast_signed();
    if is_inside && COLORS == 3 {
        // Of each of four columns, with some of the next pixel at the end.
        let mut columns = [f32x4::ZERO; 4];
        let first = top.cast_unsigned() * width + left.cast_unsigned();
        for (row, down) in down.into_iter().enumerate() {
            let five = light[first + row * width..][..5].as_flattened();
            let down = f32x4::splat(down);
            for (k, to) in columns.iter_mut().enumerate() {
                if let Some(from) = five[k * COLORS..].first_chunk() {
                    *to += down * f32x4::new(*from);
                }
            }
        }
        let [a, b, d, e] = [0, 1, 2, 3].map(|k| f32x4::splat(across[k]) * columns[k]);
        let sum = ((a + b) + (d + e)).fast_max(f32x4::ZERO).to_array();
        return std::array::from_fn(|c| sum[c]);
    }
    let mut columns = [[0.0; COLORS]; 4];
    if is_inside {
        let first = top.cast_unsigned() * width + left.cast_unsigned();
        for (row, down) in down.into_iter().enumerate() {
            let four = light[first + row * width..][..4].as_flattened();
            for (to, from) in columns.as_flattened_mut().iter_mut().zip(four) {
                *to += down * from;
            }
        }
    } else {
        for (k, down) in (top..).zip(down) {
            let row = clamped(k, height) * width;
            for (k, to) in (left..).zip(&mut columns) {
                let from = light[row + clamped(k, width)];
                for c in 0..COLORS {
                    to[c] += down * from[c];
                }
            }
        }
    }
    std::array::from_fn(|c| {
        let [a, b, d, e] = columns.map(|column| column[c]);
        let sum = (across[0] * a + across[1] * b) + (across[2] * d + across[3] * e);
        sum.max(0.0)
    })
}

/// The first of four pixels around a place, px, and their shares.
#[expect(
    clippy::cast_possible_truncation,
    reason = "px of a frame; shares of light"
)]
#[inline(always)]
fn taps(place: f64) -> (isize, [f32; 4]) {
    let place = place - 0.5;
    let whole = place.floor();
    let t = (place - whole) as f32;
    let (t2, t3) = (t * t, t * t * t);
    let shares = [
        0.5 * (-t + 2.0 * t2 - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ];
    (whole as isize - 1, shares)
}

fn clamped(k: isize, n: usize) -> usize {
    k.clamp(0, n.cast_signed() - 1).cast_unsigned()
}
