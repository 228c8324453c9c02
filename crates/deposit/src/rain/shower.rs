//! Rain on one pane as it goes on.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{Seed, Stream, uniform};

use super::pane::Pane;
use super::{Impacts, Rain, cubed};
use crate::{Area, Deposit};

/// So much of the last rain can still be asked for at earlier ages than the latest, s: frames of a clip that are shown side
/// by side.
const LATE_S: f64 = 0.25;

/// Rain on an area of a pane at one age after the other: what [`Rain::on_pane`] gives, without all the rain before.
///
/// Drops that have come to rest are kept with all that came before them; the first that might still run at a later age, and
/// what fell after it, falls anew each time. So an age takes what has rained since, and a quarter of a second of rain.
#[derive(Debug, Clone)]
pub struct Shower {
    rain: Rain,
    area: Area,
    seed: Seed,
    impacts: Impacts,
    /// Drops that land in a second on its rectangle: of corners that are cut off nothing more is asked.
    per_s: f64,
    pane: Pane,
    rng: ChaCha8Rng,
    /// The next drop, and how many landed before it.
    next: Landing,
    n_landed: u64,
    /// Latest age at which it came to rest, s.
    rests_s: f64,
}

/// A drop that lands.
#[derive(Debug, Clone, Copy)]
struct Landing {
    time_s: f64,
    at_mm: [f64; 2],
    volume_mm3: f64,
}

impl Shower {
    /// A dry pane, with the rain that will fall on it; its age does not count.
    #[must_use]
    pub fn of(rain: Rain, area: Area, seed: Seed) -> Self {
        let impacts = rain.impacts();
        let per_s = if rain.rate_m_s > 0.0 {
            impacts.all * area.rectangle_m2()
        } else {
            0.0
        };
        let mut rng = seed.stream(Stream::Rain, 0);
        let next = impacts.landing((0.0, per_s), &area, &mut rng);
        Self {
            rain,
            area,
            seed,
            pane: Pane::dry(rain, area),
            impacts,
            per_s,
            rng,
            next,
            n_landed: 0,
            rests_s: 0.0,
        }
    }

    /// Whether it is what falls on an area by a seed, at whatever age.
    #[must_use]
    pub fn is_of(&self, rain: &Rain, area: &Area, seed: Seed) -> bool {
        let age_s = rain.age_s;
        let own = Rain { age_s, ..self.rain };
        (own, self.area, self.seed) == (*rain, *area, seed)
    }

    /// Keeps what has come to rest some time before an age, s.
    pub fn rest(&mut self, age_s: f64) {
        let rests_s = age_s - LATE_S;
        self.go_on(rests_s, true);
        self.rests_s = self.rests_s.max(rests_s);
    }

    /// What lies on the pane at an age, s.
    #[must_use]
    pub fn at(mut self, age_s: f64) -> Deposit {
        if age_s < self.rests_s {
            self = Self::of(self.rain, self.area, self.seed);
        }
        self.go_on(age_s, false);
        Deposit {
            caps: self.pane.caps(),
        }
    }

    /// Lets drops land up to an age; may stop before the first that has not come to rest then.
    fn go_on(&mut self, age_s: f64, stops: bool) {
        while self.per_s > 0.0 && self.next.time_s <= age_s {
            let Landing {
                time_s,
                at_mm,
                volume_mm3,
            } = self.next;
            if self.area.holds(at_mm) {
                let trail = self.seed.stream(Stream::Rain, self.n_landed + 1);
                let rests = self.pane.lands(at_mm, volume_mm3, (age_s - time_s, trail));
                if stops && !rests {
                    self.pane.take_back();
                    return;
                }
            }
            self.n_landed += 1;
            self.next = (self.impacts).landing((time_s, self.per_s), &self.area, &mut self.rng);
        }
    }
}

impl Impacts {
    /// The drop that lands after a time, s, of so many in a second.
    fn landing(&self, (time_s, per_s): (f64, f64), area: &Area, rng: &mut ChaCha8Rng) -> Landing {
        let [width, height] = area.sides_mm();
        let time_s = time_s - libm::log(1.0 - uniform(rng)) / per_s;
        let at_mm = [
            area.from_mm[0] + width * uniform(rng),
            area.from_mm[1] + height * uniform(rng),
        ];
        let diameter_mm = self.diameter_mm(uniform(rng));
        Landing {
            time_s,
            at_mm,
            volume_mm3: PI / 6.0 * cubed(diameter_mm),
        }
    }
}
