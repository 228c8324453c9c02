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
                            let across = Taps::between(t, 0, [a, b, c, d]);
                            let down = Taps::between(t, 1, [a, b, c, d]);
                            let row = &mut rows[y * width + left..y * width + right];
                            for (x, pixel) in row.iter_mut().enumerate() {
                                *pixel = sample(light, (width, height), across.at(x), down.at(x));
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
                        let [across, down] = place.map(|place| Taps::of([place]).at(0));
                        rows[y * width + x] = sample(light, (width, height), across, down);
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

/// The light at a place, by four columns and four rows: the first of them, and their shares.
#[inline(always)]
fn sample<const COLORS: usize>(
    light: &[[f32; COLORS]],
    (width, height): (usize, usize),
    (left, across): (isize, [f32; 4]),
    (top, down): (isize, [f32; 4]),
) -> [f32; COLORS] {
    let is_inside =
        left >= 0 && top >= 0 && left + 4 <= width.cast_signed() && top + 4 <= height.cast_signed();
    if !is_inside {
        let mut columns = [[0.0; COLORS]; 4];
        for (k, down) in (top..).zip(down) {
            let row = clamped(k, height) * width;
            for (k, to) in (left..).zip(&mut columns) {
                let from = light[row + clamped(k, width)];
                for c in 0..COLORS {
                    to[c] += down * from[c];
                }
            }
        }
        return std::array::from_fn(|c| {
            let [a, b, d, e] = columns.map(|column| column[c]);
            let sum = (across[0] * a + across[1] * b) + (across[2] * d + across[3] * e);
            sum.max(0.0)
        });
    }
    let first = top.cast_unsigned() * width + left.cast_unsigned();
    let [a, b, d, e] = across;
    if COLORS == 1 {
        let mut columns = f32x4::ZERO;
        for (row, down) in down.into_iter().enumerate() {
            let four = light[first + row * width..][..4].as_flattened();
            if let ([four], []) = four.as_chunks::<4>() {
                columns += f32x4::splat(down) * f32x4::new(*four);
            }
        }
        let [i, j, k, l] = (f32x4::new(across) * columns).to_array();
        return [((i + j) + (k + l)).max(0.0); COLORS];
    }
    let [mut start, mut middle, mut end] = [f32x4::ZERO; 3];
    for (row, down) in down.into_iter().enumerate() {
        let four = light[first + row * width..][..4].as_flattened();
        let down = f32x4::splat(down);
        if let ([i, j, k], []) = four.as_chunks::<4>() {
            start += down * f32x4::new(*i);
            middle += down * f32x4::new(*j);
            end += down * f32x4::new(*k);
        }
    }
    let [r0, g0, b0, r1] = (start * f32x4::new([a, a, a, b])).to_array();
    let [g1, b1, r2, g2] = (middle * f32x4::new([b, b, d, d])).to_array();
    let [b2, r3, g3, b3] = (end * f32x4::new([d, e, e, e])).to_array();
    let sum = (f32x4::new([r0, g0, b0, 0.0]) + f32x4::new([r1, g1, b1, 0.0]))
        + (f32x4::new([r2, g2, b2, 0.0]) + f32x4::new([r3, g3, b3, 0.0]));
    let sum = sum.fast_max(f32x4::ZERO).to_array();
    std::array::from_fn(|c| sum[c])
}

/// For places side by side, px, the first of the four pixels around each, and their shares.
struct Taps<const N: usize> {
    first: [i32; N],
    shares: [[f32; N]; 4],
}

impl Taps<SQUARE> {
    /// For the columns of a square, in a row between its upper corners and its lower ones.
    // Loops and no `map`: its closures are not inlined, and so are compiled for the oldest processor.
    #[inline(always)]
    fn between(t: f64, axis: usize, [a, b, c, d]: [[f64; 2]; 4]) -> Self {
        let first = a[axis] + t * (c[axis] - a[axis]);
        let last = b[axis] + t * (d[axis] - b[axis]);
        let mut places = [0.0; SQUARE];
        for (x, place) in places.iter_mut().enumerate() {
            *place = first + part_of_square(x) * (last - first);
        }
        Self::of(places)
    }
}

impl<const N: usize> Taps<N> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "px of a frame; shares of light"
    )]
    #[inline(always)]
    fn of(places: [f64; N]) -> Self {
        let mut first = [0; N];
        let mut shares = [[0.0; N]; 4];
        for x in 0..N {
            let place = places[x] - 0.5;
            let whole = place.floor();
            let t = (place - whole) as f32;
            let (t2, t3) = (t * t, t * t * t);
            // What is no number is beyond the border, too: there all processors make 0 of it.
            let bounded = if whole > -1e9 { whole } else { -1e9 }.min(1e9);
            first[x] = lowest_bits(bounded - 1.0);
            shares[0][x] = 0.5 * (-t + 2.0 * t2 - t3);
            shares[1][x] = 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3);
            shares[2][x] = 0.5 * (t + 4.0 * t2 - 3.0 * t3);
            shares[3][x] = 0.5 * (t3 - t2);
        }
        Self { first, shares }
    }

    /// Those of one place.
    #[inline(always)]
    fn at(&self, x: usize) -> (isize, [f32; 4]) {
        let [a, b, c, d] = &self.shares;
        (self.first[x] as isize, [a[x], b[x], c[x], d[x]])
    }
}

/// A whole number below 2³¹ as an integer: added to 1.5 · 2⁵², whose last bit counts 1, it lies in the lowest bits.
#[expect(clippy::cast_possible_truncation, reason = "that is the point")]
#[inline(always)]
fn lowest_bits(whole: f64) -> i32 {
    // A cast would saturate, and is not done for several at once.
    (whole + 6_755_399_441_055_744.0).to_bits() as i32
}

fn clamped(k: isize, n: usize) -> usize {
    k.clamp(0, n.cast_signed() - 1).cast_unsigned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same without squares in vectors: each pixel alone, by the rule for the border.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "px of a frame; shares of light"
    )]
    fn plain<const COLORS: usize>(
        light: &[f32],
        (width, height): (usize, usize),
        from: impl Fn(f64, f64) -> Option<[f64; 2]>,
    ) -> Vec<f32> {
        let mut out = Vec::new();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let corner = |right: usize, down: usize| {
                let [x, y] = [x, y].map(|k| k / SQUARE * SQUARE);
                from((x + right * SQUARE) as f64, (y + down * SQUARE) as f64)
            };
            let [s, t] = [x, y].map(|k| part_of_square(k % SQUARE));
            let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            let place = match corners {
                [Some(a), Some(b), Some(c), Some(d)] => Some([0, 1].map(|k| {
                    let (first, last) = (a[k] + t * (c[k] - a[k]), b[k] + t * (d[k] - b[k]));
                    first + s * (last - first)
                })),
                _ => from(x as f64 + 0.5, y as f64 + 0.5),
            };
            let Some(place) = place else {
                out.extend([0.0; COLORS]);
                continue;
            };
            let taps = place.map(|place| {
                let whole = (place - 0.5).floor();
                let t = (place - 0.5 - whole) as f32;
                let (t2, t3) = (t * t, t * t * t);
                let shares = [
                    0.5 * (-t + 2.0 * t2 - t3),
                    0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
                    0.5 * (t + 4.0 * t2 - 3.0 * t3),
                    0.5 * (t3 - t2),
                ];
                ((whole as isize).saturating_sub(1), shares)
            });
            let [(left, across), (top, down)] = taps;
            for color in 0..COLORS {
                let columns: [f32; 4] = std::array::from_fn(|i| {
                    let column = clamped(left.saturating_add_unsigned(i), width);
                    let at = |j| clamped(top.saturating_add_unsigned(j), height) * width + column;
                    (0..4).fold(0.0, |sum, j| sum + down[j] * light[at(j) * COLORS + color])
                });
                let [a, b, d, e] = std::array::from_fn(|i| across[i] * columns[i]);
                out.push(((a + b) + (d + e)).max(0.0));
            }
        }
        out
    }

    #[test]
    fn the_bits_are_those_of_each_pixel_alone_in_frames_of_any_size_and_at_any_place() {
        type Place = fn(f64, f64) -> Option<[f64; 2]>;
        let places: [Place; 7] = [
            |u, v| Some([u, v]),
            |u, v| Some([1.03 * u - 0.4, 0.95 * v + 0.7]),
            |u, v| Some([v - 3.0, 2.0 * u]),
            |u, v| (u > 4.0).then_some([u - 0.3, v]),
            |u, v| Some([u + 1e12, v - 1e300]),
            |u, v| Some([f64::NAN, v + u]),
            |u, v| Some([u, f64::INFINITY * (v - 2.0)]),
        ];
        for (width, height) in
            (1..=19).flat_map(|width| (1..=11).map(move |height| (width, height)))
        {
            let value = |k: usize| ((k * 7919 + 13) % 257) as f32 / 256.0;
            let light: Vec<f32> = (0..3 * width * height).map(value).collect();
            for (k, from) in places.iter().enumerate() {
                let size = (width, height);
                let bits =
                    |light: Vec<f32>| light.into_iter().map(f32::to_bits).collect::<Vec<_>>();
                let three = bits(resample(&light, Channel { n: 3, size }, from));
                assert_eq!(
                    three,
                    bits(plain::<3>(&light, size, from)),
                    "place {k} of {size:?}, colors"
                );
                let gray = &light[..width * height];
                let one = bits(resample(gray, Channel { n: 1, size }, from));
                assert_eq!(
                    one,
                    bits(plain::<1>(gray, size, from)),
                    "place {k} of {size:?}, gray"
                );
            }
        }
    }
}
