//! Labels and detections in, numbers out: what `starbreak evaluate` does, without its screen.

mod join;
mod plain;
mod report_folder;
mod set;

use std::ffi::OsString;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde_json::{Map, Value, json};
use starbreak_dataset::{SourceSpec, file_len};
use starbreak_eval::evaluation::{CleanResults, Evaluation, PairedRow};
use starbreak_eval::report::report_files;
use starbreak_eval::{
    AreaRange, CompareParams, Evaluated, GroundTruth, Protocol, RegionMasks, compare_pair, evaluate,
};

use crate::Error;

use join::Join;
pub use join::{files_of, label_files, short_name, stem_of};
use plain::side;
pub use report_folder::{REPORT_FILES, report_batch};

/// Name and version of the result, the value of its `schema`.
pub const EVALUATION_SCHEMA: &str = "starbreak.evaluation-plain/1";

/// Draws of the bootstrap and of the permutation test that a request may ask for.
pub const REPLICATES: RangeInclusive<u32> = 20..=1_000_000;

/// Most failures that a report shows.
pub const MAX_WORST: u32 = 100;

/// What is to be evaluated, and how. Empty lists stand for what the protocol has.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluateRequest {
    /// Labeled dataset, such as `coco:DIR`.
    pub source: Option<OsString>,
    /// Labels alone instead.
    pub ground_truth: Option<PathBuf>,
    /// Detections in the clean images.
    pub clean: PathBuf,
    /// Detections in the cracked images.
    pub cracked: Option<PathBuf>,
    /// Folder of region masks.
    pub regions: Option<PathBuf>,
    /// The set of cracked images, which has region masks, damage and recipe.
    pub cracked_set: Option<PathBuf>,
    /// Which images are of one clip, drive or scene, as
    /// [`GroundTruth::read_clusters`] reads it; needs [`joins`](Self::joins).
    pub clusters: Option<PathBuf>,
    /// Name of the detector. **Default** that of the file of clean detections.
    pub detector: Option<String>,
    /// Name of the condition. **Default** `cracked`.
    pub condition: Option<String>,
    /// Draws of the bootstrap and of the permutation test. **Default** 1000.
    pub n_replicates: u32,
    /// Score from which a detection counts as found, 0 to 1. **Default** 0.3.
    pub score_threshold: f64,
    /// Worst failures that the report shows. **Default** 6.
    pub n_worst: u32,
    /// Least shares of a box that the region covers for it to be inside, 0 to 1.
    pub taus: Vec<f64>,
    /// By which rules. **Default** those of the dataset.
    pub protocol: Option<Protocol>,
    /// Thresholds of overlap, 0 to 1.
    pub iou_thresholds: Vec<f64>,
    /// Most detections of a category in an image, rising.
    pub max_dets: Vec<u32>,
    /// Ranges of areas, px².
    pub area_ranges: Vec<AreaRange>,
    /// Whether a detection finds an object of any category. **Default** no.
    pub class_agnostic: bool,
    /// Whether a detection that finds the object of number 0 is false, as in pycocotools.
    /// **Default** no.
    pub gt_id_zero_quirk: bool,
    /// Whether intervals, tests and the report are made, too. **Default** no.
    pub joins: bool,
    /// Whether curves are wanted. **Default** no.
    pub curves: bool,
    /// Seed of the draws. **Default** 0.
    pub seed: u64,
    /// The command line, for the report.
    pub command: Option<String>,
}

impl EvaluateRequest {
    /// Detections in clean images, with defaults for all else; labels are still to be named.
    #[must_use]
    pub fn of_clean(clean: PathBuf) -> Self {
        Self {
            source: None,
            ground_truth: None,
            clean,
            cracked: None,
            regions: None,
            cracked_set: None,
            clusters: None,
            detector: None,
            condition: None,
            n_replicates: 1000,
            score_threshold: 0.3,
            n_worst: 6,
            taus: Vec::new(),
            protocol: None,
            iou_thresholds: Vec::new(),
            max_dets: Vec::new(),
            area_ranges: Vec::new(),
            class_agnostic: false,
            gt_id_zero_quirk: false,
            joins: false,
            curves: false,
            seed: 0,
            command: None,
        }
    }
}

/// What came out.
#[derive(Debug)]
pub struct EvaluateAnswer {
    /// The one result: [`EVALUATION_SCHEMA`].
    pub json: Value,
    /// Of the clean images.
    pub clean: Evaluated,
    /// Of the cracked images.
    pub cracked: Option<Evaluated>,
    /// Clean and cracked side by side, in the region and out of it.
    pub paired: Option<Vec<PairedRow>>,
    /// What to mind, in words.
    pub warnings: Vec<String>,
    /// Files of the report by their names, if it was asked for.
    pub report: Vec<(String, String)>,
    /// Files of the curves by their paths, if they were asked for.
    pub curves: Vec<(PathBuf, Vec<u8>)>,
}

/// Evaluates, in the thread pool of the caller.
///
/// # Errors
/// [`Error::Evaluation`] for a request that makes no sense, and for a set that is not as its lists say;
/// [`Error::Eval`] and [`Error::Dataset`] for labels, detections and masks.
pub fn evaluate_files(request: &EvaluateRequest) -> Result<EvaluateAnswer, Error> {
    refuse_mixed(request)?;
    for folder in [&request.regions, &request.cracked_set]
        .into_iter()
        .flatten()
    {
        // For what the system says of one that is not there.
        file_len(folder)?;
    }
    set::refuse_moved_labels(request)?;
    set::check(request)?;
    let truth = ground_truth(request)?;
    let params = params(request, &truth);
    let clean = truth.read_detections(&request.clean)?;
    let cracked = match &request.cracked {
        Some(path) => Some(truth.read_detections(path)?),
        None => None,
    };
    let folder = regions_folder(request);
    if folder.is_none() && !request.taus.is_empty() {
        return Err(refused(
            "tau is about the region; give regions or a damaged set, too".to_owned(),
        ));
    }
    let masks = folder.as_deref().map(|folder| RegionMasks {
        folder,
        root: truth.root.as_deref(),
    });
    let compared = compare_pair(&truth, &clean, cracked.as_ref(), masks, &params)?;
    let of_clean = evaluate(&truth, &clean, &params)?;
    let mut result = Map::from_iter([
        ("schema".to_owned(), json!(EVALUATION_SCHEMA)),
        ("protocol".to_owned(), json!(truth.protocol.name())),
        ("counts".to_owned(), json!(compared.counts)),
        ("warnings".to_owned(), json!(compared.warnings)),
        ("clean".to_owned(), side(&of_clean, &clean)?),
    ]);
    if let (Some(evaluated), Some(said)) = (&compared.cracked, &cracked) {
        result.insert("cracked".to_owned(), side(evaluated, said)?);
    }
    if let Some(regions) = &compared.regions {
        let region = json!({
            "definition": "region-ap/1",
            "taus": params.taus,
            "min_objects": params.min_objects,
            "subsets": regions.subsets,
        });
        result.insert("region".to_owned(), region);
        result.insert("paired".to_owned(), json!(regions.paired));
    }
    let join = Join {
        truth: &truth,
        clean: &clean,
        cracked: cracked.as_ref(),
        masks,
        params: &params,
        of_clean: &of_clean,
        compared: &compared,
    };
    let curves = match request.curves {
        true => join.curves()?,
        false => Vec::new(),
    };
    let mut report = Vec::new();
    if request.joins {
        let study = join.study(request)?;
        if let Some(evaluation) = study.evaluations.first() {
            put_joined(&mut result, evaluation, study.clean.first());
        }
        let files = report_files(&study)?.into_iter();
        report.extend(files.map(|(name, text)| (name.to_owned(), text)));
    }
    Ok(EvaluateAnswer {
        json: Value::Object(result),
        clean: of_clean,
        cracked: compared.cracked,
        paired: compared.regions.map(|regions| regions.paired),
        warnings: compared.warnings.iter().map(ToString::to_string).collect(),
        report,
        curves,
    })
}

/// The labels of a request, with the drives of its images where a file names them.
fn ground_truth(request: &EvaluateRequest) -> Result<GroundTruth, Error> {
    let protocol = request.protocol;
    let mut truth = match (&request.source, &request.ground_truth) {
        (Some(source), _) => GroundTruth::of_dataset(&SourceSpec::parse(source)?, protocol)?,
        (None, Some(path)) => GroundTruth::of_path(path, protocol.unwrap_or(Protocol::Coco))?,
        (None, None) => {
            return Err(refused(
                "no labels; give a SOURCE such as coco:DIR, or the ground truth alone".to_owned(),
            ));
        }
    };
    if let Some(path) = &request.clusters {
        truth.read_clusters(path)?;
    }
    Ok(truth)
}

fn refused(why: String) -> Error {
    Error::Evaluation { why }
}

/// Plain values always are JSON.
fn not_json(cause: serde_json::Error) -> Error {
    refused(format!("the result cannot be written down: {cause}"))
}

/// Labels come from one place; rules of the plain protocol change what is compared nowhere else; τ
/// is a share.
fn refuse_mixed(request: &EvaluateRequest) -> Result<(), Error> {
    if request.source.is_some() && request.ground_truth.is_some() {
        return Err(refused(
            "a source and the ground truth alone both hold labels; give one of them".to_owned(),
        ));
    }
    let compares = request.regions.is_some() || request.cracked_set.is_some() || request.joins;
    let plain = [
        ("thresholds of IoU", !request.iou_thresholds.is_empty()),
        ("class-agnostic matching", request.class_agnostic),
        ("ranges of areas", !request.area_ranges.is_empty()),
    ];
    if compares && let Some((what, _)) = plain.iter().find(|(_, is_there)| *is_there) {
        return Err(refused(format!(
            "{what}: only for the numbers of whole images; leave this out with regions, a cracked set or a report, \
             whose comparisons have rules of their own"
        )));
    }
    if request.clusters.is_some() && !request.joins {
        return Err(refused(
            "clusters are about intervals and tests, which come with a report; give a folder for it, too"
                .to_owned(),
        ));
    }
    let mut taus: Vec<f64> = request.taus.clone();
    taus.sort_by(f64::total_cmp);
    let is_share = |tau: &f64| (0.0..=1.0).contains(tau);
    let is_twice = taus
        .windows(2)
        .any(|pair| matches!(pair, [a, b] if (a - b).abs() < 1e-12));
    if !taus.iter().all(is_share) || is_twice {
        return Err(refused(format!(
            "tau {:?}: expected shares from 0 to 1, each once",
            request.taus
        )));
    }
    if !REPLICATES.contains(&request.n_replicates) {
        return Err(refused(format!(
            "replicates {}: expected {} to {}",
            request.n_replicates,
            REPLICATES.start(),
            REPLICATES.end()
        )));
    }
    if request.n_worst > MAX_WORST {
        return Err(refused(format!(
            "worst failures {}: expected 0 to {MAX_WORST}",
            request.n_worst
        )));
    }
    if !(0.0..=1.0).contains(&request.score_threshold) {
        return Err(refused(format!(
            "score threshold {}: expected 0 to 1",
            request.score_threshold
        )));
    }
    Ok(())
}

/// The masks of the region, as said or those of the cracked set.
fn regions_folder(request: &EvaluateRequest) -> Option<PathBuf> {
    let of_set = || {
        Some(
            request
                .cracked_set
                .as_ref()?
                .join("starbreak")
                .join("regions"),
        )
    };
    request.regions.clone().or_else(of_set)
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
    let tide_clean = clean.and_then(|clean| clean.tide.as_ref());
    let label_audit = clean.and_then(|clean| clean.label_audit.as_ref());
    for (key, value) in [
        ("failures", json!(evaluation.failures)),
        ("tide_clean", json!(tide_clean)),
        ("tide_cracked", json!(evaluation.tide_cracked)),
        ("label_audit", json!(label_audit)),
    ] {
        if !value.is_null() {
            result.insert(key.to_owned(), value);
        }
    }
}

fn params(request: &EvaluateRequest, truth: &GroundTruth) -> CompareParams {
    let mut params = CompareParams::of(truth.protocol);
    let coco = &mut params.coco;
    if !request.iou_thresholds.is_empty() {
        coco.iou_thresholds.clone_from(&request.iou_thresholds);
    }
    if !request.max_dets.is_empty() {
        coco.max_detections.clone_from(&request.max_dets);
    }
    if !request.area_ranges.is_empty() {
        coco.area_ranges.clone_from(&request.area_ranges);
    }
    coco.by_category = !request.class_agnostic;
    coco.has_gt_id_zero_quirk = request.gt_id_zero_quirk;
    if !request.taus.is_empty() {
        params.taus.clone_from(&request.taus);
    }
    params
}
