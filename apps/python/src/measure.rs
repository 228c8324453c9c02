//! `evaluate` and `divergence`: what cracks do to detectors, and how far sets of images are apart.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use starbreak_runs::Error;
use starbreak_runs::dataset::SourceSpec;
use starbreak_runs::divergence::{Eye, MAX_DRAWS, MAX_SIDE_PX, NamedSet};
use starbreak_runs::eval::divergence::{
    Background, CompareSettings, ImageSet, ReadSettings, compare_sets,
};
use starbreak_runs::eval::{AreaRange, Protocol};
use starbreak_runs::evaluation::{
    EvaluateRequest, MAX_WORST, REPLICATES, REPORT_FILES, evaluate_files, report_batch,
};
use starbreak_runs::with_threads;

use crate::arguments::{Given, List, Real, SeedArg, Whole};
use crate::errors::raised;
use crate::values::python_of;

/// Most threads that can be asked for.
const MAX_THREADS: usize = 1024;

/// How often a signal, such as Ctrl-C, is looked for while others work.
const SIGNAL_PERIOD: Duration = Duration::from_millis(50);

/// How well detections match labels: on clean and on damaged images, inside and outside the damaged
/// region. Returns what `starbreak evaluate --json` prints, as dicts.
///
/// source: labeled dataset, as `coco:DIR`, `kitti:DIR`, `bdd:DIR` or `yolo:DIR`; or
/// ground_truth: labels alone, a file of MS-COCO or BDD100K, or a folder `label_2` of KITTI.
/// clean, cracked: detections on the clean and on the damaged images: MS-COCO results (JSON),
/// Scalabel frames (JSON), or a folder of KITTI results.
/// regions: folder of region masks, as written by `generate`; or
/// cracked_set: the whole set written by `generate`, with masks, damage and recipe.
/// protocol: `coco`, `kitti` or `bdd`; default: that of the dataset.
/// tau: a box is inside if the region covers at least this share of it, 0 to 1; several values.
/// iou_thresholds, max_dets, area_ranges (name to minimum and maximum px²), class_agnostic,
/// gt_id_zero_quirk: rules that replace those of the protocol, for whole images only.
/// output: folder for report.html, evaluation.json, numbers.csv, table.tex and failures.jsonl, with
/// intervals and tests, and the list written.json. An earlier report is replaced; other files only
/// with `replace`; inputs never.
/// detector, condition (their names), replicates (20 to 1000000), score_threshold (0 to 1), worst
/// (0 to 100), seed: settings of the report.
/// threads: 0 for one per processor.
///
/// Raises `ValueError` for an invalid request or invalid files, `OSError` for files that cannot be
/// read or written; a file that exists already is a `FileExistsError`.
///
/// >>> import json, pathlib, starbreak, tempfile
/// >>> folder = pathlib.Path(tempfile.mkdtemp())
/// >>> labels = {"images": [{"id": 1, "file_name": "1.png", "width": 99, "height": 99}],
/// ...           "categories": [{"id": 1, "name": "car"}],
/// ...           "annotations": [{"id": 1, "image_id": 1, "category_id": 1, "iscrowd": 0,
/// ...                            "bbox": [9, 9, 50, 50], "area": 2500}]}
/// >>> found = [{"image_id": 1, "category_id": 1, "bbox": [9, 9, 50, 50], "score": 0.9}]
/// >>> _ = (folder / "labels.json").write_text(json.dumps(labels))
/// >>> _ = (folder / "found.json").write_text(json.dumps(found))
/// >>> result = starbreak.evaluate(ground_truth=folder / "labels.json", clean=folder / "found.json")
/// >>> round(result["clean"]["coco_stats"][0], 3)
/// 1.0
#[pyfunction]
#[pyo3(
    signature = (source = None, *, clean, cracked = None, ground_truth = None, regions = None, cracked_set = None, protocol = None, tau = Given::of(List(Vec::new())), iou_thresholds = Given::of(List(Vec::new())), max_dets = Given::of(List(Vec::new())), area_ranges = Given::of(BTreeMap::new()), class_agnostic = Given::of(false), gt_id_zero_quirk = Given::of(false), output = None, replace = Given::of(false), detector = None, condition = None, replicates = Whole::of(1000), score_threshold = Given::of(Real(0.3)), worst = Whole::of(6), seed = SeedArg::ZERO, threads = Whole::of(0)),
    text_signature = "(source=None, *, clean, cracked=None, ground_truth=None, regions=None, cracked_set=None, protocol=None, tau=(), iou_thresholds=(), max_dets=(), area_ranges={}, class_agnostic=False, gt_id_zero_quirk=False, output=None, replace=False, detector=None, condition=None, replicates=1000, score_threshold=0.3, worst=6, seed=0, threads=0)"
)]
#[expect(
    clippy::too_many_arguments,
    reason = "they have names and defaults in Python"
)]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    source: Option<Given<OsString>>,
    clean: Given<PathBuf>,
    cracked: Option<Given<PathBuf>>,
    ground_truth: Option<Given<PathBuf>>,
    regions: Option<Given<PathBuf>>,
    cracked_set: Option<Given<PathBuf>>,
    protocol: Option<Given<String>>,
    tau: Given<List<Real>>,
    iou_thresholds: Given<List<Real>>,
    max_dets: Given<List<Whole>>,
    area_ranges: Given<BTreeMap<String, [Real; 2]>>,
    class_agnostic: Given<bool>,
    gt_id_zero_quirk: Given<bool>,
    output: Option<Given<PathBuf>>,
    replace: Given<bool>,
    detector: Option<Given<String>>,
    condition: Option<Given<String>>,
    replicates: Whole,
    score_threshold: Given<Real>,
    worst: Whole,
    seed: SeedArg,
    threads: Whole,
) -> PyResult<Bound<'py, PyAny>> {
    let protocol = Given::if_given(protocol, "protocol")?.map(|name| {
        let all = [Protocol::Coco, Protocol::Kitti, Protocol::Bdd];
        let known = all.into_iter().find(|protocol| protocol.name() == name);
        known.ok_or_else(|| one_of("protocol", &name, &all.map(Protocol::name)))
    });
    let shares = |given: Given<List<Real>>, name: &str| -> PyResult<Vec<f64>> {
        Ok(given.named(name)?.0.iter().map(|share| share.0).collect())
    };
    let output = Given::if_given(output, "output")?;
    let replaces = replace.named("replace")?;
    let ranges = area_ranges.named("area_ranges")?.into_iter();
    let max_dets = max_dets
        .named("max_dets")?
        .0
        .iter()
        .map(|n| n.within("max_dets", 1..=u32::MAX))
        .collect::<PyResult<_>>()?;
    let request = EvaluateRequest {
        source: Given::if_given(source, "source")?,
        ground_truth: Given::if_given(ground_truth, "ground_truth")?,
        cracked: Given::if_given(cracked, "cracked")?,
        regions: Given::if_given(regions, "regions")?,
        cracked_set: Given::if_given(cracked_set, "cracked_set")?,
        detector: Given::if_given(detector, "detector")?,
        condition: Given::if_given(condition, "condition")?,
        n_replicates: replicates.within("replicates", REPLICATES)?,
        score_threshold: score_threshold.named("score_threshold")?.0,
        n_worst: worst.within("worst", 0..=MAX_WORST)?,
        taus: shares(tau, "tau")?,
        protocol: protocol.transpose()?,
        iou_thresholds: shares(iou_thresholds, "iou_thresholds")?,
        max_dets,
        area_ranges: ranges
            .map(|(name, ends)| AreaRange::new(&name, ends.map(|end| end.0)))
            .collect(),
        class_agnostic: class_agnostic.named("class_agnostic")?,
        gt_id_zero_quirk: gt_id_zero_quirk.named("gt_id_zero_quirk")?,
        joins: output.is_some(),
        seed: seed.0.0,
        ..EvaluateRequest::of_clean(clean.named("clean")?)
    };
    let answer = watched(py, &threads, |_| -> Result<_, Error> {
        let source = request.source.as_deref().map(SourceSpec::parse);
        let read = request.read_files(source.transpose()?.as_ref());
        let batch = output
            .as_ref()
            .map(|folder| report_batch(folder, &REPORT_FILES, replaces, read));
        let batch = batch.transpose()?;
        let answer = evaluate_files(&request)?;
        if let (Some(folder), Some(mut batch)) = (&output, batch) {
            for (name, text) in &answer.report {
                batch.stage(&folder.join(name), text.as_bytes())?;
            }
            batch.commit()?;
        }
        Ok(answer.json)
    })?;
    python_of(py, &answer)
}

/// How far sets of images are apart: Kullback-Leibler and other divergences, with intervals, noise
/// floors and tests. Returns what `starbreak divergence --json` prints, as dicts.
///
/// sets: two or more of `folder:DIR`, `kitti:DIR`, `coco:DIR`, `bdd:DIR`, `yolo:DIR`, `list:FILE`,
/// or `networks:DIR` for crack networks; optionally with a name in front (`clean=folder:DIR`).
/// limit: use only the first images of each set.
/// alpha: pseudocount added to each bin.
/// bootstrap, permutations, splits: number of draws for intervals, p-values and noise floors, 0 to
/// 1000000.
/// seed: of these draws.
/// side: shorter side of the image for gradients and spectra, px; 0 for full size.
/// background: what shows through transparent pixels, `black`, `gray` or `white`.
/// model, layer: an ONNX detector whose activations are compared as well, and the name of the
/// value.
/// threads: 0 for one per processor.
///
/// An image that cannot be read is left out of all numbers and listed under `failed` of its set.
/// Raises `ValueError` and `OSError` as `evaluate`. Ctrl-C stops the reading of images, but not the
/// draws.
#[pyfunction]
#[pyo3(
    signature = (*sets, limit = None, alpha = Given::of(Real(0.5)), bootstrap = Whole::of(1000), permutations = Whole::of(999), splits = Whole::of(100), seed = SeedArg::ZERO, side = Whole::of(256), background = Given::of("black".to_owned()), model = None, layer = None, threads = Whole::of(0)),
    text_signature = "(*sets, limit=None, alpha=0.5, bootstrap=1000, permutations=999, splits=100, seed=0, side=256, background='black', model=None, layer=None, threads=0)"
)]
#[expect(
    clippy::too_many_arguments,
    reason = "they have names and defaults in Python"
)]
pub(crate) fn divergence<'py>(
    py: Python<'py>,
    sets: Vec<Given<OsString>>,
    limit: Option<Whole>,
    alpha: Given<Real>,
    bootstrap: Whole,
    permutations: Whole,
    splits: Whole,
    seed: SeedArg,
    side: Whole,
    background: Given<String>,
    model: Option<Given<PathBuf>>,
    layer: Option<Given<String>>,
    threads: Whole,
) -> PyResult<Bound<'py, PyAny>> {
    let sets = sets.into_iter().enumerate();
    let sets = sets.map(|(idx, set)| set.named(&format!("sets[{idx}]")));
    let sets: Vec<OsString> = sets.collect::<PyResult<_>>()?;
    let model = Given::if_given(model, "model")?;
    let layer = Given::if_given(layer, "layer")?;
    if model.is_none() && layer.is_some() {
        let said = "layer is one of a model; give model, too, or leave layer out";
        return Err(PyValueError::new_err(said));
    }
    let background = background.named("background")?;
    let reading = ReadSettings {
        background: Background::of_name(&background)
            .ok_or_else(|| one_of("background", &background, &Background::NAMES))?,
        shorter_side_px: side.within("side", 0..=MAX_SIDE_PX)?,
    };
    let settings = CompareSettings {
        alpha: alpha.named("alpha")?.0,
        n_bootstrap: bootstrap.within("bootstrap", 0..=MAX_DRAWS)?,
        n_permutations: permutations.within("permutations", 0..=MAX_DRAWS)?,
        n_splits: splits.within("splits", 0..=MAX_DRAWS)?,
        seed: seed.0.0,
    };
    let limit = limit
        .map(|n| n.within("limit", 1..=usize::MAX))
        .transpose()?;
    let report = watched(py, &threads, |stop| -> Result<_, Error> {
        let named = NamedSet::parse_all(&sets)?;
        let eye = model.map(|model| Eye::open(&model, layer.as_deref()));
        let eye = eye.transpose()?;
        let read = named.into_iter().map(|set| {
            // Nothing is written that a link could lead to.
            let set = set.following_links(true);
            let open = set.open(limit)?;
            open.read(&reading, eye.as_ref(), stop, &|| ())
        });
        let read: Vec<ImageSet> = read.collect::<Result<_, _>>()?;
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        let report = compare_sets(&read, &reading, &settings)?;
        Ok(serde_json::to_value(report).unwrap_or_default())
    })?;
    python_of(py, &report)
}

fn one_of(name: &str, found: &str, known: &[&str]) -> PyErr {
    PyValueError::new_err(format!(
        "{name} = {found:?}; expected one of {}",
        known.join(", ")
    ))
}

/// Work in a pool of its own, without the interpreter's lock, while this thread looks for signals;
/// one, such as Ctrl-C, tells the work to stop and is raised once it has.
fn watched<R: Send>(
    py: Python<'_>,
    threads: &Whole,
    work: impl FnOnce(&AtomicBool) -> Result<R, Error> + Send,
) -> PyResult<R> {
    let n_threads = threads.within("threads", 0..=MAX_THREADS)?;
    let stop = AtomicBool::new(false);
    let mut signal = Ok(());
    let result = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            let stop = &stop;
            let worker = scope.spawn(move || {
                let result = with_threads(n_threads, || work(stop));
                drop(done);
                result
            });
            while is_done.recv_timeout(SIGNAL_PERIOD) == Err(RecvTimeoutError::Timeout) {
                if signal.is_ok() {
                    signal = Python::attach(|py| py.check_signals());
                }
                if signal.is_err() {
                    stop.store(true, Ordering::Relaxed);
                }
            }
            worker.join()
        })
    });
    signal?;
    match result {
        Ok(result) => result
            .and_then(|result| result)
            .map_err(|error| raised(&error)),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}
