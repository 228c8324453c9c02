//! From what was found to the numbers of a study.

use std::collections::BTreeSet;

use rayon::prelude::*;
use starbreak_eval::GroundTruth;
use starbreak_eval::RegionMasks;
use starbreak_eval::evaluation::{
    Condition as ReportedCondition, DamageFacts, EvaluateInput, EvaluateSettings, Evaluation,
    ImageFolders, Provenance, Study, Warning, WarningKind, evaluate, robustness,
};

use super::{Condition, StudyPlan, StudyRuns};
use crate::Error;

impl StudyPlan<'_> {
    /// The numbers of all detectors under all conditions: by the labels of the plan's images, which
    /// are `truth`. Images that some detector could not look at count nowhere.
    ///
    /// # Errors
    /// [`Error::Eval`].
    pub fn numbers(
        &self,
        truth: &GroundTruth,
        runs: &StudyRuns,
        settings: &EvaluateSettings,
        title: &str,
        dataset: &str,
        provenance: Provenance,
    ) -> Result<Study, Error> {
        let unseen: BTreeSet<&str> = runs.unseen.iter().map(|one| one.name.as_str()).collect();
        let (truth, places) = truth.keep(|image| !unseen.contains(image.name.as_str()));
        let cells: Vec<(usize, usize)> = (0..self.detectors.len())
            .flat_map(|detector| {
                (0..self.conditions.len()).map(move |condition| (detector, condition))
            })
            .collect();
        // Each has threads enough for itself; side by side their order is kept.
        let evaluations: Result<Vec<Evaluation>, Error> = cells
            .par_iter()
            .map(|(detector, condition)| {
                self.cell(&truth, &places, runs, settings, (*detector, *condition))
            })
            .collect();
        let evaluations = evaluations?;
        let mut warnings = Vec::new();
        if !unseen.is_empty() {
            warnings.push(Warning {
                kind: WarningKind::Missing,
                text: format!(
                    "{} of {} images could not be broken or looked at and count nowhere",
                    unseen.len(),
                    self.images.len()
                ),
            });
        }
        Ok(Study {
            schema: Study::SCHEMA.to_owned(),
            title: title.to_owned(),
            dataset: dataset.to_owned(),
            provenance,
            warnings,
            robustness: robustness(&evaluations, Some(settings.tau())),
            evaluations,
            divergence: None,
        })
    }

    fn cell(
        &self,
        truth: &GroundTruth,
        places: &[Option<u32>],
        runs: &StudyRuns,
        settings: &EvaluateSettings,
        (detector, condition): (usize, usize),
    ) -> Result<Evaluation, Error> {
        let missing = || Error::StudyCell {
            detector,
            condition,
        };
        let name = &self.detectors.get(detector).ok_or_else(missing)?.name;
        let found = runs.detectors.get(detector).ok_or_else(missing)?;
        let layout = runs.sets.get(condition).ok_or_else(missing)?;
        let cracked = found.cracked.get(condition).ok_or_else(missing)?;
        let condition = self.conditions.get(condition).ok_or_else(missing)?;
        let facts = DamageFacts::read(&layout.state("provenance"), &truth.labels)?;
        let root = truth.root.as_deref();
        let regions = layout.state("regions");
        Ok(evaluate(&EvaluateInput {
            detector: name,
            condition: &reported(condition),
            truth,
            clean: &truth.said(&found.clean.keep(places)),
            cracked: Some(&truth.said(&cracked.keep(places))),
            regions: Some(RegionMasks {
                folder: &regions,
                root,
            }),
            facts: Some(&facts),
            images: root.map(|clean| ImageFolders {
                clean,
                cracked: layout.root(),
            }),
            settings,
        })?)
    }
}

fn reported(condition: &Condition) -> ReportedCondition {
    let severity = condition
        .severity
        .map(|severity| format!(", severity {severity}"))
        .unwrap_or_default();
    ReportedCondition {
        name: format!("{}{severity}, seed {}", condition.family, condition.seed.0),
        family: Some(condition.family.clone()),
        severity: condition.severity,
        seed: Some(condition.seed.0),
    }
}
