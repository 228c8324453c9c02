//! The full form: everything joined into one study with its provenance.

use std::path::{Path, PathBuf};

use serde_json::Value;
use starbreak_dataset::{IndexFiles, SourceSpec, files_in, set_identity};
use starbreak_eval::evaluation::{
    Condition, DamageFacts, EvaluateInput, EvaluateSettings, ImageFolders, InputFile, Provenance,
    Study, Versions, clean_results, evaluate,
};
use starbreak_eval::{
    CompareParams, Compared, Evaluated, GroundTruth, RegionMasks, SaidDetections,
};

use super::EvaluateRequest;
use super::plain::curve_files;
use crate::Error;

/// What was read.
pub(super) struct Join<'a> {
    pub(super) truth: &'a GroundTruth,
    pub(super) clean: &'a SaidDetections,
    pub(super) cracked: Option<&'a SaidDetections>,
    pub(super) masks: Option<RegionMasks<'a>>,
    pub(super) params: &'a CompareParams,
    /// What the protocol says of the clean detections.
    pub(super) of_clean: &'a Evaluated,
    /// And of the cracked ones beside them.
    pub(super) compared: &'a Compared,
}

impl Join<'_> {
    /// Files of the curves of both, by their paths.
    pub(super) fn curves(&self) -> Result<Vec<(PathBuf, Vec<u8>)>, Error> {
        let both = [
            ("clean", Some(self.of_clean), Some(self.clean)),
            ("cracked", self.compared.cracked.as_ref(), self.cracked),
        ];
        let mut files = Vec::new();
        for (idx, (name, evaluated, said)) in both.into_iter().enumerate() {
            if let (Some(evaluated), Some(said)) = (evaluated, said) {
                let coverages = self.compared.coverages.as_ref().map(|it| (it, idx));
                let folder = Path::new(name);
                files.extend(curve_files(
                    folder,
                    self.truth,
                    said,
                    evaluated,
                    coverages,
                    self.params,
                )?);
            }
        }
        Ok(files)
    }

    /// One detector under one condition, as a study.
    pub(super) fn study(&self, request: &EvaluateRequest) -> Result<Study, Error> {
        let settings = EvaluateSettings {
            compare: self.params.clone(),
            score_threshold: request.score_threshold,
            n_replicates: request.n_replicates,
            seed: request.seed,
            n_worst: request.n_worst,
            ..EvaluateSettings::of(self.truth.protocol)
        };
        let identity = request
            .cracked_set
            .as_deref()
            .map(set_identity)
            .transpose()?;
        let condition = Condition {
            name: request
                .condition
                .clone()
                .unwrap_or_else(|| "cracked".to_owned()),
            seed: identity.as_ref().and_then(|set| set.get("seed")?.as_u64()),
            ..Condition::default()
        };
        let detector = request
            .detector
            .clone()
            .unwrap_or_else(|| stem_of(&request.clean));
        let provenance_folder = request
            .cracked_set
            .as_ref()
            .map(|set| set.join("starbreak/provenance"));
        let facts = match provenance_folder {
            Some(folder) => Some(DamageFacts::read(&folder, &self.truth.labels)?),
            None => None,
        };
        let images = match (&self.truth.root, &request.cracked_set) {
            (Some(clean), Some(cracked)) if request.n_worst > 0 => {
                Some(ImageFolders { clean, cracked })
            }
            _ => None,
        };
        let input = EvaluateInput {
            detector: &detector,
            condition: &condition,
            truth: self.truth,
            clean: self.clean,
            cracked: self.cracked,
            regions: self.masks,
            facts: facts.as_ref(),
            images,
            settings: &settings,
        };
        let evaluation = evaluate(&input, self.compared.clone())?;
        let provenance = Provenance {
            inputs: inputs(request)?,
            versions: vec![Versions {
                name: "starbreak".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            }],
            settings: settings.described(self.truth, self.masks.is_some()),
            command: request.command.clone(),
            recipe: identity
                .as_ref()
                .and_then(|set| set.get("recipe").and_then(Value::as_str))
                .map(str::to_owned),
        };
        let name = short_name(&dataset_name(request));
        let mut study = Study::of_one(evaluation, &name, provenance);
        let results = self.of_clean.results.clone();
        let clean = clean_results(&detector, self.truth, self.clean, results)?;
        study.clean.push(clean);
        Ok(study)
    }
}

/// The name of a file without its extension: what a detector is called after its detections.
#[must_use]
pub fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().or_else(|| path.file_name());
    stem.map_or_else(
        || "detector".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// The last part of the path of a dataset or a file, `FORMAT:` before it or not: what a reader calls it.
#[must_use]
pub fn short_name(dataset: &str) -> String {
    let path = dataset.split_once(':').map_or(dataset, |(_, path)| path);
    let name = Path::new(path).file_name();
    name.map_or(dataset.to_owned(), |name| {
        name.to_string_lossy().into_owned()
    })
}

fn dataset_name(request: &EvaluateRequest) -> String {
    match (&request.source, &request.ground_truth) {
        (Some(source), _) => source.to_string_lossy().into_owned(),
        (None, Some(path)) => path_text(path),
        (None, None) => String::new(),
    }
}

/// The files that the numbers rest on, with their hashes.
fn inputs(request: &EvaluateRequest) -> Result<Vec<InputFile>, Error> {
    let mut inputs = Vec::new();
    let mut add = |role: &str, path: &str, files: Vec<PathBuf>| -> Result<(), Error> {
        if !files.is_empty() {
            inputs.push(InputFile::of(role, path, &files)?);
        }
        Ok(())
    };
    match (&request.source, &request.ground_truth) {
        (Some(source), _) => {
            let spec = SourceSpec::parse(source)?;
            add("labels", &dataset_name(request), label_files(&spec))?;
        }
        (None, Some(path)) => add("labels", &path_text(path), files_of(path))?,
        (None, None) => {}
    }
    add(
        "detections, clean",
        &path_text(&request.clean),
        files_of(&request.clean),
    )?;
    if let Some(path) = &request.cracked {
        add("detections, damaged", &path_text(path), files_of(path))?;
    }
    if let Some(path) = &request.clusters {
        add("clusters of images", &path_text(path), files_of(path))?;
    }
    if let Some(set) = &request.cracked_set {
        let run = set.join("starbreak").join("run.json");
        add(
            "what the damaged set is made from",
            &path_text(&run),
            vec![run.clone()],
        )?;
    }
    Ok(inputs)
}

/// A file, or the text files of a folder of results.
#[must_use]
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let texts = |folder: &Path| files_in(folder, "txt").unwrap_or_default();
    let mut files = texts(path);
    for folder in ["data", "label_2"] {
        if files.is_empty() {
            files = texts(&path.join(folder));
        }
    }
    match files.is_empty() {
        true => vec![path.to_owned()],
        false => files.into_iter().map(|(_, file)| file).collect(),
    }
}

/// The files with the labels of a dataset: its indexes, or those of KITTI in their usual places.
#[must_use]
pub fn label_files(spec: &SourceSpec) -> Vec<PathBuf> {
    match IndexFiles::of(spec) {
        Ok(index) => index.names.iter().map(|name| index.path(name)).collect(),
        Err(_) => kitti_files(&spec.path),
    }
}

fn kitti_files(root: &Path) -> Vec<PathBuf> {
    let places = ["training/label_2", "label_2"];
    let found = places
        .iter()
        .find_map(|place| files_in(&root.join(place), "txt").ok());
    found
        .unwrap_or_default()
        .into_iter()
        .map(|(_, file)| file)
        .collect()
}

fn path_text(path: impl AsRef<Path>) -> String {
    path.as_ref().to_string_lossy().into_owned()
}
