//! The verbs of the command, in this process.

use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use serde_json::Value;
use starbreak_command::{Event, Failure};

use crate::errors::SimulationError;
use crate::values::python_of;

/// Signals are looked for, and progress is told, this often.
const EACH: Duration = Duration::from_millis(50);

/// What the thread that works sends.
enum Message {
    Event(Event),
    Done(Result<Value, Failure>),
}

/// Runs a command line as the program `starbreak` does, and gives the exit code.
#[pyfunction]
pub(crate) fn _run(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| starbreak_command::main(words))
}

/// Runs a command line and gives its result; `tell` is called with kind and text of what would be printed, and with
/// "progress", items done, all items and what they are called.
#[pyfunction]
pub(crate) fn _call<'py>(
    py: Python<'py>,
    words: Vec<OsString>,
    tell: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = channel();
    let receiver = Mutex::new(receiver);
    let worker = {
        let (stop, told) = (Arc::clone(&stop), sender.clone());
        thread::spawn(move || {
            let tell = move |event| {
                // Whoever no longer listens has been interrupted.
                let _ = told.send(Message::Event(event));
            };
            let _ = sender.send(Message::Done(starbreak_command::call(words, stop, tell)));
        })
    };
    let mut interruption = None;
    let mut last = Instant::now();
    let done = loop {
        let message = py.detach(|| {
            let receiver = receiver.lock().unwrap_or_else(PoisonError::into_inner);
            receiver.recv_timeout(EACH)
        });
        let heard = match message {
            Ok(Message::Done(done)) => break Some(done),
            Ok(Message::Event(Event::Say(text))) => tell.call1(("say", text)).map(drop),
            Ok(Message::Event(Event::Note(text))) => tell.call1(("note", text)).map(drop),
            Ok(Message::Event(Event::Progress { done, total, what })) => {
                let is_last = done == total;
                if is_last || last.elapsed() >= EACH {
                    last = Instant::now();
                    tell.call1(("progress", done, total, what)).map(drop)
                } else {
                    Ok(())
                }
            }
            Err(RecvTimeoutError::Timeout) => Ok(()),
            // The thread has panicked.
            Err(RecvTimeoutError::Disconnected) => break None,
        };
        if let Err(error) = heard.and_then(|()| py.check_signals())
            && interruption.is_none()
        {
            // What has begun is finished first, so that nothing is left half-written.
            stop.store(true, Ordering::Relaxed);
            interruption = Some(error);
        }
    };
    let joined = py.detach(|| worker.join());
    if let Some(error) = interruption {
        return Err(error);
    }
    let Some(done) = done.filter(|_| joined.is_ok()) else {
        return Err(SimulationError::new_err("the command has panicked"));
    };
    match done {
        Ok(value) => python_of(py, &value),
        Err(Failure { message, code }) => Err(match code {
            2 => PyValueError::new_err(message),
            130 => PyKeyboardInterrupt::new_err(message),
            _ => SimulationError::new_err(message),
        }),
    }
}
