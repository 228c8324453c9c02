//! `starbreak bench`: the paper's timing figure on this machine, and the time of physics and optics.

use std::fmt::Write as _;

use image::DynamicImage;
use serde_json::{Value, json};
use starbreak::fracture::paper::PaperParams;
use starbreak::{Chain, FractureSettings, Recipe, Seed, Settings, Stopwatch, Timings, simulate};
use starbreak_dataset::street_scene;
use starbreak_runs::with_threads;

use super::{bench_optics, bench_physics, plot, raster};
use crate::args::Global;
use crate::args::bench::{BenchArgs, BenchModel};
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Progress, Screen, path_text};

/// Stages in the order in which they run, and the module of the paper's figure they belong to.
const STAGES: [(&str, &str); 6] = [
    ("mesh", "simulation"),
    ("propagation", "simulation"),
    ("mst", "simulation"),
    ("network", "simulation"),
    ("draw", "cracking visualization"),
    ("render", "render"),
];

/// Numbers of particles, unless asked for others.
const PARTICLES: [u32; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Runs per number of particles, unless asked for others.
const PAPER_RUNS: u32 = 100;

/// Runs per pane of the physics, unless asked for others.
const PHYSICS_RUNS: u32 = 10;

/// Runs per frame and disc of the optics, unless asked for others.
const OPTICS_RUNS: u32 = 10;

/// All runs with one number of particles.
struct Series {
    particles: u32,
    radius_px: f64,
    runs: Vec<Run>,
    peak_rss_mib: Option<f64>,
}

struct Run {
    seed: Seed,
    timings: Timings,
    n_segments: usize,
}

/// Minimum, mean, median and maximum.
pub(super) struct Spread {
    pub(super) min: f64,
    pub(super) mean: f64,
    pub(super) median: f64,
    pub(super) max: f64,
}

pub(crate) fn run(global: &Global, args: &BenchArgs, screen: &Screen) -> Result<u8, Failure> {
    let names = [
        "bench.csv",
        "bench.txt",
        "bench.svg",
        "bench.png",
        "bench-physics.csv",
        "bench-optics.csv",
    ];
    global.refuse_recipe_among(&names.map(|name| args.output.join(name)))?;
    refuse_idle_recipe(global, args)?;
    let interrupt = Interrupt::listen(screen);
    let mut batch = global.batch();
    let mut tables = Vec::new();
    let mut result = json!({ "output": path_text(&args.output) });
    let is_asked = |model| args.model.is_none_or(|only| only == model);
    // Measured for minutes before they are written; those of one model have its name.
    for name in names {
        let model = match name {
            "bench-physics.csv" => BenchModel::Physics,
            "bench-optics.csv" => BenchModel::Optics,
            _ => BenchModel::Paper,
        };
        if is_asked(model) {
            batch.may_write(&args.output.join(name))?;
        }
    }
    if is_asked(BenchModel::Paper) {
        let series = paper_series(global, args, &interrupt, screen)?;
        let figure = plot::timing_figure(&series_for_plot(&series));
        batch.stage(&args.output.join("bench.csv"), csv(&series).as_bytes())?;
        batch.stage(&args.output.join("bench.svg"), figure.svg().as_bytes())?;
        batch.stage(&args.output.join("bench.png"), &raster::png(&figure)?)?;
        tables.push(table(&series));
        result["series"] = series.iter().map(series_json).collect();
    }
    if is_asked(BenchModel::Physics) {
        let runs = args.runs.unwrap_or(PHYSICS_RUNS);
        let progress = screen.progress(bench_physics::n_steps(runs), "runs");
        let section = with_threads(1, || {
            bench_physics::measure(runs, global.seed(), &interrupt, &progress)
        })??;
        progress.finish();
        let csv = section.csv();
        batch.stage(&args.output.join("bench-physics.csv"), csv.as_bytes())?;
        tables.push(section.table());
        result["physics"] = section.to_json();
    }
    if is_asked(BenchModel::Optics) {
        let runs = args.runs.unwrap_or(OPTICS_RUNS);
        let progress = screen.progress(bench_optics::n_steps(runs), "runs");
        let section = with_threads(1, || {
            bench_optics::measure(runs, global.seed(), &interrupt, &progress)
        })??;
        progress.finish();
        let csv = section.csv();
        batch.stage(&args.output.join("bench-optics.csv"), csv.as_bytes())?;
        tables.push(section.table());
        result["optics"] = section.to_json();
    }
    let table = tables.join("\n");
    batch.stage(&args.output.join("bench.txt"), table.as_bytes())?;
    batch.commit()?;
    screen.say(&table);
    screen.say(&format!(
        "bench.txt with every run as CSV in {}",
        args.output.display()
    ));
    screen.result(|| result)?;
    Ok(DONE)
}

/// Refuses what says which recipe, or how to change it, where none is heard.
fn refuse_idle_recipe(global: &Global, args: &BenchArgs) -> Result<(), Failure> {
    let (model, measured) = match args.model {
        Some(BenchModel::Physics) => ("physics", "panes"),
        Some(BenchModel::Optics) => ("optics", "cracks"),
        Some(BenchModel::Paper) | None => return Ok(()),
    };
    let of_paper = [
        (args.particles.is_some(), "particles"),
        (args.fixed_radius, "fixed-radius"),
    ];
    let idle = of_paper
        .iter()
        .find_map(|(is_given, flag)| is_given.then_some(*flag));
    match global.recipe_flag().or(idle) {
        Some(flag) => Err(Failure::wrong_input(format!(
            "`bench --model {model}` measures the same {measured} always, so it has no use for --{flag}; leave it out"
        ))),
        None => Ok(()),
    }
}

/// The paper's series: one for each number of particles.
fn paper_series(
    global: &Global,
    args: &BenchArgs,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<Vec<Series>, Failure> {
    let recipe = global.recipe_or("paper")?;
    let mut plan = Vec::new();
    for &particles in args.particles.as_deref().unwrap_or(&PARTICLES) {
        plan.push((
            particles,
            settings_for(&recipe, particles, args.fixed_radius)?,
        ));
    }
    let runs = args.runs.unwrap_or(PAPER_RUNS);
    let scene = DynamicImage::ImageRgb8(street_scene().image);
    let progress = screen.progress(u64::from(runs) * plan.len() as u64, "runs");
    // One thread, whatever the machine has: times per core are what can be compared.
    let series = with_threads(1, || {
        measure(&plan, runs, &scene, global.seed(), interrupt, &progress)
    })??;
    progress.finish();
    Ok(series)
}

fn settings_for(recipe: &Recipe, particles: u32, fixed_radius: bool) -> Result<Settings, Failure> {
    let mut recipe = recipe.clone();
    recipe.set(&format!("fracture.particles={particles}"))?;
    if !fixed_radius {
        let radius = PaperParams::mesh_scaled_radius(particles);
        recipe.set(&format!("fracture.neighbour_radius_px={radius:?}"))?;
    }
    Ok(recipe.settings()?)
}

fn measure(
    plan: &[(u32, Settings)],
    runs: u32,
    scene: &DynamicImage,
    seed: Seed,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Vec<Series>, Failure> {
    let mut all = Vec::new();
    for (particles, settings) in plan {
        // Once without counting: caches, page tables, clock of the processor.
        damaged(settings, &mut scene.clone(), seed)?;
        let mut series = Series {
            particles: *particles,
            radius_px: match &settings.fracture {
                FractureSettings::Paper(paper) => paper.params.neighbor_radius,
                FractureSettings::Physics(_) | FractureSettings::None(_) => f64::NAN,
            },
            runs: Vec::new(),
            peak_rss_mib: None,
        };
        for k in 0..runs {
            interrupt.check()?;
            let seed = seed.of_item("bench", u64::from(k));
            let mut image = scene.clone();
            let (n_segments, timings) = damaged(settings, &mut image, seed)?;
            series.runs.push(Run {
                seed,
                timings,
                n_segments,
            });
            progress.step();
        }
        series.peak_rss_mib = peak_rss_mib();
        all.push(series);
    }
    Ok(all)
}

/// Breaks the glass before an image and shows it there: how many segments, and how long it took.
fn damaged(
    settings: &Settings,
    image: &mut DynamicImage,
    seed: Seed,
) -> Result<(usize, Timings), Failure> {
    let size = (image.width(), image.height());
    let simulated = simulate(settings, size, seed)?;
    let n_segments = simulated.network.n_segments();
    let mut watch = Stopwatch::start();
    let chain = Chain::of_simulated(settings, simulated, size, seed, &mut watch)?;
    chain.over_and_report(image, seed, &[], &mut watch)?;
    chain.crack_mask()?;
    watch.lap("masks");
    Ok((n_segments, watch.stop()))
}

/// Largest resident set of this process so far; only Linux tells.
fn peak_rss_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

pub(super) fn spread(mut values: Vec<f64>) -> Spread {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let at = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
    Spread {
        min: at(0),
        mean,
        median: f64::midpoint(at(n.saturating_sub(1) / 2), at(n / 2)),
        max: at(n.saturating_sub(1)),
    }
}

impl Series {
    fn stage(&self, stage: &str) -> Spread {
        spread(
            self.runs
                .iter()
                .filter_map(|run| run.timings.of(stage))
                .collect(),
        )
    }

    fn module(&self, module: &str) -> Spread {
        let of_run = |run: &Run| {
            let stages = STAGES.iter().filter(|(_, of)| *of == module);
            stages.filter_map(|(stage, _)| run.timings.of(stage)).sum()
        };
        spread(self.runs.iter().map(of_run).collect())
    }

    fn total(&self) -> Spread {
        spread(self.runs.iter().map(|run| run.timings.total_ms()).collect())
    }
}

fn table(series: &[Series]) -> String {
    let mut text = String::from("milliseconds on one thread, 1242 x 375: median (min-max)\n");
    for one in series {
        let rss = one
            .peak_rss_mib
            .map_or(String::new(), |mib| format!(", peak RSS {mib:.0} MiB"));
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "\n{} particles, radius {:.2} px, {} runs{rss}",
            one.particles,
            one.radius_px,
            one.runs.len()
        );
        let mut row = |name: &str, spread: &Spread| {
            let Spread {
                min, median, max, ..
            } = spread;
            let _ = writeln!(text, "  {name:28} {median:9.2} ({min:.2}-{max:.2})");
        };
        for (stage, module) in STAGES {
            row(&format!("{stage} [{module}]"), &one.stage(stage));
        }
        row("total", &one.total());
    }
    text
}

fn csv(series: &[Series]) -> String {
    let stages: Vec<String> = STAGES
        .iter()
        .map(|(stage, _)| format!("{stage}_ms"))
        .collect();
    let mut text = format!(
        "particles,radius_px,run,seed,{},total_ms,segments\n",
        stages.join(",")
    );
    for one in series {
        for (k, run) in one.runs.iter().enumerate() {
            let times: Vec<String> = STAGES
                .iter()
                .map(|(stage, _)| format!("{:.4}", run.timings.of(stage).unwrap_or(f64::NAN)))
                .collect();
            let _ = writeln!(
                text,
                "{},{},{k},{},{},{:.4},{}",
                one.particles,
                one.radius_px,
                run.seed.0,
                times.join(","),
                run.timings.total_ms(),
                run.n_segments
            );
        }
    }
    text
}

/// The three modules of the paper's figure, and their total, over the number of particles.
fn series_for_plot(series: &[Series]) -> Vec<(&'static str, Vec<(f64, Spread)>)> {
    let over = |of: &dyn Fn(&Series) -> Spread| -> Vec<(f64, Spread)> {
        series
            .iter()
            .map(|one| (f64::from(one.particles), of(one)))
            .collect()
    };
    let mut lines: Vec<_> = ["simulation", "cracking visualization", "render"]
        .map(|module| (module, over(&|one: &Series| one.module(module))))
        .into_iter()
        .collect();
    lines.push(("total", over(&Series::total)));
    lines
}

pub(super) fn spread_json(spread: &Spread) -> Value {
    json!({
        "min": spread.min,
        "mean": spread.mean,
        "median": spread.median,
        "max": spread.max,
    })
}

fn series_json(one: &Series) -> Value {
    let stages: serde_json::Map<String, Value> = STAGES
        .iter()
        .map(|(stage, _)| ((*stage).to_owned(), spread_json(&one.stage(stage))))
        .collect();
    json!({
        "particles": one.particles,
        "radius_px": one.radius_px,
        "runs": one.runs.len(),
        "stages_ms": stages,
        "total_ms": spread_json(&one.total()),
        "peak_rss_mib": one.peak_rss_mib,
    })
}
