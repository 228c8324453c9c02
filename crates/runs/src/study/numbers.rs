//! From what was found to the numbers of a study.

use std::collections::BTreeSet;

use starbreak_eval::evaluation::{
    CleanResults, Condition as ReportedCondition, DamageFacts, EvaluateInput, EvaluateSettings,
    Evaluation, ImageFolders, OverConditions, OverSeeds, Provenance, RobustnessRow, Study, Warning,
    clean_results,
};
use starbreak_eval::{GroundTruth, RegionMasks, SaidDetections, evaluate};

use super::{Condition, StudyDetector, StudyPlan, StudyRuns};
use crate::Error;

impl StudyPlan<'_> {
    /// The numbers of all detectors under all conditions: by the labels of the plan's images, which
    /// are `truth`. Images that some detector could not look at count nowhere.
    ///
    /// # Errors
    /// [`Error::Eval`], and as [`StudyPlan::detections`].
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
        let mut clean = Vec::new();
        let mut evaluations = Vec::new();
        let mut of_seeds = Vec::new();
        let mut of_detectors = Vec::new();
        for detector in self.detectors {
            let one = self.of_detector(&truth, &places, settings, detector)?;
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

    /// One detector under all conditions. What it found under each is read from its log in turn, and dropped.
    fn of_detector(
        &self,
        truth: &GroundTruth,
        places: &[Option<u32>],
        settings: &EvaluateSettings,
        detector: &StudyDetector,
    ) -> Result<OfDetector, Error> {
        let said = |condition| -> Result<SaidDetections, Error> {
            Ok(truth.said(&self.detections(detector, condition)?.keep(places)))
        };
        let name = &detector.name;
        let clean = said(None)?;
        let of_clean = evaluate(truth, &clean, &settings.compare)?;
        let of_clean = clean_results(name, truth, &clean, of_clean.results)?;
        let conditions: Vec<ReportedCondition> = self.conditions.iter().map(reported).collect();
        let mut means = OverConditions::new(&conditions);
        let mut evaluations = Vec::new();
        for (condition, reported) in self.conditions.iter().zip(&conditions) {
            let layout = self.set_layout(condition);
            let facts = DamageFacts::read(&layout.state("provenance"), &truth.labels)?;
            let root = truth.root.as_deref();
            let regions = layout.state("regions");
            evaluations.push(
                means.evaluate(&EvaluateInput {
                    detector: name,
                    condition: reported,
                    truth,
                    clean: &clean,
                    cracked: Some(&said(Some(condition))?),
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
                })?,
            );
        }
        Ok(OfDetector {
            clean: of_clean,
            over_seeds: means.over_seeds(),
            robustness: means.robustness(&evaluations)?,
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
