//! Rain on one pane as it goes on.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{Seed, Stream, uniform};

use super::pane::Pane;
use super::{Impacts, Rain, cubed};
use crate::cap::volume_per_cubed_radius;
use crate::outline::Drawn;
use crate::{Area, Deposit};

/// So much of the last rain can still be asked for at earlier ages than the latest, s: frames of a clip that are shown side
/// by side.
const LATE_S: f64 = 0.25;

/// Drops that are too small to be seen are left out as far as they bring this share of the water: others would be missed in those
/// that they become a part of.
const LITTLE: f64 = 0.01;

/// Rain on an area of a pane at one age after the other: what [`Rain::on_pane`] gives, without all the rain before.
///
/// Drops land and run at their times, so that a later age goes on from what was there at the latest that was asked for. An
/// earlier one goes on from what was there a quarter of a second before that; what is earlier still begins anew.
#[derive(Debug, Clone)]
pub struct Shower {
    falls: Falls,
    late: Past,
    latest: Past,
}

/// What falls.
#[derive(Debug, Clone)]
pub(super) struct Falls {
    rain: Rain,
    area: Area,
    seed: Seed,
    impacts: Impacts,
    /// Drops that land in a second.
    per_s: f64,
    volume_per_cubed_radius: f64,
    /// Volume of drops than which smaller ones bring little of the water.
    little_mm3: f64,
}

/// What has fallen, up to an age.
#[derive(Debug, Clone)]
struct Past {
    age_s: f64,
    pane: Pane,
    rng: ChaCha8Rng,
    /// When the next drop comes, s, and it, if it is large enough to be seen; how many came before it.
    next: (f64, Option<Landing>),
    n_landed: u64,
}

/// A drop that lands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landing {
    pub(super) at_mm: [f64; 2],
    pub(super) volume_mm3: f64,
    pub(super) drawn: Drawn,
}

impl Shower {
    /// A dry pane, with the rain that will fall on it; its age does not count.
    #[must_use]
    pub fn of(rain: Rain, area: Area, seed: Seed) -> Self {
        let falls = Falls::of(rain, area, seed);
        let dry = falls.dry();
        Self {
            falls,
            latest: dry.clone(),
            late: dry,
        }
    }

    /// Whether it is what falls on an area by a seed, at whatever age.
    #[must_use]
    pub fn is_of(&self, rain: &Rain, area: &Area, seed: Seed) -> bool {
        let age_s = rain.age_s;
        let falls = &self.falls;
        let own = Rain {
            age_s,
            ..falls.rain
        };
        (own, falls.area, falls.seed) == (*rain, *area, seed)
    }

    /// What lies on the pane at an age, s.
    pub fn at(&mut self, age_s: f64) -> Deposit {
        if age_s < self.late.age_s {
            self.late = self.falls.dry();
            self.latest = self.late.clone();
        }
        self.late.go_on(&self.falls, age_s - LATE_S);
        if self.latest.age_s < self.late.age_s {
            self.latest = self.late.clone();
        }
        if self.latest.age_s <= age_s {
            self.latest.go_on(&self.falls, age_s);
            return self.latest.deposit();
        }
        let mut earlier = self.late.clone();
        earlier.go_on(&self.falls, age_s);
        earlier.deposit()
    }
}

impl Falls {
    pub(super) fn of(rain: Rain, area: Area, seed: Seed) -> Self {
        let impacts = rain.impacts();
        let per_s = if rain.rate_m_s > 0.0 {
            impacts.all * area.area_m2()
        } else {
            0.0
        };
        Self {
            rain,
            area,
            seed,
            impacts,
            per_s,
            volume_per_cubed_radius: volume_per_cubed_radius(rain.contact_rad),
            little_mm3: PI / 6.0 * cubed(rain.brings_mm(LITTLE)),
        }
    }

    fn dry(&self) -> Past {
        let mut rng = self.seed.stream(Stream::Rain, 0);
        Past {
            age_s: 0.0,
            pane: Pane::dry(self.rain, self.area),
            next: self.next(0.0, &mut rng),
            rng,
            n_landed: 0,
        }
    }

    /// When the next drop comes after a time, s, and it, unless it is too small to be seen.
    fn next(&self, time_s: f64, rng: &mut ChaCha8Rng) -> (f64, Option<Landing>) {
        let time_s = time_s - libm::log(1.0 - uniform(rng)) / self.per_s;
        let at_mm = self.area.place(rng);
        let diameter_mm = self.impacts.diameter_mm(uniform(rng));
        let volume_mm3 = PI / 6.0 * cubed(diameter_mm);
        let least_mm = self.area.least_radius_mm(at_mm[1]);
        let seen_mm3 = self.volume_per_cubed_radius * cubed(least_mm);
        // Whatever is seen, all others are the same.
        let drawn = Drawn::by(rng);
        let landing = (volume_mm3 >= seen_mm3.min(self.little_mm3)).then_some(Landing {
            at_mm,
            volume_mm3,
            drawn,
        });
        (time_s, landing)
    }

    /// What lies on the pane at an age, s, if nothing more is asked.
    pub(super) fn at(&self, age_s: f64) -> Deposit {
        let mut past = self.dry();
        past.go_on(self, age_s);
        past.deposit()
    }
}

impl Past {
    /// Lets drops land and run up to an age, s.
    fn go_on(&mut self, falls: &Falls, age_s: f64) {
        while falls.per_s > 0.0 && self.next.0 <= age_s {
            let next = falls.next(self.next.0, &mut self.rng);
            self.n_landed += 1;
            let (time_s, Some(landing)) = std::mem::replace(&mut self.next, next) else {
                continue;
            };
            let trail = || falls.seed.stream(Stream::Rain, self.n_landed);
            self.pane.run(time_s);
            self.pane.lands(time_s, &landing, trail);
        }
        self.pane.run(age_s);
        self.age_s = self.age_s.max(age_s);
    }

    fn deposit(&self) -> Deposit {
        Deposit {
            caps: self.pane.caps(self.age_s),
        }
    }
}
