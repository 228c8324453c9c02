//! What a killed run has left of a batch, and how the next run that writes into the folder removes it.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use tempfile::TempPath;

use crate::known_folders::{TEMPORARY, is_temporary, temporary_named};

/// How the names of locks end.
const LOCK: &str = ".lock";

/// Folders that this process has looked through.
static CLEARED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A batch at work in a folder: `.starbreak-ID.lock` is held as long as its process lives, and its
/// temporary files are named `.starbreak-ID-*`.
#[derive(Debug)]
pub(crate) struct BatchLock {
    file: File,
    /// Removed with the batch.
    _path: TempPath,
    prefix: String,
}

/// A file that a commit is about to give its name.
#[derive(Debug, Serialize, Deserialize)]
struct Renamed {
    destination: PathBuf,
    /// Which file it is, whatever its name.
    inode: Inode,
}

/// The device and number of a file, which a rename leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Inode(u64, u64);

impl Inode {
    #[cfg(unix)]
    fn of(path: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt as _;
        let found = fs::symlink_metadata(path).ok()?;
        Some(Self(found.dev(), found.ino()))
    }

    #[cfg(not(unix))]
    fn of(_: &Path) -> Option<Self> {
        None
    }
}

impl BatchLock {
    /// Of a folder that is there.
    pub(crate) fn new(folder: &Path) -> io::Result<Self> {
        let (file, path) = temporary_named(TEMPORARY, LOCK, folder)?.into_parts();
        // Where the file system has no locks, what a killed run leaves stays.
        let _ = file.try_lock();
        let name = path.file_name().map(|name| name.to_string_lossy());
        let name = name.unwrap_or_default();
        let id = name.strip_suffix(LOCK).unwrap_or(&name);
        Ok(Self {
            prefix: format!("{id}-"),
            file,
            _path: path,
        })
    }

    /// How the temporary names of the batch begin.
    pub(crate) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Notes which files get their names next, given as temporary name and destination: a run that
    /// is killed before the last of them has left an output in part.
    pub(crate) fn note<'a>(&mut self, files: impl Iterator<Item = (&'a Path, &'a Path)>) {
        let renamed = files.filter_map(|(temporary, destination)| {
            let one = Renamed {
                destination: destination.to_owned(),
                inode: Inode::of(temporary)?,
            };
            serde_json::to_string(&one).ok()
        });
        let text: String = renamed.map(|line| line + "\n").collect();
        // Best effort: without it such an output stays, and the next run asks before it replaces it.
        let _ = self.file.write_all(text.as_bytes());
    }
}

/// Removes from a folder what killed runs have left: temporary files, and of an output whose files
/// had their names only in part those that had. Once per process and folder.
///
/// Only what belongs to a lock that nobody holds is touched.
pub(crate) fn clear_left(folder: &Path) {
    {
        let mut cleared = CLEARED.lock().unwrap_or_else(PoisonError::into_inner);
        if !cleared.insert(folder.to_owned()) {
            return;
        }
    }
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    let temporary: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_temporary(path))
        .collect();
    for path in &temporary {
        let name = path.file_name().map(|name| name.to_string_lossy());
        let Some(id) = name.as_deref().and_then(|name| name.strip_suffix(LOCK)) else {
            continue;
        };
        let Ok(file) = File::open(path) else {
            continue;
        };
        if file.try_lock().is_err() {
            continue;
        }
        undo_part(path);
        let prefix = format!("{id}-");
        let is_of_it = |path: &&PathBuf| {
            let name = path.file_name().map(|name| name.to_string_lossy());
            name.is_some_and(|name| name.starts_with(&prefix))
        };
        for left in temporary.iter().filter(is_of_it) {
            let _ = fs::remove_file(left);
        }
        let _ = fs::remove_file(path);
    }
}

/// Takes back the names of a commit that was not finished.
fn undo_part(lock: &Path) {
    let Ok(text) = fs::read_to_string(lock) else {
        return;
    };
    let renamed: Vec<Renamed> = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect();
    let is_there = |one: &&Renamed| Inode::of(&one.destination) == Some(one.inode);
    if renamed.iter().all(|one| is_there(&one)) {
        return;
    }
    for one in renamed.iter().filter(is_there) {
        let _ = fs::remove_file(&one.destination);
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// The files of a batch whose process was killed: unlocked, and nobody removes them.
    fn killed(folder: &Path, id: &str, journal: &str) {
        fs::write(folder.join(format!(".starbreak-{id}.lock")), journal).unwrap();
        fs::write(folder.join(format!(".starbreak-{id}-abc")), "half").unwrap();
    }

    #[test]
    fn what_a_killed_run_left_goes_and_what_lives_stays() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path();
        killed(folder, "dead00", "");
        let lives = BatchLock::new(folder).unwrap();
        let own = folder.join(format!("{}abc", lives.prefix()));
        fs::write(&own, "at work").unwrap();
        fs::write(folder.join(".starbreak-a1B2c3"), "of an earlier version").unwrap();
        fs::write(folder.join("photo.png"), "of a user").unwrap();
        clear_left(folder);
        let left = names(folder);
        assert!(own.exists(), "{left:?}");
        assert!(left.contains(&".starbreak-a1B2c3".to_owned()), "{left:?}");
        assert!(left.contains(&"photo.png".to_owned()), "{left:?}");
        assert!(!left.iter().any(|name| name.contains("dead00")), "{left:?}");
        drop(lives);
        assert!(!names(folder).iter().any(|name| name.ends_with(LOCK)));
    }

    #[cfg(unix)]
    #[test]
    fn an_output_that_has_its_names_in_part_is_taken_back_and_a_whole_one_stays() {
        let line = |path: &Path| {
            let one = Renamed {
                destination: path.to_owned(),
                inode: Inode::of(path).unwrap_or(Inode(0, 0)),
            };
            serde_json::to_string(&one).unwrap() + "\n"
        };
        for (is_whole, expected) in [(false, 1), (true, 3)] {
            let dir = tempfile::tempdir().unwrap();
            let folder = dir.path();
            let [bank, chart, other] =
                ["patterns.bank", "chart.png", "photo.png"].map(|name| folder.join(name));
            fs::write(&bank, "whole").unwrap();
            fs::write(&other, "of a user").unwrap();
            if is_whole {
                fs::write(&chart, "whole").unwrap();
            }
            killed(folder, "dead00", &(line(&bank) + &line(&chart)));
            clear_left(folder);
            assert_eq!(names(folder).len(), expected, "{:?}", names(folder));
            assert!(other.exists(), "what nobody wrote stays");
        }
    }
}
