//! KITTI: `label_2/NNNNNN.txt`.

use std::path::{Path, PathBuf};

use starbreak_dataset::{files_in, read_text};

use super::{Category, LabelSet, LabeledImage, Object, ObjectKind};
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

/// Longest file of a frame, in bytes; real ones have a few kilobytes.
pub(crate) const MAX_FILE_BYTES: u64 = 16 << 20;

/// Ground truth of KITTI: what every format has, and what only KITTI has.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KittiLabels {
    /// Frames in the order of their names, types as categories, objects. `DontCare` areas are
    /// objects of that category and [`ObjectKind::Ignored`].
    pub set: LabelSet,
    /// What else is known, object by object.
    pub facts: Vec<KittiFacts>,
}

/// What only KITTI says of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
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
        for (number, (name, path)) in (1i64..).zip(files) {
            labels.set.images.push(LabeledImage {
                id: number,
                name,
                width_px: None,
                height_px: None,
                cluster: None,
            });
            let image = u32::try_from(number - 1).unwrap_or(u32::MAX);
            for line in lines(&path)? {
                let line = line?;
                let category = category_of(&mut labels.set, &line.name);
                labels.set.check_categories(&path)?;
                let [truncation, occlusion, _, x0, y0, x1, y1, ..] = line.numbers;
                let corners_px = [x0, y0, x1, y1];
                if x1 < x0 || y1 < y0 {
                    let reason = format!("the box {corners_px:?} px ends before it begins");
                    return Err(refuse(&path, line.place, reason));
                }
                let box_px = BoxPx::from_corners(corners_px);
                let is_area = line.name.eq_ignore_ascii_case("DontCare");
                let next = labels.set.objects.len() + 1;
                labels.set.objects.push(Object {
                    id: i64::try_from(next).unwrap_or(i64::MAX),
                    image,
                    category,
                    box_px,
                    area_px2: box_px.area_px2(),
                    kind: match is_area {
                        true => ObjectKind::Ignored,
                        false => ObjectKind::Regular,
                    },
                });
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
        let is_area = |category: &Category| category.name.eq_ignore_ascii_case(AREA);
        let kept = self.set.categories.iter().filter(|c| !is_area(c));
        set.categories = kept.cloned().collect();
        let shifted = |category: u32| match area {
            Some(area) if category > area => category - 1,
            _ => category,
        };
        let n_categories = u32::try_from(set.categories.len()).unwrap_or(u32::MAX);
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
        let is_area = |category: &Category| category.name.eq_ignore_ascii_case(AREA);
        let place = self.set.categories.iter().position(is_area)?;
        u32::try_from(place).ok()
    }
}

/// The type of areas in which nothing is labeled.
const AREA: &str = "DontCare";

/// The place of the category of this name, in whatever letters; it is added where it is new.
fn category_of(set: &mut LabelSet, name: &str) -> u32 {
    let known = place_of_type(set, name);
    known.unwrap_or_else(|| {
        let next = set.categories.len();
        set.categories.push(Category {
            id: i64::try_from(next + 1).unwrap_or(i64::MAX),
            name: name.to_owned(),
            supercategory: None,
        });
        u32::try_from(next).unwrap_or(u32::MAX)
    })
}

/// The place of the category of this name, in whatever letters.
pub(crate) fn place_of_type(set: &LabelSet, name: &str) -> Option<u32> {
    let is_it = |category: &Category| category.name.eq_ignore_ascii_case(name);
    let place = set.categories.iter().position(is_it)?;
    u32::try_from(place).ok()
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

/// A label or a result.
pub(crate) struct Line {
    /// Its type.
    pub(crate) name: String,
    /// The numbers behind it; the last is the score, NaN where there is none.
    pub(crate) numbers: [f64; 15],
    /// Where it stands.
    pub(crate) place: String,
}

/// The lines of a frame's file, of 15 fields, or 16 with a score.
pub(crate) fn lines(
    path: &Path,
) -> Result<impl Iterator<Item = Result<Line, EvalError>> + use<'_>, EvalError> {
    let text = match read_text(path, MAX_FILE_BYTES) {
        // A frame without objects.
        Err(starbreak_dataset::DatasetError::EmptyFile { .. }) => String::new(),
        file => file?.unmarked(),
    };
    let rows: Vec<(usize, String)> = (1..).zip(text.lines().map(str::to_owned)).collect();
    Ok(rows
        .into_iter()
        .filter(|(_, row)| !row.trim().is_empty())
        .map(move |(number, row)| {
            let place = format!("line {number}");
            line(&row, place.clone()).map_err(|reason| refuse(path, place, reason))
        }))
}

fn line(row: &str, place: String) -> Result<Line, String> {
    let fields: Vec<&str> = row.split_ascii_whitespace().collect();
    let Some((name, rest)) = fields
        .split_first()
        .filter(|_| matches!(fields.len(), 15 | 16))
    else {
        let n_fields = fields.len();
        return Err(format!(
            "{n_fields} fields; expected 15, or 16 with a score"
        ));
    };
    let mut numbers = [f64::NAN; 15];
    for ((idx, number), text) in numbers.iter_mut().enumerate().zip(rest) {
        let parsed = text.parse().ok().filter(|value: &f64| value.abs() <= 1e9);
        *number = parsed.ok_or_else(|| {
            format!(
                "field {} = {text:?} is not a finite number within 1e9 of 0",
                idx + 2
            )
        })?;
    }
    Ok(Line {
        name: (*name).to_owned(),
        numbers,
        place,
    })
}
