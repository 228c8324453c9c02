//! `--experiment paper`: the paper's distributions and its control.

use std::process::ExitCode;

use serde_json::json;
use starbreak_dataset::SourceFormat;
use starbreak_eval::divergence::{
    CompareSettings, ImageSet, Measure, PaperComparison, PaperExperiment, PaperRole, ReadSettings,
    paper_experiment,
};
use starbreak_runs::divergence::NamedSet;

use super::{digits, finish, sets, show};
use crate::args::Global;
use crate::args::divergence::DivergenceArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::Screen;

/// Fewer make no distribution.
const FEWEST_IMAGES: usize = 10;

pub(super) fn run(
    global: &Global,
    args: &DivergenceArgs,
    reading: &ReadSettings,
    settings: &CompareSettings,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    let eye = sets::eye(args)?;
    let mut read = Vec::new();
    for role in PaperRole::ALL {
        let given = &args.experiment;
        let text = match role {
            PaperRole::Simulated => &given.simulated,
            PaperRole::RealOverlays => &given.real_overlays,
            PaperRole::SimulatedKitti => &given.simulated_kitti,
            PaperRole::OverlaysKitti => &given.overlays_kitti,
            PaperRole::RoadBroken => &given.road_broken,
            PaperRole::RoadClean => &given.road_clean,
            PaperRole::Kitti => &given.kitti,
            PaperRole::Bdd => &given.bdd,
            PaperRole::Cats => &given.cats,
        };
        let layout = match role {
            PaperRole::SimulatedKitti | PaperRole::OverlaysKitti | PaperRole::Kitti => {
                Some(SourceFormat::Kitti)
            }
            PaperRole::Bdd => Some(SourceFormat::Bdd),
            _ => None,
        };
        if let Some(text) = text {
            let named = NamedSet::parse_or(text, role.paper_name(), layout)
                .following_links(global.follow_links);
            let set = sets::read(&named, args, reading, eye.as_ref(), interrupt, screen)?;
            if set.n() < FEWEST_IMAGES {
                return Err(Failure::wrong_input(format!(
                    "{}: {:?} has {} images, of which nothing can be said; give {FEWEST_IMAGES} or more",
                    role.flag(),
                    text,
                    set.n()
                )));
            }
            read.push((role, set));
        }
    }
    if read.len() < 2 {
        return Err(Failure::wrong_input(format!(
            "the paper's experiment needs two sets or more; give some of {}",
            PaperRole::ALL.map(PaperRole::flag).join(", ")
        )));
    }
    let mut experiment = paper_experiment(&read, reading, settings)?;
    if let Some(eye) = &eye {
        let sets: Vec<ImageSet> = read.into_iter().map(|(_, set)| set).collect();
        eye.compare(&sets, args.sigma, settings, &mut experiment.report)?;
    }
    interrupt.check()?;
    show::report(&experiment.report, screen);
    screen.say("\nThe paper's comparisons (its figure names no feature, bins or estimator, so that only their order can be compared):");
    for comparison in &experiment.comparisons {
        screen.say(&line(&experiment, comparison));
    }
    if !experiment.missing.is_empty() {
        screen.note(&format!(
            "note: not given: {}",
            experiment.missing.join(", ")
        ));
    }
    let value = json!({ "experiment": "paper", "comparisons": experiment.comparisons, "missing": experiment.missing, "report": experiment.report });
    finish(global, args, &experiment.report, value, screen)
}

fn line(experiment: &PaperExperiment, comparison: &PaperComparison) -> String {
    let head = format!(
        "  {}: {} | {}",
        comparison.letter, comparison.a, comparison.b
    );
    let published = comparison
        .published
        .map_or_else(String::new, |value| format!("; published {value}"));
    if !comparison.missing.is_empty() {
        return format!(
            "{head}: missing {}{published}",
            comparison.missing.join(", ")
        );
    }
    let report = &experiment.report;
    let pair = comparison.pair.and_then(|at| report.pairs.get(at));
    let numbers: Vec<String> = if let Some(pair) = pair {
        let features = pair.features.iter().filter_map(|compared| {
            let value = compared.measures.get(&Measure::KlAb)?.value;
            Some(format!("{} {}", compared.feature.name(), digits(value)))
        });
        features.collect()
    } else {
        let floor = comparison.floor.and_then(|at| report.floors.get(at));
        let features = floor.iter().flat_map(|floor| &floor.features);
        features
            .filter_map(|(name, measures)| {
                let [mean, _] = measures.get(&Measure::KlAb)?;
                Some(format!("{name} {}", digits(*mean)))
            })
            .collect()
    };
    let what = if pair.is_some() {
        "KL(A|B)"
    } else {
        "KL of split-halves"
    };
    format!("{head}: {what} {}{published}", numbers.join(", "))
}
