//! What a study is: by this a folder tells its own study from another one.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use starbreak_dataset::video::holds_anything;
use starbreak_dataset::{DatasetError, OutputBatch, file_len, read_text, sha256_hex};
use starbreak_eval::GroundTruth;

use super::{StudyDetector, StudyPlan};
use crate::Error;
use crate::generate::Shard;

/// The file in the folder of a study that says which one it is.
const FILE: &str = "study.json";

/// Longest such file that is read, bytes.
const MAX_BYTES: u64 = 256 << 20;

/// All that numbers of the same name depend on; how they are evaluated from there on may change.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Identity {
    schema: String,
    /// SHA-256 of the names of the images, hexadecimal.
    images: String,
    n_images: u64,
    /// SHA-256 of the labels, hexadecimal.
    labels: String,
    /// By whose rules.
    protocol: String,
    /// By name.
    detectors: BTreeMap<String, DetectorIdentity>,
    /// By name.
    conditions: BTreeMap<String, ConditionIdentity>,
    /// Whether the images of its sets are removed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    removes_images: bool,
    /// Which of its shards the folder holds, where it is not the whole study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) shard: Option<Shard>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct DetectorIdentity {
    model_sha256: String,
    /// What the contract says, but for its name.
    contract: Value,
    label_map: Value,
    /// What runs it; studies from before there was a choice do not say it.
    #[serde(default = "rten")]
    runtime: String,
}

fn rten() -> String {
    "rten".to_owned()
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct ConditionIdentity {
    recipe: String,
    seed: u64,
    /// What the photographs are, of a condition that has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    photos: Option<Value>,
}

/// In what an earlier study is another one.
struct Difference {
    what: String,
    /// What makes the study that one.
    way_out: &'static str,
}

impl DetectorIdentity {
    pub(super) fn of(detector: &StudyDetector) -> Self {
        Self {
            model_sha256: detector.sha256.clone(),
            contract: json!(detector.detector.contract()),
            label_map: json!(detector.map),
            runtime: detector.detector.runtime().to_owned(),
        }
    }
}

impl Identity {
    const SCHEMA: &str = "starbreak.study/2";

    pub(super) fn of(plan: &StudyPlan<'_>, truth: &GroundTruth) -> Result<Self, Error> {
        let detectors = plan.detectors.iter();
        let detectors = detectors.map(|one| (one.name.clone(), DetectorIdentity::of(one)));
        let mut conditions = BTreeMap::new();
        for condition in plan.conditions {
            let photos = match condition.is_photographed {
                true => Some(plan.patterns(condition)?.identity()),
                false => None,
            };
            let one = ConditionIdentity {
                recipe: condition.recipe.to_toml(),
                seed: condition.seed.0,
                photos,
            };
            conditions.insert(condition.name.clone(), one);
        }
        let labels =
            serde_json::to_vec(&(&truth.labels, &truth.kitti)).map_err(cannot_be_written)?;
        Ok(Self {
            schema: Self::SCHEMA.to_owned(),
            images: plan.survey.names_sha256.clone(),
            n_images: plan.survey.n_selected,
            labels: sha256_hex(&labels),
            protocol: truth.protocol.name().to_owned(),
            detectors: detectors.collect(),
            conditions,
            removes_images: !plan.keeps_images,
            shard: None,
        })
    }

    /// Refuses a folder with another study, or with a report of no study.
    pub(super) fn check(&self, folder: &Path) -> Result<(), Error> {
        let refuse = |what: String| Error::NotAStudy {
            folder: folder.to_owned(),
            what,
        };
        // Looked at before the file, which is the first in a folder: another step of the same shard may begin it just now.
        let holds_something = holds_anything(folder);
        let text = match read_text(&folder.join(FILE), MAX_BYTES) {
            Ok(file) => file.text,
            Err(DatasetError::Read { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                let reports = ["report.html", "evaluation.json"];
                let is_there = |name: &&&str| file_len(&folder.join(name)).is_ok();
                return match reports.iter().find(is_there) {
                    Some(name) => Err(refuse(format!(
                        "has a {name}, and no {FILE} that says of which study"
                    ))),
                    None if holds_something => Err(refuse(format!(
                        "is not empty, and has no {FILE} that says which study it holds"
                    ))),
                    None => Ok(()),
                };
            }
            Err(DatasetError::Read { source, .. })
                if source.kind() == std::io::ErrorKind::NotADirectory =>
            {
                return Err(refuse("is a file, or lies in one".to_owned()));
            }
            Err(error) => return Err(error.into()),
        };
        let earlier = Self::parse(&text).map_err(refuse)?;
        match self.difference(&earlier) {
            Some(Difference { what, way_out }) => Err(Error::AnotherStudy {
                folder: folder.to_owned(),
                what,
                way_out,
            }),
            None => Ok(()),
        }
    }

    /// The shard of this study that a folder holds.
    pub(super) fn shard_in(&self, folder: &Path) -> Result<Shard, Error> {
        let refuse = |what: String| Error::StudyShard {
            folder: folder.to_owned(),
            what,
        };
        let text = read_text(&folder.join(FILE), MAX_BYTES)?.text;
        let found = Self::parse(&text).map_err(|what| refuse(format!("it {what}")))?;
        let Some(shard) = found.shard else {
            return Err(refuse(
                "it is a whole study; give folders made with --shard".to_owned(),
            ));
        };
        let as_this = Self {
            shard: Some(shard),
            ..self.clone()
        };
        match as_this.difference(&found) {
            Some(Difference { what, .. }) => Err(refuse(format!("it is of another study: {what}"))),
            None => Ok(shard),
        }
    }

    fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|cause| {
            let cause = cause.to_string().replace('\n', " ");
            format!(
                "has a {FILE} that cannot be read ({cause}), so that nobody knows which study it is"
            )
        })
    }

    /// What an earlier study has otherwise, or what it has and this one leaves out. More is no difference.
    fn difference(&self, earlier: &Self) -> Option<Difference> {
        let differs = |what: String, way_out| Some(Difference { what, way_out });
        if self.schema != earlier.schema {
            let (own, theirs) = (&self.schema, &earlier.schema);
            return differs(
                format!("its form is {theirs:?}, not {own:?}"),
                "go on with the version that began it",
            );
        }
        if self.images != earlier.images {
            let (theirs, own) = (earlier.n_images, self.n_images);
            return differs(
                format!("its {theirs} images are not these {own}"),
                "give the dataset, and --limit, that it was made with",
            );
        }
        if self.labels != earlier.labels {
            return differs(
                "the labels of its images are others".to_owned(),
                "put back the labels that they were",
            );
        }
        if self.protocol != earlier.protocol {
            return differs(
                format!(
                    "its protocol is {}, not {}",
                    earlier.protocol, self.protocol
                ),
                "give that one with --protocol",
            );
        }
        match (earlier.shard, self.shard) {
            (theirs, own) if theirs == own => {}
            (Some(shard), _) => {
                return differs(
                    format!("it is the shard {}/{}", shard.number, shard.of),
                    "give that one with --shard",
                );
            }
            (None, _) => return differs("it is not a shard".to_owned(), "leave --shard out"),
        }
        match (earlier.removes_images, self.removes_images) {
            (true, false) => differs("it was made with --no-store".to_owned(), "give --no-store"),
            (false, true) => differs(
                "it was made without --no-store".to_owned(),
                "leave --no-store out",
            ),
            _ => self
                .difference_of_detectors(earlier)
                .or_else(|| self.difference_of_conditions(earlier)),
        }
    }

    fn difference_of_detectors(&self, earlier: &Self) -> Option<Difference> {
        let differs = |what: String, way_out| Some(Difference { what, way_out });
        for (name, theirs) in &earlier.detectors {
            let Some(own) = self.detectors.get(name) else {
                return differs(
                    format!("it has the detector {name}, which is left out now"),
                    "name all detectors that it has beside those to be added",
                );
            };
            for (is_same, what, way_out) in [
                (
                    own.model_sha256 == theirs.model_sha256,
                    "model file",
                    "give that file (of two files of one name the second gets a number, so their order counts)",
                ),
                (
                    own.contract == theirs.contract,
                    "contract",
                    "give that one with --contract",
                ),
                (
                    own.label_map == theirs.label_map,
                    "label map",
                    "give that one with --label-map",
                ),
            ] {
                if !is_same {
                    return differs(format!("its detector {name} has another {what}"), way_out);
                }
            }
            if own.runtime != theirs.runtime {
                return differs(
                    format!(
                        "its detector {name} was run by {}, not by {}",
                        theirs.runtime, own.runtime
                    ),
                    "name the same with --runtime and --onnxruntime",
                );
            }
        }
        None
    }

    fn difference_of_conditions(&self, earlier: &Self) -> Option<Difference> {
        let differs = |what: String, way_out| Some(Difference { what, way_out });
        for (name, theirs) in &earlier.conditions {
            match self.conditions.get(name) {
                None => {
                    return differs(
                        format!("it has the condition {name}, which is left out now"),
                        "name all conditions that it has beside those to be added",
                    );
                }
                Some(own) if own.photos != theirs.photos => {
                    return differs(
                        format!("the photos of its condition {name} are others"),
                        "put back the photos that they were",
                    );
                }
                Some(own) if own != theirs => {
                    return differs(
                        format!("its condition {name} has another recipe or seed"),
                        "give what it was made with",
                    );
                }
                Some(_) => {}
            }
        }
        None
    }

    /// Makes the folder that of this study.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(self).map_err(cannot_be_written)?;
        let mut batch = OutputBatch::new();
        batch.stage(&folder.join(FILE), (text + "\n").as_bytes())?;
        batch.commit()?;
        Ok(())
    }
}

fn cannot_be_written(cause: serde_json::Error) -> Error {
    Error::StudyLine {
        image: FILE.to_owned(),
        reason: cause.to_string(),
    }
}
