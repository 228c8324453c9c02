//! Cracks that are not quite straight: a smooth displacement of the plane.

use std::f64::consts::TAU;

use rand_chacha::rand_core::Rng;
use starbreak_seed::uniform;

const N_WAVES: usize = 12;
/// Wavelengths, in cells.
const WAVELENGTH: [f64; 2] = [1.4, 4.0];
/// Standard deviation of each component, in cells. Its gradient stays well below 1, so that no
/// two lines come to cross.
const AMPLITUDE: f64 = 0.05;

/// A sum of plane waves.
pub(super) struct Wander {
    waves: Vec<Wave>,
}

struct Wave {
    vector: [f64; 2],
    phase: f64,
    displacement: [f64; 2],
}

impl Wander {
    pub(super) fn new(cell_m: f64, rng: &mut impl Rng) -> Self {
        let waves = (0..N_WAVES)
            .map(|_| {
                let [length, direction, phase, turn] = [(); 4].map(|()| uniform(rng));
                let length =
                    cell_m * WAVELENGTH[0] * libm::pow(WAVELENGTH[1] / WAVELENGTH[0], length);
                let (sin, cos) = libm::sincos(TAU * direction);
                let (dy, dx) = libm::sincos(TAU * turn);
                #[expect(clippy::cast_precision_loss, reason = "a dozen")]
                let amplitude = 2.0 * AMPLITUDE * cell_m / (N_WAVES as f64).sqrt();
                Wave {
                    vector: [TAU / length * cos, TAU / length * sin],
                    phase: TAU * phase,
                    displacement: [amplitude * dx, amplitude * dy],
                }
            })
            .collect();
        Self { waves }
    }

    /// Displacement at a point, m.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.waves.iter().fold([0.0; 2], |sum, wave| {
            let s = libm::sin(wave.vector[0] * x + wave.vector[1] * y + wave.phase);
            [
                sum[0] + s * wave.displacement[0],
                sum[1] + s * wave.displacement[1],
            ]
        })
    }
}
