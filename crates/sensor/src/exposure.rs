//! Too much light, or too little.

use crate::draw::single;

/// A wrong exposure: the light of a frame is 2^EV times what it should be.
///
/// A photograph brings the noise of its own exposure along. Of light k times as strong, k < 1, a sensor counts k times
/// the photons, whose noise is √k times as large, but the photograph's own noise becomes k times as large. The
/// missing part is added: μ(k − k²) + read_e²(1 − k²) electrons squared, with μ those of the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Steps of a factor of 2; below 0 it is darker.
    pub ev: f64,
    /// Electrons of a green pixel where the photograph is white.
    pub white_e: f64,
    /// Standard deviation of the reading of a pixel, electrons.
    pub read_e: f64,
}

impl Exposure {
    /// How many times as much light there is.
    #[must_use]
    pub fn gain(&self) -> f64 {
        libm::exp2(self.ev)
    }

    /// Whether it changes nothing.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.ev == 0.0
    }

    /// From the light of the darker frame to the standard deviation of the noise that it lacks, in units of white.
    pub(crate) fn missing(&self) -> impl Fn(f32) -> f32 + use<> {
        let (gain, white_e) = (self.gain(), self.white_e);
        // Of light u there were u/k.
        let of_shot = single((1.0 - gain) / white_e);
        let read = single(self.read_e * self.read_e * (1.0 - gain * gain) / (white_e * white_e));
        move |light| (light.max(0.0) * of_shot + read).max(0.0).sqrt()
    }
}
