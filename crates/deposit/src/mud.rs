//! Mud: splats of wet earth that have dried.

mod run;

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{Seed, Stream, normal, uniform};

use self::run::Run;
use crate::raster::Raster;
use crate::{Area, Coating, Field, Passage, vectorized};

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
    /// Median thickness of a splat where it is thickest, as it hits the glass, mm. What is thicker than 0.25 mm runs down.
    pub thickness_mm: f64,
    /// What it absorbs of red, green and blue, K, mm⁻¹.
    pub absorbs_per_mm: [f64; 3],
    /// What it scatters, S, mm⁻¹.
    pub scatters_per_mm: f64,
}

/// Standard deviation of the logarithm of the size of splats. FIT.
const SIZES: f64 = 0.9;

/// Farthest that a splat's outline is from its middle, in radii.
const MOST_OUTLINE: f64 = 2.0;

/// Nearest that it is.
const LEAST_OUTLINE: f64 = 0.4;

/// Cells that are worked out side by side.
const TOGETHER: usize = 8;

/// How large places are, mm, that are thicker and thinner, and by how much. FIT.
const GRAIN: (f64, f64) = (2.2, 0.45);

/// Largest radius of a splat, median diameters. FIT.
const LARGEST: f64 = 3.0;

/// Standard deviation of the logarithm of the thickness of splats. FIT.
const THICKNESSES: f64 = 0.6;

/// Most drops of spray of a splat, their least radius over its own, and how far they fly from the way that it came, rad. FIT.
const MOST_SPRAY: f64 = 40.0;
const SPRAY_OF_SPLAT: f64 = 0.035;
const SPRAYS_RAD: f64 = 1.0;

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
        let wanted = (self.coverage.clamp(0.0, 0.95) * thickness.values.len() as f64) as usize;
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
            let splat = Splat::new(middle_mm, radius_mm, (&waves, &mut rng));
            let thickness_mm = self.thickness_mm * libm::exp(THICKNESSES * normal(&mut rng));
            covered += splat.add(&mut thickness, thickness_mm);
            // Spray, most of it beyond, as it was thrown: many small drops, few larger ones.
            let many = uniform(&mut rng);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some drops"
            )]
            let n_spray = (MOST_SPRAY * many * many) as u32;
            for _ in 0..n_spray {
                let (sin, cos) = libm::sincos(-0.25 * TAU + SPRAYS_RAD * normal(&mut rng));
                let away = radius_mm * (1.1 - 1.2 * libm::log(1.0 - 0.95 * uniform(&mut rng)));
                let at = [middle_mm[0] + away * cos, middle_mm[1] + away * sin];
                let radius = SPRAY_OF_SPLAT * radius_mm / (0.03 + 0.97 * uniform(&mut rng)).sqrt();
                let drop = Splat::new(at, radius, (&waves, &mut rng));
                covered += drop.add(&mut thickness, 0.4 * thickness_mm);
            }
            for run in Run::of_splat((middle_mm, radius_mm), thickness_mm, &mut rng) {
                covered += run.add(&mut thickness);
            }
        }
        MuddyPane {
            mud: *self,
            thickness,
            grain: Field::over(area, GRAIN, (Stream::Mud, seed)),
        }
    }
}

/// Waves around the outline of a splat.
const N_LOBES: usize = 14;

/// Standard deviations of the shares of these waves: 0.2/k^1.1 of that of k times around, from k = 2 on. FIT.
fn wave_sizes() -> [f64; N_LOBES] {
    let mut sizes = [0.0; N_LOBES];
    for (order, size) in (2_u32..).zip(&mut sizes) {
        *size = 0.2 / libm::pow(f64::from(order), 1.1);
    }
    sizes
}

/// Directions in which splats are longer: upwards, as wheels throw them, with a standard deviation, rad. FIT.
const LEANS_RAD: f64 = 0.5;

/// One splat: a disc with a ragged outline, longer than wide.
struct Splat {
    middle_mm: [f64; 2],
    radius_mm: f64,
    /// Direction in which it is longer, and by how much.
    along: [f64; 2],
    longer: f64,
    /// Shares of the cosine and the sine of each wave, from that of twice around on.
    lobes: [[f64; 2]; N_LOBES],
}

impl Splat {
    fn new(
        middle_mm: [f64; 2],
        radius_mm: f64,
        (waves, rng): (&[f64; N_LOBES], &mut ChaCha8Rng),
    ) -> Self {
        let (sin, cos) = libm::sincos(0.25 * TAU + LEANS_RAD * normal(rng));
        let longer = 1.0 + 0.7 * uniform(rng) * uniform(rng);
        let mut lobes = [[0.0; 2]; N_LOBES];
        for (wave, lobe) in waves.iter().zip(&mut lobes) {
            let size = wave * normal(rng);
            let (sin, cos) = libm::sincos(TAU * uniform(rng));
            *lobe = [size * cos, -size * sin];
        }
        Self {
            middle_mm,
            radius_mm,
            along: [cos, sin],
            longer,
            lobes,
        }
    }

    /// Farthest that its outline is from its middle, in radii of the disc that it was: no more than all waves together.
    fn farthest(&self) -> f64 {
        let most = self.lobes.iter().map(|[c, s]| (c * c + s * s).sqrt()).sum();
        libm::exp(most).min(MOST_OUTLINE)
    }

    /// Of some places from the middle, mm, the squares of their distances from it in radii, and by how many powers of e the
    /// outline is farther than a radius in their directions. None where all are farther than it is anywhere.
    #[inline(always)]
    fn outlines(
        &self,
        from_middle_mm: [[f64; TOGETHER]; 2],
        farthest: f64,
    ) -> Option<[[f64; TOGETHER]; 2]> {
        let [along, across] = self.along;
        let [[mut cos, mut sin], [mut away_square, mut outline]] = [[[0.0; TOGETHER]; 2]; 2];
        for k in 0..TOGETHER {
            let [x, y] = from_middle_mm.map(|it| it[k]);
            let (x, y) = (
                (x * along + y * across) / self.longer,
                (y * along - x * across) * self.longer,
            );
            let length_square = x * x + y * y;
            away_square[k] = length_square / (self.radius_mm * self.radius_mm);
            let length = length_square.sqrt().max(1e-12);
            (cos[k], sin[k]) = (x / length, y / length);
        }
        if away_square.iter().all(|it| *it >= farthest * farthest) {
            return None;
        }
        // Cosines and sines of multiples of the angle, each from the one before.
        let (mut c, mut s) = (cos, sin);
        for [of_cos, of_sin] in &self.lobes {
            for k in 0..TOGETHER {
                (c[k], s[k]) = (c[k] * cos[k] - s[k] * sin[k], s[k] * cos[k] + c[k] * sin[k]);
                outline[k] += of_cos * c[k] + of_sin * s[k];
            }
        }
        Some([away_square, outline])
    }

    /// Adds its thickness, of what runs down no more than stays; returns how many cells it covers that were clean. Where it
    /// lies over others the thinner of both adds 0.3 of its thickness (FIT).
    fn add(&self, thickness: &mut Raster, most_mm: f64) -> usize {
        vectorized(
            #[inline(always)]
            || self.add_rows(thickness, most_mm),
        )
    }

    #[inline(always)]
    fn add_rows(&self, thickness: &mut Raster, most_mm: f64) -> usize {
        let farthest = self.farthest();
        let stays_mm = Run::stays_mm(self.radius_mm);
        let reach_mm = farthest * self.longer * self.radius_mm;
        let [columns, rows] = thickness.around(self.middle_mm, reach_mm);
        let mut n_new = 0;
        for y in rows {
            for left in columns.clone().step_by(TOGETHER) {
                let places = std::array::from_fn(|k| thickness.middle_mm(left + k, y));
                let from_middle_mm =
                    [0, 1].map(|axis| places.map(|at: [f64; 2]| at[axis] - self.middle_mm[axis]));
                let Some([away_square, outline]) = self.outlines(from_middle_mm, farthest) else {
                    continue;
                };
                let right = (left + TOGETHER).min(columns.end);
                let cells = &mut thickness.values[y * thickness.size[0]..][left..right];
                for ((cell, away_square), outline) in cells.iter_mut().zip(away_square).zip(outline)
                {
                    if away_square >= farthest * farthest || is_beyond(away_square, outline) {
                        continue;
                    }
                    let outline = libm::exp(outline).clamp(LEAST_OUTLINE, MOST_OUTLINE);
                    let part_square = away_square / (outline * outline);
                    if part_square >= 1.0 {
                        continue;
                    }
                    n_new += usize::from(*cell <= 0.0);
                    #[expect(clippy::cast_possible_truncation, reason = "a length")]
                    let more = (most_mm * dried(part_square)).min(stays_mm) as f32;
                    *cell = cell.max(more) + 0.3 * cell.min(more);
                }
            }
        }
        n_new
    }
}

/// How thick mud has dried over where it is thickest, by the square of the distance from its middle over that of its
/// edge: a little thicker all around than in the middle, for water leaves at the edge and takes earth there with it
/// \[Deegan1997\], and steep at its end. FIT.
#[inline(always)]
fn dried(part_square: f64) -> f64 {
    let sixth = part_square * part_square * part_square;
    (1.0 - sixth * sixth).max(0.0).sqrt() * (0.827 + 0.327 * part_square)
}

/// Whether a place is surely beyond an outline of so many powers of e, without taking them: e^x ≤ (1 − x/64)⁻⁶⁴ for x below 64.
#[inline(always)]
fn is_beyond(away_square: f64, outline: f64) -> bool {
    let mut less = 1.0 - outline / 64.0;
    for _ in 0..7 {
        less *= less;
    }
    let least_square = LEAST_OUTLINE * LEAST_OUTLINE;
    outline < 64.0 && away_square * less.min(1.0 / least_square) > 1.0 + 1e-9
}

/// Mud on one pane.
pub(crate) struct MuddyPane {
    mud: Mud,
    thickness: Raster,
    grain: Field,
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
            ..self.mud.layer(thickness_mm * self.grain.at(at_mm))
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
    fn what_is_beyond_an_outline_is_no_nearer_than_it() {
        for k in -2000..=2000 {
            let outline = f64::from(k) * 1e-3;
            let radius = libm::exp(outline).max(LEAST_OUTLINE);
            assert!(!is_beyond(radius * radius, outline), "on it at {outline}");
            assert!(!is_beyond(0.99 * radius * radius, outline), "within it");
            assert!(is_beyond(1.2 * radius * radius, outline), "far from it");
        }
    }
}
