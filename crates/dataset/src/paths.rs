use std::fs;
use std::path::{Component, Path, PathBuf};

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
    resolved(a) == resolved(b) || same_inode(a, b)
}

#[cfg(unix)]
fn same_inode(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn same_inode(_: &Path, _: &Path) -> bool {
    false
}

/// The absolute path without links, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
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
