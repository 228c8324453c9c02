//! `starbreak simulate`: the crack network alone.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use starbreak::fracture::physics::ImpactReport;
use starbreak::glass::{CrackNetwork, Pane};
use starbreak::{
    Chain, Details, FractureSettings, PaperSettings, Scene, Settings, Simulated, growth_drawing,
    growth_times,
};
use starbreak_dataset::{AnimationParams, OutputBatch, encode_animation, encode_mask};

use super::network_file;
use crate::args::Global;
use crate::args::simulate::SimulateArgs;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// What to tell of a chain that shows no crack; nothing where there is one, or a photograph.
pub(super) fn why_no_damage(chain: &Chain) -> Option<&'static str> {
    if !chain.is_intact() || chain.photo().is_some() {
        return None;
    }
    let settings = chain.settings();
    match chain.network().zip(chain.details()) {
        Some((network, details)) => why_intact(network, details),
        None if settings.drops.is_some() || !settings.coats.is_empty() => Some(
            "nothing is seen on the glass: by its age it has not come yet or is gone, or optics.dashboard_rows hides it",
        ),
        None => Some("nothing is broken"),
    }
}

/// What to tell when there is no crack; nothing where there is one.
fn why_intact(network: &CrackNetwork, details: &Details) -> Option<&'static str> {
    if network.n_segments() > 0 {
        return None;
    }
    let paper = match details {
        Details::Paper(paper) => paper,
        Details::Imported(_) => return Some("the network has no cracks"),
        Details::None => return Some("fracture.model is \"none\": no glass breaks"),
        Details::Physics(_) => {
            return Some(
                "nothing broke: the stone is too slow or too blunt for this glass; raise impact.speed_m_s or \
                 impact.radius_mm, or --severity",
            );
        }
    };
    let all_too_weak = paper.convergence.impacts_without_fracture == network.data().impacts.len();
    Some(if all_too_weak {
        "nothing broke: no impact.force exceeds fracture.critical_stress / fracture.safety_factor (eq. 2)"
    } else {
        "the glass breaks, but no particle within fracture.neighbour_radius_px of the impact is stressed above the \
         threshold, so there is no crack"
    })
}

/// Fewer neighbors than this make hardly any crack; the paper has 285.
const FEW_NEIGHBORS: f64 = 15.0;

/// A hint where the radius is too small for the frame.
pub(super) fn radius_hint(
    settings: &Settings,
    (width_px, height_px): (u32, u32),
) -> Option<String> {
    let FractureSettings::Paper(PaperSettings { params, .. }) = &settings.fracture else {
        return None;
    };
    let pane = Pane::from_frame_px(width_px, height_px);
    let neighbors = params.expected_neighbors(&pane);
    (neighbors < FEW_NEIGHBORS).then(|| {
        format!(
            "note: on {width_px} x {height_px} px the radius spans only {neighbors:.1} particles (the paper: 285), so \
             there is hardly a crack; try --set fracture.neighbour_radius_px={:.0} or more particles",
            params.customary_radius(&pane)
        )
    })
}

pub(crate) fn run(global: &Global, args: &SimulateArgs, screen: &Screen) -> Result<u8, Failure> {
    let settings = global.recipe()?.settings()?;
    let interrupt = Interrupt::listen(screen);
    let frames = args.growth_frames();
    let paths = [
        &args.output,
        &args.svg,
        &frames.as_ref().map(|(_, to)| to.clone()),
    ];
    let outputs: Vec<PathBuf> = paths.into_iter().flatten().cloned().collect();
    global.refuse_recipe_among(&outputs)?;
    let imported = network_file::read(args.network.as_deref(), &outputs)?;
    let simulated = match &imported {
        Some(imported) => Simulated::from(imported),
        None => starbreak::simulate(&settings, args.size, global.seed())?,
    };
    interrupt.check()?;
    let network = &simulated.network;
    let json = if args.timings {
        with_timings(&simulated)?
    } else {
        network.to_json()
    };

    let mut batch = global.batch();
    if let Some(path) = &args.output {
        batch.stage(path, json.as_bytes())?;
    }
    if let Some(path) = &args.svg {
        batch.stage(path, network.to_svg().as_bytes())?;
    }
    if let Some((n_frames, to)) = &frames {
        if !is_animation(to) {
            // Frames of an earlier run do not stay among these.
            batch = batch.with_list(&to.join("written.json"), "simulate");
        }
        stage_frames(
            &settings, &simulated, args.size, *n_frames, to, &interrupt, &mut batch,
        )?;
    }
    interrupt.check()?;
    batch.commit()?;

    if imported.is_none()
        && let Some(hint) = radius_hint(&settings, args.size)
    {
        screen.note(&hint);
    }
    if args.output.is_none() && !global.json {
        screen.data(&json)?;
        screen.note(&describe(&simulated));
    } else {
        screen.say(&describe(&simulated));
    }
    screen.result(|| result_json(args, &simulated))?;
    Ok(DONE)
}

/// The network file with the wall-clock times, which differ from run to run.
fn with_timings(simulated: &Simulated) -> Result<String, Failure> {
    let text = simulated.network.to_json();
    let mut value: Value = serde_json::from_str(&text).map_err(Failure::wrong_input)?;
    value["timings_ms"] = simulated.timings.to_json();
    Ok(format!("{value}\n"))
}

/// Growth frames as one animated PNG, or as numbered PNG files in a folder.
fn stage_frames(
    settings: &Settings,
    simulated: &Simulated,
    size: (u32, u32),
    n_frames: u32,
    to: &Path,
    interrupt: &Interrupt,
    batch: &mut OutputBatch,
) -> Result<(), Failure> {
    let network = &simulated.network;
    let times = growth_times(network, n_frames).take_while(|_| !interrupt.is_set());
    let scene = Scene::of(settings, size);
    let view = match simulated.details {
        Details::Imported(_) => scene.of_network(network)?,
        _ => scene.pane()?,
    };
    let drawings = times.map(|time| growth_drawing(network, &view, time, 1.0));
    let extension = extension(to);
    if ["gif", "webp", "mp4", "jpg", "jpeg", "avi", "mov"].contains(&extension.as_str()) {
        return Err(Failure::wrong_input(format!(
            "--frames-to {to:?}: animations are written as PNG; name a file that ends in .png, or a folder"
        )));
    }
    if is_animation(to) {
        batch.stage(
            to,
            &encode_animation(drawings, &AnimationParams::default())?,
        )?;
    } else {
        for (k, drawing) in (1..).zip(drawings) {
            batch.stage(
                &to.join(format!("frame_{k:05}.png")),
                &encode_mask(&drawing)?,
            )?;
        }
    }
    interrupt.check()
}

/// Whether frames go into one file.
fn is_animation(to: &Path) -> bool {
    ["png", "apng"].contains(&extension(to).as_str())
}

pub(super) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_lowercase()
}

fn describe(simulated: &Simulated) -> String {
    let network = &simulated.network;
    if let Some(why) = why_intact(network, &simulated.details) {
        return why.to_owned();
    }
    let summary = network.summary();
    let unit = network.data().unit.symbol();
    let cracks = format!(
        "{} segments, {:.0} {unit} of cracks",
        summary.n_segments, summary.total_length
    );
    let total_ms = simulated.timings.total_ms();
    match &simulated.details {
        Details::Imported(imported) => format!(
            "{}: {cracks}, {} impact(s), {} fragment(s)",
            imported.name,
            network.data().impacts.len(),
            summary.n_fragments.unwrap_or(1),
        ),
        Details::None => "nothing breaks".to_owned(),
        Details::Paper(paper) => {
            let report = &paper.convergence;
            format!(
                "{cracks}, {} arms from {} impact(s), {} steps; {} fronts came to rest: {} below the threshold, {} \
                 at another crack, {} without a neighbor; {total_ms:.1} ms",
                summary.n_radial,
                network.data().impacts.len(),
                report.n_steps(),
                report.n_fronts,
                report.stopped_below_threshold,
                report.stopped_at_crack,
                report.stopped_without_neighbor,
            )
        }
        Details::Physics(physics) => {
            let mut lines: Vec<String> = physics.impacts.iter().map(describe_hit).collect();
            if let Some(report) = &physics.long_crack {
                lines.push(format!(
                    "stress in the plane: {}, {:.1} mm, flaw at {:.2} of the toughness",
                    report.class,
                    // An empty sum is -0.
                    report.length_m.abs() * 1e3,
                    report.flaw_k_ratio
                ));
            }
            let longest = summary.longest_crack.unwrap_or_default();
            lines.push(format!(
                "{cracks}, longest {longest:.1} mm, {} fragment(s); {:.2} mJ of {:.2} mJ went into cracks; {total_ms:.1} ms",
                summary.n_fragments.unwrap_or(1),
                summary.dissipated_j.unwrap_or_default() * 1e3,
                summary.available_j.unwrap_or_default() * 1e3,
            ));
            lines.join("\n")
        }
    }
}

/// Class and key figures of a hit.
fn describe_hit(report: &ImpactReport) -> String {
    format!(
        "{}: {:.3} J, peak force {:.0} N, contact {:.1} us, {} arms, {} of them legs, reach {:.1} mm",
        report.damage.name(),
        report.kinetic_energy_j,
        report.peak_force_n,
        report.contact_time_s * 1e6,
        report.n_arms,
        report.n_legs,
        report.reach_m * 1e3,
    )
}

fn result_json(args: &SimulateArgs, simulated: &Simulated) -> Value {
    let network = &simulated.network;
    let mut result = Map::from_iter(
        [
            ("network", json!(args.output.as_ref().map(path_text))),
            ("svg", json!(args.svg.as_ref().map(path_text))),
            (
                "frames",
                json!(
                    args.growth_frames()
                        .map(|(n_frames, to)| json!({ "count": n_frames, "path": path_text(to) }))
                ),
            ),
            ("intact", json!(network.n_segments() == 0)),
            ("impacts", json!(network.data().impacts)),
            ("summary", json!(network.summary())),
        ]
        .map(|(key, value)| (key.to_owned(), value)),
    );
    result.extend(simulated.details.to_json());
    result.insert("timings_ms".to_owned(), simulated.timings.to_json());
    Value::Object(result)
}
