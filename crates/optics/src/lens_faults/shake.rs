//! A camera that turns while it exposes.

use std::f64::consts::TAU;

use starbreak_seed::{Seed, Stream, uniform};

use super::Optic;
use crate::pyramid::{mirrored, vectorized};

/// A camera that turns, or trembles, while a frame is exposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shake {
    /// Fastest turn, rad/s.
    pub rate_rad_s: f64,
    /// Direction in which the picture moves, from right towards down, rad.
    pub direction_rad: f64,
    /// How often it goes to and fro, Hz; 0: it turns evenly.
    pub frequency_hz: f64,
    /// How long a frame is exposed, s.
    pub exposure_s: f64,
}

/// Places of a path per px of its length.
const PER_PX: f64 = 4.0;

/// Most places: of a path longer than any frame some are left out.
const MOST_PLACES: usize = 1 << 20;

impl Shake {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.rate_rad_s <= 0.0 || self.exposure_s <= 0.0
    }

    /// Longest way of the picture in an exposure, px: L = f ω τ where it turns evenly, and no more than twice the
    /// amplitude f ω/(2πν) where it trembles.
    #[must_use]
    pub fn longest_px(&self, optic: &Optic) -> f64 {
        let even = optic.f_px * self.rate_rad_s * self.exposure_s;
        if self.frequency_hz > 0.0 {
            let half_turns = (0.5 * TAU * self.frequency_hz * self.exposure_s).min(0.5 * TAU * 0.5);
            let amplitude = optic.f_px * self.rate_rad_s / (TAU * self.frequency_hz);
            2.0 * amplitude * libm::sin(half_turns)
        } else {
            even
        }
    }

    /// Where the picture is in the course of an exposure, px along its direction, at moments of one length; about 0.
    fn path(&self, optic: &Optic, frame: Seed) -> Vec<f64> {
        let even_px = optic.f_px * self.rate_rad_s * self.exposure_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a path of some thousand px"
        )]
        let n = ((PER_PX * even_px).ceil() as usize).clamp(16, MOST_PLACES);
        let phase = TAU * uniform(&mut frame.stream(Stream::Shake, 0));
        #[expect(clippy::cast_precision_loss, reason = "a million at most")]
        let moments = (0..n).map(|k| (k as f64 + 0.5) / n as f64 - 0.5);
        let mut path: Vec<f64> = moments
            .map(|moment| {
                if self.frequency_hz > 0.0 {
                    let turn = TAU * self.frequency_hz;
                    let at = turn * moment * self.exposure_s + phase;
                    optic.f_px * self.rate_rad_s / turn * libm::sin(at)
                } else {
                    moment * even_px
                }
            })
            .collect();
        #[expect(clippy::cast_precision_loss, reason = "a million at most")]
        let mean = path.iter().sum::<f64>() / n as f64;
        path.iter_mut().for_each(|place| *place -= mean);
        path
    }

    /// The kernel: for each pixel that the path touches its share of the exposure, dwell on the path divided among the
    /// four pixels around it.
    fn kernel(&self, optic: &Optic, frame: Seed) -> Vec<((isize, isize), f32)> {
        let (sin, cos) = libm::sincos(self.direction_rad);
        let mut path = self.path(optic, frame);
        #[expect(clippy::cast_precision_loss, reason = "a million at most")]
        let dwell = 1.0 / path.len() as f64;
        let wanted = dwell * path.iter().map(|place| place * place).sum::<f64>();
        // A place between pixels is spread to them: that variance, 1/6 in the mean, is taken off the path's.
        let shrunk = (1.0 - (1.0 / 6.0 / wanted).min(0.5)).sqrt();
        path.iter_mut().for_each(|place| *place *= shrunk);
        let mut shares = std::collections::BTreeMap::new();
        for along in path {
            let [x, y] = [along * cos, along * sin];
            let [left, top] = [x.floor(), y.floor()];
            let [s, t] = [x - left, y - top];
            for (dx, dy, share) in [
                (0.0, 0.0, (1.0 - s) * (1.0 - t)),
                (1.0, 0.0, s * (1.0 - t)),
                (0.0, 1.0, (1.0 - s) * t),
                (1.0, 1.0, s * t),
            ] {
                #[expect(clippy::cast_possible_truncation, reason = "some px")]
                let at = ((top + dy) as isize, (left + dx) as isize);
                // Beyond the frame it goes on mirrored, and so comes again after two frames.
                let at = [(at.0, optic.size.1), (at.1, optic.size.0)]
                    .map(|(k, n)| folded(k, n.cast_signed()));
                *shares.entry((at[0], at[1])).or_insert(0.0) += dwell * share;
            }
        }
        // Of a path shorter than pixels can show as much as has its variance.
        #[expect(clippy::cast_precision_loss, reason = "some px")]
        let square = |(y, x): &(isize, isize)| {
            let along = *x as f64 * cos + *y as f64 * sin;
            along * along
        };
        let is_folded = self.longest_px(optic) > optic.half_diagonal_px();
        let found: f64 = shares.iter().map(|(at, share)| square(at) * share).sum();
        if found > wanted && !is_folded {
            let part = wanted / found;
            shares.values_mut().for_each(|share| *share *= part);
            *shares.entry((0, 0)).or_insert(0.0) += 1.0 - part;
        }
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        let single = |share: f64| share as f32;
        let all = shares.into_iter().filter(|(_, share)| *share > 1e-9);
        all.map(|((y, x), share)| ((x, y), single(share))).collect()
    }

    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic, frame: Seed) {
        let kernel = self.kernel(optic, frame);
        let (width, height) = optic.size;
        let reach = kernel
            .iter()
            .map(|((x, _), _)| x.unsigned_abs())
            .max()
            .unwrap_or(0);
        // Each row with as much on either side as the path reaches; beyond the frame it goes on mirrored.
        let stride = (width + 2 * reach) * n_colors;
        let mut wide = Vec::with_capacity(stride * height);
        for row in light.chunks_exact(width * n_colors) {
            for x in -reach.cast_signed()..(width + reach).cast_signed() {
                let at = mirrored(x, width) * n_colors;
                wide.extend_from_slice(&row[at..at + n_colors]);
            }
        }
        vectorized(
            #[inline(always)]
            || {
                for (y, row) in light.chunks_exact_mut(width * n_colors).enumerate() {
                    row.fill(0.0);
                    for ((dx, dy), share) in &kernel {
                        // What is seen here was there.
                        let from_y = mirrored(y.cast_signed() - dy, height);
                        let first = (reach.cast_signed() - dx).cast_unsigned() * n_colors;
                        let from = &wide[from_y * stride + first..][..width * n_colors];
                        for (to, from) in row.iter_mut().zip(from) {
                            *to += share * from;
                        }
                    }
                }
            },
        );
    }
}

/// A way of so many px in a frame of n px that goes on mirrored: the same, within n px to either side.
fn folded(way: isize, n: isize) -> isize {
    (way + n).rem_euclid(2 * n) - n
}
