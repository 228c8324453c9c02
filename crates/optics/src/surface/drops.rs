//! Drops of water on the outer face: lenses that show the scene small and upside down.

use std::sync::Arc;

use starbreak_deposit::Cap;

use super::drawn_drop::DrawnDrop;
use super::glimpse::Glimpses;
use super::kept_drops::{Looked, TracedDrop};
use super::lobe::{LANES, LightFrom};
use super::seen_at::SeenAt;
use super::small_drop::SmallDrop;
use super::water::Water;
use crate::maps::{Drawn, Reaches, Reaching};

/// Farthest from the middle, of the radius, that light is followed.
pub(super) const RIM: f64 = 0.995;

/// Least radius of a drop that is drawn, from its middle to its side, px: smaller ones change pictures by less than 0.1 codes in
/// the mean, where there are most.
pub const LEAST_DROP_PX: f64 = 0.12;

/// Drops as they are drawn: those of which parts are seen, and all others.
#[derive(Default)]
pub(crate) struct Drops<'a> {
    traced: Vec<(Reaches, Seeable<'a>)>,
    small: Vec<(Reaches, Seeable<'a>)>,
}

/// A drop that is seen.
pub(super) enum Seeable<'a> {
    Traced(DrawnDrop<'a>),
    Small(SmallDrop),
    /// As it was seen before.
    KeptTraced(Arc<TracedDrop>),
    KeptSmall(Arc<SmallDrop>),
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
        let mut drop_of = |cap: &Cap| {
            let seen = SeenAt::of(cap, from.sheet, reach_px)?;
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
                return Some((small.reaches(), Seeable::Small(small)));
            }
            let drop = Drop::of(*cap, from, seen.enters_mm)?;
            let drawn = DrawnDrop::of(drop, &seen, pupil_reach)?;
            Some((drawn.reaches(), Seeable::Traced(drawn)))
        };
        for (k, cap) in caps.iter().enumerate() {
            drops.extend(match &mut kept {
                Some(kept) => kept.keep(k, cap, || drop_of(cap)),
                None => drop_of(cap),
            });
        }
        if let Some(kept) = kept {
            kept.glimpses = glimpses;
        }
        drops
    }

    fn extend(&mut self, drop: Option<(Reaches, Seeable<'a>)>) {
        match drop {
            None => {}
            Some((_, Seeable::Small(_) | Seeable::KeptSmall(_))) => self.small.extend(drop),
            Some((_, Seeable::Traced(_) | Seeable::KeptTraced(_))) => self.traced.extend(drop),
        }
    }

    /// All, in an order that does not depend on what was kept.
    pub(crate) fn all(&self) -> Vec<Reaching<'_, LANES>> {
        let all = self.traced.iter().chain(&self.small);
        all.map(|(reaches, drop)| (reaches.clone(), drop.drawn()))
            .collect()
    }
}

impl Seeable<'_> {
    fn drawn(&self) -> &dyn Drawn<LANES> {
        match self {
            Self::Traced(drop) => drop,
            Self::Small(drop) => drop,
            Self::KeptTraced(drop) => &**drop,
            Self::KeptSmall(drop) => &**drop,
        }
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
