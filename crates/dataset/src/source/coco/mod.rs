//! MS-COCO: `annotations/instances_*.json`.

mod moved;
mod reader;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::de::IgnoredAny;

use super::coco_row::{CocoImage, read_coco_records};
use super::id::Id;
use super::index::{Catalog, IndexFile, folder_of_images};
use super::index_copy::{as_it_is, write_copy};
use super::moved::{Frames, Motion};
use super::name::path_below;
use super::record::{FileRole, SourceFile};
use super::{Images, Layout, Place, SourceFormat, SourceSpec, index_error, layout_error, no_index};
use crate::error::DatasetError;
use crate::json_records::JsonRecord;
use moved::Annotations;
use reader::{AnnotationOf, Reader};

/// The name of an index that stands beside its images, as some tools export it.
const BESIDE_IMAGES: &str = "_annotations.coco.json";

#[derive(Debug)]
pub(super) struct Coco {
    catalog: Catalog,
}

impl Coco {
    /// The root of the dataset and what its index files say.
    pub(super) fn open(spec: &SourceSpec) -> Result<(PathBuf, Self), DatasetError> {
        let (root, names, own) = place(spec)?;
        let coco = Self::of(&root, &names, own)?;
        Ok((root, coco))
    }

    fn index(&self, file: &SourceFile) -> Result<&IndexFile, DatasetError> {
        let index = self.catalog.file(&file.name);
        index.ok_or_else(|| no_index(file, SourceFormat::Coco))
    }

    fn of(root: &Path, names: &[String], own: Option<Vec<String>>) -> Result<Self, DatasetError> {
        let files = names
            .iter()
            .map(|name| read_index(root, name))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            catalog: Catalog::of(files, "annotation", own),
        })
    }
}

/// The root of the dataset, the names of its index files, and these where they are all of it.
pub(super) fn place(spec: &SourceSpec) -> Result<Place, DatasetError> {
    let path = spec.path.as_path();
    let metadata = fs::metadata(path).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })?;
    if metadata.is_dir() {
        let names = index_names(path);
        if names.is_empty() {
            return Err(layout_error(
                spec,
                format!("it has neither annotations/instances_*.json nor {BESIDE_IMAGES}"),
            ));
        }
        return Ok((path.to_owned(), names, None));
    }
    let (root, name) = super::root_and_name(spec, &["annotations"])?;
    Ok((root, vec![name.clone()], Some(vec![name])))
}

/// The index files in a folder, in the order of their names.
fn index_names(root: &Path) -> Vec<String> {
    let mut names: Vec<String> = super::names_in(&path_below(root, "annotations"))
        .into_iter()
        .filter(|name| name.starts_with("instances_") && name.ends_with(".json"))
        .map(|name| format!("annotations/{name}"))
        .collect();
    let parts = super::names_in(root);
    let beside = parts.iter().map(|part| format!("{part}/{BESIDE_IMAGES}"));
    names.extend(
        beside
            .chain([BESIDE_IMAGES.to_owned()])
            .filter(|name| path_below(root, name).is_file()),
    );
    names.sort_unstable();
    names
}

/// Folders where the images of an index may be, the likeliest first.
pub(super) fn folders_of_images(name: &str) -> Vec<String> {
    let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
    let split = file
        .strip_suffix(".json")
        .and_then(|stem| stem.strip_prefix("instances_"));
    let mut folders = Vec::new();
    if file == BESIDE_IMAGES {
        folders.push(folder.to_owned());
    }
    if let Some(split) = split {
        folders.extend([split.to_owned(), format!("images/{split}")]);
    }
    folders.extend(["images".to_owned(), String::new()]);
    if !folders.iter().any(|known| known == folder) {
        folders.push(folder.to_owned());
    }
    folders
}

/// What an index file says, with the names of its images in the dataset.
fn read_index(root: &Path, name: &str) -> Result<IndexFile, DatasetError> {
    let path = path_below(root, name);
    let mut reader = Reader::of(name);
    read_coco_records(&path, |record| reader.take(&path, &record))?;
    let mut file = reader.finish(path);
    let images = || file.rows.iter().map(|row| row.name.as_str());
    let folder = folder_of_images(root, &folders_of_images(name), images)
        .map_err(|reason| index_error(&file.path, SourceFormat::Coco, reason))?;
    file.put_images_into(&folder);
    Ok(file)
}

impl Layout for Coco {
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        self.catalog.images(root)
    }

    fn has_image(&self, name: &str) -> bool {
        self.catalog.has_image(name)
    }

    fn role(&self, _: &Path, name: &str) -> FileRole {
        self.catalog.role(name)
    }

    fn own_files(&self) -> Option<&[String]> {
        self.catalog.own_files()
    }

    fn subset(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        let index = self.index(file)?;
        let kept = index.kept_rows(is_kept).collect();
        copy(index, &kept, out, &mut |record, is_of_kept| {
            Ok(as_it_is(record, is_of_kept))
        })
    }

    fn check_movable(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
    ) -> Result<(), DatasetError> {
        let index = self.index(file)?;
        let mut annotations = Annotations::of(index, index.kept_rows(is_kept));
        read_coco_records(&index.path, |record| match record.key {
            "annotations" => annotations.check(&record),
            _ => Ok(()),
        })
    }

    fn moved(
        &self,
        root: &Path,
        (file, motion): (&SourceFile, &Motion<'_>),
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        let index = self.index(file)?;
        let mut frames = Frames::of_index(index, root, is_kept, motion);
        let kept: BTreeSet<usize> = (0..index.rows.len())
            .filter(|row| frames.has(*row))
            .collect();
        let mut annotations = Annotations::of(index, kept.iter().copied());
        copy(index, &kept, out, &mut |record, _| {
            annotations.moved(record, &mut frames)
        })
    }
}

/// What is written for a record of an annotation, of which is said whether its image is kept.
type TextOf<'t> =
    dyn for<'r> FnMut(&JsonRecord<'r>, bool) -> Result<Option<Cow<'r, str>>, DatasetError> + 't;

/// Writes an index with these rows alone.
fn copy(
    index: &IndexFile,
    rows: &BTreeSet<usize>,
    out: &mut dyn Write,
    text_of: &mut TextOf<'_>,
) -> Result<(), DatasetError> {
    let kept = index
        .rows
        .iter()
        .enumerate()
        .filter(|(k, _)| rows.contains(k));
    // Kept, and whether the record of the image is still to come.
    let mut kept: BTreeMap<&Id, bool> = kept.map(|(_, row)| (&row.id, true)).collect();
    let lists = ["images", "annotations"];
    write_copy(
        &index.path,
        &index.name,
        &lists,
        |record| match record.key {
            // One without a name is no image: another one may have its number.
            "images" => {
                let image = record.parse::<CocoImage<Id, IgnoredAny>>().ok();
                let is_kept = image
                    .filter(|image| image.file_name.is_some())
                    .and_then(|image| kept.get_mut(&image.id))
                    .is_some_and(std::mem::take);
                Ok(as_it_is(record, is_kept))
            }
            _ => {
                let annotation = record.parse::<AnnotationOf>().ok();
                let id = annotation.and_then(|annotation| annotation.image_id);
                text_of(record, id.is_some_and(|id| kept.contains_key(&id)))
            }
        },
        out,
    )?;
    match kept.values().any(|is_to_come| *is_to_come) {
        false => Ok(()),
        true => Err(super::changed(&index.path, SourceFormat::Coco)),
    }
}
