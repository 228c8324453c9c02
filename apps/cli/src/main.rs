//! The `starbreak` command: parse, call the library, show.

mod args;
mod commands;
mod failure;
mod interrupt;
mod screen;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use failure::Failure;
use screen::Screen;

/// Images come and go by the megabyte: an allocator that keeps their pages spares the system the
/// work of clearing new ones for each, a fifth of the time of a dataset.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    starbreak_dataset::silence_fenced_panics();
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) => return usage(&error),
    };
    let screen = Screen::new(args.global.json, args.global.quiet);
    match commands::run(args, &screen) {
        Ok(code) => code,
        Err(failure) => refuse(&screen, &failure),
    }
}

fn refuse(screen: &Screen, failure: &Failure) -> ExitCode {
    screen.error(&failure.message);
    ExitCode::from(failure.code)
}

/// Help and version as asked for; anything else as one line like every other error.
fn usage(error: &clap::Error) -> ExitCode {
    let asked_for = [
        ErrorKind::DisplayHelp,
        ErrorKind::DisplayVersion,
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
    ];
    if asked_for.contains(&error.kind()) {
        // Whoever closed the pipe does not want to hear about it.
        let _ = error.print();
        return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(failure::WRONG_INPUT));
    }
    let text = error.to_string();
    let said = text
        .split("\n\nUsage:")
        .next()
        .and_then(|said| said.split("\n\nFor more").next())
        .unwrap_or(&text);
    let words: Vec<&str> = said
        .trim_start_matches("error: ")
        .split_whitespace()
        .collect();
    let message = format!("{}; see starbreak --help", words.join(" "));
    refuse(&Screen::new(false, false), &Failure::wrong_input(message))
}
