//! Which dataset: the format and the path, as one word of a command line.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::formats::SourceFormat;

impl SourceFormat {
    /// The format whose layout the path has, if it is there and has one.
    fn looks_like(path: &Path) -> Option<Self> {
        let has = |name: &str| path.join(name).exists();
        if path.is_file() {
            return match path.extension()?.to_str()? {
                "json" => Some(Self::Coco),
                "yaml" | "yml" => Some(Self::Yolo),
                "txt" => Some(Self::List),
                _ => None,
            };
        }
        if !path.is_dir() {
            None
        } else if has("image_2") || has("training/image_2") {
            Some(Self::Kitti)
        } else if has("annotations") {
            Some(Self::Coco)
        } else if has("labels/det_20") {
            Some(Self::Bdd)
        } else if has("data.yaml") {
            Some(Self::Yolo)
        } else {
            fs::read_dir(path).ok().map(|_| Self::Folder)
        }
    }
}

/// A dataset on disk: what it is and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceSpec {
    /// Its layout.
    pub format: SourceFormat,
    /// Its folder, or its index file where the format has one.
    pub path: PathBuf,
    /// Whether links below a plain folder may lead out of it; such a link is a bad record else. The
    /// folders and files of other formats may always be links. **Default** no.
    pub follows_links: bool,
}

impl SourceSpec {
    /// The dataset of a format at a path.
    #[must_use]
    pub fn new(format: SourceFormat, path: impl Into<PathBuf>) -> Self {
        Self {
            format,
            path: path.into(),
            follows_links: false,
        }
    }

    /// The same, with links that may lead out of a plain folder or not.
    #[must_use]
    pub fn following_links(mut self, follows_links: bool) -> Self {
        self.follows_links = follows_links;
        self
    }

    /// The dataset that a word like `kitti:DIR` names.
    ///
    /// `kitti:DIR`, `coco:DIR` or `coco:FILE.json`, `bdd:DIR` or `bdd:FILE.json`, `yolo:DIR` or
    /// `yolo:FILE.yaml`, `folder:DIR`, `list:FILE`. Everything after the first colon is the path.
    /// The path is not looked at, unless to guess a format that is missing.
    ///
    /// # Errors
    ///
    /// [`DatasetError::SourceSpec`] where the format is missing or unknown, or the path is empty;
    /// it names the formats, and the one whose layout the path has.
    pub fn parse(text: &OsStr) -> Result<Self, DatasetError> {
        let (prefix, path) = split_at_colon(text);
        let format = prefix.and_then(|prefix| {
            let is_named = |format: &SourceFormat| format.name() == prefix;
            SourceFormat::ALL.into_iter().find(is_named)
        });
        let problem = match (format, path.as_os_str().is_empty()) {
            (Some(format), false) => return Ok(Self::new(format, path)),
            (Some(_), true) => "has no path after the colon",
            (None, _) => "does not begin with the format of a dataset",
        };
        let whole = Path::new(text);
        // The format may be the only wrong part of the word, or missing.
        let guess = SourceFormat::looks_like(whole).map(|format| (format, whole));
        let guess = guess
            .or_else(|| SourceFormat::looks_like(&path).map(|format| (format, path.as_path())));
        Err(DatasetError::SourceSpec {
            text: text.to_string_lossy().into_owned(),
            problem,
            suggestion: guess
                .map(|(format, path)| {
                    format!(
                        "; did you mean {:?}?",
                        format!("{format}:{}", path.display())
                    )
                })
                .unwrap_or_default(),
        })
    }
}

/// What stands before the first colon, if it is text, and the path after it.
#[cfg(unix)]
fn split_at_colon(text: &OsStr) -> (Option<&str>, PathBuf) {
    use std::os::unix::ffi::OsStrExt as _;
    let mut parts = text.as_bytes().splitn(2, |&byte| byte == b':');
    let prefix = parts.next().unwrap_or_default();
    match parts.next() {
        Some(path) => (
            std::str::from_utf8(prefix).ok(),
            PathBuf::from(OsStr::from_bytes(path)),
        ),
        None => (None, PathBuf::new()),
    }
}

#[cfg(not(unix))]
fn split_at_colon(text: &OsStr) -> (Option<&str>, PathBuf) {
    match text.to_str().and_then(|text| text.split_once(':')) {
        Some((prefix, path)) => (Some(prefix), PathBuf::from(path)),
        None => (None, PathBuf::new()),
    }
}
