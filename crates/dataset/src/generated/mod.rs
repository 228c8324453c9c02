//! A generated dataset on disk: where its files lie, which of them are done, and their hashes.
//!
//! The tree of the source is kept under the root, or with several samples per image once in each
//! folder `sample_0`, `sample_1`, …. All that the source does not have lies in one folder beside
//! it, [`STATE_FOLDER`]:
//!
//! | file | what |
//! |---|---|
//! | `run.json` | what the set is made from; there from the first moment |
//! | `recipe.toml` | the recipe |
//! | `regions/`, `cracks/`, `provenance/` | the source's tree again: two masks and a record for each image |
//! | `items.jsonl` | a line of hashes for each image, in the order of the source |
//! | `made.jsonl` | the lines of what was made since, while a run is at work or was interrupted |
//! | `files.jsonl` | a line for each file that was carried over |
//! | `manifest.json` | there once the set is whole: counts, and the hashes of the two lists |
//! | `failures.jsonl`, `skipped.jsonl` | what could not be done, where there is such |
//! | `lock` | empty; locked while a run is at work |
//!
//! A file stands under its name only when it is whole, and the record of an image is put in place
//! after its pictures. So a run that was killed at any moment goes on where it was. What is done is
//! kept if it has the hashes that its line had when it was made; else it is made again.

mod carry;
mod check;
mod identity;
mod items;
mod known;
mod lists;
mod merge;

pub use carry::{CarriedFile, Carry, file_len};
pub use check::{Finding, SetChecker};
pub use identity::compare_identity;
pub use items::ItemRecord;
pub use lists::Manifest;
pub use merge::{MergeReport, merge_sets};

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;
use sha2::{Digest as _, Sha256};

use crate::error::DatasetError;
use crate::known_folders::{KnownFolders, is_temporary};
use crate::ordinary_file::{read_bytes, refuse_no_file};
use crate::output_batch::OutputBatch;
use crate::paths::resolved;
use crate::provenance::blake3_hex;
use crate::set_layout::{STATE_FOLDER, SetLayout, refuse_inside_set};
use crate::text_file::read_text;
use known::{KnownItems, MADE_LOG};

/// Name and version of the format of a generated set.
pub const SET_SCHEMA: &str = "starbreak.dataset/2";

/// No record of a run is longer, bytes.
const MAX_RECORD_BYTES: u64 = 1 << 24;

/// No record of an image is longer, bytes: that of some 200 000 labeled objects.
pub const MAX_ITEM_BYTES: u64 = 64 << 20;

/// A generated dataset that this process works on; no other may at the same time.
#[derive(Debug)]
pub struct GeneratedSet {
    layout: SetLayout,
    identity: Value,
    folders: Arc<KnownFolders>,
    known: KnownItems,
    /// Holds the lock.
    _lock: File,
}

impl GeneratedSet {
    /// Begins a set, or goes on with one that the same run has begun.
    ///
    /// `identity` is the JSON object that says what the set is made from; a folder that holds a
    /// set of another identity is refused, and so is one that holds anything else. Temporary
    /// files of a killed run are removed, and so is the manifest of a finished one: from now on
    /// until [`GeneratedSet::finish`] the set is not finished.
    ///
    /// # Errors
    /// As for [`GeneratedSet::may_begin`], and [`DatasetError::FolderInUse`],
    /// [`DatasetError::Write`].
    pub fn begin(root: &Path, n_samples: u32, identity: &Value) -> Result<Self, DatasetError> {
        Self::may_begin(root, identity)?;
        let layout = SetLayout::new(root, n_samples);
        let lock = lock(&layout)?;
        refuse_other(&layout, identity)?;
        let (run_file, run_text) = (layout.state("run.json"), identity::text(identity));
        // What is there says the same, but may be damaged.
        if !read_bytes(&run_file, u64::MAX).is_ok_and(|found| found == run_text.as_bytes()) {
            let mut batch = OutputBatch::new().of_set();
            batch.stage(&run_file, run_text.as_bytes())?;
            batch.commit()?;
        }
        remove_temporaries(root)?;
        let set = Self {
            known: KnownItems::open(&layout, &run_text)?,
            layout,
            identity: identity.clone(),
            folders: Arc::default(),
            _lock: lock,
        };
        // Until the run is finished again.
        set.put_state("manifest.json", None)?;
        Ok(set)
    }

    /// Whether a set of this identity can be begun in a folder, or gone on with; nothing is written.
    ///
    /// # Errors
    /// [`DatasetError::OtherSet`], [`DatasetError::NotASet`] for a folder that holds anything else,
    /// [`DatasetError::InsideSet`], [`DatasetError::Read`].
    pub fn may_begin(root: &Path, identity: &Value) -> Result<(), DatasetError> {
        let absolute = resolved(root);
        refuse_inside_set(absolute.parent().unwrap_or(&absolute))?;
        let layout = SetLayout::new(root, 1);
        if is_there(&layout.state("run.json"))? {
            refuse_other(&layout, identity)
        } else if is_empty_or_absent(root)? || only_begun(&layout)? {
            Ok(())
        } else {
            Err(DatasetError::NotASet {
                path: root.to_owned(),
                reason: "it is not empty, and no set was begun there".to_owned(),
            })
        }
    }

    /// Where its files lie.
    #[must_use]
    pub fn layout(&self) -> &SetLayout {
        &self.layout
    }

    /// What it is made from.
    #[must_use]
    pub fn identity(&self) -> &Value {
        &self.identity
    }

    /// An empty batch for one of its samples. Thousands of files that can be made again need not
    /// wait for the disk one by one, nor look up their few folders each time.
    #[must_use]
    pub fn batch(&self) -> OutputBatch {
        OutputBatch::new_unsynced_in(Arc::clone(&self.folders))
    }

    /// Writes a file of the state folder, or removes it where there is no text.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn put_state(&self, name: &str, text: Option<&str>) -> Result<(), DatasetError> {
        let path = self.layout.state(name);
        match text {
            Some(text) => {
                let mut batch = OutputBatch::new().of_set();
                batch.stage(&path, text.as_bytes())?;
                batch.commit()
            }
            None => match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    Err(DatasetError::Write { path, source })
                }
                _ => Ok(()),
            },
        }
    }
}

/// Refuses a set of another identity. Where its `run.json` is damaged, the manifest still tells.
fn refuse_other(layout: &SetLayout, identity: &Value) -> Result<(), DatasetError> {
    let run_file = layout.state("run.json");
    if !is_there(&run_file)? {
        return Ok(());
    }
    let found = identity::read(&run_file);
    let refusal = found.and_then(|found| compare_identity(layout.root(), &found, identity));
    let run_blake3 = blake3_hex(identity::text(identity).as_bytes());
    match lists::read_manifest(layout) {
        Ok(Some(manifest)) if manifest.run_blake3 == run_blake3 => Ok(()),
        _ => refusal,
    }
}

/// The identity of the set in a folder.
///
/// # Errors
/// [`DatasetError::NotASet`] where there is none.
pub fn set_identity(root: &Path) -> Result<Value, DatasetError> {
    let path = SetLayout::new(root, 1).state("run.json");
    if !is_there(&path)? {
        return Err(DatasetError::NotASet {
            path: root.to_owned(),
            reason: format!("it has no {STATE_FOLDER}/run.json"),
        });
    }
    identity::read(&path)
}

/// The JSON in one of our own small files.
fn read_json(path: &Path) -> Result<Value, DatasetError> {
    let text = read_text(path, MAX_RECORD_BYTES)?.text;
    serde_json::from_str(&text).map_err(|error| DatasetError::Record {
        path: path.to_owned(),
        reason: crate::error::one_line(&error),
    })
}

fn is_there(path: &Path) -> Result<bool, DatasetError> {
    fs::exists(path).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })
}

fn is_empty_or_absent(root: &Path) -> Result<bool, DatasetError> {
    match fs::read_dir(root) {
        Ok(mut entries) => Ok(entries.next().is_none()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(true),
        Err(source) => Err(DatasetError::Read {
            path: root.to_owned(),
            source,
        }),
    }
}

/// Whether a folder holds nothing but what a run leaves that was killed before its `run.json`.
fn only_begun(layout: &SetLayout) -> Result<bool, DatasetError> {
    let read = |path: &Path| -> Result<Vec<PathBuf>, DatasetError> {
        let entries = fs::read_dir(path).and_then(|entries| {
            entries
                .map(|entry| entry.map(|entry| entry.path()))
                .collect()
        });
        entries.map_err(|source| DatasetError::Read {
            path: path.to_owned(),
            source,
        })
    };
    let state = layout.state_folder();
    if read(layout.root())? != [state.clone()] || !state.is_dir() {
        return Ok(false);
    }
    let lock = layout.state("lock");
    Ok(read(&state)?
        .iter()
        .all(|path| *path == lock || is_temporary(path)))
}

fn lock(layout: &SetLayout) -> Result<File, DatasetError> {
    let path = layout.state("lock");
    let write_error = |source| DatasetError::Write {
        path: path.clone(),
        source,
    };
    fs::create_dir_all(layout.state_folder()).map_err(write_error)?;
    refuse_no_file(&path)?;
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(write_error)?;
    match file.try_lock() {
        // Some file systems have no locks; that is no reason to refuse them.
        Ok(()) | Err(fs::TryLockError::Error(_)) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(DatasetError::FolderInUse {
            path: layout.root().to_owned(),
        }),
    }
}

/// Removes what a killed run has left under temporary names.
fn remove_temporaries(folder: &Path) -> Result<(), DatasetError> {
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let read_error = |source| DatasetError::Read {
            path: folder.clone(),
            source,
        };
        for entry in fs::read_dir(&folder).map_err(read_error)? {
            let entry = entry.map_err(read_error)?;
            let kind = entry.file_type().map_err(read_error)?;
            let path = entry.path();
            if kind.is_dir() {
                folders.push(path);
            } else if kind.is_file() && is_temporary(&path) {
                fs::remove_file(&path).map_err(|source| DatasetError::Write { path, source })?;
            }
        }
    }
    Ok(())
}

/// The first 64 bits of a name's SHA-256.
fn name_head(name: &str) -> u64 {
    let digest = Sha256::digest(name.as_bytes());
    let mut head = [0; 8];
    head.copy_from_slice(&digest[..8]);
    u64::from_be_bytes(head)
}
