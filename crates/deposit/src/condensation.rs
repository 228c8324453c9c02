//! Dew: drops of water vapor, too small to be seen one by one.

use std::f64::consts::PI;

use starbreak_seed::{Seed, Stream};

use crate::cap::volume_per_cubed_radius;
use crate::{Area, Coating, Field, Heat, Heating, Passage};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Wavelength of green light, m.
const WAVELENGTH_M: f64 = 0.55e-6;

/// Share of the glass that drops cover once they merge: then they grow with what they cover unchanged \[Fritter1991\].
const MOST_COVERED: f64 = 0.55;

/// Steps by which dew becomes as old as it is when drops merge are this times 3/2, those from there on of their age: the share
/// that it covers grows by 0.0014 in each at most, and its drops by 0.4 %.
const STEPS: f64 = 256.0;

/// Contact angle of a drop whose rim draws back, over that of one that grows. GUESS.
const RECEDES: f64 = 0.5;

/// Places of a side at which the drops of an uneven pane are looked at.
const PLACES: u32 = 24;

/// Water vapor that has condensed on a face of the glass, and goes again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condensation {
    /// How fast water arrives, m/s: the film that it would be.
    pub growth_m_s: f64,
    /// How long it has been there, s.
    pub age_s: f64,
    /// Age from which no more arrives and what is there evaporates, s; infinite where it never does.
    pub clears_from_s: f64,
    /// How fast, m/s of film, in the mean over the pane.
    pub clears_m_s: f64,
    /// Places at which drops begin, m⁻².
    pub nuclei_per_m2: f64,
    /// Contact angle of water on the glass as drops grow, rad.
    pub contact_rad: f64,
}

/// Drops of dew at one place of the glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dew {
    /// Share of the glass that they cover.
    pub covered: f64,
    /// Their radius, m.
    pub radius_m: f64,
    /// Their contact angle, rad.
    pub contact_rad: f64,
}

impl Condensation {
    /// The drops where so many times the mean water has arrived, and as much evaporates as in the mean.
    ///
    /// Each nucleus takes the same share, so that r ∝ t^⅓ and c = nπr². When c comes to 0.55 drops merge as fast as they
    /// grow: c stays, and r = hπ/(c k) ∝ t, with h the film and k r³ the volume of a drop.
    ///
    /// A drop that evaporates keeps its rim while its contact angle falls to the receding one, half of what it was. Then it
    /// keeps that angle, and c ∝ r² ∝ h^⅔ \[Picknett1977\]. So dew goes last where most of it was.
    #[must_use]
    pub fn drops(&self, times: f64) -> Dew {
        self.drops_of(volume_per_cubed_radius(self.contact_rad), [times, 1.0])
    }

    /// The same where a drop of radius 1 has a volume, and so many times the mean evaporates.
    fn drops_of(&self, volume: f64, [times, heat]: [f64; 2]) -> Dew {
        let grows_s = self.age_s.min(self.clears_from_s);
        let film_m = (self.growth_m_s * grows_s * times).max(0.0);
        // r³ of drops that have not merged, and the most of r²: the root of r³, which takes long, is of these alone.
        let cubed_m3 = film_m / (self.nuclei_per_m2 * volume);
        let merged_m2 = MOST_COVERED / (self.nuclei_per_m2 * PI);
        let (covered, radius_m) = if cubed_m3 * cubed_m3 < cubed(merged_m2) {
            let alone_m = libm::cbrt(cubed_m3);
            (self.nuclei_per_m2 * PI * alone_m * alone_m, alone_m)
        } else {
            (MOST_COVERED, film_m * PI / (MOST_COVERED * volume))
        };
        let dew = Dew {
            covered,
            radius_m,
            contact_rad: self.contact_rad,
        };
        let gone_m = heat * self.gone_m();
        match gone_m > 0.0 {
            true => dew.dried((1.0 - gone_m / film_m).max(0.0), volume),
            false => dew,
        }
    }

    /// Its age so many seconds later, s: by steps in which nothing visible changes, while it grows.
    pub(crate) fn later_s(&self, by_s: f64) -> f64 {
        let later_s = self.age_s + by_s;
        let merged_m = (MOST_COVERED / (self.nuclei_per_m2 * PI)).sqrt();
        let volume = volume_per_cubed_radius(self.contact_rad);
        let merges_s = self.nuclei_per_m2 * volume * cubed(merged_m) / self.growth_m_s;
        if later_s >= self.clears_from_s || !(merges_s > 0.0 && merges_s.is_finite()) {
            return later_s;
        }
        // c ∝ t^⅔, then r ∝ t.
        let steps_of = |age_s: f64| {
            let age = (age_s / merges_s).max(0.0);
            match age < 1.0 {
                true => 1.5 * STEPS * libm::cbrt(age * age),
                false => STEPS * (1.5 + libm::log(age)),
            }
        };
        let age_of = |steps: f64| {
            let part = steps / (1.5 * STEPS);
            merges_s
                * match part < 1.0 {
                    true => cubed(part.sqrt()),
                    false => libm::exp(steps / STEPS - 1.5),
                }
        };
        let begins = steps_of(self.age_s);
        match (steps_of(later_s) - begins).floor() {
            n if n >= 1.0 => age_of(begins + n).min(later_s),
            _ => self.age_s,
        }
    }

    /// What has evaporated in the mean, m of film, where there was as much.
    fn gone_m(&self) -> f64 {
        self.clears_m_s * (self.age_s - self.clears_from_s).max(0.0)
    }
}

impl Dew {
    /// What evaporation has left a part of, 0 to 1, of drops that had a volume at radius 1.
    fn dried(self, part: f64, volume: f64) -> Self {
        let receding_rad = RECEDES * self.contact_rad;
        let pinned = volume_per_cubed_radius(receding_rad) / volume;
        if part >= pinned {
            return Self {
                contact_rad: contact_of(part * volume),
                ..self
            };
        }
        let shrinks = libm::cbrt(part / pinned);
        Self {
            covered: self.covered * shrinks * shrinks,
            radius_m: self.radius_m * shrinks,
            contact_rad: receding_rad,
        }
    }

    /// Standard deviation of the angle by which drops turn light, per axis, rad: (n − 1) α on a sphere's slope α, with
    /// sin²α of ½ sin²θ in the mean over the footprint.
    #[must_use]
    pub fn refracts_by_rad(&self, refractive_index: f64) -> f64 {
        0.5 * (refractive_index - 1.0) * libm::sin(self.contact_rad)
    }
}

fn cubed(x: f64) -> f64 {
    x * x * x
}

/// The contact angle at which a cap has a volume over the cube of its radius: with u = tan(θ/2) that is π u (3 + u²)/6.
fn contact_of(volume_per_cubed_radius: f64) -> f64 {
    let u = 2.0 * libm::sinh(libm::asinh(3.0 * volume_per_cubed_radius / PI) / 3.0);
    2.0 * libm::atan(u)
}

/// Dew on a pane: more in some places than in others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fog {
    /// In the mean over the pane.
    pub mean: Condensation,
    /// How much more or less there is in places, a share of the mean.
    pub unevenness: f64,
    /// How large such places are, mm.
    pub scale_mm: f64,
    /// What heats the pane when it clears.
    pub heated_by: Heating,
}

impl Fog {
    pub(crate) fn on_pane(&self, area: &Area, seed: Seed) -> FoggedPane {
        let volume = volume_per_cubed_radius(self.mean.contact_rad);
        let (scale, stream) = (
            (self.scale_mm, self.unevenness),
            (Stream::Condensation, seed),
        );
        let mut pane = FoggedPane {
            mean: self.mean,
            volume,
            scale_mm: self.scale_mm,
            times: Field::over(area, scale, stream),
            heat: self.heated_by.of_lost(self.mean.gone_m(), area),
            typical: self.mean.drops_of(volume, [1.0, 1.0]),
        };
        if self.mean.gone_m() > 0.0 {
            pane.typical = pane.mean_drops(area);
        }
        pane
    }
}

/// Dew on one pane.
pub(crate) struct FoggedPane {
    mean: Condensation,
    /// Of a drop of radius 1.
    volume: f64,
    scale_mm: f64,
    times: Field,
    heat: Heat,
    /// What drops are like where there are some.
    typical: Dew,
}

impl FoggedPane {
    /// The drops of a place, mm.
    fn drops(&self, at_mm: [f64; 2]) -> Dew {
        let heat = self.heat.times(at_mm);
        (self.mean).drops_of(self.volume, [self.times.at(at_mm), heat])
    }

    /// The mean drops of an area where some places are dry, each place by what of it is covered.
    fn mean_drops(&self, area: &Area) -> Dew {
        let [mut covered, mut radius_m, mut contact_rad] = [0.0; 3];
        let at = |k: usize, n: u32| {
            area.from_mm[k] + (f64::from(n) + 0.5) / f64::from(PLACES) * area.sides_mm()[k]
        };
        for place in (0..PLACES * PLACES).map(|n| [at(0, n % PLACES), at(1, n / PLACES)]) {
            let dew = self.drops(place);
            covered += dew.covered;
            radius_m += dew.covered * dew.radius_m;
            contact_rad += dew.covered * dew.contact_rad;
        }
        let by = f64::max(covered, f64::MIN_POSITIVE);
        Dew {
            covered: covered / f64::from(PLACES * PLACES),
            radius_m: radius_m / by,
            contact_rad: contact_rad / by,
        }
    }
}

impl Coating for FoggedPane {
    /// Of light that a share c of drops meets, drops without order leave (1 − c)² as it is; c(1 − c) is diffracted by the
    /// gaps between them, and c refracted, which come from about the place that is seen (Babinet). The sum is 1.
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let c = self.drops(at_mm).covered;
        Passage {
            covered: c,
            direct: [(1.0 - c) * (1.0 - c); 3],
            narrow: c * (1.0 - c),
            wide: c,
            ..Passage::CLEAN
        }
    }

    /// A sixteenth of the smaller of its two sizes of places.
    fn apart_mm(&self) -> f64 {
        self.scale_mm / 32.0
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        // The core of a disc's diffraction as a Gaussian.
        let across_m = 2.0 * self.typical.radius_m;
        [
            0.42 * WAVELENGTH_M / across_m.max(WAVELENGTH_M),
            self.typical.refracts_by_rad(WATER),
        ]
    }
}
