//! `starbreak study`: detectors on a dataset before and behind broken glass.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::json;
use starbreak::{DEFAULT_PRESET, Recipe, RecipeError, Seed};
use starbreak_dataset::{Source, sha256_file};
use starbreak_detect::{Detector, DetectorOptions, ImageToSee, LabelMap, LabelRules};
use starbreak_eval::GroundTruth;
use starbreak_runs::generate::{Selection, Shard, Survey, refuse_outputs, survey};
use starbreak_runs::study::{CLEAN_STEP, Condition, Family, StudyDetector, StudyPlan, conditions};
use starbreak_runs::{Patterns, with_threads};

use super::detect::{contract_of, say_contract, say_unmapped};
use super::generate::{mind_bad_records, refuse_output_in};
use super::study_report::{self, StudyReport};
use super::study_steps::{Steps, images, say_unseen};
use crate::args::study::{DivergenceWord, StudyArgs, SuiteWord};
use crate::args::{Global, read_recipe};
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Family of the condition of photographs, and the start of its folder's name.
const PHOTOS: &str = "photos";

pub(crate) fn run(global: &Global, args: &StudyArgs, screen: &Screen) -> Result<u8, Failure> {
    if args.no_store && args.divergence == Some(DivergenceWord::On) {
        return Err(Failure::wrong_input(
            "--divergence on compares images, which --no-store does not keep; leave one of them out",
        ));
    }
    let photos = photos_of(args)?;
    let conditions = conditions_of(global, args)?;
    let spec = global.spec(&args.source)?;
    let truth = GroundTruth::of_dataset(&spec, args.protocol.map(Into::into))?;
    let source = Source::open(&spec)?;
    let selection = Selection {
        limit: args.limit,
        ..Selection::default()
    };
    let survey = survey(&source, selection, global.seed());
    mind_bad_records(&survey, args.on_error, screen)?;
    let (mut truth, images) = labeled_images(&source, &survey, &truth, screen)?;
    if let Some(path) = &args.clusters {
        truth.read_clusters(path)?;
    }
    let detectors = detectors_of(args, &source, &truth, screen)?;

    let plan = StudyPlan {
        source: &source,
        survey: &survey,
        images: &images,
        detectors: &detectors,
        conditions: &conditions,
        photos: photos.as_ref(),
        out: &args.output,
        n_threads: n_threads(global),
        keeps_images: !args.no_store,
    };
    if args.dry_run {
        plan.check(&truth)?;
        study_report::refuse_taken(global, args, &plan)?;
        return dry_run(&plan, screen);
    }
    match args.shard {
        Some(shard) => run_shard(global, args, (&plan, &truth), shard, screen),
        None => run_whole(global, args, (&plan, &truth), screen),
    }
}

/// Runs or joins the whole study, and reports.
fn run_whole(
    global: &Global,
    args: &StudyArgs,
    (plan, truth): (&StudyPlan<'_>, &GroundTruth),
    screen: &Screen,
) -> Result<u8, Failure> {
    plan.check_folder(truth)?;
    study_report::refuse_taken(global, args, plan)?;
    let interrupt = Interrupt::listen(screen);
    let compares = !args.no_store && args.divergence != Some(DivergenceWord::Off);
    let n_lines = match args.join.is_empty() {
        true => n_lines(plan, None),
        false => 0,
    };
    let steps = Steps::new(screen, n_lines + usize::from(compares));
    let runs = with_threads(usize::from(global.threads), || match args.join.is_empty() {
        true => plan.run(truth, interrupt.flag(), &|event| steps.tell(event)),
        false => plan.join(truth, &args.join).map(Some),
    })??;
    let runs = runs.ok_or_else(interrupted)?;
    let divergence = match compares {
        false => None,
        true => {
            let found = with_threads(usize::from(global.threads), || {
                plan.divergence(&runs, global.seed, interrupt.flag(), &|event| {
                    steps.tell(event);
                })
            })??;
            Some(found.ok_or_else(interrupted)?)
        }
    };
    say_unseen(&runs.unseen, &steps.finish(), screen);
    let report = StudyReport {
        args,
        plan,
        runs: &runs,
        truth,
        divergence,
        global,
    };
    screen.say("evaluating: intervals and tests");
    with_threads(usize::from(global.threads), || report.write(screen))??;
    match runs.unseen.len() {
        0 => Ok(DONE),
        n => Err(Failure {
            message: format!(
                "{} could not be used: left out of all numbers; {:?} says why",
                images(n),
                args.output.join("unseen.jsonl")
            ),
            code: SOME_FAILED,
        }),
    }
}

/// Does the images of one shard.
fn run_shard(
    global: &Global,
    args: &StudyArgs,
    (plan, truth): (&StudyPlan<'_>, &GroundTruth),
    shard: Shard,
    screen: &Screen,
) -> Result<u8, Failure> {
    let selection = Selection {
        shard: Some(shard),
        ..plan.survey.selection()
    };
    let of_shard = survey(plan.source, selection, global.seed());
    let interrupt = Interrupt::listen(screen);
    let steps = Steps::new(screen, n_lines(plan, args.step.as_deref()));
    let unseen = with_threads(usize::from(global.threads), || {
        plan.run_shard(
            truth,
            &of_shard,
            args.step.as_deref(),
            interrupt.flag(),
            &|event| steps.tell(event),
        )
    })??;
    let unseen = unseen.ok_or_else(interrupted)?;
    say_unseen(&unseen, &steps.finish(), screen);
    screen.say(&format!(
        "{}: {} images of shard {}/{}",
        args.output.display(),
        of_shard.n_selected,
        shard.number,
        shard.of
    ));
    screen.result(|| {
        json!({
            "output": path_text(&args.output),
            "shard": shard,
            "step": args.step,
            "n_images": of_shard.n_selected,
            "n_unseen": unseen.len(),
        })
    })?;
    match unseen.len() {
        0 => Ok(DONE),
        n => Err(Failure {
            message: format!(
                "{} could not be used: left out of all numbers once joined; the same command tries again",
                images(n)
            ),
            code: SOME_FAILED,
        }),
    }
}

/// Says what the study would do.
fn dry_run(plan: &StudyPlan<'_>, screen: &Screen) -> Result<u8, Failure> {
    let names = plan.steps();
    screen.say(&format!(
        "dry run: {} images with {} labeled objects, {} detectors, {} steps:",
        plan.images.len(),
        plan.survey.n_objects,
        plan.detectors.len(),
        names.len()
    ));
    for name in &names {
        screen.say(&format!("  {name}"));
    }
    screen.result(|| {
        json!({
            "dry_run": true,
            "n_images": plan.images.len(),
            "n_objects": plan.survey.n_objects,
            "detectors": plan.detectors.iter().map(|one| &one.name).collect::<Vec<_>>(),
            "steps": names,
        })
    })?;
    Ok(DONE)
}

fn interrupted() -> Failure {
    Failure::interrupted("interrupted; the same command goes on where it was")
}

/// Lines of all steps, or of one, on the screen: one for the clean images, two for each condition (breaking, detecting).
fn n_lines(plan: &StudyPlan<'_>, step: Option<&str>) -> usize {
    match step {
        None => 1 + 2 * plan.conditions.len(),
        Some(CLEAN_STEP) => 1,
        Some(_) => 2,
    }
}

fn n_threads(global: &Global) -> usize {
    match global.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => usize::from(n),
    }
}

/// The photographs of broken glass, if a folder was named; the study does not lie in it.
fn photos_of(args: &StudyArgs) -> Result<Option<Patterns>, Failure> {
    if let Some(folder) = &args.overlays {
        refuse_output_in(folder, &args.output)?;
    }
    args.overlay.read_folder(args.overlays.as_deref())
}

/// Families times severities times seeds.
fn conditions_of(global: &Global, args: &StudyArgs) -> Result<Vec<Condition>, Failure> {
    let mut families = Vec::new();
    let suite = args.suite.map(SuiteWord::presets).unwrap_or_default();
    for name in suite.iter().chain(&args.presets) {
        families.push(Family::Preset(name.clone()));
    }
    for path in &args.recipes {
        families.push(recipe_family(path)?);
    }
    if families.is_empty() {
        families.push(match &global.recipe {
            Some(path) => recipe_family(path)?,
            None => Family::Preset(
                global
                    .preset
                    .as_deref()
                    .unwrap_or(DEFAULT_PRESET)
                    .to_owned(),
            ),
        });
    }
    if let (Some(_), Some(first)) = (&args.overlays, families.first()) {
        let recipe = match first {
            Family::Preset(name) => Recipe::preset(name)?,
            Family::Recipe(_, recipe) | Family::Photos(_, recipe) => (**recipe).clone(),
        };
        families.push(Family::Photos(PHOTOS.to_owned(), Box::new(recipe)));
    }
    let mut severities = args.severities.clone();
    severities.extend(global.severity);
    let has_preset = families
        .iter()
        .any(|family| matches!(family, Family::Preset(_)));
    if !severities.is_empty() && !has_preset {
        return Err(Failure::wrong_input(
            "severities scale presets, and a recipe says its values itself; leave --severities out",
        ));
    }
    let seeds: Vec<Seed> = match args.seeds.as_slice() {
        [] => vec![global.seed()],
        seeds => seeds.iter().copied().map(Seed).collect(),
    };
    let adjust = |recipe: &mut Recipe| -> Result<(), RecipeError> { global.adjust(recipe) };
    let all = conditions(&families, &severities, &seeds, &adjust)?;
    for condition in &all {
        let settings = condition.recipe.settings()?;
        refuse_outputs(&settings.output)?;
        if condition.is_photographed {
            args.overlay.refuse_idle_gain(&settings)?;
        }
    }
    Ok(all)
}

fn recipe_family(path: &Path) -> Result<Family, Failure> {
    let recipe = read_recipe(path)?;
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    Ok(Family::Recipe(
        stem.to_string_lossy().into_owned(),
        Box::new(recipe),
    ))
}

/// The images that have labels, in the order of these.
fn labeled_images(
    source: &Source,
    survey: &Survey,
    truth: &GroundTruth,
    screen: &Screen,
) -> Result<(GroundTruth, Vec<ImageToSee>), Failure> {
    let mut paths: BTreeMap<String, _> = survey
        .selected(source)
        .map(|image| (image.name, image.path))
        .collect();
    let (truth, _) = truth.keep(|image| paths.contains_key(&image.name));
    let images: Vec<ImageToSee> = truth
        .labels
        .images
        .iter()
        .filter_map(|image| {
            let path = paths.remove(&image.name)?;
            Some(ImageToSee {
                name: image.name.clone(),
                path,
            })
        })
        .collect();
    if !paths.is_empty() {
        screen.note(&format!(
            "{} images have no labels and are left out of the numbers",
            paths.len()
        ));
    }
    if images.is_empty() {
        return Err(Failure::wrong_input(format!(
            "{:?} holds no image with labels; check the path and --limit",
            source.root()
        )));
    }
    Ok((truth, images))
}

fn detectors_of(
    args: &StudyArgs,
    source: &Source,
    truth: &GroundTruth,
    screen: &Screen,
) -> Result<Vec<StudyDetector>, Failure> {
    if args.contract.len() > args.model.len() {
        return Err(Failure::wrong_input(format!(
            "{} contracts for {} models; give one for each model, `auto` where it is to be found out",
            args.contract.len(),
            args.model.len()
        )));
    }
    let rules = match &args.label_map {
        Some(path) => super::detect::label_rules(path)?,
        None => LabelRules::of_dataset(source.format().name())?,
    };
    let backend = args.runtime.backend(screen)?;
    let mut detectors: Vec<StudyDetector> = Vec::new();
    for (place, path) in args.model.iter().enumerate() {
        let contract = match args.contract.get(place).map(String::as_str) {
            None | Some("auto") => None,
            Some(name) => Some(contract_of(name)?),
        };
        let options = DetectorOptions {
            contract,
            backend: backend.clone(),
            ..DetectorOptions::default()
        };
        let detector = Detector::open(path, &options)?;
        let stem = path.file_stem().unwrap_or(path.as_os_str());
        let stem = starbreak_runs::study::folder_name(&stem.to_string_lossy());
        let (mut name, mut number) = (stem.clone(), place + 1);
        while detectors.iter().any(|other| other.name == name) {
            name = format!("{stem}-{number}");
            number += 1;
        }
        screen.note(&format!("detector {name}:"));
        say_contract(&detector, screen);
        let map = LabelMap::new(detector.classes(), &truth.labels.category_names(), &rules)?;
        say_unmapped(&map, screen);
        let sha256 = sha256_file(path)?;
        let is_same = |other: &&StudyDetector| {
            other.sha256 == sha256 && other.detector.contract() == detector.contract()
        };
        if let Some(other) = detectors.iter().find(is_same) {
            screen.note(&format!(
                "warning: {name} is the same model with the same contract as {}, so their numbers are the same",
                other.name
            ));
        }
        detectors.push(StudyDetector {
            name,
            sha256,
            detector,
            map,
        });
    }
    Ok(detectors)
}
