//! YOLO: `data.yaml`, images, and beside `images` the same tree of texts as `labels`.

mod data_file;
mod images;
mod label;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::index::second_of_case;
use super::name::{path_below, split_extension};
use super::record::{BadRecord, FileRole, LabeledObject, ObjectKind, SourceFile, SourceImage};
use super::tree::differs_in_case;
use super::{Images, Layout, Names, SourceFormat, SourceSpec, is_file, layout_error, no_index};
use crate::error::DatasetError;
use crate::image_file::image_size;
use crate::source::lines::{Line, for_each_line};
use crate::source::moved::{Motion, MovedFrame};
use crate::text_file::read_text;
use data_file::DataFile;
use images::{Places, inside, name_of_line};
use label::{label_of_line, moved_line};

/// Longest `data.yaml`, in bytes. FIT
const MAX_DATA_BYTES: u64 = 16 << 20;

/// Extensions that the image of a label is looked for under.
const EXTENSIONS: [&str; 6] = ["jpg", "png", "jpeg", "JPG", "PNG", "JPEG"];

#[derive(Debug)]
pub(super) struct Yolo {
    data_path: PathBuf,
    data: DataFile,
    places: Places,
    /// In the order of the names.
    images: Vec<String>,
    /// The image of each label file.
    images_of_labels: BTreeMap<String, usize>,
    /// Folders of label files, with the folders of their images.
    label_folders: BTreeMap<String, String>,
}

impl Yolo {
    /// The root of the dataset and what `data.yaml` says.
    pub(super) fn open(spec: &SourceSpec) -> Result<(PathBuf, Self), DatasetError> {
        let data_path = data_path(spec)?;
        let broken = |reason: String| DatasetError::SourceIndex {
            path: data_path.clone(),
            format: SourceFormat::Yolo,
            reason,
        };
        let text = read_text(&data_path, MAX_DATA_BYTES)?.text;
        let data = DataFile::parse(text).map_err(broken)?;
        let mut places = Places::of(&data_path, &data).map_err(broken)?;
        let mut images = places.images()?;
        let name_of = |idx: usize| images.get(idx).map_or("", String::as_str);
        let all: Vec<usize> = (0..images.len()).collect();
        let collisions = second_of_case(&all, name_of);
        for (second, first) in &collisions {
            let bad = BadRecord::new(name_of(*second), differs_in_case(name_of(*first)));
            places.bad.push(bad.of_image(name_of(*second)));
        }
        let mut idx = 0;
        images.retain(|_| {
            let is_kept = !collisions.contains_key(&idx);
            idx += 1;
            is_kept
        });
        let mut images_of_labels = BTreeMap::new();
        let mut label_folders = BTreeMap::new();
        for (idx, image) in images.iter().enumerate() {
            let label = label_of_image(image);
            if let (Some((labels, _)), Some((folder, _))) =
                (label.rsplit_once('/'), image.rsplit_once('/'))
                && labels != folder
                && !label_folders.contains_key(labels)
            {
                label_folders.insert(labels.to_owned(), folder.to_owned());
            }
            // The first of two images that share a label owns it; the second says so.
            images_of_labels.entry(label).or_insert(idx);
        }
        let root = places.root.clone();
        let yolo = Self {
            data_path,
            data,
            places,
            images,
            images_of_labels,
            label_folders,
        };
        Ok((root, yolo))
    }

    fn image(&self, root: &Path, name: &str) -> Result<SourceImage, BadRecord> {
        let path = path_below(root, name);
        is_file(&path).map_err(|reason| BadRecord::new(name, reason).of_image(name))?;
        let mut image = SourceImage {
            name: name.to_owned(),
            path,
            objects: Vec::new(),
            problems: Vec::new(),
        };
        let label = label_of_image(name);
        if let Some(LabelOwner::Image(first)) = self.image_of_label(root, &label)
            && first != name
        {
            let problem = BadRecord::new(&label, format!("it is the label of {first:?} as well"));
            image.problems.push(problem.of_image(name));
        }
        // An image without labels has no file of them.
        if fs::symlink_metadata(path_below(root, &label)).is_ok() {
            self.read_labels(root, &label, &mut image);
        }
        Ok(image)
    }

    fn read_labels(&self, root: &Path, label: &str, image: &mut SourceImage) {
        let mut size_px = None;
        let SourceImage {
            name,
            path,
            objects,
            problems,
        } = image;
        let read = for_each_line(&path_below(root, label), |line| {
            let record = format!("{label}:{}", line.number);
            let object = line.text.map_err(str::to_owned).and_then(label_of_line);
            let object = object.and_then(|found| {
                let Some(found) = found else {
                    return Ok(None);
                };
                let category = self.data.names.get(&found.class);
                let category =
                    category.ok_or_else(|| format!("the class {} has no name", found.class))?;
                let (width_px, height_px) = match size_px {
                    Some(size_px) => size_px,
                    None => image_size(path).map_err(|error| error.to_string())?,
                };
                size_px = Some((width_px, height_px));
                let (w, h) = (f64::from(width_px), f64::from(height_px));
                let [x0, y0, x1, y1] = found.shares;
                Ok(Some(LabeledObject {
                    record: record.clone(),
                    category: category.clone(),
                    box_px: [x0 * w, y0 * h, x1 * w, y1 * h],
                    kind: ObjectKind::Regular,
                }))
            });
            match object {
                Ok(object) => objects.extend(object),
                Err(reason) => problems.push(BadRecord::new(record, reason).of_image(name)),
            }
            Ok(())
        });
        if let Err(error) = read {
            problems.push(BadRecord::new(label, error.to_string()).of_image(name));
        }
    }

    /// A line of a label file moved, with its box; none where it is no label or nothing of it is left.
    fn moved_line(&self, line: &Line<'_>, frame: &MovedFrame) -> Option<(String, [f64; 4])> {
        let text = line.text.ok()?;
        let label = label_of_line(text).ok().flatten()?;
        self.data.names.get(&label.class)?;
        moved_line(text, &label, frame)
    }

    /// The image that a label file belongs to, there or not; nothing for other files.
    fn image_of_label(&self, root: &Path, name: &str) -> Option<LabelOwner> {
        if let Some(idx) = self.images_of_labels.get(name) {
            return self.images.get(*idx).cloned().map(LabelOwner::Image);
        }
        let (folder, file) = name.rsplit_once('/')?;
        let (stem, "txt") = split_extension(file)? else {
            return None;
        };
        let images = self.label_folders.get(folder)?;
        // A list of the classes, which a common tool puts there.
        if file == "classes.txt" {
            return None;
        }
        let mut names = EXTENSIONS
            .iter()
            .map(|ext| format!("{images}/{stem}.{ext}"));
        Some(
            match names.any(|name| is_file(&path_below(root, &name)).is_ok()) {
                true => LabelOwner::OtherImage,
                false => LabelOwner::Nobody(format!("{images}/{stem}.jpg")),
            },
        )
    }

    /// Labels without an image.
    fn orphans<'a>(&'a self, root: &'a Path) -> impl Iterator<Item = BadRecord> + Send + 'a {
        let folders: BTreeSet<&String> = self.label_folders.keys().collect();
        folders.into_iter().flat_map(move |folder| {
            let labels = super::names_in(&path_below(root, folder)).into_iter();
            labels.filter_map(move |file| {
                let name = format!("{folder}/{file}");
                let Some(LabelOwner::Nobody(image)) = self.image_of_label(root, &name) else {
                    return None;
                };
                let stem = split_extension(&image).map_or(image.as_str(), |(stem, _)| stem);
                let reason = format!("there is no image \"{stem}.*\" for this label");
                Some(BadRecord::new(name, reason))
            })
        })
    }
}

/// Whose label it is.
enum LabelOwner {
    Image(String),
    /// An image that is there, but in no part of the dataset.
    OtherImage,
    /// The image that is not there.
    Nobody(String),
}

/// `data.yaml` of a folder, or its only YAML file.
fn data_path(spec: &SourceSpec) -> Result<PathBuf, DatasetError> {
    let path = spec.path.as_path();
    let metadata = fs::metadata(path).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })?;
    if !metadata.is_dir() {
        return Ok(path.to_owned());
    }
    let is_yaml = |name: &String| name.ends_with(".yaml") || name.ends_with(".yml");
    let names: Vec<String> = super::names_in(path).into_iter().filter(is_yaml).collect();
    let usual = names
        .iter()
        .find(|name| matches!(name.as_str(), "data.yaml" | "data.yml"));
    match (usual, &names[..]) {
        (Some(name), _) => Ok(path.join(name)),
        (None, [name]) => Ok(path.join(name)),
        (None, []) => Err(layout_error(spec, "there is no data.yaml")),
        (None, names) => Err(layout_error(
            spec,
            format!(
                "there is no data.yaml but {}; name one: yolo:FILE",
                names.join(", ")
            ),
        )),
    }
}

/// The label file of an image: the last folder `images` becomes `labels`, the extension `txt`.
fn label_of_image(image: &str) -> String {
    let (stem, _) = split_extension(image).unwrap_or((image, ""));
    let replaced = match stem.rsplit_once("/images/") {
        Some((before, after)) => Some(format!("{before}/labels/{after}")),
        None => stem
            .strip_prefix("images/")
            .map(|after| format!("labels/{after}")),
    };
    format!("{}.txt", replaced.as_deref().unwrap_or(stem))
}

/// The way from a folder of the dataset to a name in it.
fn relative(folder: &str, name: &str) -> String {
    let mut from: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    let mut to: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    while let (Some(a), Some(b)) = (from.first(), to.first())
        && a == b
    {
        from.remove(0);
        to.remove(0);
    }
    let parts: Vec<&str> = from.iter().map(|_| "..").chain(to).collect();
    match parts.is_empty() {
        true => ".".to_owned(),
        false => parts.join("/"),
    }
}

impl Layout for Yolo {
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        let bad = self.places.bad.iter().cloned().chain(self.orphans(root));
        let images = self.images.iter().map(move |name| self.image(root, name));
        Box::new(bad.map(Err).chain(images))
    }

    fn names<'a>(&'a self, root: &'a Path) -> Names<'a> {
        let is_there = |name: &&String| is_file(&path_below(root, name)).is_ok();
        Box::new(self.images.iter().filter(is_there).cloned())
    }

    fn categories(&self) -> Vec<String> {
        self.data.names.values().cloned().collect()
    }

    fn has_image(&self, name: &str) -> bool {
        let found = self
            .images
            .binary_search_by(|known| known.as_str().cmp(name));
        found.is_ok()
    }

    fn role(&self, root: &Path, name: &str) -> FileRole {
        if self.places.data_name == name || self.places.lists.iter().any(|list| list == name) {
            return FileRole::Index;
        }
        match self.image_of_label(root, name) {
            Some(LabelOwner::Image(image) | LabelOwner::Nobody(image)) => FileRole::LabelOf(image),
            Some(LabelOwner::OtherImage) | None => FileRole::Other,
        }
    }

    fn outside_files(&self) -> Vec<(String, PathBuf)> {
        let name = &self.places.data_name;
        match inside(&self.places.root, &self.data_path) {
            Some(inside) if inside == *name => Vec::new(),
            _ => vec![(name.clone(), self.data_path.clone())],
        }
    }

    fn subset(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        let write_error = |error| super::subset_error(file, error);
        let root = self.places.root.as_path();
        let folder = file.name.rsplit_once('/').map_or("", |(folder, _)| folder);
        if file.name == self.places.data_name {
            let has_base = self.data.base.is_some();
            let text = self.data.rewritten(|path| {
                let name = self.places.names.get(path)?;
                let must_change = has_base || Path::new(path).is_absolute();
                must_change.then(|| relative(folder, name))
            });
            return out.write_all(text.as_bytes()).map_err(write_error);
        }
        if !self.places.lists.contains(&file.name) {
            return Err(no_index(file, SourceFormat::Yolo));
        }
        let mut written = BTreeSet::new();
        for_each_line(&file.path, |line| {
            let text = line.text.map_err(str::to_owned);
            let bytes = match text.and_then(|text| name_of_line(root, &file.name, text)) {
                Ok(None) => line.bytes.to_vec(),
                Ok(Some(name)) if self.has_image(&name) && is_kept(&name) => {
                    let is_absolute = line.text.is_ok_and(|t| Path::new(t.trim()).is_absolute());
                    let way = relative(folder, &name);
                    let end = if line.bytes.ends_with(b"\r\n") {
                        "\r\n"
                    } else {
                        "\n"
                    };
                    // With "./" tools take the folder of the list, without it their own.
                    let dot = if way.starts_with("../") { "" } else { "./" };
                    let bytes = match is_absolute {
                        false => line.bytes.to_vec(),
                        true => format!("{dot}{way}{end}").into_bytes(),
                    };
                    match written.insert(name) {
                        true => bytes,
                        false => Vec::new(),
                    }
                }
                Ok(Some(_)) | Err(_) => Vec::new(),
            };
            out.write_all(&bytes).map_err(write_error)
        })
    }

    fn moved(
        &self,
        root: &Path,
        (file, motion): (&SourceFile, &Motion<'_>),
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        let FileRole::LabelOf(image) = &file.role else {
            return self.subset(file, is_kept, out);
        };
        let frame = MovedFrame::of_file(&path_below(root, image), motion)?;
        for_each_line(&file.path, |line| {
            let Some((text, _)) = self.moved_line(&line, &frame) else {
                return Ok(());
            };
            writeln!(out, "{text}").map_err(|error| super::subset_error(file, error))
        })
    }

    fn moved_objects(
        &self,
        root: &Path,
        image: &SourceImage,
        frame: &MovedFrame,
    ) -> Result<Vec<LabeledObject>, DatasetError> {
        let label = label_of_image(&image.name);
        let mut objects = image.objects.iter().peekable();
        let mut moved = Vec::new();
        // A file that changed in the meantime has fewer.
        for_each_line(&path_below(root, &label), |line| {
            let record = format!("{label}:{}", line.number);
            if let Some(object) = objects.next_if(|object| object.record == record) {
                let box_px = self.moved_line(&line, frame).map(|(_, box_px)| box_px);
                moved.extend(box_px.map(|box_px| LabeledObject {
                    box_px,
                    ..object.clone()
                }));
            }
            Ok(())
        })?;
        Ok(moved)
    }
}
