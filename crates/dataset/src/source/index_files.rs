//! Where the index files of a dataset are, for readers that want more of them than boxes.

use std::path::PathBuf;

use super::index::{folder_of_images, image_name, in_folder};
use super::name::path_below;
use super::{SourceFormat, SourceSpec, bdd, coco, layout_error};
use crate::error::DatasetError;

/// The index files of a dataset of MS-COCO or BDD100K.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IndexFiles {
    /// The folder in which all names stand.
    pub root: PathBuf,
    /// The names of the files, in their order.
    pub names: Vec<String>,
    format: SourceFormat,
}

impl IndexFiles {
    /// Those of a dataset; the same that [`super::Source`] reads.
    ///
    /// # Errors
    /// [`DatasetError::SourceLayout`] where there are none or the format has none,
    /// [`DatasetError::Read`] where there is no such path.
    pub fn of(spec: &SourceSpec) -> Result<Self, DatasetError> {
        let (root, names, _) = match spec.format {
            SourceFormat::Coco => coco::place(spec)?,
            SourceFormat::Bdd => bdd::place(spec)?,
            _ => return Err(layout_error(spec, "its format has no index file")),
        };
        Ok(Self {
            root,
            names,
            format: spec.format,
        })
    }

    /// The path of one of the files.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        path_below(&self.root, name)
    }

    /// The names in the dataset of the images that an index file calls so, in their order: in the
    /// folder where the first of them is that is there at all. Where none is there, the names are
    /// those in the likeliest folder; that of an image that would be outside is kept as it is.
    #[must_use]
    pub fn image_names(&self, index: &str, images: &[&str]) -> Vec<String> {
        let folders = match self.format {
            SourceFormat::Coco => coco::folders_of_images(index),
            _ => bdd::folders_of_images(index),
        };
        let checked = || images.iter().filter_map(|name| image_name(name).ok());
        let names: Vec<String> = checked().collect();
        let found = folder_of_images(&self.root, &folders, || names.iter().map(String::as_str));
        let folder = found.or_else(|_| folders.first().cloned().ok_or(()));
        let folder = folder.unwrap_or_default();
        let in_dataset = |name: &&str| match image_name(name) {
            Ok(name) => in_folder(&folder, &name),
            Err(_) => (*name).to_owned(),
        };
        images.iter().map(in_dataset).collect()
    }
}
