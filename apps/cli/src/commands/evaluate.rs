//! `starbreak evaluate`: labels and detections to numbers.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use starbreak::dataset::{FileSet, OutputBatch, file_len};
use starbreak::evaluation::{EvaluateRequest, evaluate_files, files_of, label_files};
use starbreak::pipeline::with_threads;
use starbreak_eval::evaluation::{Estimate, PairedMetric, PairedRow, ScopeKind};
use starbreak_eval::{AreaRange, CocoEvaluation, Evaluated, KittiCurve, Protocol};

use crate::args::Global;
use crate::args::evaluate::EvaluateArgs;
use crate::failure::Failure;
use crate::screen::{Screen, path_text};

pub(crate) fn run(
    global: &Global,
    args: &EvaluateArgs,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    if let Some(folder) = &args.output {
        refuse_study_or_set(folder)?;
    }
    let batch = match &args.output {
        Some(folder) => report_batch(global, folder, &REPORT_FILES)?,
        None => global.batch(),
    };
    let mut batch = batch.never_over(FileSet::of(&inputs(global, args)?));
    for folder in args.output.iter().chain(&args.curves) {
        // A folder that cannot be written to is known before the work.
        OutputBatch::new().reserve(&folder.join("trial"))?;
    }
    let request = request(global, args);
    let answer = with_threads(usize::from(global.threads), || evaluate_files(&request))??;
    if let Some(folder) = &args.curves {
        for (path, bytes) in &answer.curves {
            batch.stage(&folder.join(path), bytes)?;
        }
    }
    if let Some(folder) = &args.output {
        for (name, text) in &answer.report {
            batch.stage(&folder.join(name), text.as_bytes())?;
        }
    }
    batch.commit()?;
    for warning in &answer.warnings {
        screen.note(&format!("warning: {warning}"));
    }
    show(
        screen,
        &answer.clean,
        answer.cracked.as_ref(),
        answer.paired.as_deref(),
    );
    if let Some(folder) = &args.output {
        screen.say(&format!("wrote {}", path_text(folder.join("report.html"))));
    }
    screen.result(|| answer.json)?;
    Ok(ExitCode::SUCCESS)
}

/// The files of a report of images.
const REPORT_FILES: [&str; 5] = [
    "report.html",
    "evaluation.json",
    "numbers.csv",
    "table.tex",
    "failures.jsonl",
];

/// The batch for a report of these files, none of which may be of somebody else. One list is of both
/// kinds of reports: that of images and that of clips replace each other.
pub(super) fn report_batch(
    global: &Global,
    folder: &Path,
    names: &[&str],
) -> Result<OutputBatch, Failure> {
    let list = folder.join("written.json");
    let batch = global.batch().with_list(&list, "report");
    for name in names {
        batch.may_write(&folder.join(name))?;
    }
    Ok(batch)
}

/// The files that are read.
fn inputs(global: &Global, args: &EvaluateArgs) -> Result<Vec<PathBuf>, Failure> {
    let mut inputs = match &args.source {
        Some(source) => label_files(&global.spec(source)?),
        None => Vec::new(),
    };
    let others = [&args.ground_truth, &args.cracked, &args.clusters];
    let others = others.into_iter().flatten().chain([&args.clean]);
    inputs.extend(others.flat_map(|path| files_of(path)));
    Ok(inputs)
}

/// The report of a study is not to be replaced by that of something else, and a generated set holds no
/// files but its own.
pub(super) fn refuse_study_or_set(folder: &Path) -> Result<(), Failure> {
    let taken = [
        ("study.json", "a study, whose report would be replaced"),
        (
            "starbreak/run.json",
            "a generated set, to which no report belongs",
        ),
    ];
    let is_there = |(name, _): &&(&str, &str)| file_len(&folder.join(name)).is_ok();
    match taken.iter().find(is_there) {
        None => Ok(()),
        Some((_, what)) => Err(Failure::wrong_input(format!(
            "{}: is the folder of {what}; give another",
            folder.display()
        ))),
    }
}

/// What the flags ask for.
fn request(global: &Global, args: &EvaluateArgs) -> EvaluateRequest {
    let ranges = args.area_range.iter();
    EvaluateRequest {
        source: args.source.clone(),
        ground_truth: args.ground_truth.clone(),
        clean: args.clean.clone(),
        cracked: args.cracked.clone(),
        regions: args.regions.clone(),
        cracked_set: args.cracked_set.clone(),
        clusters: args.clusters.clone(),
        detector: args.detector.clone(),
        condition: args.condition.clone(),
        n_replicates: args.replicates,
        score_threshold: args.score_threshold,
        n_worst: args.worst,
        taus: args.tau.clone(),
        protocol: args.protocol.map(Protocol::from),
        iou_thresholds: args.iou_thresholds.clone(),
        max_dets: args.max_dets.clone(),
        area_ranges: ranges
            .map(|(name, ends)| AreaRange::new(name, *ends))
            .collect(),
        class_agnostic: args.class_agnostic,
        gt_id_zero_quirk: args.gt_id_zero_quirk,
        joins: args.output.is_some(),
        curves: args.curves.is_some(),
        seed: global.seed,
        command: Some(command()),
    }
}

/// The command line as a shell takes it.
pub(super) fn command() -> String {
    let words: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| shell_word(&word))
        .collect();
    format!("starbreak {}", words.join(" "))
}

/// A word as a shell takes it.
pub(super) fn shell_word(word: &OsStr) -> String {
    let word = word.to_string_lossy().into_owned();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// A table for people.
fn show(
    screen: &Screen,
    clean: &Evaluated,
    cracked: Option<&Evaluated>,
    paired: Option<&[PairedRow]>,
) {
    for (name, side) in [("clean", Some(clean)), ("cracked", cracked)] {
        let Some(side) = side else { continue };
        if let Some(stats) = side.coco.as_ref().and_then(CocoEvaluation::stats) {
            let [ap, ap50, ap75, ..] = stats.map(|stat| match stat < 0.0 {
                true => "-".to_owned(),
                false => format!("{:.2}", stat * 100.0),
            });
            screen.say(&format!("{name}: AP {ap}, AP50 {ap50}, AP75 {ap75} %"));
        }
        for curve in &side.kitti {
            let [_, ceiling] = KittiCurve::ceiling(curve.n_gt);
            screen.say(&format!(
                "{name}: {} {}: AP40 {:.2}, AP11 {:.2} %, {} objects, a perfect detector {ceiling:.1} %",
                curve.class.name(),
                curve.difficulty.name(),
                curve.ap40(),
                curve.ap11(),
                curve.n_gt
            ));
        }
    }
    let figure = |estimate: &Estimate| match (estimate.value, &estimate.refused) {
        (Some(value), _) => format!("{:.2}", value * 100.0),
        (None, Some(why)) => format!("not given ({why})"),
        (None, None) => "not given".to_owned(),
    };
    let is_shown = |row: &&PairedRow| {
        row.n_objects > 0 && matches!(row.metric, PairedMetric::Ap50 | PairedMetric::KittiAp40)
    };
    for row in paired.into_iter().flatten().filter(is_shown) {
        let scope = match (row.scope.kind, row.scope.tau) {
            (ScopeKind::InRegion, Some(tau)) => format!("in region (tau {tau})"),
            (ScopeKind::OutOfRegion, Some(tau)) => format!("out of region (tau {tau})"),
            _ => "whole image".to_owned(),
        };
        let metric = match row.metric {
            PairedMetric::KittiAp40 => "AP40",
            _ => "AP50",
        };
        screen.say(&format!(
            "{scope}: {}: {metric} clean {}, cracked {} %, {} objects in {} images",
            row.group.name,
            figure(&row.clean),
            figure(&row.cracked),
            row.n_objects,
            row.n_images
        ));
    }
}
