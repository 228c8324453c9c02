//! BDD100K `det_20`: lists of frames in Scalabel form.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::id::Id;
use super::index::{Catalog, IndexFile, Label, Row, folder_of_images, image_name, second_names};
use super::index_copy::{as_it_is, write_copy};
use super::moved::{Frames, Motion};
use super::name::path_below;
use super::record::{BadRecord, FileRole, SourceFile};
use super::scalabel_moved::{check_labels, moved_labels};
use super::scalabel_row::{ScalabelFrame, ScalabelLabel, read_scalabel_frames};
use super::{Images, Layout, Place, SourceFormat, SourceSpec, index_error, layout_error, no_index};
use crate::error::DatasetError;
use crate::json_records::JsonRecord;

/// Folders below the root that may hold the index files, the likeliest first.
const INDEX_FOLDERS: [&str; 3] = ["labels/det_20", "labels", ""];

#[derive(Debug)]
pub(super) struct Bdd {
    catalog: Catalog,
}

impl Bdd {
    /// The root of the dataset and what its index files say.
    pub(super) fn open(spec: &SourceSpec) -> Result<(PathBuf, Self), DatasetError> {
        let (root, names, own) = place(spec)?;
        let bdd = Self::of(&root, &names, own)?;
        Ok((root, bdd))
    }

    fn index(&self, file: &SourceFile) -> Result<&IndexFile, DatasetError> {
        let index = self.catalog.file(&file.name);
        index.ok_or_else(|| no_index(file, SourceFormat::Bdd))
    }

    fn of(root: &Path, names: &[String], own: Option<Vec<String>>) -> Result<Self, DatasetError> {
        let files = names
            .iter()
            .map(|name| read_index(root, name))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            catalog: Catalog::of(files, "label", own),
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
    if !metadata.is_dir() {
        let (root, name) = super::root_and_name(spec, &["labels"])?;
        return Ok((root, vec![name.clone()], Some(vec![name])));
    }
    let names = INDEX_FOLDERS
        .iter()
        .map(|folder| index_names(path, folder))
        .find(|names| !names.is_empty());
    let names = names.ok_or_else(|| {
        layout_error(
            spec,
            "there is no JSON file in labels/det_20, in labels or beside them",
        )
    })?;
    Ok((path.to_owned(), names, None))
}

/// The JSON files in a folder of the dataset, in the order of their names.
fn index_names(root: &Path, folder: &str) -> Vec<String> {
    super::names_in(&path_below(root, folder))
        .into_iter()
        .filter(|name| name.ends_with(".json"))
        .map(|name| super::index::in_folder(folder, &name))
        .collect()
}

/// Folders where the images of an index may be, the likeliest first.
pub(super) fn folders_of_images(name: &str) -> Vec<String> {
    let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
    let stem = file.strip_suffix(".json").unwrap_or(file);
    let split = stem.rsplit('_').next().unwrap_or(stem);
    let mut folders = Vec::new();
    // The split in the name of the file, or that of the folder as for videos.
    for split in [split, folder.rsplit('/').next().unwrap_or(folder)] {
        for parent in ["images/100k", "images/10k", "images/track", "images"] {
            folders.push(format!("{parent}/{split}"));
        }
        folders.push(split.to_owned());
    }
    folders.extend(["images".to_owned(), String::new(), folder.to_owned()]);
    let mut seen = BTreeSet::new();
    folders.retain(|folder| !folder.ends_with('/') && seen.insert(folder.clone()));
    folders
}

/// Takes the frames of one index file.
#[derive(Default)]
struct Reader {
    name: String,
    rows: Vec<Row>,
    /// The name of each row below the folder of its video.
    names_in_videos: Vec<Option<Box<str>>>,
    category_numbers: BTreeMap<String, usize>,
    categories: Vec<String>,
    labels: Vec<(usize, Label)>,
    problems: Vec<(usize, BadRecord)>,
    bad: Vec<BadRecord>,
}

impl Reader {
    /// Takes a frame; one that is no JSON is an error of the file.
    fn take(&mut self, path: &Path, record: &JsonRecord<'_>) -> Result<(), DatasetError> {
        let frame_idx = record.idx.unwrap_or(0);
        let by_number = format!("{}: frame [{frame_idx}]", self.name);
        let frame: ScalabelFrame<'_> = match record.row(path)? {
            Ok(frame) => frame,
            Err(reason) => {
                self.bad.push(BadRecord::new(by_number, reason));
                return Ok(());
            }
        };
        // A video is a folder of frames.
        let checked = image_name(&frame.name).and_then(|name| {
            let video = frame.video.as_ref();
            let in_video = video.map(|video| image_name(&format!("{video}/{name}")));
            Ok((name, in_video.transpose()?))
        });
        let (name, in_video) = match checked {
            Ok(names) => names,
            Err(reason) => {
                let bad = BadRecord::new(by_number, reason);
                self.bad.push(bad.of_image(&frame.name));
                return Ok(());
            }
        };
        let place = format!("{}: frame {name}", self.name);
        let row_idx = self.rows.len();
        self.rows.push(Row {
            name,
            id: Id::Int(i64::try_from(frame_idx).unwrap_or(i64::MAX)),
            labels_end: 0,
        });
        self.names_in_videos
            .push(in_video.map(String::into_boxed_str));
        self.labels_of(&frame, row_idx, &place);
        Ok(())
    }

    /// Takes the labels of a frame.
    fn labels_of(&mut self, frame: &ScalabelFrame<'_>, row_idx: usize, place: &str) {
        let labels = match frame.labels() {
            Ok(labels) => labels,
            Err(reason) => {
                self.problems.push((row_idx, BadRecord::new(place, reason)));
                return;
            }
        };
        let mut ids = BTreeSet::new();
        for (label_idx, label) in labels.enumerate() {
            let by_number = format!("[{label_idx}]");
            let mut label_place = format!("label {by_number}");
            let label = label.and_then(|label| {
                let id = Option::<Id>::deserialize(&label.id).map_err(|error| error.to_string())?;
                if let Some(id) = &id {
                    label_place = format!("label {id}");
                }
                let id = id.unwrap_or(Id::Text(by_number.into_boxed_str()));
                self.label(&label, id)
            });
            let label = match label {
                Ok(Some(label)) if !ids.insert(label.id.clone()) => {
                    Err("the id occurs twice in its frame".to_owned())
                }
                label => label,
            };
            match label {
                Ok(label) => self.labels.extend(label.map(|label| (row_idx, label))),
                Err(reason) => {
                    let problem = BadRecord::new(format!("{place}, {label_place}"), reason);
                    self.problems.push((row_idx, problem));
                }
            }
        }
    }

    /// The box of a label; nothing where it has no box.
    fn label(&mut self, label: &ScalabelLabel, id: Id) -> Result<Option<Label>, String> {
        let Some(object) = label.object()? else {
            return Ok(None);
        };
        let next = self.categories.len();
        let category = object.class.to_owned();
        let number = *self
            .category_numbers
            .entry(category.clone())
            .or_insert(next);
        if number == next {
            self.categories.push(category);
        }
        Ok(Some(Label {
            id,
            category: number,
            box_px: object.corners_px,
            kind: object.kind,
        }))
    }

    /// Frames which name one image: the second is refused.
    fn refuse_second_names(&mut self) {
        let seconds = second_names(&self.rows);
        if seconds.is_empty() {
            return;
        }
        // The new place of each row.
        let mut places = Vec::with_capacity(self.rows.len());
        let mut kept = Vec::new();
        for (row_idx, row) in std::mem::take(&mut self.rows).into_iter().enumerate() {
            if seconds.contains(&row_idx) {
                let place = format!("{}: frame [{}]", self.name, row.id);
                let reason = format!("the name {:?} occurs twice", row.name);
                self.bad
                    .push(BadRecord::new(place, reason).of_image(&row.name));
                places.push(None);
            } else {
                places.push(Some(kept.len()));
                kept.push(row);
            }
        }
        self.rows = kept;
        let place_of = |row: usize| places.get(row).copied().flatten();
        self.labels = std::mem::take(&mut self.labels)
            .into_iter()
            .filter_map(|(row, label)| Some((place_of(row)?, label)))
            .collect();
        self.problems = std::mem::take(&mut self.problems)
            .into_iter()
            .filter_map(|(row, problem)| Some((place_of(row)?, problem)))
            .collect();
    }

    /// Finds the images and sorts what belongs to each to it.
    fn finish(mut self, root: &Path, path: PathBuf) -> Result<IndexFile, DatasetError> {
        let folders = folders_of_images(&self.name);
        let plain = || self.rows.iter().map(|row| row.name.as_str());
        let folder = match folder_of_images(root, &folders, plain) {
            Ok(folder) => folder,
            Err(reason) => {
                // Frames of videos lie in a folder per video.
                for (row, name) in self.rows.iter_mut().zip(&self.names_in_videos) {
                    if let Some(name) = name {
                        row.name = name.to_string();
                    }
                }
                let in_video = || self.rows.iter().map(|row| row.name.as_str());
                folder_of_images(root, &folders, in_video)
                    .map_err(|_| index_error(&path, SourceFormat::Bdd, reason))?
            }
        };
        self.refuse_second_names();
        let mut file = IndexFile {
            name: self.name,
            path,
            rows: self.rows,
            labels: Vec::new(),
            categories: self.categories,
            problems: self.problems,
            bad: self.bad,
        }
        .with_labels(self.labels);
        file.put_images_into(&folder);
        Ok(file)
    }
}

/// What an index file says, with the names of its images in the dataset.
fn read_index(root: &Path, name: &str) -> Result<IndexFile, DatasetError> {
    let path = path_below(root, name);
    let mut reader = Reader {
        name: name.to_owned(),
        ..Reader::default()
    };
    read_scalabel_frames(&path, |record| reader.take(&path, &record))?;
    reader.finish(root, path)
}

impl Layout for Bdd {
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
        copy(index, index.kept_rows(is_kept), out, &mut |record, _| {
            Ok(as_it_is(record, true))
        })
    }

    fn check_movable(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
    ) -> Result<(), DatasetError> {
        let index = self.index(file)?;
        let kept = index.kept_rows(is_kept);
        copy(index, kept, &mut io::sink(), &mut |record, row| {
            check_labels(record.text, ids_of(index, row)).map_err(unmovable(index, row))?;
            Ok(None)
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
        let kept: Vec<usize> = (0..index.rows.len())
            .filter(|row| frames.has(*row))
            .collect();
        copy(index, kept.into_iter(), out, &mut |record, row| {
            let moved = frames
                .of_row(row)
                .map(|frame| moved_labels(record.text, ids_of(index, row), frame));
            let moved = moved.transpose().map_err(unmovable(index, row))?;
            Ok(moved.map(Cow::Owned))
        })
    }
}

/// The ids of the labels with boxes of a row.
fn ids_of(index: &IndexFile, row: usize) -> BTreeSet<&Id> {
    index.labels_of(row).iter().map(|label| &label.id).collect()
}

fn unmovable(index: &IndexFile, row: usize) -> impl FnOnce((String, String)) -> DatasetError {
    let name = index.rows.get(row).map_or("", |row| row.name.as_str());
    move |(label, what)| DatasetError::Unmovable {
        path: index.path.clone(),
        place: format!("frame {name}, {label}"),
        what,
    }
}

/// What is written for a frame of a row.
type TextOf<'t> =
    dyn for<'r> FnMut(&JsonRecord<'r>, usize) -> Result<Option<Cow<'r, str>>, DatasetError> + 't;

/// Writes an index with these rows alone.
fn copy(
    index: &IndexFile,
    rows: impl Iterator<Item = usize>,
    out: &mut dyn Write,
    text_of: &mut TextOf<'_>,
) -> Result<(), DatasetError> {
    let rows = rows.filter_map(|k| Some((k, index.rows.get(k)?)));
    // By the number of the frame in the file.
    let mut kept: BTreeMap<&Id, (usize, &str)> = rows
        .map(|(k, row)| (&row.id, (k, row.name.as_str())))
        .collect();
    write_copy(
        &index.path,
        &index.name,
        &["frames"],
        |record| {
            let idx = record.idx.and_then(|idx| i64::try_from(idx).ok());
            let id = Id::Int(idx.unwrap_or(i64::MAX));
            // A frame that is not the one that was read stays to be missed below.
            let is_same = kept.get(&id).is_some_and(|(_, name)| {
                let frame = record.parse::<ScalabelFrame<'_>>().ok();
                let in_folder = frame.and_then(|frame| image_name(&frame.name).ok());
                in_folder.is_some_and(|in_folder| name.ends_with(&in_folder))
            });
            match is_same.then(|| kept.remove(&id)).flatten() {
                Some((row, _)) => text_of(record, row),
                None => Ok(None),
            }
        },
        out,
    )?;
    match kept.is_empty() {
        true => Ok(()),
        false => Err(super::changed(&index.path, SourceFormat::Bdd)),
    }
}
