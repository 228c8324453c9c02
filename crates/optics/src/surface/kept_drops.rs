//! Drops that lie there frame after frame.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use starbreak_deposit::Cap;

use super::drops::Seeable;
use super::glimpse::Glimpses;
use super::lobe::LANES;
use super::params::Glass;
use super::small_drop::SmallDrop;
use crate::View;
use crate::environment::EnvironmentParams;
use crate::lens::Lens;
use crate::maps::Drawn;

/// Most cells that are kept, of 52 bytes each.
const MOST_CELLS: usize = 1 << 21;

/// Among so many drops of the last frame one is looked for, from where the one before it was.
const LOOKED_AT: usize = 8;

/// All that what is seen through a drop depends on, beside the drop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeenBy {
    pub(crate) view: View,
    pub(crate) lens: Lens,
    pub(crate) glass: Glass,
    pub(crate) environment: EnvironmentParams,
}

/// What is seen through the drops of the last frame of a camera, for those that come: most drops of rain lie where they lay,
/// and keep their order. Pictures do not depend on it; they are made in less time. Up to 110 MB of memory.
///
/// One serves frames that are worked on side by side. For another camera or other optics it begins anew.
#[derive(Debug, Default)]
pub struct KeptDrops(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    by: Option<SeenBy>,
    drops: Vec<(Cap, Arc<Shown>)>,
    glimpses: Vec<(u64, Arc<Glimpses>)>,
}

/// What is seen of a drop.
#[derive(Debug)]
pub(super) enum Shown {
    Nothing,
    Small(SmallDrop),
    Traced(TracedDrop),
}

impl Shown {
    fn n_cells(&self) -> usize {
        match self {
            Self::Traced(traced) => traced.cells.len(),
            Self::Small(_) | Self::Nothing => 0,
        }
    }
}

/// What was known of the drops of a frame, and what is found.
#[derive(Debug)]
pub(crate) struct Looked {
    /// Of each, in their order.
    pub(super) known: Vec<Option<Arc<Shown>>>,
    pub(super) glimpses: Vec<(u64, Arc<Glimpses>)>,
    /// Cells for which there is room.
    room: usize,
    found: Vec<(Cap, Arc<Shown>)>,
}

impl Looked {
    /// Keeps what is seen of a drop, if there is room for it.
    pub(super) fn keep<'a>(&mut self, cap: &Cap, drop: Option<Seeable<'a>>) -> Option<Seeable<'a>> {
        let shown = match drop {
            None => Arc::new(Shown::Nothing),
            Some(Seeable::Kept(shown)) => shown,
            Some(Seeable::Small(small)) => Arc::new(Shown::Small(small)),
            Some(Seeable::Traced(_)) if self.room == 0 => return drop,
            Some(Seeable::Traced(drawn)) => Arc::new(Shown::Traced(TracedDrop::of(&drawn))),
        };
        self.room = self.room.saturating_sub(shown.n_cells());
        self.found.push((*cap, Arc::clone(&shown)));
        Some(Seeable::Kept(shown))
    }
}

impl KeptDrops {
    /// Looks for drops that are seen by a camera.
    pub(crate) fn look_for(&self, caps: &[Cap], by: SeenBy) -> Looked {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.by != Some(by) {
            *known = Known {
                by: Some(by),
                ..Known::default()
            };
        }
        let (mut next, mut n_missed) = (0, 0);
        let look = |cap: &Cap| {
            let mut rest = known.drops[next..].iter().take(LOOKED_AT);
            let Some(place) = rest.position(|(known, _)| known == cap) else {
                // Where as many have gone, on behind them.
                n_missed += 1;
                if n_missed == LOOKED_AT {
                    n_missed = 0;
                    next = known.drops.len().min(next + LOOKED_AT);
                }
                return None;
            };
            n_missed = 0;
            next += place + 1;
            Some(Arc::clone(&known.drops[next - 1].1))
        };
        Looked {
            known: caps.iter().map(look).collect(),
            glimpses: known.glimpses.clone(),
            room: MOST_CELLS,
            found: Vec::with_capacity(caps.len()),
        }
    }

    /// Keeps what was found, unless another camera has looked since.
    pub(crate) fn keep(&self, looked: Looked, by: SeenBy) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.by == Some(by) {
            known.drops = looked.found;
            known.glimpses = looked.glimpses;
        }
    }
}

/// A drop with all cells that it covers.
#[derive(Debug)]
pub(super) struct TracedDrop {
    blur_px: f64,
    rows: Range<i32>,
    /// Where the cells of each row end.
    ends: Vec<usize>,
    cells: Vec<(i32, [f32; LANES])>,
}

impl TracedDrop {
    fn of(drawn: &dyn Drawn<LANES>) -> Self {
        let mut cells = Vec::new();
        let ends = drawn.rows().map(|row| {
            drawn.row(row, &mut |column, lanes| cells.push((column, lanes)));
            cells.len()
        });
        let ends = ends.collect();
        cells.shrink_to_fit();
        Self {
            blur_px: drawn.radius_px(),
            rows: drawn.rows(),
            ends,
            cells,
        }
    }
}

impl Drawn<LANES> for TracedDrop {
    fn radius_px(&self) -> f64 {
        self.blur_px
    }

    fn rows(&self) -> Range<i32> {
        self.rows.clone()
    }

    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        let place = usize::try_from(row - self.rows.start).ok();
        let Some((place, end)) = place.and_then(|at| Some((at, *self.ends.get(at)?))) else {
            return;
        };
        let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        for (column, lanes) in &self.cells[start..end] {
            add(*column, *lanes);
        }
    }
}
