//! Drops that lie there frame after frame.

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
use crate::maps::{Drawn, Reaches};

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
    drops: Vec<(Cap, Shown)>,
    glimpses: Vec<(u64, Arc<Glimpses>)>,
}

/// What is seen of a drop.
#[derive(Debug, Clone)]
enum Shown {
    Nothing,
    Small(Reaches, Arc<SmallDrop>),
    Traced(Reaches, Arc<TracedDrop>),
}

impl Shown {
    fn n_cells(&self) -> usize {
        match self {
            Self::Traced(_, traced) => traced.cells.len(),
            Self::Small(..) | Self::Nothing => 0,
        }
    }

    fn seeable<'a>(self) -> Option<(Reaches, Seeable<'a>)> {
        match self {
            Self::Nothing => None,
            Self::Small(reaches, small) => Some((reaches, Seeable::KeptSmall(small))),
            Self::Traced(reaches, traced) => Some((reaches, Seeable::KeptTraced(traced))),
        }
    }
}

/// What was known of the drops of a frame, and what is found.
#[derive(Debug)]
pub(crate) struct Looked {
    /// Of each, in their order.
    known: Vec<Option<Shown>>,
    pub(super) glimpses: Vec<(u64, Arc<Glimpses>)>,
    /// Cells for which there is room.
    room: usize,
    found: Vec<(Cap, Shown)>,
}

impl Looked {
    /// What is seen of the k-th drop: as it is known, or else as it is found, and then it is kept if there is room for it.
    pub(super) fn keep<'a>(
        &mut self,
        k: usize,
        cap: &Cap,
        find: impl FnOnce() -> Option<(Reaches, Seeable<'a>)>,
    ) -> Option<(Reaches, Seeable<'a>)> {
        let shown = match self.known[k].take() {
            Some(shown) => shown,
            None => match find() {
                None => Shown::Nothing,
                Some((reaches, Seeable::Small(small))) => Shown::Small(reaches, Arc::new(small)),
                Some((reaches, Seeable::Traced(drawn))) if self.room > 0 => {
                    let traced = TracedDrop::of(&reaches, &drawn);
                    Shown::Traced(reaches, Arc::new(traced))
                }
                drop => return drop,
            },
        };
        self.room = self.room.saturating_sub(shown.n_cells());
        self.found.push((*cap, shown.clone()));
        shown.seeable()
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
            Some(known.drops[next - 1].1.clone())
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
    first_row: i32,
    /// Where the cells of each row end.
    ends: Vec<usize>,
    cells: Vec<(i32, [f32; LANES])>,
}

impl TracedDrop {
    fn of(reaches: &Reaches, drawn: &dyn Drawn<LANES>) -> Self {
        let mut cells = Vec::new();
        let ends = reaches.rows.clone().map(|row| {
            drawn.row(row, &mut |column, lanes| cells.push((column, lanes)));
            cells.len()
        });
        let ends = ends.collect();
        cells.shrink_to_fit();
        Self {
            first_row: reaches.rows.start,
            ends,
            cells,
        }
    }
}

impl Drawn<LANES> for TracedDrop {
    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        let place = usize::try_from(row - self.first_row).ok();
        let Some((place, end)) = place.and_then(|at| Some((at, *self.ends.get(at)?))) else {
            return;
        };
        let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        for (column, lanes) in &self.cells[start..end] {
            add(*column, *lanes);
        }
    }
}
