//! `starbreak crack`: photos to cracked photos.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use serde_json::{Value, json};
use starbreak::{Chain, OutputFormat};
use starbreak_dataset::OutputBatch;
use starbreak_runs::images::{
    Failure as ItemFailure, ImageJob, JobResult, Written, damage_files, plan_images,
};
use starbreak_runs::{Patterns, RunContext, with_threads};

use super::generate::patterns;
use super::simulate::extension;
use crate::args::Global;
use crate::args::crack::CrackArgs;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

pub(crate) fn run(global: &Global, args: &CrackArgs, screen: &Screen) -> Result<u8, Failure> {
    let (out, image_name) = folder_and_name(args)?;
    let out = out.as_path();
    let mut recipe = global.recipe()?;
    if let Some(name) = &image_name {
        let (format, word) = match name.to_lowercase().ends_with(".png") {
            true => (OutputFormat::Png, "png"),
            false => (OutputFormat::Jpeg, "jpeg"),
        };
        if ![format, OutputFormat::Same].contains(&recipe.settings()?.output.format) {
            return Err(Failure::wrong_input(format!(
                "-o {name:?} is not in the format that output.format asks for; leave one of both out"
            )));
        }
        recipe.set(&format!("output.format={word:?}"))?;
    }
    if args.maps {
        recipe.set("output.maps=true")?;
    }
    let mut context = RunContext::new(&recipe, global.seed(), out)?;
    context.replaces = global.replace;
    args.overlay_args.refuse_idle_gain(&context.settings)?;
    let jobs = plan_images(&args.inputs, out, image_name.as_deref())?;
    let failures = out.join("failures.jsonl");
    global.refuse_recipe_among(std::slice::from_ref(&failures))?;
    if jobs.len() > 1 && !is_list_of_failures(&failures) {
        global.refuse_taken(&[failures])?;
    }
    let outputs: Vec<PathBuf> = jobs
        .iter()
        .flat_map(ImageJob::possible_outputs)
        .map(|name| out.join(name))
        .collect();
    global.refuse_recipe_among(&outputs)?;
    let photo = args.overlay.as_deref();
    let patterns = patterns(
        args.overlay_args
            .read_one(photo, args.overlay_random, &outputs)?,
        (None, global.max_memory),
        args.network.as_deref(),
        &outputs,
    )?;
    let interrupt = Interrupt::listen(screen);
    let progress = screen.progress(jobs.len() as u64, "images");
    let results = with_threads(usize::from(global.threads), || {
        damage_files(&jobs, &context, &patterns, interrupt.flag(), |_, result| {
            if let Err(failure) = result
                && jobs.len() > 1
            {
                progress.line(&format!("error: {}", failure.error));
            }
            progress.step();
        })
    })?;
    progress.finish();
    // One image with a name has no list, and the folder's may be of other images.
    let has_list = image_name.is_none();
    finish(results, (&context, &patterns), has_list, &interrupt, screen)
}

/// Says how it went, and with which exit code.
fn finish(
    results: Vec<JobResult>,
    (context, patterns): (&RunContext, &Patterns),
    has_list: bool,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<u8, Failure> {
    let RunContext { out, settings, .. } = context;
    let total = results.len();
    let (mut written, mut failed) = (Vec::new(), Vec::new());
    for result in results.into_iter().flatten() {
        match result {
            Ok(item) => written.push(item),
            Err(failure) => failed.push(failure),
        }
    }
    if total == 1
        && let Some(failure) = failed.pop()
    {
        return Err(failure.error.into());
    }
    for item in &written {
        screen.say(&describe(item));
    }
    let sizes = written.iter().map(|item| item.shown.region.dimensions());
    if matches!(patterns, Patterns::Fresh)
        && let Some(hint) = sizes
            .into_iter()
            .find_map(|size| super::simulate::radius_hint(settings, size))
    {
        screen.note(&hint);
    }
    if let Some(hint) = written.iter().find_map(|item| little_mud_hint(&item.chain)) {
        screen.note(&hint);
    }
    if has_list {
        record_failures(&failed, out)?;
    }
    screen.result(|| {
        json!({
            "output": path_text(out),
            "images": written.iter().map(item_json).collect::<Vec<_>>(),
            "failed": failed.iter().map(failure_json).collect::<Vec<_>>(),
        })
    })?;
    let not_begun = total - written.len() - failed.len();
    if interrupt.is_set() && not_begun > 0 {
        return Err(Failure::interrupted(format!(
            "interrupted: {not_begun} of {total} images not begun; the same command does them"
        )));
    }
    if failed.is_empty() {
        return Ok(DONE);
    }
    let message = format!(
        "{} of {total} images failed; {:?} lists them with their reasons",
        failed.len(),
        out.join("failures.jsonl")
    );
    Err(Failure {
        message,
        code: SOME_FAILED,
    })
}

/// A hint where mud covers less than half of what was asked.
fn little_mud_hint(chain: &Chain) -> Option<String> {
    let [covered, asked] = chain.mud_covers()?.map(|share| 100.0 * share);
    (covered < 0.5 * asked).then(|| {
        format!(
            "note: mud covers {covered:.1} % of the frame, where mud.coverage_percent = {asked}: at most 200,000 splats \
             are made, too few for fine mud or a pane far away; raise mud.splat_mm or lower glass.distance_m (a few large \
             splats may also lie beside the frame: take another seed)"
        )
    })
}

/// The output folder, and the name of the damaged image where the output is named as one.
fn folder_and_name(args: &CrackArgs) -> Result<(PathBuf, Option<String>), Failure> {
    let output = &args.output;
    let extension = extension(output);
    let is_image = matches!(extension.as_str(), "png" | "jpg" | "jpeg");
    let is_other_image = matches!(extension.as_str(), "webp" | "bmp" | "gif" | "tif" | "tiff");
    let name = output.file_name().and_then(|name| name.to_str());
    let is_folder = output.is_dir() || output.to_string_lossy().ends_with(['/', MAIN_SEPARATOR]);
    if is_other_image && !is_folder {
        return Err(Failure::wrong_input(format!(
            "-o {output:?}: images are written as .png, .jpg or .jpeg; choose one of them, or end the name with / for \
             a folder of that name"
        )));
    }
    let Some(name) = name.filter(|_| is_image && !is_folder) else {
        return Ok((output.clone(), None));
    };
    if args.inputs.len() > 1 {
        return Err(Failure::wrong_input(format!(
            "-o {output:?} names one image, but there are {}; give a folder",
            args.inputs.len()
        )));
    }
    let folder = output
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.map_or_else(|| PathBuf::from("."), Path::to_owned);
    Ok((folder, Some(name.to_owned())))
}

/// The list of failures beside the results; none where nothing failed.
fn record_failures(failed: &[ItemFailure], out: &Path) -> Result<(), Failure> {
    let path = out.join("failures.jsonl");
    if failed.is_empty() {
        // That of an earlier run would now be wrong; a file of somebody else's stays.
        if is_list_of_failures(&path) {
            let _ = std::fs::remove_file(path);
        }
        return Ok(());
    }
    let lines: String = failed
        .iter()
        .map(|failure| format!("{}\n", failure_json(failure)))
        .collect();
    // Another one was refused before the work.
    let mut batch = OutputBatch::new().replacing(true);
    batch.stage(&path, lines.as_bytes())?;
    batch.commit()?;
    Ok(())
}

/// Whether a file is a list that this verb has written.
fn is_list_of_failures(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().next().is_some_and(|line| {
        serde_json::from_str::<Value>(line)
            .is_ok_and(|line| line["input"].is_string() && line["error"].is_string())
    })
}

pub(super) fn describe(item: &Written) -> String {
    let name = item.image.display();
    let affected = format!(
        "{:.1} % of the frame affected, {:.1} ms",
        item.shown.region_fraction * 100.0,
        item.timings.total_ms(),
    );
    if let Some(placed) = item.chain.photo() {
        return format!(
            "{name}: {} before {}, {affected}",
            placed.glass.name,
            placed.glass.photo.background().name(),
        );
    }
    if let Some(why) = super::simulate::why_no_damage(&item.chain) {
        return format!("{name}: {why}");
    }
    let cracks = item.chain.network().map_or_else(String::new, |network| {
        format!(
            "{} segments, {:.0} {} of cracks, ",
            network.n_segments(),
            network.summary().total_length,
            network.data().unit.symbol(),
        )
    });
    format!("{name}: {cracks}{affected}")
}

pub(super) fn item_json(item: &Written) -> Value {
    json!({
        "image": path_text(&item.image),
        "region": item.region.as_ref().map(path_text),
        "crack": item.crack.as_ref().map(path_text),
        "maps": item.maps.iter().map(path_text).collect::<Vec<_>>(),
        "provenance": path_text(&item.provenance),
        "region_fraction": item.shown.region_fraction,
        "optics": item.shown.optics.to_json(),
        "intact": item.chain.is_intact(),
        "summary": item.chain.network().map(|network| network.summary()),
        "timings_ms": item.timings.to_json(),
    })
}

fn failure_json(failure: &ItemFailure) -> Value {
    json!({ "input": path_text(&failure.input), "error": failure.error.to_string() })
}
