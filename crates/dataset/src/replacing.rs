//! Which files an output may take the place of: the one rule for all that is written outside of sets.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Value, json};

use crate::error::DatasetError;
use crate::ordinary_file::read_bytes;
use crate::paths::{FileSet, resolved};
use crate::provenance::{blake3_file, blake3_hex};
use crate::set_layout::{refuse_inside_set, safe_path};

/// What an output may take the place of.
///
/// Never of a file that is read or of a generated set. Else of a file that has the bytes of the output already, of a record of
/// ours for the same purpose (JSON with the same `schema`, and of the same input where both name
/// one), of a file that such a record lists with the hash that it still has, and of any other only if that
/// was asked for.
#[derive(Debug, Default)]
pub(crate) struct Replacing {
    any: bool,
    is_of_set: bool,
    inputs: FileSet,
    /// What an earlier run has written: BLAKE3 by path.
    earlier: BTreeMap<PathBuf, String>,
}

/// The list that a run leaves of what it has written: its file, the schema of such a list, and the
/// entries so far.
#[derive(Debug)]
pub(crate) struct WrittenList {
    path: PathBuf,
    schema: String,
    entries: Vec<Value>,
}

impl WrittenList {
    /// The list of a verb, to be at `path`.
    pub(crate) fn new(path: &Path, verb: &str) -> Self {
        Self {
            path: path.to_owned(),
            schema: format!("starbreak.written-by-{verb}/1"),
            entries: Vec::new(),
        }
    }

    /// What the list of an earlier run has.
    pub(crate) fn earlier(&self) -> Vec<(PathBuf, String)> {
        listed_files(&self.path, &self.schema, None)
    }

    /// Notes a file below the folder of the list; others are not listed, nor are records, which are
    /// known by what they say and may hold times.
    pub(crate) fn note(&mut self, path: &Path, bytes: &[u8]) {
        if Purpose::of(bytes).is_some() {
            return;
        }
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if let Some(name) = path.strip_prefix(folder).ok().and_then(Path::to_str) {
            let name = name.replace(std::path::MAIN_SEPARATOR, "/");
            self.entries
                .push(json!({ "name": name, "blake3": blake3_hex(bytes) }));
        }
    }

    /// Its file.
    pub(crate) fn file(self) -> (PathBuf, String) {
        let list = json!({ "schema": self.schema, "files": self.entries });
        (self.path, format!("{list:#}\n"))
    }
}

impl Replacing {
    pub(crate) fn allow_any(&mut self, any: bool) {
        self.any = any;
    }

    /// The files are those of a generated set, in which all is ours.
    pub(crate) fn allow_set(&mut self) {
        self.is_of_set = true;
        self.any = true;
    }

    pub(crate) fn protect(&mut self, inputs: FileSet) {
        self.inputs = inputs;
    }

    /// Takes files that an earlier run has written for its own.
    pub(crate) fn take_over(&mut self, files: impl IntoIterator<Item = (PathBuf, String)>) {
        let files = files.into_iter();
        self.earlier
            .extend(files.map(|(path, blake3)| (resolved(&path), blake3)));
    }

    /// Whether an output of these bytes may be written; those of another program are not known before.
    pub(crate) fn check(&self, path: &Path, bytes: Option<&[u8]>) -> Result<(), DatasetError> {
        if let Some(input) = self.inputs.find(path) {
            return Err(DatasetError::OutputIsInput {
                input,
                output: path.to_owned(),
            });
        }
        if !self.is_of_set {
            refuse_inside_set(path.parent().unwrap_or(path))?;
        }
        let Ok(found) = fs::symlink_metadata(path) else {
            return Ok(());
        };
        let is_other_thing = fs::metadata(path).is_ok_and(|found| !found.is_file());
        // What is no file is refused for that.
        if self.any || is_other_thing || (!found.is_symlink() && self.is_ours(path, bytes)) {
            return Ok(());
        }
        let path = path.to_owned();
        Err(match self.earlier.contains_key(&resolved(&path)) {
            true => DatasetError::Altered { path },
            false => DatasetError::Taken { path },
        })
    }

    /// The files of earlier runs that no output has taken the place of, as they were written.
    pub(crate) fn left_over<'a>(
        &'a self,
        is_written: impl Fn(&Path) -> bool + 'a,
    ) -> impl Iterator<Item = &'a Path> + 'a {
        let left = self.earlier.iter().filter(move |(path, blake3)| {
            let is_kept = is_written(path) || self.inputs.find(path).is_some();
            !is_kept && blake3_file(path).is_ok_and(|found| found == **blake3)
        });
        left.map(|(path, _)| path.as_path())
    }

    fn is_ours(&self, path: &Path, bytes: Option<&[u8]>) -> bool {
        if let Some(blake3) = self.earlier.get(&resolved(path))
            && blake3_file(path).is_ok_and(|found| found == *blake3)
        {
            return true;
        }
        let Some(bytes) = bytes else { return false };
        let Ok(found) = read_bytes(path, u64::MAX) else {
            return false;
        };
        found == bytes || Purpose::of(bytes).is_some_and(|own| Purpose::of(&found) == Some(own))
    }
}

/// What a JSON file of ours is for.
#[derive(Debug, PartialEq, Eq)]
struct Purpose {
    /// Its schema, without the version.
    schema: String,
    /// The name of what it was made from.
    input: Option<String>,
}

#[derive(Deserialize)]
struct Head {
    schema: String,
    #[serde(default)]
    input: Value,
}

impl Purpose {
    fn of(bytes: &[u8]) -> Option<Self> {
        let is_object = bytes.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{');
        let head: Head = serde_json::from_slice(bytes).ok().filter(|_| is_object)?;
        let (schema, _) = head.schema.split_once('/')?;
        schema.starts_with("starbreak.").then(|| Self {
            schema: schema.to_owned(),
            input: head.input["name"].as_str().map(str::to_owned),
        })
    }
}

/// Whether a file is a JSON record of ours, for whatever purpose.
pub(crate) fn is_record(path: &Path) -> bool {
    let is_link = fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
    !is_link && read_bytes(path, u64::MAX).is_ok_and(|bytes| Purpose::of(&bytes).is_some())
}

/// What in a record is about files that were written.
const LISTS: [&str; 5] = ["output", "region", "crack", "maps", "files"];

/// The files that a record of ours lists beside it with their hashes, if it is for the same purpose as a
/// record of this schema and input. A record that cannot be read lists none.
#[must_use]
pub fn listed_files(record: &Path, schema: &str, input: Option<&str>) -> Vec<(PathBuf, String)> {
    let Ok(bytes) = read_bytes(record, u64::MAX) else {
        return Vec::new();
    };
    let purpose = Purpose {
        schema: schema.split('/').next().unwrap_or(schema).to_owned(),
        input: input.map(str::to_owned),
    };
    let value = match Purpose::of(&bytes) == Some(purpose) {
        true => serde_json::from_slice(&bytes).unwrap_or(Value::Null),
        false => Value::Null,
    };
    let folder = record.parent().unwrap_or(Path::new(""));
    let entries = value.as_object().into_iter().flatten();
    let entries = entries.filter(|(key, _)| LISTS.contains(&key.as_str()));
    let files = entries.flat_map(|(_, value)| match value {
        Value::Array(files) => files.as_slice(),
        file => std::slice::from_ref(file),
    });
    let file = |file: &Value| {
        let path = safe_path(folder, file["name"].as_str()?)?;
        Some((path, file["blake3"].as_str()?.to_owned()))
    };
    files.filter_map(file).collect()
}
