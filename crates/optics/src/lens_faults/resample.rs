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
                        let corners = [a, b, c, d];
                        let moves_across = moves_of(corners, [left, top], 0);
                        let moves_down = moves_of(corners, [left, top], 1);
                        for y in top..bottom {
                            let t = part_of_square(y - top);
                            let across = Taps::between(t, &moves_across);
                            let down = Taps::between(t, &moves_down);
                            let row = &mut rows[y * width + left..y * width + right];
                            if let Some(first) =
                                first_of_all([&across, &down], [left, y], (width, height))
                            {
                                let light = light[first..].as_flattened();
                                let row = row.as_flattened_mut();
                                let n_row = width * COLORS;
                                if COLORS == 1
                                    && let Some(row) = row.first_chunk_mut()
                                {
                                    *row =
                                        sample_row(light, (n_row, 1), &across.shares, &down.shares);
                                    continue;
                                }
                                if let Some(row) = row.first_chunk_mut() {
                                    let across = of_colors(&across.shares);
                                    let down = of_colors(&down.shares);
                                    *row = sample_row(light, (n_row, COLORS), &across, &down);
                                    continue;
                                }
                            }
                            for (x, pixel) in row.iter_mut().enumerate() {
                                let (across, down) = (across.at(x, left + x), down.at(x, y));
                                *pixel = sample(light, (width, height), across, down);
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
                        let [across, down] = [(x, place[0]), (y, place[1])]
                            .map(|(at, place)| Taps::of([moved(place, at, 0.5)]).at(0, at));
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
fn part_of_square(k: usize) -> f32 {
    (k as f32 + 0.5) / SQUARE as f32
}

/// How far a place is from that of a pixel, or from so far behind it, px.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "some px"
)]
#[inline(always)]
fn moved(place: f64, pixel: usize, behind: f64) -> f32 {
    (place - (pixel as f64 + behind)) as f32
}

/// How far the places of a square's corners are from these along an axis, px: upper left and right, lower left and right.
#[inline(always)]
fn moves_of(places: [[f64; 2]; 4], first: [usize; 2], axis: usize) -> [f32; 4] {
    let mut moves = [0.0; 4];
    for (k, (to, place)) in moves.iter_mut().zip(places).enumerate() {
        let is_beyond = [k % 2, k / 2][axis];
        *to = moved(place[axis], first[axis] + SQUARE * is_beyond, 0.0);
    }
    moves
}

/// The first of the four pixels of each of some places side by side, if these are side by side, too, and all within the
/// frame.
#[inline(always)]
fn first_of_all(
    [across, down]: [&Taps<SQUARE>; 2],
    [left, y]: [usize; 2],
    (width, height): (usize, usize),
) -> Option<usize> {
    // Along a row moves only grow or only fall, so that the outermost tell of all between.
    let is_one = |taps: &Taps<SQUARE>| taps.first[0] == taps.first[SQUARE - 1];
    if !(is_one(across) && is_one(down)) {
        return None;
    }
    let left = left.checked_add_signed(across.first[0] as isize)?;
    let top = y.checked_add_signed(down.first[0] as isize)?;
    let is_inside = left + SQUARE + 3 <= width && top + 4 <= height;
    is_inside.then_some(top * width + left)
}

/// The light at places side by side, each by four columns and four rows, from the first of all: as [`sample`]. `n_row` values
/// make a row of the frame, `n_colors` a pixel.
#[inline(always)]
fn sample_row<const N: usize>(
    light: &[f32],
    (n_row, n_colors): (usize, usize),
    across: &[[f32; N]; 4],
    down: &[[f32; N]; 4],
) -> [f32; N] {
    let mut columns = [[0.0; N]; 4];
    for (j, down) in down.iter().enumerate() {
        let row = &light[j * n_row..][..N + 3 * n_colors];
        for (i, column) in columns.iter_mut().enumerate() {
            let row = &row[i * n_colors..][..N];
            for x in 0..N {
                column[x] += down[x] * row[x];
            }
        }
    }
    let mut sum = [0.0; N];
    for x in 0..N {
        let near = across[0][x] * columns[0][x] + across[1][x] * columns[1][x];
        let far = across[2][x] * columns[2][x] + across[3][x] * columns[3][x];
        sum[x] = (near + far).max(0.0);
    }
    sum
}

/// Shares of places for each of their colors.
#[inline(always)]
fn of_colors(shares: &[[f32; SQUARE]; 4]) -> [[f32; 3 * SQUARE]; 4] {
    let mut all = [[0.0; 3 * SQUARE]; 4];
    for (all, shares) in all.iter_mut().zip(shares) {
        for (x, to) in all.iter_mut().enumerate() {
            *to = shares[x / 3];
        }
    }
    all
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

/// For places side by side, px, the first of the four pixels around each, from the pixel that it is of, and their shares.
struct Taps<const N: usize> {
    first: [i32; N],
    shares: [[f32; N]; 4],
}

impl Taps<SQUARE> {
    /// For the columns of a square, in a row between its upper corners and its lower ones.
    // Loops and no `map`: its closures are not inlined, and so are compiled for the oldest processor.
    #[inline(always)]
    fn between(t: f32, [a, b, c, d]: &[f32; 4]) -> Self {
        let first = a + t * (c - a);
        let last = b + t * (d - b);
        let mut moved = [0.0; SQUARE];
        for (x, moved) in moved.iter_mut().enumerate() {
            *moved = first + part_of_square(x) * (last - first);
        }
        Self::of(moved)
    }
}

impl<const N: usize> Taps<N> {
    #[inline(always)]
    fn of(moved: [f32; N]) -> Self {
        let mut first = [0; N];
        let mut shares = [[0.0; N]; 4];
        for x in 0..N {
            let whole = moved[x].floor();
            let t = moved[x] - whole;
            let (t2, t3) = (t * t, t * t * t);
            // What is no number is beyond the border, too: there all processors make 0 of it.
            let bounded = if whole > -FARTHEST { whole } else { -FARTHEST }.min(FARTHEST);
            first[x] = lowest_bits(bounded - 1.0);
            shares[0][x] = 0.5 * (-t + 2.0 * t2 - t3);
            shares[1][x] = 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3);
            shares[2][x] = 0.5 * (t + 4.0 * t2 - 3.0 * t3);
            shares[3][x] = 0.5 * (t3 - t2);
        }
        Self { first, shares }
    }

    /// Those of one place, which is that of a pixel.
    #[inline(always)]
    fn at(&self, x: usize, pixel: usize) -> (isize, [f32; 4]) {
        let [a, b, c, d] = &self.shares;
        let first = pixel.cast_signed() + self.first[x] as isize;
        (first, [a[x], b[x], c[x], d[x]])
    }
}

/// Farther than any frame is wide, px.
const FARTHEST: f32 = 4e6;

/// A whole number below 2²² as an integer: added to 1.5 · 2²³, whose last bit counts 1, it lies in the lowest bits.
#[inline(always)]
fn lowest_bits(whole: f32) -> i32 {
    // A cast would saturate, and is not done for several at once.
    (whole + 12_582_912.0).to_bits().cast_signed() - 12_582_912_f32.to_bits().cast_signed()
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
            let at = [x, y];
            let moved = match corners {
                [Some(a), Some(b), Some(c), Some(d)] => Some([0, 1].map(|k| {
                    let before = (at[k] / SQUARE * SQUARE) as f64;
                    let beyond = before + SQUARE as f64;
                    let [of_b, of_c] = [1 - k, k].map(|is| if is == 1 { beyond } else { before });
                    let a = (a[k] - before) as f32;
                    let b = (b[k] - of_b) as f32;
                    let c = (c[k] - of_c) as f32;
                    let d = (d[k] - beyond) as f32;
                    let (first, last) = (a + t * (c - a), b + t * (d - b));
                    first + s * (last - first)
                })),
                _ => from(x as f64 + 0.5, y as f64 + 0.5)
                    .map(|place| [0, 1].map(|k| (place[k] - (at[k] as f64 + 0.5)) as f32)),
            };
            let Some(moved) = moved else {
                out.extend([0.0; COLORS]);
                continue;
            };
            let taps = [0, 1].map(|k| {
                let whole = moved[k].floor();
                let t = moved[k] - whole;
                let (t2, t3) = (t * t, t * t * t);
                let shares = [
                    0.5 * (-t + 2.0 * t2 - t3),
                    0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
                    0.5 * (t + 4.0 * t2 - 3.0 * t3),
                    0.5 * (t3 - t2),
                ];
                (
                    (whole as isize)
                        .saturating_add_unsigned(at[k])
                        .saturating_sub(1),
                    shares,
                )
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
