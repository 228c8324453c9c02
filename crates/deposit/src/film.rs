//! A film of grease or water: glass that is no longer even.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, SQRT_2, TAU};

use starbreak_seed::{Seed, Stream, uniform};

use crate::{Area, Coating, Field, Passage, vectorized};

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

/// Ways that are worked out side by side.
const TOGETHER: usize = 8;

impl FilmedPane {
    /// What it does to light in the mean over some ways, each by its middle and how far it goes, mm: the mean of a wave is that
    /// at the middle, times sin u/u of half of how far its phase goes.
    #[inline(always)]
    fn over<const N: usize>(&self, ways_mm: &[[[f64; 2]; 2]; N]) -> [Passage; N] {
        let [mut right, mut down, mut height] = [[0.0; N]; 3];
        for wave in &self.waves {
            let [kx, ky] = wave.number;
            let (mut phases, mut halves) = ([0.0; N], [0.0; N]);
            for (k, [[x, y], [along_x, along_y]]) in ways_mm.iter().enumerate() {
                #[expect(clippy::cast_possible_truncation, reason = "a phase of some turns")]
                let phase = (kx * x + ky * y + wave.phase) as f32;
                phases[k] = phase;
                halves[k] = 0.5 * (kx * along_x + ky * along_y);
            }
            let [sin, cos] = if phases.iter().all(|phase| phase.abs() <= MOST_PHASE) {
                sines(phases)
            } else {
                let both = phases.map(libm::sincosf);
                [
                    both.map(|it| f64::from(it.0)),
                    both.map(|it| f64::from(it.1)),
                ]
            };
            let left = means(halves);
            for k in 0..N {
                height[k] += left[k] * cos[k];
                right[k] += left[k] * kx * sin[k];
                down[k] += left[k] * ky * sin[k];
            }
        }
        let mut all = [Passage::CLEAN; N];
        for k in 0..N {
            all[k] = self.passage_of(ways_mm[k][0], [right[k], down[k]], height[k]);
        }
        all
    }

    /// By the sums over its waves.
    fn passage_of(&self, at_mm: [f64; 2], turned: [f64; 2], height: f64) -> Passage {
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
}

impl Coating for FilmedPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let [passage] = self.over(&[[at_mm, [0.0; 2]]]);
        passage
    }

    /// In closed form, wherever it is looked at.
    fn along(&self, ways_mm: &[[[f64; 2]; 2]], _: u32, to: &mut Vec<Passage>) {
        to.reserve(ways_mm.len());
        vectorized(
            #[inline(always)]
            || {
                let (together, rest) = ways_mm.as_chunks::<TOGETHER>();
                for ways in together {
                    to.extend(self.over(ways));
                }
                to.extend(rest.iter().flat_map(|way| self.over(&[*way])));
            },
        );
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, SCATTERS_BY_RAD]
    }
}

/// sin u/u of some numbers.
#[inline(always)]
fn means<const N: usize>(numbers: [f64; N]) -> [f64; N] {
    let mut means = [0.0; N];
    for (mean, u) in means.iter_mut().zip(numbers) {
        let z = u * u;
        *mean = 1.0 - z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z / 362_880.0)));
    }
    if numbers.iter().all(|u| u.abs() <= SHORT) {
        return means;
    }
    let mut phases = [0.0_f32; N];
    for (phase, u) in phases.iter_mut().zip(numbers) {
        #[expect(clippy::cast_possible_truncation, reason = "a phase of some turns")]
        let near = u.clamp(-f64::from(MOST_PHASE), f64::from(MOST_PHASE)) as f32;
        *phase = near;
    }
    let [sines, _] = sines(phases);
    for ((mean, u), sine) in means.iter_mut().zip(numbers).zip(sines) {
        if u.abs() > SHORT {
            *mean = sine / u;
        }
    }
    means
}

/// Numbers up to which the first terms of [`means`] do: to 3·10⁻⁸.
const SHORT: f64 = 1.0;

/// Phases up to which [`sines`] holds: some 2²⁸ quarters of a turn.
const MOST_PHASE: f32 = 4.2e8;

/// Phases up to which quarters of a turn are taken off in one piece: nine eighths of a turn.
const NEAR: f64 = 7.068_583_011_627_197;

/// Sines and cosines, to the last bit those of [`libm::sincosf`] but for the sign of 0. This is the part of it that most
/// phases come to.
#[inline(always)]
fn sines<const N: usize>(phases: [f32; N]) -> [[f64; N]; 2] {
    // The first 25 bits of π/2, and the rest; 3·2⁵¹, beyond which numbers are whole.
    const QUARTER: [f64; 2] = [1.570_796_310_901_641_8, 1.589_325_477_352_819_6e-8];
    const WHOLE: f64 = 6_755_399_441_055_744.0;
    let [mut sines, mut cosines] = [[0.0; N]; 2];
    for (k, phase) in phases.into_iter().enumerate() {
        let phase = f64::from(phase);
        let shifted = phase * FRAC_2_PI + WHOLE;
        let quarters = shifted - WHOLE;
        let x = if phase.abs() <= NEAR {
            phase - quarters * FRAC_PI_2
        } else {
            phase - quarters * QUARTER[0] - quarters * QUARTER[1]
        };
        let (z, w) = (x * x, (x * x) * (x * x));
        let rest = -0.000_198_393_348_360_966_32 + z * 0.000_002_718_311_493_989_822;
        let cubed = z * x;
        let sine = (x + cubed * (-0.166_666_666_416_265_24 + z * 0.008_333_329_385_889_463))
            + cubed * w * rest;
        let rest = -0.001_388_676_377_460_993 + z * 0.000_024_390_448_796_277_41;
        let cosine =
            ((1.0 + z * -0.499_999_997_251_031) + w * 0.041_666_623_323_739_06) + (w * z) * rest;
        #[expect(clippy::cast_possible_truncation, reason = "of single precision")]
        let [sine, cosine] = [sine, cosine].map(|it| f64::from(it as f32));
        // The last bits of a number that large are those of a whole one.
        let turned = shifted.to_bits();
        let (one, other) = match turned & 1 {
            0 => (sine, cosine),
            _ => (cosine, sine),
        };
        sines[k] = if turned & 2 == 0 { one } else { -one };
        cosines[k] = if (turned + 1) & 2 == 0 { other } else { -other };
    }
    [sines, cosines]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_the_library_to_the_last_bit() {
        // All of both signs up to the largest, in steps that share no factor with powers of two, and one of the few for which
        // it matters how quarters are taken off.
        let steps = (0..MOST_PHASE.to_bits()).step_by(4099);
        for phase in steps.chain([0x4040_6406, 0x40e2_31d5, 0x40e2_31d6]) {
            for phase in [1.0, -1.0].map(|sign| sign * f32::from_bits(phase)) {
                let [[sine], [cosine]] = sines([phase]);
                let (one, other) = libm::sincosf(phase);
                let expected = [one, other].map(|it| f64::from(it).abs().to_bits());
                let found = [sine, cosine].map(|it| it.abs().to_bits());
                assert_eq!(found, expected, "size at {phase}");
                let is_same = |a: f64, b: f32| (a - f64::from(b)).abs() <= 0.0;
                assert!(is_same(sine, one) && is_same(cosine, other), "at {phase}");
            }
        }
    }
}
