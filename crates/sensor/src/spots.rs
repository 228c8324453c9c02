//! Dust on the glass that covers the sensor.

use std::f64::consts::PI;

use starbreak_seed::{Seed, Stream, uniform};

use crate::draw::{Normal, single};

/// Opaque, round grains of dust on the cover of the sensor, at a height over its pixels.
///
/// Light comes to a pixel from the whole exit pupil, through a disc of diameter b = height/N on the cover. A grain of
/// diameter D takes away the part of that disc that it covers: its shadow is D + b wide and min(1, (D/b)²) deep, and
/// holds the light of the grain's own area, whatever N. Diameters are log-normal (FIT), with the mean area of D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spots {
    /// How many.
    pub count: u32,
    /// Diameter of a usual grain, m.
    pub diameter_m: f64,
    /// From the cover to the pixels, m.
    pub height_m: f64,
    /// Focal length over the pupil's diameter.
    pub f_number: f64,
    /// From pixel to pixel, m.
    pub pitch_m: f64,
}

/// Standard deviation of the logarithm of the grains' diameters. FIT.
const SPREAD: f64 = 0.4;

impl Spots {
    /// Whether there are none.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.count == 0
    }

    /// Radius of the disc through which light comes to a pixel, px.
    fn disc_px(&self) -> f64 {
        0.5 * self.height_m / self.f_number / self.pitch_m
    }

    /// Radius of a grain, px, so many times the usual one.
    fn grain_px(&self, factor: f64) -> f64 {
        0.5 * factor * self.diameter_m / self.pitch_m
    }

    /// Radius of the shadow of a usual grain, px.
    #[must_use]
    pub fn reach_px(&self) -> f64 {
        self.reach_of_px(1.0)
    }

    fn reach_of_px(&self, factor: f64) -> f64 {
        self.disc_px() + self.grain_px(factor)
    }

    /// Share of the light that the middle of the shadow of a usual grain lacks.
    #[must_use]
    pub fn depth(&self) -> f64 {
        let ratio = self.diameter_m * self.f_number / self.height_m;
        (ratio * ratio).min(1.0)
    }

    /// Share of the light that is lost at a distance from the middle of a shadow, px: what two circles have in common,
    /// over the disc. The grain is so many times as wide as the usual one.
    #[must_use]
    pub fn lost(&self, distance_px: f64, factor: f64) -> f64 {
        let (disc, grain) = (self.disc_px(), self.grain_px(factor));
        let small = disc.min(grain);
        let lens = if distance_px >= disc + grain {
            0.0
        } else if distance_px <= (disc - grain).abs() {
            PI * small * small
        } else {
            let half = |a: f64, b: f64| {
                let cosine = (distance_px * distance_px + a * a - b * b) / (2.0 * distance_px * a);
                let angle = libm::acos(cosine.clamp(-1.0, 1.0));
                a * a * (angle - 0.5 * libm::sin(2.0 * angle))
            };
            half(disc, grain) + half(grain, disc)
        };
        (lens / (PI * disc * disc)).min(1.0)
    }

    /// A sensor's spots: their middles, px from the frame's corner, and how many times as wide as the usual one the grain
    /// is. First those before the frame, then as many for each area beside it.
    #[must_use]
    pub fn of_sensor(&self, (width, height): (usize, usize), sensor: Seed) -> Vec<([f64; 2], f64)> {
        #[expect(clippy::cast_precision_loss, reason = "sides of a frame")]
        let sides = [width as f64, height as f64];
        let mut rng = sensor.stream(Stream::SensorSpots, 0);
        let mut normal = Normal::new().numbers(sensor, Stream::SensorSpots, 2);
        let mut factor = || libm::exp(SPREAD * normal() - SPREAD * SPREAD);
        let mut all = Vec::new();
        for _ in 0..self.count {
            all.push((sides.map(|side| side * uniform(&mut rng)), factor()));
        }
        // Wider grains are rare.
        let reach = self.reach_of_px(3.0);
        let around = sides.map(|side| side + 2.0 * reach);
        let ratio = around[0] * around[1] / (sides[0] * sides[1]) - 1.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of spots"
        )]
        let n_all = all.len() + (f64::from(self.count) * ratio).round() as usize;
        let mut rng = sensor.stream(Stream::SensorSpots, 1);
        while all.len() < n_all {
            let at = around.map(|side| side * uniform(&mut rng) - reach);
            if (0..2).any(|k| !(0.0..sides[k]).contains(&at[k])) {
                all.push((at, factor()));
            }
        }
        all
    }

    /// Calls for each pixel in the shadow of a spot with its place in rows from the top, and the share of light that is
    /// left.
    pub(crate) fn each_shadowed(
        &self,
        (width, height): (usize, usize),
        sensor: Seed,
        mut call: impl FnMut(usize, f32),
    ) {
        for ([x_px, y_px], factor) in self.of_sensor((width, height), sensor) {
            let reach = self.reach_of_px(factor);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "pixels of the frame"
            )]
            let near = |middle: f64, n: usize| {
                let first = (middle - reach).floor().max(0.0) as usize;
                first.min(n)..((middle + reach).ceil().max(0.0) as usize).min(n)
            };
            for y in near(y_px, height) {
                for x in near(x_px, width) {
                    #[expect(clippy::cast_precision_loss, reason = "pixels of a frame")]
                    let away = libm::hypot(x as f64 + 0.5 - x_px, y as f64 + 0.5 - y_px);
                    let left = single(1.0 - self.lost(away, factor));
                    if left < 1.0 {
                        call(y * width + x, left);
                    }
                }
            }
        }
    }
}
