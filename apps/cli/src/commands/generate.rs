//! `starbreak generate`: a dataset to its cracked twin.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};
use starbreak::{FAULTS, Recipe};
use starbreak_dataset::{
    BadRecord, Carry, DatasetError, Encoding, Source, encode_image, file_in, is_inside, same_file,
};
use starbreak_runs::bank::{BANK_FILE, PatternBank};
use starbreak_runs::generate::{
    Event, GenerateOptions, GenerateReport, Plan, Preview, Selection, Survey, generate, preview,
    refuse_outputs, survey,
};
use starbreak_runs::{Patterns, RunContext, with_threads};

use super::contact_sheet::{Cell, contact_sheet};
use super::network_file;
use crate::args::Global;
use crate::args::generate::{GenerateArgs, OnError, OtherFiles};
use crate::args::overlay::is_bank;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Images of a dry run.
const N_PREVIEW: u64 = 12;

/// Bad records that are shown one by one.
const MOST_SHOWN: usize = 20;

/// Refuses an output folder in the folder of an input, and around it.
pub(super) fn refuse_output_in(input: &Path, output: &Path) -> Result<(), Failure> {
    if is_inside(output, input) || is_inside(input, output) {
        return Err(DatasetError::OutputInInput {
            input: input.to_owned(),
            output: output.to_owned(),
        }
        .into());
    }
    Ok(())
}

pub(crate) fn run(global: &Global, args: &GenerateArgs, screen: &Screen) -> Result<u8, Failure> {
    if let Some(overlays) = &args.overlays {
        refuse_output_in(overlays, &args.output)?;
    }
    let photos = args.overlay.read_folder(args.overlays.as_deref())?;
    let patterns = patterns(
        photos,
        (args.bank.as_deref(), global.max_memory),
        args.network.as_deref(),
        &[],
    )?;
    let recipe = match &patterns {
        Patterns::Bank(bank) => recipe_of_bank(bank, global)?,
        _ => global.recipe()?,
    };
    let context = RunContext::new(&recipe, global.seed(), &args.output)?;
    refuse_outputs(&context.settings.output)?;
    args.overlay.refuse_idle_gain(&context.settings)?;
    let options = options_of(args);
    let source = Source::open(&global.spec(&args.source)?)?;
    let survey = survey(&source, options.selection, global.seed());
    mind_bad_records(&survey, args.on_error, screen)?;
    if survey.n_strays > 0 {
        screen.note(&format!(
            "{} image files that the dataset does not name are left out",
            survey.n_strays
        ));
    }
    // A shard of few images may be empty, and is one all the same.
    if survey.n_selected == 0 && (options.selection.shard.is_none() || survey.n_images == 0) {
        return Err(Failure::wrong_input(format!(
            "{:?} holds no image to be taken ({} in all); check the path and the selection",
            source.root(),
            survey.n_images
        )));
    }
    let plan = Plan {
        source: &source,
        context: &context,
        patterns: &patterns,
        options: &options,
        survey: &survey,
    };
    if args.dry_run {
        return dry_run(global, &plan, screen);
    }

    let interrupt = Interrupt::listen(screen);
    let total = survey.n_selected * u64::from(options.n_samples);
    let progress = screen.progress(total, "images");
    let started = Instant::now();
    let report = with_threads(usize::from(global.threads), || {
        generate(&plan, interrupt.flag(), &|event| match event {
            Event::Done => progress.step(),
            Event::Failed(failure) => progress.line(&format!("error: {}", failure.error)),
        })
    })?;
    progress.finish();
    // What is wrong with the disk is in the way of all images: the work failed.
    let report = report.map_err(|error| {
        let code = if error.is_of_the_disk() {
            SOME_FAILED
        } else {
            crate::failure::WRONG_INPUT
        };
        Failure {
            message: format!(
                "{error}{}",
                if code == SOME_FAILED {
                    "; the same command goes on"
                } else {
                    ""
                }
            ),
            code,
        }
    })?;
    let seconds = started.elapsed().as_secs_f64();
    finish(&plan, &report, seconds, &interrupt, screen)
}

/// Where the damage comes from: photographs, a bank of cracks, a network, or fresh breaks. None of the
/// outputs is a file that is read.
pub(super) fn patterns(
    photos: Option<Patterns>,
    (bank, max_memory): (Option<&Path>, u64),
    network: Option<&Path>,
    outputs: &[PathBuf],
) -> Result<Patterns, Failure> {
    if let Some(photos) = photos {
        return Ok(photos);
    }
    let Some(bank) = bank else {
        let imported = network_file::read(network, outputs)?;
        return Ok(imported.map_or(Patterns::Fresh, |it| Patterns::Network(Box::new(it))));
    };
    let file = file_in(bank, BANK_FILE);
    if let Some(output) = outputs.iter().find(|output| same_file(&file, output)) {
        return Err(Failure::wrong_input(format!(
            "the output {output:?} would replace the bank {bank:?}; choose another name"
        )));
    }
    if is_bank(bank) && !bank.join(BANK_FILE).is_file() {
        return Err(Failure::wrong_input(format!(
            "{bank:?} is a bank of photos, not of cracks; `generate --overlays` takes it"
        )));
    }
    let mut bank = PatternBank::open(bank)?;
    bank.set_max_memory(max_memory);
    Ok(Patterns::Bank(Box::new(bank)))
}

/// The recipe that the patterns were made with, with what is said of the output and of the faults of the camera.
pub(super) fn recipe_of_bank(bank: &PatternBank, global: &Global) -> Result<Recipe, Failure> {
    let mut recipe = bank.header().parse_recipe()?;
    recipe.set_max_memory(global.max_memory);
    let later: Vec<&str> = (FAULTS.iter().filter(|fault| !fault.is_on_pane()))
        .map(|fault| fault.table)
        .chain(["lens", "sensor", "output"])
        .collect();
    for assignment in &global.set {
        let table = assignment
            .trim_start()
            .split('.')
            .next()
            .unwrap_or_default();
        if !later.contains(&table) {
            return Err(Failure::wrong_input(format!(
                "--set {assignment} would change the recipe of the bank's patterns; with --bank only these tables can \
                 be set: {}; or make another bank with it",
                later.join(", ")
            )));
        }
        recipe.set(assignment)?;
    }
    Ok(recipe)
}

fn options_of(args: &GenerateArgs) -> GenerateOptions {
    GenerateOptions {
        n_samples: args.samples,
        selection: Selection {
            limit: args.limit,
            sample: args.sample,
            shard: args.shard,
        },
        other_files: match args.other_files {
            OtherFiles::Copy => Some(Carry::Copy),
            OtherFiles::HardLink => Some(Carry::HardLink),
            OtherFiles::Skip => None,
        },
        max_failures: if args.fail_fast {
            Some(0)
        } else {
            args.max_failures
        },
    }
}

/// Stops, or says what is left out.
pub(super) fn mind_bad_records(
    survey: &Survey,
    on_error: OnError,
    screen: &Screen,
) -> Result<(), Failure> {
    let n_bad = survey.bad.len();
    if n_bad == 0 {
        return Ok(());
    }
    for bad in survey.bad.iter().take(MOST_SHOWN) {
        screen.note(&format!("bad record: {bad}"));
    }
    if n_bad > MOST_SHOWN {
        screen.note(&format!("and {} more bad records", n_bad - MOST_SHOWN));
    }
    match on_error {
        OnError::Stop => Err(Failure::wrong_input(format!(
            "the dataset has {}, the first: {}; mend them, or leave them out with --on-error skip",
            match n_bad {
                1 => "1 bad record".to_owned(),
                n => format!("{n} bad records"),
            },
            survey
                .bad
                .first()
                .map(BadRecord::to_string)
                .unwrap_or_default()
        ))),
        OnError::Skip => Ok(()),
    }
}

/// Says what the run would do, and shows a few of its images.
fn dry_run(global: &Global, plan: &Plan<'_>, screen: &Screen) -> Result<u8, Failure> {
    let made = with_threads(usize::from(global.threads), || preview(plan, N_PREVIEW))??;
    let mut cells = Vec::new();
    for image in &made.images {
        let caption = [
            image.name.clone(),
            format!(
                "{:.1} % of the frame affected",
                image.region_fraction * 100.0
            ),
        ];
        cells.push(Cell::new(&image.pixels.to_rgb8(), caption));
    }
    let mut sheet_path = plan.context.out.clone().into_os_string();
    sheet_path.push(".preview.png");
    let sheet_path = PathBuf::from(sheet_path);
    if !cells.is_empty() {
        let title = format!(
            "{} of {} images, seed {}",
            cells.len(),
            plan.survey.n_selected,
            global.seed
        );
        let sheet = encode_image(&contact_sheet(&title, &cells).into(), &Encoding::Png, None)?;
        let mut batch = global.batch();
        batch.stage(&sheet_path, &sheet)?;
        batch.commit()?;
    }
    for (_, error) in &made.failures {
        screen.note(&format!("error: {error}"));
    }
    screen.say(&would_do(plan, &made));
    if !cells.is_empty() {
        screen.say(&format!(
            "{} of them on {}",
            cells.len(),
            sheet_path.display()
        ));
    }
    screen.result(|| {
        json!({
            "dry_run": true,
            "n_images": plan.survey.n_selected,
            "n_samples": plan.options.n_samples,
            "n_objects": plan.survey.n_objects,
            "n_bad_records": plan.survey.bad.len(),
            "input_bytes": made.n_input_bytes,
            "output_bytes": made.n_output_bytes,
            "n_files": made.n_files,
            "file_bytes": made.n_file_bytes,
            "seconds_on_one_thread": made.seconds_on_one_thread,
            "preview": path_text(&sheet_path),
            "failed": made.failures.len(),
        })
    })?;
    Ok(DONE)
}

fn would_do(plan: &Plan<'_>, made: &Preview) -> String {
    let n_samples = plan.options.n_samples;
    let times = if n_samples == 1 {
        String::new()
    } else {
        format!(" {n_samples} times each")
    };
    format!(
        "dry run: {} of {} images{times} with {} labeled objects ({}) would become about {} with their masks and \
         records, in about {:.0} s on one thread; {} labels and other files ({}) {}",
        plan.survey.n_selected,
        plan.survey.n_images,
        plan.survey.n_objects,
        bytes_text(made.n_input_bytes),
        bytes_text(made.n_output_bytes),
        made.seconds_on_one_thread,
        made.n_files,
        bytes_text(made.n_file_bytes),
        how_carried(plan),
    )
}

fn how_carried(plan: &Plan<'_>) -> &'static str {
    match plan.options.other_files {
        Some(_) if plan.moves_labels() => "moved with what they name",
        Some(Carry::Copy) => "copied",
        Some(Carry::HardLink) => "carried over, labels copied and the others hard-linked",
        None if plan.moves_labels() => "moved with what they name, other files left out",
        None => "copied, other files left out",
    }
}

/// A number of bytes for people.
fn bytes_text(n_bytes: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "three digits of it")]
    let n = n_bytes as f64;
    match n_bytes {
        0..10_000 => format!("{n_bytes} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", n / 1e3),
        10_000_000..10_000_000_000 => format!("{:.1} MB", n / 1e6),
        _ => format!("{:.1} GB", n / 1e9),
    }
}

/// Says how it went, and with which exit code.
fn finish(
    plan: &Plan<'_>,
    report: &GenerateReport,
    seconds: f64,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<u8, Failure> {
    let out = &plan.context.out;
    let n_failed = report.failures.len();
    if report.manifest.is_some() {
        screen.say(&summary(plan, report, seconds));
    }
    screen.result(|| result_json(plan, report, seconds))?;
    if report.manifest.is_none() && n_failed == 0 {
        let left = match report.n_not_begun {
            0 => "labels and lists".to_owned(),
            n => format!("{n} images"),
        };
        return Err(Failure::interrupted(format!(
            "interrupted: {left} not begun; the same command goes on"
        )));
    }
    if n_failed == 0 {
        return Ok(DONE);
    }
    let list = out.join("starbreak").join("failures.jsonl");
    let stopped = match (report.manifest.is_some(), interrupt.is_set()) {
        (true, _) => String::new(),
        (false, true) => format!(", interrupted with {} not begun", report.n_not_begun),
        (false, false) => format!(
            ", and the run was stopped with {} not begun",
            report.n_not_begun
        ),
    };
    Err(Failure {
        message: format!(
            "{n_failed} images failed{stopped}; {list:?} lists them with their reasons; once they are mended the same \
             command does them"
        ),
        code: SOME_FAILED,
    })
}

fn summary(plan: &Plan<'_>, report: &GenerateReport, seconds: f64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "a rate")]
    let rate = report.n_made as f64 / seconds.max(1e-9);
    let n_files = report
        .manifest
        .as_ref()
        .map_or(0, |manifest| manifest.n_files);
    let before = match report.n_done_before {
        0 => String::new(),
        n => format!(", {n} done before"),
    };
    let intact = match report.n_intact {
        0 => String::new(),
        n => format!(", {n} of them with nothing broken"),
    };
    let skipped = match report.skipped.len() {
        0 => String::new(),
        n => format!("; {n} bad records left out (starbreak/skipped.jsonl)"),
    };
    format!(
        "{}: {} images made{intact}{before}, {rate:.1} per second, {}; {n_files} labels and other files {}; PNG lossless, \
         JPEG at quality {}{skipped}",
        plan.context.out.display(),
        report.n_made,
        bytes_text(report.n_bytes),
        how_carried(plan),
        plan.context.settings.output.quality,
    )
}

fn result_json(plan: &Plan<'_>, report: &GenerateReport, seconds: f64) -> Value {
    json!({
        "output": path_text(&plan.context.out),
        "finished": report.manifest.is_some(),
        "n_made": report.n_made,
        "n_done_before": report.n_done_before,
        "n_intact": report.n_intact,
        "n_not_begun": report.n_not_begun,
        "n_skipped": report.skipped.len(),
        "bytes": report.n_bytes,
        "seconds": seconds,
        "timings_ms": report.timings.to_json(),
        "manifest": report.manifest,
        "failed": report
            .failures
            .iter()
            .map(|failure| {
                json!({
                    "name": failure.name,
                    "sample": failure.sample_idx,
                    "error": failure.error.to_string(),
                })
            })
            .collect::<Vec<_>>(),
    })
}
