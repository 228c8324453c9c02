//! `starbreak divergence`: how far sets of images are apart.

mod experiment;
mod given;
mod sets;
mod show;

use std::process::ExitCode;

use serde_json::Value;
use starbreak_eval::divergence::{
    AnalysisSize, Background, CompareSettings, DivergenceReport, ReadSettings, divergence_csv,
    divergence_svg,
};
use starbreak_runs::divergence::compare_read_sets;
use starbreak_runs::with_threads;

use crate::args::Global;
use crate::args::divergence::{BackgroundWord, DivergenceArgs};
use crate::failure::{Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// The files that go into the output folder.
const FILES: [&str; 3] = ["divergence.json", "divergence.csv", "divergence.svg"];

pub(crate) fn run(
    global: &Global,
    args: &DivergenceArgs,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    if let Some(file) = &args.histograms {
        return given::histograms(file, screen);
    }
    if let Some(folder) = &args.output {
        global.refuse_taken(&FILES.map(|name| folder.join(name)))?;
    }
    let n_threads = usize::from(global.threads);
    let settings = CompareSettings {
        alpha: args.alpha,
        n_bootstrap: wide(args.bootstrap),
        n_permutations: wide(args.permutations),
        n_splits: wide(args.splits),
        seed: global.seed,
        ..CompareSettings::default()
    };
    if let Some(files) = &args.features {
        return with_threads(n_threads, || {
            given::features(files, args.sigma, &settings, screen)
        })?;
    }
    let reading = reading(args);
    let interrupt = Interrupt::listen();
    if args.experiment.experiment.is_some() {
        return with_threads(n_threads, || {
            experiment::run(global, args, &reading, &settings, &interrupt, screen)
        })?;
    }
    with_threads(n_threads, || {
        let eye = sets::eye(args)?;
        let sets = sets::read_all(global, args, &reading, eye.as_ref(), &interrupt, screen)?;
        let eye = eye.as_ref().map(|eye| (eye, args.sigma));
        let report = compare_read_sets(&sets, &reading, &settings, eye)?;
        interrupt.check()?;
        show::report(&report, screen);
        let value = serde_json::to_value(&report).map_err(Failure::wrong_input)?;
        finish(global, args, &report, value, screen)
    })?
}

/// Writes the files, says what failed.
fn finish(
    global: &Global,
    args: &DivergenceArgs,
    report: &DivergenceReport,
    value: Value,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    if let Some(folder) = &args.output {
        let text = serde_json::to_string_pretty(&value).map_err(Failure::wrong_input)?;
        let contents = [text + "\n", divergence_csv(report), divergence_svg(report)];
        let mut batch = global.batch();
        for (name, content) in FILES.iter().zip(&contents) {
            batch.stage(&folder.join(name), content.as_bytes())?;
        }
        batch.commit()?;
        screen.say(&format!(
            "wrote {} to {}",
            FILES.join(", "),
            path_text(folder)
        ));
    }
    screen.result(|| value)?;
    let n_failed: usize = report.sets.iter().map(|set| set.failed.len()).sum();
    if n_failed == 0 {
        return Ok(ExitCode::SUCCESS);
    }
    Err(Failure {
        message: format!(
            "{n_failed} images could not be read and are in no number; they are listed above and in the result"
        ),
        code: SOME_FAILED,
    })
}

fn reading(args: &DivergenceArgs) -> ReadSettings {
    ReadSettings {
        background: match args.background {
            BackgroundWord::Black => Background::Black,
            BackgroundWord::Gray => Background::Gray,
            BackgroundWord::White => Background::White,
        },
        analysis: AnalysisSize {
            shorter_side_px: args.side,
            ..AnalysisSize::default()
        },
    }
}

fn wide(n: u32) -> usize {
    usize::try_from(n).unwrap_or(usize::MAX)
}

/// A number for people: four digits.
fn digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        return format!("{value:.2e}");
    }
    format!("{value:.4}")
}
