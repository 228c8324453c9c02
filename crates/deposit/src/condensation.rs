//! Dew: drops of water vapor, too small to be seen one by one.

use std::f64::consts::PI;

use starbreak_seed::{Seed, Stream};

use crate::cap::volume_per_cubed_radius;
use crate::{Area, Coating, Field, Passage};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Wavelength of green light, m.
const WAVELENGTH_M: f64 = 0.55e-6;

/// Share of the glass that drops cover once they merge: then they grow with what they cover unchanged \[Fritter1991\].
const MOST_COVERED: f64 = 0.55;

/// Water vapor that has condensed on a face of the glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condensation {
    /// How fast water arrives, m/s: the film that it would be.
    pub growth_m_s: f64,
    /// How long it has, s.
    pub age_s: f64,
    /// Places at which drops begin, m⁻².
    pub nuclei_per_m2: f64,
    /// Contact angle of water on the glass, rad.
    pub contact_rad: f64,
}

/// Drops of dew at one place of the glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dew {
    /// Share of the glass that they cover.
    pub covered: f64,
    /// Their radius, m.
    pub radius_m: f64,
}

impl Condensation {
    /// The drops where so many times the mean water has arrived.
    ///
    /// Each nucleus takes the same share, so that r ∝ t^⅓ and c = nπr². When c comes to 0.55 drops merge as fast as they
    /// grow: c stays, and r = hπ/(c k) ∝ t, with h the film and k r³ the volume of a drop.
    #[must_use]
    pub fn drops(&self, times: f64) -> Dew {
        self.drops_of(volume_per_cubed_radius(self.contact_rad), times)
    }

    /// The same where a drop of radius 1 has a volume.
    fn drops_of(&self, volume: f64, times: f64) -> Dew {
        let film_m = (self.growth_m_s * self.age_s * times).max(0.0);
        let alone_m = libm::cbrt(film_m / (self.nuclei_per_m2 * volume));
        let covered = self.nuclei_per_m2 * PI * alone_m * alone_m;
        if covered <= MOST_COVERED {
            Dew {
                covered,
                radius_m: alone_m,
            }
        } else {
            Dew {
                covered: MOST_COVERED,
                radius_m: film_m * PI / (MOST_COVERED * volume),
            }
        }
    }

    /// Standard deviation of the angle by which drops turn light, per axis, rad: (n − 1) α on a sphere's slope α, with
    /// sin²α of ½ sin²θ in the mean over the footprint.
    #[must_use]
    pub fn refracts_by_rad(&self, refractive_index: f64) -> f64 {
        0.5 * (refractive_index - 1.0) * libm::sin(self.contact_rad)
    }
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
}

impl Fog {
    pub(crate) fn on_pane(&self, area: &Area, seed: Seed) -> FoggedPane {
        FoggedPane {
            mean: self.mean,
            volume: volume_per_cubed_radius(self.mean.contact_rad),
            times: Field::over(
                area,
                (self.scale_mm, self.unevenness),
                (Stream::Condensation, seed),
            ),
        }
    }
}

/// Dew on one pane.
pub(crate) struct FoggedPane {
    mean: Condensation,
    /// Of a drop of radius 1.
    volume: f64,
    times: Field,
}

impl Coating for FoggedPane {
    /// Of light that a share c of drops meets, drops without order leave (1 − c)² as it is; c(1 − c) is diffracted by the
    /// gaps between them, and c refracted, which come from about the place that is seen (Babinet). The sum is 1.
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let c = (self.mean.drops_of(self.volume, self.times.at(at_mm))).covered;
        Passage {
            covered: c,
            direct: [(1.0 - c) * (1.0 - c); 3],
            narrow: c * (1.0 - c),
            wide: c,
            ..Passage::CLEAN
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        // The core of a disc's diffraction as a Gaussian.
        let across_m = 2.0 * self.mean.drops(1.0).radius_m;
        [
            0.42 * WAVELENGTH_M / across_m.max(WAVELENGTH_M),
            self.mean.refracts_by_rad(WATER),
        ]
    }
}
