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

mod area;
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

pub use area::Area;
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
