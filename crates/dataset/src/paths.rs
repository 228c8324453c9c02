use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::error::DatasetError;

/// Whether both paths lead to the same file, so that writing one would destroy the other.
///
/// Relative paths, `.` and `..`, symbolic links and, on Unix, hard links are seen through. A path
/// need not exist: then its deepest existing folder is resolved and the rest is compared as text.
///
/// # Limits
///
/// Two names that do not exist yet and differ only in case are taken for different, even where
/// the file system does not tell them apart. A link that leads nowhere stands for itself.
#[must_use]
pub fn same_file(a: &Path, b: &Path) -> bool {
    resolved(a) == resolved(b) || inode(a).is_some_and(|inode_a| inode(b) == Some(inode_a))
}

/// Whether a path lies in a folder, or is it; links are seen through as in [`same_file`].
#[must_use]
pub fn is_inside(path: &Path, folder: &Path) -> bool {
    resolved(path).starts_with(resolved(folder))
}

/// The files in a folder, not below it, whose names end in a dot and `extension`: each name
/// without that end, and the path, in the order of the bytes of the names. Names that begin with a
/// dot or are not UTF-8 are left out.
///
/// # Errors
/// [`DatasetError::Read`] where there is no folder, or it cannot be listed.
pub fn files_in(folder: &Path, extension: &str) -> Result<Vec<(String, PathBuf)>, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: folder.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(read_error)? {
        let entry = entry.map_err(read_error)?;
        let name = entry.file_name();
        let stem = name
            .to_str()
            .and_then(|name| name.strip_suffix(extension)?.strip_suffix('.'))
            .filter(|stem| !stem.is_empty() && !stem.starts_with('.'));
        if let Some(stem) = stem
            && !entry.path().is_dir()
        {
            files.push((stem.to_owned(), entry.path()));
        }
    }
    files.sort_unstable();
    Ok(files)
}

/// Device and number of an existing file.
#[cfg(unix)]
fn inode(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    fs::metadata(path).ok().map(|file| (file.dev(), file.ino()))
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<(u64, u64)> {
    None
}

/// Files that must not be written, to be asked about many paths.
#[derive(Debug, Clone, Default)]
pub struct FileSet {
    by_path: BTreeMap<PathBuf, PathBuf>,
    by_inode: BTreeMap<(u64, u64), PathBuf>,
}

impl FileSet {
    /// The set of these files.
    #[must_use]
    pub fn of(paths: &[PathBuf]) -> Self {
        let mut set = Self::default();
        for path in paths {
            set.by_path.insert(resolved(path), path.clone());
            if let Some(inode) = inode(path) {
                set.by_inode.insert(inode, path.clone());
            }
        }
        set
    }

    /// The file of the set that a path leads to, in the sense of [`same_file`], as it was given.
    #[must_use]
    pub fn find(&self, path: &Path) -> Option<PathBuf> {
        let by_inode = || inode(path).and_then(|inode| self.by_inode.get(&inode));
        self.by_path.get(&resolved(path)).or_else(by_inode).cloned()
    }
}

/// The absolute path without links, as far as it exists.
pub(crate) fn resolved(path: &Path) -> PathBuf {
    let mut resolved = PathBuf::new();
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for component in absolute.components() {
        match component {
            // The folder before is resolved by now, so that its parent is the real one.
            Component::ParentDir => {
                resolved.pop();
            }
            other => resolved.push(other),
        }
        if let Ok(canonical) = fs::canonicalize(&resolved) {
            resolved = canonical;
        }
    }
    resolved
}

/// The file itself, or the one of this name where the path is that of a folder.
#[must_use]
pub fn file_in(path: &Path, name: &str) -> PathBuf {
    if path.is_dir() {
        path.join(name)
    } else {
        path.to_owned()
    }
}
