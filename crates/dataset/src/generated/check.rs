//! Whether a set is whole, unmixed and as its lists say.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::Path;

use serde::de::IgnoredAny;
use serde_json::Value;

use super::known::MADE_LOG;
use super::lists::{Manifest, read_list, read_manifest};
use super::{
    CarriedFile, ItemRecord, MAX_RECORD_BYTES, SET_SCHEMA, STATE_FOLDER, SetLayout, is_there,
    name_head,
};
use crate::error::DatasetError;
use crate::provenance::{blake3_file, sha256_file};
use crate::text_file::read_text;

/// Something that is wrong with a set.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// The file, as a path from the root of the set.
    pub name: String,
    /// What is wrong with it.
    pub what: String,
    /// Whether it is a file that the set has not: to mend that, remove it. All else the run that made
    /// the set makes anew.
    pub is_foreign: bool,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {}", self.name, self.what)
    }
}

/// A finished set that is to be checked.
#[derive(Debug)]
pub struct SetChecker {
    layout: SetLayout,
    manifest: Manifest,
    identity: Value,
    /// Heads of the digests of all names that belong to the set: a few bytes each.
    names: BTreeSet<u64>,
}

impl SetChecker {
    /// Opens a set for checking.
    ///
    /// # Errors
    /// [`DatasetError::NotASet`] where there is none, or it is not finished.
    pub fn open(root: &Path) -> Result<Self, DatasetError> {
        let identity = super::set_identity(root)?;
        let n_samples = identity["samples"].as_u64().unwrap_or(1);
        let layout = SetLayout::new(root, u32::try_from(n_samples).unwrap_or(1));
        let Some(manifest) = read_manifest(&layout)? else {
            return Err(DatasetError::NotASet {
                path: root.to_owned(),
                reason: format!(
                    "it has no {STATE_FOLDER}/manifest.json, so it is not finished; run the same generate again"
                ),
            });
        };
        Ok(Self {
            layout,
            manifest,
            identity,
            names: BTreeSet::new(),
        })
    }

    /// What the set is made from.
    #[must_use]
    pub fn identity(&self) -> &Value {
        &self.identity
    }

    /// What the run said at its end.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Where its files lie.
    #[must_use]
    pub fn layout(&self) -> &SetLayout {
        &self.layout
    }

    /// Whether the manifest is the one of this many samples and other files.
    ///
    /// # Errors
    /// As for [`read_text`].
    pub fn check_manifest(
        &self,
        n_items: u64,
        n_files: u64,
    ) -> Result<Option<Finding>, DatasetError> {
        let n_lines = |name: &str| {
            let path = self.layout.state(name);
            let is_there = is_there(&path)?;
            let lines = is_there.then(|| read_list::<IgnoredAny>(&path));
            lines.map_or(Ok(0), |lines| lines.map(|lines| lines.count() as u64))
        };
        let manifest = Manifest {
            schema: SET_SCHEMA.to_owned(),
            n_items,
            n_failed: n_lines("failures.jsonl")?,
            n_skipped: n_lines("skipped.jsonl")?,
            n_files,
            ..self.manifest.clone()
        };
        let is_as_meant = read_text(&self.layout.state("manifest.json"), MAX_RECORD_BYTES)?.text
            == manifest.to_text();
        Ok((!is_as_meant).then(|| Finding {
            name: format!("{STATE_FOLDER}/manifest.json"),
            what: "does not say what the lists hold".to_owned(),
            is_foreign: false,
        }))
    }

    /// Whether the lists are those that the manifest means.
    ///
    /// # Errors
    /// [`DatasetError::Read`].
    pub fn check_lists(&self) -> Result<Vec<Finding>, DatasetError> {
        let mut findings = Vec::new();
        let recipe_sha256 = self.identity["recipe_sha256"].as_str().unwrap_or_default();
        let recipe_sha256 = recipe_sha256.to_owned();
        let manifest = &self.manifest;
        let lists: [(_, DigestOf, _); 6] = [
            ("run.json", blake3_file, Some(&manifest.run_blake3)),
            ("recipe.toml", sha256_file, Some(&recipe_sha256)),
            ("items.jsonl", blake3_file, Some(&manifest.items_blake3)),
            ("files.jsonl", blake3_file, Some(&manifest.files_blake3)),
            (
                "failures.jsonl",
                blake3_file,
                manifest.failures_blake3.as_ref(),
            ),
            (
                "skipped.jsonl",
                blake3_file,
                manifest.skipped_blake3.as_ref(),
            ),
        ];
        for (name, digest_of, digest) in lists {
            let path = self.layout.state(name);
            let what = match (is_there(&path)?, digest) {
                (false, None) => continue,
                (false, Some(_)) => "is missing",
                (true, None) => "is there, and the run that made the set wrote none",
                (true, Some(digest)) if digest_of(&path)? != *digest => {
                    "is not the one that the manifest means"
                }
                (true, Some(_)) => continue,
            };
            findings.push(Finding {
                name: format!("{STATE_FOLDER}/{name}"),
                what: what.to_owned(),
                is_foreign: false,
            });
        }
        Ok(findings)
    }

    /// The images of the set, in its order.
    ///
    /// # Errors
    /// [`DatasetError::Read`], and per line [`DatasetError::Record`].
    pub fn items(
        &self,
    ) -> Result<impl Iterator<Item = Result<ItemRecord, DatasetError>> + use<>, DatasetError> {
        read_list(&self.layout.state("items.jsonl"))
    }

    /// The files that were carried over.
    ///
    /// # Errors
    /// As for [`SetChecker::items`].
    pub fn files(
        &self,
    ) -> Result<impl Iterator<Item = Result<CarriedFile, DatasetError>> + use<>, DatasetError> {
        read_list(&self.layout.state("files.jsonl"))
    }

    /// Takes the names of an image's files for known.
    pub fn know_item(&mut self, item: &ItemRecord) {
        for (name, _) in self.hashes_of(item) {
            self.know(&name);
        }
    }

    /// Takes the name of a file for known.
    pub fn know(&mut self, name: &str) {
        self.names.insert(name_head(name));
    }

    /// Whether the files of an image are there with the right bytes.
    #[must_use]
    pub fn check_item(&self, item: &ItemRecord) -> Vec<Finding> {
        let hashes = self.hashes_of(item);
        let of_file = |(name, blake3): &(String, String)| self.check_file(name, blake3);
        hashes.iter().filter_map(of_file).collect()
    }

    /// Whether a file is there with the right bytes.
    #[must_use]
    pub fn check_file(&self, name: &str, blake3: &str) -> Option<Finding> {
        let finding = |what: String| {
            Some(Finding {
                name: name.to_owned(),
                what,
                is_foreign: false,
            })
        };
        let Some(path) = crate::set_layout::safe_path(self.layout.root(), name) else {
            return finding("is no name inside the set".to_owned());
        };
        match is_there(&path) {
            Ok(false) => return finding("is missing".to_owned()),
            Err(error) => return finding(error.to_string()),
            Ok(true) => {}
        }
        match blake3_file(&path) {
            Ok(found) if found == blake3 => None,
            Ok(_) => finding("has other bytes than the run wrote".to_owned()),
            Err(error) => finding(error.to_string()),
        }
    }

    /// Files below the root that belong to no list: what somebody else has put there, or another
    /// run. All names must be known before.
    ///
    /// # Errors
    /// [`DatasetError::Read`].
    pub fn strangers(&self) -> Result<Vec<Finding>, DatasetError> {
        let root = self.layout.root();
        let mut findings = Vec::new();
        let mut folders = vec![root.to_owned()];
        while let Some(folder) = folders.pop() {
            let read_error = |source| DatasetError::Read {
                path: folder.clone(),
                source,
            };
            for entry in fs::read_dir(&folder).map_err(read_error)? {
                let path = entry.map_err(read_error)?.path();
                let name = path.strip_prefix(root).unwrap_or(&path);
                let name = name
                    .to_string_lossy()
                    .replace(std::path::MAIN_SEPARATOR, "/");
                if fs::symlink_metadata(&path).is_ok_and(|file| file.is_dir()) {
                    folders.push(path);
                } else if !is_own(&name) && !self.names.contains(&name_head(&name)) {
                    findings.push(Finding {
                        name,
                        what: "does not belong to the set".to_owned(),
                        is_foreign: true,
                    });
                }
            }
        }
        findings.sort();
        Ok(findings)
    }

    fn hashes_of(&self, item: &ItemRecord) -> Vec<(String, String)> {
        let files = self.layout.files_of(&item.name, item.sample);
        let mut hashes = vec![
            (files.image, item.image_blake3.clone()),
            (files.provenance, item.provenance_blake3.clone()),
        ];
        let masks = [
            (files.region, &item.region_blake3),
            (files.crack, &item.crack_blake3),
        ];
        for (name, blake3) in masks {
            if let Some(blake3) = blake3 {
                hashes.push((name, blake3.clone()));
            }
        }
        hashes
    }
}

/// Whether a name is one of the few of the state folder itself.
fn is_own(name: &str) -> bool {
    const OWN: [&str; 9] = [
        "run.json",
        "recipe.toml",
        "items.jsonl",
        MADE_LOG,
        "files.jsonl",
        "manifest.json",
        "failures.jsonl",
        "skipped.jsonl",
        "lock",
    ];
    name.strip_prefix(STATE_FOLDER)
        .and_then(|rest| rest.strip_prefix('/'))
        .is_some_and(|rest| OWN.contains(&rest))
}

/// A digest of a file.
type DigestOf = fn(&Path) -> Result<String, DatasetError>;
