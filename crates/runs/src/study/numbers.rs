//! From what was found to the numbers of a study.

use std::collections::BTreeSet;

use rayon::prelude::*;
use starbreak_eval::evaluation::{
    CleanResults, Condition as ReportedCondition, CrackedSet, DamageFacts, EvaluateInput,
    EvaluateSettings, Evaluation, ImageFolders, OverSeeds, Provenance, RobustnessRow, SeedsInput,
    Study, Warning, clean_results, evaluate_with_coverages, over_seeds, robustness,
};
use starbreak_eval::{Coverages, GroundTruth, RegionMasks, SaidDetections, evaluate};

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
        let n_detectors = self.detectors.len();
        let mut clean = Vec::new();
        let mut evaluations = Vec::new();
        let mut of_seeds = Vec::new();
        let mut of_detectors = Vec::new();
        for detector in 0..n_detectors {
            let one = self.of_detector(&truth, &places, runs, settings, detector)?;
            clean.push(one.clean);
            evaluations.extend(one.evaluations);
            of_seeds.extend(one.over_seeds);
            of_detectors.push(one.robustness);
        }
        let mut warnings = Vec::new();
        if !unseen.is_empty() {
            warnings.push(Warning::ImagesNotSeen {
                n: unseen.len().into(),
                n_images: self.images.len().into(),
            });
        }
        let mut study = Study {
            schema: Study::SCHEMA.to_owned(),
            title: title.to_owned(),
            dataset: dataset.to_owned(),
            provenance,
            warnings,
            clean,
            evaluations,
            over_seeds: of_seeds,
            robustness: of_detectors.into_iter().flatten().collect(),
            divergence: None,
        };
        study.correct_for_many_tests();
        study.warn_of_few_replicates(settings.n_replicates);
        Ok(study)
    }

    /// One detector under all conditions.
    fn of_detector(
        &self,
        truth: &GroundTruth,
        places: &[Option<u32>],
        runs: &StudyRuns,
        settings: &EvaluateSettings,
        detector: usize,
    ) -> Result<OfDetector, Error> {
        let missing = || Error::StudyCell {
            detector,
            condition: 0,
        };
        let name = &self.detectors.get(detector).ok_or_else(missing)?.name;
        let found = runs.detectors.get(detector).ok_or_else(missing)?;
        let clean = truth.said(&found.clean.keep(places));
        let conditions: Vec<ReportedCondition> = self.conditions.iter().map(reported).collect();
        let cracked: Vec<SaidDetections> = found
            .cracked
            .iter()
            .map(|cracked| truth.said(&cracked.keep(places)))
            .collect();
        // Each has threads enough for itself; side by side their order is kept.
        let cells: Result<Vec<(Evaluation, Option<Coverages>)>, Error> = (0..conditions.len())
            .into_par_iter()
            .map(|place| {
                let missing = || Error::StudyCell {
                    detector,
                    condition: place,
                };
                let layout = runs.sets.get(place).ok_or_else(missing)?;
                let facts = DamageFacts::read(&layout.state("provenance"), &truth.labels)?;
                let root = truth.root.as_deref();
                let regions = layout.state("regions");
                Ok(evaluate_with_coverages(&EvaluateInput {
                    detector: name,
                    condition: conditions.get(place).ok_or_else(missing)?,
                    truth,
                    clean: &clean,
                    cracked: Some(cracked.get(place).ok_or_else(missing)?),
                    regions: Some(RegionMasks {
                        folder: &regions,
                        root,
                    }),
                    facts: Some(&facts),
                    images: root
                        .filter(|_| self.keeps_images)
                        .map(|clean| ImageFolders {
                            clean,
                            cracked: layout.root(),
                        }),
                    settings,
                })?)
            })
            .collect();
        let (evaluations, coverages): (Vec<Evaluation>, Vec<Option<Coverages>>) =
            cells?.into_iter().unzip();
        let sets: Vec<CrackedSet<'_>> = conditions
            .iter()
            .zip(&cracked)
            .zip(&coverages)
            .map(|((condition, said), coverages)| CrackedSet {
                condition,
                said,
                coverages: coverages.as_ref(),
            })
            .collect();
        let all = SeedsInput {
            detector: name,
            truth,
            clean: &clean,
            cracked: &sets,
            settings,
        };
        let of_clean = evaluate(truth, &clean, &settings.compare)?;
        Ok(OfDetector {
            clean: clean_results(name, truth, &clean, of_clean.results)?,
            over_seeds: over_seeds(&all)?,
            robustness: robustness(&evaluations, &all)?,
            evaluations,
        })
    }
}

/// What is known of one detector.
struct OfDetector {
    clean: CleanResults,
    evaluations: Vec<Evaluation>,
    over_seeds: Vec<OverSeeds>,
    robustness: Vec<RobustnessRow>,
}

pub(super) fn reported(condition: &Condition) -> ReportedCondition {
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
