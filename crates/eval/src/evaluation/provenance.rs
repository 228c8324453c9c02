use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use starbreak_dataset::{file_len, sha256_file, sha256_hex};

use crate::EvalError;

/// All that the numbers depend on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Files that were read.
    pub inputs: Vec<InputFile>,
    /// Programs and files of settings.
    pub versions: Vec<Versions>,
    /// How it was evaluated.
    pub settings: Settings,
    /// The command line that does it again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// The recipe that broke the glass, as text, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recipe: Option<String>,
}

/// A file or folder that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// What it is to the evaluation: `labels`, `clean detections`, `model`, …
    pub role: String,
    /// Where it was.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal; of a folder that of the list of its files' hashes.
    pub sha256: String,
    /// Its bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_bytes: Option<u64>,
}

impl InputFile {
    /// What was read of `path`: of a single file its hash, of several that of the list of their hashes
    /// and names, in the order given.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] if one cannot be read.
    pub fn of(role: &str, path: &str, files: &[PathBuf]) -> Result<Self, EvalError> {
        let mut n_bytes = 0;
        let mut hashes = Vec::with_capacity(files.len());
        for file in files {
            n_bytes += file_len(file)?;
            hashes.push(sha256_file(file)?);
        }
        let sha256 = match hashes.as_slice() {
            [alone] => alone.clone(),
            _ => {
                let name =
                    |file: &PathBuf| file.file_name().map(|n| n.to_string_lossy().into_owned());
                let lines: Vec<String> = hashes
                    .iter()
                    .zip(files)
                    .map(|(hash, file)| format!("{hash}  {}\n", name(file).unwrap_or_default()))
                    .collect();
                sha256_hex(lines.concat().as_bytes())
            }
        };
        Ok(Self {
            role: role.to_owned(),
            path: path.to_owned(),
            sha256,
            n_bytes: Some(n_bytes),
        })
    }
}

/// A program with its version.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// How it was evaluated.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Settings {
    /// `coco`, `kitti` or `bdd`.
    pub protocol: String,
    /// Definition of the region and of what counts in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region_definition: Option<String>,
    /// Share of a box that the region must cover, the one that counts first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<f64>,
    /// Detections below this score do not count as found, in rates of failure.
    pub score_threshold: f64,
    /// Detections that overlap less do not count as found, in rates of failure.
    pub iou_threshold: f64,
    /// Draws of the bootstrap.
    pub n_bootstrap: u32,
    /// Draws of the permutation test.
    pub n_permutations: u32,
    /// Seed of both.
    pub seed: u64,
    /// What is drawn as one: `image`, or `drive` for frames of clips.
    pub resampling_unit: String,
    /// Fewer objects than this, and a number is refused.
    pub min_objects: u64,
    /// Most detections per image that count, where the protocol has such a number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_detections: Option<u32>,
}
