//! `cargo xtask <task>`: the chores of the project.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a report is what a chore is for"
)]

use std::process::ExitCode;

use xtask::{
    advisories, deps, docs, gallery, licences, links, lint, notices, refs, root, test, web,
};

const USAGE: &str = "\
usage: cargo xtask <task>
  test            cargo test --workspace with doctests and the replay of the fuzz corpus, the wheel
                  of the Python package and its tests; its tools (Python packages, ffmpeg,
                  maturin) come from PyPI into target/test-venv, a missing Chromium and QEMU from
                  Debian's packages into target/test-browser and target/test-emulator
  processors      the golden digests on emulated processors: x86-64 without AVX, which test runs,
                  too, and aarch64; QEMU and a cross compiler come from Debian's packages into
                  target/test-emulator and target/test-cross-compiler, the standard library of
                  aarch64 from rustup
  lint            fmt, the lock file of fuzz/libfuzzer, clippy, rustdoc, licences, advisories,
                  deps --check, refs, links
  licences        every package's licence is on the allow-list and every source is crates.io
  notices         prints the licences of all that the binaries contain, to go with them
  advisories      no version in the lock file was withdrawn, and cargo audit, where it is
                  installed, knows nothing against one; says of which day, and what it could not check
  deps [--check]  writes the dependency graph into ARCHITECTURE.md, or says that it is stale
  refs            every [AuthorYear] has an entry in a .bib file
  links           every link between pages leads to a file and a heading
  docs            the documentation site in target/docs-site, from the pages of docs/SUMMARY.md and
                  the docstrings of the Python package; every link in it leads somewhere, and every
                  command and Python block of the pages runs, on made-up inputs; mdBook comes from
                  crates.io into target/test-mdbook, pdoc from PyPI into target/docs-venv
  web [--serve]   the playground in target/playground, for any web server: the modules in Rust for browsers, whose
                  library comes from rustup, and the page, whose packages come from npm; with --serve it
                  is served on this machine
  gallery         writes docs/figures/gallery: every preset and damage class, and the animation of
                  the README, for which it takes the ffmpeg of the tests";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args.as_slice() {
        ["test"] => test::run(root()),
        ["processors"] => test::run_on_processors(root()),
        ["lint"] => lint::run(root()),
        ["licences"] => licences::run(root()),
        ["notices"] => notices::run(root()),
        ["advisories"] => advisories::run(root()),
        ["deps"] => deps::run(root(), deps::Mode::Write),
        ["deps", "--check"] => deps::run(root(), deps::Mode::Check),
        ["refs"] => refs::run(root()),
        ["links"] => links::run(root()),
        ["docs"] => docs::run(root()),
        ["web"] => web::run(root(), false),
        ["web", "--serve"] => web::run(root(), true),
        ["gallery"] => gallery::run(root()),
        [] | ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask {}: {failure}", args.join(" "));
            ExitCode::FAILURE
        }
    }
}
