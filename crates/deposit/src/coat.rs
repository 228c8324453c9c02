//! Coats of all kinds, as a pane has them.

use starbreak_seed::Seed;

use crate::{Area, Coating, Dust, Film, Fog, Frost, Heating, Mud, Scratches};

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
            Self::Scratches(it) => Box::new(it.on_pane()),
            Self::Fog(it) => Box::new(it.on_pane(area, seed)),
        }
    }

    /// The same so many seconds later: dew and frost grow, by steps in which nothing visible changes, and clear.
    #[must_use]
    pub fn later(mut self, by_s: f64) -> Self {
        match &mut self {
            Self::Frost(it) => it.age_s = it.later_s(by_s),
            Self::Fog(Fog { mean, .. }) => mean.age_s = mean.later_s(by_s),
            Self::Mud(_) | Self::Dust(_) | Self::Film(_) | Self::Scratches(_) => {}
        }
        self
    }

    /// The same where the optical axis meets the pane at a place, mm, and the pane ends so far down it, mm.
    #[must_use]
    pub fn seen_from(mut self, axis_mm: [f64; 2], end_mm: f64) -> Self {
        match &mut self {
            Self::Scratches(it) => {
                it.pivot_mm = [0, 1].map(|k| it.pivot_mm[k] + axis_mm[k]);
            }
            Self::Frost(Frost { heated_by, .. }) | Self::Fog(Fog { heated_by, .. }) => {
                if let Heating::Vents { edge_mm } = heated_by {
                    *edge_mm = end_mm;
                }
            }
            Self::Mud(_) | Self::Dust(_) | Self::Film(_) => {}
        }
        self
    }

    /// Whether it changes as time goes.
    #[must_use]
    pub fn grows(&self) -> bool {
        matches!(self, Self::Frost(_) | Self::Fog(_))
    }
}
