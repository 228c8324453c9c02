//! KITTI object detection: `image_2/NNNNNN.png`, `label_2/NNNNNN.txt`, `calib`.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::kitti_row::{KittiRow, moved_line};
use super::moved::{Motion, MovedFrame};
use super::name::{is_image_name, path_below, split_extension};
use super::record::{BadRecord, FileRole, LabeledObject, ObjectKind, SourceFile, SourceImage};
use super::tree::{Found, Walk};
use super::{Images, Layout, Names, SourceFormat, SourceSpec, layout_error, no_index};
use crate::error::DatasetError;
use crate::ordinary_file::{check_file_len, read_file};

/// The folders with the frames of one part of the data, in the order of their names.
const PARTS: [&str; 3] = ["", "testing/", "training/"];

/// Left and right camera, in gray and in color.
const CAMERAS: [&str; 4] = ["image_0", "image_1", "image_2", "image_3"];

/// The camera whose image the boxes of `label_2` are drawn in.
const LABELED_CAMERA: &str = "image_2";

#[derive(Debug)]
pub(super) struct Kitti {
    /// The prefixes of [`PARTS`] that are there, each with whether it has labels.
    parts: Vec<(&'static str, bool)>,
    /// Names of the images of the labeled camera by name without extension, and the reverse.
    labeled: BTreeMap<String, String>,
}

impl Kitti {
    pub(super) fn open(spec: &SourceSpec) -> Result<Self, DatasetError> {
        let root = spec.path.as_path();
        let is_there = |name: &str| path_below(root, name).is_dir();
        let parts: Vec<_> = PARTS
            .into_iter()
            .filter(|part| is_there(&format!("{part}{LABELED_CAMERA}")))
            .map(|part| (part, is_there(&format!("{part}label_2"))))
            .collect();
        if parts.is_empty() {
            return Err(layout_error(
                spec,
                "it has neither image_2 nor training/image_2",
            ));
        }
        let mut labeled = BTreeMap::new();
        for (part, _) in &parts {
            let prefix = format!("{part}{LABELED_CAMERA}/");
            for found in Walk::below(&path_below(root, prefix.trim_end_matches('/')), &prefix) {
                if let (true, Err(bad)) = (found.name == prefix, &found.file) {
                    return Err(layout_error(spec, bad.to_string()));
                }
                if let Some((stem, _)) = split_extension(&found.name)
                    && is_frame(&prefix, &found.name)
                    && found.file.is_ok()
                {
                    labeled.entry(stem.to_owned()).or_insert(found.name);
                }
            }
        }
        Ok(Self { parts, labeled })
    }

    /// The part and the camera of an image.
    fn camera_of(&self, name: &str) -> Option<(&'static str, &'static str)> {
        let of_part = |part: &'static str| {
            let is_in = |camera: &&str| is_frame(&format!("{part}{camera}/"), name);
            CAMERAS.into_iter().find(is_in).map(|camera| (part, camera))
        };
        self.parts.iter().find_map(|(part, _)| of_part(part))
    }

    /// An image with its labels.
    fn image(&self, root: &Path, name: String, path: PathBuf) -> SourceImage {
        let mut image = SourceImage {
            name,
            path,
            objects: Vec::new(),
            problems: Vec::new(),
        };
        let Some((part, LABELED_CAMERA)) = self.camera_of(&image.name) else {
            return image;
        };
        if !self.parts.contains(&(part, true)) {
            return image;
        }
        let stem = split_extension(&image.name).map_or(image.name.as_str(), |(stem, _)| stem);
        let frame = stem.rsplit('/').next().unwrap_or(stem);
        let label = format!("{part}label_2/{frame}.txt");
        let owner = self.labeled.get(stem).filter(|owner| **owner != image.name);
        if let Some(owner) = owner {
            let reason = format!("it is the label of {owner:?} as well");
            image
                .problems
                .push(BadRecord::new(&label, reason).of_image(&image.name));
        }
        match read_label(&path_below(root, &label), &label) {
            Ok(text) => {
                // Some editors mark UTF-8 so, and files that were joined have it anywhere.
                let text = text.replace('\u{feff}', "");
                for (line_idx, line) in text.lines().enumerate() {
                    let record = format!("{label}:{}", line_idx + 1);
                    match object_of_line(line, &record) {
                        Ok(object) => image.objects.extend(object),
                        Err(reason) => image
                            .problems
                            .push(BadRecord::new(record, reason).of_image(&image.name)),
                    }
                }
            }
            Err(reason) => image
                .problems
                .push(BadRecord::new(label, reason).of_image(&image.name)),
        }
        image
    }

    /// The image a label belongs to, there or not; nothing for what is not a label.
    fn image_of_label(&self, name: &str) -> Option<String> {
        let (stem, "txt") = split_extension(name)? else {
            return None;
        };
        let (folder, frame) = stem.rsplit_once('/')?;
        let part = folder.strip_suffix("label_2")?;
        self.parts.iter().find(|(known, _)| *known == part)?;
        let image_stem = format!("{part}{LABELED_CAMERA}/{frame}");
        Some(match self.labeled.get(&image_stem) {
            Some(image) => image.clone(),
            None => format!("{image_stem}.png"),
        })
    }

    /// What stands under the name of an image, good or bad.
    fn frames<'a>(&'a self, root: &'a Path) -> impl Iterator<Item = Found> + Send + 'a {
        let below = self.parts.iter().flat_map(move |(part, _)| {
            CAMERAS
                .into_iter()
                .map(move |camera| format!("{part}{camera}"))
                .filter(move |folder| path_below(root, folder).is_dir())
                .flat_map(move |folder| {
                    Walk::below(&path_below(root, &folder), &format!("{folder}/"))
                })
        });
        below.filter(|found| self.camera_of(&found.name).is_some())
    }

    /// Labels without an image.
    fn orphans<'a>(&'a self, root: &'a Path) -> impl Iterator<Item = BadRecord> + Send + 'a {
        let with_labels = self.parts.iter().filter(|(_, has_labels)| *has_labels);
        with_labels
            .flat_map(|(part, _)| {
                let prefix = format!("{part}label_2");
                Walk::below(&path_below(root, &prefix), &format!("{prefix}/"))
            })
            .filter_map(|found| {
                let image = self.image_of_label(&found.name)?;
                let stem = split_extension(&image).map(|(stem, _)| stem)?;
                if self.labeled.contains_key(stem) {
                    return None;
                }
                let reason = format!("there is no image {image:?} for this label");
                Some(BadRecord::new(found.name, reason))
            })
    }
}

/// Whether a name is that of an image in just this folder.
fn is_frame(folder: &str, name: &str) -> bool {
    let file = name.strip_prefix(folder);
    file.is_some_and(|file| !file.contains('/')) && is_image_name(name)
}

impl Layout for Kitti {
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        let images = self
            .frames(root)
            .map(|Found { name, file, .. }| match file {
                Ok(path) => Ok(self.image(root, name, path)),
                Err(bad) => Err(bad.of_image(&name)),
            });
        Box::new(self.orphans(root).map(Err).chain(images))
    }

    fn names<'a>(&'a self, root: &'a Path) -> Names<'a> {
        let good = self.frames(root).filter(|found| found.file.is_ok());
        Box::new(good.map(|found| found.name))
    }

    fn has_image(&self, name: &str) -> bool {
        self.camera_of(name).is_some()
    }

    fn role(&self, _: &Path, name: &str) -> FileRole {
        self.image_of_label(name)
            .map_or(FileRole::Other, FileRole::LabelOf)
    }

    fn subset(
        &self,
        file: &SourceFile,
        _: &mut dyn FnMut(&str) -> bool,
        _: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        Err(no_index(file, SourceFormat::Kitti))
    }

    fn moved(
        &self,
        root: &Path,
        (file, motion): (&SourceFile, &Motion<'_>),
        _: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        let FileRole::LabelOf(image) = &file.role else {
            return Err(no_index(file, SourceFormat::Kitti));
        };
        let frame = MovedFrame::of_file(&path_below(root, image), motion)?;
        let bytes = label_bytes(&file.path, &file.name)?;
        // What is no text is among the problems of the image.
        let text = String::from_utf8(bytes).unwrap_or_default();
        for line in text.replace('\u{feff}', "").split_inclusive('\n') {
            let row = KittiRow::parse(line).ok().flatten();
            let moved = row.and_then(|row| {
                let moved = frame.box_px(row.label_corners_px().ok()?)?;
                Some(moved_line(line, &row, &moved))
            });
            let text = moved.unwrap_or_default();
            out.write_all(text.as_bytes())
                .map_err(|error| super::subset_error(file, error))?;
        }
        Ok(())
    }
}

/// The bytes of a label file.
fn label_bytes(path: &Path, name: &str) -> Result<Vec<u8>, DatasetError> {
    let bytes = read_file(path, name, KittiRow::MAX_FILE_BYTES)?;
    check_file_len(name, bytes.len() as u64, KittiRow::MAX_FILE_BYTES)?;
    Ok(bytes)
}

/// The text of a label file, which may be empty.
fn read_label(path: &Path, name: &str) -> Result<String, String> {
    let bytes = label_bytes(path, name).map_err(|error| match fs::symlink_metadata(path) {
        Err(found) if found.kind() == io::ErrorKind::NotFound => {
            "there is no such file: the image has no label".to_owned()
        }
        // Such as a link that leads nowhere.
        _ => error.to_string(),
    })?;
    String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())
}

/// The object of a line; nothing for an empty line.
fn object_of_line(line: &str, record: &str) -> Result<Option<LabeledObject>, String> {
    let Some(row) = KittiRow::parse(line)? else {
        return Ok(None);
    };
    Ok(Some(LabeledObject {
        record: record.to_owned(),
        box_px: row.label_corners_px()?,
        kind: ObjectKind::of_kitti_type(&row.category),
        category: row.category,
    }))
}
