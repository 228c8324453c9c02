//! Ctrl-C: finish what is begun, begin nothing more, leave nothing half-written.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use crate::failure::{Failure, INTERRUPTED};
use crate::screen::Screen;

/// The flag of this process, whose signals have one listener.
static OF_PROCESS: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Set once the user has asked to stop.
#[derive(Debug, Clone)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens for Ctrl-C and termination from now on; the second time the process ends at once. In a
    /// program that calls, whose signals are its own, it is the flag that came with the call.
    pub(crate) fn listen(screen: &Screen) -> Self {
        if let Some(flag) = screen.stop() {
            return Self(flag);
        }
        let flag = OF_PROCESS.get_or_init(|| {
            let flag = Arc::new(AtomicBool::new(false));
            let seen = Arc::clone(&flag);
            // A system without signals cannot be interrupted this way; that is no reason to fail.
            let _ = ctrlc::set_handler(move || {
                // Whoever asks twice does not want to wait; what is in its place is whole.
                if seen.swap(true, Ordering::Relaxed) {
                    std::process::exit(i32::from(INTERRUPTED));
                }
            });
            flag
        });
        Self(Arc::clone(flag))
    }

    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Stops a run that has written nothing yet.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.is_set() {
            return Err(Failure::interrupted(
                "interrupted: nothing was written; run the command again",
            ));
        }
        Ok(())
    }

    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.0
    }
}
