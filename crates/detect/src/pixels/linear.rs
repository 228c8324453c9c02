//! OpenCV's bilinear interpolation of 8-bit images, in fixed point.

use image::RgbImage;

use super::Side;

/// Where a new pixel lies between two old ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weights {
    /// By the centers of the pixels: `INTER_LINEAR`.
    Centers,
    /// By the edges of the pixels: what `INTER_AREA` is where a side grows.
    Edges,
}

/// An old pixel, and the weights of it and the next in 1/2048.
#[derive(Debug, Clone, Copy)]
struct Tap {
    first: i64,
    weights: [i32; 2],
}

/// Channels of a pixel.
const N: usize = 3;

/// The bytes of the image in its new size.
pub(super) fn resize(source: &RgbImage, x: Side, y: Side, weights: Weights) -> Vec<u8> {
    let columns = columns(x, weights);
    let rows = taps(y, weights);
    let row_len = columns.len() * N;
    let mut bytes = Vec::with_capacity(row_len * rows.len());
    // The two rows that are being blended, each with the number of its source.
    let mut upper = Row::new(row_len);
    let mut lower = Row::new(row_len);
    for tap in rows {
        let last = i64::from(y.from) - 1;
        let (first, second) = (tap.first.clamp(0, last), (tap.first + 1).clamp(0, last));
        if upper.number != first && lower.number == first {
            std::mem::swap(&mut upper, &mut lower);
        }
        upper.fill(source, first, &columns);
        lower.fill(source, second, &columns);
        let [b0, b1] = tap.weights;
        for (&s0, &s1) in upper.values.iter().zip(&lower.values) {
            let sum = ((b0 * (s0 >> 4)) >> 16) + ((b1 * (s1 >> 4)) >> 16);
            let value = ((sum + 2) >> 2).clamp(0, 255);
            bytes.push(u8::try_from(value).unwrap_or(u8::MAX));
        }
    }
    bytes
}

/// A row of the source in its new width, times 2048.
struct Row {
    number: i64,
    values: Vec<i32>,
}

impl Row {
    fn new(len: usize) -> Self {
        Self {
            number: -1,
            values: vec![0; len],
        }
    }

    fn fill(&mut self, source: &RgbImage, number: i64, columns: &[Column]) {
        if self.number == number {
            return;
        }
        self.number = number;
        let stride = source.width() as usize * N;
        let start = usize::try_from(number).unwrap_or(0) * stride;
        let Some(row) = source.as_raw().get(start..start + stride) else {
            return;
        };
        for (out, column) in self.values.chunks_exact_mut(N).zip(columns) {
            let old = |at: usize| row.get(at..at + N).unwrap_or(&[0; N]);
            let pixels = old(column.first).iter().zip(old(column.second));
            for (value, (&s0, &s1)) in out.iter_mut().zip(pixels) {
                *value = i32::from(s0) * column.weights[0] + i32::from(s1) * column.weights[1];
            }
        }
    }
}

/// Places of two bytes of a row, and their weights.
#[derive(Debug, Clone, Copy)]
struct Column {
    first: usize,
    second: usize,
    weights: [i32; 2],
}

/// The columns; along this side OpenCV gives an edge pixel all the weight.
fn columns(x: Side, weights: Weights) -> Vec<Column> {
    let last = i64::from(x.from) - 1;
    taps(x, weights)
        .into_iter()
        .map(|tap| {
            let is_edge = tap.first < 0 || tap.first >= last;
            let first = tap.first.clamp(0, last);
            let byte = |pixel: i64| usize::try_from(pixel).unwrap_or(0) * N;
            Column {
                first: byte(first),
                second: byte((first + 1).min(last)),
                weights: if is_edge { [2048, 0] } else { tap.weights },
            }
        })
        .collect()
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "OpenCV's own steps: places to f32, weights to 11 bits"
)]
fn taps(side: Side, weights: Weights) -> Vec<Tap> {
    let tap = |to: u32| {
        let (first, share) = match weights {
            Weights::Centers => {
                let place = ((f64::from(to) + 0.5) * side.scale - 0.5) as f32;
                (place.floor() as i64, place - place.floor())
            }
            Weights::Edges => {
                let first = (f64::from(to) * side.scale).floor();
                let share = (f64::from(to) + 1.0 - (first + 1.0) * side.inverse) as f32;
                let share = if share <= 0.0 {
                    0.0
                } else {
                    share - share.floor()
                };
                (first as i64, share)
            }
        };
        let fixed = |weight: f32| (weight * 2048.0).round_ties_even() as i32;
        Tap {
            first,
            weights: [fixed(1.0 - share), fixed(share)],
        }
    };
    (0..side.to).map(tap).collect()
}
