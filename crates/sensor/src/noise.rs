//! Noise of the sensor: photons are counted, amplifiers and rows add their own, and no two pixels are alike.
//!
//! A pixel that light u reaches, 1 where green is white, holds μ = u·white_e electrons in the mean. Its number is
//! \[EMVA1288\]
//!
//! e = P(μ(1 + p) + d) − d + N(read_e) + N_row(row_e) + D
//!
//! with P Poisson, N normal, p = N(prnu) and D = N(dsnu_e) of the sensor, not of the frame, and d = dark_e_s·τ·2^((T −
//! 25 °C)/doubling_k) electrons of dark current, whose mean the black level takes away again \[Theuwissen2009\]: of the
//! well, which holds white_e, so much is lost. From
//! [`MAX_COUNTED`](crate::draw::MAX_COUNTED) electrons on the Poisson number is drawn as a normal one.

use starbreak_seed::{Seed, Stream};

use crate::draw::{MAX_COUNTED, Normal, Poisson, single, words_of};

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

    /// Adds the noise of row y to the light of each of its pixels.
    pub(crate) fn add_to_row(&self, y: usize, row: &[f32], change: &mut [f32], seeds: [Seed; 2]) {
        let [frame, sensor] = seeds;
        let words = words_of(frame, Stream::SensorElectrons, y, 1 + 2 * row.len());
        let has_pattern = self.prnu > 0.0 || self.dsnu_e > 0.0;
        let pattern = match has_pattern {
            true => words_of(sensor, Stream::SensorPattern, y, 2 * row.len()),
            false => Vec::new(),
        };
        let (normal, poisson) = (Normal::new(), Poisson::new());
        let [white_e, read_e, prnu, dsnu_e] =
            [self.white_e, self.read_e, self.prnu, self.dsnu_e].map(single);
        let dark_e = single(self.dark_e().min(MOST_DARK_E));
        let row_e = single(self.row_e) * normal.of(words[0]);
        // What dark current takes of the well is no longer there for light.
        let room = (1.0 - dark_e / white_e).max(0.0);
        let mut words = words[1..].chunks(2 * TOGETHER);
        let mut patterns = pattern.chunks(2 * TOGETHER);
        for (light, change) in row.chunks(TOGETHER).zip(change.chunks_mut(TOGETHER)) {
            let words = words.next().unwrap_or_default();
            let [by_chance, reading]: [[f32; TOGETHER]; 2] = normal.of_pairs(words);
            let pattern = patterns.next().unwrap_or_default();
            let [mut unlike_e, offsets]: [[f32; TOGETHER]; 2] = normal.of_pairs(pattern);
            let [mut mean_e, mut shot_e] = [[0.0; TOGETHER]; 2];
            for (k, light) in light.iter().enumerate() {
                let signal_e = light.max(0.0) * white_e;
                unlike_e[k] = signal_e * (prnu * unlike_e[k]).max(-1.0);
                mean_e[k] = signal_e + unlike_e[k] + dark_e;
                shot_e[k] = mean_e[k].sqrt() * by_chance[k];
            }
            for (k, word) in words.iter().step_by(2).enumerate() {
                let mean_e = mean_e[k];
                if mean_e < MAX_COUNTED {
                    let counted = poisson.of(mean_e, mean_e.sqrt(), *word, by_chance[k]);
                    shot_e[k] = counted - mean_e;
                }
            }
            for (k, (light, change)) in light.iter().zip(change).enumerate() {
                let read_e = read_e * reading[k];
                let noise_e = unlike_e[k] + shot_e[k] + read_e + row_e + dsnu_e * offsets[k];
                *change = (light + noise_e / white_e).min(room) - light;
            }
        }
    }
}

/// Pixels that are worked on together.
const TOGETHER: usize = 32;

/// More dark current than any well holds, electrons.
const MOST_DARK_E: f64 = 1e12;
