//! The `starbreak` command.

use std::process::ExitCode;

/// Images come and go by the megabyte: an allocator that keeps their pages spares the system the
/// work of clearing new ones for each, a fifth of the time of a dataset.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    ExitCode::from(starbreak_command::main(std::env::args_os()))
}
