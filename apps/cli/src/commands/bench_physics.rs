//! The physics section of `starbreak bench`: time per stage for panes of each kind.

use std::fmt::Write as _;

use serde_json::{Value, json};
use starbreak::fracture::physics::{StoneImpact, simulate};
use starbreak::{
    Details, Error, FractureSettings, PhysicsSettings, Recipe, Seed, Settings, Stopwatch, Timings,
};

use super::bench::{Spread, spread, spread_json};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::Progress;

/// Stages in the order in which they run.
const STAGES: [&str; 7] = [
    "contact",
    "stress",
    "tips",
    "rings",
    "dice",
    "long_crack",
    "network",
];

/// The frame that the camera of the cases has, px.
const FRAME: (u32, u32) = (1242, 375);

/// Impacts by which the time of one more is measured, beside the first.
const MORE_IMPACTS: u32 = 10;

/// Distance between them, m: far beyond what one of them breaks or bends.
const APART_M: f64 = 0.1;

/// A window pane, hit hard; the other cases are presets.
const WINDOW: &str = r#"
schema = 1
[camera]
focus_distance_m = "far"
[glass]
kind = "annealed"
width_mm = 1000.0
height_mm = 800.0
thickness_mm = 4.0
distance_m = 0.5
axis_at = [0.5, 0.5]
rake_deg = 0.0
[[impact]]
speed_m_s = 30.0
radius_mm = 10.0
tip_radius_mm = 5.0
[fracture]
model = "physics"
"#;

/// All runs of one pane on one mesh.
pub(super) struct Case {
    name: &'static str,
    mesh: &'static str,
    runs: Vec<Run>,
}

struct Run {
    seed: Seed,
    timings: Timings,
    n_segments: usize,
    damage: String,
}

/// What the section has measured.
pub(super) struct Section {
    cases: Vec<Case>,
    /// Time of one more impact on a pane whose factorization is kept.
    another: Vec<(&'static str, Spread)>,
}

/// Panes that are broken: name and recipe.
fn panes() -> Result<[(&'static str, Recipe); 4], Error> {
    Ok([
        ("laminated star", Recipe::preset("windshield-star")?),
        (
            "annealed window, hit hard",
            Recipe::parse("window", WINDOW)?,
        ),
        ("tempered cover", Recipe::preset("tempered-cover")?),
        ("lens cover", Recipe::preset("lens-cover-star")?),
    ])
}

const MESHES: [&str; 2] = ["default", "fast"];

/// Number of runs that [`measure`] counts on a progress bar.
pub(super) fn n_steps(runs: u32) -> u64 {
    // Four panes and the kept factor, on each mesh.
    u64::from(runs) * 5 * MESHES.len() as u64
}

pub(super) fn measure(
    runs: u32,
    seed: Seed,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Section, Failure> {
    let mut section = Section {
        cases: Vec::new(),
        another: Vec::new(),
    };
    for mesh in MESHES {
        for (name, mut recipe) in panes()? {
            recipe.set(&format!("fracture.mesh={mesh}"))?;
            let settings = recipe.settings()?;
            // Once without counting: caches, page tables, clock of the processor.
            run_of(&settings, seed)?;
            let mut case = Case {
                name,
                mesh,
                runs: Vec::new(),
            };
            for k in 0..runs {
                interrupt.check()?;
                case.runs
                    .push(run_of(&settings, seed.of_item("bench", u64::from(k)))?);
                progress.step();
            }
            section.cases.push(case);
        }
        let mut recipe = Recipe::preset("windshield-star")?;
        recipe.set(&format!("fracture.mesh={mesh}"))?;
        if let FractureSettings::Physics(physics) = recipe.settings()?.fracture {
            let mut times = Vec::new();
            for k in 0..runs {
                interrupt.check()?;
                times.push(another_impact_ms(
                    &physics,
                    seed.of_item("bench", u64::from(k)),
                )?);
                progress.step();
            }
            section.another.push((mesh, spread(times)));
        }
    }
    Ok(section)
}

fn run_of(settings: &Settings, seed: Seed) -> Result<Run, Error> {
    let simulated = starbreak::simulate(settings, FRAME, seed)?;
    let damage = match &simulated.details {
        Details::Physics(physics) => physics.impacts.first().map_or("", |hit| hit.damage.name()),
        Details::Paper(_) | Details::Imported(_) | Details::None => "",
    };
    Ok(Run {
        seed,
        damage: damage.to_owned(),
        n_segments: simulated.network.n_segments(),
        timings: simulated.timings,
    })
}

/// Milliseconds that one more impact takes: the time of eleven, far apart, less that of one,
/// over ten.
fn another_impact_ms(settings: &PhysicsSettings, seed: Seed) -> Result<f64, Error> {
    let Some(stone) = settings.stones.first() else {
        return Ok(f64::NAN);
    };
    let [width_m, height_m] = settings.pane.outline.size_m();
    let stones: Vec<StoneImpact> = (0..=MORE_IMPACTS)
        .map(|k| {
            let from_middle = f64::from(k) - 0.5 * f64::from(MORE_IMPACTS);
            stone.at(
                [0.5 * width_m + APART_M * from_middle, 0.5 * height_m],
                0.0,
                0.0,
            )
        })
        .collect();
    let time_ms = |stones: &[StoneImpact]| -> Result<f64, Error> {
        let mut watch = Stopwatch::start();
        simulate(&settings.pane, stones, None, &settings.params, seed, |_| {})?;
        watch.lap("all");
        Ok(watch.stop().total_ms())
    };
    let one = time_ms(&stones[..1])?;
    let all = time_ms(&stones)?;
    Ok((all - one) / f64::from(MORE_IMPACTS))
}

impl Case {
    /// Time of a stage; nothing where no run had it.
    fn stage(&self, stage: &str) -> Option<Spread> {
        let times: Vec<f64> = self
            .runs
            .iter()
            .filter_map(|run| run.timings.of(stage))
            .collect();
        (!times.is_empty()).then(|| spread(times))
    }

    /// How often each damage class came, in the order of its first time.
    fn classes(&self) -> String {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for run in &self.runs {
            match counts.iter_mut().find(|(name, _)| *name == run.damage) {
                Some((_, count)) => *count += 1,
                None => counts.push((&run.damage, 1)),
            }
        }
        let said: Vec<String> = counts
            .iter()
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        said.join(", ")
    }

    fn total(&self) -> Spread {
        spread(self.runs.iter().map(|run| run.timings.total_ms()).collect())
    }
}

impl Section {
    pub(super) fn table(&self) -> String {
        let mut text =
            String::from("physics: milliseconds of a simulation on one thread: median (min-max)\n");
        let row = |text: &mut String, name: &str, spread: &Spread| {
            let Spread {
                min, median, max, ..
            } = spread;
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {name:28} {median:9.2} ({min:.2}-{max:.2})");
        };
        for case in &self.cases {
            let _ = writeln!(
                text,
                "\n{}, mesh {}, {} runs: {}",
                case.name,
                case.mesh,
                case.runs.len(),
                case.classes()
            );
            for stage in STAGES {
                if let Some(spread) = case.stage(stage) {
                    row(&mut text, stage, &spread);
                }
            }
            row(&mut text, "total", &case.total());
        }
        text.push_str("\nanother impact on a kept factor, laminated star\n");
        for (mesh, spread) in &self.another {
            row(&mut text, &format!("mesh {mesh}"), spread);
        }
        text
    }

    pub(super) fn csv(&self) -> String {
        let columns = STAGES.map(|stage| format!("{stage}_ms")).join(",");
        let mut text = format!("case,mesh,run,seed,damage_class,{columns},total_ms,segments\n");
        for case in &self.cases {
            for (k, run) in case.runs.iter().enumerate() {
                let times = STAGES
                    .map(|stage| format!("{:.4}", run.timings.of(stage).unwrap_or(0.0)))
                    .join(",");
                let _ = writeln!(
                    text,
                    "{},{},{k},{},{},{times},{:.4},{}",
                    case.name.replace(',', ""),
                    case.mesh,
                    run.seed.0,
                    run.damage,
                    run.timings.total_ms(),
                    run.n_segments
                );
            }
        }
        text
    }

    pub(super) fn to_json(&self) -> Value {
        let cases = self.cases.iter().map(|case| {
            let stages: serde_json::Map<String, Value> = STAGES
                .iter()
                .filter_map(|&stage| Some((stage.to_owned(), spread_json(&case.stage(stage)?))))
                .collect();
            json!({
                "case": case.name,
                "mesh": case.mesh,
                "runs": case.runs.len(),
                "stages_ms": stages,
                "total_ms": spread_json(&case.total()),
            })
        });
        let another = self
            .another
            .iter()
            .map(|(mesh, spread)| json!({ "mesh": mesh, "ms": spread_json(spread) }));
        json!({
            "cases": cases.collect::<Vec<_>>(),
            "another_impact": another.collect::<Vec<_>>(),
        })
    }
}
