//! A pane while it rains: drops land, merge, run and leave others behind.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::uniform;

use super::shower::Landing;
use super::{Rain, cubed};
use crate::cap::volume_per_cubed_radius;
use crate::grid::{Grid, Known};
use crate::outline::Drawn;
use crate::{Area, Cap, Outline};

/// How fast a drop runs, m/s: no law; films of drops that run down glass show some 0.02 to 0.3.
const RUN_M_S: f64 = 0.1;

/// A drop that runs leaves another each time it has gone so many of its radii, of such radii at most.
const TRAIL_STEP: f64 = 2.2;
const TRAIL_RADIUS: f64 = 0.28;

/// A drop that runs stops when it is smaller than this part of what makes it run: it moves with the angles of its
/// front and its back, and holds by them again.
const STOPS_AT: f64 = 0.85;

/// No smaller drop begins to run, mm, however it is held.
const LEAST_RUNS_MM: f64 = 1e-3;

/// Most drops for which room is made before they land.
const MOST_AWAITED: f64 = 1e6;

/// A drop on a pane. One that runs is where it began its step.
#[derive(Debug, Clone, Copy)]
struct Lying {
    at_mm: [f64; 2],
    radius_mm: f64,
    outline: Outline,
    /// Since when it lies there, or runs from there, s of the pane's age.
    since_s: f64,
    runs: Option<Step>,
    /// How many were put on the pane before it.
    put: u64,
}

/// A step of a drop that runs: down (1) or up (−1), and when it is done, s of the pane's age.
#[derive(Debug, Clone, Copy)]
struct Step {
    goes: f64,
    done_s: f64,
}

impl Lying {
    fn known(&self, number: u32) -> Known {
        Known {
            at_mm: self.at_mm,
            radius_mm: self.radius_mm,
            number,
            goes_mm: self.goes_mm(),
        }
    }

    /// How far its step is, mm; 0 of one that holds.
    fn goes_mm(&self) -> f64 {
        self.runs.map_or(0.0, |_| TRAIL_STEP * self.radius_mm)
    }

    /// How far one that runs has come in its step at an age, mm: downwards, or upwards if below 0.
    fn gone_mm(&self, age_s: f64) -> f64 {
        self.runs.map_or(0.0, |Step { goes, .. }| {
            let gone_mm = RUN_M_S * 1e3 * (age_s - self.since_s);
            goes * gone_mm.clamp(0.0, self.goes_mm())
        })
    }

    /// Where it is at an age, mm.
    fn at_mm(&self, age_s: f64) -> [f64; 2] {
        let [x, y] = self.at_mm;
        [x, y + self.gone_mm(age_s)]
    }

    /// Whether one that runs has come to another by an age, s: so near that it takes it up. Only since both are there.
    fn has_come_to(&self, other: &Self, age_s: f64) -> bool {
        let since_s = self.since_s.max(other.since_s);
        let [(dx, before), (_, after)] = [since_s, age_s].map(|age_s| {
            let ([x, y], [other_x, other_y]) = (self.at_mm(age_s), other.at_mm(age_s));
            (other_x - x, other_y - y)
        });
        let nearest = 0_f64.clamp(before.min(after), before.max(after));
        let sum = self.radius_mm + 0.5 * other.radius_mm;
        dx * dx + nearest * nearest < sum * sum
    }
}

/// A pane while it rains.
#[derive(Debug, Clone)]
pub(super) struct Pane {
    rain: Rain,
    area: Area,
    runs_from_mm: f64,
    driven_from_mm: f64,
    most_bulges: f64,
    grid: Grid,
    /// Those that went into others, or away, are none, and their places free.
    drops: Vec<Option<Lying>>,
    free: Vec<u32>,
    n_put: u64,
    /// Those that run, by when they have gone a step (as bits, which are in the order of what is above 0) and their place, with
    /// what they draw from.
    running: BTreeMap<(u64, u32), ChaCha8Rng>,
    /// Of a drop: all have the same contact angle.
    volume_per_cubed_radius: f64,
}

impl Pane {
    pub(super) fn dry(rain: Rain, area: Area) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some drops"
        )]
        let n_awaited = rain.n_landing(&area).min(MOST_AWAITED) as usize;
        Self {
            rain,
            area,
            // Ever smaller ones would run for ever.
            runs_from_mm: rain.runs_from_mm().max(LEAST_RUNS_MM),
            driven_from_mm: rain.driven_from_mm().max(LEAST_RUNS_MM),
            most_bulges: Outline::most(rain.contact_rad, rain.holds_rad()),
            grid: Grid::over(&area),
            drops: Vec::with_capacity(n_awaited),
            free: Vec::new(),
            n_put: 0,
            running: BTreeMap::new(),
            volume_per_cubed_radius: volume_per_cubed_radius(rain.contact_rad),
        }
    }

    /// The drops that frames may show at an age to which all have run, s.
    pub(super) fn caps(&self, age_s: f64) -> Vec<Cap> {
        // Those that run have gone a part of their step, and taken up what was in their way.
        let mut changed = BTreeMap::new();
        for (_, number) in self.running.keys() {
            if let Some(lying) = &self.drops[*number as usize]
                && !changed.contains_key(number)
            {
                changed.insert(*number, None);
                let cap = self.gone(lying, age_s, &mut changed);
                changed.insert(*number, cap);
            }
        }
        let mut changed = changed.into_iter().peekable();
        let shown = self.area.shown();
        let is_shown = |at_mm: [f64; 2], radius_mm: f64| shown.is_near(at_mm, 2.0 * radius_mm);
        let mut caps = Vec::with_capacity(self.drops.len());
        for (number, lying) in (0..).zip(&self.drops) {
            caps.extend(match changed.next_if(|(of, _)| *of == number) {
                Some((_, cap)) => cap.filter(|cap| is_shown(cap.at_mm, cap.radius_mm)),
                None => (lying.as_ref())
                    .filter(|lying| is_shown(lying.at_mm, lying.radius_mm))
                    .map(|lying| self.cap(lying)),
            });
        }
        caps
    }

    /// A drop lands at an age to which all have run, s, takes up what it touches, and begins to run if it is too heavy then: it
    /// is given what it will draw from.
    pub(super) fn lands(
        &mut self,
        age_s: f64,
        landing: &Landing,
        trail: impl FnOnce() -> ChaCha8Rng,
    ) {
        let mut cap = Cap {
            outline: Outline::fallen(&landing.drawn, self.most_bulges),
            ..self.round(landing.at_mm, landing.volume_mm3)
        };
        let ran = self.take_up(&mut cap, age_s);
        self.leave(&cap, (age_s, ran), trail);
    }

    /// Lets those that run go on to an age, s, step by step, each at its time.
    pub(super) fn run(&mut self, age_s: f64) {
        while let Some(first) = self.running.first_entry()
            && f64::from_bits(first.key().0) <= age_s
        {
            let ((_, number), trail) = first.remove_entry();
            let lying = self.clear(number);
            if let Some((lying, step)) = lying.and_then(|lying| Some((lying, lying.runs?))) {
                self.step(&lying, step, trail);
            }
        }
    }

    /// A drop has gone a step: it has taken up what was in its way, and leaves a small drop behind, until it is small enough to
    /// hold.
    fn step(&mut self, before: &Lying, Step { goes, done_s }: Step, mut trail: ChaCha8Rng) {
        let Some(cap) = self.go(before, done_s) else {
            return;
        };
        let [u, v, w] = [
            uniform(&mut trail),
            uniform(&mut trail),
            uniform(&mut trail),
        ];
        let mut small = Cap {
            at_mm: [
                before.at_mm[0] + 0.3 * before.radius_mm * (2.0 * v - 1.0),
                before.at_mm[1] - goes * 0.3 * before.radius_mm * w,
            ],
            radius_mm: TRAIL_RADIUS * before.radius_mm * (0.35 + 0.65 * u),
            outline: Outline::fallen(&Drawn::by(&mut trail), self.most_bulges),
            ..cap
        };
        let left_mm3 = self.volume_mm3(cap.radius_mm) - self.volume_mm3(small.radius_mm);
        // Others may have fallen there meanwhile.
        let ran = self.take_up(&mut small, done_s);
        self.leave(&small, (done_s, ran), || trail.clone());
        let mut cap = Cap {
            outline: cap.outline,
            ..self.round(cap.at_mm, left_mm3)
        };
        if self.goes_on(&cap, goes) {
            self.begin(&cap, done_s, goes, trail);
        } else {
            // Where it stops it may touch others.
            let ran = self.take_up(&mut cap, done_s);
            self.leave(&cap, (done_s, ran), || trail);
        }
    }

    /// A drop that was taken off the pane and runs, where it is at an age, with all that was in its way, which is taken off, too;
    /// none where it has left the area.
    fn go(&mut self, lying: &Lying, age_s: f64) -> Option<Cap> {
        let mut taken = BTreeMap::new();
        let cap = self.gone(lying, age_s, &mut taken);
        for number in taken.keys() {
            self.clear(*number);
        }
        cap
    }

    /// The same, but that nothing is taken off: numbers of what was in its way are added to those that are taken, and drops that
    /// are among them already are passed over.
    fn gone(
        &self,
        lying: &Lying,
        age_s: f64,
        taken: &mut BTreeMap<u32, Option<Cap>>,
    ) -> Option<Cap> {
        let [x, from] = lying.at_mm;
        let by_mm = lying.gone_mm(age_s);
        let [low, high] = [from.min(from + by_mm), from.max(from + by_mm)];
        let in_way = self.near(([x, low], [x, high]), lying.radius_mm, |other| {
            lying.has_come_to(other, age_s)
        });
        let mut volume_mm3 = self.volume_mm3(lying.radius_mm);
        for number in in_way {
            if taken.contains_key(&number) {
                continue;
            }
            taken.insert(number, None);
            let more_mm = match &self.drops[number as usize] {
                Some(other) if other.runs.is_some() => {
                    (self.gone(other, age_s, taken)).map_or(0.0, |cap| cap.radius_mm)
                }
                other => other.as_ref().map_or(0.0, |other| other.radius_mm),
            };
            volume_mm3 += self.volume_mm3(more_mm);
        }
        let at_mm = [x, from + by_mm];
        let is_on = (self.area.from_mm[1]..self.area.to_mm[1]).contains(&at_mm[1]);
        is_on.then(|| Cap {
            outline: Outline::ran(by_mm.signum(), self.most_bulges),
            ..self.round(at_mm, volume_mm3)
        })
    }

    /// A drop holds where it is at an age, or begins to run, or goes on as one did that it took up.
    fn leave(
        &mut self,
        cap: &Cap,
        (age_s, ran): (f64, Option<f64>),
        trail: impl FnOnce() -> ChaCha8Rng,
    ) {
        let goes = self.runs(cap);
        match goes.or_else(|| ran.filter(|goes| self.goes_on(cap, *goes))) {
            Some(goes) => self.begin(cap, age_s, goes, trail()),
            None => {
                self.put(cap, (age_s, None));
            }
        }
    }

    /// A drop begins a step.
    fn begin(&mut self, cap: &Cap, age_s: f64, goes: f64, trail: ChaCha8Rng) {
        let done_s = age_s + TRAIL_STEP * cap.radius_mm / (RUN_M_S * 1e3);
        let step = Step { goes, done_s };
        let number = self.put(cap, (age_s, Some(step)));
        self.running.insert((done_s.to_bits(), number), trail);
    }

    /// A round drop: [`Cap::of_volume`], without the angles, which take most of its time.
    fn round(&self, at_mm: [f64; 2], volume_mm3: f64) -> Cap {
        Cap {
            at_mm,
            radius_mm: libm::cbrt(volume_mm3 / self.volume_per_cubed_radius),
            contact_rad: self.rain.contact_rad,
            outline: Outline::default(),
        }
    }

    /// [`Cap::volume_mm3`], in the same way.
    fn volume_mm3(&self, radius_mm: f64) -> f64 {
        self.volume_per_cubed_radius * cubed(radius_mm)
    }

    /// Whether a drop moves: 1 downhill, −1 uphill.
    fn runs(&self, cap: &Cap) -> Option<f64> {
        if cap.radius_mm >= self.driven_from_mm {
            Some(-1.0)
        } else if cap.radius_mm >= self.runs_from_mm {
            Some(1.0)
        } else {
            None
        }
    }

    /// Whether a drop that runs downhill (1) or uphill (−1) is still large enough for that.
    fn goes_on(&self, cap: &Cap, goes: f64) -> bool {
        let moves_from_mm = if goes < 0.0 {
            self.driven_from_mm
        } else {
            self.runs_from_mm
        };
        cap.radius_mm > STOPS_AT * moves_from_mm
    }

    fn put(&mut self, cap: &Cap, (since_s, runs): (f64, Option<Step>)) -> u32 {
        let number = self.free.pop().unwrap_or_else(|| {
            self.drops.push(None);
            u32::try_from(self.drops.len() - 1).unwrap_or(u32::MAX)
        });
        let lying = Lying {
            at_mm: cap.at_mm,
            radius_mm: cap.radius_mm,
            outline: cap.outline,
            since_s,
            runs,
            put: self.n_put,
        };
        self.grid.add(lying.known(number));
        self.drops[number as usize] = Some(lying);
        self.n_put += 1;
        number
    }

    /// Takes up all drops that a drop touches at an age, until it touches none: one of all their water, at their center of mass.
    /// Where the first of those that ran went: downhill (1) or uphill (−1).
    fn take_up(&mut self, cap: &mut Cap, age_s: f64) -> Option<f64> {
        let mut ran = None;
        loop {
            let touched = self.near((cap.at_mm, cap.at_mm), cap.radius_mm, |other| {
                let at_mm = other.at_mm(age_s);
                let [dx, dy] = [0, 1].map(|k| at_mm[k] - cap.at_mm[k]);
                let sum = cap.radius_mm + other.radius_mm;
                dx * dx + dy * dy < sum * sum && !self.is_taken_up(other, age_s)
            });
            if touched.is_empty() {
                return ran;
            }
            let mut taken = Vec::new();
            for number in touched {
                // One may have been in the way of another.
                let Some(lying) = self.clear(number) else {
                    continue;
                };
                ran = ran.or(lying.runs.map(|step| step.goes));
                taken.extend(match lying.runs {
                    Some(_) => self.go(&lying, age_s),
                    None => Some(self.cap(&lying)),
                });
            }
            for other in taken {
                let [own, more] = [*cap, other].map(|cap| self.volume_mm3(cap.radius_mm));
                let at =
                    [0, 1].map(|k| (own * cap.at_mm[k] + more * other.at_mm[k]) / (own + more));
                let parts = [*cap, other].map(|cap| (cap.at_mm, cap.radius_mm, cap.outline));
                *cap = Cap {
                    outline: Outline::joined(&parts, self.most_bulges),
                    ..self.round(at, own + more)
                };
            }
        }
    }

    /// Whether one that runs has come to a drop by an age, and takes it up when its step is done.
    fn is_taken_up(&self, other: &Lying, age_s: f64) -> bool {
        let mut is_taken_up = false;
        let within_mm = other.goes_mm() + other.radius_mm;
        let place = (other.at_mm, other.at_mm);
        self.grid.each_running_near(place, within_mm, |number| {
            is_taken_up |= (self.drops[number as usize].as_ref())
                .is_some_and(|it| it.put != other.put && it.has_come_to(other, age_s));
        });
        is_taken_up
    }

    /// Numbers of the drops that are as asked among those that may reach to within a distance of a rectangle. They come in an
    /// order that does not depend on how they are kept: sums over them have its last bits.
    fn near(
        &self,
        place: ([f64; 2], [f64; 2]),
        within_mm: f64,
        is: impl Fn(&Lying) -> bool,
    ) -> Vec<u32> {
        let mut found = Vec::new();
        self.grid.each_near(place, within_mm, |number| {
            if self.drops[number as usize].as_ref().is_some_and(&is) {
                found.push(number);
            }
        });
        if found.len() > 1 {
            found.sort_by_cached_key(|number| {
                let lying = self.drops[*number as usize].as_ref();
                lying.map(|lying| (self.grid.order(lying.at_mm), lying.put))
            });
        }
        found
    }

    /// As it lies; one that runs where it began its step.
    fn cap(&self, lying: &Lying) -> Cap {
        Cap {
            at_mm: lying.at_mm,
            radius_mm: lying.radius_mm,
            contact_rad: self.rain.contact_rad,
            outline: lying.outline,
        }
    }

    /// Takes a drop off the pane, if it is there.
    fn clear(&mut self, number: u32) -> Option<Lying> {
        let lying = self.drops[number as usize].take()?;
        if let Some(Step { done_s, .. }) = lying.runs {
            self.running.remove(&(done_s.to_bits(), number));
        }
        self.grid.remove(&lying.known(number));
        self.free.push(number);
        Some(lying)
    }
}

#[cfg(test)]
#[path = "pane_tests.rs"]
mod tests;
