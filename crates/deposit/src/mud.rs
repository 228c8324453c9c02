//! Mud: splats of wet earth that have dried.

mod run;
mod splat;

use std::f64::consts::TAU;

use starbreak_seed::{Seed, Stream, normal, uniform};

use self::run::Run;
use self::splat::{Finger, MOST_REACH, Splat, wave_sizes};
use crate::raster::Raster;
use crate::{Area, Coating, Field, Passage};

/// Mud on a pane.
///
/// How much of each color goes through a layer of thickness t in all, and what it sends back, follows from Kubelka and Munk
/// \[KubelkaMunk1931\]: with a = 1 + K/S and b = √(a² − 1), b/(a sinh bSt + b cosh bSt) goes through and
/// sinh bSt/(a sinh bSt + b cosh bSt) comes back.
///
/// Of what goes through, e^(−(K + s) t) is as it came, s = S/(¾ (1 − g)) \[MudgettRichards1971\]: grains scatter mostly
/// forwards, so that e^(−(K + (1 − g) s) t) is turned by a small angle at most. K is that of diffuse light throughout; the half
/// of it, which straight light loses, would let more go straight on than goes through in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mud {
    /// Share of the glass that it covers, 0 to 0.8.
    pub coverage: f64,
    /// Median diameter of a splat, mm.
    pub splat_mm: f64,
    /// Thickness of a splat of that diameter where it is thickest, as it hits the glass, in the median, mm. What is thicker
    /// than 0.25 mm runs down.
    pub thickness_mm: f64,
    /// What it absorbs of red, green and blue, K, mm⁻¹.
    pub absorbs_per_mm: [f64; 3],
    /// What it scatters, S, mm⁻¹.
    pub scatters_per_mm: f64,
}

/// Standard deviation of the logarithm of the size of splats. FIT.
const SIZES: f64 = 0.9;

/// How large places are, mm, that are thicker and thinner, and by how much. FIT.
const GRAIN: (f64, f64) = (2.2, 0.45);

/// Largest radius of a splat, median diameters. FIT.
const LARGEST: f64 = 3.0;

/// To which power of their size splats are thick: a drop spreads by D^¼ \[SchellerBousfield1995\], its splat is as thick as D^½;
/// and the standard deviation of the logarithm of their thickness about that. FIT.
const THICKER: f64 = 0.4;
const THICKNESSES: f64 = 0.3;

/// Splats fly upwards, as wheels throw them, with a standard deviation, rad, and are longer that way. FIT.
const LEANS_RAD: f64 = 0.5;

/// Mean cosine g of the angle by which a grain of earth scatters. FIT, of mineral dust.
const FORWARDS: f64 = 0.75;

/// Standard deviation per axis of the angle by which it turns what goes on nearly as it came, rad. FIT, as of dust.
const TURNED_RAD: f64 = 0.35;

/// Most splats.
const MOST_SPLATS: u32 = 200_000;

impl Mud {
    /// What a layer of a thickness does to light.
    #[must_use]
    pub fn layer(&self, thickness_mm: f64) -> Passage {
        let s = self.scatters_per_mm.max(1e-6);
        let scatters = s / (0.75 * (1.0 - FORWARDS));
        let mut layer = Passage {
            covered: 1.0,
            wide: 1.0,
            ..Passage::CLEAN
        };
        for (k, absorbs) in self.absorbs_per_mm.iter().enumerate() {
            let after = |per_mm: f64| libm::exp(-(absorbs + per_mm) * thickness_mm);
            let direct = after(scatters);
            let a = 1.0 + absorbs / s;
            let b = (a * a - 1.0).max(0.0).sqrt();
            let depth = s * thickness_mm;
            let (through, back) = if b * depth < 1e-4 {
                (1.0 / (1.0 + a * depth), depth / (1.0 + a * depth))
            } else {
                // Over cosh bSt, which may be beyond all numbers.
                let tanh = libm::tanh(b * depth);
                let per = a * tanh + b;
                (b / per / libm::cosh((b * depth).min(700.0)), tanh / per)
            };
            layer.direct[k] = direct;
            layer.diffuse[k] = (through - direct).max(0.0);
            layer.back[k] = back.min(1.0 - direct);
            // As much of all colors.
            let ahead = after((1.0 - FORWARDS) * scatters) - direct;
            layer.wide = ahead.min(layer.diffuse[k]).min(layer.wide);
        }
        let wide = layer.wide;
        layer.diffuse = layer.diffuse.map(|it| it - wide);
        layer
    }

    pub(crate) fn on_pane(&self, area: &Area, finest_mm: f64, seed: Seed) -> MuddyPane {
        let mut thickness = Raster::over(area, finest_mm, 0.0);
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "cells of a pane"
        )]
        let wanted = (self.coverage.clamp(0.0, 0.95) * thickness.n_across() as f64) as usize;
        let mut covered = 0;
        let waves = wave_sizes();
        let sides = area.sides_mm();
        for k in 0..MOST_SPLATS {
            if covered >= wanted {
                break;
            }
            let mut rng = seed.stream(Stream::Mud, 16 + u64::from(k));
            let radius_mm = 0.5 * self.splat_mm * libm::exp(SIZES * normal(&mut rng));
            // Larger ones come apart as they fly.
            let radius_mm = radius_mm.min(LARGEST * self.splat_mm);
            let middle_mm = [0, 1].map(|k| {
                area.from_mm[k] + (sides[k] + 2.0 * radius_mm) * uniform(&mut rng) - radius_mm
            });
            if !area.is_near(middle_mm, MOST_REACH * radius_mm) {
                continue;
            }
            let (sin, cos) = libm::sincos(-0.25 * TAU + LEANS_RAD * normal(&mut rng));
            let fingers = Finger::of_splat(radius_mm, &mut rng);
            let size_mm = (radius_mm, thickness.cell_mm);
            let ahead = (middle_mm, [cos, sin]);
            let splat = Splat::new(ahead, size_mm, &fingers, (&waves, &mut rng));
            let thicker = libm::pow(2.0 * radius_mm / self.splat_mm, THICKER);
            let thickness_mm =
                self.thickness_mm * thicker * libm::exp(THICKNESSES * normal(&mut rng));
            covered += splat.add(&mut thickness, thickness_mm);
            for drop in splat.spray(&fingers, (area, thickness.cell_mm), (&waves, &mut rng)) {
                covered += drop.add(&mut thickness, 0.4 * thickness_mm);
            }
            for run in Run::of_splat((middle_mm, radius_mm), thickness_mm, &mut rng) {
                covered += run.add(&mut thickness);
            }
        }
        let most_mm = thickness
            .values
            .iter()
            .fold(0.0, |most: f32, it| most.max(*it));
        MuddyPane {
            layers: Layers::of(self, f64::from(most_mm) * (1.0 + GRAIN.1)),
            thickness,
            grain: Field::over(area, GRAIN, (Stream::Mud, seed)),
        }
    }
}

/// Mud on one pane.
pub(crate) struct MuddyPane {
    layers: Layers,
    thickness: Raster,
    grain: Field,
}

/// Steps of the thickness, which are smaller where it is thin: their number grows with its root.
const STEPS: u32 = 1024;

/// What layers up to the thickest of a pane do to light, on straight lines between steps: within
/// κ d/(2 e 1024²) of the law, with d the thickest and κ what straight light loses on a way of 1 mm: some 10⁻⁴.
struct Layers {
    steps: Vec<Passage>,
    steps_per_root_mm: f64,
}

impl Layers {
    fn of(mud: &Mud, most_mm: f64) -> Self {
        let part = |step: u32| f64::from(step) / f64::from(STEPS);
        Self {
            steps: (0..=STEPS)
                .map(|step| mud.layer(most_mm * part(step) * part(step)))
                .collect(),
            steps_per_root_mm: f64::from(STEPS) / most_mm.sqrt().max(f64::MIN_POSITIVE),
        }
    }

    /// What a layer does.
    fn at(&self, thickness_mm: f64) -> Passage {
        let at = (thickness_mm.sqrt() * self.steps_per_root_mm).min(f64::from(STEPS));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a step"
        )]
        let (step, part) = (at as usize, at - (at as usize) as f64);
        let [one, next] = [0, 1].map(|k| &self.steps[(step + k).min(self.steps.len() - 1)]);
        let between = |one: f64, next: f64| one + part * (next - one);
        let colors = |one: &[f64; 3], next: &[f64; 3]| [0, 1, 2].map(|k| between(one[k], next[k]));
        Passage {
            covered: one.covered,
            direct: colors(&one.direct, &next.direct),
            wide: between(one.wide, next.wide),
            diffuse: colors(&one.diffuse, &next.diffuse),
            back: colors(&one.back, &next.back),
            ..Passage::CLEAN
        }
    }
}

impl Coating for MuddyPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let thickness_mm = self.thickness.at(at_mm);
        if thickness_mm <= 0.0 {
            return Passage::CLEAN;
        }
        let is_covered = |cell: usize| self.thickness.values[cell] > 0.0;
        Passage {
            covered: f64::from(u8::from(self.thickness.cell(at_mm).is_some_and(is_covered))),
            ..self.layers.at(thickness_mm * self.grain.at(at_mm))
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, TURNED_RAD]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_between_steps_are_those_of_the_law() {
        let usual = Mud {
            coverage: 0.2,
            splat_mm: 6.0,
            thickness_mm: 0.1,
            absorbs_per_mm: [6.0, 11.0, 22.0],
            scatters_per_mm: 20.0,
        };
        let [none, much] = [0.0, 200.0].map(|absorbs| Mud {
            absorbs_per_mm: [absorbs; 3],
            ..usual
        });
        for (mud, most_mm) in [(usual, 0.4), (usual, 0.01), (none, 0.3), (much, 3.0)] {
            let layers = Layers::of(&mud, most_mm);
            let mut worst = 0.0_f64;
            for k in 0..=20_000 {
                let thickness_mm = most_mm * f64::from(k) / 20_000.0;
                let (found, law) = (layers.at(thickness_mm), mud.layer(thickness_mm));
                let shares = |it: &Passage| {
                    let colors = it.direct.into_iter().chain(it.diffuse).chain(it.back);
                    colors.chain([it.wide, it.covered]).collect::<Vec<_>>()
                };
                for (found, law) in shares(&found).into_iter().zip(shares(&law)) {
                    worst = worst.max((found - law).abs());
                }
            }
            assert!(worst < 2e-4, "{mud:?} of up to {most_mm} mm: {worst}");
        }
    }
}
