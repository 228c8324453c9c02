//! What the frames of a clip leave for those that come.

use std::sync::{Arc, Mutex, PoisonError};

use starbreak_deposit::{Area, Coat, Deposit, Rain, Shower};
use starbreak_optics::physical::KeptDrops;
use starbreak_optics::screens::Screen;
use starbreak_seed::Seed;

/// What was found for the last ages of a chain. Nothing depends on it: it only spares finding it again. Frames of a clip
/// that are worked on side by side share it.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// That since a wiper passed last, and before.
    rain: Mutex<Vec<Shower>>,
    pub(super) drops: KeptDrops,
    /// Coats as old as they were last, with the seed that placed them, and how frames show each.
    coats: Mutex<Vec<(Coat, Seed, Arc<Screen>)>>,
}

impl Kept {
    /// What lies on an area of the pane, found from what lay there shortly before.
    pub(super) fn rain(&self, rain: &Rain, area: &Area, seed: Seed) -> Deposit {
        let mut kept = self.rain.lock().unwrap_or_else(PoisonError::into_inner);
        let place = kept.iter().position(|it| it.is_of(rain, area, seed));
        let known = place.map(|place| kept.remove(place));
        let mut shower = known.unwrap_or_else(|| Shower::of(*rain, *area, seed));
        let deposit = shower.at(rain.age_s);
        kept.truncate(1);
        kept.insert(0, shower);
        deposit
    }

    /// How frames show coats that grow; those are found that are not as they were last.
    pub(super) fn coats<E>(
        &self,
        coats: &[Coat],
        seed: Seed,
        find: impl FnOnce(&[Coat]) -> Result<Vec<Screen>, E>,
    ) -> Result<Vec<Arc<Screen>>, E> {
        let lock = || self.coats.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().clone();
        let screen_of = |coat: &Coat| {
            let kept = known.iter().find(|(of, by, _)| (of, *by) == (coat, seed));
            kept.map(|(.., screen)| Arc::clone(screen))
        };
        let new = coats.iter().filter(|coat| screen_of(coat).is_none());
        let new: Vec<Coat> = new.copied().collect();
        // Found while others may be, too, and without holding up those whose coats are known.
        let mut found = find(&new)?.into_iter().map(Arc::new);
        let all = coats.iter().filter_map(|coat| {
            let screen = screen_of(coat).or_else(|| found.next())?;
            Some((*coat, seed, screen))
        });
        let all: Vec<(Coat, Seed, Arc<Screen>)> = all.collect();
        let screens = all.iter().map(|(.., screen)| Arc::clone(screen)).collect();
        if !new.is_empty() {
            *lock() = all;
        }
        Ok(screens)
    }
}
