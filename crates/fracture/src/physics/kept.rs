//! What does not depend on where a pane is hit, kept from pane to pane.

use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use crate::FractureError;

/// Values that follow from their keys alone, so that no result depends on whether one is kept. Those
/// that were asked for last stay for the life of the program: a set of images is broken by one recipe.
///
/// Nobody waits: where another thread is at the list at this very moment, or was when the process
/// was forked, a value is made and not kept; threads that begin together make their own.
pub(super) struct Kept<V> {
    most: usize,
    last_first: Mutex<Values<V>>,
}

/// Values by their keys, as they are written.
type Values<V> = Vec<(String, Arc<V>)>;

impl<V> Kept<V> {
    /// Room for so many values.
    pub(super) const fn new(most: usize) -> Self {
        Self {
            most,
            last_first: Mutex::new(Vec::new()),
        }
    }

    /// The value of a key, which is made where it is not kept. Keys are one if they are written
    /// alike, which tells every number from every other, and 0 from -0.
    ///
    /// # Errors
    /// That of `make`, after which nothing is kept.
    pub(super) fn of(
        &self,
        key: &impl Debug,
        make: impl FnOnce() -> Result<V, FractureError>,
    ) -> Result<Arc<V>, FractureError> {
        let key = format!("{key:?}");
        let place = |all: &[(String, Arc<V>)]| all.iter().position(|(known, _)| *known == key);
        if let Some(mut all) = self.list()
            && let Some(at) = place(&all)
        {
            all[..=at].rotate_right(1);
            return Ok(Arc::clone(&all[0].1));
        }
        let made = Arc::new(make()?);
        if let Some(mut all) = self.list()
            && place(&all).is_none()
        {
            all.truncate(self.most - 1);
            all.insert(0, (key, Arc::clone(&made)));
        }
        Ok(made)
    }

    /// The list, unless another thread has it. Nothing in it is ever half done.
    fn list(&self) -> Option<MutexGuard<'_, Values<V>>> {
        match self.last_first.try_lock() {
            Ok(list) => Some(list),
            Err(TryLockError::Poisoned(list)) => Some(list.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_until_others_take_its_place() {
        let kept = Kept::<u8>::new(4);
        let mut n_made = 0;
        let mut ask = |key: u8| {
            let value = kept.of(&key, || {
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
    fn a_sign_of_zero_is_told() {
        let kept = Kept::<f64>::new(4);
        for zero in [0.0_f64, -0.0, 0.0] {
            let value = kept.of(&[zero], || Ok(zero)).unwrap();
            assert_eq!(value.to_bits(), zero.to_bits());
        }
    }

    #[test]
    fn what_fails_is_made_again_and_takes_no_place() {
        let kept = Kept::<u8>::new(1);
        assert_eq!(*kept.of(&2, || Ok(20)).unwrap(), 20);
        let failed = kept.of(&1, || {
            Err(FractureError::Solver {
                cause: "made up".to_owned(),
            })
        });
        assert!(failed.is_err());
        assert_eq!(*kept.of(&2, || Ok(0)).unwrap(), 20, "still kept");
        assert_eq!(*kept.of(&1, || Ok(7)).unwrap(), 7);
    }

    #[test]
    fn nobody_waits_for_a_list_that_another_has() {
        let kept = Kept::<u8>::new(4);
        assert_eq!(*kept.of(&1, || Ok(10)).unwrap(), 10);
        let held = kept.last_first.lock().unwrap();
        assert_eq!(*kept.of(&1, || Ok(11)).unwrap(), 11, "made, not kept");
        drop(held);
        assert_eq!(*kept.of(&1, || Ok(12)).unwrap(), 10);
    }
}
