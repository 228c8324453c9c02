//! What does not depend on where a pane is hit, kept from pane to pane.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::FractureError;

/// Most values of a kind that are kept: those of some recipes at a time, of 10 to 20 MB each.
const MOST: usize = 4;

/// Values that follow from their keys alone, so that no result depends on whether one is kept. The
/// ones that were asked for last stay for the life of the program: a set of images is broken by one
/// recipe.
pub(super) struct Kept<K, V> {
    last_first: Mutex<Vec<(K, Slot<V>)>>,
}

/// A value, once it is made.
type Slot<V> = Arc<Mutex<Option<Arc<V>>>>;

impl<K: PartialEq, V> Kept<K, V> {
    pub(super) const fn new() -> Self {
        Self {
            last_first: Mutex::new(Vec::new()),
        }
    }

    /// The value of a key, which is made where it is not kept. Who asks for it meanwhile waits.
    ///
    /// # Errors
    /// That of `make`, after which nothing is kept.
    pub(super) fn of(
        &self,
        key: K,
        make: impl FnOnce() -> Result<V, FractureError>,
    ) -> Result<Arc<V>, FractureError> {
        let slot = self.slot(key);
        let mut value = locked(&slot);
        if let Some(value) = &*value {
            return Ok(Arc::clone(value));
        }
        let made = Arc::new(make()?);
        *value = Some(Arc::clone(&made));
        Ok(made)
    }

    fn slot(&self, key: K) -> Slot<V> {
        let mut all = locked(&self.last_first);
        let known = all.iter().position(|(known, _)| *known == key);
        let entry = known.map_or_else(|| (key, Slot::default()), |at| all.remove(at));
        let slot = Arc::clone(&entry.1);
        all.truncate(MOST - 1);
        all.insert(0, entry);
        slot
    }
}

/// A lock under which nothing is ever left half done.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_until_others_take_its_place() {
        let kept = Kept::<u8, u8>::new();
        let mut n_made = 0;
        let mut ask = |key: u8| {
            let value = kept.of(key, || {
                n_made += 1;
                Ok(10 * key)
            });
            assert_eq!(*value.unwrap(), 10 * key);
            n_made
        };
        assert_eq!(ask(1), 1);
        assert_eq!(ask(1), 1, "kept");
        assert_eq!([2, 3, 4].map(&mut ask), [2, 3, 4]);
        assert_eq!(ask(1), 4, "kept beside three others");
        assert_eq!(ask(5), 5);
        assert_eq!(ask(1), 5, "asked for after the second");
        assert_eq!(ask(2), 6, "the one that was not asked for the longest");
    }

    #[test]
    fn what_fails_is_made_again() {
        let kept = Kept::<u8, u8>::new();
        let failed = kept.of(1, || {
            Err(FractureError::Solver {
                cause: "made up".to_owned(),
            })
        });
        assert!(failed.is_err());
        assert_eq!(*kept.of(1, || Ok(7)).unwrap(), 7);
    }
}
