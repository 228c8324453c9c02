//! The files below a folder, one after the other, in the order of their names.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::vec;

use super::record::BadRecord;
use crate::ordinary_file::not_a_file;

/// Something found below a folder.
#[derive(Debug)]
pub(super) struct Found {
    /// Its path inside the folder, with `/` between the parts; readable, not exact, if bad.
    pub(super) name: String,
    /// Whether it is a folder, which then is a bad one: good ones are entered.
    pub(super) is_folder: bool,
    /// The file, or why there is none.
    pub(super) file: Result<PathBuf, BadRecord>,
}

/// All files below a folder; holds the names of one folder per level.
///
/// The order is that of the bytes of the whole names. Links are followed, in [`Walk::inside`] those
/// that stay inside; a link to a folder that is being walked is a bad record and not entered. Names that begin with a dot are left out,
/// and with them the temporary files of [`crate::OutputBatch`]. Of two names in one folder that
/// differ only in case the second is bad: where case does not count, it would replace the first.
#[derive(Debug)]
pub(super) struct Walk {
    levels: Vec<Level>,
    /// The folder, without links, that no link may lead out of.
    confines: Option<PathBuf>,
    /// All folders entered so far, without links.
    entered: BTreeSet<PathBuf>,
    /// The folder to begin with cannot be listed.
    failed: Option<Found>,
}

#[derive(Debug)]
struct Level {
    /// The folder without links, to know it again.
    canonical: PathBuf,
    entries: vec::IntoIter<Entry>,
}

#[derive(Debug)]
struct Entry {
    name: String,
    path: PathBuf,
    is_folder: bool,
    /// Why it is not used.
    problem: Option<String>,
}

impl Walk {
    /// The files below `root`, with names that begin with `prefix`.
    pub(super) fn below(root: &Path, prefix: &str) -> Self {
        Self::new(root, prefix, None)
    }

    /// The files below `root`, where a link that leads out of it is a bad record.
    pub(super) fn inside(root: &Path) -> Self {
        // A folder that is not there is told of where it is listed.
        Self::new(root, "", fs::canonicalize(root).ok())
    }

    /// The folders that were entered so far, without links.
    pub(super) fn entered(self) -> BTreeSet<PathBuf> {
        self.entered
    }

    fn new(root: &Path, prefix: &str, confines: Option<PathBuf>) -> Self {
        let mut walk = Self {
            levels: Vec::new(),
            confines,
            entered: BTreeSet::new(),
            failed: None,
        };
        match Level::of(root, prefix, walk.confines.as_deref()) {
            Ok(level) => walk.push(level),
            Err(error) => {
                let reason = format!("cannot list the folder: {error}");
                walk.failed = Some(bad_folder(prefix, &reason));
            }
        }
        walk
    }

    fn push(&mut self, level: Level) {
        self.entered.insert(level.canonical.clone());
        self.levels.push(level);
    }

    /// The folder is entered, unless it is one of those that are walked just now.
    fn enter(&mut self, name: &str, path: &Path) -> Result<(), String> {
        let level = Level::of(path, &format!("{name}/"), self.confines.as_deref())
            .map_err(|error| format!("cannot list the folder: {error}"))?;
        if self.levels.iter().any(|l| l.canonical == level.canonical) {
            return Err("a link back to a folder that holds it; remove the link".to_owned());
        }
        self.push(level);
        Ok(())
    }
}

impl Iterator for Walk {
    type Item = Found;

    fn next(&mut self) -> Option<Found> {
        if let Some(failed) = self.failed.take() {
            return Some(failed);
        }
        loop {
            let Some(entry) = self.levels.last_mut()?.entries.next() else {
                self.levels.pop();
                continue;
            };
            let problem = match (entry.problem, entry.is_folder) {
                (Some(problem), _) => Some(problem),
                (None, false) => None,
                (None, true) => match self.enter(&entry.name, &entry.path) {
                    Ok(()) => continue,
                    Err(problem) => Some(problem),
                },
            };
            let is_folder = entry.is_folder;
            let file = match problem {
                None => Ok(entry.path),
                Some(reason) => Err(BadRecord::new(&entry.name, reason)),
            };
            return Some(Found {
                name: entry.name,
                is_folder,
                file,
            });
        }
    }
}

impl Level {
    fn of(folder: &Path, prefix: &str, confines: Option<&Path>) -> io::Result<Self> {
        let canonical = fs::canonicalize(folder)?;
        let mut entries = Vec::new();
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let file_name = entry.file_name();
            let path = entry.path();
            if file_name.as_encoded_bytes().starts_with(b".") {
                continue;
            }
            let (is_folder, problem) = match is_folder(&entry, &path, confines) {
                Ok(is_folder) => (is_folder, None),
                Err(problem) => (false, Some(problem)),
            };
            let bad_name = match file_name.to_str() {
                None => Some("the name is not UTF-8; rename it".to_owned()),
                Some(name) if name.contains('\\') => {
                    Some("the name has a backslash; rename it".to_owned())
                }
                Some(_) => None,
            };
            entries.push(Entry {
                name: format!("{prefix}{}", file_name.to_string_lossy()),
                path,
                is_folder,
                problem: bad_name.or(problem),
            });
        }
        // Folders as their contents will stand, so that the whole walk is in order.
        entries.sort_by_cached_key(|entry| {
            let slash = if entry.is_folder { "/" } else { "" };
            format!("{}{slash}", entry.name)
        });
        let mut folded = BTreeMap::new();
        for entry in &mut entries {
            if let Some(first) = folded.insert(entry.name.to_lowercase(), entry.name.clone()) {
                entry.problem = Some(differs_in_case(&first));
                folded.insert(entry.name.to_lowercase(), first);
            }
        }
        Ok(Self {
            canonical,
            entries: entries.into_iter(),
        })
    }
}

/// Whether an entry of a folder leads to a folder rather than a file, or why to neither.
fn is_folder(entry: &fs::DirEntry, path: &Path, confines: Option<&Path>) -> Result<bool, String> {
    let cannot_read = |error: io::Error| format!("cannot read it: {error}");
    let file_type = entry.file_type().map_err(cannot_read)?;
    if file_type.is_file() || file_type.is_dir() {
        return Ok(file_type.is_dir());
    }
    let metadata = fs::metadata(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => "a link that leads nowhere".to_owned(),
        _ => cannot_read(error),
    })?;
    if let Some(root) = confines {
        let target = fs::canonicalize(path).map_err(cannot_read)?;
        if !target.starts_with(root) {
            return Err(format!(
                "a link that leads out of the folder, to {target:?}; give --follow-links to read what is there, or \
                 remove the link"
            ));
        }
    }
    match not_a_file(&metadata) {
        None => Ok(false),
        Some(_) if metadata.is_dir() => Ok(true),
        Some(what) => Err(format!("it is {what}, not a file")),
    }
}

fn bad_folder(prefix: &str, reason: &str) -> Found {
    let name = if prefix.is_empty() { "." } else { prefix };
    Found {
        name: name.to_owned(),
        is_folder: true,
        file: Err(BadRecord::new(name, reason)),
    }
}

/// The reason why the second of two such names is refused.
pub(super) fn differs_in_case(first: &str) -> String {
    format!("the name differs from {first:?} only in case; rename one of them")
}
