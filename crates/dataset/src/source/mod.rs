//! Datasets on disk, read lazily: which images there are, what is labeled in them, what else is
//! there. Nothing is decoded here and nothing is written.

mod record;
mod spec;

mod name;
mod tree;

mod folder;
mod kitti;

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

pub use record::{BadRecord, FileRole, LabeledObject, ObjectKind, SourceFile, SourceImage};
pub use spec::{SourceFormat, SourceSpec};

use crate::error::DatasetError;
use tree::{Found, Walk};

/// A dataset which is read as it is walked.
///
/// What a format keeps in large index files is read once when the dataset is opened, and no more
/// of it is held than the names and boxes; everything else is read when its turn comes. Files
/// that are added, removed or changed in the meantime are seen or not.
#[derive(Debug)]
pub struct Source {
    format: SourceFormat,
    root: PathBuf,
    layout: Box<dyn Layout>,
}

/// Images or bad records, one after the other.
type Images<'a> = Box<dyn Iterator<Item = Result<SourceImage, BadRecord>> + Send + 'a>;

/// Other files or bad records, one after the other.
type Files<'a> = Box<dyn Iterator<Item = Result<SourceFile, BadRecord>> + Send + 'a>;

/// What a format must know.
trait Layout: fmt::Debug + Send + Sync {
    /// The images, in the order of the bytes of their names, after the bad records of none.
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a>;

    /// Whether a file of this name is an image of the dataset or would be one if it were good.
    fn has_image(&self, name: &str) -> bool;

    /// What a file that is not an image is.
    fn role(&self, name: &str) -> FileRole;

    /// The files of the dataset where it is less than all files below its root.
    fn own_files(&self) -> Option<&[String]> {
        None
    }

    /// An index with the kept images only.
    fn subset(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError>;
}

impl Source {
    /// The dataset at a place, after a look at its layout and its index files.
    ///
    /// # Errors
    ///
    /// [`DatasetError::SourceLayout`] where the folder is not laid out as the format says,
    /// [`DatasetError::SourceIndex`] where an index file is broken as a whole (a single bad record
    /// in it comes out of [`images`](Self::images)), [`DatasetError::Read`] and
    /// [`DatasetError::NotAFile`].
    pub fn open(spec: &SourceSpec) -> Result<Self, DatasetError> {
        let path = spec.path.as_path();
        let (root, layout): (PathBuf, Box<dyn Layout>) = match spec.format {
            SourceFormat::Kitti => (folder_at(spec)?, Box::new(kitti::Kitti::open(spec)?)),
            SourceFormat::Folder => (folder_at(spec)?, Box::new(folder::Folder)),
            SourceFormat::Coco | SourceFormat::Bdd | SourceFormat::Yolo | SourceFormat::List => {
                return Err(layout_error(spec, "this format is not read yet"));
            }
        };
        let _ = path;
        Ok(Self {
            format: spec.format,
            root,
            layout,
        })
    }

    /// The format.
    #[must_use]
    pub fn format(&self) -> SourceFormat {
        self.format
    }

    /// The folder in which all names stand.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The images of the dataset in the order of the bytes of their names, and bad records.
    ///
    /// Every call begins again and gives the same order. A bad record does not end the iteration:
    /// records of no image come first, a bad image stands where the image would. What is wrong
    /// with the labels of an image that is there itself is in [`SourceImage::problems`].
    ///
    /// # Limits
    ///
    /// That a file has the name of an image does not mean that it is one: nothing is decoded. Two
    /// names that a file system takes for one for another reason than case (such as Unicode
    /// composition) are not found.
    #[must_use]
    pub fn images(&self) -> Images<'_> {
        self.layout.images(&self.root)
    }

    /// The files of the dataset which are not images of it, in the order of the bytes of their
    /// names, and bad records.
    ///
    /// Names that begin with a dot are left out. Links to files and folders are followed; a link
    /// back to a folder that holds it, pipes, sockets and devices, names that are not UTF-8 or
    /// differ from another only in case are bad records.
    #[must_use]
    pub fn files(&self) -> Files<'_> {
        if let Some(names) = self.layout.own_files() {
            return Box::new(names.iter().map(|name| {
                Ok(SourceFile {
                    name: name.clone(),
                    path: name::path_below(&self.root, name),
                    role: self.layout.role(name),
                    must_be_rewritten: false,
                })
            }));
        }
        let found = Walk::below(&self.root, "");
        Box::new(found.filter_map(|Found { name, file, .. }| {
            if self.layout.has_image(&name) {
                return None;
            }
            Some(file.map(|path| SourceFile {
                role: self.layout.role(&name),
                must_be_rewritten: false,
                name,
                path,
            }))
        }))
    }

    /// Writes an [index](FileRole::Index) of the dataset for those of its images whose names are
    /// kept.
    ///
    /// What belongs to a kept image is written with the very characters of the source and in its
    /// order, and so is everything that belongs to no image; only the white space between the
    /// records is not kept.
    ///
    /// # Errors
    ///
    /// [`DatasetError::SourceLayout`] where the file is no index, [`DatasetError::SourceIndex`]
    /// where it changed since the dataset was opened, [`DatasetError::SubsetWrite`] where `out`
    /// refuses, [`DatasetError::Read`].
    pub fn subset(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        self.layout.subset(file, is_kept, out)
    }
}

/// The path, which must be a folder.
fn folder_at(spec: &SourceSpec) -> Result<PathBuf, DatasetError> {
    let metadata = std::fs::metadata(&spec.path).map_err(|source| DatasetError::Read {
        path: spec.path.clone(),
        source,
    })?;
    if metadata.is_dir() {
        Ok(spec.path.clone())
    } else {
        Err(layout_error(spec, "it is not a folder"))
    }
}

fn layout_error(spec: &SourceSpec, reason: impl Into<String>) -> DatasetError {
    DatasetError::SourceLayout {
        path: spec.path.clone(),
        format: spec.format,
        reason: reason.into(),
    }
}

/// The answer of formats without an index to a request for a part of one.
fn no_index(file: &SourceFile, format: SourceFormat) -> DatasetError {
    DatasetError::SourceLayout {
        path: file.path.clone(),
        format,
        reason: "it is not an index of images".to_owned(),
    }
}
