//! `starbreak bag`: a recording in MCAP to the same with its cameras behind broken glass.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use starbreak::Recipe;
use starbreak_runs::bag::{Added, Bag, BagReport, BagRequest, CameraReport, CameraRequest, Damage};
use starbreak_runs::{RunContext, with_threads};

use crate::args::Global;
use crate::args::bag::BagArgs;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

pub(crate) fn run(global: &Global, args: &BagArgs, screen: &Screen) -> Result<u8, Failure> {
    let request = request_of(global, args)?;
    let interrupt = Interrupt::listen(screen);
    let bag = Bag::open(request)?;
    let progress = screen.progress(bag.n_frames().unwrap_or(0), "images");
    let started = Instant::now();
    let report = with_threads(usize::from(global.threads), || {
        bag.run(interrupt.flag(), || progress.step())
    })?;
    progress.finish();
    let Some(report) = report? else {
        return Err(Failure::interrupted(
            "interrupted: nothing was written; run the command again",
        ));
    };
    let elapsed_s = started.elapsed().as_secs_f64();
    let name = args.output.display();
    screen.say(&format!(
        "{name}: {} messages in {elapsed_s:.1} s",
        report.n_messages
    ));
    for camera in &report.cameras {
        screen.say(&describe(camera));
    }
    screen.result(|| result_json(args, &report, elapsed_s))?;
    match &report.damage {
        None => Ok(DONE),
        Some(damage) => Err(Failure {
            message: format!(
                "{:?} is not whole: {damage}; all that was read is written",
                args.input
            ),
            code: SOME_FAILED,
        }),
    }
}

fn request_of(global: &Global, args: &BagArgs) -> Result<BagRequest, Failure> {
    global.refuse_recipe_among(std::slice::from_ref(&args.output))?;
    let context = |recipe: &Recipe| RunContext::new(recipe, global.seed(), &args.output);
    let cameras = args.topic.iter().map(|camera| {
        let recipe = match &camera.recipe {
            Some(word) if is_preset(word) => global.preset_called(word)?,
            Some(file) => global.recipe_in(Path::new(file), &args.output)?,
            None => global.recipe()?,
        };
        Ok(CameraRequest {
            topic: camera.topic.clone(),
            context: context(&recipe)?,
        })
    });
    let cameras = cameras.collect::<Result<Vec<_>, Failure>>()?;
    refuse_names(args)?;
    let all = match cameras.as_slice() {
        [] => Some(context(&global.recipe()?)?),
        _ => None,
    };
    let masks = args.masks.then_some([Added::Region, Added::Track]);
    let control = args.control.then_some(Added::Control);
    Ok(BagRequest {
        input: args.input.clone(),
        output: args.output.clone(),
        cameras,
        all,
        impact_at: args.impact_at,
        growth: args.growth.growth(),
        light: args.light.light(),
        added: masks.into_iter().flatten().chain(control).collect(),
        replaces: global.replace,
    })
}

/// Names that would be taken for what they are not: folders as rosbag2 writes them, standard output, bags of another kind.
fn refuse_names(args: &BagArgs) -> Result<(), Failure> {
    let BagArgs { input, output, .. } = args;
    if input.is_dir() {
        return Err(Failure::wrong_input(format!(
            "{input:?} is a folder; give the .mcap in it"
        )));
    }
    if !output
        .extension()
        .is_some_and(|it| it.eq_ignore_ascii_case("mcap"))
    {
        return Err(Failure::wrong_input(format!(
            "the output {output:?} would be MCAP; give it a name that ends in .mcap"
        )));
    }
    Ok(())
}

/// Whether a word is a preset, or a name like one where no file is: it is then told which presets there are.
fn is_preset(word: &str) -> bool {
    let is_name = word
        .chars()
        .all(|it| it.is_ascii_alphanumeric() || it == '-');
    Recipe::preset(word).is_ok() || is_name && !Path::new(word).exists()
}

fn describe(camera: &CameraReport) -> String {
    let CameraReport {
        topic,
        n_frames,
        n_altered,
        ..
    } = camera;
    let onset = camera
        .damage_onset
        .filter(|(idx, _)| *idx > 0)
        .map_or_else(String::new, |(idx, time_s)| {
            format!(", damage from image {idx} ({time_s:.3} s)")
        });
    let growth = match camera.n_growing {
        0 => String::new(),
        n => format!(", growing for {n}"),
    };
    format!(
        "{}: {n_altered} of {n_frames} images damaged{onset}{growth}; {:.1} % of the last one affected",
        topic.escape_debug(),
        camera.region_fraction * 100.0
    )
}

fn result_json(args: &BagArgs, report: &BagReport, elapsed_s: f64) -> Value {
    let place = |place: Option<(u64, f64)>| {
        place.map(|(idx, time_s)| json!({ "frame_idx": idx, "time_s": time_s }))
    };
    let cameras: Vec<Value> = (report.cameras.iter())
        .map(|camera| {
            json!({
                "topic": camera.topic,
                "item": { "name": camera.name, "sample_index": 0, "seed": camera.seed },
                "n_frames": camera.n_frames,
                "n_altered": camera.n_altered,
                "n_growing": camera.n_growing,
                "sizes_px": camera.sizes,
                "damage_onset": place(camera.damage_onset),
                "first_visible": place(camera.first_visible),
                "region_fraction": camera.region_fraction,
            })
        })
        .collect();
    let damage = report.damage.as_ref();
    json!({
        "output": path_text(&args.output),
        "n_messages": report.n_messages,
        "cameras": cameras,
        "input_damage": damage.map(Damage::to_json),
        "elapsed_s": elapsed_s,
    })
}
