//! Folders into which many files go, looked up once.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

/// How the temporary names of all outputs begin.
pub(crate) const TEMPORARY: &str = ".starbreak-";

/// Whether a file has a temporary name, as one that a killed run has left.
pub(crate) fn is_temporary(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| name.as_encoded_bytes().starts_with(TEMPORARY.as_bytes()))
}

/// More folders are not remembered, so that a set with a folder for each image takes no more memory.
const MAX_KNOWN_FOLDERS: usize = 256;

/// Where folders are, without links, for those who put thousands of files into a few of them.
///
/// To look it up asks the system about each part of the path. What is remembered is only a place to
/// try first: where no file can be created there, the path is looked up anew.
#[derive(Debug, Default)]
pub(crate) struct KnownFolders {
    /// By the absolute path as it was given.
    resolved: Mutex<BTreeMap<PathBuf, PathBuf>>,
}

impl KnownFolders {
    /// A new file in a folder, under a temporary name that begins with `prefix`, and the folder
    /// without links.
    ///
    /// `create_missing` makes the folder if it is not there; it is called again where others
    /// remove it in the meantime. The path of the folder is absolute.
    pub(crate) fn temporary_in(
        &self,
        folder: &Path,
        prefix: &str,
        mut create_missing: impl FnMut() -> io::Result<()>,
    ) -> io::Result<(PathBuf, NamedTempFile)> {
        if let Some(known) = self.get(folder)
            && let Ok(temporary) = temporary_named(prefix, "", &known)
        {
            return Ok((known, temporary));
        }
        let mut n_retries = 20;
        loop {
            let attempt = create_missing()
                .and_then(|()| fs::canonicalize(folder))
                .and_then(|resolved| Ok((temporary_named(prefix, "", &resolved)?, resolved)));
            match attempt {
                Ok((temporary, resolved)) => {
                    self.remember(folder, &resolved);
                    return Ok((resolved, temporary));
                }
                // Another batch may have removed a folder which it had created.
                Err(e) if e.kind() == io::ErrorKind::NotFound && n_retries > 0 => n_retries -= 1,
                Err(e) => return Err(e),
            }
        }
    }

    fn get(&self, folder: &Path) -> Option<PathBuf> {
        let resolved = self.resolved.lock().unwrap_or_else(PoisonError::into_inner);
        resolved.get(folder).cloned()
    }

    fn remember(&self, folder: &Path, resolved: &Path) {
        let mut known = self.resolved.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MAX_KNOWN_FOLDERS {
            known.clear();
        }
        known.insert(folder.to_owned(), resolved.to_owned());
    }
}

/// The folder of a path, absolute, so that a change of the working directory does no harm.
pub(crate) fn absolute_folder_of(path: &Path) -> io::Result<PathBuf> {
    let absolute = std::path::absolute(path)?;
    let folder = absolute.parent().map(Path::to_path_buf);
    folder.ok_or_else(|| io::ErrorKind::InvalidInput.into())
}

/// A new file in a folder under a temporary name.
pub(crate) fn temporary_named(
    prefix: &str,
    suffix: &str,
    folder: &Path,
) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(suffix);
    // Less the umask, as for any new file; the default would be private to the user.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use super::*;

    /// Where a file for the folder goes, and how often the folder was made for it.
    fn place_of(known: &KnownFolders, folder: &Path) -> (PathBuf, u32) {
        let mut n_made = 0;
        let (resolved, temporary) = known
            .temporary_in(folder, TEMPORARY, || {
                n_made += 1;
                fs::create_dir_all(folder)
            })
            .unwrap();
        assert_eq!(temporary.path().parent(), Some(resolved.as_path()), "in it");
        (resolved, n_made)
    }

    #[test]
    fn folder_is_looked_up_once_and_again_when_it_is_gone() {
        let dir = tempfile::tempdir().unwrap();
        let root = fs::canonicalize(dir.path()).unwrap();
        let (folder, known) = (root.join("a/b"), KnownFolders::default());
        assert_eq!(place_of(&known, &folder), (folder.clone(), 1), "new");
        assert_eq!(place_of(&known, &folder), (folder.clone(), 0), "known");
        fs::remove_dir_all(root.join("a")).unwrap();
        assert_eq!(place_of(&known, &folder), (folder.clone(), 1), "gone");
    }

    #[test]
    fn folder_that_others_always_remove_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        let mut n_made = 0;
        let known = KnownFolders::default();
        let made = known.temporary_in(&dir.path().join("never"), TEMPORARY, || {
            n_made += 1;
            Ok(())
        });
        assert_eq!(made.unwrap_err().kind(), io::ErrorKind::NotFound, "said");
        assert_eq!(n_made, 21, "tried");
    }

    #[cfg(unix)]
    #[test]
    fn link_is_followed_to_where_it_led_first_while_that_is_there() {
        let dir = tempfile::tempdir().unwrap();
        let root = fs::canonicalize(dir.path()).unwrap();
        let (first, second, link) = (root.join("1"), root.join("2"), root.join("link"));
        fs::create_dir(&first).unwrap();
        fs::create_dir(&second).unwrap();
        std::os::unix::fs::symlink(&first, &link).unwrap();
        let known = KnownFolders::default();
        assert_eq!(place_of(&known, &link).0, first, "resolved");
        fs::remove_file(&link).unwrap();
        std::os::unix::fs::symlink(&second, &link).unwrap();
        assert_eq!(place_of(&known, &link).0, first, "remembered");
        fs::remove_dir(&first).unwrap();
        assert_eq!(place_of(&known, &link).0, second, "looked up anew");
        assert_eq!(place_of(&known, &link).0, second, "remembered again");
    }

    #[test]
    fn no_more_folders_are_remembered_than_a_few_hundred() {
        let dir = tempfile::tempdir().unwrap();
        let known = KnownFolders::default();
        for k in 0..=MAX_KNOWN_FOLDERS {
            place_of(&known, &dir.path().join(k.to_string()));
        }
        assert_eq!(known.resolved.lock().unwrap().len(), 1, "begun again");
    }
}
