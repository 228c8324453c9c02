//! A film of grease or water: glass that is no longer even.

use std::f64::consts::{SQRT_2, TAU};

use starbreak_seed::{Seed, Stream, uniform};

use crate::{Area, Coating, Field, Passage};

/// A film whose thickness varies smoothly.
///
/// Where it slopes by ∇h it is a prism that turns light by (n − 1) ∇h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// Standard deviation of its thickness, m.
    pub ripple_m: f64,
    /// From one thick place to the next across the wiper's way, mm, about.
    pub scale_mm: f64,
    /// Share of the light that it scatters in the mean; more where it is thick.
    pub haze: f64,
}

/// Refractive index of grease and of the oils of skin, about.
const GREASE: f64 = 1.47;

/// Times that it is smoother along the wiper's way, sideways. FIT.
const SMEARED: f64 = 4.0;

/// Waves that make it.
const N_WAVES: u32 = 24;

/// Shortest and longest wave, in scales.
const LENGTHS: [f64; 2] = [0.6, 2.0];

/// How much more haze there is in some places than in others, where hands and cloths were, and how large they are, mm.
/// FIT.
const PATCHES: (f64, f64) = (70.0, 0.8);

/// Share of the haze that is across the wiper's way. FIT.
const ACROSS: f64 = 0.5;

/// How much more it scatters where it is thicker by its standard deviation, a share. FIT.
const WHERE_THICK: f64 = 0.2;

/// Angle by which it scatters, rad. FIT.
const SCATTERS_BY_RAD: f64 = 0.1;

impl Film {
    /// Root mean square of the angle by which it turns light, rad: (n − 1) σ times the root mean square of its waves'
    /// numbers, 2π/λ.
    #[must_use]
    pub fn turns_by_rms_rad(&self) -> f64 {
        let [short, long] = LENGTHS.map(|it| TAU / (it * self.scale_mm));
        // Wave numbers are even between their ends.
        let square = (short * short + short * long + long * long) / 3.0;
        // Half of them sideways, where they are longer.
        let square = 0.5 * square * (1.0 + 1.0 / (SMEARED * SMEARED));
        (GREASE - 1.0) * self.ripple_m * 1e3 * square.sqrt()
    }

    pub(crate) fn on_pane(&self, area: &Area, seed: Seed) -> FilmedPane {
        let mut rng = seed.stream(Stream::Film, 9);
        let [most, least] = LENGTHS.map(|it| TAU / (it * self.scale_mm));
        let height_mm = self.ripple_m * 1e3 * SQRT_2 / f64::from(N_WAVES).sqrt();
        let waves = (0..N_WAVES)
            .map(|k| {
                // Evenly over numbers, in any direction.
                let part = (f64::from(k) + uniform(&mut rng)) / f64::from(N_WAVES);
                let number = least + (most - least) * part;
                let (sin, cos) = libm::sincos(TAU * uniform(&mut rng));
                let phase = TAU * uniform(&mut rng);
                Wave {
                    number: [number * cos / SMEARED, number * sin],
                    phase,
                }
            })
            .collect();
        FilmedPane {
            waves,
            turn_mm: (GREASE - 1.0) * height_mm,
            haze: self.haze,
            patches: Field::over(area, PATCHES, (Stream::Film, seed)),
        }
    }
}

/// h cos(k·x + φ).
struct Wave {
    number: [f64; 2],
    phase: f64,
}

/// A film on one pane.
pub(crate) struct FilmedPane {
    waves: Vec<Wave>,
    /// (n − 1) times the height of each wave.
    turn_mm: f64,
    haze: f64,
    patches: Field,
}

impl Coating for FilmedPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let (mut turned, mut height) = ([0.0; 2], 0.0);
        for wave in &self.waves {
            let [kx, ky] = wave.number;
            #[expect(clippy::cast_possible_truncation, reason = "a phase of some turns")]
            let phase = (kx * at_mm[0] + ky * at_mm[1] + wave.phase) as f32;
            let (sin, cos) = libm::sincosf(phase);
            let (sin, cos) = (f64::from(sin), f64::from(cos));
            height += cos;
            turned[0] += kx * sin;
            turned[1] += ky * sin;
        }
        // In standard deviations.
        let height = height * (2.0 / f64::from(N_WAVES)).sqrt();
        let haze = self.haze * self.patches.at(at_mm) * (1.0 + WHERE_THICK * height);
        let haze = haze.clamp(0.0, 1.0);
        Passage {
            covered: haze,
            direct: [1.0 - haze; 3],
            wide: (1.0 - ACROSS) * haze,
            streak: ACROSS * haze,
            across: [0.0, 1.0],
            turned_rad: turned.map(|it| it * self.turn_mm),
            ..Passage::CLEAN
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, SCATTERS_BY_RAD]
    }
}
