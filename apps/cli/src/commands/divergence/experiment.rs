//! `--experiment paper`: the paper's distributions and its control.

use std::ffi::OsStr;

use starbreak_dataset::SourceFormat;
use starbreak_eval::divergence::{
    CompareSettings, DivergenceReport, Measure, PAPER_SETS, PaperComparison, paper_experiment,
};
use starbreak_runs::divergence::NamedSet;

use super::show::{self, digits};
use super::{Reader, finish, wide};
use crate::failure::Failure;

/// Fewer make no distribution.
const FEWEST_IMAGES: usize = 10;

pub(super) fn run(reader: &Reader<'_>, settings: &CompareSettings) -> Result<u8, Failure> {
    let given = &reader.args.experiment;
    let kitti = Some(SourceFormat::Kitti);
    // In the order of the paper's sets.
    let given = [
        (&given.simulated, None),
        (&given.real_overlays, None),
        (&given.simulated_kitti, kitti),
        (&given.overlays_kitti, kitti),
        (&given.road_broken, None),
        (&given.road_clean, None),
        (&given.kitti, kitti),
        (&given.bdd, Some(SourceFormat::Bdd)),
        (&given.cats, None),
    ];
    let limit = reader.args.limit.map(wide);
    let (mut named, mut small) = (Vec::new(), Vec::new());
    for ((flag, name), (text, layout)) in PAPER_SETS.into_iter().zip(given) {
        if let Some(text) = text {
            let set = NamedSet::parse_or(text, name, layout);
            let set = set.following_links(reader.global.follow_links);
            small.extend(too_few(flag, text, set.open(limit)?.n()));
            named.push((flag, text, set));
        }
    }
    // Before any is read, which takes minutes.
    refuse_small(&small)?;
    let mut sets = Vec::new();
    for (flag, text, set) in named {
        let set = reader.read(set)?;
        // Some may be unreadable.
        refuse_small(too_few(flag, text, set.summary.n).as_slice())?;
        sets.push(set);
    }
    if sets.len() < 2 {
        return Err(Failure::wrong_input(format!(
            "the paper's experiment needs two sets or more; give some of {}",
            PAPER_SETS.map(|(flag, _)| flag).join(", ")
        )));
    }
    let experiment = paper_experiment(&sets, &reader.reading, settings)?;
    reader.interrupt.check()?;
    let screen = reader.screen;
    show::report(&experiment.report, screen);
    for ordering in &experiment.orderings {
        show::ordering(ordering, screen);
    }
    screen.say("\nThe paper's comparisons (its figure names no feature, bins or estimator, so that only their order can be compared):");
    for comparison in &experiment.comparisons {
        screen.say(&line(&experiment.report, comparison));
    }
    if !experiment.missing.is_empty() {
        let missing = experiment.missing.join(", ");
        screen.note(&format!("note: not given: {missing}"));
    }
    finish(reader, &experiment.report, &experiment)
}

/// What is said of a set of too few images.
fn too_few(flag: &str, text: &OsStr, n: usize) -> Option<String> {
    (n < FEWEST_IMAGES).then(|| format!("{flag}: {text:?} has {n} images"))
}

fn refuse_small(small: &[String]) -> Result<(), Failure> {
    match small.is_empty() {
        true => Ok(()),
        false => Err(Failure::wrong_input(format!(
            "{}, of which nothing can be said; give {FEWEST_IMAGES} or more each",
            small.join("; ")
        ))),
    }
}

fn line(report: &DivergenceReport, comparison: &PaperComparison) -> String {
    let (a, b) = (comparison.a, comparison.b);
    let head = format!("  {}: {a} | {b}", comparison.letter);
    let published = comparison.published;
    let published = published.map_or_else(String::new, |value| format!("; published {value}"));
    if !comparison.missing.is_empty() {
        let missing = comparison.missing.join(", ");
        return format!("{head}: missing {missing}{published}");
    }
    let mut pairs = report.pairs.iter();
    let (what, numbers): (_, Vec<(&str, f64)>) = match pairs.find(|p| p.a == a && p.b == b) {
        Some(pair) => {
            let kl = pair.features.iter().filter_map(|compared| {
                let kl = compared.measures.get(&Measure::KlAb)?;
                Some((compared.feature.name(), kl.value))
            });
            ("KL(A|B)", kl.collect())
        }
        None => {
            let floor = report.floors.iter().find(|floor| floor.set == a);
            let features = floor.iter().flat_map(|floor| &floor.features);
            let kl = features.filter_map(|(name, of)| Some((*name, *of.get(&Measure::KlAb)?)));
            ("KL of split-halves", kl.collect())
        }
    };
    let numbers = numbers
        .iter()
        .map(|(name, kl)| format!("{name} {}", digits(*kl)));
    let numbers: Vec<String> = numbers.collect();
    format!("{head}: {what} {}{published}", numbers.join(", "))
}
