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
        let refuse = |what: String| Error::AnotherStudy {
            folder: folder.to_owned(),
            what,
        };
        let mut found = read_text(&folder.join(FILE), MAX_BYTES);
        if found.is_err() && holds_anything(folder) {
            // Another step of the same shard may have begun it just now.
            found = read_text(&folder.join(FILE), MAX_BYTES);
        }
        let text = match found {
            Ok(file) => file.text,
            Err(DatasetError::Read { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                let reports = ["report.html", "evaluation.json"];
                let is_there = |name: &&&str| file_len(&folder.join(name)).is_ok();
                return match reports.iter().find(is_there) {
                    Some(name) => Err(refuse(format!("its {name} is of no study"))),
                    None if holds_anything(folder) => Err(refuse(
                        "it is not empty, and no study was begun there".to_owned(),
                    )),
                    None => Ok(()),
                };
            }
            Err(error) => return Err(error.into()),
        };
        let earlier = Self::parse(&text).map_err(refuse)?;
        match self.difference(&earlier) {
            Some(what) => Err(refuse(what)),
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
        let found = Self::parse(&text).map_err(refuse)?;
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
            Some(what) => Err(refuse(format!("it is of another study: {what}"))),
            None => Ok(shard),
        }
    }

    fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|cause| {
            let cause = cause.to_string().replace('\n', " ");
            format!("its {FILE} is not that of a study: {cause}")
        })
    }

    /// What an earlier study has otherwise, or what it has and this one leaves out. More is no difference.
    fn difference(&self, earlier: &Self) -> Option<String> {
        if self.schema != earlier.schema {
            let (own, theirs) = (&self.schema, &earlier.schema);
            return Some(format!("its form is {theirs:?}, not {own:?}"));
        }
        if self.images != earlier.images {
            return Some(format!(
                "its {} images are not these {}",
                earlier.n_images, self.n_images
            ));
        }
        if self.labels != earlier.labels {
            return Some("the labels of its images are others".to_owned());
        }
        if self.protocol != earlier.protocol {
            return Some(format!(
                "its protocol is {}, not {}",
                earlier.protocol, self.protocol
            ));
        }
        if self.shard != earlier.shard {
            return Some(match earlier.shard {
                Some(shard) => format!("it is the shard {}/{}", shard.number, shard.of),
                None => "it is not a shard".to_owned(),
            });
        }
        if self.removes_images != earlier.removes_images {
            let is_with = if earlier.removes_images {
                "with"
            } else {
                "without"
            };
            return Some(format!("it was made {is_with} --no-store"));
        }
        for (name, theirs) in &earlier.detectors {
            let Some(own) = self.detectors.get(name) else {
                return Some(format!("it has the detector {name}, which is left out now"));
            };
            for (is_same, what) in [
                (own.model_sha256 == theirs.model_sha256, "model file"),
                (own.contract == theirs.contract, "contract"),
                (own.label_map == theirs.label_map, "label map"),
            ] {
                if !is_same {
                    return Some(format!("its detector {name} has another {what}"));
                }
            }
            if own.runtime != theirs.runtime {
                return Some(format!(
                    "its detector {name} was run by {}, not by {}; name the same with --runtime and --onnxruntime",
                    theirs.runtime, own.runtime
                ));
            }
        }
        for (name, theirs) in &earlier.conditions {
            match self.conditions.get(name) {
                None => {
                    return Some(format!(
                        "it has the condition {name}, which is left out now"
                    ));
                }
                Some(own) if own.photos != theirs.photos => {
                    return Some(format!("the photos of its condition {name} are others"));
                }
                Some(own) if own != theirs => {
                    return Some(format!("its condition {name} has another recipe"));
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
