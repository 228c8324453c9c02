//! What a study writes once all is found.

use std::path::{Path, PathBuf};

use serde_json::json;
use starbreak::FractureSettings;
use starbreak_dataset::{FileSet, OutputBatch, SourceSpec, file_len};
use starbreak_eval::GroundTruth;
use starbreak_eval::evaluation::{
    DivergenceResults, Estimate, EvaluateSettings, GroupKind, InputFile, PairedMetric, Provenance,
    ScopeKind, Study, Versions, WarningKind,
};
use starbreak_eval::report::report_files;
use starbreak_runs::evaluation::{REPORT_FILES, files_of, label_files, short_name};
use starbreak_runs::study::{CLEAN_STEP, Condition, StudyDetector, StudyPlan, StudyRuns};

use crate::args::Global;
use crate::args::study::StudyArgs;
use crate::failure::Failure;
use crate::screen::{Screen, path_text};

/// All that the report is made from.
pub(super) struct StudyReport<'a> {
    pub(super) args: &'a StudyArgs,
    pub(super) plan: &'a StudyPlan<'a>,
    pub(super) runs: &'a StudyRuns,
    pub(super) truth: &'a GroundTruth,
    pub(super) divergence: Option<DivergenceResults>,
    pub(super) global: &'a Global,
}

impl StudyReport<'_> {
    /// Writes report.html, evaluation.json, numbers.csv, table.tex, failures.jsonl, and the
    /// detections of every arm as results of MS-COCO: all of them or none.
    pub(super) fn write(&self, screen: &Screen) -> Result<(), Failure> {
        let study = self.numbers()?;
        let out = &self.args.output;
        let mut batch = batch_of(self.global, self.args)?;
        let labels = &self.truth.labels;
        for (file, detector, step) in detection_files(self.args, self.plan) {
            let found = self.plan.detections(detector, step)?;
            batch.stage(&file, found.to_coco(labels).as_bytes())?;
        }
        // Empty where all is well: one of an earlier run may be there.
        let lines = self.runs.unseen.iter().map(|unseen| {
            let line = json!({ "name": unseen.name, "reason": unseen.reason });
            format!("{line}\n")
        });
        let text: String = lines.collect();
        batch.stage(&out.join(UNSEEN), text.as_bytes())?;
        for (name, text) in report_files(&study)? {
            batch.stage(&out.join(name), text.as_bytes())?;
        }
        batch.commit()?;
        say_numbers(&study, screen);
        screen.say(&format!("wrote {}", path_text(out.join("report.html"))));
        screen.result(|| json!(study))
    }

    fn numbers(&self) -> Result<Study, Failure> {
        let args = self.args;
        let settings = EvaluateSettings {
            score_threshold: args.score_threshold,
            n_replicates: args.replicates,
            seed: self.global.seed,
            n_worst: args.worst.unwrap_or_else(|| self.usual_n_worst()),
            ..EvaluateSettings::of(self.truth.protocol)
        };
        let dataset = short_name(&args.source.to_string_lossy());
        let names: Vec<&str> = self
            .plan
            .detectors
            .iter()
            .map(|detector| detector.name.as_str())
            .collect();
        let breaks = |condition: &Condition| {
            let settings = condition.recipe.settings();
            settings.is_ok_and(|it| !matches!(it.fracture, FractureSettings::None(_)))
        };
        let what = match self.plan.conditions.iter().any(breaks) {
            true => "behind broken glass",
            false => "in a camera with faults",
        };
        let title = format!("{} {what}", names.join(", "));
        let provenance = Provenance {
            inputs: self.inputs()?,
            versions: vec![Versions {
                name: "starbreak".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            }],
            settings: settings.described(self.truth, true),
            command: Some(self.global.command.clone()),
            recipe: match self.plan.conditions {
                [alone] => Some(alone.recipe.to_toml()),
                _ => None,
            },
        };
        let mut study = self.plan.numbers(
            self.truth, self.runs, &settings, &title, &dataset, provenance,
        )?;
        study.divergence.clone_from(&self.divergence);
        Ok(study)
    }

    /// A page with many conditions shows few pictures of each.
    fn usual_n_worst(&self) -> u32 {
        let n_cells = self.plan.detectors.len() * self.plan.conditions.len();
        let n_cells = u32::try_from(n_cells).unwrap_or(u32::MAX).max(1);
        (24 / n_cells).clamp(1, 6)
    }

    fn inputs(&self) -> Result<Vec<InputFile>, Failure> {
        let mut inputs = Vec::new();
        let spec = SourceSpec::parse(&self.args.source)?;
        let labels = label_files(&spec);
        if !labels.is_empty() {
            let source = self.args.source.to_string_lossy();
            inputs.push(InputFile::of("labels", &source, &labels)?);
        }
        if let Some(path) = &self.args.clusters {
            let files = files_of(path);
            inputs.push(InputFile::of(
                "clusters of images",
                &path_text(path),
                &files,
            )?);
        }
        for (path, detector) in self.args.model.iter().zip(self.plan.detectors) {
            let contract = detector.detector.contract();
            let role = format!(
                "model {}, contract {}: score threshold {}; run by {}",
                detector.name,
                contract.name,
                contract.score_threshold,
                detector.detector.runtime()
            );
            let file = std::slice::from_ref(path);
            inputs.push(InputFile::of(&role, &path_text(path), file)?);
        }
        let contracts = self.args.contract.iter().map(Path::new);
        let contracts = contracts.filter(|path| path.extension().is_some_and(|end| end == "toml"));
        let files = contracts.map(|path| ("contract", path));
        let map = self
            .args
            .label_map
            .iter()
            .map(|path| ("label map", path.as_path()));
        for (role, path) in files.chain(map) {
            let file = [path.to_owned()];
            inputs.push(InputFile::of(role, &path_text(path), &file)?);
        }
        for condition in self.plan.conditions {
            let run = self.plan.set_folder(condition).join("starbreak/run.json");
            inputs.push(InputFile::of(
                "what the damaged set is made from",
                &path_text(&run),
                std::slice::from_ref(&run),
            )?);
        }
        Ok(inputs)
    }
}

/// The images without a result.
const UNSEEN: &str = "unseen.jsonl";

/// Refuses what cannot be written at the end, before the work.
pub(super) fn refuse_taken(
    global: &Global,
    args: &StudyArgs,
    plan: &StudyPlan<'_>,
) -> Result<(), Failure> {
    if file_len(&args.output.join("study.json")).is_err() {
        // A folder that holds anything and is of no study is refused for that.
        return Ok(());
    }
    let batch = batch_of(global, args)?;
    let names = REPORT_FILES.iter().chain([&UNSEEN]);
    let files = names.map(|name| args.output.join(name));
    let mut files = files.chain(detection_files(args, plan).map(|(file, ..)| file));
    Ok(files.try_for_each(|file| batch.may_write(&file))?)
}

/// The batch of what a study writes once all is found, which replaces what an earlier run has written, and nothing that is
/// read.
fn batch_of(global: &Global, args: &StudyArgs) -> Result<OutputBatch, Failure> {
    let mut read = label_files(&SourceSpec::parse(&args.source)?);
    read.extend(args.model.iter().chain(&args.label_map).cloned());
    read.extend(args.recipes.iter().cloned());
    read.extend(args.contract.iter().map(PathBuf::from));
    read.extend(args.clusters.iter().flat_map(|path| files_of(path)));
    let batch = global.batch().never_over(FileSet::of(&read));
    Ok(batch.with_list(&args.output.join("written.json"), "study"))
}

/// What is found by each detector, clean and under each condition, as results of MS-COCO: the files.
fn detection_files<'a>(
    args: &'a StudyArgs,
    plan: &'a StudyPlan<'a>,
) -> impl Iterator<Item = (PathBuf, &'a StudyDetector, Option<&'a Condition>)> {
    plan.detectors.iter().flat_map(move |detector| {
        let folder = args.output.join("detections").join(&detector.name);
        let steps = std::iter::once(None).chain(plan.conditions.iter().map(Some));
        steps.map(move |step| {
            let name = step.map_or(CLEAN_STEP, |condition| &condition.name);
            (folder.join(format!("{name}.json")), detector, step)
        })
    })
}

/// A line for each detector and condition.
fn say_numbers(study: &Study, screen: &Screen) {
    let percent = |estimate: &Estimate| match estimate.value {
        Some(value) => format!("{:.1} %", value * 100.0),
        None => "not given".to_owned(),
    };
    let of_all = study.warnings.iter();
    for warning in of_all.filter(|it| it.kind() == WarningKind::SmallSample) {
        screen.note(&format!("warning: {warning}"));
    }
    for one in &study.evaluations {
        for warning in &one.warnings {
            if warning.kind() == WarningKind::SmallSample {
                screen.note(&format!(
                    "warning: {}, {}: {warning}",
                    one.detector, one.condition.name
                ));
            }
        }
        let ap50 = one.paired.iter().find(|row| {
            row.scope.kind == ScopeKind::WholeImage
                && row.metric == PairedMetric::Ap50
                && row.group.kind == GroupKind::All
        });
        let rate = |kind: ScopeKind| {
            let rows = one.failures.iter().flat_map(|failures| &failures.rates);
            let mut rows =
                rows.filter(|row| row.scope.kind == kind && row.group.kind == GroupKind::All);
            rows.next()
                .map_or_else(|| "not given".to_owned(), |row| percent(&row.failure_rate))
        };
        let ap50 = ap50.map_or_else(String::new, |row| {
            let points = |value: f64| format!("{:.1}", value * 100.0);
            let change = match (row.delta.value, row.delta.interval(), row.p_holm.or(row.p)) {
                (Some(delta), Some([low, high]), Some(p)) => format!(
                    " ({} points [{}, {}], p {p:.3})",
                    points(delta),
                    points(low),
                    points(high)
                ),
                _ => String::new(),
            };
            match row.clean.value.or(row.cracked.value) {
                None => "no AP50 of whole images, ".to_owned(),
                Some(_) => format!(
                    "AP50 of whole images {} to {}{change}, ",
                    percent(&row.clean),
                    percent(&row.cracked)
                ),
            }
        });
        screen.say(&format!(
            "{}, {}: {ap50}lost in the region {}, outside {}",
            one.detector,
            one.condition.name,
            rate(ScopeKind::InRegion),
            rate(ScopeKind::OutOfRegion)
        ));
    }
}
