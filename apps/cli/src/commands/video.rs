//! `starbreak video`: a clip or a folder of frames to the same behind broken glass.

use std::path::PathBuf;
use std::time::Instant;

use serde_json::{Map, Value, json};
use starbreak::Recipe;
use starbreak_dataset::DatasetError;
use starbreak_runs::clip::{Clip, ClipReport, ClipRequest};
use starbreak_runs::{Patterns, RunContext, with_threads};

use super::generate::{patterns, recipe_of_bank};
use super::simulate::{radius_hint, why_no_damage};
use crate::args::Global;
use crate::args::video::{DamageArgs, VideoArgs};
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

pub(crate) fn run(global: &Global, args: VideoArgs, screen: &Screen) -> Result<u8, Failure> {
    let request = request_of(&args)?;
    let outputs = [request.output.clone(), request.track(), request.network()];
    global.refuse_recipe_among(&outputs)?;
    let (patterns, recipe) = damage_of(global, &args.damage, &outputs)?;
    let mut context = RunContext::new(&recipe, global.seed(), &request.output)?;
    context.replaces = global.replace;
    args.damage
        .overlay_args
        .refuse_idle_gain(&context.settings)?;
    let interrupt = Interrupt::listen(screen);
    let clip = Clip::open(request.clone())?;
    if clip.has_rare_pixels() {
        let (width, height) = clip.size();
        screen.note(&format!(
            "note: {width} x {height} px has an odd side, so the clip is H.264 with all of its chroma (4:4:4), which \
             browsers and phones do not show; choose .avi, or crop the frames to even sides"
        ));
    }
    for note in notes(&clip) {
        screen.note(&note);
    }
    if matches!(patterns, Patterns::Fresh)
        && let Some(hint) = radius_hint(&context.settings, clip.size())
    {
        screen.note(&hint);
    }
    let progress = screen.progress(clip.n_frames(), "frames");
    let started = Instant::now();
    let report = with_threads(usize::from(global.threads), || {
        clip.run(&context, &patterns, interrupt.flag(), || progress.step())
    })?;
    progress.finish();
    let Some(report) = report? else {
        return Err(Failure::interrupted(
            "interrupted: nothing was written; run the command again",
        ));
    };
    let elapsed_s = started.elapsed().as_secs_f64();
    screen.say(&describe(&request, &report, elapsed_s));
    screen.result(|| result_json(&request, &clip, &report, elapsed_s))?;
    Ok(DONE)
}

/// What the clip loses, and what the user may not expect of it.
fn notes(clip: &Clip) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some((bits, has_alpha)) = clip.reduction() {
        let bits = (bits > 8).then(|| format!("{bits} bits per channel"));
        let alpha = has_alpha.then(|| "alpha".to_owned());
        let more: Vec<String> = bits.into_iter().chain(alpha).collect();
        notes.push(format!(
            "note: the input has {}; its frames are read and written as 8-bit RGB",
            more.join(" and ")
        ));
    }
    if let Some(transfer) = clip.high_dynamic_range() {
        notes.push(format!(
            "note: the input is of high dynamic range ({transfer}), for which 8 bits are few: expect banding"
        ));
    }
    notes
}

/// What is put over the frames, and its recipe. None of the outputs is what that is read from.
pub(super) fn damage_of(
    global: &Global,
    args: &DamageArgs,
    outputs: &[PathBuf],
) -> Result<(Patterns, Recipe), Failure> {
    let patterns = patterns(
        args.overlay_args
            .read_one(args.overlay.as_deref(), args.overlay_random, outputs)?,
        (args.bank.as_deref(), global.max_memory),
        args.network.as_deref(),
        outputs,
    )?;
    let recipe = match &patterns {
        Patterns::Bank(bank) => recipe_of_bank(bank, global)?,
        _ => global.recipe()?,
    };
    Ok((patterns, recipe))
}

fn request_of(args: &VideoArgs) -> Result<ClipRequest, Failure> {
    let fps = args.fps.as_deref().map(str::parse).transpose();
    Ok(ClipRequest {
        input: args.input.clone(),
        output: args.output.clone(),
        impact_at_s: args.damage.impact_at,
        growth: args.damage.growth.growth(),
        masks: args.masks.clone(),
        fps: fps.map_err(|error| Failure::from(DatasetError::Video(error)))?,
        is_lossless: args.lossless,
        light: args.light.light(),
        ffmpeg: args.reader.ffmpeg.clone(),
    })
}

fn describe(request: &ClipRequest, report: &ClipReport, elapsed_s: f64) -> String {
    let name = request.output.display();
    #[expect(clippy::cast_precision_loss, reason = "counts, for a rate")]
    let rate = report.n_frames as f64 / elapsed_s.max(1e-9);
    let frames = format!(
        "{} frames in {elapsed_s:.1} s ({rate:.1} per second)",
        report.n_frames
    );
    // What lies on the glass may come later than the first frame, of which the chain is.
    let shows_nothing = report.first_visible.is_none();
    if let Some(why) = why_no_damage(&report.chain).filter(|_| shows_nothing) {
        return format!("{name}: {why}; {frames}");
    }
    let onset = report
        .damage_onset
        .map_or_else(String::new, |(idx, time_s)| {
            format!(", damage from frame {idx} ({time_s:.3} s)")
        });
    let growth = match report.n_growing {
        0 => String::new(),
        n => format!(", growing for {n}"),
    };
    let cracks = report.chain.network().map_or_else(String::new, |network| {
        format!("{} segments, ", network.n_segments())
    });
    format!(
        "{name}: {frames}{onset}{growth}; {cracks}{:.1} % of the last frame affected",
        report.region_fraction * 100.0
    )
}

fn result_json(request: &ClipRequest, clip: &Clip, report: &ClipReport, elapsed_s: f64) -> Value {
    let (width_px, height_px) = clip.size();
    let rate = clip.rate();
    let place = |(idx, time_s)| json!({ "frame_idx": idx, "time_s": time_s });
    let onset = report.damage_onset.map(place);
    let first_visible = report.first_visible.map(place);
    Value::Object(Map::from_iter(
        [
            ("output", json!(path_text(&request.output))),
            ("track", json!(path_text(request.track()))),
            (
                "network",
                json!(report.chain.network().map(|_| path_text(request.network()))),
            ),
            ("masks", json!(request.masks.as_ref().map(path_text))),
            ("n_frames", json!(report.n_frames)),
            ("fps", json!(rate.value())),
            (
                "fps_fraction",
                json!([rate.numerator(), rate.denominator()]),
            ),
            ("width_px", json!(width_px)),
            ("height_px", json!(height_px)),
            ("damage_onset", json!(onset)),
            ("first_visible", json!(first_visible)),
            ("n_growing", json!(report.n_growing)),
            ("n_lights", json!(report.n_lights)),
            ("region_fraction", json!(report.region_fraction)),
            (
                "intact",
                json!(report.chain.is_intact() && report.first_visible.is_none()),
            ),
            (
                "summary",
                json!(report.chain.network().map(|network| network.summary())),
            ),
            ("elapsed_s", json!(elapsed_s)),
        ]
        .map(|(key, value)| (key.to_owned(), value)),
    ))
}
