use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempPath;

use crate::batch_lock::{BatchLock, clear_left};
use crate::error::DatasetError;
use crate::known_folders::{KnownFolders, TEMPORARY, absolute_folder_of};
use crate::ordinary_file::not_a_file;
use crate::paths::FileSet;
use crate::replacing::{Replacing, WrittenList, is_record};

/// The files of one sample, which appear together or not at all.
///
/// [`stage`](Self::stage) writes each file under a temporary name (`.starbreak-*`) into its own
/// folder and waits until it is on the disk (unless the batch is
/// [unsynced](Self::new_unsynced)); [`commit`](Self::commit) renames them all, in the
/// order of staging. A batch that is dropped removes its temporary files and the folders it has
/// created. So stage the file that stands for "done", such as the provenance, last.
///
/// A file that is there stays, and the output is refused, unless the file has the bytes of the output
/// already, is a record of ours for the same purpose (JSON with the same `schema`, of the same
/// input), or was written by an earlier run and not touched since, as such a record or a
/// [list](Self::with_list) says; or unless the batch is to [replace](Self::replacing) all. A file is
/// replaced with the permissions of a new one; where the destination is a link, the link is replaced and
/// not the file it leads to. What an earlier run has written and this one has not is removed.
///
/// # Limits
///
/// A rename cannot be taken back: if a commit fails half way, files that were new when they were
/// staged are removed again, but files that were there and are already replaced keep their new content
/// ([`DatasetError::Commit`] lists them). What a process that is killed leaves behind, the next one that
/// writes into the folder removes: its `.starbreak-*` files, and those of an output that had got their
/// names only in part (of a generated set, the set does). Of batches that share a new folder at one time, none may be the one to remove it,
/// so that it stays, empty. After a loss of power a committed file is whole or absent, never half.
/// Where a link leads to a folder, files go where it led when the batch, or one before of the same
/// [set](crate::GeneratedSet::batch), first used it, as long as that folder is there.
#[derive(Debug)]
pub struct OutputBatch {
    staged: Vec<StagedFile>,
    destinations: BTreeSet<PathBuf>,
    waits_for_disk: bool,
    folders: Arc<KnownFolders>,
    rule: Replacing,
    list: Option<WrittenList>,
    /// By the folder; none of a set, which has a lock of its own.
    locks: Option<BTreeMap<PathBuf, BatchLock>>,
    /// Folders created by this batch, parents first.
    created_folders: Vec<PathBuf>,
}

/// A file under its temporary name.
#[derive(Debug)]
pub(crate) struct StagedFile {
    /// The resolved folder with the file's name: where the file goes.
    destination: PathBuf,
    temporary: TempPath,
    /// Whether there was a file, or a link, under its name.
    replaces: bool,
    /// Whether another program fills it.
    is_reserved: bool,
}

impl OutputBatch {
    /// An empty batch, whose files are on the disk before they get their names.
    #[must_use]
    pub fn new() -> Self {
        Self {
            staged: Vec::new(),
            destinations: BTreeSet::new(),
            waits_for_disk: true,
            folders: Arc::default(),
            rule: Replacing::default(),
            list: None,
            locks: Some(BTreeMap::new()),
            created_folders: Vec::new(),
        }
    }

    /// An empty batch which leaves it to the system when the files reach the disk.
    ///
    /// Many times faster for small files, and meant for thousands of samples that can be made
    /// again: after a loss of power a committed file may be empty.
    #[must_use]
    pub fn new_unsynced() -> Self {
        let mut batch = Self::new();
        batch.waits_for_disk = false;
        batch
    }

    /// As [`OutputBatch::new_unsynced`], for many batches that share a few folders, in which all files
    /// are ours.
    pub(crate) fn new_unsynced_in(folders: Arc<KnownFolders>) -> Self {
        let mut batch = Self::new_unsynced().of_set();
        batch.folders = folders;
        batch
    }

    /// The same, whose files are those of a generated set.
    pub(crate) fn of_set(mut self) -> Self {
        self.rule.allow_set();
        self.locks = None;
        self
    }

    /// The same, which replaces any file or only those of ours.
    #[must_use]
    pub fn replacing(mut self, any: bool) -> Self {
        self.rule.allow_any(any);
        self
    }

    /// The same, which replaces none of these files, whatever else it may.
    #[must_use]
    pub fn never_over(mut self, inputs: FileSet) -> Self {
        self.rule.protect(inputs);
        self
    }

    /// The same, which leaves a list of its files at `path`, and takes over those that the list of
    /// an earlier run of this verb has.
    #[must_use]
    pub fn with_list(mut self, path: &Path, verb: &str) -> Self {
        let list = WrittenList::new(path, verb);
        self.rule.take_over(list.earlier());
        self.list = Some(list);
        self
    }

    /// Takes over files that an earlier run has written, with the BLAKE3 that each then had: they may
    /// be replaced, and those that are not are removed.
    pub fn take_over(&mut self, files: Vec<(PathBuf, String)>) {
        self.rule.take_over(files);
    }

    /// Whether an output whose bytes are not known yet may be written: better said before the work
    /// than after it. Of a record of ours in its place that is decided when it is staged.
    ///
    /// # Errors
    /// [`DatasetError::Taken`], [`DatasetError::Altered`], [`DatasetError::OutputIsInput`], [`DatasetError::InsideSet`].
    pub fn may_write(&self, path: &Path) -> Result<(), DatasetError> {
        self.clear_left_beside(path);
        match self.rule.check(path, None) {
            Err(DatasetError::Taken { .. } | DatasetError::Altered { .. }) if is_record(path) => {
                Ok(())
            }
            checked => checked,
        }
    }

    /// Whether a file that another program, or another part of this one, fills may be written.
    ///
    /// # Errors
    /// [`DatasetError::Taken`], [`DatasetError::Altered`], [`DatasetError::OutputIsInput`], [`DatasetError::InsideSet`].
    pub(crate) fn may_fill(&self, path: &Path) -> Result<(), DatasetError> {
        self.clear_left_beside(path);
        self.rule.check(path, None)
    }

    /// Removes what killed runs have left in the folder of an output.
    fn clear_left_beside(&self, path: &Path) {
        if let (Some(_), Ok(folder)) = (&self.locks, absolute_folder_of(path)) {
            clear_left(&folder);
        }
    }

    /// Writes `bytes` beside `path`, under a temporary name, creating missing folders.
    ///
    /// # Errors
    ///
    /// [`DatasetError::DuplicateOutput`] where the path was staged before (also by another
    /// spelling), [`DatasetError::DestinationNotAFile`] where it is a folder, a pipe or a device,
    /// [`DatasetError::Taken`], [`DatasetError::Altered`] and [`DatasetError::OutputIsInput`] where a file is to stay,
    /// [`DatasetError::InsideSet`] in a generated set,
    /// [`DatasetError::Write`] where the file system refuses. The batch stays as it was, apart
    /// from folders, and may be used further.
    pub fn stage(&mut self, path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
        self.clear_left_beside(path);
        self.rule.check(path, Some(bytes))?;
        let (mut file, staged) = self.begin(path)?;
        file.write_all(bytes)
            .and_then(|()| file.flush())
            .and_then(|()| match self.waits_for_disk {
                true => file.sync_all(),
                false => Ok(()),
            })
            .map_err(|source| DatasetError::Write {
                path: path.to_owned(),
                source,
            })?;
        self.end(staged);
        if let Some(list) = &mut self.list {
            list.note(path, bytes);
        }
        Ok(())
    }

    /// The temporary name of an empty file beside `path`, for another program to fill before the
    /// commit; as [`stage`](Self::stage) otherwise.
    ///
    /// # Errors
    ///
    /// As for [`stage`](Self::stage).
    pub fn reserve(&mut self, path: &Path) -> Result<PathBuf, DatasetError> {
        self.may_fill(path)?;
        let (_, mut staged) = self.begin(path)?;
        staged.is_reserved = true;
        let name = staged.temporary.to_path_buf();
        self.end(staged);
        Ok(name)
    }

    /// An empty file beside `path`, open for writing under a temporary name, for the caller to fill before the commit;
    /// as [`stage`](Self::stage) otherwise.
    ///
    /// # Errors
    ///
    /// As for [`stage`](Self::stage).
    pub fn open(&mut self, path: &Path) -> Result<File, DatasetError> {
        self.may_fill(path)?;
        let (file, mut staged) = self.begin(path)?;
        staged.is_reserved = true;
        self.end(staged);
        Ok(file)
    }

    /// Opens a file beside `path`, under a temporary name; [`OutputBatch::end`] stages it once it
    /// has been written.
    ///
    /// # Errors
    /// As for [`OutputBatch::stage`].
    pub(crate) fn begin(&mut self, path: &Path) -> Result<(File, StagedFile), DatasetError> {
        let file_name = file_name_of(path)?;
        let found = fs::symlink_metadata(path).ok();
        let target = match &found {
            Some(found) if found.is_symlink() => fs::metadata(path).ok(),
            found => found.clone(),
        };
        if let Some(what) = target.as_ref().and_then(not_a_file) {
            return Err(DatasetError::DestinationNotAFile {
                path: path.to_owned(),
                what,
            });
        }
        let write_error = |source| DatasetError::Write {
            path: path.to_owned(),
            source,
        };
        let folder = absolute_folder_of(path).map_err(write_error)?;
        let created = &mut self.created_folders;
        let prefix = match &mut self.locks {
            Some(locks) => prefix_in(&folder, locks, created).map_err(write_error)?,
            None => TEMPORARY.to_owned(),
        };
        let (folder, temporary) = self
            .folders
            .temporary_in(&folder, &prefix, || create_folders(&folder, created))
            .map_err(write_error)?;
        let destination = folder.join(file_name);
        if self.destinations.contains(&destination) {
            return Err(DatasetError::DuplicateOutput {
                path: path.to_owned(),
            });
        }

        let (file, temporary) = temporary.into_parts();
        let staged = StagedFile {
            destination,
            temporary,
            replaces: found.is_some(),
            is_reserved: false,
        };
        Ok((file, staged))
    }

    /// Stages a file that has been written.
    pub(crate) fn end(&mut self, staged: StagedFile) {
        self.destinations.insert(staged.destination.clone());
        self.staged.push(staged);
    }

    /// Renames all staged files into place, in the order of staging.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Commit`] where a rename fails. Files of this batch that did not exist
    /// when they were staged are then removed again, with the folders created for them; files that existed and
    /// were already replaced are listed in the error. As for [`stage`](Self::stage) where there is a
    /// list.
    pub fn commit(mut self) -> Result<(), DatasetError> {
        if let Some((path, text)) = self.list.take().map(WrittenList::file) {
            self.stage(&path, text.as_bytes())?;
        }
        if self.waits_for_disk {
            for staged in self.staged.iter().filter(|staged| staged.is_reserved) {
                File::open(&staged.temporary)
                    .and_then(|file| file.sync_all())
                    .map_err(|source| DatasetError::Write {
                        path: staged.destination.clone(),
                        source,
                    })?;
            }
        }
        for lock in self.locks.iter_mut().flat_map(BTreeMap::values_mut) {
            let staged = self.staged.iter();
            lock.note(staged.map(|one| (&*one.temporary, one.destination.as_path())));
        }
        let mut new_files = Vec::new();
        let mut replaced = Vec::new();
        for staged in std::mem::take(&mut self.staged) {
            if let Err(failed) = staged.temporary.persist(&staged.destination) {
                for path in new_files {
                    // Best effort: the first failure is the one to report.
                    let _ = fs::remove_file(path);
                }
                return Err(DatasetError::Commit {
                    path: staged.destination,
                    replaced,
                    source: failed.error,
                });
            }
            let list = if staged.replaces {
                &mut replaced
            } else {
                &mut new_files
            };
            list.push(staged.destination);
        }
        self.created_folders.clear();
        for path in self.rule.left_over(|path| self.destinations.contains(path)) {
            // Best effort: what stays is an old file, and no wrong one.
            let _ = fs::remove_file(path);
        }
        Ok(())
    }
}

impl Default for OutputBatch {
    /// As [`OutputBatch::new`].
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for OutputBatch {
    fn drop(&mut self) {
        self.staged.clear();
        self.locks = None;
        for folder in self.created_folders.iter().rev() {
            // Fails where another batch has put a file into it, and then it is to stay.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// How temporary names begin in a folder, which is made if it is not there; its lock is held from now on.
fn prefix_in(
    folder: &Path,
    locks: &mut BTreeMap<PathBuf, BatchLock>,
    created: &mut Vec<PathBuf>,
) -> io::Result<String> {
    if let Some(lock) = locks.get(folder) {
        return Ok(lock.prefix().to_owned());
    }
    let mut n_retries = 20;
    loop {
        match create_folders(folder, created).and_then(|()| BatchLock::new(folder)) {
            Ok(lock) => {
                let prefix = lock.prefix().to_owned();
                locks.insert(folder.to_owned(), lock);
                return Ok(prefix);
            }
            // Another batch may have removed a folder which it had created.
            Err(e) if e.kind() == io::ErrorKind::NotFound && n_retries > 0 => n_retries -= 1,
            Err(e) => return Err(e),
        }
    }
}

/// Creates a folder with those above it, as far as they are missing, and notes which.
fn create_folders(folder: &Path, created: &mut Vec<PathBuf>) -> io::Result<()> {
    let mut missing = Vec::new();
    for ancestor in folder.ancestors() {
        match fs::metadata(ancestor) {
            Ok(metadata) if metadata.is_dir() => break,
            Ok(_) => return Err(io::ErrorKind::NotADirectory.into()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => missing.push(ancestor),
            Err(e) => return Err(e),
        }
    }
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => created.push(folder.to_owned()),
            // Another batch was faster, and may have removed it again by now.
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && !is_other(folder) => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

/// Whether something is there that is no folder.
fn is_other(folder: &Path) -> bool {
    fs::symlink_metadata(folder).is_ok_and(|found| !found.is_dir() && !folder.is_dir())
}

/// The last part of the path, unless the path as written names a folder.
fn file_name_of(path: &Path) -> Result<&OsStr, DatasetError> {
    let text = path.as_os_str().to_string_lossy();
    let last = text.rsplit(std::path::is_separator).next().unwrap_or("");
    path.file_name()
        .filter(|_| !matches!(last, "" | "." | ".."))
        .ok_or_else(|| DatasetError::DestinationNotAFile {
            path: path.to_owned(),
            what: "the name of a folder",
        })
}
