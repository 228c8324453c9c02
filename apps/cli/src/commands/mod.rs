//! One module per verb.

mod bag;
mod bench;
mod bench_optics;
mod bench_physics;
mod boxed_clip;
mod contact_sheet;
mod crack;
mod demo;
mod detect;
mod detect_clip;
mod detect_labels;
mod divergence;
mod evaluate;
mod generate;
mod latencies;
mod network_file;
mod overlay_bank;
mod pattern_images;
mod pattern_statistics;
mod patterns;
mod pipe;
mod plot;
mod raster;
mod recipe;
mod shell;
mod simulate;
mod study;
mod study_report;
mod study_steps;
mod sweep;
mod timeline;
mod timeline_sides;
mod timeline_tracks;
mod verify;
mod video;
mod waiting_frames;

use crate::args::overlay::is_bank as is_overlay_bank;
use crate::args::patterns::PatternsArgs;
use crate::args::{Args, Global, Verb};
use crate::failure::Failure;
use crate::screen::Screen;

/// Does what the command line says.
pub(crate) fn run(args: Args, screen: &Screen) -> Result<u8, Failure> {
    let global = &args.global;
    match args.verb {
        Verb::Demo { output } => demo::run(global, &output, screen),
        Verb::Crack(args) => crack::run(global, &args, screen),
        Verb::Generate(args) => generate::run(global, &args, screen),
        Verb::Verify(args) => verify::run(global, &args, screen),
        Verb::Merge(args) => verify::merge(&args, screen),
        Verb::Detect(args) => detect::run(global, &args, screen),
        Verb::Divergence(args) => divergence::run(global, &args, screen),
        Verb::Sweep {
            input,
            output,
            over,
        } => sweep::run(global, &input, &output, &over, screen),
        Verb::Simulate(args) => simulate::run(global, &args, screen),
        Verb::Patterns(args) => bank(global, &args, screen),
        Verb::Video(args) => video::run(global, args, screen),
        Verb::Bag(args) => bag::run(global, &args, screen),
        Verb::Pipe(args) => pipe::run(global, &args, screen),
        Verb::Evaluate(args) => evaluate::run(global, &args, screen),
        Verb::Timeline(args) => timeline::run(global, &args, screen),
        Verb::Study(args) => study::run(global, &args, screen),
        Verb::Recipe { schema, list } => recipe::run(global, schema, list, screen),
        Verb::Bench(args) => bench::run(global, &args, screen),
        Verb::Completions { shell } => shell::completions(shell, screen),
        Verb::Man { output } => shell::man_pages(global, &output, screen),
    }
}

/// `starbreak patterns`: makes a bank of either kind, or says what is in one.
fn bank(global: &Global, args: &PatternsArgs, screen: &Screen) -> Result<u8, Failure> {
    if let (Some(bank), Some(output)) = (&args.images_of, &args.output) {
        args.overlay.refuse_idle(false, true)?;
        return pattern_images::run(global, bank, (args.n, output), screen);
    }
    match (&args.info, &args.check, args.n, &args.output) {
        (Some(bank), ..) | (_, Some(bank), ..) if is_overlay_bank(bank) => {
            overlay_bank::info(bank, screen)
        }
        (Some(bank), ..) => patterns::info(bank, screen),
        (_, Some(bank), ..) => patterns::check(bank, screen),
        (_, _, Some(n), Some(output)) => {
            args.overlay.refuse_idle(args.overlays.is_some(), true)?;
            match &args.overlays {
                Some(photos) => overlay_bank::run(global, args, photos, (n, output), screen),
                None => patterns::run(global, args, (n, output), screen),
            }
        }
        _ => Err(Failure::wrong_input(
            "patterns needs a number -n and a folder -o, or a folder -o and --images-of BANK, or --info BANK, or --check BANK",
        )),
    }
}
