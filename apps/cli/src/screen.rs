//! What the user sees: results on standard output, everything else on standard error.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use serde_json::Value;

use crate::failure::Failure;

/// Plain progress lines are this far apart where there is no terminal.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// A path as text for people and JSON; what is not Unicode becomes a replacement character.
pub(crate) fn path_text(path: impl AsRef<Path>) -> String {
    path.as_ref().to_string_lossy().into_owned()
}

/// What a program that calls is told.
#[derive(Debug, Clone)]
pub enum Event {
    /// What was done, for people.
    Say(String),
    /// A warning or a remark.
    Note(String),
    /// So many of `total` items called `what` are done; `total` is 0 where it is not known.
    Progress {
        /// Items done.
        done: u64,
        /// All items.
        total: u64,
        /// What they are called.
        what: &'static str,
    },
}

/// A program that calls the command, in place of a terminal.
pub(crate) struct Caller {
    pub(crate) tell: Box<dyn Fn(Event) + Send + Sync>,
    pub(crate) stop: Arc<AtomicBool>,
    pub(crate) result: Mutex<Option<String>>,
}

/// Where text goes: to standard output and error by `--json` and `--quiet`, or to a program that calls.
#[derive(Clone)]
pub(crate) struct Screen {
    json: bool,
    quiet: bool,
    caller: Option<Arc<Caller>>,
}

impl Screen {
    pub(crate) fn new(json: bool, quiet: bool) -> Self {
        Self {
            json,
            quiet,
            caller: None,
        }
    }

    pub(crate) fn of_caller(caller: Arc<Caller>, quiet: bool) -> Self {
        Self {
            json: true,
            quiet,
            caller: Some(caller),
        }
    }

    /// What a program that calls sets to stop the work.
    pub(crate) fn stop(&self) -> Option<Arc<AtomicBool>> {
        self.caller.as_ref().map(|caller| Arc::clone(&caller.stop))
    }

    /// Text for people: on standard output, or on standard error beside `--json`; not at all
    /// with `--quiet`.
    pub(crate) fn say(&self, text: &str) {
        if self.quiet {
            return;
        }
        // Whoever closed the pipe does not want to hear about it.
        let _ = match &self.caller {
            Some(caller) => {
                (caller.tell)(Event::Say(text.to_owned()));
                Ok(())
            }
            None if self.json => writeln!(std::io::stderr(), "{text}"),
            None => writeln!(std::io::stdout(), "{text}"),
        };
    }

    /// A remark that is no result: on standard error, not with `--quiet`.
    pub(crate) fn note(&self, text: &str) {
        match &self.caller {
            _ if self.quiet => {}
            Some(caller) => (caller.tell)(Event::Note(text.to_owned())),
            None => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
        }
    }

    /// The one machine-readable result, if asked for.
    ///
    /// # Errors
    /// As for [`Screen::data`].
    pub(crate) fn result(&self, value: impl FnOnce() -> Value) -> Result<(), Failure> {
        if self.json {
            self.data(&value().to_string())
        } else {
            Ok(())
        }
    }

    /// The one machine-readable result, if asked for, on standard error, where standard output has frames.
    pub(crate) fn result_beside(&self, value: impl FnOnce() -> Value) {
        if self.json {
            let _ = writeln!(std::io::stderr(), "{}", value());
        }
    }

    /// Data that was asked for: on standard output, always.
    ///
    /// # Errors
    /// If it could not be written, except that the reader went away.
    pub(crate) fn data(&self, text: &str) -> Result<(), Failure> {
        if let Some(caller) = &self.caller {
            if let Ok(mut result) = caller.result.lock() {
                *result = Some(text.to_owned());
            }
            return Ok(());
        }
        let mut stdout = std::io::stdout().lock();
        let end = if text.ends_with('\n') { "" } else { "\n" };
        let written = write!(stdout, "{text}{end}").and_then(|()| stdout.flush());
        match written {
            Err(cause) if cause.kind() != ErrorKind::BrokenPipe => Err(Failure::wrong_input(
                format!("standard output cannot be written: {cause}"),
            )),
            _ => Ok(()),
        }
    }

    /// An error, in one place, once.
    pub(crate) fn error(&self, message: &str) {
        let _ = writeln!(std::io::stderr(), "error: {message}");
    }

    /// Progress over `total` items called `what`.
    pub(crate) fn progress(&self, total: u64, what: &'static str) -> Progress {
        let terminal = std::io::stderr().is_terminal();
        let bar = if self.quiet || self.caller.is_some() || !terminal || total < 2 {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(total)
        };
        if let Ok(style) =
            ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}  {rate_and_time_left}")
        {
            bar.set_style(style.with_key("rate_and_time_left", rate_and_time_left));
        }
        bar.set_message(what);
        Progress {
            bar,
            plain: !self.quiet && !terminal && self.caller.is_none(),
            screen: self.clone(),
            total,
            what,
            counts: Mutex::new(Counts {
                n_done: 0,
                n_skipped: 0,
                began: Instant::now(),
                written: Instant::now(),
            }),
        }
    }
}

/// A bar with rate and time left on a terminal, a line now and then elsewhere.
pub(crate) struct Progress {
    bar: ProgressBar,
    screen: Screen,
    plain: bool,
    total: u64,
    what: &'static str,
    counts: Mutex<Counts>,
}

struct Counts {
    /// Items done or skipped.
    n_done: u64,
    n_skipped: u64,
    /// Since when those are done that are not skipped.
    began: Instant,
    /// When the last plain line was written.
    written: Instant,
}

/// Nothing before the first item is done.
fn rate_and_time_left(state: &ProgressState, to: &mut dyn std::fmt::Write) {
    let rate = state.per_sec();
    if rate > 0.0 {
        let left = HumanDuration(state.eta());
        let _ = write!(to, "{rate:.1} per second, {left:#} left");
    }
}

impl Progress {
    /// One more item is done.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
        let Ok(mut counts) = self.counts.lock() else {
            return;
        };
        counts.n_done += 1;
        self.tell_caller(&counts);
        if self.plain && counts.written.elapsed() >= PLAIN_INTERVAL {
            counts.written = Instant::now();
            let n_made = counts.n_done - counts.n_skipped;
            #[expect(clippy::cast_precision_loss, reason = "counts, for a rate")]
            let rate = n_made as f64 / counts.began.elapsed().as_secs_f64();
            let (n_done, what) = (counts.n_done, self.what);
            // Where the number is not known before, it is 0.
            let of_total = self.total.checked_sub(n_done).map(|n_left| {
                #[expect(clippy::cast_precision_loss, reason = "counts, for a time")]
                let seconds = n_left as f64 / rate;
                (format!("/{}", self.total), format!(", {seconds:.0} s left"))
            });
            let (total, left) = of_total.unwrap_or_default();
            let _ = writeln!(
                std::io::stderr(),
                "{n_done}{total} {what}, {rate:.1} per second{left}"
            );
        }
    }

    /// So many items were done before, in no time.
    pub(crate) fn skip(&self, n: u64) {
        self.bar.inc(n);
        self.bar.reset_eta();
        if let Ok(mut counts) = self.counts.lock() {
            counts.n_done += n;
            counts.n_skipped += n;
            counts.began = Instant::now();
            self.tell_caller(&counts);
        }
    }

    fn tell_caller(&self, counts: &Counts) {
        if let Some(caller) = &self.screen.caller {
            (caller.tell)(Event::Progress {
                done: counts.n_done,
                total: self.total,
                what: self.what,
            });
        }
    }

    /// Writes a line above the bar.
    pub(crate) fn line(&self, text: &str) {
        self.bar.suspend(|| match &self.screen.caller {
            Some(caller) => (caller.tell)(Event::Note(text.to_owned())),
            None => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
        });
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
