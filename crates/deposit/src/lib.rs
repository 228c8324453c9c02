//! What lies on the glass before a camera.
//!
//! [`Rain`] makes drops on the outer face of a pane: as many and as large as rain of its rate brings to a pane that
//! stands and moves as this one does, merged where they touch, run down where they are too heavy to stay.
//! What is not seen piece by piece is a [`Coat`]: [`Mud`], [`Dust`], a [`Film`], [`Frost`], [`Scratches`] and the [`Fog`] of
//! [`Condensation`]. A [`Coating`] says what becomes of light at each place of the pane, its [`Passage`].
//!
//! What it is not: it knows no camera, light or pixel. Lengths on the pane are mm, +y downhill.
//!
//! # Example
//! ```
//! use starbreak_deposit::{Area, Rain};
//! use starbreak_seed::Seed;
//!
//! let rain = Rain { rate_m_s: 7.6e-3 / 3600.0, ..Rain::default() };
//! let area = Area::rectangle([0.0, 0.0], [300.0, 200.0]);
//! let deposit = rain.on_pane(&area, Seed(7));
//! assert!(deposit.caps.len() > 100);
//! # Ok::<(), std::convert::Infallible>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cap;
mod closing;
mod coat;
mod coating;
mod condensation;
mod dust;
mod field;
mod film;
mod frost;
mod grid;
mod heating;
mod mud;
mod outline;
mod rain;
mod raster;
mod scratches;
mod wiper;

pub use cap::Cap;
pub use coat::Coat;
pub use coating::{Coating, Passage};
pub use condensation::{Condensation, Dew, Fog};
pub use dust::Dust;
pub use field::Field;
pub use film::Film;
pub use frost::Frost;
pub use heating::{Heat, Heating};
pub use mud::Mud;
pub use outline::{Outline, RoundPlace};
pub use rain::{Rain, Shower, Wiped};
pub use scratches::Scratches;
pub use wiper::Wiper;

/// A part of a pane: a rectangle, of which the upper corners may be cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Upper left corner of the rectangle, mm.
    pub from_mm: [f64; 2],
    /// Its lower right corner, mm.
    pub to_mm: [f64; 2],
    /// How far its upper edge is cut from the left and from the right, mm, and by how much less an edge below it, mm per mm.
    cut_mm: [f64; 2],
    widens: [f64; 2],
}

impl Area {
    /// A rectangle between corners, mm.
    #[must_use]
    pub const fn rectangle(from_mm: [f64; 2], to_mm: [f64; 2]) -> Self {
        Self {
            from_mm,
            to_mm,
            cut_mm: [0.0; 2],
            widens: [0.0; 2],
        }
    }

    /// Without what is left of a straight line, or right of another: each by the place to the right, mm, where it meets the
    /// upper edge, and how far that moves with each mm down. A line that leaves more of the upper edge than of others cuts
    /// nothing off: what slides down the pane would come from there.
    #[must_use]
    pub fn between(self, lines: [(f64, f64); 2]) -> Self {
        let cut = |k: usize| {
            let (at_mm, moves) = lines[k];
            let (cut_mm, widens) = match k {
                0 => (at_mm - self.from_mm[0], -moves),
                _ => (self.to_mm[0] - at_mm, moves),
            };
            let does_cut = cut_mm > 0.0 && widens > 0.0 && (cut_mm + widens).is_finite();
            if does_cut {
                (cut_mm, widens)
            } else {
                (0.0, 0.0)
            }
        };
        let [left, right] = [0, 1].map(cut);
        Self {
            cut_mm: [left.0, right.0],
            widens: [left.1, right.1],
            ..self
        }
    }

    /// From where to where it reaches at a height, mm.
    #[must_use]
    pub fn across_mm(&self, down_mm: f64) -> [f64; 2] {
        let below_mm = down_mm - self.from_mm[1];
        let [left, right] = [0, 1].map(|k| (self.cut_mm[k] - self.widens[k] * below_mm).max(0.0));
        [self.from_mm[0] + left, self.to_mm[0] - right]
    }

    /// Whether a place, mm, is in it.
    #[must_use]
    pub fn holds(&self, at_mm: [f64; 2]) -> bool {
        let [left, right] = self.across_mm(at_mm[1]);
        (left..right).contains(&at_mm[0]) && (self.from_mm[1]..self.to_mm[1]).contains(&at_mm[1])
    }

    /// Whether a place is in it, or may be so near, mm.
    pub(crate) fn is_near(&self, at_mm: [f64; 2], within_mm: f64) -> bool {
        // No row that near is wider than the lowest.
        let [left, right] = self.across_mm(at_mm[1] + within_mm);
        let is_beside =
            |mm: f64, [from, to]: [f64; 2]| mm >= from - within_mm && mm <= to + within_mm;
        is_beside(at_mm[0], [left, right]) && is_beside(at_mm[1], [self.from_mm[1], self.to_mm[1]])
    }

    /// Sides of the rectangle, mm.
    #[must_use]
    pub fn sides_mm(&self) -> [f64; 2] {
        [0, 1].map(|k| (self.to_mm[k] - self.from_mm[k]).max(0.0))
    }

    /// Cells of a width, mm, along each side of the rectangle: one at least.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a pane"
    )]
    pub(crate) fn cells(&self, cell_mm: f64) -> [usize; 2] {
        self.sides_mm()
            .map(|side| ((side / cell_mm).ceil() as usize).max(1))
    }

    /// Its area, m²: without the corners that are cut off.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let [_, height_mm] = self.sides_mm();
        let corner_mm2 = |k: usize| {
            let (cut_mm, widens) = (self.cut_mm[k], self.widens[k]);
            let high_mm = if widens > 0.0 {
                (cut_mm / widens).min(height_mm)
            } else {
                0.0
            };
            high_mm * (cut_mm - 0.5 * widens * high_mm)
        };
        self.rectangle_m2() - 1e-6 * (corner_mm2(0) + corner_mm2(1))
    }

    /// The area of the rectangle, m².
    pub(crate) fn rectangle_m2(&self) -> f64 {
        let [width, height] = self.sides_mm();
        width * height * 1e-6
    }
}

/// What lies on the outer face of a pane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deposit {
    /// Drops of water.
    pub caps: Vec<Cap>,
}

impl Deposit {
    /// Whether there is nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.caps.is_empty()
    }

    /// Share of an area that it covers, where nothing overlaps.
    #[must_use]
    pub fn coverage(&self, area: &Area) -> f64 {
        let is_inside = |cap: &&Cap| area.holds(cap.at_mm);
        let covered = self.caps.iter().filter(is_inside).map(Cap::footprint_mm2);
        // The sum of nothing is −0.
        (covered.sum::<f64>() + 0.0) * 1e-6 / area.area_m2().max(f64::MIN_POSITIVE)
    }

    /// Volume of its water over an area, m³/m²: the depth of the film that it would be.
    #[must_use]
    pub fn water_m(&self, area: &Area) -> f64 {
        let volume: f64 = self.caps.iter().map(Cap::volume_mm3).sum();
        (volume + 0.0) * 1e-9 / area.area_m2().max(f64::MIN_POSITIVE)
    }
}

/// Runs what is inlined in it compiled for the processor that there is. No result depends on it: nothing is fused.
#[inline(always)]
fn vectorized<R>(run: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(run)
}
