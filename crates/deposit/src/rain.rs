//! Rain on a pane: from its rate to the drops that lie there.

mod pane;
mod shower;

use std::f64::consts::PI;

use starbreak_seed::Seed;

use crate::cap::volume_per_cubed_radius;
use crate::wiper::Pass;
use crate::{Area, Deposit, Wiper};

use shower::Falls;
pub use shower::Shower;

/// Surface tension of water at 20 °C, N/m.
const TENSION_N_M: f64 = 0.0728;
/// Density of water, kg/m³.
const WATER_KG_M3: f64 = 998.0;
/// Density of air, kg/m³.
const AIR_KG_M3: f64 = 1.2;
/// Acceleration of gravity, m/s².
const GRAVITY_M_S2: f64 = 9.81;

/// Drops of Marshall and Palmer's law, m⁻³ mm⁻¹.
const N0: f64 = 8000.0;

/// The largest drops that fall, mm: others break.
const LARGEST_MM: f64 = 6.0;

/// ρ U² h/γ from which air drives a drop along \[White2020\].
const SHEAR_LIMIT: f64 = 7.9;

/// Rain that falls on a pane, which is wiped dry at first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rain {
    /// Rate of the rain on level ground, m/s: 1 mm/h is 2.8·10⁻⁷.
    pub rate_m_s: f64,
    /// Speed of the camera, m/s.
    pub speed_m_s: f64,
    /// How long it has rained since the pane was wiped, s.
    pub age_s: f64,
    /// From one wipe to the next, s; 0 where nothing wipes.
    pub wiper_period_s: f64,
    /// Contact angle of water on the glass, rad.
    pub contact_rad: f64,
    /// Angle at the front of a drop that is about to move less that at its back, rad.
    pub hysteresis_rad: f64,
    /// Angle of the pane to the ground, rad: a quarter of a turn where it stands upright, less where its upper edge
    /// leans towards the camera.
    pub slope_rad: f64,
}

/// Rain on a pane that is wiped now and then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wiped {
    /// What has fallen since the wiper passed last, or is to pass: nothing if it has not come half of its way.
    pub rain: Rain,
    /// How often it passed, or began to.
    pub n_passes: u64,
    /// The wiper, while it or the film that it leaves is seen.
    pub wiper: Option<Wiper>,
    /// While it is on its way, what had fallen before: that still lies where the wiper has not come by.
    pub before: Option<Rain>,
}

impl Default for Rain {
    /// Moderate rain, 4 s after the wiper, on a windscreen of 30° to the ground at 50 km/h.
    fn default() -> Self {
        Self {
            rate_m_s: 7.6e-3 / 3600.0,
            speed_m_s: 14.0,
            age_s: 4.0,
            wiper_period_s: 0.0,
            contact_rad: 50.0_f64.to_radians(),
            hysteresis_rad: 30.0_f64.to_radians(),
            slope_rad: 30.0_f64.to_radians(),
        }
    }
}

/// Drops of rain by their diameter: how many hit a pane, and how large they are.
#[derive(Debug, Clone)]
struct Impacts {
    /// m⁻² s⁻¹.
    all: f64,
    /// Share of impacts of drops smaller than each diameter of [`diameter_mm`].
    up_to: Vec<f64>,
}

/// Steps of the diameters.
const N_DIAMETERS: u32 = 600;

fn diameter_mm(step: f64) -> f64 {
    LARGEST_MM * step / f64::from(N_DIAMETERS)
}

fn cubed(x: f64) -> f64 {
    x * x * x
}

/// Speed at which a drop falls, m/s: 9.65 − 10.3 e^(−0.6 D) \[Atlas1973\], and not upwards.
fn fall_m_s(diameter_mm: f64) -> f64 {
    (9.65 - 10.3 * libm::exp(-0.6 * diameter_mm)).max(0.0)
}

impl Rain {
    /// N(D) = 8000 e^(−ΛD), m⁻³ mm⁻¹, with Λ = 4.1 R^(−0.21) mm⁻¹ of R in mm/h \[MarshallPalmer1948\].
    fn density(&self, diameter_mm: f64) -> f64 {
        let rate_mm_h = self.rate_m_s * 3.6e6;
        let slope = 4.1 * libm::pow(rate_mm_h, -0.21);
        N0 * libm::exp(-slope * diameter_mm)
    }

    /// Speed of a falling drop towards the pane, m/s: v cos α + V sin α.
    fn towards_pane_m_s(&self, diameter_mm: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.slope_rad);
        (fall_m_s(diameter_mm) * cos + self.speed_m_s * sin).max(0.0)
    }

    fn impacts(&self) -> Impacts {
        let mut up_to = vec![0.0];
        let mut all = 0.0;
        for step in 0..N_DIAMETERS {
            let middle = diameter_mm(f64::from(step) + 0.5);
            all += self.density(middle) * self.towards_pane_m_s(middle) * diameter_mm(1.0);
            up_to.push(all);
        }
        if all > 0.0 {
            up_to.iter_mut().for_each(|part| *part /= all);
        }
        Impacts { all, up_to }
    }

    /// Drops that hit a square meter of the pane in a second.
    #[must_use]
    pub fn impacts_per_m2_s(&self) -> f64 {
        if self.rate_m_s > 0.0 {
            self.impacts().all
        } else {
            0.0
        }
    }

    /// Water that hits the pane, m³/(m² s): on level glass at rest the rate of the rain, as well as the law of its drops
    /// holds that.
    #[must_use]
    pub fn water_m_s(&self) -> f64 {
        if self.rate_m_s <= 0.0 {
            return 0.0;
        }
        (0..N_DIAMETERS).map(|step| self.brings_m_s(step)).sum()
    }

    /// The water of drops of one step of the diameters.
    fn brings_m_s(&self, step: u32) -> f64 {
        let middle = diameter_mm(f64::from(step) + 0.5);
        let volume_m3 = PI / 6.0 * cubed(middle * 1e-3);
        volume_m3 * self.density(middle) * self.towards_pane_m_s(middle) * diameter_mm(1.0)
    }

    /// The diameter up to which drops bring no more than a share of the water, mm.
    fn brings_mm(&self, share: f64) -> f64 {
        let mut left = share * self.water_m_s();
        for step in 0..N_DIAMETERS {
            left -= self.brings_m_s(step);
            if left <= 0.0 {
                return diameter_mm(f64::from(step));
            }
        }
        LARGEST_MM
    }

    /// Contact angles at which water draws back from glass and goes over it, rad.
    fn holds_rad(&self) -> [f64; 2] {
        [-0.5, 0.5].map(|side| (self.contact_rad + side * self.hysteresis_rad).clamp(0.0, PI))
    }

    /// Radius of the least drop that runs down the pane, mm: m g sin α = 2 r γ (cos θ_r − cos θ_a) \[Furmidge1962\], with
    /// half of the hysteresis to either side of the contact angle. Infinity on level glass.
    #[must_use]
    pub fn runs_from_mm(&self) -> f64 {
        let [receding, advancing] = self.holds_rad();
        let holds = 2.0 * TENSION_N_M * (libm::cos(receding) - libm::cos(advancing));
        let pulls = WATER_KG_M3
            * GRAVITY_M_S2
            * volume_per_cubed_radius(self.contact_rad)
            * libm::sin(self.slope_rad);
        if pulls > 0.0 {
            (holds / pulls).sqrt() * 1e3
        } else {
            f64::INFINITY
        }
    }

    /// Radius of the least drop that the wind drives up the pane, mm: ρ U² h/γ = 7.9 of its height h \[White2020\], which
    /// was measured on aluminum. Infinity at rest.
    #[must_use]
    pub fn driven_from_mm(&self) -> f64 {
        let pressure = AIR_KG_M3 * self.speed_m_s * self.speed_m_s;
        let height_m = SHEAR_LIMIT * TENSION_N_M / pressure;
        height_m / libm::tan(0.5 * self.contact_rad) * 1e3
    }

    /// The rain so many seconds later: since a wiper passed, and before it where it is at it. It goes there and back each
    /// time it has rained for a period, or a whole number of them, and leaves a pane without drops behind it.
    #[must_use]
    pub fn later(&self, by_s: f64) -> Wiped {
        let age_s = self.age_s + by_s;
        let since = |began_s: Option<f64>| Self {
            age_s: began_s.map_or(age_s, |began_s| age_s - began_s),
            ..*self
        };
        match Pass::at(age_s, self.age_s, self.wiper_period_s) {
            Some(pass) => Wiped {
                rain: since(Some(pass.began_s)),
                n_passes: pass.number,
                wiper: pass.wiper,
                before: (pass.wiper)
                    .filter(Wiper::is_on_its_way)
                    .map(|_| since(pass.before_s)),
            },
            None => Wiped {
                rain: since(None),
                n_passes: 0,
                wiper: None,
                before: None,
            },
        }
    }

    /// How many drops land on an area of the pane in the mean, with those that are too small to be seen there. What becomes of
    /// each takes time, a second for some hundred thousand.
    #[must_use]
    pub fn n_landing(&self, area: &Area) -> f64 {
        self.impacts_per_m2_s() * area.area_m2() * self.age_s
    }

    /// The drops on an area of the pane. The same seed gives the same drops at the same places at any age, so that a
    /// later age goes on from what was there. Drops that land where they are too small to be seen are left out
    /// ([`Area::without_smaller`]), as far as they bring a hundredth of the water. Of an area of which frames show only a part
    /// ([`Area::shown_below`]), the drops that lie in that part, or reach into it.
    #[must_use]
    pub fn on_pane(&self, area: &Area, seed: Seed) -> Deposit {
        Falls::of(*self, *area, seed).at(self.age_s)
    }
}

impl Impacts {
    /// The diameter up to which a share of the impacts are, mm.
    fn diameter_mm(&self, share: f64) -> f64 {
        let next = self.up_to.partition_point(|part| *part <= share);
        let last = next.clamp(1, self.up_to.len() - 1);
        let [low, high] = [self.up_to[last - 1], self.up_to[last]];
        let part = if high > low {
            (share - low) / (high - low)
        } else {
            0.0
        };
        #[expect(clippy::cast_precision_loss, reason = "some hundred steps")]
        let step = (last - 1) as f64;
        diameter_mm(step + part.clamp(0.0, 1.0))
    }
}
