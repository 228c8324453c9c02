//! BDD100K `det_20`: lists of frames in Scalabel form.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::value::RawValue;

use super::index::{
    Catalog, IndexFile, Label, Row, checked_box, folder_of_images, image_name, second_names,
};
use super::json::{self, Id, Sink, record_reason};
use super::name::path_below;
use super::record::{BadRecord, FileRole, ObjectKind, SourceFile};
use super::{Images, Layout, Place, SourceFormat, SourceSpec, layout_error, no_index};
use crate::error::DatasetError;

/// The two forms of an index: a list of frames, or an object with one.
const LISTS: [&str; 2] = ["", "frames"];

/// Folders below the root that may hold the index files, the likeliest first.
const INDEX_FOLDERS: [&str; 3] = ["labels/det_20", "labels", ""];

/// Older or finer names of classes, and those that evaluation uses [BDD100K, `det.toml`].
const SAME_CLASS: [(&str, &str); 5] = [
    ("bike", "bicycle"),
    ("caravan", "car"),
    ("motor", "motorcycle"),
    ("person", "pedestrian"),
    ("van", "car"),
];

/// Classes that are ignored as a class of evaluation [BDD100K, `det.toml`].
const IGNORED_CLASS: [(&str, &str); 3] = [
    ("other person", "pedestrian"),
    ("other vehicle", "car"),
    ("trailer", "truck"),
];

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

/// A frame with its labels as they are written.
#[derive(Deserialize)]
struct FrameRecord<'a> {
    #[serde(default, borrow)]
    labels: Option<Vec<&'a RawValue>>,
}

/// What is needed to know which image a frame is.
#[derive(Deserialize)]
struct FrameName {
    name: String,
    #[serde(rename = "videoName", default)]
    video: Option<String>,
}

#[derive(Deserialize)]
struct LabelRecord {
    #[serde(default)]
    id: Option<Id>,
    #[serde(default)]
    category: Option<String>,
    #[serde(default)]
    attributes: Option<Attributes>,
    #[serde(default)]
    box2d: Option<Box2d>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Attributes {
    crowd: serde_json::Value,
    ignored: serde_json::Value,
}

#[derive(Deserialize)]
struct Box2d {
    x1: f64,
    y1: f64,
    x2: f64,
    y2: f64,
}

/// The class of evaluation that a name of BDD100K stands for, and whether its objects are ignored.
#[must_use]
pub fn bdd_class(name: &str) -> (&str, bool) {
    let find = |map: &[(&str, &'static str)]| {
        let pair = map.iter().find(|(from, _)| *from == name);
        pair.map(|(_, to)| *to)
    };
    match (find(&IGNORED_CLASS), find(&SAME_CLASS)) {
        (Some(class), _) => (class, true),
        (None, Some(class)) => (class, false),
        (None, None) => (name, false),
    }
}

/// Whether an attribute is set, in the sense of Python, in which the public tools are written.
#[must_use]
pub fn is_set_in_python(value: &serde_json::Value) -> bool {
    use serde_json::Value;
    match value {
        Value::Null => false,
        Value::Bool(value) => *value,
        Value::Number(value) => value.as_f64() != Some(0.0),
        Value::String(value) => !value.is_empty(),
        Value::Array(value) => !value.is_empty(),
        Value::Object(value) => !value.is_empty(),
    }
}

/// Takes the frames of one index file.
#[derive(Default)]
struct Reader {
    name: String,
    n_frames: usize,
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
    fn frame(&mut self, text: &str, frame_idx: usize) {
        let place = |name: &str| format!("{}: frame {name}", self.name);
        let by_number = place(&format!("[{frame_idx}]"));
        let named = match serde_json::from_str::<FrameName>(text) {
            Ok(named) => named,
            Err(error) => {
                self.bad
                    .push(BadRecord::new(by_number, record_reason(&error)));
                return;
            }
        };
        // A video is a folder of frames.
        let checked = image_name(&named.name).and_then(|name| {
            let in_video = named
                .video
                .map(|video| image_name(&format!("{video}/{name}")));
            Ok((name, in_video.transpose()?))
        });
        let (name, in_video) = match checked {
            Ok(names) => names,
            Err(reason) => {
                let bad = BadRecord::new(by_number, reason);
                self.bad.push(bad.of_image(&named.name));
                return;
            }
        };
        let place = place(&name);
        let row_idx = self.rows.len();
        self.rows.push(Row {
            name,
            id: Id::Int(i64::try_from(frame_idx).unwrap_or(i64::MAX)),
            labels_end: 0,
        });
        self.names_in_videos
            .push(in_video.map(String::into_boxed_str));
        let labels = match serde_json::from_str::<FrameRecord<'_>>(text) {
            Ok(record) => record.labels.unwrap_or_default(),
            Err(error) => {
                let problem = BadRecord::new(place, record_reason(&error));
                self.problems.push((row_idx, problem));
                return;
            }
        };
        let mut ids = BTreeSet::new();
        for (label_idx, label) in labels.into_iter().enumerate() {
            let mut label_place = format!("label [{label_idx}]");
            let label = serde_json::from_str::<LabelRecord>(label.get())
                .map_err(|error| record_reason(&error))
                .and_then(|record| {
                    if let Some(id) = &record.id {
                        label_place = format!("label {id}");
                    }
                    self.label(record, label_idx)
                })
                .and_then(|label| match label {
                    Some(label) if !ids.insert(label.id.clone()) => {
                        Err("the id occurs twice in its frame".to_owned())
                    }
                    label => Ok(label),
                });
            match label {
                Ok(label) => self.labels.extend(label.map(|label| (row_idx, label))),
                Err(reason) => {
                    let problem = BadRecord::new(format!("{place}, {label_place}"), reason);
                    self.problems.push((row_idx, problem));
                }
            }
        }
    }

    /// The box of a label; nothing where it has no box, such as the outline of a lane.
    fn label(&mut self, record: LabelRecord, label_idx: usize) -> Result<Option<Label>, String> {
        let Some(Box2d { x1, y1, x2, y2 }) = record.box2d else {
            return Ok(None);
        };
        let box_px = checked_box([x1, y1, x2, y2]).ok_or_else(|| {
            format!(
                "the box2d {:?} px ends before it begins, or reaches beyond 1e9 px",
                [x1, y1, x2, y2]
            )
        })?;
        let category = record.category.ok_or("it has a box but no category")?;
        let attributes = record.attributes.unwrap_or_default();
        let (class, is_ignored) = bdd_class(&category);
        let kind = if is_ignored {
            ObjectKind::Ignored
        } else if is_set_in_python(&attributes.crowd) {
            ObjectKind::Crowd
        } else if is_set_in_python(&attributes.ignored) {
            ObjectKind::Ignored
        } else {
            ObjectKind::Regular
        };
        let category = class.to_owned();
        let next = self.categories.len();
        let number = *self
            .category_numbers
            .entry(category.clone())
            .or_insert(next);
        if number == next {
            self.categories.push(category);
        }
        let by_number = || Id::Text(format!("[{label_idx}]").into_boxed_str());
        Ok(Some(Label {
            id: record.id.unwrap_or_else(by_number),
            category: number,
            box_px,
            kind,
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
                    .map_err(|_| json::index_error(&path, SourceFormat::Bdd, &reason))?
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

impl Sink for Reader {
    fn is_list(&self, key: &str) -> bool {
        LISTS.contains(&key)
    }

    fn record(&mut self, _: &str, text: &str) -> io::Result<()> {
        let frame_idx = self.n_frames;
        self.n_frames += 1;
        self.frame(text, frame_idx);
        Ok(())
    }
}

/// What an index file says, with the names of its images in the dataset.
fn read_index(root: &Path, name: &str) -> Result<IndexFile, DatasetError> {
    let path = path_below(root, name);
    let mut reader = Reader {
        name: name.to_owned(),
        ..Reader::default()
    };
    json::read(&path, SourceFormat::Bdd, &["frames"], &mut reader)?;
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
        let index = self.catalog.file(&file.name);
        let index = index.ok_or_else(|| no_index(file, SourceFormat::Bdd))?;
        // By the number of the frame in the file.
        let mut kept: BTreeMap<&Id, &str> = index
            .rows
            .iter()
            .filter(|row| is_kept(&row.name))
            .map(|row| (&row.id, row.name.as_str()))
            .collect();
        let mut n_frames = 0i64;
        let keeps = |_: &str, text: &str| {
            let frame = Id::Int(n_frames);
            n_frames += 1;
            // A frame that is not the one that was read stays to be missed below.
            let is_same = kept.get(&frame).is_some_and(|name| {
                let record = serde_json::from_str::<FrameName>(text).ok();
                let record = record.and_then(|record| image_name(&record.name).ok());
                record.is_some_and(|record| name.ends_with(&record))
            });
            is_same && kept.remove(&frame).is_some()
        };
        let path = &index.path;
        json::write_copy(path, &file.name, SourceFormat::Bdd, &LISTS, keeps, out)?;
        match kept.is_empty() {
            true => Ok(()),
            false => Err(super::changed(path, SourceFormat::Bdd)),
        }
    }
}
