//! Runs every input of the corpus, and mutations of them that are the same on every machine,
//! through the fuzz targets, on stable Rust and without a fuzzer.
//!
//! `STARBREAK_FUZZ_MUTATIONS=100000 cargo test --package starbreak-fuzz --test replay`: so many
//! mutations per target (default: the target's own number). A finding is written to
//! `artifacts/<target>/` and makes the test fail; so does an input that takes more than
//! [`MAX_BYTES`] of memory. `STARBREAK_FUZZ_TARGET=image` runs one target alone.
#![expect(clippy::print_stdout, reason = "a report is what this program is for")]

use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use peak_alloc::PeakAlloc;
use starbreak_fuzz::{Mutator, TARGETS, Target};

/// Findings of one target that are reported; one bug is often found many times.
const MAX_FINDINGS: usize = 10;

/// Counts what is allocated.
#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Memory that an input of some kilobytes may take, bytes.
const MAX_BYTES: usize = 128 << 20;

/// Characters of a message that are printed.
const MAX_MESSAGE: usize = 400;

fn main() -> ExitCode {
    // As the other tests, it is left out where tests of other names are asked for.
    let mut names = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"));
    if names.any(|name| !"replay".contains(&name)) {
        return ExitCode::SUCCESS;
    }
    let n_mutations = match std::env::var("STARBREAK_FUZZ_MUTATIONS").map(|n| n.parse()) {
        Err(_) => None,
        Ok(Ok(n)) => Some(n),
        Ok(Err(_)) => {
            println!("STARBREAK_FUZZ_MUTATIONS is no number of mutations");
            return ExitCode::from(2);
        }
    };
    let mut n_findings = 0;
    let only = std::env::var("STARBREAK_FUZZ_TARGET").ok();
    let is_wanted = |target: &&Target| only.as_ref().is_none_or(|name| name == target.name);
    for target in TARGETS.iter().filter(is_wanted) {
        match replay(target, n_mutations.unwrap_or(target.n_mutations)) {
            Ok(n) => n_findings += n,
            Err(cause) => {
                println!("fuzz {}: {cause}", target.name);
                return ExitCode::from(2);
            }
        }
    }
    if n_findings == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Number of findings.
fn replay(target: &Target, n_mutations: usize) -> std::io::Result<usize> {
    let started = Instant::now();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<_> = fs::read_dir(root.join("corpus").join(target.name))?
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    files.sort();
    let corpus = files
        .iter()
        .map(fs::read)
        .collect::<std::io::Result<Vec<_>>>()?;
    if corpus.is_empty() {
        return Err(std::io::Error::other("the corpus is empty"));
    }
    let mut n_findings = 0;
    for (file, input) in files.iter().zip(&corpus) {
        if let Some(what) = finding(target, input) {
            n_findings += 1;
            println!("fuzz {}: {}: {what}", target.name, file.display());
        }
    }
    let mut mutator = Mutator::new(0);
    for k in 0..n_mutations {
        let input = mutator.next_input(&corpus, target.vocabulary);
        let Some(what) = finding(target, &input) else {
            continue;
        };
        n_findings += 1;
        let folder = root.join("artifacts").join(target.name);
        fs::create_dir_all(&folder)?;
        let file = folder.join(format!("replay-{k}"));
        fs::write(&file, &input)?;
        println!("fuzz {}: {}: {what}", target.name, file.display());
        if n_findings >= MAX_FINDINGS {
            println!("fuzz {}: stopped after mutation {k}", target.name);
            break;
        }
    }
    println!(
        "fuzz {}: {} corpus files, {n_mutations} mutations, {n_findings} findings, {:.1} s",
        target.name,
        corpus.len(),
        started.elapsed().as_secs_f64()
    );
    Ok(n_findings)
}

/// What the target says against the input, in one line.
fn finding(target: &Target, input: &[u8]) -> Option<String> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    let result = panic::catch_unwind(AssertUnwindSafe(|| (target.check)(input)));
    panic::set_hook(hook);
    let taken = ALLOCATED.peak_usage().saturating_sub(before);
    if taken > MAX_BYTES {
        return Some(format!("it took {} MiB of memory", taken >> 20));
    }
    let what = result.err()?;
    let message = what
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| what.downcast_ref::<&str>().copied())
        .unwrap_or("panicked");
    Some(
        message
            .replace('\n', " ")
            .chars()
            .take(MAX_MESSAGE)
            .collect(),
    )
}
