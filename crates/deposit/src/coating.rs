//! What lies on a pane without being seen piece by piece: what it does to light, from place to place.

use starbreak_seed::Seed;

use crate::{Area, Dust, Film, Fog, Frost, Mud, Scratches};

/// What becomes of light of red, green and blue that meets a pane at one place, in shares of it. What is missing to 1 is
/// absorbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Share of the glass that is covered there.
    pub covered: f64,
    /// Goes straight on.
    pub direct: [f64; 3],
    /// Is turned by the coating's smaller angle: diffraction by grains and drops.
    pub narrow: f64,
    /// Is turned by its larger angle: refraction by drops, grains and ice.
    pub wide: f64,
    /// Is turned across a direction of the pane: by grooves along it.
    pub streak: f64,
    /// The direction across those grooves, a unit vector.
    pub across: [f64; 2],
    /// Goes on in any direction.
    pub diffuse: [f64; 3],
    /// Is sent back.
    pub back: [f64; 3],
    /// Angles by which what goes straight on is turned as a whole, right and down, rad.
    pub turned_rad: [f64; 2],
}

impl Passage {
    /// Clean glass.
    pub const CLEAN: Self = Self {
        covered: 0.0,
        direct: [1.0; 3],
        narrow: 0.0,
        wide: 0.0,
        streak: 0.0,
        across: [1.0, 0.0],
        diffuse: [0.0; 3],
        back: [0.0; 3],
        turned_rad: [0.0; 2],
    };
}

/// A coat on one pane.
pub trait Coating {
    /// What it does to light at a place, mm.
    fn passage(&self, at_mm: [f64; 2]) -> Passage;

    /// Standard deviations per axis of its smaller and its larger angle, rad.
    fn turns_by_rad(&self) -> [f64; 2];
}

/// What lies on a pane as a coat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coat {
    /// Splats of mud.
    Mud(Mud),
    /// Grains of dust.
    Dust(Dust),
    /// A film of grease.
    Film(Film),
    /// Ice.
    Frost(Frost),
    /// Grooves in the glass.
    Scratches(Scratches),
    /// Dew.
    Fog(Fog),
}

impl Coat {
    /// How it lies on an area of a pane, in details down to a length, mm; the seed places it.
    #[must_use]
    pub fn on_pane(&self, area: &Area, finest_mm: f64, seed: Seed) -> Box<dyn Coating> {
        match self {
            Self::Mud(it) => Box::new(it.on_pane(area, finest_mm, seed)),
            Self::Dust(it) => Box::new(it.on_pane(area, finest_mm, seed)),
            Self::Film(it) => Box::new(it.on_pane(area, seed)),
            Self::Frost(it) => Box::new(it.on_pane(area, finest_mm, seed)),
            Self::Scratches(it) => Box::new(*it),
            Self::Fog(it) => Box::new(it.on_pane(area, seed)),
        }
    }

    /// The same so many seconds later: dew and frost grow.
    #[must_use]
    pub fn later(mut self, by_s: f64) -> Self {
        match &mut self {
            Self::Frost(it) => it.age_s += by_s,
            Self::Fog(it) => it.mean.age_s += by_s,
            Self::Mud(_) | Self::Dust(_) | Self::Film(_) | Self::Scratches(_) => {}
        }
        self
    }

    /// The same where the optical axis meets the pane at a place, mm.
    #[must_use]
    pub fn seen_from(mut self, axis_mm: [f64; 2]) -> Self {
        if let Self::Scratches(it) = &mut self {
            it.pivot_mm = [0, 1].map(|k| it.pivot_mm[k] + axis_mm[k]);
        }
        self
    }

    /// Whether it changes as time goes.
    #[must_use]
    pub fn grows(&self) -> bool {
        matches!(self, Self::Frost(_) | Self::Fog(_))
    }
}
