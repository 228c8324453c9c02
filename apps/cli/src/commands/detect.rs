//! `starbreak detect`: a detector over a dataset or a clip.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};
use starbreak_dataset::{
    DatasetError, ObjectKind, OutputBatch, Source, files_in, is_inside, read_text, same_file,
};
use starbreak_detect::{
    Contract, DetectError, Detector, DetectorOptions, ImageDetections, ImageToSee, LabelMap,
    LabelRules, preset_names,
};
use starbreak_eval::{BoxPx, Detection, Detections, LabelSet};

use super::boxed_clip::BoxedClip;
use super::detect_clip;
use super::detect_labels::Referred;
use crate::args::Global;
use crate::args::detect::{DetectArgs, ResultFormat};
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Longest contract or label map that is read, bytes.
const MOST_TOML_BYTES: u64 = 1 << 20;

/// Names that are listed in a remark.
const MOST_NAMED: usize = 12;

pub(crate) fn run(global: &Global, args: &DetectArgs, screen: &Screen) -> Result<u8, Failure> {
    let (Some(source), Some(model), Some(output)) = (&args.source, &args.model, &args.output)
    else {
        return list_contracts(screen);
    };
    let run = Run {
        global,
        args,
        model,
        output,
        screen,
    };
    run.refuse_output()?;
    let clip = detect_clip::clip_of(source);
    let boxed = BoxedClip::of(&run, clip.as_deref())?;
    let looked = match &clip {
        Some(clip) => detect_clip::look(&run, clip)?,
        None => look(&run, source)?,
    };
    let results = Results::of(&looked);
    if results.failures.len() == looked.names.len() {
        return Err(Failure {
            message: format!(
                "nothing was written: not one of {} images could be looked at, the first because: {}",
                looked.names.len(),
                results
                    .failures
                    .first()
                    .map_or("", |(_, error)| error.as_str())
            ),
            code: SOME_FAILED,
        });
    }
    let mut batch = run.batch();
    if let Some(boxed) = &boxed {
        boxed.stage(&run, &looked, &mut batch)?;
    }
    stage(&run, &results.detections, &looked.referred, &mut batch)?;
    batch.commit()?;
    finish(&looked, output, &results, screen)
}

/// What was asked for.
pub(super) struct Run<'a> {
    pub(super) global: &'a Global,
    pub(super) args: &'a DetectArgs,
    pub(super) model: &'a Path,
    pub(super) output: &'a Path,
    pub(super) screen: &'a Screen,
}

impl Run<'_> {
    pub(super) fn detector(&self) -> Result<Detector, Failure> {
        Ok(Detector::open(
            self.model,
            &options_of(self.args, self.screen)?,
        )?)
    }

    /// The batch that the detections go into. A folder of KITTI's form holds those of one run.
    fn batch(&self) -> OutputBatch {
        match self.args.format {
            ResultFormat::Kitti => {
                let list = self.output.join("written.json");
                self.global.batch().with_list(&list, "detect")
            }
            ResultFormat::Coco | ResultFormat::Bdd => self.global.batch(),
        }
    }

    /// The output can be written, and takes the place of no file that it may not: better said before
    /// the work than after.
    fn refuse_output(&self) -> Result<(), Failure> {
        let contract = self.args.contract.as_deref().map(PathBuf::from);
        let label_map = self.args.label_map.clone();
        let inputs = [Some(self.model.to_owned()), contract, label_map];
        self.refuse_among(inputs.into_iter().flatten())?;
        match self.args.format {
            ResultFormat::Coco | ResultFormat::Bdd => {
                self.batch().reserve(self.output)?;
            }
            ResultFormat::Kitti => {
                let folder = self.output.join("data");
                self.batch().reserve(&folder.join("trial.txt"))?;
                let batch = self.batch();
                if folder.is_dir() {
                    for (_, path) in files_in(&folder, "txt")? {
                        batch.may_write(&path)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The output is none of these, and holds none of them.
    pub(super) fn refuse_among(
        &self,
        inputs: impl Iterator<Item = PathBuf>,
    ) -> Result<(), Failure> {
        let is_folder = self.args.format == ResultFormat::Kitti;
        // What is not there yet is no input, and in a folder all is.
        let is_output = |input: &PathBuf| match is_folder {
            true => is_inside(input, self.output),
            false => same_file(input, self.output),
        };
        if !self.output.exists() {
            return Ok(());
        }
        match { inputs }.find(is_output) {
            None => Ok(()),
            Some(input) => Err(DatasetError::OutputIsInput {
                input,
                output: self.output.to_owned(),
            }
            .into()),
        }
    }

    /// Which class is which category, where the images come from this format; said out loud.
    pub(super) fn map(
        &self,
        detector: &Detector,
        labels: &LabelSet,
        format: &str,
    ) -> Result<LabelMap, Failure> {
        let rules = match &self.args.label_map {
            Some(path) => label_rules(path)?,
            None => LabelRules::of_dataset(format)?,
        };
        let map = LabelMap::new(detector.classes(), &labels.category_names(), &rules)?;
        say_contract(detector, self.screen);
        say_unmapped(&map, self.screen);
        Ok(map)
    }
}

/// What a detector has looked at.
pub(super) struct Looked {
    pub(super) detector: Detector,
    pub(super) map: LabelMap,
    pub(super) names: Vec<String>,
    pub(super) seen: Vec<Result<ImageDetections, DetectError>>,
    pub(super) referred: Referred,
    pub(super) seconds: f64,
}

/// Looks through the images of a dataset.
fn look(run: &Run<'_>, source: &OsStr) -> Result<Looked, Failure> {
    let spec = run
        .global
        .spec(source)
        .map_err(|error| Failure::wrong_input(format!("{error}; a clip is clip:FILE")))?;
    let source = Source::open(&spec)?;
    let images = images_of(&source, run.args.limit, run.screen)?;
    let labels = source.files().filter_map(Result::ok).map(|file| file.path);
    run.refuse_among(labels.chain(images.iter().map(|image| image.path.clone())))?;
    let detector = run.detector()?;
    let referred = Referred::of(&spec, &images, detector.classes())?;
    let map = run.map(&detector, &referred.labels, source.format().name())?;
    look_at(run, detector, map, &images, referred)
}

/// Looks through images.
pub(super) fn look_at(
    run: &Run<'_>,
    detector: Detector,
    map: LabelMap,
    images: &[ImageToSee],
    referred: Referred,
) -> Result<Looked, Failure> {
    let interrupt = Interrupt::listen(run.screen);
    let progress = run.screen.progress(images.len() as u64, "images");
    let started = Instant::now();
    let seen = detector.detect_all(
        images,
        usize::from(run.global.threads),
        interrupt.flag(),
        &|image, found| {
            progress.step();
            if let Err(error) = found {
                progress.line(&format!("error: {:?}: {error}", image.name));
            }
        },
    );
    progress.finish();
    let seen: Option<Vec<_>> = seen.into_iter().collect();
    Ok(Looked {
        detector,
        map,
        names: images.iter().map(|image| image.name.clone()).collect(),
        seen: seen.ok_or_else(interrupted)?,
        referred,
        seconds: started.elapsed().as_secs_f64(),
    })
}

pub(super) fn interrupted() -> Failure {
    Failure::interrupted("interrupted: nothing was written; run the command again")
}

/// The files of the detections.
fn stage(
    run: &Run<'_>,
    detections: &Detections,
    referred: &Referred,
    batch: &mut OutputBatch,
) -> Result<(), Failure> {
    let (labels, output) = (&referred.labels, run.output);
    let files: Vec<(PathBuf, String)> = match run.args.format {
        ResultFormat::Coco => vec![(output.to_owned(), detections.to_coco(labels))],
        ResultFormat::Bdd => vec![(output.to_owned(), detections.to_scalabel(labels))],
        ResultFormat::Kitti => {
            let mut seen = referred.places.clone();
            seen.sort_unstable();
            // Frames that were not looked through have no file: they are not evaluated.
            let files = (0_u32..).zip(detections.to_kitti(labels));
            files
                .filter(|(place, _)| seen.binary_search(place).is_ok())
                .map(|(_, (name, text))| (output.join("data").join(name), text))
                .collect()
        }
    };
    for (path, text) in &files {
        batch.stage(path, text.as_bytes())?;
    }
    Ok(())
}

fn list_contracts(screen: &Screen) -> Result<u8, Failure> {
    let mut lines = Vec::new();
    for name in preset_names() {
        lines.push(format!("{name:24} {}", Contract::preset(name)?.about));
    }
    screen.data(&lines.join("\n"))?;
    Ok(DONE)
}

/// The contract of a preset or a file.
pub(super) fn contract_of(name: &str) -> Result<Contract, Failure> {
    let is_preset = preset_names().any(|known| known == name);
    if !is_preset && (name.ends_with(".toml") || Path::new(name).is_file()) {
        let text = read_text(Path::new(name), MOST_TOML_BYTES)?;
        return Ok(Contract::parse(name, &text.text)?);
    }
    // The error names the presets.
    Ok(Contract::preset(name)?)
}

/// The label map in a file.
pub(super) fn label_rules(path: &Path) -> Result<LabelRules, Failure> {
    let text = read_text(path, MOST_TOML_BYTES)?;
    Ok(LabelRules::parse(&path.to_string_lossy(), &text.text)?)
}

fn options_of(args: &DetectArgs, screen: &Screen) -> Result<DetectorOptions, Failure> {
    let contract = args.contract.as_deref().map(contract_of).transpose()?;
    Ok(DetectorOptions {
        contract,
        score_threshold: args.score_threshold,
        backend: args.runtime.backend(screen)?,
        ..DetectorOptions::default()
    })
}

fn images_of(
    source: &Source,
    limit: Option<usize>,
    screen: &Screen,
) -> Result<Vec<ImageToSee>, Failure> {
    let mut images = Vec::new();
    let mut n_bad = 0_u64;
    for image in source.images() {
        match image {
            Ok(image) => images.push(ImageToSee {
                name: image.name,
                path: image.path,
            }),
            Err(bad) => {
                n_bad += 1;
                screen.note(&format!("bad record: {bad}"));
            }
        }
    }
    if n_bad > 0 {
        return Err(Failure::wrong_input(format!(
            "the dataset has {n_bad} bad records; mend them"
        )));
    }
    images.truncate(limit.unwrap_or(usize::MAX));
    if images.is_empty() {
        return Err(Failure::wrong_input(format!(
            "{:?} holds no image to be looked through; check the path and --limit",
            source.root()
        )));
    }
    Ok(images)
}

/// How images become input and outputs boxes, and why so.
pub(super) fn say_contract(detector: &Detector, screen: &Screen) {
    let contract = detector.contract();
    screen.note(&format!(
        "contract {}, because {}: {}",
        contract.name,
        detector.reason(),
        contract.about
    ));
    screen.note(&format!(
        "{} classes by {}; scores from {} on, at most {} detections per image; run by {}",
        contract.classes.names.iter().flatten().count(),
        contract.classes.origin,
        contract.score_threshold,
        contract.max_detections,
        detector.runtime()
    ));
}

/// Which classes and categories have no partner.
pub(super) fn say_unmapped(map: &LabelMap, screen: &Screen) {
    let list = |names: &[&str]| {
        let mut text: Vec<&str> = names.iter().take(MOST_NAMED).copied().collect();
        if names.len() > MOST_NAMED {
            text.push("…");
        }
        text.join(", ")
    };
    let classes: Vec<&str> = map.unmapped_classes().iter().map(String::as_str).collect();
    if !classes.is_empty() {
        screen.note(&format!(
            "{} classes of the model have no category in the dataset, their detections are left out: {}",
            classes.len(),
            list(&classes)
        ));
    }
    // KITTI's areas of no labels are no objects.
    let categories = map.unmapped_categories().iter().map(String::as_str);
    let categories: Vec<&str> = categories
        .filter(|name| ObjectKind::of_kitti_type(name) != ObjectKind::Ignored)
        .collect();
    if !categories.is_empty() {
        screen.note(&format!(
            "{} categories of the dataset have no class in the model, their objects cannot be found: {}",
            categories.len(),
            list(&categories)
        ));
    }
}

/// Detections, and what was counted on the way.
struct Results {
    detections: Detections,
    n_unmapped: u64,
    n_inverted: u64,
    n_without_class: u64,
    failures: Vec<(String, String)>,
}

impl Results {
    fn of(looked: &Looked) -> Self {
        let mut results = Self {
            detections: Detections::default(),
            n_unmapped: 0,
            n_inverted: 0,
            n_without_class: 0,
            failures: Vec::new(),
        };
        let images = looked.names.iter().zip(&looked.seen);
        for ((name, seen), &place) in images.zip(&looked.referred.places) {
            match seen {
                Ok(found) => {
                    results.n_inverted += u64::from(found.n_inverted);
                    results.n_without_class += u64::from(found.n_without_class);
                    for raw in &found.detections {
                        let Some(category) = looked.map.category(raw.class) else {
                            results.n_unmapped += 1;
                            continue;
                        };
                        results.detections.items.push(Detection {
                            image: place,
                            category,
                            box_px: BoxPx::from_corners(raw.corners_px),
                            score: raw.score,
                        });
                    }
                }
                Err(error) => results.failures.push((name.clone(), error.to_string())),
            }
        }
        results
    }
}

fn finish(
    looked: &Looked,
    output: &Path,
    results: &Results,
    screen: &Screen,
) -> Result<u8, Failure> {
    let n_images = looked.names.len();
    #[expect(clippy::cast_precision_loss, reason = "a rate")]
    let rate = n_images as f64 / looked.seconds.max(1e-9);
    let n_failed = results.failures.len();
    let mut said = format!(
        "{}: {} detections in {} images, {rate:.1} images per second",
        output.display(),
        results.detections.items.len(),
        n_images - n_failed,
    );
    for (n, what) in [
        (
            results.n_unmapped,
            "detections of classes without a category",
        ),
        (results.n_inverted, "boxes with sides the wrong way round"),
        (results.n_without_class, "boxes of labels that are no class"),
    ] {
        if n > 0 {
            said.push_str(&format!("; left out {n} {what}"));
        }
    }
    screen.say(&said);
    screen.result(|| result_json(looked, output, results))?;
    if n_failed == 0 {
        return Ok(DONE);
    }
    let first = results.failures.first();
    Err(Failure {
        message: format!(
            "{n_failed} of {n_images} images failed and have no detections, the first: {}; mend or remove them and run \
             the command again",
            first.map_or_else(String::new, |(name, error)| format!("{name:?}: {error}")),
        ),
        code: SOME_FAILED,
    })
}

fn result_json(looked: &Looked, output: &Path, results: &Results) -> Value {
    let Looked { detector, map, .. } = looked;
    let contract = detector.contract();
    json!({
        "output": path_text(output),
        "contract": contract.name,
        "reason": detector.reason(),
        "runtime": detector.runtime(),
        "score_threshold": contract.score_threshold,
        "n_classes": contract.classes.names.iter().flatten().count(),
        "unmapped_classes": map.unmapped_classes(),
        "unmapped_categories": map.unmapped_categories(),
        "n_images": looked.names.len(),
        "n_detections": results.detections.items.len(),
        "n_unmapped": results.n_unmapped,
        "n_inverted": results.n_inverted,
        "n_without_class": results.n_without_class,
        "seconds": looked.seconds,
        "failed": results
            .failures
            .iter()
            .map(|(name, error)| json!({"name": name, "error": error}))
            .collect::<Vec<_>>(),
    })
}
