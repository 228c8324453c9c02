//! Gaussian blur of chosen pixels of a frame, and of no others.

use crate::bit_rows::BitRows;

/// A normalized, symmetric kernel: its half from the middle outward.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kernel {
    half: Vec<f32>,
}

impl Kernel {
    /// A sampled Gaussian of standard deviation `sigma_px`, cut to `2·radius + 1` taps and
    /// normalized to sum 1, as OpenCV's `getGaussianKernel` makes it.
    pub(crate) fn gaussian(radius: usize, sigma_px: f64) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a kernel radius")]
        let in_sigmas = |k: usize| k as f64 / sigma_px;
        let tap = |k: usize| libm::exp(-0.5 * (in_sigmas(k) * in_sigmas(k)));
        let sum: f64 = 1.0 + 2.0 * (1..=radius).map(tap).sum::<f64>();
        #[expect(clippy::cast_possible_truncation, reason = "taps as f32")]
        let half = (0..=radius).map(|k| (tap(k) / sum) as f32).collect();
        Self { half }
    }

    /// A sampled Gaussian of a standard deviation, in samples, that is cut where hardly any of it is left.
    pub(crate) fn wide(sigma: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some samples"
        )]
        let radius = (3.5 * sigma).ceil() as usize;
        Self::gaussian(radius, sigma.max(1e-6))
    }

    pub(crate) fn radius(&self) -> usize {
        self.half.len() - 1
    }
}

/// Index of a sample beyond the border: mirrored about the border pixel, which is not repeated
/// (OpenCV's `BORDER_REFLECT_101`).
pub(crate) fn reflect(index: isize, n: usize) -> usize {
    if n == 1 {
        return 0;
    }
    let period = 2 * (n.cast_signed() - 1);
    let folded = index.rem_euclid(period);
    folded.min(period - folded).cast_unsigned()
}

/// A frame that is read and written by runs of a row. The blur loads a row for the last time
/// before it stores the row `radius` above it, so that both may be the same image.
pub(crate) trait Frame {
    /// Fills `row` with the interleaved samples of pixels `start..end` of row `y`.
    fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]);
    /// Takes the blurred samples of pixels `start..end` of row `y`.
    fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]);
}

/// Blurs a frame of `channels` interleaved samples per pixel at the pixels of `wanted`.
///
/// Only pixels that matter are loaded and stored, rows in ascending order. Every sum runs in a
/// fixed order, so the result does not depend on how the compiler vectorizes it.
pub(crate) fn blur_pixels(
    wanted: &BitRows,
    (width, height): (usize, usize),
    channels: usize,
    kernel: &Kernel,
    frame: &mut impl Frame,
) {
    let radius = kernel.radius();
    let needed = wanted.dilated_across_rows(radius);
    let row_samples = width * channels;
    let mut ring = vec![0.0_f32; (2 * radius + 1).min(height) * row_samples];
    let slots = ring.len() / row_samples;
    let mut padded = vec![0.0_f32; row_samples + 2 * radius * channels];
    let mut blurred = vec![0.0_f32; row_samples];
    let mut next = 0;
    for y in 0..height {
        let runs = wanted.runs(y);
        // Horizontal pass, one row ahead of what the vertical pass needs.
        while next < height && next <= y + radius {
            let slot = &mut ring[(next % slots) * row_samples..][..row_samples];
            for (start, end) in needed.runs(next) {
                pad_run(
                    next,
                    (start, end),
                    (width, channels, radius),
                    &mut padded,
                    frame,
                );
                let samples = (end - start + 2 * radius) * channels;
                let n = (end - start) * channels;
                let shifted = |k: usize| &padded[k * channels..samples][..n];
                let taps: Vec<_> = (0..=radius)
                    .map(|k| (shifted(radius - k), shifted(radius + k)))
                    .collect();
                weighted_sum(&taps, kernel, &mut slot[start * channels..end * channels]);
            }
            next += 1;
        }
        for (start, end) in runs {
            let span = start * channels..end * channels;
            let out = &mut blurred[span.clone()];
            let row = |k: isize| {
                let slot = reflect(y.cast_signed() + k, height) % slots;
                &ring[slot * row_samples..][span.clone()]
            };
            let taps: Vec<_> = (0..=radius.cast_signed())
                .map(|k| (row(-k), row(k)))
                .collect();
            weighted_sum(&taps, kernel, out);
            frame.store(y, start, end, out);
        }
    }
}

/// Σ over the taps of weight · (sample on one side + sample on the other); the first tap has
/// the middle on both sides. Blocks of samples keep their sums in registers.
#[inline(always)]
pub(crate) fn weighted_sum(taps: &[(&[f32], &[f32])], kernel: &Kernel, out: &mut [f32]) {
    const BLOCK: usize = 32;
    let weight = |k: usize| {
        if k == 0 {
            kernel.half[0] * 0.5
        } else {
            kernel.half[k]
        }
    };
    let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
    for (at, block) in blocks.iter_mut().enumerate() {
        let mut sums = [0.0_f32; BLOCK];
        for (k, (one, other)) in taps.iter().enumerate() {
            let (one, other) = (
                &one.as_chunks::<BLOCK>().0[at],
                &other.as_chunks::<BLOCK>().0[at],
            );
            let weight = weight(k);
            for (sum, (a, b)) in sums.iter_mut().zip(one.iter().zip(other)) {
                *sum += weight * (a + b);
            }
        }
        *block = sums;
    }
    let first = blocks.len() * BLOCK;
    for (at, sample) in (first..).zip(rest) {
        *sample = taps
            .iter()
            .enumerate()
            .map(|(k, (one, other))| weight(k) * (one[at] + other[at]))
            .sum();
    }
}

/// The samples of a run and `radius` pixels on both sides of it, mirrored at the border.
fn pad_run(
    y: usize,
    (start, end): (usize, usize),
    (width, channels, radius): (usize, usize, usize),
    padded: &mut [f32],
    frame: &mut impl Frame,
) {
    let (first, last) = (start.saturating_sub(radius), (end + radius).min(width));
    // Where pixel `first` stands in the padded run.
    let offset = first + radius - start;
    frame.load(
        y,
        first,
        last,
        &mut padded[offset * channels..][..(last - first) * channels],
    );
    let total = end - start + 2 * radius;
    for place in (0..offset).chain(offset + last - first..total) {
        let x = reflect(
            place.cast_signed() + start.cast_signed() - radius.cast_signed(),
            width,
        );
        if (first..last).contains(&x) {
            let from = (x - first + offset) * channels;
            padded.copy_within(from..from + channels, place * channels);
        } else {
            frame.load(y, x, x + 1, &mut padded[place * channels..][..channels]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_sum_to_one() {
        for (radius, sigma) in [(0, 1.0), (1, 0.5), (7, 2.6), (40, 12.0)] {
            let kernel = Kernel::gaussian(radius, sigma);
            let sum: f64 = kernel
                .half
                .iter()
                .map(|tap| 2.0 * f64::from(*tap))
                .sum::<f64>()
                - f64::from(kernel.half[0]);
            assert!((sum - 1.0).abs() < 1e-6, "radius {radius}: {sum}");
        }
    }

    #[test]
    fn reflection_is_that_of_opencv() {
        let mirrored: Vec<usize> = (-4..8).map(|k| reflect(k, 4)).collect();
        assert_eq!(
            mirrored,
            [2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0, 1],
            "gfedcb|abcdefgh|gfedcba"
        );
        assert_eq!(reflect(-9, 1), 0, "a row of one pixel mirrors to itself");
    }

    #[test]
    fn chosen_pixels_get_what_a_full_blur_gives_them() {
        for (width, height, radius) in [(1, 1, 3), (1, 40, 2), (40, 1, 7), (5, 6, 9), (90, 33, 4)] {
            let channels = 2;
            let image: Vec<f32> = (0..width * height * channels)
                .map(|k| ((k * 7919) % 251) as f32)
                .collect();
            let kernel = Kernel::gaussian(radius, 1.9);
            let mut wanted = BitRows::new(width, height);
            for (x, y) in [(0, 0), (width - 1, height - 1), (width / 2, height / 2)] {
                wanted.set_run(y, x, x + 1);
            }
            let wanted = wanted.dilated(2);
            let mut frame = Recorder {
                image: image.clone(),
                width,
                channels,
                stored: Vec::new(),
            };
            blur_pixels(&wanted, (width, height), channels, &kernel, &mut frame);
            for &(x, y, c, value) in &frame.stored {
                let expected = slow(&image, (width, height), channels, &kernel, (x, y), c);
                assert!(
                    (f64::from(value) - expected).abs() < 1e-3,
                    "({x}, {y}) of {width}×{height}"
                );
            }
            let asked: usize = (0..height).map(|y| wanted.ones(y).count()).sum();
            assert_eq!(
                frame.stored.len(),
                asked * channels,
                "every chosen sample once"
            );
        }
    }

    /// Spoils what is stored, so that a load after the store would show.
    struct Recorder {
        image: Vec<f32>,
        width: usize,
        channels: usize,
        stored: Vec<(usize, usize, usize, f32)>,
    }

    impl Frame for Recorder {
        fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
            let at = |x: usize| (y * self.width + x) * self.channels;
            row.copy_from_slice(&self.image[at(start)..at(end)]);
        }

        fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
            for (x, pixel) in (start..end).zip(row.chunks(self.channels)) {
                for (c, &value) in pixel.iter().enumerate() {
                    self.stored.push((x, y, c, value));
                    self.image[(y * self.width + x) * self.channels + c] = f32::NAN;
                }
            }
        }
    }

    fn slow(
        image: &[f32],
        (width, height): (usize, usize),
        channels: usize,
        kernel: &Kernel,
        (x, y): (usize, usize),
        c: usize,
    ) -> f64 {
        let radius = kernel.radius().cast_signed();
        let mut sum = 0.0;
        for j in -radius..=radius {
            for i in -radius..=radius {
                let weight = f64::from(kernel.half[i.unsigned_abs()])
                    * f64::from(kernel.half[j.unsigned_abs()]);
                let (sx, sy) = (
                    reflect(x.cast_signed() + i, width),
                    reflect(y.cast_signed() + j, height),
                );
                sum += weight * f64::from(image[(sy * width + sx) * channels + c]);
            }
        }
        sum
    }
}
