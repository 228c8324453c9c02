//! MS-COCO: `instances_*.json`.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::{JsonRecord, read_json_records};

use super::{Category, LabelSet, LabeledImage, Object, ObjectKind, index_of};
use crate::json_record::{Flag, Id, parse, place, refuse, refuse_file};
use crate::{BoxPx, EvalError};

#[derive(Deserialize)]
struct ImageRecord {
    id: Id,
    #[serde(default)]
    file_name: Option<String>,
    #[serde(default)]
    width: Option<u32>,
    #[serde(default)]
    height: Option<u32>,
}

#[derive(Deserialize)]
struct CategoryRecord {
    id: Id,
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    supercategory: Option<String>,
}

#[derive(Deserialize)]
struct AnnotationRecord {
    id: Id,
    image_id: Id,
    category_id: Id,
    bbox: [f64; 4],
    area: f64,
    #[serde(default)]
    iscrowd: Flag,
}

/// An object whose image and category are still numbers of the file.
struct Row {
    id: i64,
    image_id: i64,
    category_id: i64,
    box_px: BoxPx,
    area_px2: f64,
    kind: ObjectKind,
    /// Its place in its list.
    idx: u64,
}

/// Takes the records of one file or several.
#[derive(Default)]
pub(super) struct Reader {
    images: Vec<LabeledImage>,
    categories: Vec<Category>,
    rows: Vec<Row>,
}

impl Reader {
    /// Reads a file; `names` makes the names of images in the dataset of what the file calls them.
    pub(super) fn read(
        &mut self,
        path: &Path,
        names: impl Fn(&[&str]) -> Vec<String>,
    ) -> Result<(), EvalError> {
        let n_before = self.images.len();
        let lists = read_json_records(path, |record| self.take(path, &record))?;
        for key in ["images", "annotations", "categories"] {
            if !lists.keys.iter().any(|known| known == key) {
                let reason = match lists.is_one_list {
                    true => "it is one list, as results are; ground truth is an object with the lists images, annotations and categories".to_owned(),
                    false => format!("it has no list {key:?}; ground truth of MS-COCO has images, annotations and categories"),
                };
                return Err(refuse_file(path, reason));
            }
        }
        let images = self.images.get_mut(n_before..).unwrap_or(&mut []);
        let said: Vec<&str> = images.iter().map(|image| image.name.as_str()).collect();
        let named = names(&said);
        for (image, name) in images.iter_mut().zip(named) {
            image.name = name;
        }
        Ok(())
    }

    fn take(&mut self, path: &Path, record: &JsonRecord<'_>) -> Result<(), EvalError> {
        match (record.key, record.idx) {
            ("images", Some(_)) => {
                let image: ImageRecord = parse(path, record)?;
                let id = image.id.0;
                self.images.push(LabeledImage {
                    id,
                    name: image.file_name.unwrap_or_else(|| id.to_string()),
                    width_px: image.width,
                    height_px: image.height,
                    cluster: None,
                });
            }
            ("categories", Some(_)) => {
                let category: CategoryRecord = parse(path, record)?;
                let id = category.id.0;
                let category = Category {
                    id,
                    name: category.name.unwrap_or_else(|| id.to_string()),
                    supercategory: category.supercategory,
                };
                // Several files of one dataset repeat their categories.
                if !self.categories.contains(&category) {
                    self.categories.push(category);
                }
            }
            ("annotations", Some(idx)) => {
                let row = row_of(path, record, parse(path, record)?, idx)?;
                self.rows.push(row);
            }
            // What else there is must be JSON, too.
            _ => {
                parse::<serde::de::IgnoredAny>(path, record)?;
            }
        }
        Ok(())
    }

    /// All that was read, in the order of the protocol: images and categories by their numbers,
    /// objects as they stood.
    pub(super) fn finish(mut self, path: &Path) -> Result<LabelSet, EvalError> {
        self.images.sort_by_key(|image| image.id);
        self.categories.sort_by_key(|category| category.id);
        let twice = |what: &str, id: Option<i64>| match id {
            Some(id) => Err(refuse(path, format!("{what} {id}"), "the id occurs twice")),
            None => Ok(()),
        };
        twice("image", second(self.images.iter().map(|image| image.id)))?;
        let categories = self.categories.iter().map(|category| category.id);
        twice("category", second(categories))?;
        tell_apart(&mut self.categories);
        let mut ids: Vec<i64> = self.rows.iter().map(|row| row.id).collect();
        ids.sort_unstable();
        twice("annotation", second(ids.into_iter()))?;

        let mut objects = Vec::with_capacity(self.rows.len());
        for row in self.rows {
            let lost = |what: &str, id: i64| {
                let place = format!("annotations[{}], annotation {}", row.idx, row.id);
                refuse(path, place, format!("its {what} {id} is not in the file"))
            };
            let image = index_of(&self.images, row.image_id, |image| image.id);
            let category = index_of(&self.categories, row.category_id, |category| category.id);
            objects.push(Object {
                id: row.id,
                image: image.ok_or_else(|| lost("image", row.image_id))?,
                category: category.ok_or_else(|| lost("category", row.category_id))?,
                box_px: row.box_px,
                area_px2: row.area_px2,
                kind: row.kind,
            });
        }
        let labels = LabelSet {
            images: self.images,
            categories: self.categories,
            objects,
        };
        labels.within_limits(path)
    }
}

fn row_of(
    path: &Path,
    record: &JsonRecord<'_>,
    annotation: AnnotationRecord,
    idx: u64,
) -> Result<Row, EvalError> {
    let id = annotation.id.0;
    let wrong =
        |reason: String| refuse(path, format!("{}, annotation {id}", place(record)), reason);
    let [x, y, width, height] = annotation.bbox;
    let box_px = BoxPx {
        x,
        y,
        width,
        height,
    };
    if !box_px.is_sound() {
        let reason = format!(
            "the bbox {:?} px has a negative side, or reaches beyond 1e9 px",
            annotation.bbox
        );
        return Err(wrong(reason));
    }
    Ok(Row {
        id,
        image_id: annotation.image_id.0,
        category_id: annotation.category_id.0,
        box_px,
        area_px2: annotation.area,
        kind: match annotation.iscrowd.0 {
            true => ObjectKind::Crowd,
            false => ObjectKind::Regular,
        },
        idx,
    })
}

/// Of several categories of one name all but the first get their number behind it: a name stands for one
/// category in all that is reported.
fn tell_apart(categories: &mut [Category]) {
    let mut known = BTreeSet::new();
    for category in categories {
        while !known.insert(category.name.clone()) {
            category.name = format!("{} (id {})", category.name, category.id);
        }
    }
}

/// The first of these sorted numbers that occurs twice.
fn second(mut ids: impl Iterator<Item = i64>) -> Option<i64> {
    let mut last = ids.next()?;
    ids.find(|id| std::mem::replace(&mut last, *id) == *id)
}

#[cfg(test)]
mod tests {
    use super::{Category, tell_apart};

    #[test]
    fn no_two_categories_share_a_name_whatever_they_are_called() {
        let all = [(1, "car"), (2, "car (id 7)"), (7, "car"), (9, "bus")];
        let mut categories = all.map(|(id, name)| Category {
            id,
            name: name.to_owned(),
            supercategory: None,
        });
        tell_apart(&mut categories);
        let names = categories.map(|category| category.name);
        let expected = ["car", "car (id 7)", "car (id 7) (id 7)", "bus"];
        assert_eq!(names, expected, "each its own");
    }
}
