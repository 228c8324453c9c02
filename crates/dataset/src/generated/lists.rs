//! The lists of a set, and the manifest that says it is whole.

use std::io::{BufRead as _, BufReader};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{CarriedFile, GeneratedSet, ItemRecord, SetLayout, read_json};
use crate::error::{DatasetError, one_line};
use crate::ordinary_file::open_file;
use crate::provenance::blake3_file;

/// What a finished run says of its set: `manifest.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`SET_SCHEMA`](super::SET_SCHEMA).
    pub schema: String,
    /// Images made, samples counted one by one.
    pub n_items: u64,
    /// Images that could not be made; `failures.jsonl` lists them.
    pub n_failed: u64,
    /// Records of the source that were left out; `skipped.jsonl` lists them.
    pub n_skipped: u64,
    /// Files that were carried over.
    pub n_files: u64,
    /// BLAKE3 of `run.json`.
    pub run_blake3: String,
    /// BLAKE3 of `items.jsonl`.
    pub items_blake3: String,
    /// BLAKE3 of `files.jsonl`.
    pub files_blake3: String,
    /// BLAKE3 of `failures.jsonl`, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failures_blake3: Option<String>,
    /// BLAKE3 of `skipped.jsonl`, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skipped_blake3: Option<String>,
}

impl GeneratedSet {
    /// Writes the lists and the manifest of `n_taken` samples, of which some failed.
    ///
    /// # Errors
    /// [`DatasetError::Write`], what the items say, and [`DatasetError::LostItems`] where they and the
    /// failures are not as many as were taken.
    pub fn finish(
        &self,
        items: &mut dyn Iterator<Item = Result<ItemRecord, DatasetError>>,
        files: &[CarriedFile],
        n_taken: u64,
        [n_failed, n_skipped]: [u64; 2],
    ) -> Result<Manifest, DatasetError> {
        let mut n_items = 0;
        let items = self.put_list("items.jsonl", &mut |line| {
            items.next().transpose()?.map_or(Ok(false), |item| {
                n_items += 1;
                push_line(line, &item);
                Ok(true)
            })
        })?;
        if n_items + n_failed != n_taken {
            return Err(DatasetError::LostItems {
                path: self.layout.root().to_owned(),
                n_items,
                n_failed,
                n_taken,
            });
        }
        let mut rest = files.iter();
        let files_list = self.put_list("files.jsonl", &mut |line| {
            Ok(rest.next().map(|file| push_line(line, file)).is_some())
        })?;
        let manifest = Manifest {
            schema: super::SET_SCHEMA.to_owned(),
            n_items,
            n_failed,
            n_skipped,
            n_files: files.len() as u64,
            run_blake3: blake3_file(&self.layout.state("run.json"))?,
            items_blake3: items.blake3,
            files_blake3: files_list.blake3,
            failures_blake3: self.hash_if_there("failures.jsonl")?,
            skipped_blake3: self.hash_if_there("skipped.jsonl")?,
        };
        self.put_state("manifest.json", Some(&manifest.to_text()))?;
        // The list has its lines now.
        self.put_state(super::MADE_LOG, None)?;
        Ok(manifest)
    }

    fn hash_if_there(&self, name: &str) -> Result<Option<String>, DatasetError> {
        let path = self.layout.state(name);
        let is_there = super::is_there(&path)?;
        is_there.then(|| blake3_file(&path)).transpose()
    }

    /// Writes a list of the state folder, line by line, until there is no next.
    fn put_list(
        &self,
        name: &str,
        next: &mut dyn FnMut(&mut String) -> Result<bool, DatasetError>,
    ) -> Result<CarriedFile, DatasetError> {
        let path = self.layout.state(name);
        let name = format!("{}/{name}", super::STATE_FOLDER);
        self.put_with(&name, &mut |out| {
            let mut line = String::new();
            while next(&mut line)? {
                out.write_all(line.as_bytes())
                    .map_err(|source| DatasetError::Write {
                        path: path.clone(),
                        source,
                    })?;
                line.clear();
            }
            Ok(())
        })
    }
}

impl Manifest {
    /// What `manifest.json` holds.
    pub(super) fn to_text(&self) -> String {
        // Numbers and texts always have a JSON form.
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        format!("{text}\n")
    }
}

fn push_line(line: &mut String, record: &impl Serialize) {
    // Records of texts and numbers always have a JSON form.
    line.push_str(&serde_json::to_string(record).unwrap_or_default());
    line.push('\n');
}

/// The manifest of a set; none where it is not finished.
pub(super) fn read_manifest(layout: &SetLayout) -> Result<Option<Manifest>, DatasetError> {
    let path = layout.state("manifest.json");
    if !super::is_there(&path)? {
        return Ok(None);
    }
    serde_json::from_value(read_json(&path)?)
        .map(Some)
        .map_err(|error| DatasetError::Record {
            path,
            reason: one_line(&error),
        })
}

/// The lines of a list, one after the other.
pub(super) fn read_list<T: DeserializeOwned>(
    path: &Path,
) -> Result<impl Iterator<Item = Result<T, DatasetError>> + use<T>, DatasetError> {
    let path = path.to_owned();
    let lines = BufReader::new(open_file(&path)?).lines();
    Ok((1..).zip(lines).map(move |(k, line): (u64, _)| {
        let line = line.map_err(|source| DatasetError::Read {
            path: path.clone(),
            source,
        })?;
        serde_json::from_str(&line).map_err(|error| DatasetError::Record {
            path: path.clone(),
            reason: format!("line {k}: {}", one_line(&error)),
        })
    }))
}
