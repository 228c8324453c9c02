//! `starbreak evaluate`: labels and detections to numbers.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::{Map, Value, json};
use starbreak::dataset::{OutputBatch, SourceSpec, encode_array_f64};
use starbreak::pipeline::with_threads;
use starbreak_eval::evaluation::{
    CleanResults, Estimate, Evaluation, PairedMetric, PairedRow, ScopeKind,
};
use starbreak_eval::report::report_files;
use starbreak_eval::{
    AreaRange, CocoEvaluation, CompareParams, CoverageOf, Coverages, Evaluated, GroundTruth,
    KittiCurve, Protocol, RegionMasks, SaidDetections, Subset, check_pair, compare_in_regions,
    cover, evaluate, subset_curves,
};

use super::evaluate_join::Join;
use crate::args::Global;
use crate::args::evaluate::EvaluateArgs;
use crate::failure::Failure;
use crate::screen::{Screen, path_text};

pub(crate) fn run(
    global: &Global,
    args: &EvaluateArgs,
    screen: &Screen,
) -> Result<ExitCode, Failure> {
    let n_threads = usize::from(global.threads);
    with_threads(n_threads, || evaluated(global, args, screen))??;
    Ok(ExitCode::SUCCESS)
}

fn evaluated(global: &Global, args: &EvaluateArgs, screen: &Screen) -> Result<(), Failure> {
    refuse_mixed(args)?;
    for folder in args.output.iter().chain(&args.curves) {
        // A folder that cannot be written to is known before the work.
        OutputBatch::new().reserve(&folder.join("report.html"))?;
    }
    let protocol = args.protocol.map(Protocol::from);
    let mut truth = match (&args.source, &args.ground_truth) {
        (Some(source), _) => GroundTruth::of_dataset(&SourceSpec::parse(source)?, protocol)?,
        (None, Some(path)) => GroundTruth::of_path(path, protocol.unwrap_or(Protocol::Coco))?,
        (None, None) => {
            return Err(Failure::wrong_input(
                "no labels; give a SOURCE such as coco:DIR, or --ground-truth",
            ));
        }
    };
    if let Some(path) = &args.clusters {
        truth.read_clusters(path)?;
    }
    let params = params(args, &truth);
    let clean = truth.read_detections(&args.clean)?;
    let cracked = match &args.cracked {
        Some(path) => Some(truth.read_detections(path)?),
        None => None,
    };
    let warnings = check_pair(&truth, &clean, cracked.as_ref())?;
    let folder = regions_folder(args);
    if folder.is_none() && !args.tau.is_empty() {
        return Err(Failure::wrong_input(
            "--tau is about the region; give --regions or --cracked-set, too",
        ));
    }
    let masks = folder.as_deref().map(|folder| RegionMasks {
        folder,
        root: truth.root.as_deref(),
    });
    let tau = params.taus.first().copied().unwrap_or(0.0);
    let sets: Vec<&SaidDetections> = [Some(&clean), cracked.as_ref()]
        .into_iter()
        .flatten()
        .collect();
    let (counts, coverages) = cover(&truth, &sets, masks, tau)?;
    let of_clean = evaluate(&truth, &clean, &params)?;
    let of_cracked = match &cracked {
        Some(cracked) => Some(evaluate(&truth, cracked, &params)?),
        None => None,
    };
    let regions = match &coverages {
        Some(coverages) => Some(compare_in_regions(
            &truth,
            &clean,
            cracked.as_ref(),
            coverages,
            &params,
        )?),
        None => None,
    };
    let mut result = json!({
        "schema": "starbreak.evaluation-plain/1",
        "protocol": truth.protocol.name(),
        "counts": counts,
        "warnings": warnings,
        "clean": side(&of_clean, &clean)?,
    });
    if let Value::Object(result) = &mut result {
        if let (Some(evaluated), Some(said)) = (&of_cracked, &cracked) {
            result.insert("cracked".to_owned(), side(evaluated, said)?);
        }
        if let Some(regions) = &regions {
            let region = json!({
                "definition": "region-ap/1",
                "taus": params.taus,
                "min_objects": params.min_objects,
                "subsets": regions.subsets,
            });
            result.insert("region".to_owned(), region);
            result.insert("paired".to_owned(), json!(regions.paired));
        }
    }
    let mut batch = OutputBatch::new();
    if let Some(folder) = &args.curves {
        let both = [
            ("clean", Some(&of_clean), Some(&clean)),
            ("cracked", of_cracked.as_ref(), cracked.as_ref()),
        ];
        for (idx, (name, evaluated, said)) in both.into_iter().enumerate() {
            if let (Some(evaluated), Some(said)) = (evaluated, said) {
                let coverages = coverages.as_ref().map(|c| (c, idx));
                stage_curves(
                    &mut batch,
                    &folder.join(name),
                    &truth,
                    said,
                    evaluated,
                    coverages,
                    &params,
                )?;
            }
        }
    }
    if let Some(folder) = &args.output {
        let join = Join {
            truth: &truth,
            clean: &clean,
            cracked: cracked.as_ref(),
            masks,
            params: &params,
        };
        let study = join.study(global, args)?;
        if let (Value::Object(result), Some(evaluation)) = (&mut result, study.evaluations.first())
        {
            put_joined(result, evaluation, study.clean.first());
        }
        for (name, text) in report_files(&study)? {
            batch.stage(&folder.join(name), text.as_bytes())?;
        }
    }
    batch.commit()?;
    for warning in &warnings {
        screen.note(&format!("warning: {}", warning.text));
    }
    show(
        screen,
        &of_clean,
        of_cracked.as_ref(),
        regions.as_ref().map(|r| r.paired.as_slice()),
    );
    if let Some(folder) = &args.output {
        screen.say(&format!("wrote {}", path_text(folder.join("report.html"))));
    }
    screen.result(|| result)
}

/// Flags of the plain protocol change what is compared nowhere else; τ is a share.
fn refuse_mixed(args: &EvaluateArgs) -> Result<(), Failure> {
    let compares = args.regions.is_some() || args.cracked_set.is_some() || args.output.is_some();
    let plain = [
        ("--iou-thresholds", !args.iou_thresholds.is_empty()),
        ("--class-agnostic", args.class_agnostic),
        ("--area-range", !args.area_range.is_empty()),
    ];
    if compares && let Some((flag, _)) = plain.iter().find(|(_, is_there)| *is_there) {
        return Err(Failure::wrong_input(format!(
            "{flag} holds for the numbers of whole images alone; leave it out with --regions, --cracked-set and -o, \
             whose comparisons have rules of their own"
        )));
    }
    if args.clusters.is_some() && args.output.is_none() {
        return Err(Failure::wrong_input(
            "--clusters is about intervals and tests, which come with a report; give -o, too",
        ));
    }
    let mut taus: Vec<f64> = args.tau.clone();
    taus.sort_by(f64::total_cmp);
    let is_share = |tau: &f64| (0.0..=1.0).contains(tau);
    let is_twice = taus
        .windows(2)
        .any(|pair| matches!(pair, [a, b] if (a - b).abs() < 1e-12));
    if !taus.iter().all(is_share) || is_twice {
        return Err(Failure::wrong_input(format!(
            "--tau {:?}: expected shares from 0 to 1, each once",
            args.tau
        )));
    }
    if !(0.0..=1.0).contains(&args.score_threshold) {
        return Err(Failure::wrong_input(format!(
            "--score-threshold {}: expected 0 to 1",
            args.score_threshold
        )));
    }
    Ok(())
}

/// The masks of the region, as said or those of the cracked set.
fn regions_folder(args: &EvaluateArgs) -> Option<PathBuf> {
    let of_set = || Some(args.cracked_set.as_ref()?.join("starbreak").join("regions"));
    args.regions.clone().or_else(of_set)
}

/// The numbers that come with a report, in the one result on standard output.
fn put_joined(
    result: &mut Map<String, Value>,
    evaluation: &Evaluation,
    clean: Option<&CleanResults>,
) {
    let of_clean = clean.iter().flat_map(|clean| &clean.warnings);
    let warnings: Vec<_> = of_clean.chain(&evaluation.warnings).collect();
    result.insert("warnings".to_owned(), json!(warnings));
    result.insert("paired".to_owned(), json!(evaluation.paired));
    for (key, value) in [
        ("failures", json!(evaluation.failures)),
        (
            "tide_clean",
            json!(clean.and_then(|clean| clean.tide.as_ref())),
        ),
        ("tide_cracked", json!(evaluation.tide_cracked)),
        (
            "label_audit",
            json!(clean.and_then(|clean| clean.label_audit.as_ref())),
        ),
    ] {
        if !value.is_null() {
            result.insert(key.to_owned(), value);
        }
    }
}

fn params(args: &EvaluateArgs, truth: &GroundTruth) -> CompareParams {
    let mut params = CompareParams::of(truth.protocol);
    if !args.iou_thresholds.is_empty() {
        params.coco.iou_thresholds.clone_from(&args.iou_thresholds);
    }
    if !args.max_dets.is_empty() {
        params.coco.max_detections.clone_from(&args.max_dets);
    }
    if !args.area_range.is_empty() {
        let ranges = args.area_range.iter();
        params.coco.area_ranges = ranges
            .map(|(name, ends)| AreaRange::new(name, *ends))
            .collect();
    }
    if !args.tau.is_empty() {
        params.taus.clone_from(&args.tau);
    }
    params.coco.by_category = !args.class_agnostic;
    params.coco.has_gt_id_zero_quirk = args.gt_id_zero_quirk;
    params
}

/// What a protocol says of one set, with the numbers of MS-COCO as pycocotools has them.
fn side(evaluated: &Evaluated, said: &SaidDetections) -> Result<Value, Failure> {
    let mut value = serde_json::to_value(&evaluated.results).map_err(Failure::wrong_input)?;
    let Value::Object(members) = &mut value else {
        return Ok(value);
    };
    if let Some(stats) = evaluated.coco.as_ref().and_then(CocoEvaluation::stats) {
        members.insert("coco_stats".to_owned(), json!(stats));
    }
    if !evaluated.kitti.is_empty() {
        members.insert("kitti".to_owned(), kitti(&evaluated.kitti));
    }
    let n_unused = said.unused.as_ref().map_or(0, |unused| unused.n_detections);
    members.insert(
        "n_detections_of_unknown_categories".to_owned(),
        json!(n_unused),
    );
    Ok(value)
}

/// Curves of KITTI by class and difficulty; average precisions in percent, as the benchmark has
/// them.
fn kitti(curves: &[KittiCurve]) -> Value {
    let mut classes = Map::new();
    for curve in curves {
        let class = classes
            .entry(curve.class.name())
            .or_insert_with(|| Value::Object(Map::new()));
        let [ceiling_ap11, ceiling_ap40] = KittiCurve::ceiling(curve.n_gt);
        if let Value::Object(class) = class {
            let of_difficulty = json!({
                "n_gt": curve.n_gt,
                "ap11": curve.ap11(),
                "ap40": curve.ap40(),
                "ceiling_ap11": ceiling_ap11,
                "ceiling_ap40": ceiling_ap40,
                "min_overlap": curve.class.min_overlap(),
                "precision": curve.precision.to_vec(),
                "recall": curve.recall(),
                "thresholds": curve.thresholds,
                "counts": curve.counts,
            });
            class.insert(curve.difficulty.name().to_owned(), of_difficulty);
        }
    }
    Value::Object(classes)
}

fn stage_curves(
    batch: &mut OutputBatch,
    folder: &Path,
    truth: &GroundTruth,
    said: &SaidDetections,
    evaluated: &Evaluated,
    coverages: Option<(&Coverages, usize)>,
    params: &CompareParams,
) -> Result<(), Failure> {
    let Some(coco) = &evaluated.coco else {
        let mut text = kitti(&evaluated.kitti).to_string();
        text.push('\n');
        return Ok(batch.stage(&folder.join("kitti.json"), text.as_bytes())?);
    };
    stage_arrays(batch, folder, coco)?;
    let Some((coverages, idx)) = coverages else {
        return Ok(());
    };
    let coverage = CoverageOf {
        objects: &coverages.objects,
        detections: coverages.detections.get(idx).map_or(&[], Vec::as_slice),
    };
    let most = params.coco.max_detections.last().copied().unwrap_or(100);
    for tau in &params.taus {
        let subset = Subset::InRegion { tau: *tau };
        let curves = subset_curves(&truth.labels, &said.detections, coverage, &subset, most)?;
        let folder: PathBuf = folder.join(format!("region_tau_{tau}"));
        stage_arrays(batch, &folder, &curves)?;
    }
    Ok(())
}

fn stage_arrays(
    batch: &mut OutputBatch,
    folder: &Path,
    coco: &CocoEvaluation,
) -> Result<(), Failure> {
    let [t, r, k, a, m] = coco.shape();
    for (name, shape, values) in [
        ("precision", vec![t, r, k, a, m], &coco.precision),
        ("recall", vec![t, k, a, m], &coco.recall),
        ("scores", vec![t, r, k, a, m], &coco.scores),
    ] {
        let file = encode_array_f64(&shape, values)?;
        batch.stage(&folder.join(format!("{name}.npy")), &file)?;
    }
    Ok(())
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
