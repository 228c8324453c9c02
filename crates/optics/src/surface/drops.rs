//! Drops of water on the outer face: lenses that show the scene small and upside down.

use std::sync::Arc;

use starbreak_deposit::{Cap, RoundPlace};

use super::drawn_drop::{DrawnDrop, Seen};
use super::glimpse::Glimpses;
use super::kept_drops::{Looked, Shown};
use super::lobe::{Before, HELD, LANES, LightFrom, Sent};
use super::small_drop::SmallDrop;
use crate::interface::fresnel::{reflectance, reflectance_at};
use crate::maps::Drawn;
use crate::vector::{Vector, dot};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Times that light is followed within a drop, and the least share of it that is; what is left then is lost.
const MOST_BOUNCES: u32 = 5;
const LEAST_SHARE: f64 = 1e-3;

/// Farthest from the middle, of the radius, that light is followed.
pub(super) const RIM: f64 = 0.995;

/// Least radius of a drop, px.
pub(super) const LEAST_PX: f64 = 0.12;

/// Drops as they are drawn: those of which parts are seen, and all others.
#[derive(Default)]
pub(crate) struct Drops<'a> {
    traced: Vec<Seeable<'a>>,
    small: Vec<Seeable<'a>>,
}

/// A drop that is seen.
pub(super) enum Seeable<'a> {
    Traced(DrawnDrop<'a>),
    Small(SmallDrop),
    /// As it was seen before.
    Kept(Arc<Shown>),
}

impl<'a> Drops<'a> {
    /// All that reach into the frame, blurred by a pupil that reaches so many of its radii from its middle; those that are
    /// farther from the frame than `reach_px` do not. Those that are kept are not traced again, and what is traced of others
    /// is kept.
    pub(crate) fn of(
        from: &'a LightFrom<'a>,
        caps: &[Cap],
        (reach_px, pupil_reach): (f64, f64),
        mut kept: Option<&mut Looked>,
    ) -> Self {
        let mut drops = Self::default();
        let mut glimpses: Vec<(u64, Arc<Glimpses>)> = match &kept {
            Some(kept) => kept.glimpses.clone(),
            None => Vec::new(),
        };
        for (k, cap) in caps.iter().enumerate() {
            let known = kept.as_mut().and_then(|kept| kept.known[k].take());
            let drop = known.map(Seeable::Kept).or_else(|| {
                let seen = Seen::of(cap, from.sheet, reach_px)?;
                let small = SmallDrop::of(&seen, |at_px, is_soft| {
                    let contact = cap.contact_rad.to_bits();
                    let known = glimpses.iter().position(|(of, _)| *of == contact);
                    let known = known.unwrap_or_else(|| {
                        let all = Glimpses::of(&Water::of(cap.contact_rad, from));
                        glimpses.push((contact, Arc::new(all)));
                        glimpses.len() - 1
                    });
                    glimpses[known].1.at(at_px, is_soft)
                });
                if let Some(small) = small {
                    return Some(Seeable::Small(small));
                }
                let drop = Drop::of(*cap, from, seen.enters_mm)?;
                let drawn = DrawnDrop::of(drop, &seen, pupil_reach)?;
                Some(Seeable::Traced(drawn))
            });
            drops.extend(match &mut kept {
                Some(kept) => kept.keep(cap, drop),
                None => drop,
            });
        }
        if let Some(kept) = kept {
            kept.glimpses = glimpses;
        }
        drops
    }

    fn extend(&mut self, drop: Option<Seeable<'a>>) {
        match drop {
            None => {}
            Some(Seeable::Traced(_)) => self.traced.extend(drop),
            Some(Seeable::Small(_)) => self.small.extend(drop),
            Some(Seeable::Kept(ref shown)) => match **shown {
                Shown::Traced(_) => self.traced.extend(drop),
                Shown::Small(_) => self.small.extend(drop),
                Shown::Nothing => {}
            },
        }
    }

    /// All, in an order that does not depend on what was kept.
    pub(crate) fn all(&self) -> Vec<&dyn Drawn<LANES>> {
        let all = self.traced.iter().chain(&self.small);
        all.filter_map(|drop| match drop {
            Seeable::Traced(drop) => Some(drop as &dyn Drawn<LANES>),
            Seeable::Small(drop) => Some(drop),
            Seeable::Kept(shown) => match &**shown {
                Shown::Traced(drop) => Some(drop),
                Shown::Small(drop) => Some(drop),
                Shown::Nothing => None,
            },
        })
        .collect()
    }
}

/// A drop before a camera.
pub(super) struct Drop<'a> {
    pub(super) cap: Cap,
    pub(super) water: Water<'a>,
    /// Where the ray of sight to its middle enters the pane, mm, and how this moves across it, mm per mm.
    enters_mm: [f64; 2],
    moves: [[f64; 2]; 2],
}

/// What light meets in drops of a contact angle, whatever their size.
#[derive(Clone, Copy)]
pub(super) struct Water<'a> {
    pub(super) from: &'a LightFrom<'a>,
    /// Sine and cosine of the contact angle: radius of a drop, and how far its footprint is from the middle of its sphere,
    /// of the radius of that.
    sphere: [f64; 2],
}

/// A direction of sight before the glass, and what is the same for all light that is seen along it.
#[derive(Clone, Copy)]
pub(super) struct Sight {
    /// Its parts in the plane of the pane.
    pub(super) along: [f64; 2],
    /// The face towards the camera.
    pub(super) before: Before,
    /// What passes from glass to water.
    pub(super) passes: f64,
}

impl<'a> Drop<'a> {
    /// Of one to whose middle the ray of sight enters the pane at a place, mm; none where it is not before the camera.
    fn of(cap: Cap, from: &'a LightFrom<'a>, enters_mm: [f64; 2]) -> Option<Self> {
        let enters = |right_mm: f64, down_mm: f64| {
            let at = [cap.at_mm[0] + right_mm, cap.at_mm[1] + down_mm];
            from.sheet.entry(at, from.sheet.outer_mm(), [0.0; 2])
        };
        let by = |other: [f64; 2]| [0, 1].map(|k| (other[k] - enters_mm[k]) / cap.radius_mm);
        Some(Self {
            cap,
            water: Water::of(cap.contact_rad, from),
            enters_mm,
            moves: [
                by(enters(cap.radius_mm, 0.0)?),
                by(enters(0.0, cap.radius_mm)?),
            ],
        })
    }

    /// Where the ray of sight to a place of the outer face enters the pane: a drop is so small that this is linear.
    fn enters_mm(&self, at_mm: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| at_mm[k] - self.cap.at_mm[k]);
        [0, 1].map(|k| self.enters_mm[k] + x * self.moves[0][k] + y * self.moves[1][k])
    }

    /// Where a place of the outer face appears in the frame, px.
    pub(super) fn appears(&self, at_mm: [f64; 2]) -> Option<[f64; 2]> {
        self.water
            .from
            .sheet
            .appears(self.enters_mm(at_mm), [0.0; 2])
    }
}

impl<'a> Water<'a> {
    fn of(contact_rad: f64, from: &'a LightFrom<'a>) -> Self {
        let (sin, cos) = libm::sincos(contact_rad);
        let sphere = [sin, cos];
        Self { from, sphere }
    }

    /// What is seen through an uneven drop at what is a place of a round one, as a share of what bare glass would show there;
    /// the shares sum to 1.
    pub(super) fn seen_in(&self, RoundPlace { level, slope }: RoundPlace, sight: &Sight) -> Sent {
        let [wide, face] = self.sphere;
        // To a sphere of the same radius whose surface is as high above the place, and as steep: along its normal, from the
        // middle of it.
        let [x, y] = slope.map(|part| wide * part);
        let z = (1.0 - wide * wide * level).max(0.0).sqrt();
        let by = 1.0 / (x * x + y * y + z * z).sqrt();
        self.seen_from([by * x, by * y, by * z - (z - face).max(0.0)], sight)
    }

    /// The same through a round drop at a place of the outer face, of its radius from its middle.
    pub(super) fn seen(&self, [x, y]: [f64; 2], sight: &Sight) -> Sent {
        let [wide, face] = self.sphere;
        self.seen_from([wide * x, wide * y, face], sight)
    }

    /// What is seen through a drop from a place of the outer face, from the middle of its sphere, of the radius of that.
    fn seen_from(&self, mut at: Vector, sight: &Sight) -> Sent {
        let [x, y] = sight.along.map(|part| part * (1.0 / WATER));
        let mut ray = [x, y, (1.0 - x * x - y * y).sqrt()];
        // The face cuts off what is before this.
        let face = at[2];
        let mut share = 1.0;
        let mut sent = Sent::default();
        for _ in 0..MOST_BOUNCES {
            // To the sphere, or before that to the glass.
            let along = dot(at, ray);
            let to_sphere = (along * along - dot(at, at) + 1.0).max(0.0).sqrt() - along;
            let to_glass = if ray[2] < 0.0 {
                (face - at[2]) / ray[2]
            } else {
                f64::INFINITY
            };
            if to_glass < to_sphere {
                self.enters_cabin(&mut sent, sight, ray, share);
                return sent;
            }
            at = std::array::from_fn(|k| at[k] + to_sphere * ray[k]);
            let cos = dot(ray, at).clamp(0.0, 1.0);
            let square = 1.0 - WATER * WATER * (1.0 - cos * cos);
            if square > 0.0 {
                let cos_out = square.sqrt();
                let mirrored = reflectance_at([cos, cos_out], 1.0 / WATER);
                let leaves =
                    std::array::from_fn(|k| WATER * ray[k] + (cos_out - WATER * cos) * at[k]);
                self.leaves(&mut sent, sight, leaves, share * (1.0 - mirrored));
                share *= mirrored;
            }
            if share < LEAST_SHARE {
                break;
            }
            ray = std::array::from_fn(|k| ray[k] - 2.0 * cos * at[k]);
        }
        sent.lanes[HELD] += share;
        sent
    }

    /// Along a direction before the glass.
    pub(super) fn sight(&self, [x, y, z]: Vector) -> Sight {
        let n = self.from.sheet.index;
        let in_glass = (1.0 - (1.0 - z * z) / (n * n)).sqrt();
        Sight {
            along: [x, y],
            before: self.from.before([x, y, z]),
            passes: 1.0 - reflectance(in_glass, WATER / n),
        }
    }

    /// Light from outside, seen along a direction in the air. Bare glass has taken its outer face's share of what an image
    /// shows, and given the cabin's light for it.
    fn leaves(&self, sent: &mut Sent, sight: &Sight, direction: Vector, share: f64) {
        if direction[2] <= 0.0 {
            // Through the glass beside the drop.
            self.from.cabin(sent, direction, share);
        } else {
            let seen = share * (1.0 + sight.before.reflects) * sight.passes;
            let direction = self.from.sheet.camera_from_sheet(direction);
            self.from.seen(sent, direction, seen);
            sight.before.mirror_cabin(sent, share - seen);
        }
    }

    /// Light that comes through the glass, seen along a direction in the water.
    fn enters_cabin(&self, sent: &mut Sent, sight: &Sight, [x, y, _]: Vector, share: f64) {
        let [x, y] = [WATER * x, WATER * y];
        let square = x * x + y * y;
        if square >= 1.0 {
            // The inner face holds it.
            sent.lanes[HELD] += share;
        } else {
            let z = (1.0 - square).sqrt();
            let face = reflectance(z, self.from.sheet.index);
            let again = share * face * (1.0 - face);
            self.from.cabin(sent, [x, y, -z], share - again);
            self.leaves(sent, sight, [x, y, z], again);
        }
    }
}
