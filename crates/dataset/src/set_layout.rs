//! Where the files of a generated set lie.

use std::path::{Component, Path, PathBuf};

use crate::error::DatasetError;
use crate::paths::resolved;

/// The folder of a set that holds what its source does not have.
pub const STATE_FOLDER: &str = "starbreak";

/// Where the files of a set lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetLayout {
    root: PathBuf,
    n_samples: u32,
}

/// The files that one image of the source becomes, as paths from the root of the set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleFiles {
    /// The image.
    pub image: String,
    /// The region mask.
    pub region: String,
    /// The crack mask.
    pub crack: String,
    /// The record of how it came about.
    pub provenance: String,
}

impl SetLayout {
    /// The layout of a set with so many samples of each image.
    #[must_use]
    pub fn new(root: &Path, n_samples: u32) -> Self {
        Self {
            root: root.to_owned(),
            n_samples,
        }
    }

    /// The folder that all lies in.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Samples of each image.
    #[must_use]
    pub fn n_samples(&self) -> u32 {
        self.n_samples
    }

    /// The name of a source's file in the tree of one sample.
    #[must_use]
    pub fn in_sample(&self, name: &str, sample_idx: u32) -> String {
        if self.n_samples == 1 {
            name.to_owned()
        } else {
            format!("sample_{sample_idx}/{name}")
        }
    }

    /// The files of one sample of an image. Masks are PNG and records JSON, whatever the image is.
    #[must_use]
    pub fn files_of(&self, name: &str, sample_idx: u32) -> SampleFiles {
        let image = self.in_sample(name, sample_idx);
        let (stem, _) = split_extension(&image);
        SampleFiles {
            region: format!("{STATE_FOLDER}/regions/{stem}.png"),
            crack: format!("{STATE_FOLDER}/cracks/{stem}.png"),
            provenance: format!("{STATE_FOLDER}/provenance/{stem}.json"),
            image,
        }
    }

    /// The path of a name inside the set.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// The path of a name that comes from a list.
    ///
    /// # Errors
    /// [`DatasetError::UnsafeName`] for one that leaves the set.
    pub fn safe(&self, name: &str) -> Result<PathBuf, DatasetError> {
        safe_path(&self.root, name).ok_or_else(|| DatasetError::UnsafeName {
            name: name.to_owned(),
        })
    }

    /// The path of a file of the state folder.
    #[must_use]
    pub fn state(&self, name: &str) -> PathBuf {
        self.state_folder().join(name)
    }

    pub(crate) fn state_folder(&self) -> PathBuf {
        self.root.join(STATE_FOLDER)
    }
}

/// A name without its extension, and that, without the dot; a leading dot begins none.
fn split_extension(name: &str) -> (&str, &str) {
    crate::source::name::split_extension(name).unwrap_or((name, ""))
}

/// The path of a name from a list, which must stay inside its folder: relative, `/` between its
/// parts, none of them empty, `.` or `..`; without NUL, and without a backslash, which is a
/// separator on some systems.
#[must_use]
pub(crate) fn safe_path(root: &Path, name: &str) -> Option<PathBuf> {
    let is_part = |part: &str| !matches!(part, "" | "." | "..");
    let is_plain = !name.contains(['\0', '\\']) && name.split('/').all(is_part);
    let path = Path::new(name);
    let is_normal = |part: Component<'_>| matches!(part, Component::Normal(_));
    (is_plain && path.components().all(is_normal)).then(|| root.join(path))
}

/// Refuses a folder that is a generated set or lies in one, where files of others would be foreign.
///
/// # Errors
/// [`DatasetError::InsideSet`].
pub fn refuse_inside_set(folder: &Path) -> Result<(), DatasetError> {
    set_around(folder).map_or(Ok(()), |set| {
        Err(DatasetError::InsideSet {
            path: folder.to_owned(),
            set,
        })
    })
}

/// The generated set that a folder is or lies in.
#[must_use]
pub fn set_around(folder: &Path) -> Option<PathBuf> {
    let is_set = |folder: &&Path| SetLayout::new(folder, 1).state("run.json").is_file();
    let set = resolved(folder).ancestors().find(is_set)?.to_owned();
    Some(set)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_one_sample_are_those_of_the_source() {
        let files = SetLayout::new(Path::new("out"), 1).files_of("image_2/000001.png", 0);
        assert_eq!(files.image, "image_2/000001.png");
        assert_eq!(files.region, "starbreak/regions/image_2/000001.png");
        assert_eq!(files.provenance, "starbreak/provenance/image_2/000001.json");
    }

    #[test]
    fn several_samples_have_a_tree_each() {
        let files = SetLayout::new(Path::new("out"), 3).files_of("a.b/c.JPG", 2);
        assert_eq!(files.image, "sample_2/a.b/c.JPG");
        assert_eq!(files.crack, "starbreak/cracks/sample_2/a.b/c.png");
    }

    #[test]
    fn extension_is_that_of_the_last_part() {
        for (name, expected) in [
            ("a.b/c", ("a.b/c", "")),
            ("a/.hidden", ("a/.hidden", "")),
            ("a/x.tar.gz", ("a/x.tar", "gz")),
            ("x.", ("x", "")),
        ] {
            assert_eq!(split_extension(name), expected, "{name}");
        }
    }

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        let root = Path::new("root");
        for name in [
            "../a",
            "a/../../b",
            "/etc/passwd",
            "a//b",
            "",
            "a\\..\\b",
            "a\0b",
            "./a",
        ] {
            assert_eq!(safe_path(root, name), None, "{name:?}");
        }
        assert_eq!(
            safe_path(root, "a b/ü\n.png"),
            Some(root.join("a b/ü\n.png"))
        );
    }
}
