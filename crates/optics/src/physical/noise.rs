//! The noise of the sensor, where the crack has changed the light.

use rand_chacha::rand_core::Rng;
use starbreak_seed::{Seed, Stream};

use super::SensorNoise;
use super::overlay::Run;
use crate::maps::CHUNK;

/// The sensor's noise, a stream of it for each run of pixels.
pub(super) struct Noise {
    pub(super) params: SensorNoise,
    pub(super) seed: Seed,
}

impl Noise {
    /// A number of standard deviation 1 for each color of a run.
    pub(super) fn of_run<const COLORS: usize>(
        &self,
        run: &Run,
        width: usize,
    ) -> [[f32; COLORS]; CHUNK] {
        let key = (run.y * width + run.x) as u64;
        let mut rng = self.seed.stream(Stream::SensorNoise, key);
        std::array::from_fn(|_| {
            std::array::from_fn(|_| {
                // The sum of three uniform numbers, of variance ¼: bounded, and near a normal one.
                let sum: f64 = (0..3)
                    .map(|_| f64::from(rng.next_u32()) / 4_294_967_296.0)
                    .sum();
                #[expect(clippy::cast_possible_truncation, reason = "noise as f32")]
                let unit = (2.0 * (sum - 1.5)) as f32;
                unit
            })
        })
    }

    /// Standard deviation of what is missing: the noise of the light that is there now, less
    /// what the image's own share brought along.
    pub(super) fn missing(&self, keep: f32, before: f32, after: f32) -> f32 {
        let SensorNoise { read, shot } = self.params;
        let variance = |light: f32| read * read + shot * f64::from(light.max(0.0));
        let brought = f64::from(keep * keep) * variance(before);
        #[expect(clippy::cast_possible_truncation, reason = "noise as f32")]
        let deviation = (variance(after) - brought).max(0.0).sqrt() as f32;
        deviation
    }
}
