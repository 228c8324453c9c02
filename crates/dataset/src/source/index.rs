//! What index files say about many images, held in little memory.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::id::Id;
use super::name::{is_image_name, path_below};
use super::record::{BadRecord, FileRole, LabeledObject, ObjectKind, SourceImage};
use super::tree::differs_in_case;
use super::{Images, is_file};

/// The index files of a dataset together.
#[derive(Debug)]
pub(super) struct Catalog {
    files: Vec<IndexFile>,
    /// File and row of each image, in the order of the names.
    order: Vec<(usize, usize)>,
    bad: Vec<BadRecord>,
    /// Names of images whose records are bad.
    refused: BTreeSet<String>,
    /// What a record of a label is called.
    noun: &'static str,
    /// The index files, where they are the whole dataset with their images.
    own_files: Option<Vec<String>>,
}

/// One index file.
#[derive(Debug)]
pub(super) struct IndexFile {
    /// Its name in the dataset.
    pub(super) name: String,
    /// Where it can be read.
    pub(super) path: PathBuf,
    /// Its images, in its order.
    pub(super) rows: Vec<Row>,
    /// Labels in the order of the rows, then of the file.
    pub(super) labels: Vec<Label>,
    /// Names of classes.
    pub(super) categories: Vec<String>,
    /// Rows with what is wrong in their labels, in the order of the rows.
    pub(super) problems: Vec<(usize, BadRecord)>,
    /// Records of no image.
    pub(super) bad: Vec<BadRecord>,
}

/// An image.
#[derive(Debug)]
pub(super) struct Row {
    /// Its name in the dataset.
    pub(super) name: String,
    /// Its number or name in the index.
    pub(super) id: Id,
    /// The end of its labels in the list of all; they begin where those of the row before end.
    pub(super) labels_end: usize,
}

/// A box.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Label {
    pub(super) id: Id,
    /// Index into the categories.
    pub(super) category: usize,
    pub(super) box_px: [f64; 4],
    pub(super) kind: ObjectKind,
}

impl IndexFile {
    /// The index with these labels, each with its row.
    pub(super) fn with_labels(mut self, mut labels: Vec<(usize, Label)>) -> Self {
        // Stable: the order of the file stays within an image.
        labels.sort_by_key(|(row, _)| *row);
        self.problems.sort_by_key(|(row, _)| *row);
        for (row_idx, row) in self.rows.iter_mut().enumerate() {
            row.labels_end = labels.partition_point(|(row, _)| *row <= row_idx);
        }
        self.labels = labels.into_iter().map(|(_, label)| label).collect();
        self
    }

    /// Gives the images their names in the dataset, in place of those in the folder.
    pub(super) fn put_images_into(&mut self, folder: &str) {
        for row in &mut self.rows {
            row.name = in_folder(folder, &row.name);
        }
        for bad in &mut self.bad {
            if let Some(name) = &mut bad.image
                && let Ok(checked) = image_name(name)
            {
                *name = in_folder(folder, &checked);
            }
        }
        for (row_idx, problem) in &mut self.problems {
            problem.image = self.rows.get(*row_idx).map(|row| row.name.clone());
        }
    }

    pub(super) fn labels_of(&self, row_idx: usize) -> &[Label] {
        let end_of = |row: Option<&Row>| row.map_or(0, |row| row.labels_end);
        let begin = end_of(
            row_idx
                .checked_sub(1)
                .and_then(|before| self.rows.get(before)),
        );
        let end = end_of(self.rows.get(row_idx));
        self.labels.get(begin..end).unwrap_or_default()
    }

    /// The numbers of the rows whose images are kept.
    pub(super) fn kept_rows<'a>(
        &'a self,
        is_kept: &'a mut dyn FnMut(&str) -> bool,
    ) -> impl Iterator<Item = usize> + 'a {
        let rows = self.rows.iter().enumerate();
        rows.filter(|(_, row)| is_kept(&row.name)).map(|(k, _)| k)
    }

    fn problems_of(&self, row_idx: usize) -> impl Iterator<Item = &BadRecord> {
        let begin = self.problems.partition_point(|(row, _)| *row < row_idx);
        let of_row = self.problems.get(begin..).unwrap_or_default();
        let of_row = of_row.iter().take_while(move |(row, _)| *row == row_idx);
        of_row.map(|(_, problem)| problem)
    }

    /// Whether both rows have the same labels.
    fn agrees(&self, row_idx: usize, other: &Self, other_row_idx: usize) -> bool {
        let named = |file: &Self, label: &Label| {
            let category = file.categories.get(label.category).cloned();
            let bits = label.box_px.map(f64::to_bits);
            (label.id.clone(), category, bits, label.kind)
        };
        let labels = self.labels_of(row_idx).iter().map(|l| named(self, l));
        let others = other.labels_of(other_row_idx).iter();
        labels.eq(others.map(|l| named(other, l)))
    }
}

impl Catalog {
    /// The images of all files; `noun` is what a record of a label is called.
    pub(super) fn of(
        mut files: Vec<IndexFile>,
        noun: &'static str,
        own_files: Option<Vec<String>>,
    ) -> Self {
        let mut bad: Vec<BadRecord> = Vec::new();
        let mut order: Vec<(usize, usize)> = Vec::new();
        for (file_idx, file) in files.iter_mut().enumerate() {
            bad.append(&mut file.bad);
            order.extend((0..file.rows.len()).map(|row_idx| (file_idx, row_idx)));
        }
        let name_of = |(file, row): (usize, usize)| {
            let rows = files.get(file).map(|file| file.rows.as_slice());
            let row = rows.and_then(|rows| rows.get(row));
            row.map_or("", |row| row.name.as_str())
        };
        // Stable: of one name in two files, that in the first file comes first.
        order.sort_by(|a, b| name_of(*a).cmp(name_of(*b)));

        let mut differing = Vec::new();
        let mut unique: Vec<(usize, usize)> = Vec::with_capacity(order.len());
        for at in order {
            match unique.last().copied() {
                Some(first) if name_of(first) == name_of(at) => {
                    if let (Some(file), Some(other)) = (files.get(first.0), files.get(at.0))
                        && !file.agrees(first.1, other, at.1)
                    {
                        differing.push((first, other.name.clone()));
                    }
                }
                _ => unique.push(at),
            }
        }
        let mut collisions = second_of_case(&unique, name_of);
        unique.retain(|at| match collisions.remove(at) {
            None => true,
            Some(first) => {
                let place = files.get(at.0).map_or("", |file| file.name.as_str());
                let name = name_of(*at);
                let reason = format!("{name:?}: {}", differs_in_case(name_of(first)));
                bad.push(BadRecord::new(place, reason).of_image(name));
                false
            }
        });
        for (at, other) in differing {
            let Some(file) = files.get_mut(at.0) else {
                continue;
            };
            let name = file.rows.get(at.1).map_or("", |row| row.name.as_str());
            let reason = format!(
                "{name:?} has other labels in {:?}; those here are taken",
                other
            );
            let problem = BadRecord::new(&file.name, reason).of_image(name);
            let end = file.problems.partition_point(|(row, _)| *row <= at.1);
            file.problems.insert(end, (at.1, problem));
        }
        let refused = bad.iter().filter_map(|bad| bad.image.clone()).collect();
        Self {
            files,
            order: unique,
            refused,
            bad,
            noun,
            own_files,
        }
    }

    /// The images, after the bad records of none.
    pub(super) fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        let bad = self.bad.iter().cloned().map(Err);
        let images = self.order.iter().filter_map(move |(file_idx, row_idx)| {
            let file = self.files.get(*file_idx)?;
            let row = file.rows.get(*row_idx)?;
            Some(self.image(root, file, *row_idx, row))
        });
        Box::new(bad.chain(images))
    }

    fn image(
        &self,
        root: &Path,
        file: &IndexFile,
        row_idx: usize,
        row: &Row,
    ) -> Result<SourceImage, BadRecord> {
        let path = path_below(root, &row.name);
        is_file(&path).map_err(|reason| {
            let reason = format!("image {:?}: {reason}", row.name);
            BadRecord::new(&file.name, reason).of_image(&row.name)
        })?;
        let objects = file.labels_of(row_idx).iter().map(|label| LabeledObject {
            record: format!("{} {}", self.noun, label.id),
            category: file
                .categories
                .get(label.category)
                .cloned()
                .unwrap_or_default(),
            box_px: label.box_px,
            kind: label.kind,
        });
        Ok(SourceImage {
            objects: objects.collect(),
            problems: file.problems_of(row_idx).cloned().collect(),
            name: row.name.clone(),
            path,
        })
    }

    /// Whether it is one of the images, or one whose record is bad.
    pub(super) fn has_image(&self, name: &str) -> bool {
        let name_of = |at: &(usize, usize)| {
            let row = self.files.get(at.0).and_then(|file| file.rows.get(at.1));
            row.map_or("", |row| row.name.as_str())
        };
        let found = self.order.binary_search_by(|at| name_of(at).cmp(name));
        found.is_ok() || self.refused.contains(name)
    }

    pub(super) fn role(&self, name: &str) -> FileRole {
        match self.file(name) {
            Some(_) => FileRole::Index,
            None => FileRole::Other,
        }
    }

    /// The index file of this name.
    pub(super) fn file(&self, name: &str) -> Option<&IndexFile> {
        self.files.iter().find(|file| file.name == name)
    }

    pub(super) fn own_files(&self) -> Option<&[String]> {
        self.own_files.as_deref()
    }
}

/// Each item whose name differs from that of an item before only in case, with that item.
pub(super) fn second_of_case<'n, T: Copy + Ord>(
    items: &[T],
    name_of: impl Fn(T) -> &'n str,
) -> BTreeMap<T, T> {
    let mut folded: Vec<(String, T)> = items
        .iter()
        .map(|item| (name_of(*item).to_lowercase(), *item))
        .collect();
    // Stable: the first name stays the first.
    folded.sort_by(|a, b| a.0.cmp(&b.0));
    let mut seconds = BTreeMap::new();
    for same in folded.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, first), rest @ ..] = same {
            seconds.extend(rest.iter().map(|(_, second)| (*second, *first)));
        }
    }
    seconds
}

/// The rows whose name a row before has.
pub(super) fn second_names(rows: &[Row]) -> BTreeSet<usize> {
    seconds(rows, |row| &row.name)
}

/// The places of items whose key an item before has.
pub(super) fn seconds<T, K: Ord>(items: &[T], key_of: impl Fn(&T) -> &K) -> BTreeSet<usize> {
    let key_at = |idx: &usize| items.get(*idx).map(&key_of);
    let mut by_key: Vec<usize> = (0..items.len()).collect();
    // Stable: the first item stays the first.
    by_key.sort_by(|a, b| key_at(a).cmp(&key_at(b)));
    by_key
        .chunk_by(|a, b| key_at(a) == key_at(b))
        .flat_map(|same| same.iter().skip(1).copied())
        .collect()
}

/// The first of these folders below the root that holds one of these images.
///
/// `images` gives the names afresh for each call; the first name that is found anywhere decides.
pub(super) fn folder_of_images<'n, N: Iterator<Item = &'n str>>(
    root: &Path,
    folders: &[String],
    images: impl Fn() -> N,
) -> Result<String, String> {
    let mut n_images = 0usize;
    for image in images() {
        n_images += 1;
        for folder in folders {
            if is_file(&path_below(root, &in_folder(folder, image))).is_ok() {
                return Ok(folder.clone());
            }
        }
    }
    if n_images == 0 {
        return Ok(folders.first().cloned().unwrap_or_default());
    }
    let mut reason = format!("none of its {n_images} images is there; looked in ");
    for (idx, folder) in folders.iter().enumerate() {
        let comma = if idx == 0 { "" } else { ", " };
        let folder = if folder.is_empty() { "." } else { folder };
        let _ = write!(reason, "{comma}{folder:?}");
    }
    Err(reason)
}

/// The name below a folder, which may be the root.
pub(super) fn in_folder(folder: &str, name: &str) -> String {
    match folder {
        "" => name.to_owned(),
        _ => format!("{folder}/{name}"),
    }
}

/// The name of an image in an index, if it stays inside and is that of PNG or JPEG.
pub(super) fn image_name(text: &str) -> Result<String, String> {
    let name = super::name::checked(text)?;
    if is_image_name(&name) {
        Ok(name)
    } else {
        Err(format!("{name:?} is neither PNG nor JPEG by its name"))
    }
}

/// Whether corners `x0, y0, x1, y1` are those of a box that does not end before it begins, within a
/// thousand million pixels of 0: areas of wilder ones end in infinity.
pub(super) fn sound_corners(corners_px: [f64; 4]) -> bool {
    let [x0, y0, x1, y1] = corners_px;
    corners_px.iter().all(|v| v.abs() <= 1e9) && x0 <= x1 && y0 <= y1
}
