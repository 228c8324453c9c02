//! The `starbreak` command: parse, call the libraries, show. The program is [`main`]; a program in another language,
//! as the Python package, has the same verbs through [`call`].

mod args;
mod commands;
mod failure;
mod interrupt;
mod screen;

use std::ffi::OsString;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use clap::error::ErrorKind;
use serde_json::Value;

pub use failure::Failure;
pub use screen::Event;
use screen::{Caller, Screen};

/// Runs a command line, the program's name first, on standard output and error, and gives the exit code.
///
/// It listens for Ctrl-C, so it is for a process whose whole work this is.
pub fn main(words: impl IntoIterator<Item = OsString>) -> u8 {
    starbreak_dataset::silence_fenced_panics();
    let args = match args::parse(words) {
        Ok(args) => args,
        Err(error) => return usage(&error),
    };
    let screen = Screen::new(args.global.json, args.global.quiet);
    match commands::run(args, &screen) {
        Ok(code) => code,
        Err(failure) => refuse(&screen, &failure),
    }
}

/// Runs a command line, the program's name first, for a program that calls: nothing is printed, `tell` gets what
/// would be, and setting `stop` ends the work as Ctrl-C does, where the verb listens for it. Gives what `--json`
/// prints, `null` where the verb prints nothing. Records of what was made have the command line `recorded`.
///
/// # Errors
/// [`Failure`] where the command line is wrong or the work stopped. Where some items failed (exit code 1) and there
/// is a result, that is given, and the failure is told as a note.
pub fn call(
    words: impl IntoIterator<Item = OsString>,
    recorded: impl IntoIterator<Item = OsString>,
    stop: Arc<AtomicBool>,
    tell: impl Fn(Event) + Send + Sync + 'static,
) -> Result<Value, Failure> {
    starbreak_dataset::silence_fenced_panics();
    let mut args = args::parse(words).map_err(|error| Failure::wrong_input(in_one_line(&error)))?;
    args.global.command = args::as_typed(recorded);
    let quiet = args.global.quiet;
    let caller = Arc::new(Caller {
        tell: Box::new(tell),
        stop,
        result: Mutex::new(None),
    });
    let screen = Screen::of_caller(Arc::clone(&caller), quiet);
    let ended = commands::run(args, &screen);
    let result = caller
        .result
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    let value = result.map(|text| serde_json::from_str(&text).unwrap_or(Value::String(text)));
    match (ended, value) {
        (Ok(_), value) => Ok(value.unwrap_or_default()),
        (Err(failure), Some(value)) if failure.code == failure::SOME_FAILED => {
            screen.note(&format!("warning: {}", failure.message));
            Ok(value)
        }
        (Err(failure), _) => Err(failure),
    }
}

fn refuse(screen: &Screen, failure: &Failure) -> u8 {
    screen.error(&failure.message);
    failure.code
}

/// Help and version as asked for; anything else as one line like every other error.
fn usage(error: &clap::Error) -> u8 {
    let asked_for = [
        ErrorKind::DisplayHelp,
        ErrorKind::DisplayVersion,
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
    ];
    if asked_for.contains(&error.kind()) {
        // Whoever closed the pipe does not want to hear about it.
        let _ = error.print();
        return u8::try_from(error.exit_code()).unwrap_or(failure::WRONG_INPUT);
    }
    let message = format!("{}; see starbreak --help", in_one_line(error));
    refuse(&Screen::new(false, false), &Failure::wrong_input(message))
}

/// Possible values up to so many characters stand in a message.
const MOST_VALUES: usize = 200;

fn in_one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said = text
        .split("\n\nUsage:")
        .next()
        .and_then(|said| said.split("\n\nFor more").next())
        .unwrap_or(&text);
    // Names that a shell completes are too many for a line.
    let said = match said.split_once("\n  [possible values:") {
        Some((said, values)) if values.len() > MOST_VALUES => said,
        _ => said,
    };
    let said = said.replace("\n\n  tip: ", "; tip: ");
    let words: Vec<&str> = said
        .trim_start_matches("error: ")
        .split_whitespace()
        .collect();
    words.join(" ")
}
