//! Datasets on disk, read lazily: which images there are, what is labeled in them, what else is
//! there. Nothing is decoded here and nothing is written.

mod record;
mod spec;

pub(crate) mod name;
mod tree;

mod id;
mod index;
mod index_copy;
mod index_files;
mod lines;
mod nesting;

mod bdd;
mod coco;
mod coco_row;
mod folder;
mod kitti;
mod kitti_row;
mod list;
mod moved;
mod scalabel_moved;
mod scalabel_row;
mod yolo;

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

pub use coco_row::{
    CocoAnnotation, CocoCategory, CocoImage, CocoObject, read_coco_records, sound_bbox,
};
pub use id::WholeId;
pub use index_files::IndexFiles;
pub use kitti_row::KittiRow;
pub use moved::{Motion, PlaceMap};
pub use record::{BadRecord, FileRole, LabeledObject, ObjectKind, SourceFile, SourceImage};
pub use scalabel_row::{
    FrameSize, ScalabelFrame, ScalabelLabel, ScalabelObject, read_scalabel_frames,
};
pub use spec::SourceSpec;

use crate::error::DatasetError;
pub(crate) use crate::formats::SourceFormat;
use crate::ordinary_file::not_a_file;
use moved::MovedFrame;
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

/// The root of a dataset, the names of its index files, and these where they are all of it.
type Place = (PathBuf, Vec<String>, Option<Vec<String>>);

/// Images or bad records, one after the other.
type Images<'a> = Box<dyn Iterator<Item = Result<SourceImage, BadRecord>> + Send + 'a>;

/// Names of images, one after the other.
type Names<'a> = Box<dyn Iterator<Item = String> + Send + 'a>;

/// Other files or bad records, one after the other.
type Files<'a> = Box<dyn Iterator<Item = Result<SourceFile, BadRecord>> + Send + 'a>;

/// What a format must know.
trait Layout: fmt::Debug + Send + Sync {
    /// The images, in the order of the bytes of their names, after the bad records of none.
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a>;

    /// The names of the good images, in the same order. No label needs to be read for them.
    fn names<'a>(&'a self, root: &'a Path) -> Names<'a> {
        let images = self.images(root).filter_map(Result::ok);
        Box::new(images.map(|image| image.name))
    }

    /// Whether a file of this name is an image of the dataset or would be one if it were good.
    fn has_image(&self, name: &str) -> bool;

    /// What a file that is not an image is.
    fn role(&self, root: &Path, name: &str) -> FileRole;

    /// All that lies below the root.
    fn walk(&self, root: &Path) -> Walk {
        Walk::below(root, "")
    }

    /// Whether a folder that cannot be entered, or a bad name, hides images of the dataset.
    fn hides_images(&self, found: &Found) -> bool {
        self.has_image(&found.name)
    }

    /// The names of all classes that there may be, where the dataset has such a list.
    fn categories(&self) -> Vec<String> {
        Vec::new()
    }

    /// Files of the dataset which are not below its root, with their names in it.
    fn outside_files(&self) -> Vec<(String, PathBuf)> {
        Vec::new()
    }

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

    /// Refuses a file with labels of kept images that cannot be moved, as far as it can be said without the images.
    fn check_movable(
        &self,
        _: &SourceFile,
        _: &mut dyn FnMut(&str) -> bool,
    ) -> Result<(), DatasetError> {
        Ok(())
    }

    /// A label file, or an index with the kept images only, with what it labels moved.
    fn moved(
        &self,
        _: &Path,
        (file, _): (&SourceFile, &Motion<'_>),
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        self.subset(file, is_kept, out)
    }

    /// The objects of an image in its moved frame.
    fn moved_objects(
        &self,
        _: &Path,
        image: &SourceImage,
        frame: &MovedFrame,
    ) -> Result<Vec<LabeledObject>, DatasetError> {
        let objects = image.objects.iter();
        Ok(objects.filter_map(|object| frame.object(object)).collect())
    }
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
        let (root, layout): (PathBuf, Box<dyn Layout>) = match spec.format {
            SourceFormat::Kitti => (folder_at(spec)?, Box::new(kitti::Kitti::open(spec)?)),
            SourceFormat::Folder => {
                let follows_links = spec.follows_links;
                (folder_at(spec)?, Box::new(folder::Folder { follows_links }))
            }
            SourceFormat::Coco => {
                let (root, coco) = coco::Coco::open(spec)?;
                (root, Box::new(coco))
            }
            SourceFormat::Bdd => {
                let (root, bdd) = bdd::Bdd::open(spec)?;
                (root, Box::new(bdd))
            }
            SourceFormat::Yolo => {
                let (root, yolo) = yolo::Yolo::open(spec)?;
                (root, Box::new(yolo))
            }
            SourceFormat::List => {
                let (root, list) = list::List::open(spec)?;
                (root, Box::new(list))
            }
        };
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

    /// The names of all classes that there may be, labeled or not, in the order of their numbers:
    /// those of YOLO's `data.yaml`; nothing for other formats.
    #[must_use]
    pub fn categories(&self) -> Vec<String> {
        self.layout.categories()
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

    /// The names of the images that [`images`](Self::images) gives, in the same order, without a
    /// look at their labels and without the bad records.
    #[must_use]
    pub fn names(&self) -> Names<'_> {
        self.layout.names(&self.root)
    }

    /// The files of the dataset which are not images of it, in the order of the bytes of their
    /// names, and bad records.
    ///
    /// All files below the [root](Self::root); where the dataset was given as one index of COCO or
    /// BDD or as a list, that file alone, for then it is the dataset with the images it names.
    /// The `data.yaml` of YOLO comes first where it stands elsewhere.
    ///
    /// Names that begin with a dot are left out. Links to files and folders are followed; a link
    /// back to a folder that holds it, one that leads out of a plain folder unless
    /// [`SourceSpec::follows_links`], pipes, sockets and devices, names that are not UTF-8 or
    /// differ from another only in case are bad records.
    #[must_use]
    pub fn files(&self) -> Files<'_> {
        let file = |name: String, path: PathBuf| SourceFile {
            role: self.layout.role(&self.root, &name),
            name,
            path,
        };
        if let Some(names) = self.layout.own_files() {
            let path_of = |name: &String| name::path_below(&self.root, name);
            return Box::new(
                names
                    .iter()
                    .map(move |name| Ok(file(name.clone(), path_of(name)))),
            );
        }
        let outside = self.layout.outside_files();
        let names: Vec<String> = outside.iter().map(|(name, _)| name.clone()).collect();
        let below = self.layout.walk(&self.root).filter_map(move |found| {
            let is_replaced = names.contains(&found.name);
            if is_replaced || self.layout.hides_images(&found) {
                return None;
            }
            Some(found.file.map(|path| file(found.name, path)))
        });
        let outside = outside
            .into_iter()
            .map(move |(name, path)| Ok(file(name, path)));
        Box::new(outside.chain(below))
    }

    /// Writes an [index](FileRole::Index) of the dataset for those of its images whose names are
    /// kept.
    ///
    /// What belongs to a kept image is written with the very characters of the source and in its
    /// order, and so is everything that belongs to no image; only the white space between the
    /// records is not kept. Two kinds of YOLO files are changed so that a copy of the dataset does
    /// not lead back to the source: in `data.yaml` the key `path` is left out and the paths of
    /// `train`, `val` and `test` become relative to the file; in a list, absolute paths become
    /// relative to the list. In `data.yaml` nothing depends on which images are kept.
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

    /// The labels of an image once what it shows is moved: each box becomes the smallest around what it holds, to a
    /// hundredth of a px, and is cut to the frame; those are left out of which nothing remains there.
    ///
    /// # Errors
    /// As [`crate::readable_size`], and where a label file cannot be read any more.
    pub fn moved_objects(
        &self,
        image: &SourceImage,
        motion: &Motion<'_>,
    ) -> Result<Vec<LabeledObject>, DatasetError> {
        if image.objects.is_empty() {
            return Ok(Vec::new());
        }
        let frame = MovedFrame::of_file(&image.path, motion)?;
        self.layout.moved_objects(&self.root, image, &frame)
    }

    /// Refuses an [index](FileRole::Index) with labels of kept images that [`Source::write_moved`] could not write,
    /// without a look at the images.
    ///
    /// # Errors
    /// [`DatasetError::Unmovable`], [`DatasetError::Read`], [`DatasetError::JsonText`].
    pub fn check_movable(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
    ) -> Result<(), DatasetError> {
        self.layout.check_movable(file, is_kept)
    }

    /// Writes a [label file](FileRole::LabelOf), or an [index](FileRole::Index) for those of the images whose names are
    /// kept, with what is labeled where it is seen once what images show is moved.
    ///
    /// Boxes are moved as [`Source::moved_objects`] says. Outlines get corners where their lines are bent, and are cut to
    /// the frame; of masks each pixel asks what its middle shows; a key point that is not seen any more is one of which
    /// nobody knows where it is (0, 0, 0). The vertices of BDD100K's `poly2d` are moved and not cut. Objects whose box
    /// leaves the frame are left out, and so are labels that could not be read, and in an index images without a header
    /// that says their size. What says no place of the frame stays as it was, and so do 3-D boxes of KITTI, which are
    /// those of the scene; how much of its objects is cut off is raised by what the frame cuts off.
    ///
    /// # Errors
    /// [`DatasetError::Unmovable`] for labels with places that cannot be moved, as in masks of another size than the
    /// image; as [`Source::subset`], and [`crate::readable_size`] for a label file.
    pub fn write_moved(
        &self,
        file: &SourceFile,
        motion: &Motion<'_>,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        self.layout.moved(&self.root, (file, motion), is_kept, out)
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

/// The folder of the dataset that a file belongs to, and the name of the file in it.
///
/// The dataset begins above the nearest of these folders that holds the file, otherwise with the
/// folder of the file.
fn root_and_name(spec: &SourceSpec, folders: &[&str]) -> Result<(PathBuf, String), DatasetError> {
    let parts = |path: &Path| -> Option<String> {
        let parts: Option<Vec<&str>> = path.iter().map(|part| part.to_str()).collect();
        parts.map(|parts| parts.join("/"))
    };
    let is_marked = |folder: &&Path| {
        let name = folder.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| folders.contains(&name))
    };
    let path = spec.path.as_path();
    let marked = path.ancestors().skip(1).take(3).find(is_marked);
    let root = marked.unwrap_or(path).parent().unwrap_or(Path::new(""));
    let name = path.strip_prefix(root).ok().and_then(parts);
    let name = name.ok_or_else(|| layout_error(spec, "its name is not UTF-8; rename it"))?;
    let root = if root.as_os_str().is_empty() {
        Path::new(".")
    } else {
        root
    };
    Ok((root.to_owned(), name))
}

/// The names in a folder which are text and not hidden, in order; none where there is no folder.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    names.sort_unstable();
    names
}

/// That there is an ordinary file, or why not.
fn is_file(path: &Path) -> Result<(), String> {
    match std::fs::metadata(path) {
        Ok(metadata) => match not_a_file(&metadata) {
            None => Ok(()),
            Some(what) => Err(format!("it is {what}, not a file")),
        },
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            Err("there is no such file".to_owned())
        }
        Err(error) => Err(format!("cannot read it: {error}")),
    }
}

fn layout_error(spec: &SourceSpec, reason: impl Into<String>) -> DatasetError {
    DatasetError::SourceLayout {
        path: spec.path.clone(),
        format: spec.format,
        reason: reason.into(),
    }
}

/// The changed copy of a file cannot be written.
fn subset_error(file: &SourceFile, source: std::io::Error) -> DatasetError {
    DatasetError::SubsetWrite {
        name: file.name.clone(),
        source,
    }
}

/// The error of an index that is broken as a whole.
fn index_error(path: &Path, format: SourceFormat, reason: impl Into<String>) -> DatasetError {
    DatasetError::SourceIndex {
        path: path.to_owned(),
        format,
        reason: reason.into(),
    }
}

/// The error of an index that is no longer what it was.
fn changed(path: &Path, format: SourceFormat) -> DatasetError {
    let reason = "it changed since the dataset was opened; begin again";
    index_error(path, format, reason)
}

/// The answer of formats without an index to a request for a part of one.
fn no_index(file: &SourceFile, format: SourceFormat) -> DatasetError {
    DatasetError::SourceLayout {
        path: file.path.clone(),
        format,
        reason: "it is not an index of images".to_owned(),
    }
}
