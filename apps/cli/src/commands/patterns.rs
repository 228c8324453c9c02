//! `starbreak patterns`: a bank of cracks, simulated and baked once for any number of images.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};
use starbreak_dataset::Source;
use starbreak_runs::bank::{
    BANK_FILE, BankHeader, BankReport, FrameSizes, PatternBank, write_bank,
};
use starbreak_runs::{RunContext, with_threads};

use super::pattern_statistics::{Statistics, csv, figure};
use super::raster;
use crate::args::Global;
use crate::args::patterns::PatternsArgs;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// The most frequent frame sizes of a dataset.
fn sizes_of(
    global: &Global,
    source: &OsStr,
    most: u16,
    screen: &Screen,
) -> Result<Vec<(u32, u32)>, Failure> {
    let source = Source::open(&global.spec(source)?)?;
    let found = FrameSizes::of(&source);
    let (sizes, n_others) = found.most_frequent(usize::from(most));
    if sizes.is_empty() {
        return Err(Failure::wrong_input(format!(
            "{:?} holds no image whose size can be read; check the path",
            source.root()
        )));
    }
    if n_others > 0 {
        let n_sizes = found.by_frequency.len();
        screen.note(&format!(
            "{n_others} images have one of {} further sizes, for which patterns are baked anew; --most-sizes {n_sizes} takes all",
            n_sizes - sizes.len()
        ));
    }
    if found.n_unreadable > 0 {
        screen.note(&format!(
            "the size of {} images cannot be read",
            found.n_unreadable
        ));
    }
    Ok(sizes)
}

/// Makes a bank of `n` patterns in the folder `output`.
pub(crate) fn run(
    global: &Global,
    args: &PatternsArgs,
    (n, output): (u32, &Path),
    screen: &Screen,
) -> Result<u8, Failure> {
    let sizes = match &args.sizes_of {
        Some(source) => sizes_of(global, source, args.most_sizes, screen)?,
        None => args.size.clone(),
    };
    let recipe = global.recipe()?;
    let mut context = RunContext::new(&recipe, global.seed(), output)?;
    context.replaces = global.replace;
    let to = output.join(BANK_FILE);
    let beside = |name: &str| output.join(name);
    let paths = [
        beside("statistics.csv"),
        beside("statistics.svg"),
        beside("statistics.png"),
    ];
    let all = [std::slice::from_ref(&to), &paths[..]].concat();
    global.refuse_recipe_among(&all)?;
    // A bank is hours of work to some; neither it nor what lies there is replaced by the way.
    global.refuse_taken(&all)?;
    let interrupt = Interrupt::listen(screen);
    let started = Instant::now();
    let progress = screen.progress(u64::from(n), "patterns");
    let draft = with_threads(usize::from(global.threads), || {
        write_bank(&context, n as usize, &sizes, &to, interrupt.flag(), |_| {
            progress.step();
        })
    })?;
    progress.finish();
    let draft = draft.map_err(|error| match error {
        starbreak_runs::Error::Interrupted => Failure::interrupted(
            "interrupted: a bank is written as a whole or not at all, so nothing was written; run the command again",
        ),
        error => error.into(),
    })?;
    let statistics = Statistics::of(&draft.report);
    let figure = figure(&statistics);
    let texts = [csv(&draft.report), figure.svg()].map(String::into_bytes);
    let bytes = texts.into_iter().chain([raster::png(&figure)?]);
    let files: Vec<(PathBuf, Vec<u8>)> = paths.into_iter().zip(bytes).collect();
    interrupt.check()?;
    let report = draft.commit(&files)?;
    let elapsed_s = started.elapsed().as_secs_f64();
    for line in said(&report, &statistics, elapsed_s) {
        screen.say(&line);
    }
    screen.say(&format!("statistics in {}", files[0].0.display()));
    screen.result(|| {
        let mut result = described(&report.header, report.rows.len(), report.n_bytes);
        result["bank"] = path_text(&to).into();
        result["sha256"] = report.sha256.as_str().into();
        result["seconds"] = elapsed_s.into();
        result["statistics"] = statistics.to_json();
        result["files"] = files.iter().map(|(path, _)| path_text(path)).collect();
        result
    })?;
    Ok(DONE)
}

/// Header and totals of a bank.
pub(crate) fn info(path: &Path, screen: &Screen) -> Result<u8, Failure> {
    let bank = PatternBank::open(path)?;
    let header = bank.header();
    screen.say(&format!("{}: {}", bank.path().display(), totals(&bank)));
    screen.say(&format!(
        "made by {} {}, seed {}, frames of {}",
        header.generator.name,
        header.generator.version,
        header.seed.0,
        sizes_text(header)
    ));
    screen.say(&format!("sha256 {}", bank.sha256()));
    screen.say(&format!("recipe {}:", header.recipe_sha256));
    screen.say(header.recipe.trim_end());
    screen.result(|| {
        let mut result = described(header, bank.len(), bank.n_bytes());
        result["bank"] = path_text(bank.path()).into();
        result["sha256"] = bank.sha256().into();
        result["recipe"] = header.recipe.as_str().into();
        result
    })?;
    Ok(DONE)
}

/// Reads all of a bank.
pub(crate) fn check(path: &Path, screen: &Screen) -> Result<u8, Failure> {
    let bank = PatternBank::open(path)?;
    let interrupt = Interrupt::listen(screen);
    let progress = screen.progress(bank.len() as u64, "patterns");
    let result = bank.check(|_| {
        progress.step();
        !interrupt.is_set()
    });
    progress.finish();
    result?;
    if interrupt.is_set() {
        return Err(Failure::interrupted(
            "interrupted: the bank was not checked to its end; run the command again",
        ));
    }
    screen.say(&format!(
        "{} is whole: {}",
        bank.path().display(),
        totals(&bank)
    ));
    screen.result(|| {
        let mut result = described(bank.header(), bank.len(), bank.n_bytes());
        result["bank"] = path_text(bank.path()).into();
        result["sha256"] = bank.sha256().into();
        result["whole"] = true.into();
        result
    })?;
    Ok(DONE)
}

fn totals(bank: &PatternBank) -> String {
    format!("{} patterns in {}", bank.len(), bytes_text(bank.n_bytes()))
}

fn said(report: &BankReport, statistics: &Statistics, elapsed_s: f64) -> Vec<String> {
    #[expect(clippy::cast_precision_loss, reason = "a rate")]
    let rate = report.rows.len() as f64 / elapsed_s.max(1e-9);
    let classes: Vec<String> = statistics
        .classes
        .iter()
        .map(|(class, n)| format!("{n} {class}"))
        .collect();
    vec![
        format!(
            "{} patterns for frames of {} in {elapsed_s:.1} s ({rate:.1} per second), {}",
            report.rows.len(),
            sizes_text(&report.header),
            bytes_text(report.n_bytes)
        ),
        format!("classes: {}", classes.join(", ")),
        format!(
            "cracks cover {:.2} % of the frame in the middle (5 % to 95 %: {:.2} to {:.2} %)",
            statistics.area_percent[1], statistics.area_percent[0], statistics.area_percent[2]
        ),
        format!("sha256 {}", report.sha256),
    ]
}

fn described(header: &BankHeader, n: usize, n_bytes: u64) -> Value {
    json!({
        "kind": header.kind,
        "n_patterns": n,
        "bytes": n_bytes,
        "generator": header.generator,
        "seed": header.seed,
        "sizes_px": header.sizes,
        "recipe_sha256": header.recipe_sha256,
    })
}

fn sizes_text(header: &BankHeader) -> String {
    let sizes: Vec<String> = header
        .sizes
        .iter()
        .map(|(width, height)| format!("{width} × {height} px"))
        .collect();
    sizes.join(" and ")
}

pub(super) fn bytes_text(n_bytes: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "a length for people")]
    let n = n_bytes as f64;
    match n {
        0.0..1e6 => format!("{:.1} kB", n / 1e3),
        1e6..1e9 => format!("{:.1} MB", n / 1e6),
        _ => format!("{:.2} GB", n / 1e9),
    }
}
