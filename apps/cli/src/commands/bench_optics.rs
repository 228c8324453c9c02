//! The optics section of `starbreak bench`: time to bake a crack, to light it, and per frame.

use std::fmt::Write as _;

use image::DynamicImage;
use image::imageops::FilterType;
use serde_json::{Value, json};
use starbreak::glass::CrackNetwork;
use starbreak::optics::environment::Environment;
use starbreak::optics::physical::{PhysicalOptics, bake};
use starbreak::{
    DEFAULT_PRESET, Error, FractureSettings, Recipe, Scene, Seed, Settings, Stopwatch, Timings,
};
use starbreak_dataset::street_scene;

use super::bench::{Spread, spread, spread_json};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::Progress;

/// Stages of a still; a later frame needs `next_frame` alone.
const STAGES: [&str; 4] = ["bake", "light", "first_frame", "next_frame"];

/// Later frames by which one is timed.
const FRAMES: u32 = 10;

/// Frames, px.
const SIZES: [(u32, u32); 2] = [(1242, 375), (1920, 1080)];

/// Radii of the lens's disc, px: that of the design's figures, and a large one.
const RADII_PX: [f64; 2] = [7.2, 35.0];

/// All runs of one frame and one disc.
struct Case {
    size: (u32, u32),
    radius_px: f64,
    runs: Vec<Run>,
}

struct Run {
    seed: Seed,
    timings: Timings,
    n_segments: usize,
    touched_px: usize,
}

/// What the section has measured.
pub(super) struct Section {
    cases: Vec<Case>,
}

/// Number of runs that [`measure`] counts on a progress bar.
pub(super) fn n_steps(runs: u32) -> u64 {
    u64::from(runs) * (SIZES.len() * RADII_PX.len()) as u64
}

pub(super) fn measure(
    runs: u32,
    seed: Seed,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Section, Failure> {
    let settings = Recipe::preset(DEFAULT_PRESET)?.settings()?;
    let scene = DynamicImage::ImageRgb8(street_scene().image);
    let mut section = Section { cases: Vec::new() };
    for size in SIZES {
        let scene = scene.resize_exact(size.0, size.1, FilterType::Triangle);
        for radius_px in RADII_PX {
            let optics = optics_of(&settings, size, radius_px);
            let mut case = Case {
                size,
                radius_px,
                runs: Vec::new(),
            };
            // The first is not counted: caches, page tables, clock of the processor. Nor are stones
            // that leave the glass whole.
            let mut k = 0;
            while case.runs.len() <= runs as usize && k < 20 * (u64::from(runs) + 1) {
                interrupt.check()?;
                let seed = seed.of_item("bench", k);
                k += 1;
                let network = starbreak::simulate(&settings, size, seed)?.network;
                if network.n_segments() == 0 {
                    continue;
                }
                if !case.runs.is_empty() {
                    progress.step();
                }
                case.runs
                    .push(run_of(&settings, &optics, &network, &scene, seed)?);
            }
            case.runs.drain(..1.min(case.runs.len()));
            section.cases.push(case);
        }
    }
    Ok(section)
}

/// The default lens at its f-number, with the focal length that makes a disc of this radius where
/// the optical axis meets the pane.
fn optics_of(settings: &Settings, size: (u32, u32), radius_px: f64) -> PhysicalOptics {
    let mut optics = PhysicalOptics::default();
    if let FractureSettings::Physics(physics) = &settings.fracture {
        let f_px = settings.camera.f_px.of_frame(size.0);
        let lens = &mut optics.lens;
        let per_aperture = f_px * (1.0 / physics.mount.distance_m - 1.0 / lens.focus_m);
        lens.focal_length_m = lens.f_number * 2.0 * radius_px / per_aperture;
    }
    optics
}

fn run_of(
    settings: &Settings,
    optics: &PhysicalOptics,
    network: &CrackNetwork,
    scene: &DynamicImage,
    seed: Seed,
) -> Result<Run, Error> {
    let view = Scene::of(settings, (scene.width(), scene.height())).pane()?;
    let mut still = scene.clone();
    let mut watch = Stopwatch::start();
    let pattern = bake(network, f64::INFINITY, &view, optics, seed)?;
    watch.lap("bake");
    let environment = Environment::estimate(&still, &optics.environment, pattern.f_px());
    let overlay = pattern.light(&environment, optics);
    watch.lap("light");
    overlay.apply(&mut still, seed)?;
    watch.lap("first_frame");
    let mut times = Vec::new();
    for _ in 0..FRAMES {
        let mut frame = scene.clone();
        let mut watch = Stopwatch::start();
        overlay.apply(&mut frame, seed)?;
        watch.lap("next_frame");
        times.push(watch.stop());
    }
    times.sort_by(|a, b| a.total_ms().total_cmp(&b.total_ms()));
    let mut timings = watch.stop();
    timings.append(times.swap_remove(times.len() / 2));
    let region = overlay.region();
    Ok(Run {
        seed,
        timings,
        n_segments: network.n_segments(),
        touched_px: region.as_raw().iter().filter(|level| **level > 0).count(),
    })
}

impl Run {
    /// Milliseconds from the network to the first frame.
    fn still_ms(&self) -> f64 {
        let of = |stage: &&str| self.timings.of(stage).unwrap_or(f64::NAN);
        STAGES.iter().take(3).map(of).sum()
    }
}

impl Case {
    fn stage(&self, stage: &str) -> Spread {
        let times = self.runs.iter().filter_map(|run| run.timings.of(stage));
        spread(times.collect())
    }

    fn still(&self) -> Spread {
        spread(self.runs.iter().map(Run::still_ms).collect())
    }

    #[expect(clippy::cast_precision_loss, reason = "counts of pixels and segments")]
    fn median_of(&self, count: impl Fn(&Run) -> usize) -> f64 {
        spread(self.runs.iter().map(|run| count(run) as f64).collect()).median
    }
}

impl Section {
    pub(super) fn table(&self) -> String {
        let mut text =
            format!("optics: milliseconds of {DEFAULT_PRESET} on one thread: median (min-max)\n");
        for case in &self.cases {
            let (width, height) = case.size;
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "\n{width} x {height}, disc of radius {} px, {} runs: {} segments, {} px touched",
                case.radius_px,
                case.runs.len(),
                case.median_of(|run| run.n_segments),
                case.median_of(|run| run.touched_px),
            );
            let mut row = |name: &str, spread: &Spread| {
                let Spread {
                    min, median, max, ..
                } = spread;
                let _ = writeln!(text, "  {name:28} {median:9.3} ({min:.3}-{max:.3})");
            };
            for stage in STAGES {
                row(stage, &case.stage(stage));
            }
            row("bake to first frame", &case.still());
        }
        text
    }

    pub(super) fn csv(&self) -> String {
        let columns = STAGES.map(|stage| format!("{stage}_ms")).join(",");
        let mut text = format!(
            "width_px,height_px,radius_px,run,seed,{columns},still_ms,segments,touched_px\n"
        );
        for case in &self.cases {
            for (k, run) in case.runs.iter().enumerate() {
                let times = STAGES
                    .map(|stage| format!("{:.4}", run.timings.of(stage).unwrap_or(f64::NAN)))
                    .join(",");
                let _ = writeln!(
                    text,
                    "{},{},{},{k},{},{times},{:.4},{},{}",
                    case.size.0,
                    case.size.1,
                    case.radius_px,
                    run.seed.0,
                    run.still_ms(),
                    run.n_segments,
                    run.touched_px
                );
            }
        }
        text
    }

    pub(super) fn to_json(&self) -> Value {
        let cases = self.cases.iter().map(|case| {
            let stages: serde_json::Map<String, Value> = STAGES
                .iter()
                .map(|&stage| (stage.to_owned(), spread_json(&case.stage(stage))))
                .collect();
            json!({
                "width_px": case.size.0,
                "height_px": case.size.1,
                "radius_px": case.radius_px,
                "runs": case.runs.len(),
                "segments": case.median_of(|run| run.n_segments),
                "touched_px": case.median_of(|run| run.touched_px),
                "stages_ms": stages,
                "still_ms": spread_json(&case.still()),
            })
        });
        json!({ "cases": cases.collect::<Vec<_>>() })
    }
}
