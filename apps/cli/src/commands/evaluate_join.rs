//! The full form of `starbreak evaluate`: everything joined into one study with its provenance.

use std::path::{Path, PathBuf};

use serde_json::Value;
use starbreak::dataset::{IndexFiles, SourceSpec, files_in, set_identity};
use starbreak_eval::evaluation::{
    Condition, DamageFacts, EvaluateInput, EvaluateSettings, ImageFolders, InputFile, Provenance,
    Study, Versions, clean_results, evaluate,
};
use starbreak_eval::{CompareParams, GroundTruth, RegionMasks, SaidDetections};

use crate::args::Global;
use crate::args::evaluate::EvaluateArgs;
use crate::failure::Failure;
use crate::screen::path_text;

/// What was read.
pub(super) struct Join<'a> {
    pub(super) truth: &'a GroundTruth,
    pub(super) clean: &'a SaidDetections,
    pub(super) cracked: Option<&'a SaidDetections>,
    pub(super) masks: Option<RegionMasks<'a>>,
    pub(super) params: &'a CompareParams,
}

impl Join<'_> {
    /// One detector under one condition, as a study.
    pub(super) fn study(&self, global: &Global, args: &EvaluateArgs) -> Result<Study, Failure> {
        if !(args.score_threshold.is_finite() && (0.0..=1.0).contains(&args.score_threshold)) {
            return Err(Failure::wrong_input(format!(
                "--score-threshold {}: expected 0 to 1",
                args.score_threshold
            )));
        }
        let settings = EvaluateSettings {
            compare: self.params.clone(),
            score_threshold: args.score_threshold,
            n_replicates: args.replicates,
            seed: global.seed,
            n_worst: args.worst,
            ..EvaluateSettings::of(self.truth.protocol)
        };
        let identity = args.cracked_set.as_deref().map(set_identity).transpose()?;
        let condition = Condition {
            name: args
                .condition
                .clone()
                .unwrap_or_else(|| "cracked".to_owned()),
            seed: identity.as_ref().and_then(|set| set.get("seed")?.as_u64()),
            ..Condition::default()
        };
        let detector = args
            .detector
            .clone()
            .unwrap_or_else(|| stem_of(&args.clean));
        let provenance_folder = args
            .cracked_set
            .as_ref()
            .map(|set| set.join("starbreak/provenance"));
        let facts = match provenance_folder {
            Some(folder) => Some(DamageFacts::read(&folder, &self.truth.labels)?),
            None => None,
        };
        let images = match (&self.truth.root, &args.cracked_set) {
            (Some(clean), Some(cracked)) if args.worst > 0 => Some(ImageFolders { clean, cracked }),
            _ => None,
        };
        let evaluation = evaluate(&EvaluateInput {
            detector: &detector,
            condition: &condition,
            truth: self.truth,
            clean: self.clean,
            cracked: self.cracked,
            regions: self.masks,
            facts: facts.as_ref(),
            images,
            settings: &settings,
        })?;
        let provenance = Provenance {
            inputs: inputs(args)?,
            versions: vec![Versions {
                name: "starbreak".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            }],
            settings: settings.described(self.truth, self.masks.is_some()),
            command: Some(command()),
            recipe: identity
                .as_ref()
                .and_then(|set| set.get("recipe").and_then(Value::as_str))
                .map(str::to_owned),
        };
        let dataset = dataset_name(args);
        let name = Path::new(&dataset).file_name();
        let name = name.map_or(dataset.clone(), |name| name.to_string_lossy().into_owned());
        let mut study = Study::of_one(evaluation, &name, provenance);
        let clean = clean_results(&detector, self.truth, self.clean, &settings)?;
        study.clean.push(clean);
        Ok(study)
    }
}

pub(super) fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().or_else(|| path.file_name());
    stem.map_or_else(
        || "detector".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

fn dataset_name(args: &EvaluateArgs) -> String {
    match (&args.source, &args.ground_truth) {
        (Some(source), _) => source.to_string_lossy().into_owned(),
        (None, Some(path)) => path_text(path),
        (None, None) => String::new(),
    }
}

/// The files that the numbers rest on, with their hashes.
fn inputs(args: &EvaluateArgs) -> Result<Vec<InputFile>, Failure> {
    let mut inputs = Vec::new();
    let mut add = |role: &str, path: &str, files: Vec<PathBuf>| -> Result<(), Failure> {
        if !files.is_empty() {
            inputs.push(InputFile::of(role, path, &files)?);
        }
        Ok(())
    };
    match (&args.source, &args.ground_truth) {
        (Some(source), _) => {
            let spec = SourceSpec::parse(source)?;
            let files = match IndexFiles::of(&spec) {
                Ok(index) => index.names.iter().map(|name| index.path(name)).collect(),
                Err(_) => label_files(&spec.path),
            };
            add("labels", &dataset_name(args), files)?;
        }
        (None, Some(path)) => add("labels", &path_text(path), files_of(path))?,
        (None, None) => {}
    }
    add(
        "clean detections",
        &path_text(&args.clean),
        files_of(&args.clean),
    )?;
    if let Some(path) = &args.cracked {
        add("cracked detections", &path_text(path), files_of(path))?;
    }
    if let Some(path) = &args.clusters {
        add("clusters of images", &path_text(path), files_of(path))?;
    }
    if let Some(set) = &args.cracked_set {
        let run = set.join("starbreak").join("run.json");
        add(
            "what the cracked set is made from",
            &path_text(&run),
            vec![run.clone()],
        )?;
    }
    Ok(inputs)
}

/// A file, or the text files of a folder of results.
pub(super) fn files_of(path: &Path) -> Vec<PathBuf> {
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

/// The label files of KITTI, where they are in their usual places.
pub(super) fn label_files(root: &Path) -> Vec<PathBuf> {
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

/// The command line as a shell takes it.
pub(super) fn command() -> String {
    let word = |word: std::ffi::OsString| {
        let word = word.to_string_lossy().into_owned();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
        match !word.is_empty() && word.chars().all(is_plain) {
            true => word,
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    };
    let words: Vec<String> = std::env::args_os().skip(1).map(word).collect();
    format!("starbreak {}", words.join(" "))
}
