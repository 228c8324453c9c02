//! KITTI: `label_2/NNNNNN.txt`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use starbreak_dataset::{KittiRow, files_in, read_text};

use super::{Category, LabelSet, Object, ObjectKind, place};
use crate::json_record::{refuse, refuse_file};
use crate::{BoxPx, EvalError};

/// The types of the benchmark; a type that is none of them is a category behind these.
const TYPES: [&str; 9] = [
    "Car",
    "Van",
    "Truck",
    "Pedestrian",
    "Person_sitting",
    "Cyclist",
    "Tram",
    "Misc",
    "DontCare",
];

/// Ground truth of KITTI: what every format has, and what only KITTI has.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct KittiLabels {
    /// Frames in the order of their names, types as categories, objects. `DontCare` areas are
    /// objects of that category and [`ObjectKind::Ignored`].
    pub set: LabelSet,
    /// What else is known, object by object.
    pub facts: Vec<KittiFacts>,
}

/// What only KITTI says of an object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KittiFacts {
    /// The box `x0, y0, x1, y1` in the numbers of the file, px.
    pub corners_px: [f64; 4],
    /// How much of it is outside of the frame, 0 to 1; -1 of `DontCare`.
    pub truncation: f64,
    /// 0 visible, 1 partly hidden, 2 mostly hidden, 3 unknown; -1 of `DontCare`.
    pub occlusion: f64,
}

impl KittiLabels {
    /// The ground truth in a folder with a file `NNNNNN.txt` per frame; the frame's image is called
    /// `image_2/NNNNNN.png` below `prefix`.
    ///
    /// # Errors
    /// [`EvalError::Record`] with file and line for what is no label, [`EvalError::File`] where
    /// there is no file at all, [`EvalError::Dataset`].
    pub fn read(folder: &Path, prefix: &str) -> Result<Self, EvalError> {
        let files = frame_files(folder)?;
        let images = files
            .iter()
            .map(|(frame, _)| format!("{prefix}image_2/{frame}.png"));
        let images: Vec<String> = images.collect();
        let files = files.into_iter().map(|(_, path)| path);
        Self::read_files(images.into_iter().zip(files))
    }

    /// The ground truth in these files, each with the name of its image, in the order of names.
    pub(crate) fn read_files(
        files: impl Iterator<Item = (String, PathBuf)>,
    ) -> Result<Self, EvalError> {
        let mut labels = Self::default();
        for name in TYPES {
            category_of(&mut labels.set, name);
        }
        for (name, path) in files {
            let image = labels.set.add_image(name, None);
            for line in lines(&path)? {
                let Line { row, place } = line?;
                let category = category_of(&mut labels.set, &row.category);
                labels.set.check_categories(&path)?;
                let [truncation, occlusion, ..] = row.numbers;
                let corners_px = row
                    .label_corners_px()
                    .map_err(|reason| refuse(&path, place, reason))?;
                let box_px = BoxPx::from_corners(corners_px);
                let kind = ObjectKind::of_kitti_type(&row.category);
                labels.set.add_object(image, category, box_px, kind);
                labels.facts.push(KittiFacts {
                    corners_px,
                    truncation,
                    occlusion,
                });
            }
        }
        Ok(labels)
    }

    /// The same for protocols that know no `DontCare`: each such area becomes a crowd of every
    /// other category, since a detection inside a crowd counts for nothing, by the share of the
    /// detection that lies in it, just as with KITTI.
    #[must_use]
    pub fn with_areas_as_crowds(&self) -> LabelSet {
        let mut set = LabelSet {
            images: self.set.images.clone(),
            ..LabelSet::default()
        };
        let area = self.category_of_areas();
        let kept = self.set.categories.iter().filter(|c| !is_area(c));
        set.categories = kept.cloned().collect();
        let shifted = |category: u32| match area {
            Some(area) if category > area => category - 1,
            _ => category,
        };
        let n_categories = place(set.categories.len());
        for object in &self.set.objects {
            if Some(object.category) != area {
                let category = shifted(object.category);
                set.objects.push(Object {
                    category,
                    ..object.clone()
                });
                continue;
            }
            set.objects.extend((0..n_categories).map(|category| Object {
                category,
                kind: ObjectKind::Crowd,
                ..object.clone()
            }));
        }
        for (object, id) in set.objects.iter_mut().zip(1..) {
            object.id = id;
        }
        set
    }

    /// For each object of [`with_areas_as_crowds`](Self::with_areas_as_crowds) its place here, `None`
    /// for a crowd.
    pub(crate) fn places_with_areas_as_crowds(&self) -> Vec<Option<usize>> {
        let area = self.category_of_areas();
        let n_categories = self.set.categories.len() - usize::from(area.is_some());
        let objects = self.set.objects.iter().enumerate();
        objects
            .flat_map(|(place, object)| match Some(object.category) == area {
                true => vec![None; n_categories],
                false => vec![Some(place)],
            })
            .collect()
    }

    fn category_of_areas(&self) -> Option<u32> {
        self.set.categories.iter().position(is_area).map(place)
    }
}

/// Whether a category is that of areas in which nothing is labeled.
fn is_area(category: &Category) -> bool {
    ObjectKind::of_kitti_type(&category.name) == ObjectKind::Ignored
}

/// The place of the category of this name, in whatever letters; it is added where it is new.
pub(crate) fn category_of(set: &mut LabelSet, name: &str) -> u32 {
    let known = place_of_type(set, name);
    known.unwrap_or_else(|| set.add_category(name.to_owned()))
}

/// The place of the category of this name, in whatever letters.
pub(crate) fn place_of_type(set: &LabelSet, name: &str) -> Option<u32> {
    let is_it = |category: &Category| category.name.eq_ignore_ascii_case(name);
    set.categories.iter().position(is_it).map(place)
}

/// The files `NAME.txt` in a folder, with `NAME`, in the order of names.
pub(crate) fn frame_files(folder: &Path) -> Result<Vec<(String, PathBuf)>, EvalError> {
    let files = files_in(folder, "txt")?;
    if files.is_empty() {
        return Err(refuse_file(
            folder,
            "it has no files NNNNNN.txt; give the folder that holds one per frame",
        ));
    }
    Ok(files)
}

/// A row of a file.
pub(crate) struct Line {
    pub(crate) row: KittiRow,
    /// Where it stands.
    pub(crate) place: String,
}

/// The rows of a frame's file.
pub(crate) fn lines(
    path: &Path,
) -> Result<impl Iterator<Item = Result<Line, EvalError>> + use<'_>, EvalError> {
    let rows = rows(path)?;
    Ok(rows
        .into_iter()
        .filter_map(move |(place, row)| match KittiRow::parse(&row) {
            Ok(row) => row.map(|row| Ok(Line { row, place })),
            Err(reason) => Some(Err(refuse(path, place, reason))),
        }))
}

/// The lines of a file that are not empty, each with where it stands. An empty file, of a frame or a
/// clip without objects, has none.
pub(crate) fn rows(path: &Path) -> Result<Vec<(String, String)>, EvalError> {
    let text = match read_text(path, KittiRow::MAX_FILE_BYTES) {
        Err(starbreak_dataset::DatasetError::EmptyFile { .. }) => String::new(),
        file => file?.unmarked(),
    };
    let rows = (1..)
        .zip(text.lines())
        .filter(|(_, row)| !row.trim().is_empty());
    Ok(rows
        .map(|(number, row)| (format!("line {number}"), row.to_owned()))
        .collect())
}
