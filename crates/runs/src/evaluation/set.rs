//! Whether what is read of a generated set is what the run that made it has listed.

use std::path::Path;

use rayon::prelude::*;
use serde_json::Value;
use starbreak::Recipe;
use starbreak_dataset::{
    DatasetError, Finding, ItemRecord, SetChecker, SourceSpec, set_around, set_identity,
};

use super::{EvaluateRequest, refused};
use crate::Error;

/// Refuses a set that is not finished, or of which a file that is read is not as its lists say.
pub(super) fn check(request: &EvaluateRequest) -> Result<(), Error> {
    if let Some(set) = request.regions.as_deref().and_then(set_around) {
        check_set(&set, Part::Regions)?;
    }
    match &request.cracked_set {
        // Only a report has its records and its pictures.
        Some(set) if request.joins => check_set(set, Part::All),
        Some(set) => check_set(set, Part::Regions),
        None => Ok(()),
    }
}

/// Refuses clean images beside damaged ones whose labels moved.
pub(super) fn refuse_moved_labels(request: &EvaluateRequest) -> Result<(), Error> {
    if request.cracked.is_none() {
        return Ok(());
    }
    let source = (request.source.as_deref()).and_then(|spec| SourceSpec::parse(spec).ok());
    let labels = [source.map(|spec| spec.path), request.ground_truth.clone()];
    let images = [request.cracked_set.clone(), request.regions.clone()];
    for path in images.into_iter().chain(labels).flatten() {
        let set = set_around(&path);
        let Some(Ok(identity)) = set.as_deref().map(set_identity) else {
            // It is no set, or refused where it is read.
            continue;
        };
        let recipe = identity.get("recipe").and_then(Value::as_str);
        let Some(Ok(recipe)) = recipe.map(|text| Recipe::parse("run.json", text)) else {
            continue;
        };
        if recipe.settings()?.moves_labels() {
            return Err(refused(format!(
                "the lens of the set {:?} moves what images show, and their labels with it, so that clean and damaged \
                 images have no labels in common; evaluate each by its own: once the clean dataset with the clean \
                 detections, once the set with its own in their place (--clean)",
                set.unwrap_or_default()
            )));
        }
    }
    Ok(())
}

/// What of each image is read.
#[derive(Clone, Copy)]
enum Part {
    All,
    Regions,
}

impl Part {
    fn findings(self, checker: &SetChecker, item: &ItemRecord) -> Vec<Finding> {
        let region = || {
            let files = checker.layout().files_of(&item.name, item.sample);
            let blake3 = item.region_blake3.as_deref()?;
            checker.check_file(&files.region, blake3)
        };
        match self {
            Self::All => checker.check_item(item),
            Self::Regions => region().into_iter().collect(),
        }
    }
}

fn check_set(root: &Path, part: Part) -> Result<(), Error> {
    let checker = SetChecker::open(root)?;
    let mut findings = checker.check_lists()?;
    if findings.is_empty() {
        let of_items = checker.items()?.par_bridge().map(|item| {
            let item = item?;
            Ok(part.findings(&checker, &item))
        });
        let of_items: Result<Vec<Vec<Finding>>, DatasetError> = of_items.collect();
        findings = of_items?.concat();
        findings.sort();
    }
    match findings.first() {
        None => Ok(()),
        Some(first) => Err(refused(format!(
            "{} files of the set {root:?} are not as its lists say, the first: {first}; `starbreak verify {}` says how \
             to mend it",
            findings.len(),
            root.display()
        ))),
    }
}
