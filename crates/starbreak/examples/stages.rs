//! Where the time of `starbreak generate` from a bank goes, ms per image and stage.
//!
//! `stages N_THREADS FORMAT:PATH BANK OUT` makes the set and prints its stages; what it waits for
//! the disk after `record`, and the lists at the end, are in the whole alone.
#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::ffi::OsStr;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use starbreak::Seed;
use starbreak::bank::PatternBank;
use starbreak::dataset::{Source, SourceSpec};
use starbreak::generate::{GenerateOptions, Patterns, Plan, generate, survey};
use starbreak::pipeline::{RunContext, with_threads};

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [n_threads, source, bank, out] = args.as_slice() else {
        return Err("expected N_THREADS FORMAT:PATH BANK OUT".into());
    };
    let n_threads = n_threads.parse()?;
    let source = Source::open(&SourceSpec::parse(OsStr::new(source))?)?;
    let bank = PatternBank::open(Path::new(bank))?;
    let recipe = bank.header().parse_recipe()?;
    let context = RunContext::new(&recipe, Seed(1), Path::new(out))?;
    let patterns = Patterns::Bank(bank);
    let options = GenerateOptions::default();
    let started = Instant::now();
    let report = with_threads(n_threads, || {
        let plan = Plan {
            source: &source,
            context: &context,
            patterns: &patterns,
            options: &options,
            survey: &survey(&source, options.selection, context.seed),
        };
        generate(&plan, &AtomicBool::new(false), &|_| ())
    })??;
    let whole_ms = started.elapsed().as_secs_f64() * 1e3;
    let n_made = f64::from(u32::try_from(report.n_made)?.max(1));
    println!("whole, all threads: {:.3}", whole_ms / n_made);
    if let Some(stages) = report.timings.to_json().as_object() {
        for (stage, ms) in stages {
            println!("{stage}: {:.3}", ms.as_f64().unwrap_or(0.0) / n_made);
        }
    }
    Ok(())
}
