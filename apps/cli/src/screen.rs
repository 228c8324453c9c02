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
        let counts = Arc::new(Mutex::new(Counts {
            n_done: 0,
            n_skipped: 0,
            total,
            began: Instant::now(),
            written: Instant::now(),
        }));
        let counted = Arc::clone(&counts);
        let rate = move |_: &ProgressState, to: &mut dyn std::fmt::Write| {
            if let Some(rate) = counted.lock().ok().and_then(|counts| counts.rate()) {
                let _ = to.write_str(&rate);
            }
        };
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}{rate}") {
            bar.set_style(style.with_key("rate", rate));
        }
        bar.set_message(what);
        Progress {
            bar,
            plain: !self.quiet && !terminal && self.caller.is_none(),
            screen: self.clone(),
            what,
            counts,
        }
    }
}

/// A bar with rate and time left on a terminal, a line now and then elsewhere.
pub(crate) struct Progress {
    bar: ProgressBar,
    screen: Screen,
    plain: bool,
    what: &'static str,
    counts: Arc<Mutex<Counts>>,
}

struct Counts {
    /// Items done or skipped.
    n_done: u64,
    n_skipped: u64,
    /// Where it is not known before, 0.
    total: u64,
    /// Since when those are done that are not skipped.
    began: Instant,
    /// When the last plain line was written.
    written: Instant,
}

impl Counts {
    /// How many are done in a second, and how long it takes until all are; none before the first is done.
    #[expect(clippy::cast_precision_loss, reason = "counts, for a rate")]
    fn rate(&self) -> Option<String> {
        let n_done = self.n_done - self.n_skipped;
        let rate = n_done as f64 / self.began.elapsed().as_secs_f64();
        let left = self.total.checked_sub(self.n_done).map(|n_left| {
            let seconds = Duration::try_from_secs_f64(n_left as f64 / rate).unwrap_or_default();
            format!(", {} left", HumanDuration(seconds))
        });
        (n_done > 0).then(|| format!(", {rate:.1} per second{}", left.unwrap_or_default()))
    }
}

impl Progress {
    /// One more item is done.
    pub(crate) fn step(&self) {
        let Ok(mut counts) = self.counts.lock() else {
            return;
        };
        counts.n_done += 1;
        self.tell_caller(&counts);
        if self.plain && counts.written.elapsed() >= PLAIN_INTERVAL {
            counts.written = Instant::now();
            let (n_done, what) = (counts.n_done, self.what);
            let total = match counts.total.checked_sub(n_done) {
                Some(_) => format!("/{}", counts.total),
                None => String::new(),
            };
            let rate = counts.rate().unwrap_or_default();
            let _ = writeln!(std::io::stderr(), "{n_done}{total} {what}{rate}");
        }
        // The bar shows the rate, for which it reads the counts.
        drop(counts);
        self.bar.inc(1);
    }

    /// So many items were done before: they count in no rate.
    pub(crate) fn skip(&self, n: u64) {
        if let Ok(mut counts) = self.counts.lock() {
            counts.n_done += n;
            counts.n_skipped += n;
            counts.began = Instant::now();
            self.tell_caller(&counts);
        }
        self.bar.inc(n);
    }

    fn tell_caller(&self, counts: &Counts) {
        if let Some(caller) = &self.screen.caller {
            (caller.tell)(Event::Progress {
                done: counts.n_done,
                total: counts.total,
                what: self.what,
            });
        }
    }

    /// Writes a remark above the bar.
    pub(crate) fn note(&self, text: &str) {
        self.bar.suspend(|| self.screen.note(text));
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
