//! Other people's code, whose panics are no more than errors here.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static IS_FENCED: Cell<bool> = const { Cell::new(false) };
}

/// What `work` gives, or nothing where it panicked: for decoders that others wrote, of which a
/// broken file shall not end the program.
///
/// What `work` changes outside of itself may be half done after a panic; give it only what is
/// dropped then.
pub fn fence<T>(work: impl FnOnce() -> T) -> Option<T> {
    let outside = IS_FENCED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    IS_FENCED.set(outside);
    result.ok()
}

/// From now on panics inside of a [`fence`] are not printed; all others are, as before.
///
/// For programs, once at their start: the hook for panics is that of the whole process.
pub fn silence_fenced_panics() {
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        // A thread whose variables are gone is in no fence.
        if !IS_FENCED.try_with(Cell::get).unwrap_or(false) {
            before(info);
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_stays_inside_and_what_is_outside_is_not_fenced() {
        assert_eq!(fence(|| 3), Some(3), "work that ends well");
        let inner = fence(|| {
            assert_eq!(fence(|| -> u8 { panic!("of a test") }), None, "inside");
            IS_FENCED.get()
        });
        assert_eq!(inner, Some(true), "still in the outer fence");
        assert!(!IS_FENCED.get(), "outside again");
    }
}
