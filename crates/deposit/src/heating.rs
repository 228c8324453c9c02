//! What clears a pane of dew and ice: where how much heat comes to it.

use std::f64::consts::TAU;

use crate::Area;

/// From one outlet under the pane to the next, how wide each is, and how far below the pane its jet begins, mm. GUESS:
/// as in cars.
const OUTLETS_EACH_MM: f64 = 300.0;
const OUTLET_MM: f64 = 150.0;
const BELOW_MM: f64 = 60.0;

/// How much wider a jet along a wall is, to where its speed is half of the most, on each side per way \[LaunderRodi1983\].
const WIDENS: f64 = 0.26;

/// How what a jet brings to a wall falls with the way: speed falls with its root, and a turbulent layer takes up
/// u^0.8 x^−0.2 \[LaunderRodi1983\].
const FALLS: f64 = 0.6;

/// A half width over the standard deviation of a Gaussian: √(2 ln 2).
const HALF_WIDTH: f64 = 1.177_410_022_515_474_7;

/// What heats a pane that clears.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Heating {
    /// Wires or a film in it: all of it alike.
    #[default]
    Pane,
    /// Warm air from outlets along its lower edge: most right above them, least at the top.
    Vents {
        /// Where that is, mm: at the end of the area that is looked at if that is higher.
        edge_mm: f64,
    },
}

impl Heating {
    /// How it heats an area of a pane that has lost so much in the mean: what is nothing need not be found place by place.
    pub(crate) fn of_lost(self, lost: f64, area: &Area) -> Heat {
        match lost > 0.0 {
            true => self.over(area),
            false => Heat::EVEN,
        }
    }

    /// How it heats an area of a pane: in the mean over what is above the outlets, once.
    #[must_use]
    pub fn over(self, area: &Area) -> Heat {
        let Self::Vents { edge_mm } = self else {
            return Heat::EVEN;
        };
        let lower_mm = edge_mm.min(area.to_mm[1]);
        let height_mm = lower_mm - area.from_mm[1];
        if height_mm <= 0.0 {
            return Heat::EVEN;
        }
        // The mean of (h + h₀)^−a over the height is 1.
        let rest = 1.0 - FALLS;
        let whole = libm::pow(height_mm + BELOW_MM, rest) - libm::pow(BELOW_MM, rest);
        Heat {
            lower_mm,
            scale: rest * height_mm / whole,
        }
    }
}

/// Heat over an area of a pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    lower_mm: f64,
    /// Of the law of jets; 0 where all of the pane is heated alike.
    scale: f64,
}

impl Heat {
    const EVEN: Self = Self {
        lower_mm: 0.0,
        scale: 0.0,
    };

    /// How many times the mean heat comes to a place, mm.
    #[must_use]
    pub fn times(&self, [x_mm, y_mm]: [f64; 2]) -> f64 {
        if self.scale <= 0.0 {
            return 1.0;
        }
        let height_mm = (self.lower_mm - y_mm).max(0.0) + BELOW_MM;
        let sigma_mm = (0.5 * OUTLET_MM + WIDENS * height_mm) / HALF_WIDTH;
        // Gaussians around all outlets, over their mean: by Poisson's sum a row of cosines, of which one is enough.
        let waves = TAU / OUTLETS_EACH_MM;
        let falls = libm::exp(-0.5 * (sigma_mm * waves) * (sigma_mm * waves));
        let beside = 1.0 + 2.0 * falls * libm::cos(waves * x_mm);
        self.scale * libm::pow(height_mm, -FALLS) * beside.max(0.0)
    }
}
