//! `starbreak sweep`: one crack over the values of one parameter.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use starbreak::{CameraSettings, Chain, FractureSettings, Simulated, Stopwatch, simulate};
use starbreak_dataset::{
    Encoding, FileSet, ImageFile, ImageLimits, blake3_file, encode_image, files_in, listed_files,
    read_image, same_file,
};
use starbreak_runs::images::{ImageJob, Written, plan_images, stage_shown};
use starbreak_runs::{PROVENANCE_SCHEMA, RunContext};

use super::contact_sheet::{Cell, contact_sheet};
use super::crack::item_json;
use crate::args::Global;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Most values of one sweep.
const MOST_VALUES: usize = 1000;

/// One value of the parameter, and what came out.
struct Step {
    value: String,
    context: RunContext,
    written: Written,
}

/// The pictures and records of an earlier sweep over the same image.
fn of_earlier_run(job: &ImageJob, out: &Path) -> Result<Vec<(PathBuf, String)>, Failure> {
    if !out.is_dir() {
        return Ok(Vec::new());
    }
    let step = |stem: &str| -> Option<()> {
        let (number, _) = stem
            .strip_prefix(&job.stem)?
            .strip_prefix('.')?
            .split_once('-')?;
        number.parse::<u32>().ok().map(drop)
    };
    let mut files = Vec::new();
    for (stem, record) in files_in(out, "json")? {
        if step(&stem).is_some() {
            let written = listed_files(&record, PROVENANCE_SCHEMA, Some(&job.name));
            if !written.is_empty() {
                files.push((record.clone(), blake3_file(&record)?));
            }
            files.extend(written);
        }
    }
    Ok(files)
}

/// Cracks, and what they depend on.
struct Cracks {
    fracture: FractureSettings,
    camera: CameraSettings,
    simulated: Simulated,
}

pub(crate) fn run(
    global: &Global,
    input: &Path,
    out: &Path,
    over: &str,
    screen: &Screen,
) -> Result<u8, Failure> {
    let (key, values) = values_of(over)?;
    let jobs = plan_images(&[input.to_owned()], out, None)?;
    let Some(job) = jobs.first() else {
        return Err(Failure::wrong_input("no image"));
    };
    let sheet_path = out.join(format!("{}.sweep.png", job.stem));
    let csv_path = out.join(format!("{}.sweep.csv", job.stem));
    for output in [&sheet_path, &csv_path] {
        if same_file(input, output) {
            return Err(Failure::wrong_input(format!(
                "the output {output:?} would replace the input {input:?}; choose another output folder"
            )));
        }
    }
    global.refuse_recipe_among(std::slice::from_ref(&csv_path))?;
    let contexts = contexts(global, &key, &values, out)?;
    let interrupt = Interrupt::listen(screen);
    let file = read_image(input, &ImageLimits::default())?;

    let progress = screen.progress(values.len() as u64, "values");
    let inputs = [Some(input.to_owned()), global.recipe.clone()];
    let inputs = FileSet::of(&inputs.into_iter().flatten().collect::<Vec<_>>());
    let mut batch = global.batch().never_over(inputs);
    batch.take_over(of_earlier_run(job, out)?);
    let mut steps = Vec::with_capacity(values.len());
    let mut cells = Vec::with_capacity(values.len());
    let mut cracks: Option<Cracks> = None;
    for (k, (value, context)) in (1..).zip(values.into_iter().zip(contexts)) {
        interrupt.check()?;
        let simulated = cracks_for(&mut cracks, &context, job, &file)?;
        let job = ImageJob {
            stem: format!("{}.{k:02}-{}", job.stem, file_part(&value)),
            ..job.clone()
        };
        let mut file = file.clone();
        let mut watch = Stopwatch::start();
        let seed = context.seed.of_item(&job.name, 0);
        let size = (file.pixels.width(), file.pixels.height());
        let chain = Chain::of_simulated(&context.settings, simulated, size, seed, &mut watch)?;
        let written = stage_shown(&job, &mut file, chain, watch, &context, &mut batch)?;
        let caption = [format!("{key} = {value}"), figures(&written)];
        cells.push(Cell::new(&file.pixels.to_rgb8(), caption));
        steps.push(Step {
            value,
            context,
            written,
        });
        progress.step();
    }
    progress.finish();
    let title = format!("{}, seed {}", job.name, global.seed);
    let sheet = contact_sheet(&title, &cells);
    let sheet = encode_image(&sheet.into(), &Encoding::Png, None)?;
    batch.stage(&sheet_path, &sheet)?;
    batch.stage(&csv_path, csv(&key, &steps).as_bytes())?;
    interrupt.check()?;
    batch.commit()?;

    for step in &steps {
        let why = super::simulate::why_no_damage(&step.written.chain);
        let what = why.map_or_else(|| figures(&step.written), str::to_owned);
        screen.say(&format!("{key} = {}: {what}", step.value));
    }
    screen.say(&format!("all on {}", sheet_path.display()));
    screen.result(|| {
        json!({
            "output": path_text(out),
            "key": key,
            "sheet": path_text(&sheet_path),
            "csv": path_text(&csv_path),
            "steps": steps.iter().map(step_json).collect::<Vec<_>>(),
        })
    })?;
    Ok(DONE)
}

/// The key and its values: `camera.focus_distance_m=far,2,1`. Commas in brackets do not separate.
fn values_of(over: &str) -> Result<(String, Vec<String>), Failure> {
    let wrong = |what: &str| {
        Failure::wrong_input(format!(
            "--over {}: {what}; write table.key=value,value,…, e.g. camera.focus_distance_m=far,1,0.3,short",
            over.escape_debug()
        ))
    };
    let Some((key, list)) = over.split_once('=') else {
        return Err(wrong("no values"));
    };
    let mut values = vec![String::new()];
    let mut depth = 0_i32;
    for character in list.chars() {
        match character {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => {}
        }
        if character == ',' && depth == 0 {
            values.push(String::new());
        } else if let Some(value) = values.last_mut() {
            value.push(character);
        }
    }
    for value in &mut values {
        *value = value.trim().to_owned();
    }
    if values.iter().any(String::is_empty) {
        return Err(wrong("a value is empty"));
    }
    if values.len() > MOST_VALUES {
        return Err(wrong("more than 1000 values"));
    }
    Ok((key.trim().to_owned(), values))
}

/// The run of each value; all of them are valid before anything is rendered.
fn contexts(
    global: &Global,
    key: &str,
    values: &[String],
    out: &Path,
) -> Result<Vec<RunContext>, Failure> {
    let recipe = global.recipe()?;
    let of_value = |value: &String| -> Result<RunContext, Failure> {
        let mut recipe = recipe.clone();
        recipe.set(&format!("{key}={value}"))?;
        Ok(RunContext::new(&recipe, global.seed(), out)?)
    };
    values.iter().map(of_value).collect()
}

/// The cracks of a run: those of the one before, unless glass, hits or field of view differ.
fn cracks_for(
    last: &mut Option<Cracks>,
    context: &RunContext,
    job: &ImageJob,
    file: &ImageFile,
) -> Result<Simulated, Failure> {
    let settings = &context.settings;
    if let Some(cracks) = last
        && cracks.fracture == settings.fracture
        && cracks.camera == settings.camera
    {
        return Ok(cracks.simulated.clone());
    }
    let seed = context.seed.of_item(&job.name, 0);
    let size = (file.pixels.width(), file.pixels.height());
    let simulated = simulate(settings, size, seed)?;
    *last = Some(Cracks {
        fracture: settings.fracture.clone(),
        camera: settings.camera,
        simulated: simulated.clone(),
    });
    Ok(simulated)
}

/// A value as a part of a file name.
fn file_part(value: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || ['.', '-', '+'].contains(&c);
    value
        .chars()
        .take(40)
        .map(|c| if plain(c) { c } else { '_' })
        .collect()
}

/// What a caption says of a picture.
fn figures(written: &Written) -> String {
    let optics = &written.shown.optics;
    let contrast = format!("contrast {:.3}", optics.contrast.mean);
    optics.scene.map_or_else(
        || contrast.clone(),
        |scene| {
            format!(
                "glass disc {:.1} px, scene disc {:.1} px, {contrast}",
                scene.glass_disc_px, scene.scene_disc_px
            )
        },
    )
}

fn csv(key: &str, steps: &[Step]) -> String {
    let mut text = format!(
        "{key},image,f_px,glass_disc_px,scene_disc_px,contrast_mean,contrast_weber,contrast_brighter,\
         contrast_darker,contrast_rms_code,region_fraction\n"
    );
    for step in steps {
        let optics = &step.written.shown.optics;
        let contrast = &optics.contrast;
        let scene = optics.scene.map_or_else(
            || ",,".to_owned(),
            |scene| {
                format!(
                    "{},{},{}",
                    scene.f_px, scene.glass_disc_px, scene.scene_disc_px
                )
            },
        );
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{},{},{scene},{},{},{},{},{},{}",
            quoted(&step.value),
            quoted(&file_name(&step.written.image)),
            contrast.mean,
            contrast.weber,
            contrast.brighter,
            contrast.darker,
            contrast.rms_code,
            step.written.shown.region_fraction
        );
    }
    text
}

/// A field of a CSV file, quoted where it must be (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

fn file_name(path: &PathBuf) -> String {
    path.file_name().map_or_else(
        || path_text(path),
        |name| name.to_string_lossy().into_owned(),
    )
}

fn step_json(step: &Step) -> Value {
    let mut item = item_json(&step.written);
    item["value"] = json!(step.value);
    item["recipe_sha256"] = json!(step.context.recipe_sha256);
    item
}
