//! One module per verb.

mod bench;
mod bench_optics;
mod bench_physics;
mod contact_sheet;
mod crack;
mod demo;
mod detect;
mod detect_clip;
mod detect_labels;
mod divergence;
mod evaluate;
mod generate;
mod network_file;
mod overlay_bank;
mod pattern_statistics;
mod patterns;
mod plot;
mod raster;
mod recipe;
mod shell;
mod simulate;
mod study;
mod study_report;
mod sweep;
mod timeline;
mod timeline_sides;
mod timeline_tracks;
mod verify;
mod video;

use std::process::ExitCode;

use crate::args::overlay::is_bank as is_overlay_bank;
use crate::args::{Args, Verb};
use crate::failure::Failure;
use crate::screen::Screen;

/// Does what the command line says.
pub(crate) fn run(args: Args, screen: &Screen) -> Result<ExitCode, Failure> {
    let global = &args.global;
    match args.verb {
        Verb::Demo { output } => demo::run(global, &output, screen),
        Verb::Crack {
            inputs,
            output,
            maps,
            network,
            overlay,
            overlay_random,
            overlay_args,
        } => {
            let request = crack::Request {
                inputs,
                out: output,
                maps,
                network,
                overlay,
                overlay_random,
                overlay_args,
            };
            crack::run(global, &request, screen)
        }
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
        Verb::Simulate {
            output,
            svg,
            network,
            size,
            frames,
            frames_to,
            timings,
        } => {
            let request = simulate::Request {
                svg,
                network,
                size,
                frames: frames.map(|n_frames| {
                    (
                        n_frames,
                        frames_to.unwrap_or_else(|| simulate::frames_beside(output.as_deref())),
                    )
                }),
                output,
                timings,
            };
            simulate::run(global, &request, screen)
        }
        Verb::Patterns {
            n,
            output,
            size,
            sizes_of,
            most_sizes,
            overlays,
            overlay,
            info,
            check,
        } => match (info, check, n, output) {
            (Some(bank), ..) if is_overlay_bank(&bank) => overlay_bank::info(&bank, screen),
            (_, Some(bank), ..) if is_overlay_bank(&bank) => overlay_bank::info(&bank, screen),
            (Some(bank), ..) => patterns::info(&bank, screen),
            (_, Some(bank), ..) => patterns::check(&bank, screen),
            (_, _, Some(n), Some(output)) => {
                overlay.refuse_idle(overlays.is_some(), true)?;
                if let Some(photos) = overlays {
                    let request = overlay_bank::Request {
                        photos,
                        options: overlay.options(true)?,
                        n,
                        sizes: size,
                        output,
                    };
                    return overlay_bank::run(global, &request, screen);
                }
                let sizes = match sizes_of {
                    Some(source) => patterns::sizes_of(global, &source, most_sizes, screen)?,
                    None => size,
                };
                let request = patterns::Request { n, output, sizes };
                patterns::run(global, &request, screen)
            }
            _ => Err(Failure::wrong_input(
                "patterns needs a number -n and a folder -o, or --info BANK, or --check BANK",
            )),
        },
        Verb::Video(args) => video::run(global, args, screen),
        Verb::Evaluate(args) => evaluate::run(global, &args, screen),
        Verb::Timeline(args) => timeline::run(global, &args, screen),
        Verb::Study(args) => study::run(global, &args, screen),
        Verb::Recipe { schema, list } => recipe::run(global, schema, list, screen),
        Verb::Bench {
            output,
            particles,
            runs,
            fixed_radius,
            model,
        } => {
            let request = bench::Request {
                output,
                particles,
                runs,
                fixed_radius,
                model,
            };
            bench::run(global, &request, screen)
        }
        Verb::Completions { shell } => shell::completions(shell, screen),
        Verb::Man { output } => shell::man_pages(global, &output, screen),
    }
}
