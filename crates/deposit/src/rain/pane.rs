//! A pane while it rains: drops land, merge, run and leave others behind.

use rand_chacha::ChaCha8Rng;
use starbreak_seed::uniform;

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

/// Most drops for which room is made before they land.
const MOST_AWAITED: f64 = 1e6;

/// A drop that lies on a pane.
#[derive(Debug, Clone, Copy)]
struct Lying {
    at_mm: [f64; 2],
    radius_mm: f64,
    outline: Lies,
    /// How many were put on the pane before it.
    put: u64,
}

/// How far a drop is from round: as it is known, or as what it was left with makes it.
#[derive(Debug, Clone, Copy)]
enum Lies {
    Known(Outline),
    Drawn(Drawn),
}

impl Lying {
    fn known(&self, number: u32) -> Known {
        Known {
            at_mm: self.at_mm,
            radius_mm: self.radius_mm,
            number,
        }
    }
}

/// What is done to a pane.
#[derive(Debug, Clone, Copy)]
enum Change {
    /// A drop is put into a place, which may be a new one.
    Put {
        number: u32,
        is_new: bool,
    },
    Cleared(Known, Option<Lying>),
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
    /// Since the last drop landed.
    changes: Vec<Change>,
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
            runs_from_mm: rain.runs_from_mm(),
            driven_from_mm: rain.driven_from_mm(),
            most_bulges: Outline::most(rain.contact_rad, rain.holds_rad()),
            grid: Grid::over(&area),
            drops: Vec::with_capacity(n_awaited),
            free: Vec::new(),
            n_put: 0,
            changes: Vec::new(),
            volume_per_cubed_radius: volume_per_cubed_radius(rain.contact_rad),
        }
    }

    /// The drops that lie there.
    pub(super) fn caps(&self) -> Vec<Cap> {
        let drops = self.drops.iter().flatten();
        drops.map(|lying| self.cap(lying)).collect()
    }

    /// A drop lands, takes up what it touches, and runs for so long if it is too heavy then. Whether it has come to rest, or
    /// has left the area: then it is so after any longer time.
    pub(super) fn lands(
        &mut self,
        at_mm: [f64; 2],
        volume_mm3: f64,
        (runs_s, mut trail): (f64, ChaCha8Rng),
    ) -> bool {
        self.changes.clear();
        let mut cap = Cap {
            outline: Outline::fallen(&Drawn::by(&mut trail), self.most_bulges),
            ..self.round(at_mm, volume_mm3)
        };
        self.take_up(&mut cap);
        let mut left_mm = RUN_M_S * runs_s * 1e3;
        let mut has_run = false;
        while left_mm > 0.0
            && let Some(goes) = self.runs(&cap)
        {
            has_run = true;
            match self.run(&mut cap, (goes, left_mm), &mut trail) {
                Some(left) => left_mm = left,
                None => return true,
            }
        }
        self.put(&cap, Lies::Known(cap.outline));
        left_mm > 0.0 || !has_run && self.runs(&cap).is_none()
    }

    /// As if the last drop had not landed.
    pub(super) fn take_back(&mut self) {
        while let Some(change) = self.changes.pop() {
            match change {
                Change::Put { number, is_new } => {
                    self.n_put -= 1;
                    let lying = match is_new {
                        true => self.drops.pop().flatten(),
                        false => {
                            self.free.push(number);
                            self.drops[number as usize].take()
                        }
                    };
                    if let Some(lying) = lying {
                        self.grid.remove(&lying.known(number));
                    }
                }
                Change::Cleared(known, lying) => {
                    self.free.pop();
                    self.drops[known.number as usize] = lying;
                    self.grid.add(known);
                }
            }
        }
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

    fn put(&mut self, cap: &Cap, outline: Lies) {
        let freed = self.free.pop();
        let number = freed.unwrap_or_else(|| {
            self.drops.push(None);
            u32::try_from(self.drops.len() - 1).unwrap_or(u32::MAX)
        });
        let lying = Lying {
            at_mm: cap.at_mm,
            radius_mm: cap.radius_mm,
            outline,
            put: self.n_put,
        };
        self.grid.add(lying.known(number));
        self.drops[number as usize] = Some(lying);
        self.n_put += 1;
        let is_new = freed.is_none();
        self.changes.push(Change::Put { number, is_new });
    }

    /// Takes up all drops that a drop touches, until it touches none: one of all their water, at their center of mass.
    fn take_up(&mut self, cap: &mut Cap) {
        loop {
            let touched = self.near((cap.at_mm, cap.at_mm), cap.radius_mm, |other| {
                let [dx, dy] = [0, 1].map(|k| other.at_mm[k] - cap.at_mm[k]);
                let sum = cap.radius_mm + other.radius_mm;
                dx * dx + dy * dy < sum * sum
            });
            if touched.is_empty() {
                return;
            }
            let touched: Vec<Cap> = touched
                .iter()
                .filter_map(|known| self.take(known))
                .collect();
            for other in touched {
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

    /// A drop runs downhill (1) or uphill (−1) by so many mm at most. It takes up what is in its way and leaves small
    /// drops behind, until it is small enough to hold. How far it could still go; none where it has left the area.
    fn run(
        &mut self,
        cap: &mut Cap,
        (goes, mut left_mm): (f64, f64),
        trail: &mut ChaCha8Rng,
    ) -> Option<f64> {
        let moves_from_mm = if goes < 0.0 {
            self.driven_from_mm
        } else {
            self.runs_from_mm
        };
        let stops_mm = STOPS_AT * moves_from_mm;
        while left_mm > 0.0 && cap.radius_mm > stops_mm {
            let full_mm = TRAIL_STEP * cap.radius_mm;
            let step_mm = full_mm.min(left_mm);
            left_mm -= step_mm;
            let from = cap.at_mm;
            cap.at_mm[1] += goes * step_mm;
            if !(self.area.from_mm[1]..self.area.to_mm[1]).contains(&cap.at_mm[1]) {
                return None;
            }
            // What is in its way.
            let [low, high] = [from[1].min(cap.at_mm[1]), from[1].max(cap.at_mm[1])];
            let way = ([cap.at_mm[0], low], [cap.at_mm[0], high]);
            let in_way = self.near(way, cap.radius_mm, |other| {
                let dx = other.at_mm[0] - cap.at_mm[0];
                let dy = other.at_mm[1] - other.at_mm[1].clamp(low, high);
                let sum = cap.radius_mm + 0.5 * other.radius_mm;
                dx * dx + dy * dy < sum * sum
            });
            let mut volume = self.volume_mm3(cap.radius_mm);
            let more = in_way.iter().map(|known| self.volume_mm3(known.radius_mm));
            volume += more.sum::<f64>();
            in_way.iter().for_each(|known| self.clear(known));
            // What stays behind.
            let [u, v, w] = [uniform(trail), uniform(trail), uniform(trail)];
            let small_mm = TRAIL_RADIUS * cap.radius_mm * (0.35 + 0.65 * u);
            let small = Cap {
                at_mm: [
                    from[0] + 0.3 * cap.radius_mm * (2.0 * v - 1.0),
                    from[1] - goes * 0.3 * cap.radius_mm * w,
                ],
                radius_mm: small_mm,
                contact_rad: cap.contact_rad,
                outline: Outline::default(),
            };
            let drawn = Drawn::by(trail);
            if step_mm >= full_mm {
                volume -= self.volume_mm3(small_mm);
                self.put(&small, Lies::Drawn(drawn));
            }
            *cap = self.round(cap.at_mm, volume);
        }
        cap.outline = Outline::ran(goes, self.most_bulges);
        // Where it stops it may touch others.
        self.take_up(cap);
        Some(left_mm)
    }

    /// The drops about a rectangle that are as asked, and reach to within a distance of it at least. They come in an order
    /// that does not depend on how they are kept: sums over them have its last bits.
    fn near(
        &self,
        place: ([f64; 2], [f64; 2]),
        within_mm: f64,
        is: impl Fn(&Known) -> bool,
    ) -> Vec<Known> {
        let mut found = Vec::new();
        self.grid.each_near(place, within_mm, |known| {
            if is(known) {
                found.push(*known);
            }
        });
        if found.len() > 1 {
            found.sort_by_cached_key(|known| {
                let lying = self.drops[known.number as usize].as_ref();
                let put = lying.map(|lying| lying.put);
                (self.grid.order(known.at_mm), put)
            });
        }
        found
    }

    fn cap(&self, lying: &Lying) -> Cap {
        Cap {
            at_mm: lying.at_mm,
            radius_mm: lying.radius_mm,
            contact_rad: self.rain.contact_rad,
            outline: match &lying.outline {
                Lies::Known(outline) => *outline,
                Lies::Drawn(drawn) => Outline::fallen(drawn, self.most_bulges),
            },
        }
    }

    /// Takes a drop off the pane.
    fn take(&mut self, known: &Known) -> Option<Cap> {
        let lying = self.drops[known.number as usize];
        self.clear(known);
        lying.map(|lying| self.cap(&lying))
    }

    fn clear(&mut self, known: &Known) {
        let lying = self.drops[known.number as usize].take();
        self.changes.push(Change::Cleared(*known, lying));
        self.grid.remove(known);
        self.free.push(known.number);
    }
}
