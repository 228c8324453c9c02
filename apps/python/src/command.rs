//! The verbs of the command, in this process.

use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use serde_json::Value;
use starbreak_command::{Event, Failure};

use crate::errors::SimulationError;
use crate::values::python_of;

/// Signals are looked for this often where nothing is told.
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

/// Runs a command line, which records show as `recorded`, and gives its result; `tell` is called with kind and text
/// of what would be printed, and with "progress", items done, all items and what they are called.
#[pyfunction]
pub(crate) fn _call<'py>(
    py: Python<'py>,
    words: Vec<OsString>,
    recorded: Vec<OsString>,
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
            let _ = sender.send(Message::Done(starbreak_command::call(
                words, recorded, stop, tell,
            )));
        })
    };
    let told = |event| match event {
        Event::Say(text) => tell.call1(("say", text)),
        Event::Note(text) => tell.call1(("note", text)),
        Event::Progress { done, total, what } => tell.call1(("progress", done, total, what)),
    };
    let mut interruption = None;
    let done = loop {
        let message = py.detach(|| {
            let receiver = receiver.lock().unwrap_or_else(PoisonError::into_inner);
            receiver.recv_timeout(EACH)
        });
        let event = match message {
            Ok(Message::Done(done)) => break Some(done),
            Ok(Message::Event(event)) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            // The thread has panicked.
            Err(RecvTimeoutError::Disconnected) => break None,
        };
        if interruption.is_some() {
            // Whoever asks twice does not want to wait; what is under way ends by itself.
            py.check_signals()?;
        } else if let Err(error) = event
            .map_or(Ok(()), |event| told(event).map(drop))
            .and_then(|()| py.check_signals())
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
