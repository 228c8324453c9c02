//! The `starbreak` command: parse, call the library, show.

mod args;
mod commands;
mod failure;
mod interrupt;
mod screen;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let args = args::Args::parse();
    let screen = screen::Screen::new(args.global.json, args.global.quiet);
    match commands::run(args, &screen) {
        Ok(code) => code,
        Err(failure) => {
            screen.error(&failure.message);
            ExitCode::from(failure.code)
        }
    }
}
