//! Noise of the sensor: photons are counted, amplifiers and rows add their own, and no two pixels are alike.
//!
//! A pixel that light u reaches, 1 where green is white, holds μ = u·white_e electrons in the mean. Its number is
//! \[EMVA1288\]
//!
//! e = P(μ(1 + p) + d) − d + N(read_e) + N_row(row_e) + D
//!
//! with P Poisson, N normal, p = N(prnu) and D = N(dsnu_e) of the sensor, not of the frame, and d = dark_e_s·τ·2^((T −
//! 25 °C)/doubling_k) electrons of dark current, whose mean the black level takes away again \[Theuwissen2009\]. From
//! [`MAX_COUNTED`](crate::draw::MAX_COUNTED) electrons on the Poisson number is drawn as a normal one.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;
use starbreak_seed::{Seed, Stream};

use crate::draw::{MAX_COUNTED, Normal, poisson, single};

/// What makes a sensor noisy. All zeros, and an infinite `white_e`, are no noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Electrons of a green pixel where the image is white.
    pub white_e: f64,
    /// Standard deviation of the reading of a pixel, electrons.
    pub read_e: f64,
    /// The same of a whole row, electrons.
    pub row_e: f64,
    /// Standard deviation of the pixels' sensitivities, a share.
    pub prnu: f64,
    /// Standard deviation of the pixels' offsets, electrons.
    pub dsnu_e: f64,
    /// Dark current at 25 °C, electrons per second.
    pub dark_e_s: f64,
    /// Kelvin that double the dark current.
    pub doubling_k: f64,
    /// Temperature of the sensor, °C.
    pub temperature_c: f64,
    /// Exposure, s.
    pub exposure_s: f64,
}

impl Noise {
    /// Electrons of dark current in a frame, in the mean.
    #[must_use]
    pub fn dark_e(&self) -> f64 {
        let doublings = (self.temperature_c - 25.0) / self.doubling_k;
        self.dark_e_s * self.exposure_s * libm::exp2(doublings)
    }

    /// Standard deviation where light u reaches a pixel, in units of white, over frames: without what is fixed in the
    /// sensor.
    #[must_use]
    pub fn deviation(&self, light: f64) -> f64 {
        let shot_e = light.max(0.0) * self.white_e + self.dark_e();
        let square = shot_e + self.read_e * self.read_e + self.row_e * self.row_e;
        if self.is_nothing() {
            0.0
        } else {
            square.sqrt() / self.white_e
        }
    }

    /// Whether there is none: endless electrons.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        !self.white_e.is_finite()
    }

    /// Signal over its noise at 18 % of white, by which ISO 12232 judges pictures: 10 is acceptable, 40 excellent.
    #[must_use]
    pub fn snr_18(&self) -> f64 {
        0.18 / self.deviation(0.18)
    }

    /// The noise of a row of pixels: how much to add to the light of each.
    pub(crate) fn row(&self, y: usize, seed: Seed, sensor: Seed) -> Row {
        let row = y as u64;
        let has_pattern = self.prnu > 0.0 || self.dsnu_e > 0.0;
        let mut electrons = seed.stream(Stream::SensorElectrons, row);
        let normal = Normal::new();
        Row {
            row_e: self.row_e * f64::from(normal.of(electrons.next_u32())),
            dark_e: self.dark_e(),
            electrons,
            pattern: has_pattern.then(|| sensor.stream(Stream::SensorPattern, row)),
            normal,
        }
    }
}

/// The noise of one row, pixel after pixel.
pub(crate) struct Row {
    row_e: f64,
    dark_e: f64,
    electrons: ChaCha8Rng,
    pattern: Option<ChaCha8Rng>,
    normal: Normal,
}

impl Row {
    /// What the noise adds to the light of the next pixel.
    #[inline]
    pub(crate) fn next(&mut self, noise: &Noise, light: f32) -> f32 {
        let [shot, read] = [self.electrons.next_u32(), self.electrons.next_u32()];
        let (gain, offset_e) = match &mut self.pattern {
            Some(pattern) => (
                noise.prnu * f64::from(self.normal.of(pattern.next_u32())),
                noise.dsnu_e * f64::from(self.normal.of(pattern.next_u32())),
            ),
            None => (0.0, 0.0),
        };
        let signal_e = f64::from(light.max(0.0)) * noise.white_e;
        let mean_e = (signal_e * (1.0 + gain)).max(0.0) + self.dark_e;
        let counted_e = if mean_e < MAX_COUNTED {
            poisson(mean_e, shot)
        } else {
            mean_e + mean_e.sqrt() * f64::from(self.normal.of(shot))
        };
        let read_e = noise.read_e * f64::from(self.normal.of(read));
        single(
            (counted_e - self.dark_e - signal_e + read_e + self.row_e + offset_e) / noise.white_e,
        )
    }
}
