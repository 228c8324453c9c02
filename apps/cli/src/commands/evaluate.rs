//! `starbreak evaluate`: labels and detections to numbers.

use starbreak_dataset::OutputBatch;
use starbreak_eval::evaluation::{Estimate, GroupKind, PairedMetric, PairedRow, ScopeKind};
use starbreak_eval::{AreaRange, CocoEvaluation, Evaluated, KittiCurve, Protocol};
use starbreak_runs::evaluation::{EvaluateRequest, REPORT_FILES, evaluate_files, report_batch};
use starbreak_runs::with_threads;

use crate::args::Global;
use crate::args::evaluate::EvaluateArgs;
use crate::failure::{DONE, Failure};
use crate::screen::{Screen, path_text};

pub(crate) fn run(global: &Global, args: &EvaluateArgs, screen: &Screen) -> Result<u8, Failure> {
    let request = request(global, args);
    let source = args.source.as_deref().map(|source| global.spec(source));
    let read = request.read_files(source.transpose()?.as_ref());
    let mut batch = match &args.output {
        Some(folder) => report_batch(folder, &REPORT_FILES, global.replace, read)?,
        None => global.batch().never_over(read),
    };
    for folder in args.output.iter().chain(&args.curves) {
        // A folder that cannot be written to is known before the work.
        OutputBatch::new().reserve(&folder.join("trial"))?;
    }
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
    Ok(DONE)
}

/// What the flags ask for.
fn request(global: &Global, args: &EvaluateArgs) -> EvaluateRequest {
    let ranges = args.area_range.iter();
    EvaluateRequest {
        source: args.source.clone(),
        ground_truth: args.ground_truth.clone(),
        clean: args.clean.clone(),
        cracked: args.damaged.clone(),
        regions: args.regions.clone(),
        cracked_set: args.damaged_set.clone(),
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
        command: Some(global.command.clone()),
    }
}

/// So many lines of a table are for people.
const MOST_ROWS: usize = 36;

/// A table for people.
fn show(
    screen: &Screen,
    clean: &Evaluated,
    cracked: Option<&Evaluated>,
    paired: Option<&[PairedRow]>,
) {
    for (name, side) in [("clean", Some(clean)), ("damaged", cracked)] {
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
    let mut rows: Vec<&PairedRow> = paired.into_iter().flatten().filter(is_shown).collect();
    let n_all = rows.len();
    for kind in [GroupKind::Class, GroupKind::Supercategory] {
        // Of KITTI all rows are of classes.
        if rows.len() > MOST_ROWS && rows.iter().any(|row| row.group.kind != kind) {
            rows.retain(|row| row.group.kind != kind);
        }
    }
    rows.truncate(MOST_ROWS);
    let n_left = n_all - rows.len();
    for row in rows {
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
            "{scope}: {}: {metric} clean {}, damaged {} %, {} objects in {} images",
            row.group.name,
            figure(&row.clean),
            figure(&row.cracked),
            row.n_objects,
            row.n_images
        ));
    }
    if n_left > 0 {
        screen.say(&format!(
            "{n_left} more lines are in the report (-o) and in the result (--json)"
        ));
    }
}
